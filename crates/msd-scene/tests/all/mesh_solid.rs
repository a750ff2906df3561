//! Solids of meshes: distances on a grid, and runs that rest on them and are resumed.

use glam::DVec3;
use msd_core::{
    DistanceGrid, Friction, Integrator, Material, Neighbours, Scene, Settings, Shape, Simulation,
    Solid, shape,
};
use msd_scene::mesh::{Format, Mesh, MeshError, distances, parse as parse_mesh};
use msd_scene::{Loaded, Precision, SceneFormat, parse, read_saved, saved_bytes};
use std::sync::Arc;

fn obj(text: &str) -> Mesh {
    parse_mesh(text.as_bytes(), Format::Obj, "solid.obj").expect("a mesh")
}

const BOX: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\n\
                   v -1 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";

/// A ball of rings of squares, all corners on it.
fn ball(rings: usize) -> Mesh {
    let around = 2 * rings;
    let mut text = String::new();
    for ring in 0..=rings {
        for step in 0..around {
            let [up, turn] = [ring as f64 / rings as f64, 2.0 * step as f64 / around as f64]
                .map(|part| part * std::f64::consts::PI);
            let (x, y, z) = (up.sin() * turn.cos(), up.cos(), up.sin() * turn.sin());
            text += &format!("v {x:.12} {y:.12} {z:.12}\n");
        }
    }
    for ring in 0..rings {
        for step in 0..around {
            let corner = |ring: usize, step: usize| ring * around + step % around + 1;
            let (a, b) = (corner(ring, step), corner(ring, step + 1));
            let (c, d) = (corner(ring + 1, step + 1), corner(ring + 1, step));
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    obj(&text)
}

/// The surface of a smooth mesh is off by a part of the square of the cell. The reported error is
/// that found by points of the true ball.
#[test]
fn the_error_on_a_ball_falls_with_the_square_of_the_cell() {
    let mesh = ball(128);
    let grids = [8.0, 16.0, 32.0].map(|cells| distances(&mesh, 2.0, Some(2.0 / cells)).unwrap());
    let off = |grid: &DistanceGrid| {
        let far = grid.corners.iter().map(|corner| grid.gap(*corner).abs());
        far.fold(0.0, f64::max)
    };
    for [coarse, fine] in [[0, 1], [1, 2]] {
        let ratio = grids[coarse].error / grids[fine].error;
        // 2²; the next order adds a tenth at an eighth of the diameter, and the error of the mesh
        // itself, 1/6500 of the radius, takes as much from the finest.
        assert!((3.2..5.0).contains(&ratio), "{ratio}");
        let ratio = off(&grids[coarse]) / off(&grids[fine]);
        assert!((3.2..5.0).contains(&ratio), "{ratio}");
    }
    for grid in &grids {
        // 1/8 of the second derivatives, two of 1/r, times the square of the cell; and as much of
        // the sides of the mesh, π/128 long.
        let square = grid.cell * grid.cell / (1.0 - grid.cell);
        assert!(grid.error < 0.25 * (square + 6e-4), "{}", grid.error);
        assert!(off(grid) <= grid.error);
        assert!((grid.reach - 1.0).abs() < 1e-9);
    }
}

#[test]
fn distances_of_a_box_are_those_of_the_box() {
    let (cell, size) = (0.125, DVec3::splat(2.0));
    let grid = distances(&obj(BOX), 2.0, Some(cell)).expect("a closed mesh");
    let solid = Shape::Box { size };
    let [nx, ny, _] = grid.counts;
    for (at, &distance) in grid.distances.iter().enumerate() {
        let steps = DVec3::new((at % nx) as f64, (at / nx % ny) as f64, (at / nx / ny) as f64);
        let point = grid.low + cell * steps;
        assert!((distance - solid.gap(point)).abs() < 1e-15, "{point}: {distance}");
    }
    // An edge is cut off where the lines of points that cross it end: beside the middle of a cell.
    assert!(0.1 * cell < grid.error && grid.error < 0.5 * cell, "{}", grid.error);
}

/// Bodies that overlap are one: a point inside of both is inside.
#[test]
fn pieces_that_overlap_are_one_solid() {
    let second = BOX.lines().map(|line| {
        let words: Vec<&str> = line.split(' ').collect();
        if words[0] == "v" {
            let [x, y, z] = [1, 2, 3].map(|word| words[word].parse::<f64>().expect("a number"));
            return format!("v {} {y} {z}", x + 1.2);
        }
        let corners = words[1..].iter().map(|word| word.parse::<usize>().expect("a row") + 8);
        corners.fold("f".to_string(), |line, corner| format!("{line} {corner}"))
    });
    let text = second.fold(BOX.to_string(), |text, line| text + &line + "\n");
    let grid = distances(&obj(&text), 3.2, Some(0.1)).expect("closed");
    for x in [-1.5, -0.4, 0.0, 0.4, 1.5] {
        assert!(grid.gap(DVec3::new(x, 0.03, 0.02)) < 0.0, "{x}");
    }
    assert!(0.0 < grid.gap(DVec3::new(0.0, 1.1, 0.0)));
}

#[test]
fn what_has_no_inside_or_no_grid_is_refused() {
    let refused = |mesh: &Mesh, length: f64, cell: Option<f64>| {
        distances(mesh, length, cell).expect_err("refused").to_string()
    };
    let open = obj(BOX.strip_suffix("f 2 3 7 6\n").expect("a last face"));
    assert_eq!(
        refused(&open, 1.0, None),
        "solid.obj: is not closed, so it has no inside: 4 open edges, 0 edges with more than two \
         faces"
    );
    assert_eq!(
        refused(&obj(BOX), 1.0, Some(1e-3)),
        "solid.obj: the number of points of its grid of distances would be 1015075125; at most \
         4194304 fit"
    );
    assert!(refused(&obj(BOX), 1.0, Some(1e-300)).contains("at most 4194304 fit"));
    assert!(refused(&obj(BOX), 1.0, Some(10.0)).contains("no point of the grid is inside"));
    assert!(refused(&obj(BOX), f64::NAN, None).contains("size of the mesh body is NaN"));
    assert!(refused(&obj(BOX), 1.0, Some(0.0)).contains("cell of the mesh body is 0"));
    let needs = distances(&open, 1.0, None);
    assert!(matches!(needs, Err(MeshError::Open { open: 4, crowded: 0, .. })));
}

/// A block that falls on a solid with a flat top.
fn block_on(shape: Shape) -> Scene {
    let material = Material { mass: 0.1, stiffness: 500.0, damping: 0.5 };
    let mut block = shape::lattice([3, 3, 3], Neighbours::All, 0.2, material).expect("a block");
    for particle in &mut block.particles {
        particle.position += DVec3::new(0.03, 1.25, -0.02);
    }
    let friction = Friction::Coulomb(0.5);
    let solids = vec![Solid { friction, ..Solid::new(shape) }];
    Scene { solids, ..Scene::of("block", block) }
}

#[test]
fn a_block_rests_on_a_mesh_of_a_box_as_on_the_box() {
    let mesh = distances(&obj(BOX), 2.0, Some(0.125)).expect("a closed mesh");
    let shapes = [Shape::Box { size: DVec3::splat(2.0) }, Shape::Mesh(Arc::new(mesh))];
    let scenes = shapes.map(block_on);
    for integrator in Integrator::ALL {
        let settings = Settings { integrator, substeps: 20, ..Settings::default() };
        let [on_box, on_mesh] = scenes.each_ref().map(|scene| {
            let mut run = Simulation::<f64>::new(scene, settings).expect("a valid scene");
            (0..90).for_each(|_| run.step().expect("a calm run"));
            let lowest = run.state().positions.iter().map(|place| place.y).fold(f64::MAX, f64::min);
            assert!((lowest - 1.0).abs() < 1e-6, "{integrator}: it lies at {lowest}");
            run.state()
        });
        for (a, b) in on_box.positions.iter().zip(&on_mesh.positions) {
            // The top is flat: both gaps are the same but for rounding, which explicit Euler
            // amplifies.
            let tolerance = if integrator == Integrator::ExplicitEuler { 1e-6 } else { 1e-9 };
            assert!(a.distance(*b) < tolerance, "{integrator}: {a} and {b}");
        }
    }
}

const FILE: &str = "version = 1\n[solver]\nsubsteps = 20\n[[world.solids]]\nkind = 'mesh'\n\
                    file = 'bunny.obj'\ncell = 0.05\nposition = [0, 0.4, 0]\n\
                    key_frames = [{ time = 0.5, position = [0, 0.6, 0] }, { time = 1, rotation = \
                    { axis = [0, 1, 0], angle_deg = 90 } }]\n[[bodies]]\nkind = 'cloth'\n\
                    size = [9, 9]\nspacing = 0.08\nmass = 0.001\nstiffness = 20\n\
                    damping = 0.01\nposition = [0, 1, 0]\nrotation = { axis = [1, 0, 0], \
                    angle_deg = 90 }\n";

/// A run on a mesh that goes through key frames is saved and resumed with the same bits.
#[test]
fn a_run_on_a_mesh_is_resumed_with_the_same_bits() {
    let loaded = parse(FILE, SceneFormat::Toml, "s.toml").expect("a scene");
    let told = loaded.notes.iter().find(|note| note.contains("its surface is off by at most"));
    let Shape::Mesh(grid) = &loaded.scene.solids[0].shape else { panic!("a mesh") };
    assert!(told.is_some_and(|note| note.starts_with("bunny.obj: a solid by distances at")));
    assert!(0.0 < grid.error && grid.error < grid.cell, "{} of {}", grid.error, grid.cell);
    // It is thicker than a cell, which is less than the spacing.
    let is_thin = |loaded: &Loaded| loaded.notes.iter().any(|note| note.contains("m thick"));
    assert!(!is_thin(&loaded));
    let wide = parse(&FILE.replace("0.08", "0.8"), SceneFormat::Toml, "s.toml");
    assert!(is_thin(&wide.expect("a scene")));
    for integrator in Integrator::ALL {
        // Explicit Euler adds energy to a body that is hardly damped.
        let substeps = if integrator == Integrator::ExplicitEuler { 500 } else { 20 };
        let settings = Settings { integrator, substeps, ..loaded.settings };
        let mut run = Simulation::<f32>::new(&loaded.scene, settings).expect("a valid scene");
        (0..15).for_each(|_| run.step().expect("a calm run"));
        assert!(run.touched(), "{integrator}");
        let (scene, progress) = run.progress();
        let saved = Loaded {
            scene,
            progress: Some(Box::new(progress)),
            precision: Precision::F32,
            ..loaded.clone()
        };
        let read = read_saved(&saved_bytes(&saved).expect("bytes"), "s.msd").expect("a saved run");
        assert_eq!(read.scene.solids, loaded.scene.solids);
        let progress = read.progress.expect("a saved run has one");
        let mut resumed = Simulation::<f32>::resume(&read.scene, &progress).expect("a run");
        (0..10).for_each(|_| (run.step().unwrap(), resumed.step().unwrap()).0);
        assert_eq!(run.state(), resumed.state(), "{integrator}");
    }
}
