//! Grabbed and selected particles and solids.

use glam::DVec3;
use msd_core::obstacles::Placed;
use msd_core::{Interaction, Model, Real, Simulation, Vector};
use msd_run::{Runner, on};

/// Frequency at which a whole body follows the mouse, hertz.
const BODY_FREQUENCY: f64 = 1.5;
/// Damping ratio of a whole body on the spring of the mouse.
const BODY_DAMPING: f64 = 0.7;
/// The largest force of a grab as a multiple of the weight of the body.
const STRENGTH: f64 = 30.0;
/// Least gravity in the weight of a body, m/s²: so that floating bodies can be thrown too.
const LEAST_GRAVITY: f64 = 9.82;
/// Largest number of particles in a grab: each is an interaction whenever the pointer moves.
pub const MOST_HELD: usize = 256;
/// Part of the way to the target that a grabbed pin or solid moves in one step.
const PIN_PULL: f64 = 0.25;

/// A particle on the spring of the mouse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The particle.
    pub particle: usize,
    /// Target of the spring, metres.
    pub target: DVec3,
    frequency: f64,
    damping_ratio: f64,
    max_force: f64,
}

impl Held {
    /// Returns a grab that, with `others` of the same body alike, is strong enough for the body.
    ///
    /// The frequency f of a single particle of mass m defines the spring of a grab. n such
    /// particles carry a body of mass M at frequency F: n m f² = M F², so f = F √(M / (n m)).
    /// Damping ratios scale alike. The substep limits both in msd-core.
    fn new<R: Real>(model: &Model<R>, particle: usize, target: DVec3, others: &[usize]) -> Self {
        let masses = model.masses();
        let bodies = model.bodies().iter().map(|body| body.particles.clone());
        let body = bodies.into_iter().find(|body| body.contains(&particle));
        let body = body.unwrap_or(particle..particle + 1);
        let count = others.iter().filter(|other| body.contains(other)).count().max(1) as f64;
        let mass = masses[particle].to_f64();
        let carried = masses[body].iter().map(|m| m.to_f64()).sum::<f64>() / count;
        let share = (carried / mass).sqrt();
        let gravity = model.gravity().to_f64().length().max(LEAST_GRAVITY);
        Held {
            particle,
            target,
            frequency: BODY_FREQUENCY * share,
            damping_ratio: BODY_DAMPING * share,
            max_force: STRENGTH * carried * gravity,
        }
    }

    /// Returns the interaction of this grab.
    pub(in crate::session) fn interaction(&self) -> Interaction {
        Interaction::Grab {
            particle: self.particle,
            target: self.target,
            frequency: self.frequency,
            damping_ratio: self.damping_ratio,
            max_force: self.max_force,
        }
    }

    /// Returns the motion of a grabbed pin in the next step. No force moves a pin, so the mouse
    /// sets its velocity. `None` for a particle that is not pinned.
    pub(in crate::session) fn pin_motion(&self, runner: &Runner) -> Option<Interaction> {
        let Held { particle, target, .. } = *self;
        let (is_pinned, position) = on!(runner, simulation => {
            (simulation.model().is_pinned(particle), simulation.position(particle).to_f64())
        });
        let velocity = (target - position) * (PIN_PULL / runner.settings().step);
        is_pinned.then_some(Interaction::Pin { particle, velocity })
    }
}

/// A grabbed solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldSolid {
    /// The solid.
    pub solid: usize,
    /// Target of its centre, metres.
    pub target: DVec3,
}

impl HeldSolid {
    /// Returns a grab of a solid at its current position.
    pub(in crate::session) fn new(runner: &Runner, solid: usize) -> Self {
        HeldSolid { solid, target: place(runner, solid).0 }
    }

    /// Returns its motion in the next step: the mouse sets its velocity, as no force moves a solid,
    /// and keeps its spin.
    pub(in crate::session) fn motion(&self, runner: &Runner) -> Interaction {
        let (position, spin) = place(runner, self.solid);
        let velocity = (self.target - position) * (PIN_PULL / runner.settings().step);
        Interaction::MoveSolid { solid: self.solid, position, velocity, spin }
    }

    /// Returns the interaction that leaves the solid at rest at its position.
    pub(in crate::session) fn rest(&self, runner: &Runner) -> Interaction {
        let (position, spin) = place(runner, self.solid);
        Interaction::MoveSolid { solid: self.solid, position, velocity: DVec3::ZERO, spin }
    }
}

/// Returns the centre of a solid, metres, and its angular velocity, radians per second.
fn place(runner: &Runner, solid: usize) -> (DVec3, DVec3) {
    on!(runner, simulation => {
        let placed = Placed::new(&simulation.model().solids()[solid], simulation.time());
        (placed.middle, placed.spin)
    })
}

/// The grab, and the selection.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grab {
    /// The grabbed particles; the first is the one under the pointer.
    pub held: Vec<Held>,
    /// The grabbed solid, instead of particles.
    pub solid: Option<HeldSolid>,
    /// The selected particle, which buttons and keys act on.
    pub selected: Option<usize>,
    /// The particles that a grab takes together.
    pub group: Vec<usize>,
}

impl Grab {
    /// Grabs a particle and its whole group, if it has one. Each keeps its offset from the first,
    /// whose target is given.
    pub(in crate::session) fn hold(
        &self,
        runner: &Runner,
        first: usize,
        target: DVec3,
    ) -> Vec<Held> {
        let together = if self.group.contains(&first) { &self.group[..] } else { &[first] };
        on!(runner, simulation => {
            let place = |particle: usize| simulation.position(particle).to_f64();
            let way = target - place(first);
            let others = together.iter().copied().filter(|&other| other != first);
            let hold = |particle: usize| {
                let target = if particle == first { target } else { place(particle) + way };
                Held::new(simulation.model(), particle, target, together)
            };
            std::iter::once(first).chain(others).map(hold).collect()
        })
    }

    /// Returns the grab with the first particle at `target`: all keep their relative positions.
    pub(in crate::session) fn moved(&self, target: DVec3) -> Vec<Held> {
        let way = self.held.first().map_or(DVec3::ZERO, |first| target - first.target);
        let to = |(row, held): (usize, &Held)| {
            // The first one exactly: a sum would round.
            let target = if row == 0 { target } else { held.target + way };
            Held { target, ..*held }
        };
        self.held.iter().enumerate().map(to).collect()
    }

    /// Returns whether an interaction only moves a grabbed particle or solid.
    pub(in crate::session) fn moves(&self, interaction: &Interaction) -> bool {
        use Interaction::{Grab, MoveSolid, Pin};
        match interaction {
            Grab { particle, .. } | Pin { particle, .. } => {
                self.held.iter().any(|held| held.particle == *particle)
            }
            MoveSolid { solid, .. } => self.solid.is_some_and(|held| held.solid == *solid),
            _ => false,
        }
    }
}

/// Returns the total force of all grabs of a simulation in its current state, newtons.
pub(in crate::session) fn force<R: Real>(simulation: &Simulation<R>) -> DVec3 {
    let pull = |grab: &msd_core::Grab<R>| {
        let particle = grab.particle as usize;
        grab.pull(simulation.position(particle), simulation.velocity(particle)).to_f64()
    };
    simulation.model().grabs().iter().map(pull).sum()
}
