//! Is the predicted limit of the substep where runs do blow up?

mod common;

use common::weightless;
use msd_core::stability::{is_stable, largest_substep, spectrum};
use msd_core::{Explicit, Integrator, Material, Model, Scene, Settings, Simulation, Vector, shape};

fn at_rest(damping: f64) -> Scene {
    let material = Material { mass: 2.0, stiffness: 300.0, damping };
    let mut part = shape::block([4, 4, 4], 1.0, material).unwrap();
    // A tiny push that has a part of every mode.
    let mut numbers = common::Numbers(7);
    part.particles.iter_mut().for_each(|particle| particle.velocity = numbers.vector() * 1e-9);
    Scene { world: weightless(), ..Scene::of("block", part) }
}

/// Whether a tiny disturbance of the rest state grows.
fn blows_up(scene: &Scene, settings: Settings) -> bool {
    let mut simulation = Simulation::<f64>::new(scene, settings).unwrap();
    let speed =
        |s: &Simulation<f64>| s.state().velocities.iter().map(|v| v.extent()).fold(0.0, f64::max);
    for _ in 0..6_000 / settings.substeps {
        simulation.step().unwrap();
        if 1e-5 < speed(&simulation) {
            return true;
        }
    }
    false
}

#[test]
fn the_predicted_limit_is_the_one_observed() {
    for damping in [0.0, 5.0, 60.0] {
        let scene = at_rest(damping);
        let (model, state) = Model::<f64>::new(&scene).unwrap();
        let spectrum = spectrum(&model, &state);
        let methods = [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4];
        for (integrator, substeps) in methods.into_iter().flat_map(|i| [(i, 1), (i, 4)]) {
            let predicted = largest_substep(spectrum, integrator, substeps);
            let (mut low, mut high) = (0.5 * predicted, 2.0 * predicted);
            for _ in 0..10 {
                let h = 0.5 * (low + high);
                let settings = Settings {
                    integrator,
                    step: h * f64::from(substeps),
                    substeps,
                    ..Settings::default()
                };
                if blows_up(&scene, settings) { high = h } else { low = h }
            }
            let ratio = predicted / low;
            // Lanczos is within 0.2 % from below in w², growth takes a margin of 0.1 % to show.
            let name = format!("{integrator}, b = {damping}, {substeps} substeps: {ratio}");
            assert!((ratio - 1.0).abs() < 0.005, "{name}");
        }
    }
}

#[test]
fn two_masses_have_the_spectrum_of_their_reduced_mass() {
    let scene = common::two_masses([1.0, 3.0], 30.0, 2.0, 0.0);
    let (model, state) = Model::<f64>::new(&scene).unwrap();
    let spectrum = spectrum(&model, &state);
    let per_mass = 1.0 + 1.0 / 3.0;
    assert!((spectrum.stiffness - 30.0 * per_mass).abs() < 1e-9);
    assert!((spectrum.damping - 2.0 * per_mass).abs() < 1e-9);
}

#[test]
fn the_regions_are_those_of_the_textbooks() {
    let limit = |integrator, zeta: f64| {
        let spectrum = msd_core::stability::Spectrum { stiffness: 1.0, damping: 2.0 * zeta };
        largest_substep(spectrum, integrator, 1)
    };
    // Undamped: 2 / w for Verlet and symplectic Euler, 2 √2 / w for RK4, none for explicit Euler.
    assert!((limit(Integrator::SymplecticEuler, 0.0) - 2.0).abs() < 1e-6);
    assert!((limit(Integrator::VelocityVerlet, 0.0) - 2.0).abs() < 1e-6);
    assert!((limit(Integrator::Rk4, 0.0) - 8f64.sqrt()).abs() < 1e-6);
    assert_eq!(limit(Integrator::ExplicitEuler, 0.0), 0.0);
    for zeta in [1e-4f64, 0.1, 0.5, 1.0, 3.0] {
        // Symplectic Euler: W/4 + Z/2 = 1; explicit Euler below critical damping: h = 2 ζ / w.
        let exact = 2.0 * ((zeta * zeta + 1.0).sqrt() - zeta);
        assert!((limit(Integrator::SymplecticEuler, zeta) - exact).abs() < 1e-6);
        if zeta <= 1.0 {
            assert!((limit(Integrator::ExplicitEuler, zeta) - 2.0 * zeta).abs() < 1e-6);
        }
    }
    // A step of many substeps of Verlet has the limit of symplectic Euler, damped or not.
    for zeta in [0.0f64, 0.01, 0.3, 1.0, 10.0] {
        let exact = 2.0 * ((zeta * zeta + 1.0).sqrt() - zeta);
        let stable = |h: f64| is_stable(Explicit::VelocityVerlet, 64, h * h, 2.0 * zeta * h);
        assert!(stable(0.99 * exact) && !stable(1.01 * exact), "{zeta}");
    }
}

#[test]
fn free_particles_have_no_limit_and_pins_raise_it() {
    let mut scene = common::two_masses([1.0, 1.0], 30.0, 0.0, 0.0);
    let limit = |scene: &Scene| {
        Simulation::<f32>::new(scene, Settings::default()).unwrap().stable_substep()
    };
    let free = limit(&scene);
    scene.pins = vec![msd_core::Pin { particle: 0, velocity: Default::default() }];
    // A pin doubles the reduced mass: √2 slower.
    assert!((limit(&scene) / free - 2f64.sqrt()).abs() < 1e-6);
    scene.springs.clear();
    assert_eq!(limit(&scene), f64::INFINITY);
}
