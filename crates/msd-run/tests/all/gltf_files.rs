//! Scenes in glTF files, read back by the `gltf` crate.

use gltf::animation::Property;
use gltf::material::AlphaMode;
use gltf::mesh::Mode;
use gltf::{Document, Gltf};
use msd_core::glam::{Mat4, Quat, Vec3};
use msd_run::Runner;
use msd_run::export::{Export, Format};
use msd_scene::{SceneFormat, parse};

const SCENE: &str = "version = 1
[world]
gravity = [0, 0, 0]
[[world.planes]]
normal = [0, 1, 0]
offset = -4
[[world.planes]]
normal = [-0.6, 0.8, 0]
offset = -8
[[world.solids]]
kind = 'half_space'
position = [0, 0, -9]
rotation = { axis = [1, 0, 0], angle_deg = 90 }
[[world.solids]]
kind = 'sphere'
radius = 0.5
position = [0, -3, 0]
[[world.solids]]
kind = 'box'
size = [1, 2, 4]
position = [5, 0, 0]
velocity = [2, 0, 0]
spin = [0, 0, 3]
[[bodies]]
kind = 'cloth'
size = [9, 9]
spacing = 0.1
[bodies.look]
colour = '#ff8000'
back = '#000080'
roughness = 0.25
pattern = 'checks'
translucency = 0
[[bodies]]
kind = 'rope'
size = [6]
spacing = 0.2
position = [0, 2, 0]
velocity = [1, 0, 0]
look = { finish = 'metal', colour = '#808080' }
[[bodies]]
kind = 'block'
size = [3, 3, 3]
spacing = 0.2
position = [0, 4, 0]
";

/// The scene over a second, a moment each half, as a document and its numbers.
fn exported() -> (Document, Vec<u8>) {
    let loaded = parse(SCENE, SceneFormat::Toml, "s.toml").expect("a scene");
    let mut runner = Runner::open(&loaded).expect("a run");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.glb");
    let mut export = Export::begin(&path, Format::Glb, &runner).expect("a file");
    for _ in 0..3 {
        export.add(&runner).expect("a moment");
        (0..30).for_each(|_| runner.step().expect("a step"));
    }
    export.finish(&runner).expect("a file");
    // Read with all checks of the crate.
    let Gltf { document, blob } =
        Gltf::from_slice(&std::fs::read(&path).expect("bytes")).expect("a valid file");
    (document, blob.expect("numbers"))
}

fn linear(part: u8) -> f32 {
    ((f32::from(part) / 255.0 + 0.055) / 1.055).powf(2.4)
}

fn node<'d>(document: &'d Document, name: &str) -> gltf::Node<'d> {
    document.nodes().find(|node| node.name() == Some(name)).expect("a node of this name")
}

#[test]
fn bodies_have_the_colours_of_their_looks() {
    let (document, blob) = exported();
    let cloth = node(&document, "cloth").mesh().expect("a mesh");
    let [front, back] = &cloth.primitives().collect::<Vec<_>>()[..] else {
        panic!("a sheet with two colours has two sides")
    };
    let colour = |primitive: &gltf::Primitive<'_>| {
        primitive.material().pbr_metallic_roughness().base_color_factor()
    };
    let near = |colour: [f32; 4], wanted: [f32; 3]| {
        // Colours are given to eight bits, numbers to 24.
        (0..3).all(|part| (colour[part] - wanted[part]).abs() < 1e-6) && colour[3] == 1.0
    };
    assert!(near(colour(front), [1.0, linear(128), 0.0]), "{:?}", colour(front));
    assert!(near(colour(back), [0.0, 0.0, linear(128)]), "{:?}", colour(back));
    let plain = front.material().pbr_metallic_roughness();
    assert_eq!((plain.roughness_factor(), plain.metallic_factor()), (0.25, 0.0));
    assert!(!front.material().double_sided(), "each side has its own colour");
    // The pattern: two shades, each on some of the corners.
    let reader = front.reader(|_| Some(&blob));
    let shades: Vec<[f32; 3]> = reader.read_colors(0).expect("colours").into_rgb_f32().collect();
    assert_eq!(shades.len(), 81);
    let dark = shades.iter().filter(|shade| shade[0] < 1.0).count();
    assert!((16..=65).contains(&dark), "{dark} of 81 corners are dark");
    // The sides are turned to one another.
    let triangles = |primitive: &gltf::Primitive<'_>| {
        let reader = primitive.reader(|_| Some(&blob));
        reader.read_indices().expect("corners").into_u32().collect::<Vec<u32>>()
    };
    let (front, back) = (triangles(front), triangles(back));
    assert_eq!([front[0], front[2], front[1]], [back[0], back[1], back[2]]);
    let rope = node(&document, "rope").mesh().expect("a mesh");
    let metal = rope.primitives().next().expect("a part").material().pbr_metallic_roughness();
    assert_eq!(metal.metallic_factor(), 1.0);
    // The third body has the third colour of the palette.
    let block = node(&document, "block").mesh().expect("a mesh");
    let [red, ..] = colour(&block.primitives().next().expect("a part"));
    assert!((red - 0.891).abs() < 1e-2, "{red}");
}

#[test]
fn a_rope_is_a_tube_that_follows_its_particles() {
    let (document, blob) = exported();
    let rope = node(&document, "rope").mesh().expect("a mesh");
    let part = rope.primitives().next().expect("a part");
    assert_eq!(part.mode(), Mode::Triangles);
    let reader = part.reader(|_| Some(&blob));
    let places: Vec<Vec3> = reader.read_positions().expect("places").map(Vec3::from).collect();
    let normals: Vec<Vec3> = reader.read_normals().expect("normals").map(Vec3::from).collect();
    // Eight corners around each of six particles; all of a ring as far from their middle.
    assert_eq!(places.len(), 48);
    for (ring, normals) in places.chunks(8).zip(normals.chunks(8)) {
        let middle = ring.iter().sum::<Vec3>() / 8.0;
        for (place, normal) in ring.iter().zip(normals) {
            let out = *place - middle;
            assert!((out.length() - 0.03).abs() < 1e-6 && 0.999 < out.normalize().dot(*normal));
        }
    }
    let triangles: Vec<u32> = reader.read_indices().expect("corners").into_u32().collect();
    for corners in triangles.chunks(3) {
        let [a, b, c] = [0, 1, 2].map(|corner| places[corners[corner] as usize]);
        let outward = (b - a).cross(c - a).dot(normals[corners[0] as usize]);
        assert!(0.0 < outward, "triangles face out");
    }
    // It flies along x at 1 m/s, undeformed: the targets of 0.5 s and 1 s.
    for (target, way) in reader.read_morph_targets().zip([0.5, 1.0]) {
        for moved in target.0.expect("ways") {
            assert!((Vec3::from(moved) - Vec3::X * way).length() < 1e-5, "{moved:?}");
        }
    }
}

#[test]
fn solids_are_nodes_and_those_that_move_are_animated() {
    let (document, blob) = exported();
    let ball = node(&document, "solid 1");
    let (place, ..) = ball.transform().decomposed();
    assert_eq!(place, [0.0, -3.0, 0.0]);
    let mesh = ball.mesh().expect("a mesh");
    let part = mesh.primitives().next().expect("a part");
    let reader = part.reader(|_| Some(&blob));
    for place in reader.read_positions().expect("places") {
        assert!((Vec3::from(place).length() - 0.5).abs() < 1e-6);
    }
    let plank = node(&document, "solid 2");
    let animation = document.animations().next().expect("an animation");
    let of =
        |node: usize| animation.channels().filter(move |of| of.target().node().index() == node);
    assert_eq!(of(ball.index()).count(), 0, "it stands still");
    for channel in of(plank.index()) {
        let reader = channel.reader(|_| Some(&blob));
        let times: Vec<f32> = reader.read_inputs().expect("times").collect();
        assert!(times.iter().zip([0.0, 0.5, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{times:?}");
        match (channel.target().property(), reader.read_outputs().expect("values")) {
            (Property::Translation, gltf::animation::util::ReadOutputs::Translations(places)) => {
                for (place, time) in places.zip(&times) {
                    assert!((Vec3::from(place) - Vec3::X * (5.0 + 2.0 * time)).length() < 1e-5);
                }
            }
            (Property::Rotation, gltf::animation::util::ReadOutputs::Rotations(turns)) => {
                for (turn, time) in turns.into_f32().zip(&times) {
                    let wanted = Quat::from_rotation_z(3.0 * time);
                    assert!(0.99999 < Quat::from_array(turn).dot(wanted).abs(), "{turn:?}");
                }
            }
            other => panic!("{:?}", other.0),
        }
    }
    assert_eq!(of(plank.index()).count(), 2);
}

#[test]
fn planes_are_squares_that_face_the_scene_and_hold_all_of_it() {
    let (document, blob) = exported();
    // All that moves in the second: the cloth, the block, and the rope, which flies along x.
    let ends = [Vec3::new(-0.4, -0.4, -0.4), Vec3::new(1.5, 4.4, 0.4)];
    let planes = [
        ("plane 0", Vec3::Y, -4.0),
        ("plane 1", Vec3::new(-0.6, 0.8, 0.0), -8.0),
        ("solid 0", Vec3::Z, -9.0),
    ];
    for (name, normal, offset) in planes {
        let plane = node(&document, name);
        let matrix = Mat4::from_cols_array_2d(&plane.transform().matrix());
        let part = plane.mesh().expect("a mesh").primitives().next().expect("a part");
        let reader = part.reader(|_| Some(&blob));
        let corners: Vec<Vec3> = reader
            .read_positions()
            .expect("places")
            .map(|place| matrix.transform_point3(place.into()))
            .collect();
        for corner in &corners {
            assert!((corner.dot(normal) - offset).abs() < 1e-4, "{name}: {corner}");
        }
        let middle = corners.iter().sum::<Vec3>() / 4.0;
        let half = corners[0].distance(corners[1]) / 2.0;
        for end in ends {
            let below = end - normal * (end.dot(normal) - offset);
            assert!(
                below.distance(middle) < half,
                "{name}: {below} is within {half} m of {middle}"
            );
        }
        assert!(half < 40.0, "{name}: it has an end");
        let triangles: Vec<u32> = reader.read_indices().expect("corners").into_u32().collect();
        for triangle in triangles.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|corner| corners[triangle[corner] as usize]);
            let facing = (b - a).cross(c - a).normalize();
            assert!(0.9999 < facing.dot(normal), "{name}: it faces {facing}");
        }
        let material = part.material();
        assert!(!material.double_sided(), "from behind it would hide the scene");
        let wanted = if name == "plane 0" { "floor" } else { "wall" };
        assert_eq!(material.name(), Some(wanted));
    }
}

#[test]
fn a_translucent_look_is_blended_by_the_share_of_light_that_it_lets_through() {
    let (document, _) = exported();
    let material = |name| {
        let mesh = node(&document, name).mesh().expect("a mesh");
        let part = mesh.primitives().next().expect("a part");
        let colour = part.material().pbr_metallic_roughness().base_color_factor();
        (part.material().alpha_mode(), colour[3])
    };
    // A block is jelly unless its look says otherwise, and jelly lets 0.6 of the light through.
    assert_eq!(material("block"), (AlphaMode::Blend, 1.0 - 0.6));
    assert_eq!(material("cloth"), (AlphaMode::Opaque, 1.0));
    assert_eq!(material("rope"), (AlphaMode::Opaque, 1.0));
    assert_eq!(material("plane 0"), (AlphaMode::Opaque, 1.0));
}
