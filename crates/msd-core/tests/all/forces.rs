//! Forces of springs, dampers and fields, against their laws.
//!
//! They are read from a step of explicit Euler, which adds h f / m to each velocity.

use crate::common::{random_scene, simulation, two_masses, weightless};
use msd_core::glam::DVec3;
use msd_core::{Integrator, Real, Scene, Simulation};
use proptest::prelude::*;

/// A scene after a step of a second.
fn stepped<R: Real>(scene: &Scene) -> Simulation<R> {
    let mut simulation = simulation(scene, Integrator::ExplicitEuler, 1.0);
    simulation.step().unwrap();
    simulation
}

/// The forces on each particle, newtons.
fn forces(scene: &Scene) -> Vec<DVec3> {
    let gained = stepped::<f64>(scene);
    let rows = gained.velocities().zip(&scene.particles);
    rows.map(|(velocity, row)| (velocity - row.velocity) * row.mass).collect()
}

proptest! {
    #[test]
    fn springs_and_dampers_exert_no_net_force_and_no_net_torque(seed in any::<u64>()) {
        let scene = Scene { world: weightless(), ..random_scene(seed) };
        let forces = forces(&scene);
        let force: DVec3 = forces.iter().sum();
        let rows = scene.particles.iter().zip(&forces);
        let torque: DVec3 = rows.map(|(p, f)| p.position.cross(*f)).sum();
        // At most 120 springs of at most 2000 N at arms of 10 m, each rounded to 2^-53.
        prop_assert!(force.length() < 1e-10 && torque.length() < 1e-9);
    }
}

#[test]
fn a_stretched_spring_pulls_its_ends_together_and_a_damper_resists_parting() {
    let mut scene = two_masses([1.0, 1.0], 10.0, 3.0, 0.5);
    scene.particles[1].velocity = DVec3::new(2.0, 7.0, 0.0); // the sideways part is not damped
    // k (L − l0) + b (v_b − v_a)·u = 10 · 0.5 + 3 · 2 = 11 N.
    assert_eq!(forces(&scene), [DVec3::new(11.0, 0.0, 0.0), DVec3::new(-11.0, 0.0, 0.0)]);
}

#[test]
fn a_spring_whose_ends_coincide_has_no_direction_and_exerts_no_force() {
    let scene = two_masses([1.0, 1.0], 10.0, 3.0, -1.0);
    assert_eq!(forces(&scene), [DVec3::ZERO; 2]);
}

#[test]
fn the_power_of_a_damper_is_damping_times_rate_squared() {
    let mut scene = two_masses([1.0, 1.0], 10.0, 3.0, 0.5);
    scene.particles[1].velocity = DVec3::new(2.0, 0.0, 0.0);
    // For a second.
    assert_eq!(stepped::<f64>(&scene).dissipated(), 3.0 * 2.0 * 2.0);
}

#[test]
fn gravity_pulls_by_mass_and_the_uniform_force_does_not() {
    let mut scene = two_masses([2.0, 4.0], 0.0, 0.0, 0.0);
    scene.world.gravity = DVec3::new(0.0, -10.0, 0.0);
    scene.world.force = DVec3::new(1.0, 0.0, 0.0);
    assert_eq!(forces(&scene), [DVec3::new(1.0, -20.0, 0.0), DVec3::new(1.0, -40.0, 0.0)]);
}
