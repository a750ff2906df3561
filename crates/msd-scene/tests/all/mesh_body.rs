//! Facts about bodies built from meshes.

use msd_core::glam::{DMat3, DVec3};
use msd_core::{Friction, Part, Plane, Scene, Settings, Simulation};
use msd_scene::mesh::{self, Filling, Format, Mesh, MeshError, MeshOptions};
use std::path::Path;

fn load(name: &str) -> Mesh {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes");
    mesh::read(&folder.join(name)).unwrap()
}

/// The volume that the surface of a part encloses.
fn volume(part: &Part, positions: &[DVec3]) -> f64 {
    let at = |corner: u32| positions[part.surface.corners[corner as usize].particle as usize];
    let tetrahedra = part.surface.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))));
    tetrahedra.sum::<f64>() / 6.0
}

fn positions(part: &Part) -> Vec<DVec3> {
    part.particles.iter().map(|particle| particle.position).collect()
}

fn extent(positions: &[DVec3]) -> DVec3 {
    let low = positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    positions.iter().copied().fold(DVec3::MIN, DVec3::max) - low
}

/// The sets of particles that springs join: the lowest member of each, by particle.
fn sets(part: &Part) -> Vec<usize> {
    let mut sets: Vec<usize> = (0..part.particles.len()).collect();
    loop {
        let before = sets.clone();
        for spring in &part.springs {
            let low = sets[spring.ends[0]].min(sets[spring.ends[1]]);
            spring.ends.into_iter().for_each(|end| sets[end] = low);
        }
        if sets == before {
            return sets;
        }
    }
}

/// Asserts that at least four springs hold every particle, against every direction.
fn assert_held(part: &Part) {
    let mut counts = vec![0; part.particles.len()];
    let mut sums = vec![DMat3::ZERO; part.particles.len()];
    for spring in &part.springs {
        let [a, b] = spring.ends.map(|end| part.particles[end].position);
        let d = (b - a).normalize();
        for end in spring.ends {
            counts[end] += 1;
            sums[end] += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        }
    }
    assert!(counts.iter().all(|&count| 4 <= count));
    // The determinant is the product of the three stiffnesses, in units of one spring; with four
    // springs and a least one of 0.25 it is at least 0.25³.
    assert!(sums.iter().all(|sum| 0.25f64.powi(3) <= sum.determinant()));
}

/// Drops a part from 1 m above the ground and returns where its particles are after each time.
fn drop_on_ground(part: &Part, times: &[f64]) -> Vec<Vec<DVec3>> {
    let lowest = part.particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
    let mut fallen = part.clone();
    fallen.place(DMat3::IDENTITY, DVec3::Y * (1.0 - lowest));
    let mut scene = Scene::default();
    scene.add("part", fallen);
    let friction = Friction::Coulomb(0.5);
    scene.planes.push(Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction });
    let settings = Settings { substeps: 60, ..Settings::default() };
    let mut simulation = Simulation::<f32>::new(&scene, settings).unwrap();
    assert!(settings.substep() < simulation.stable_substep());
    let mut reached = Vec::new();
    for time in times {
        while simulation.time() < *time {
            simulation.step().unwrap();
        }
        reached.push(simulation.positions().map(|x| x.as_dvec3()).collect());
    }
    reached
}

/// Gershgorin's bound of the largest squared frequency, per second squared.
fn largest_w2(part: &Part) -> f64 {
    let mut sums = vec![0.0; part.particles.len()];
    for spring in &part.springs {
        spring
            .ends
            .into_iter()
            .for_each(|end| sums[end] += spring.stiffness / part.particles[end].mass);
    }
    let pairs = part.springs.iter().map(|s| sums[s.ends[0]] + sums[s.ends[1]]);
    pairs.fold(0.0, f64::max)
}

/// Root mean square of the relative change of the distance between pairs of surface particles.
fn distortion(part: &Part, surface: usize, x: &[DVec3]) -> f64 {
    let before = |i: usize| part.particles[i].position;
    let pairs = (0..surface).flat_map(|a| (a + 1..surface).step_by(7).map(move |b| (a, b)));
    let squares = pairs.map(|(a, b)| {
        let rest = before(a).distance(before(b));
        (x[a].distance(x[b]) / rest - 1.0).powi(2)
    });
    let squares: Vec<f64> = squares.collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn the_bunny_is_a_solid_in_one_piece_that_holds_every_particle() {
    let mesh = load("bunny.obj");
    let (part, report) = mesh::body(&mesh, &MeshOptions::default()).unwrap();
    assert!(report.solid && !part.surface.two_sided);
    assert_eq!(report.loose_particles, 0);
    assert_eq!(report.surface_particles, 1839);
    // The volume over the cube of the spacing, less the points too near to the surface.
    let filling = report.volume / report.spacing.powi(3);
    let count = report.interior_particles as f64;
    assert!(0.5 * filling <= count && count <= filling);
    assert_held(&part);
    assert!(sets(&part).iter().all(|&set| set == 0));
    assert_eq!(
        part.springs.len(),
        report.edge_springs + report.lattice_springs + report.brace_springs
    );
}

#[test]
fn the_volume_is_the_sum_of_the_tetrahedra_under_the_surface() {
    let (part, report) = mesh::body(&load("bunny.obj"), &MeshOptions::default()).unwrap();
    // Sums of 3674 terms in two orders: 1e-12 is four thousand roundings.
    let volume = volume(&part, &positions(&part));
    assert!((volume - report.volume).abs() <= 1e-12 * volume);
}

#[test]
fn no_pair_of_particles_is_joined_twice_and_every_spring_is_at_rest() {
    for name in ["bunny.obj", "teapot.obj"] {
        let (part, _) = mesh::body(&load(name), &MeshOptions::default()).unwrap();
        let mut pairs: Vec<_> = part
            .springs
            .iter()
            .map(|s| [s.ends[0].min(s.ends[1]), s.ends[0].max(s.ends[1])])
            .collect();
        pairs.sort_unstable();
        assert!(pairs.windows(2).all(|pair| pair[0] != pair[1]), "{name}");
        for spring in &part.springs {
            let [a, b] = spring.ends.map(|end| part.particles[end].position);
            assert!(0.0 < spring.rest_length && spring.rest_length == a.distance(b));
        }
    }
}

#[test]
fn the_bunny_keeps_its_shape_when_it_falls_one_metre() {
    let (part, report) = mesh::body(&load("bunny.obj"), &MeshOptions::default()).unwrap();
    let before = volume(&part, &positions(&part));
    // In the deepest crash, and settled.
    let bounds = [(0.55, 0.9, 0.15), (1.8, 0.97, 0.06)];
    let reached = drop_on_ground(&part, &bounds.map(|(seconds, ..)| seconds));
    for (x, (seconds, volume_kept, distorted)) in reached.into_iter().zip(bounds) {
        let kept = volume(&part, &x) / before;
        assert!(volume_kept <= kept && kept <= 2.0 - volume_kept, "volume {kept}");
        let distortion = distortion(&part, report.surface_particles, &x);
        assert!(distortion <= distorted, "distortion {distortion} after {seconds} s");
    }
}

#[test]
fn two_bodies_in_one_file_are_not_tied_together() {
    let mut text = String::new();
    for x in [0.0, 1.01] {
        text += &format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nv {x} 0 1\n", x + 1.0);
    }
    text += "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n";
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "two").unwrap();
    let options = MeshOptions { spacing: Some(0.04), ..MeshOptions::default() };
    let (part, report) = mesh::body(&mesh, &options).unwrap();
    assert_held(&part);
    let sets = sets(&part);
    assert_eq!(sets.iter().enumerate().filter(|&(i, &set)| i == set).count(), 2);
    assert_eq!(report.loose_particles, 0);
}

/// Boxes, each with eight vertices of its own, as an OBJ file.
fn boxes(lows: &[[f64; 3]]) -> String {
    let mut text = String::new();
    for (number, [x, y, z]) in lows.iter().enumerate() {
        text += &format!("o box{number}\n");
        for corner in 0..8 {
            let [a, b, c] = [corner & 1, corner >> 1 & 1, corner >> 2].map(f64::from);
            text += &format!("v {} {} {}\n", x + a, y + b, z + c);
        }
        let first = 8 * number + 1;
        for quad in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            let [a, b, c, d] = quad.map(|corner| corner + first);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

#[test]
fn closed_parts_that_touch_are_solids_of_their_own_and_counted() {
    // On a face, on an edge, on a corner; in a row of three; and apart.
    let cases: [(&[[f64; 3]], usize); 5] = [
        (&[[0.0; 3], [0.0, 1.0, 0.0]], 2),
        (&[[0.0; 3], [1.0, 1.0, 0.0]], 2),
        (&[[0.0; 3], [1.0, 1.0, 1.0]], 2),
        (&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], 3),
        (&[[0.0; 3], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]], 2),
    ];
    for (lows, touching) in cases {
        let named = boxes(lows);
        // Objects by name, and one list of faces.
        for text in [named.clone(), named.replace("o box", "# ")] {
            let mesh = mesh::parse(text.as_bytes(), Format::Obj, "boxes").unwrap();
            assert!(mesh.is_closed(), "{lows:?}: {}", mesh.report);
            assert_eq!((mesh.report.touching, mesh.positions.len()), (touching, 8 * lows.len()));
            assert!(mesh.report.to_string().contains("closed parts touch another one"));
            let options = MeshOptions { size: None, ..MeshOptions::default() };
            let (part, report) = mesh::body(&mesh, &options).unwrap();
            assert!(report.solid && (report.volume - lows.len() as f64).abs() < 1e-12);
            let sets = sets(&part);
            let count = sets.iter().enumerate().filter(|&(i, &set)| i == set).count();
            assert_eq!(count, lows.len(), "{lows:?}");
        }
    }
}

#[test]
fn a_closed_part_that_is_there_twice_is_read_once() {
    let once = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    // In other places of the file, in another order, and turned the other way.
    let again = "o copy\nf 8 7 6\nf 5 6 7\nf 5 8 6\nf 5 7 8\n";
    let text = format!("{once}o first\n{faces}{once}{again}");
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "a.obj").expect("a mesh");
    let report = mesh.report;
    assert_eq!((report.triangles, report.duplicate, report.touching), (4, 4, 0), "{report}");
    assert!(mesh.is_closed(), "{report}");
}

#[test]
fn closed_parts_that_overlap_are_counted() {
    let overlapping = |text: &str| {
        let report = mesh::parse(text.as_bytes(), Format::Obj, "a.obj").expect("parts").report;
        let says = report.to_string().contains("closed parts overlap another one; what they");
        assert_eq!(says, 0 < report.overlapping);
        report.overlapping
    };
    // Two of three go through each other; one lies on a face of the other; and apart.
    assert_eq!(overlapping(&boxes(&[[0.0; 3], [0.5, 0.4, 0.3], [5.0, 0.0, 0.0]])), 2);
    assert_eq!(overlapping(&boxes(&[[0.0; 3], [1.0, 0.25, 0.25]])), 0);
    assert_eq!(overlapping(&boxes(&[[0.0; 3], [2.0, 0.0, 0.0]])), 0);
    // A tetrahedron inside another one is one more, or a void if it is turned the other way.
    let outer = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let inner = "v .1 .1 .1\nv .3 .1 .1\nv .1 .3 .1\nv .1 .1 .3\n";
    let (more, void) =
        ("f 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n", "f 7 5 6\nf 6 5 8\nf 8 5 7\nf 7 6 8\n");
    assert_eq!([more, void].map(|faces| overlapping(&format!("{outer}{inner}{faces}"))), [2, 0]);
}

#[test]
fn vertices_that_touching_parts_share_in_the_file_become_those_of_each() {
    // Two boxes that share the four vertices of the face between them.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                v 0 0 2\nv 1 0 2\nv 0 1 2\nv 1 1 2\n";
    let faces = |[a, b, c, d, e, f, g, h]: [usize; 8]| {
        format!(
            "f {a} {c} {d} {b}\nf {e} {f} {h} {g}\nf {a} {b} {f} {e}\n\
             f {c} {g} {h} {d}\nf {a} {e} {g} {c}\nf {b} {d} {h} {f}\n"
        )
    };
    let text =
        text.to_owned() + &faces([1, 2, 3, 4, 5, 6, 7, 8]) + &faces([5, 6, 7, 8, 9, 10, 11, 12]);
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "boxes").unwrap();
    assert!(mesh.is_closed() && mesh.report.touching == 2, "{}", mesh.report);
    assert_eq!((mesh.positions.len(), mesh.report.welded, mesh.report.unused), (16, 0, 0));
}

#[test]
fn an_open_sheet_stays_welded_to_the_box_that_it_is_on() {
    let text = boxes(&[[0.0; 3]]) + "o ribbon\nv 0 1 0\nv 1 1 0\nv 0.5 2 0\nf 9 11 10\n";
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "box").unwrap();
    assert_eq!((mesh.positions.len(), mesh.report.touching), (9, 0));
}

#[test]
fn the_teapot_is_a_shell_whose_spout_and_handle_stay_on() {
    let mesh = load("teapot.obj");
    let (part, report) = mesh::body(&mesh, &MeshOptions::default()).unwrap();
    assert!(!report.solid && part.surface.two_sided);
    assert_eq!(report.interior_particles, 0);
    assert_eq!(report.volume, 0.0);
    // Each edge with two faces bends.
    assert_eq!(report.bending_springs, 1456);
    assert_eq!(mesh.report.components, 3);
    assert!(sets(&part).iter().all(|&set| set == 0));
}

fn solid(mesh: &Mesh) -> Result<(Part, mesh::BodyReport), MeshError> {
    let filling = Filling::Solid;
    mesh::body(mesh, &MeshOptions { filling, ..MeshOptions::for_mesh(mesh, filling) })
}

/// The bunny with the faces around some of its vertices torn out, far from each other.
fn torn_bunny() -> Mesh {
    let mesh = load("bunny.obj");
    let mut text = String::new();
    for DVec3 { x, y, z } in &mesh.positions {
        text += &format!("v {x} {y} {z}\n");
    }
    let torn = [100, 400, 700, 1000];
    for corners in mesh.triangles.iter().filter(|corners| !corners.iter().any(|v| torn.contains(v)))
    {
        let [a, b, c] = corners.map(|corner| corner + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    mesh::parse(text.as_bytes(), Format::Obj, "torn.obj").unwrap()
}

#[test]
fn a_torn_scan_can_be_made_a_solid_and_says_how_many_holes_it_took_for_closed() {
    let (_, whole) = solid(&load("bunny.obj")).unwrap();
    let torn = torn_bunny();
    assert!(!torn.is_closed());
    let (part, report) = solid(&torn).unwrap();
    assert_eq!((whole.holes, report.holes), (0, 4));
    assert!(report.to_string().starts_with("solid, 4 holes taken for closed: "), "{report}");
    assert_held(&part);
    // A hole takes the faces around one vertex of more than a thousand. The fan over it cuts off
    // or adds a cone that is less high than an edge is long.
    let unlike = (report.volume / whole.volume - 1.0).abs();
    assert!(0.0 < unlike && unlike < 4e-3, "{unlike}");
    // The surface of the winding number 1/2 bulges through a hole by less than it is wide.
    let points = |report: &mesh::BodyReport| report.interior_particles as f64;
    assert!((points(&report) / points(&whole) - 1.0).abs() < 1e-2);
    // Left to itself it is a shell.
    let (_, shell) = mesh::body(&torn, &MeshOptions::for_mesh(&torn, Filling::Auto)).unwrap();
    assert!(!shell.solid);
}

#[test]
fn the_teapot_can_be_made_a_solid_with_the_stiffness_of_one() {
    let mesh = load("teapot.obj");
    let (part, report) = solid(&mesh).unwrap();
    assert!(report.solid && 0 < report.interior_particles && 0 < report.holes, "{report}");
    assert_held(&part);
    let closed = MeshOptions::for_mesh(&load("bunny.obj"), Filling::Auto);
    assert_eq!(MeshOptions::for_mesh(&mesh, Filling::Solid).stiffness, closed.stiffness);
}

#[test]
fn a_surface_that_encloses_nothing_is_no_solid() {
    let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    let mesh = mesh::parse(square, Format::Obj, "square.obj").unwrap();
    let error = solid(&mesh).unwrap_err();
    assert_eq!(
        error.to_string(),
        "square.obj: over 100.0 % of its surface it is undecided what is inside; at most 10 % may \
         be: close its holes, or ask for a shell"
    );
}

#[test]
fn the_masses_are_equal_and_add_up_to_the_mass_of_the_body() {
    for (name, mass) in [("bunny.obj", 2.5), ("teapot.obj", 0.3)] {
        let options = MeshOptions { mass, ..MeshOptions::default() };
        let (part, _) = mesh::body(&load(name), &options).unwrap();
        let sum: f64 = part.particles.iter().map(|particle| particle.mass).sum();
        // One rounding of each of n additions, at most.
        let tolerance = part.particles.len() as f64 * f64::EPSILON * mass;
        assert!((sum - mass).abs() <= tolerance);
        assert!(part.particles.iter().all(|p| p.mass == part.particles[0].mass));
    }
}

#[test]
fn the_longest_side_has_the_size_asked_for_and_is_centred() {
    let mesh = load("bunny.obj");
    let options = MeshOptions { size: Some(0.4), ..MeshOptions::default() };
    let (part, report) = mesh::body(&mesh, &options).unwrap();
    let x = &positions(&part)[..report.surface_particles];
    assert!((extent(x).max_element() - 0.4).abs() <= 1e-15);
    let low = x.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = x.iter().copied().fold(DVec3::MIN, DVec3::max);
    assert!((low + high).length() <= 1e-15);
    let options = MeshOptions { size: None, ..MeshOptions::default() };
    let (part, report) = mesh::body(&mesh, &options).unwrap();
    let x = &positions(&part)[..report.surface_particles];
    assert!((extent(x) - extent(&mesh.positions)).length() <= 1e-14);
}

#[test]
fn a_coarse_box_has_a_lattice_that_reaches_its_corners() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let mesh = mesh::parse(text.as_bytes(), Format::Obj, "box").unwrap();
    let (part, report) = mesh::body(&mesh, &MeshOptions::default()).unwrap();
    // Six steps of 1/6 from face to face; the layers in the faces themselves are left out.
    assert_eq!(report.interior_particles, 5 * 5 * 5);
    assert!((report.volume - 1.0).abs() <= 1e-14);
    assert_held(&part);
    assert!(sets(&part).iter().all(|&set| set == 0));
    let mut scene = Scene::default();
    scene.add("box", part);
    assert!(Simulation::<f32>::new(&scene, Settings::default()).is_ok());
}

#[test]
fn texture_coordinates_lie_in_the_unit_square() {
    for name in ["bunny.obj", "teapot.obj"] {
        let (part, _) = mesh::body(&load(name), &MeshOptions::default()).unwrap();
        let uvs = part.surface.corners.iter().flat_map(|corner| corner.uv);
        assert!(uvs.into_iter().all(|value| (0.0..=1.0).contains(&value)));
    }
}

#[test]
fn options_outside_their_domain_are_refused_by_name() {
    let mesh = load("teapot.obj");
    let refused = |options: MeshOptions| mesh::body(&mesh, &options).unwrap_err().to_string();
    let default = MeshOptions::default();
    assert_eq!(
        refused(MeshOptions { mass: -1.0, ..default }),
        "mass of the mesh body is -1; it must be positive and at most 1e9"
    );
    assert!(refused(MeshOptions { size: Some(f64::NAN), ..default }).starts_with("size"));
    assert!(refused(MeshOptions { spacing: Some(0.0), ..default }).starts_with("spacing"));
    assert!(refused(MeshOptions { stiffness: -1.0, ..default }).starts_with("stiffness"));
    assert!(refused(MeshOptions { damping: f64::INFINITY, ..default }).starts_with("damping"));
    assert!(refused(MeshOptions { bending: -0.5, ..default }).starts_with("bending"));
    let fine = MeshOptions { spacing: Some(1e-6), ..default };
    let error = mesh::body(&load("bunny.obj"), &fine).unwrap_err();
    assert!(matches!(error, MeshError::TooFine { .. }));
}

#[test]
fn the_bunny_is_well_conditioned() {
    let (part, _) = mesh::body(&load("bunny.obj"), &MeshOptions::default()).unwrap();
    // A regular lattice of 26 springs each has a bound of 52 k/m; twice that is the price of an
    // irregular surface.
    let spring = part.springs[0];
    let unit = spring.stiffness / part.particles[0].mass;
    assert!(largest_w2(&part) <= 104.0 * unit, "{}", largest_w2(&part) / unit);
    assert!(part.springs.iter().all(|s| s.stiffness == spring.stiffness));
}
