//! Energy that appears in a step: the first sign of one beyond the limit of stability.
//!
//! A body that is pressed flat, or whose springs come to lie along one line, is stiffer than at the
//! last prediction, and a step that was stable no longer is. Its error grows by a factor in each
//! substep, so it shows in the energy long before anything leaves the world.

use super::Simulation;
use crate::energy;
use crate::methods::{Done, Integrator};
use crate::number::Real;

/// The least change and dissipation of the kinetic energy in a step, as a part of it, before the
/// rest of the energy is looked at. Most steps pay for two sums over the particles.
const CHANGE: f64 = 0.05;
/// The rise of the energy in a step that is too much, as a part of the energy in motion after it.
///
/// The energy of a mode at 0.9 of the limit comes and goes by a factor of five, but little of the
/// motion is in such modes.
const RISE: f64 = 0.1;

impl<R: Real> Simulation<R> {
    /// Whether the step since the last good state has raised the energy by so much that it must
    /// have been too long. Not asked where unaccounted energy may come, nor of methods that have no
    /// limit or always add some.
    pub(super) fn has_risen(&self, done: &Done) -> bool {
        use Integrator::{Rk4, SymplecticEuler, VelocityVerlet};
        let is_limited = matches!(self.settings.integrator, SymplecticEuler | VelocityVerlet | Rk4);
        if !is_limited || self.own_method.is_some() || !self.queue.is_empty() {
            return false;
        }
        let [before, after] =
            [&self.good, &self.state].map(|state| energy::kinetic(&self.model, state));
        // The step is not counted yet.
        let end = self.time() + self.settings.step;
        // A body that is pressed together slows down while the error grows in its springs, and
        // contact takes the energy that has appeared within the same step.
        let is_calm = (after - before).abs() + done.counted.abs() <= before * CHANGE;
        if is_calm || self.is_handled_until(end) {
            return false;
        }
        let at = (self.time(), self.settings.substep());
        let [before, after] = [&self.good, &self.state]
            .map(|state| energy::energy_and_rounding(&self.model, state, at, self.level));
        let gain = after.0.mechanical() - before.0.mechanical() + done.counted;
        let rise = gain - before.1 - after.1;
        let moving = after.0.kinetic + after.0.elastic.abs();
        // A body that flies apart may be booked as infinitely much that contact gave.
        !rise.is_finite() || RISE * moving < rise
    }
}
