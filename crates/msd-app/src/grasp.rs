//! What does the mouse do to a particle: hold, throw, pin?

use crate::hand::Hold;
use crate::session::Session;
use glam::DVec3;
use msd_core::{Interaction, Vector};
use msd_run::on;

/// Part of the way to the hand that a pin moves in one step.
const PIN_PULL: f64 = 0.25;

impl Session {
    /// Takes a particle with the mouse.
    pub fn grab(&mut self, particle: usize, target: DVec3) {
        self.release();
        let hold = on!(&self.runner, simulation => Hold::on(simulation.model(), particle, target));
        if self.act(hold.interaction()) {
            self.hold = Some(hold);
            self.selected = Some(particle);
        }
    }

    /// Moves the hand.
    pub fn move_grab(&mut self, target: DVec3) {
        let Some(mut hold) = self.hold else { return };
        hold.target = target;
        if self.act(hold.interaction()) {
            self.hold = Some(hold);
        }
    }

    /// Where the hand is, metres; nowhere while it is open.
    pub fn hold_target(&self) -> Option<DVec3> {
        self.hold.map(|hold| hold.target)
    }

    /// Opens the hand; what it held keeps its velocity.
    pub fn release(&mut self) {
        let Some(hold) = self.hold.take() else { return };
        self.act(Interaction::Release { particle: hold.particle });
        if self.is_pinned(hold.particle) {
            self.act(Interaction::Pin { particle: hold.particle, velocity: DVec3::ZERO });
        }
    }

    /// Opens the hand and selects nothing.
    pub fn deselect(&mut self) {
        self.release();
        self.selected = None;
    }

    /// Pins a free particle where it is, or frees a pinned one.
    pub fn pin_toggle(&mut self, particle: usize) {
        if self.is_pinned(particle) {
            self.act(Interaction::Unpin { particle });
        } else {
            if self.held() == Some(particle) {
                self.release();
            }
            self.act(Interaction::Pin { particle, velocity: DVec3::ZERO });
        }
        self.selected = Some(particle);
        self.touch();
    }

    /// Whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        on!(&self.runner, simulation => simulation.model().is_pinned(particle))
    }

    /// Where a particle is, metres.
    pub fn position(&self, particle: usize) -> DVec3 {
        on!(&self.runner, simulation => simulation.position(particle).to_f64())
    }

    /// No force moves a pin, so the hand gives it a velocity.
    pub(crate) fn move_held_pin(&mut self) {
        let Some(Hold { particle, target, .. }) = self.hold else { return };
        if self.is_pinned(particle) {
            let way = target - self.position(particle);
            let velocity = way * (PIN_PULL / self.runner.settings().step);
            self.act(Interaction::Pin { particle, velocity });
        }
    }
}
