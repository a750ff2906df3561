//! Sliding over flat triangles without friction: their edges do not hold a body.

use super::bodies::{Stuff, add_block, add_cloth};
use super::{ALL, centre, run, shell, start};
use msd_core::glam::{DVec3, dvec3};
use msd_core::{Particle, Pin, Scene, Shell, World};

/// A floor of pinned triangles, 0.1 m apart.
fn floor(gravity: DVec3) -> Scene {
    let mut scene = Scene { world: World { gravity, ..World::default() }, ..Scene::default() };
    let ways = [dvec3(-0.5, 0.0, -0.4), DVec3::X * 0.1, DVec3::Z * 0.1];
    let all = add_cloth(&mut scene, [41, 9], ways, (1.0, 1.0), shell(0.01, 0.0));
    scene.springs.clear();
    scene.pins.extend(all.map(|particle| Pin { particle, velocity: DVec3::ZERO }));
    scene
}

#[test]
fn a_ball_slides_over_flat_triangles_as_over_a_plane() {
    for height in [0.0, 1e-9] {
        let mut scene = floor(DVec3::ZERO);
        let (position, velocity) = (dvec3(0.0, 0.06 + height, 0.013), dvec3(2.0, 0.0, 0.1));
        scene.particles.push(Particle { position, velocity, mass: 1.0 });
        let points = vec![scene.particles.len() - 1];
        scene.shells.push(Shell { points: points.clone(), ..shell(0.05, 0.0) });
        for integrator in ALL {
            for substeps in [1, 4, 16] {
                let mut simulation = start::<f64>(&scene, integrator, substeps);
                run(&mut simulation, 1.0);
                let off = simulation.velocity(points[0]) - velocity;
                assert!(off.length() < 1e-9, "{integrator} {substeps}: {off} m/s");
            }
        }
    }
}

#[test]
fn a_block_slides_over_flat_triangles_as_over_a_plane() {
    let mut scene = floor(DVec3::Y * -9.82);
    let stuff = Stuff { young: 1e5, density: 1000.0, damping: 1e-3 };
    let corner = dvec3(-0.2, 0.0112, -0.013);
    let shell = shell(0.001, 0.0);
    let block = add_block(&mut scene, [4, 4, 4], (0.03, corner), stuff, shell);
    let velocity = dvec3(4.0, 0.0, 0.3);
    block.clone().for_each(|at| scene.particles[at].velocity = velocity);
    for integrator in ALL {
        // Explicit Euler's springs need more than 16.
        for substeps in [24, 32] {
            let mut simulation = start::<f64>(&scene, integrator, substeps);
            run(&mut simulation, 0.7);
            let (_, now) = centre(&simulation, block.clone());
            let off = now - velocity;
            // It falls by 0.2 mm at the start and trembles by 40 mm/s, at right angles to the way
            // within a thousandth. An iterative solve leaves a hundredth of each change.
            let most = if integrator.is_implicit() { 1e-2 } else { 1e-3 };
            assert!(dvec3(off.x, 0.0, off.z).length() < most, "{integrator} {substeps}: {now}");
        }
    }
}
