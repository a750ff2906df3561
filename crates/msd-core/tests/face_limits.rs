//! Limits of particles with a radius against triangles: stable steps, passes, and what does not
//! touch.

mod common;
#[path = "common/touching.rs"]
mod touching;

use common::weightless;
use msd_core::glam::DVec3;
use msd_core::{Integrator, Pin, Scene, Settings, Spring, Touch};
use touching::{corners, faced, over, particle, pinned, settings, simulation};

/// A particle between two triangles that are pinned, k from each side: w² = 2 k / m.
#[test]
fn the_stable_substep_between_two_triangles_is_that_of_the_closed_form() {
    let places = corners().into_iter().chain(corners().map(|at| at + DVec3::Y * 0.18));
    let mut particles: Vec<_> = places.map(|place| particle(place, DVec3::ZERO, 0.1)).collect();
    particles.push(particle(DVec3::Y * 0.09, DVec3::Y * 1e-6, 0.1));
    let triangles = [[0, 1, 2], [3, 4, 5]].map(|at| faced(at.to_vec(), vec![at], 0.05));
    let touches = triangles.into_iter().chain([faced(vec![6], vec![], 0.05)]).collect();
    let pins = (0..6).map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    let scene = Scene { world: weightless(), particles, pins, touches, ..Scene::default() };
    let wanted = 2.0 / (2.0 * 200.0_f64 / 0.1).sqrt();
    let run = |step: f64| {
        let settings = Settings { step, ..settings(Integrator::SymplecticEuler, 1) };
        let mut simulation = simulation::<f64>(&scene, settings);
        let limit = simulation.stable_substep();
        (0..2000).for_each(|_| simulation.step().expect("inside the world"));
        (limit, (simulation.position(6).y - 0.09).abs())
    };
    let ((limit, below), (_, above)) = (run(0.995 * wanted), run(1.005 * wanted));
    assert!((limit / wanted - 1.0).abs() < 1e-9, "{limit} instead of {wanted}");
    assert!(below < 1e-6 && 1e-3 < above, "{below} {above}");
}

/// A particle beside the edge of a triangle, all of them free: w² = k (1/m + Σ wᵢ²/mᵢ).
#[test]
fn the_stable_substep_beside_an_edge_is_that_of_the_closed_form() {
    let [a, b, _] = corners();
    let beside = DVec3::new(0.1, 0.0, -1.0).normalize() * 0.09;
    let scene = over(
        corners().map(|corner| particle(corner, DVec3::ZERO, 0.5)),
        particle(a * 0.5 + b * 0.5 + beside, DVec3::ZERO, 0.1),
        |row| row,
    );
    let wanted = 2.0 / (200.0 * (1.0_f64 / 0.1 + 2.0 * 0.25 / 0.5)).sqrt();
    let limit =
        simulation::<f64>(&scene, settings(Integrator::SymplecticEuler, 1)).stable_substep();
    // The turn of the edge, δ over its length, is not in it.
    assert!((limit / wanted - 1.0).abs() < 5e-3, "{limit} instead of {wanted}");
}

#[test]
fn what_may_have_passed_through_is_counted() {
    let passes = |height: f64, velocity: DVec3, triangle: DVec3, stiffness: f64| {
        let scene = over(
            corners().map(|corner| particle(corner, triangle, 0.1)),
            particle(DVec3::Y * height, velocity, 0.1),
            |row| Touch { stiffness, ..row },
        );
        let mut simulation = simulation::<f32>(&scene, settings(Integrator::VelocityVerlet, 4));
        (0..30).for_each(|_| simulation.step().expect("inside the world"));
        0 < simulation.ledger().passes()
    };
    for (speed, wanted) in [(0.5, false), (2.0, false), (30.0, true), (2000.0, true)] {
        assert_eq!(passes(0.35, -DVec3::Y * speed, DVec3::ZERO, 400.0), wanted, "{speed} m/s");
        // The same as seen from the particle.
        assert_eq!(passes(0.35, DVec3::ZERO, DVec3::Y * speed, 400.0), wanted, "{speed} m/s");
        // Together they never meet, however fast.
        let both = -DVec3::Y * speed;
        assert!(!passes(0.35, both, both, 400.0), "{speed} m/s");
    }
    // Slowly through it, as it is too soft; past its edge, and up and down at rest within reach.
    assert!(passes(0.05, -DVec3::Y * 0.5, DVec3::ZERO, 1e-3));
    let beside = |height: f64, velocity: DVec3| passes(height, velocity, DVec3::ZERO, 1e-3);
    assert!(!beside(0.05, DVec3::X * 2.0) && !beside(0.05, DVec3::Y * 0.5));
    assert!(!passes(0.09, DVec3::ZERO, DVec3::ZERO, 400.0));
}

/// Beside an edge the plane of a triangle may be crossed: nothing passes.
#[test]
fn to_go_around_an_edge_is_no_pass() {
    let scene = pinned(over(
        corners().map(|corner| particle(corner, DVec3::ZERO, 1.0)),
        particle(DVec3::new(-0.55, 0.02, -0.33), -DVec3::Y * 0.2, 0.1),
        |row| Touch { stiffness: 1e-3, ..row },
    ));
    let mut simulation = simulation::<f64>(&scene, settings(Integrator::VelocityVerlet, 16));
    (0..30).for_each(|_| simulation.step().expect("inside the world"));
    assert!(simulation.position(3).y < -0.05);
    assert_eq!(simulation.ledger().passes(), 0);
}

/// The force on the particle over a triangle, of a scene that a change was made to.
fn force_after(change: impl FnOnce(&mut Scene)) -> DVec3 {
    let mut scene = over(
        corners().map(|corner| particle(corner, DVec3::ZERO, 1.0)),
        particle(DVec3::Y * 0.08, DVec3::ZERO, 1.0),
        |row| row,
    );
    change(&mut scene);
    let simulation = simulation::<f64>(&scene, Settings::default());
    simulation.forces().0[3]
}

#[test]
fn triangles_are_passed_by_what_is_joined_exempt_or_ignored() {
    let push = DVec3::Y * 200.0 * 0.02;
    assert!((force_after(|_| ()) - push).length() < 1e-12);
    let spring = Spring { ends: [3, 1], rest_length: 0.1, stiffness: 0.0, damping: 0.0 };
    assert_eq!(force_after(|scene| scene.springs.push(spring)), DVec3::ZERO);
    assert_eq!(force_after(|scene| scene.exempt.push([2, 3])), DVec3::ZERO);
    assert_eq!(force_after(|scene| scene.touches[1].ignored.push(0)), DVec3::ZERO);
    // In one row, the particle is of the surface's own.
    let one_row = |itself: bool| {
        move |scene: &mut Scene| {
            scene.touches.pop();
            scene.touches[0].particles.push(3);
            scene.touches[0].itself = itself;
        }
    };
    assert!((force_after(one_row(true)) - push).length() < 1e-12);
    assert_eq!(force_after(one_row(false)), DVec3::ZERO);
    // At rest within reach it does not touch, in `add_touch`.
    let at_rest = |scene: &mut Scene| {
        let row = Touch { particles: vec![0, 1, 2, 3], ..scene.touches[0].clone() };
        scene.touches.clear();
        scene.add_touch(row).expect("a few pairs");
        assert_eq!(scene.exempt.len(), 1);
        assert!(scene.exempt[0].contains(&3));
    };
    assert_eq!(force_after(at_rest), DVec3::ZERO);
}
