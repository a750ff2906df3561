//! The list of near particles: what comes from afar is met, what passes through is counted.

mod common;
#[path = "common/touching.rs"]
mod touching;

use common::{Random, weightless};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Particle, Scene, Simulation, Touch};
use touching::{faced, particle, settings, simulation, touch};

/// Two clusters that are far apart when the list is made, each of particles that move alike, so
/// that nothing in a cell or in cells that touch comes closer: only by their way do they meet.
#[test]
fn what_comes_from_afar_is_met() {
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::BackwardEuler,
        Integrator::ImplicitMidpoint,
        Integrator::Xpbd,
        Integrator::DormandPrince,
    ] {
        for distance in [0.5, 2.0, 8.0] {
            let cluster = |side: f64| {
                (0..9).map(move |at| {
                    let (y, z) = (f64::from(at / 3), f64::from(at % 3));
                    let position = DVec3::new(side * distance / 2.0, 0.2 * y, 0.2 * z);
                    particle(position, DVec3::X * -side, 0.1)
                })
            };
            let particles: Vec<Particle> = cluster(-1.0).chain(cluster(1.0)).collect();
            let touches = vec![touch((0..18).collect(), 0.05)];
            let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
            let mut simulation = simulation::<f64>(&scene, settings(integrator, 16));
            let frames = (60.0 * (0.5 * distance + 0.5)) as usize;
            (0..frames).for_each(|_| simulation.step().expect("inside the world"));
            let state = simulation.state();
            for at in 0..18 {
                let away = if at < 9 { -1.0 } else { 1.0 };
                let speed = state.velocities[at].x * away;
                assert!(0.5 < speed, "{integrator:?}: {speed} m/s after {distance} m");
            }
        }
    }
}

#[test]
fn what_may_have_passed_through_is_counted() {
    for (speed, passes) in [(1.0, false), (5.0, false), (30.0, true), (2000.0, true)] {
        let particles = vec![
            particle(DVec3::ZERO, DVec3::X * speed, 0.1),
            particle(DVec3::new(0.35, 0.01, 0.0), DVec3::ZERO, 0.1),
        ];
        let touches = vec![touch(vec![0, 1], 0.05)];
        let scene = Scene { world: weightless(), particles, touches, ..Scene::default() };
        let mut simulation = simulation::<f32>(&scene, settings(Integrator::VelocityVerlet, 4));
        (0..30).for_each(|_| simulation.step().expect("inside the world"));
        assert_eq!(0 < simulation.ledger().passes(), passes, "{speed} m/s");
    }
}

/// Passes are counted from the state alone, whatever the list of what is near was made at before
/// and whatever the last drift was.
#[test]
fn passes_are_counted_alike_in_a_run_and_from_each_of_its_states() {
    use Integrator::{SymplecticEuler, VelocityVerlet};
    let mut random = Random(7);
    // Clouds of beads and of triangles that go through each other by so many sums of two radii in a
    // step: what is slow, what is fast, and what a stiff touch throws from slow to fast in a step.
    for (part, stiffness, least) in [(0.95, 1e-3, 20), (1.5, 1e-3, 100), (0.1, 1e4, 5)] {
        let speed = 0.5 * part * 0.1 * 60.0;
        let count = 900;
        let mut place = DVec3::ZERO;
        let mut row = |at: usize| {
            let is_first_corner = at.is_multiple_of(3);
            place = match at < 600 || is_first_corner {
                true => random.vector() * 1.5,
                false => place + random.vector() * 0.2,
            };
            let velocity = if at < 600 { speed } else { -speed };
            particle(place, velocity * DVec3::X, 1.0)
        };
        let particles = (0..count).map(&mut row).collect();
        let triangles = (600..count).step_by(3).map(|at| [at, at + 1, at + 2]).collect();
        let rows =
            [touch((0..600).collect(), 0.05), faced((600..count).collect(), triangles, 0.05)];
        let touches = rows.map(|row| Touch { stiffness, ..row }).into();
        let scene = Scene { particles, touches, world: weightless(), ..Scene::default() };
        for integrator in [SymplecticEuler, VelocityVerlet] {
            let settings = settings(integrator, 1);
            let mut whole: Simulation<f64> = simulation(&scene, settings);
            let mut sum = 0;
            for step in 0..8 {
                let mut fresh: Simulation<f64> = simulation(&scene, settings);
                fresh.set_state(&whole.state(), whole.steps()).expect("a state");
                let before = whole.ledger().passes();
                whole.step().expect("a step");
                fresh.step().expect("a step");
                let counted = whole.ledger().passes() - before;
                let run = format!("{integrator} {part} {stiffness}, step {step}");
                assert_eq!(counted, fresh.ledger().passes(), "{run}");
                sum += counted;
            }
            assert!(least < sum, "{integrator} {part} {stiffness}: {sum}");
        }
    }
}
