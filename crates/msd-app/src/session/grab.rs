//! The particle that the mouse holds, and the one that is selected.

use glam::DVec3;
use msd_core::{Interaction, Model, Real, Vector};
use msd_run::{Runner, on};

/// How fast a whole body follows the mouse, hertz.
const BODY_FREQUENCY: f64 = 1.5;
/// Damping ratio of a whole body on the spring of the mouse.
const BODY_DAMPING: f64 = 0.7;
/// The largest force of a grab as a multiple of the weight of the body.
const STRENGTH: f64 = 30.0;
/// Weight is reckoned with at least this gravity, m/s²: things that float can be thrown too.
const LEAST_GRAVITY: f64 = 9.82;
/// Part of the way to the target that a pin moves in one step.
const PIN_PULL: f64 = 0.25;

/// A particle on the spring of the mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The particle.
    pub particle: usize,
    /// Where it is pulled to, metres.
    pub target: DVec3,
    frequency: f64,
    damping_ratio: f64,
    max_force: f64,
}

impl Held {
    /// A grab strong enough for the body of a particle.
    ///
    /// The spring of a grab is given by the frequency f of the single particle of mass m, and is
    /// to carry a body of mass M at frequency F: m f² = M F², so f = F √(M / m). Damping ratios
    /// scale alike. The core caps both by the substep.
    pub(super) fn new<R: Real>(model: &Model<R>, particle: usize, target: DVec3) -> Self {
        let masses = model.masses();
        let holds = |range: &std::ops::Range<usize>| range.contains(&particle);
        let body = model.bodies().iter().map(|body| body.particles.clone()).find(holds);
        let mass = masses[particle].to_f64();
        let body = body.map_or(mass, |range| masses[range].iter().map(|m| m.to_f64()).sum());
        let share = (body / mass).sqrt();
        let gravity = model.gravity().to_f64().length().max(LEAST_GRAVITY);
        Held {
            particle,
            target,
            frequency: BODY_FREQUENCY * share,
            damping_ratio: BODY_DAMPING * share,
            max_force: STRENGTH * body * gravity,
        }
    }

    /// The grab as the simulation takes it.
    pub(super) fn interaction(&self) -> Interaction {
        Interaction::Grab {
            particle: self.particle,
            target: self.target,
            frequency: self.frequency,
            damping_ratio: self.damping_ratio,
            max_force: self.max_force,
        }
    }

    /// How a held pin moves in the next step: no force moves it, so the mouse gives it a velocity.
    /// `None` for a particle that is not pinned.
    pub(super) fn pin_motion(&self, runner: &Runner) -> Option<Interaction> {
        let Held { particle, target, .. } = *self;
        let (is_pinned, position) = on!(runner, simulation => {
            (simulation.model().is_pinned(particle), simulation.position(particle).to_f64())
        });
        let velocity = (target - position) * (PIN_PULL / runner.settings().step);
        is_pinned.then_some(Interaction::Pin { particle, velocity })
    }
}

/// What the mouse holds, and what buttons and keys act on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grab {
    /// The particle that the mouse holds.
    pub held: Option<Held>,
    /// The particle that buttons and keys act on.
    pub selected: Option<usize>,
}

impl Grab {
    /// Whether an interaction only moves the particle that is held already.
    pub(super) fn moves(&self, interaction: &Interaction) -> bool {
        use Interaction::{Grab, Pin};
        let (Grab { particle, .. } | Pin { particle, .. }) = interaction else { return false };
        self.held.is_some_and(|held| held.particle == *particle)
    }
}
