//! Forces at any state, by the plain loops: for experiments with methods that the core lacks.

use msd_core::glam::DVec3;
use msd_core::{Model, Real, State};

/// Overwrites `forces` with gravity, the uniform force, drag and the pull of every spring at a
/// state, N.
///
/// With d the vector from `a` to `b` and u its direction, f = (k (|d| − rest) + b u·(v_b − v_a)) u
/// is added to `a` and taken from `b`. A spring whose ends coincide has no direction and is skipped.
pub(super) fn set_forces(model: &Model<f64>, state: &State<f64>, forces: &mut [DVec3]) {
    let rows = forces.iter_mut().zip(model.masses()).zip(&state.velocities);
    for ((force, &mass), &velocity) in rows {
        *force = model.gravity() * mass + model.force() - velocity * model.drag();
    }
    for (spring, ends) in model.ends().iter().enumerate() {
        let [a, b] = ends.map(|end| end as usize);
        let across = state.positions[b] - state.positions[a];
        let squared = across.dot(across);
        if model.is_cut(spring) || squared < f64::SHORTEST_SQUARED {
            continue;
        }
        let length = squared.sqrt();
        let per_length = 1.0 / length;
        let rate = across.dot(state.velocities[b] - state.velocities[a]) * per_length;
        let tension = model.stiffness(spring) * (length - model.rest_lengths()[spring]);
        let pull = across * ((tension + model.damping(spring) * rate) * per_length);
        forces[a] += pull;
        forces[b] -= pull;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Integrator, Material, Scene, Settings, Simulation, shape};

    #[test]
    fn explicit_euler_moves_by_these_forces() {
        let material = Material { mass: 0.5, stiffness: 30.0, damping: 2.0 };
        let mut scene = Scene::of("cloth", shape::cloth([4, 5], 1.0, material).unwrap());
        (scene.world.drag, scene.world.force) = (0.3, DVec3::new(1.0, 2.0, -3.0));
        for (row, particle) in scene.particles.iter_mut().enumerate() {
            let off = DVec3::new((row % 3) as f64, (row % 5) as f64, (row % 7) as f64);
            particle.position += 0.1 * off;
            particle.velocity = off;
        }
        let settings = Settings { integrator: Integrator::ExplicitEuler, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).unwrap();
        let start = simulation.state();
        let mut forces = vec![DVec3::ZERO; start.positions.len()];
        set_forces(simulation.model(), &start, &mut forces);
        simulation.step().unwrap();
        let h = settings.substep();
        for (row, force) in forces.iter().enumerate() {
            let gained = (simulation.velocity(row) - start.velocities[row]) * 0.5 / h;
            // A velocity of about 10 m/s is rounded by 1e-15, and divided by h.
            assert!((gained - *force).length() <= 1e-12 / h, "{row}: {gained} for {force}");
        }
    }
}
