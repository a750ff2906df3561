//! Guided pins between two steps.

use super::Simulation;
use crate::number::Real;
use crate::system::Columns;

impl<R: Real> Simulation<R> {
    /// Puts guided particles at their places for the current time, pins those of guides that begin
    /// and frees those of guides that have ended.
    pub(super) fn follow_guides(&mut self) {
        let time = self.time();
        if self.model.guides.0.is_empty() {
            return;
        }
        if self.model.hold(time, self.settings.step) {
            self.model.renew_masses();
            self.scratch.warm = false;
        }
        let Columns { positions, velocities } = &mut self.state;
        self.model.place(time, [positions, velocities]);
    }

    /// Whether a pin ended in the last step: the limit of stability may be another.
    pub fn has_freed_pins(&self) -> bool {
        self.model.guides.has_ended(self.time(), self.settings.step)
    }
}
