//! Wind: a uniform force, steady or in gusts.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Periods of the two swings that gusts are made of, seconds: their sum does not repeat within a
/// minute.
const PERIODS: [f64; 2] = [2.3, 0.71];

/// A wind on top of the uniform force of a scene.
///
/// The core has no air that moves: wind is a force on every particle, whatever its velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wind {
    /// Mean force on every particle, newtons; not negative.
    pub strength: f64,
    /// Where it blows to: angle about the y axis, radians; 0 is the x axis, a quarter turn −z.
    pub heading: f64,
    /// The part of its strength by which it comes and goes, 0 to 1.
    pub gusts: f64,
}

impl Wind {
    /// The force on every particle at a simulated time, newtons.
    pub fn force(&self, time: f64) -> DVec3 {
        let swing: f64 = PERIODS.iter().map(|period| libm::sin(TAU * time / period)).sum();
        let share = 1.0 + self.gusts * swing / PERIODS.len() as f64;
        let (sine, cosine) = libm::sincos(self.heading);
        DVec3::new(cosine, 0.0, -sine) * (self.strength * share)
    }

    /// Whether every number is in its domain.
    pub(crate) fn is_usable(&self) -> bool {
        (0.0..f64::INFINITY).contains(&self.strength)
            && self.heading.is_finite()
            && (0.0..=1.0).contains(&self.gusts)
    }

    /// The same without gusts.
    pub fn mean(&self) -> Wind {
        Wind { gusts: 0.0, ..*self }
    }

    /// The same as strong as it comes to be, without gusts.
    pub fn strongest(&self) -> Wind {
        Wind { strength: self.strength * (1.0 + self.gusts), ..self.mean() }
    }

    /// Returns whether it is gusty.
    pub fn is_gusty(&self) -> bool {
        0.0 < self.gusts && 0.0 < self.strength
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_stay_between_nothing_and_twice_the_strength_and_keep_its_mean() {
        let wind = Wind { strength: 3.0, heading: 0.5, gusts: 1.0 };
        let way = Wind { gusts: 0.0, ..wind }.force(0.0) / 3.0;
        let forces: Vec<f64> = (0..60_000)
            .map(|row| wind.force(f64::from(row) / 100.0))
            .map(|force| {
                assert!((force - way * force.dot(way)).length() < 1e-12, "it keeps its heading");
                force.dot(way)
            })
            .collect();
        assert!(forces.iter().all(|force| (-1e-12..=6.0 + 1e-12).contains(force)));
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        // A swing that is cut off within a period leaves at most its period over the whole time.
        assert!((mean - 3.0).abs() < 3.0 * 2.3 / 600.0, "{mean} N");
    }
}
