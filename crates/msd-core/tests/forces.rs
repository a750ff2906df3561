//! Do the two algorithms of the source report agree, and with the law of design section 4?

mod common;

use common::{random_scene, two_masses};
use msd_core::forces::{
    Incidence, add_spring_forces, add_spring_forces_by_particle, set_external_forces,
};
use msd_core::glam::DVec3;
use msd_core::{Model, Real, Scene, Vector};
use proptest::prelude::*;

fn by_spring_and_by_particle<R: Real>(scene: &Scene) -> [Vec<R::Vec3>; 2] {
    let (model, state) = Model::<R>::new(scene).unwrap();
    let mut scattered = vec![R::Vec3::ZERO; model.particle_count()];
    let mut gathered = scattered.clone();
    add_spring_forces(&model, state.motion(), &mut scattered);
    let incidence = Incidence::new(&model);
    add_spring_forces_by_particle(&model, &incidence, state.motion(), &mut gathered);
    [scattered, gathered]
}

proptest! {
    /// A sum per particle in the order of the springs is the same sum either way: the same bits.
    #[test]
    fn both_algorithms_give_the_same_bits_on_random_topologies(seed in any::<u64>()) {
        let scene = random_scene(seed);
        let [scattered, gathered] = by_spring_and_by_particle::<f32>(&scene);
        prop_assert_eq!(scattered, gathered);
        let [scattered, gathered] = by_spring_and_by_particle::<f64>(&scene);
        prop_assert_eq!(scattered, gathered);
    }

    #[test]
    fn springs_and_dampers_exert_no_net_force_and_no_net_torque(seed in any::<u64>()) {
        let scene = random_scene(seed);
        let [forces, _] = by_spring_and_by_particle::<f64>(&scene);
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
    let [forces, _] = by_spring_and_by_particle::<f64>(&scene);
    // k (L − l0) + b (v_b − v_a)·u = 10 · 0.5 + 3 · 2 = 11 N.
    assert_eq!(forces, [DVec3::new(11.0, 0.0, 0.0), DVec3::new(-11.0, 0.0, 0.0)]);
}

#[test]
fn a_spring_whose_ends_coincide_has_no_direction_and_exerts_no_force() {
    let scene = two_masses([1.0, 1.0], 10.0, 3.0, -1.0);
    for forces in by_spring_and_by_particle::<f64>(&scene) {
        assert_eq!(forces, [DVec3::ZERO; 2]);
    }
}

#[test]
fn the_power_of_a_damper_is_damping_times_rate_squared() {
    let mut scene = two_masses([1.0, 1.0], 10.0, 3.0, 0.5);
    scene.particles[1].velocity = DVec3::new(2.0, 0.0, 0.0);
    let (model, state) = Model::<f64>::new(&scene).unwrap();
    let power = add_spring_forces(&model, state.motion(), &mut [DVec3::ZERO; 2]);
    assert_eq!(power, 3.0 * 2.0 * 2.0);
}

#[test]
fn gravity_pulls_by_mass_and_the_uniform_force_does_not() {
    let mut scene = two_masses([2.0, 5.0], 0.0, 0.0, 0.0);
    scene.world.gravity = DVec3::new(0.0, -10.0, 0.0);
    scene.world.force = DVec3::new(1.0, 0.0, 0.0);
    let (model, state) = Model::<f64>::new(&scene).unwrap();
    let mut forces = [DVec3::splat(99.0); 2];
    set_external_forces(&model, state.motion(), &mut forces);
    assert_eq!(forces, [DVec3::new(1.0, -20.0, 0.0), DVec3::new(1.0, -50.0, 0.0)]);
}
