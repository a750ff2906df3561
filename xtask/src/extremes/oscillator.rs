//! An oscillator whose motion is known exactly, whatever its stiffness, masses and damping.
//!
//! Two masses on one spring are let go along it. Their distance is that of a damped oscillator, s''
//! + c/μ s' + k/μ s = 0 with 1/μ = 1/m₁ + 1/m₂, at any amplitude below the rest length.

use msd_core::glam::DVec3;
use msd_core::{Particle, Scene, Spring, World};

/// Two masses on a spring of 1 m, stretched by [`AMPLITUDE`] and at rest, in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// The masses, kilograms.
    pub masses: [f64; 2],
    /// Stiffness, newtons per metre.
    pub stiffness: f64,
    /// Damping ratio c / (2 √(k μ)): 1 is critical.
    pub damping_ratio: f64,
}

/// Stretch at the start, metres.
pub const AMPLITUDE: f64 = 0.1;
/// Rest length, metres.
const REST: f64 = 1.0;

impl Oscillator {
    /// The scene. The spring points along no axis.
    pub fn scene(&self) -> Scene {
        let direction = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let [a, b] = self.masses;
        let length = REST + AMPLITUDE;
        // About the centre of mass, which stays at the origin.
        let at = [-length * b / (a + b), length * a / (a + b)];
        let particle = |end: usize| Particle {
            position: direction * at[end],
            velocity: DVec3::ZERO,
            mass: self.masses[end],
        };
        let damping = 2.0 * self.damping_ratio * (self.stiffness * self.reduced_mass()).sqrt();
        let spring = Spring { ends: [0, 1], rest_length: REST, stiffness: self.stiffness, damping };
        Scene {
            world: World { gravity: DVec3::ZERO, ..World::default() },
            particles: vec![particle(0), particle(1)],
            springs: vec![spring],
            ..Scene::default()
        }
    }

    fn reduced_mass(&self) -> f64 {
        1.0 / (1.0 / self.masses[0] + 1.0 / self.masses[1])
    }

    /// Frequency without damping, radians per second.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.reduced_mass()).sqrt()
    }

    /// The stretch at a time, metres.
    pub fn stretch(&self, time: f64) -> f64 {
        let (w, ratio) = (self.frequency(), self.damping_ratio);
        let decay = ratio * w;
        let square = 1.0 - ratio * ratio;
        if 0.0 < square {
            let turn = w * square.sqrt();
            let (sin, cos) = libm::sincos(turn * time);
            AMPLITUDE * libm::exp(-decay * time) * (cos + decay / turn * sin)
        } else if square == 0.0 {
            AMPLITUDE * libm::exp(-decay * time) * (1.0 + decay * time)
        } else {
            // The slow root as the product of both over the fast one: their difference cancels.
            let fast = -(decay + w * (-square).sqrt());
            let slow = w * w / fast;
            let [slow_part, fast_part] = [slow, fast].map(|root| libm::exp(root * time));
            AMPLITUDE * (fast * slow_part - slow * fast_part) / (fast - slow)
        }
    }

    /// Distance of the masses less the exact one, in amplitudes.
    pub fn error(&self, time: f64, positions: &dyn Fn(usize) -> DVec3) -> f64 {
        let stretch = (positions(1) - positions(0)).length() - REST;
        (stretch - self.stretch(time)).abs() / AMPLITUDE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_obeys_its_equation() {
        for ratio in [0.0, 0.3, 0.999, 1.0, 1.001, 5.0] {
            let known = Oscillator { masses: [2.0, 3.0], stiffness: 40.0, damping_ratio: ratio };
            assert!((known.stretch(0.0) - AMPLITUDE).abs() < 1e-15);
            let (h, t) = (1e-4, 0.37);
            let [before, now, after] = [t - h, t, t + h].map(|time| known.stretch(time));
            let (slope, bend) =
                ((after - before) / (2.0 * h), (after - 2.0 * now + before) / h / h);
            let w = known.frequency();
            let left = bend + 2.0 * ratio * w * slope + w * w * now;
            // Central differences: a part h² of the fourth derivative, and rounding over h².
            let scale = AMPLITUDE * w * w * (1.0 + (ratio * w).powi(2));
            assert!(left.abs() < 1e-5 * scale, "{ratio}: {left}");
        }
    }
}
