//! The workloads are what their documentation says.

use msd_core::glam::DVec3;
use msd_core::{Friction, Scene};
use msd_run::Runner;
use msd_scene::{FileError, Precision, workloads};

fn check_material(scene: &Scene, stiffness: f64, damping: f64) {
    for particle in &scene.particles {
        assert_eq!((particle.mass, particle.velocity), (1.0, DVec3::ZERO));
    }
    for spring in &scene.springs {
        assert_eq!((spring.stiffness, spring.damping), (stiffness, damping));
        let [a, b] = spring.ends.map(|end| scene.particles[end].position);
        // At rest: as long as its ends are apart, 1, √2 or √3 rounded twice.
        assert!((a.distance(b) - spring.rest_length).abs() < 1e-15);
    }
    assert_eq!(scene.world.gravity, DVec3::new(0.0, -9.82, 0.0));
}

#[test]
fn a_cloth_lies_flat_in_row_order_with_the_ends_of_its_first_side_pinned() {
    for side in [2, 3, 8, 31] {
        let scene = workloads::cloth(side).unwrap();
        check_material(&scene, 1e4, 20.0);
        assert_eq!(scene.springs.len(), (side - 1) * (4 * side - 2));
        assert_eq!(scene.particles.len(), side * side);
        for (row, particle) in scene.particles.iter().enumerate() {
            let (i, j) = ((row / side) as f64, (row % side) as f64);
            assert_eq!(particle.position, DVec3::new(i, 0.0, j));
        }
        let pins: Vec<usize> = scene.pins.iter().map(|pin| pin.particle).collect();
        assert_eq!(pins, [0, (side - 1) * side]);
        assert!(scene.pins.iter().all(|pin| pin.velocity == DVec3::ZERO));
        assert!(scene.planes.is_empty());
    }
}

#[test]
fn a_block_starts_a_metre_above_a_plane_that_neither_bounces_nor_rubs() {
    for side in [2, 3, 10] {
        let scene = workloads::block(side).unwrap();
        check_material(&scene, 2200.0, 1.0);
        assert_eq!(scene.springs.len(), (side - 1) * (13 * side * side - 14 * side + 4));
        assert_eq!(scene.particles.len(), side * side * side);
        for (row, particle) in scene.particles.iter().enumerate() {
            let at = [row / side % side, row / side / side + 1, row % side];
            assert_eq!(particle.position, DVec3::from(at.map(|length| length as f64)));
        }
        let plane = scene.planes[0];
        assert_eq!((plane.normal, plane.offset), (DVec3::Y, 0.0));
        assert_eq!((plane.restitution, plane.friction), (0.0, Friction::Coulomb(0.0)));
        assert_eq!((scene.planes.len(), scene.pins.len()), (1, 0));
    }
}

#[test]
fn an_irregular_body_joins_each_particle_to_its_14_nearest() {
    for count in [0, 1, 2, 14, 15, 16, 200] {
        let scene = workloads::irregular(count).unwrap();
        check_material(&scene, 2200.0, 1.0);
        let mut pairs = Vec::new();
        for (row, particle) in scene.particles.iter().enumerate() {
            let mut others: Vec<usize> = (0..count).filter(|&other| other != row).collect();
            let square = |&other: &usize| {
                particle.position.distance_squared(scene.particles[other].position)
            };
            others.sort_by(|a, b| square(a).total_cmp(&square(b)));
            pairs.extend(others.iter().take(14).map(|&other| [row.min(other), row.max(other)]));
        }
        pairs.sort_unstable();
        pairs.dedup();
        let ends: Vec<[usize; 2]> = scene.springs.iter().map(|spring| spring.ends).collect();
        assert_eq!(ends, pairs, "{count}");
    }
}

#[test]
fn springs_inside_join_8_and_26_neighbours() {
    let degree = |scene: &Scene, particle: usize| {
        scene.springs.iter().filter(|spring| spring.ends.contains(&particle)).count()
    };
    assert_eq!(degree(&workloads::cloth(3).unwrap(), 4), 8);
    assert_eq!(degree(&workloads::block(3).unwrap(), 13), 26);
}

#[test]
fn both_run_for_two_seconds_in_either_precision() {
    for scene in [workloads::cloth(6).unwrap(), workloads::block(4).unwrap()] {
        for precision in [Precision::F32, Precision::F64] {
            let mut runner = Runner::new(&scene, workloads::settings(), precision).unwrap();
            (0..120).for_each(|_| runner.step().unwrap());
        }
    }
}

#[test]
fn a_side_too_short_or_too_long_is_refused() {
    for side in [0, 1] {
        for refused in [workloads::cloth(side), workloads::block(side)] {
            let told = refused.unwrap_err().to_string();
            assert!(told.contains(&format!("is {side}; it must be at least 2")), "{told}");
        }
    }
    for refused in [workloads::cloth(5000), workloads::block(150), workloads::block(usize::MAX)] {
        assert!(matches!(refused, Err(FileError::TooLarge { .. })));
    }
    let told = workloads::cloth(5000).unwrap_err().to_string();
    assert!(told.starts_with("cloth: its size asks for 25000000 particles"), "{told}");
}
