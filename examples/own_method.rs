//! Errors of a third-order symplectic method of our own (Ruth, 1983) on a spring: eight times
//! smaller at half the step.

use msd::core::glam::DVec3;
use msd::core::methods::{Method, Parts, StepContext};
use msd::core::stability::Region;
use msd::core::{Error, Particle, Real, Scene, Settings, Simulation, Spring, World};

/// Kicks by c, drifts by d, three times.
#[derive(Debug)]
struct Ruth;

const STAGES: [[f64; 2]; 3] =
    [[7.0 / 24.0, 2.0 / 3.0], [3.0 / 4.0, -2.0 / 3.0], [-1.0 / 24.0, 1.0]];

impl<R: Real> Method<R> for Ruth {
    fn region(&self) -> Region {
        // Undamped, it is stable up to 2.5 / w; symplectic Euler's 2 / w is on the safe side.
        Region::SymplecticEuler
    }

    fn advance(&self, step: &mut StepContext<'_, R>) {
        let h = step.substep();
        for _ in 0..step.substeps() {
            let mut taken = 0.0;
            for [c, d] in STAGES {
                taken += step.set_forces(step.time()) * c * h.to_f64();
                let Parts { positions, velocities, forces, inverse_masses, .. } = step.parts();
                for i in 0..positions.len() {
                    velocities[i] += forces[i] * inverse_masses[i] * (h * R::of(c));
                    positions[i] += velocities[i] * (h * R::of(d));
                }
            }
            step.finish_substep(taken);
        }
    }
}

fn main() -> Result<(), Error> {
    let at = |x: f64| Particle { position: DVec3::X * x, velocity: DVec3::ZERO, mass: 2.0 };
    let scene = Scene {
        world: World { gravity: DVec3::ZERO, ..World::default() },
        particles: vec![at(0.0), at(1.1)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 100.0, damping: 0.0 }],
        ..Scene::default()
    };
    for substeps in [16, 32, 64, 128] {
        let settings = Settings { step: 1.0, substeps, ..Settings::default() };
        let mut pair = Simulation::<f64>::new(&scene, settings)?;
        pair.set_method(Ruth);
        pair.step()?;
        // Two masses of 2 kg on 100 N/m: w = 10 rad/s.
        let exact = 1.0 + 0.1 * 10f64.cos();
        let error = (pair.position(1).x - pair.position(0).x - exact).abs();
        println!("{substeps:4} substeps: error {error:.2e} m");
    }
    Ok(())
}
