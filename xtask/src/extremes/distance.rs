//! The loss of single precision far from the origin, and the remedies.

use crate::extremes::bodies;
use msd_core::glam::DVec3;
use msd_core::{Error, Real, Scene, Settings, Simulation, State};
use msd_study::errors::rms_distance;
use serde::Serialize;

/// The distances measured, metres along every axis.
pub const DISTANCES: [f64; 6] = [0.0, 1e2, 1e3, 1e4, 1e5, 1e6];

/// Errors at one distance: root mean square over the particles after a second, as fractions of the
/// size of the body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Loss {
    /// Distance from the origin along every axis, metres.
    pub distance: f64,
    /// Between two neighbours among the numbers of `f32` there, metres, at most.
    pub rounding: f64,
    /// Of a run in `f32`, beside one in `f64` at the same place.
    pub single: f64,
    /// Of a run in `f32` of the same scene [recentred](Scene::recentred), beside the same.
    pub recentred: f64,
    /// Of a run in `f64`, beside one in `f64` at the origin.
    pub double: f64,
}

/// Steps of 1/60 s.
const STEPS: usize = 60;

/// Measures the loss at a distance.
///
/// # Errors
/// A distance outside the world.
pub fn loss(distance: f64) -> Result<Loss, Error> {
    let here = tumbling();
    let offset = DVec3::splat(distance);
    let there = here.moved(offset);
    let (moved, origin) = there.recentred();
    let right = run::<f64>(&there)?;
    let shifted = |mut state: State<f64>, by: DVec3| {
        state.positions.iter_mut().for_each(|position| *position += by);
        state
    };
    let size = Simulation::<f64>::new(&here, Settings::default())?.model().size();
    let off = |state: State<f64>| rms_distance(&state, &right) / size;
    Ok(Loss {
        distance,
        rounding: distance * f64::from(f32::EPSILON),
        single: off(run::<f32>(&there)?),
        recentred: off(shifted(run::<f32>(&moved)?, origin)),
        double: off(shifted(run::<f64>(&here)?, offset)),
    })
}

/// The usual block, thrown and turning, stretched by a tenth.
fn tumbling() -> Scene {
    let mut part = bodies::part();
    part.set_motion(DVec3::new(1.0, 5.0, 0.5), DVec3::new(1.0, 2.0, -1.0));
    for particle in &mut part.particles {
        particle.position *= 1.1;
    }
    bodies::in_a_wide_world(Scene::of("block", part))
}

fn run<R: Real>(scene: &Scene) -> Result<State<f64>, Error> {
    let mut simulation = Simulation::<R>::new(scene, Settings::default())?;
    for _ in 0..STEPS {
        simulation.step()?;
    }
    Ok(simulation.state().convert())
}
