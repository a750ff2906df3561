//! The origin of a scene, moved near it so that single precision has digits left.
//!
//! A coordinate of size x is rounded by about 6e-8 |x| in `f32`: 1 mm at 10 km. Nothing in the
//! physics depends on where the origin is, so a scene far from it is moved in double precision
//! before it is rounded, and readings are moved back.

use crate::number::Real;
use crate::scene::{Lead, Scene};
use glam::DVec3;

impl Scene {
    /// The same scene elsewhere: particles, obstacles and gusts moved by `by`, metres.
    ///
    /// The world reaches as far from the new origin as from the old, and gravitational energy is
    /// zero at the new one.
    pub fn moved(&self, by: DVec3) -> Scene {
        let mut scene = self.clone();
        for particle in &mut scene.particles {
            particle.position += by;
        }
        if let Some(air) = &mut scene.world.air {
            air.gust.origin += by;
        }
        for plane in &mut scene.planes {
            let largest = plane.normal.abs().max_element();
            // No direction: nothing that could be moved; the scene is refused where it is run.
            if 0.0 < largest && largest.is_finite() {
                let scaled = plane.normal / largest;
                plane.offset += scaled.dot(by) / Real::sqrt(scaled.dot(scaled));
            }
        }
        for solid in &mut scene.solids {
            solid.position += by;
            solid.keys.iter_mut().for_each(|key| key.position += by);
        }
        for guide in &mut scene.guides {
            if let Lead::Path { position, keys, .. } = &mut guide.lead {
                *position += by;
                keys.iter_mut().for_each(|key| key.position += by);
            }
        }
        scene
    }

    /// The scene moved so that its middle is within a metre of the origin, and the new origin in
    /// the old coordinates, metres. A position x of the new scene is x + this of the old one.
    ///
    /// Whole metres, so that a double loses nothing. Use it for a scene far away that is to run in
    /// `f32`; it does not help a scene that is as large as its distance.
    pub fn recentred(&self) -> (Scene, DVec3) {
        let mut positions = self.particles.iter().map(|particle| particle.position);
        let first = positions.next().unwrap_or_default();
        let (low, high) =
            positions.fold((first, first), |(low, high), x| (low.min(x), high.max(x)));
        let middle = (low + (high - low) * 0.5).to_array();
        // Saturates for numbers that no world holds.
        let origin = DVec3::from_array(middle.map(|x| x as i64 as f64));
        (self.moved(-origin), origin)
    }
}
