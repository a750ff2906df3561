//! How strong is the hand that holds a particle?

use glam::DVec3;
use msd_core::{Interaction, Model, Real, Vector};

/// How fast a whole body follows the hand, hertz.
const BODY_FREQUENCY: f64 = 1.5;
/// Damping ratio of a whole body on the hand.
const BODY_DAMPING: f64 = 0.7;
/// The largest force of the hand as a multiple of the weight of the body.
const STRENGTH: f64 = 30.0;
/// Weight is reckoned with at least this gravity, m/s²: things that float can be thrown too.
const LEAST_GRAVITY: f64 = 9.82;

/// A particle held by the mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The particle.
    pub particle: usize,
    /// Where it is pulled to, metres.
    pub target: DVec3,
    frequency: f64,
    damping_ratio: f64,
    max_force: f64,
}

impl Hold {
    /// A hand strong enough for the body of a particle.
    ///
    /// The spring of the hand is given by the frequency f of the single particle of mass m, and is
    /// to carry a body of mass M at frequency F: m f² = M F², so f = F √(M / m). Damping ratios
    /// scale alike. The core caps both by the substep.
    pub(crate) fn on<R: Real>(model: &Model<R>, particle: usize, target: DVec3) -> Self {
        let masses = model.masses();
        let holds = |range: &std::ops::Range<usize>| range.contains(&particle);
        let body = model.bodies().iter().map(|body| body.particles.clone()).find(holds);
        let mass = masses[particle].to_f64();
        let body = body.map_or(mass, |range| masses[range].iter().map(|m| m.to_f64()).sum());
        let share = (body / mass).sqrt();
        let gravity = model.gravity().to_f64().length().max(LEAST_GRAVITY);
        Hold {
            particle,
            target,
            frequency: BODY_FREQUENCY * share,
            damping_ratio: BODY_DAMPING * share,
            max_force: STRENGTH * body * gravity,
        }
    }

    /// The grab of this hand.
    pub(crate) fn interaction(&self) -> Interaction {
        Interaction::Grab {
            particle: self.particle,
            target: self.target,
            frequency: self.frequency,
            damping_ratio: self.damping_ratio,
            max_force: self.max_force,
        }
    }
}
