//! Bodies that cannot carry their own weight.

use crate::materials::Made;
use msd_core::glam::DVec3;
use msd_core::{Body, Scene};

/// The strain of a column at its foot under its own weight, by Hooke's law, above which it is said.
const MOST_STRAIN: f64 = 0.5;

/// A note for each solid of a material that its own weight squeezes by more than half at its foot.
pub(super) fn overburdened(scene: &Scene, made: &[Option<Made>]) -> Vec<String> {
    let notes = scene.bodies.iter().zip(made).enumerate().filter_map(|(row, (body, made))| {
        let made = made.filter(|made| made.poisson.is_some() && made.thickness.is_none())?;
        let pressure = made.density * drop(scene, body);
        let young = made.young?;
        if pressure <= MOST_STRAIN * young {
            return None;
        }
        let end = if pressure < young { "is squeezed by" } else { "collapses: that is" };
        Some(format!(
            "bodies[{row}] ({}) cannot carry its own weight: where it stands its foot bears \
             density * gravity * height = {pressure:.3e} Pa, and {end} {:.0} % of its Young's \
             modulus; with a `young` of {:.1e} Pa it is squeezed by a tenth",
            body.name,
            100.0 * pressure / young,
            10.0 * pressure
        ))
    });
    notes.collect()
}

/// The gravity times how far a body reaches along it, square metres per second squared.
fn drop(scene: &Scene, body: &Body) -> f64 {
    let gravity: DVec3 = scene.world.gravity;
    let depths =
        scene.particles[body.particles.clone()].iter().map(|row| gravity.dot(row.position));
    let [least, most] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], depth| {
        [least.min(depth), most.max(depth)]
    });
    (most - least).max(0.0)
}
