//! Acts of a session upon its past: looking back, going on from there, undo and redo.

use super::{Before, Deed, Mark, MarkKind};
use crate::session::Session;
use crate::session::recording::now;
use msd_run::recording::Event;
use msd_run::{Moment, Runner, on};

/// Looking back.
impl Session {
    /// Pauses and shows the state so many steps before the latest one. What comes after it is kept
    /// until the run goes on, or is changed, from there.
    pub fn look_back(&mut self, back: usize) {
        self.paused = true;
        if self.is_holding() {
            self.release();
        }
        let ahead = self.timeline.ahead();
        let back = back.min(ahead + self.history.len());
        let mut moment = self.runner().moment();
        for _ in ahead..back {
            let Some(earlier) = self.history.pop() else { break };
            self.timeline.future.push(std::mem::replace(&mut moment, earlier));
        }
        for _ in back..ahead {
            let Some(later) = self.timeline.future.pop() else { break };
            self.history.push(std::mem::replace(&mut moment, later));
        }
        let shown = self.return_to(&moment);
        self.watch.change(self.run.runner());
        self.refusal = shown.err().map(|error| error.to_string());
        self.failure = None;
        self.restart_twin();
        self.energy.rewind(self.runner().time());
    }

    /// Goes on from the state that is shown: what came after it is dropped, from the recording too.
    pub(in crate::session) fn settle(&mut self) {
        let ahead = self.timeline.ahead();
        if ahead == 0 {
            return;
        }
        for _ in 0..ahead {
            let recorded = self.recording.back(|| now(&self.loaded, self.run.runner()));
            self.refuse(recorded);
        }
        if self.runner().is_automatic() {
            self.record(&Event::Settings(self.runner().settings()));
        }
        let runner = self.run.runner();
        self.timeline.drop_after(runner.steps(), runner.contacts().count);
    }

    /// How many states come after the one that is shown, while one looks back.
    pub fn steps_ahead(&self) -> usize {
        self.timeline.ahead()
    }

    /// The states that one can look back and ahead to, every so many of them up to the last, oldest
    /// first.
    pub fn states(&self, every: usize) -> Vec<Moment> {
        let (back, ahead) = (self.history.len(), self.timeline.ahead());
        let state = |place: usize| match place.checked_sub(back) {
            None => self.history.nth_back(back - place).cloned(),
            Some(0) => Some(self.runner().moment()),
            Some(later) => self.timeline.future.get(ahead - later).cloned(),
        };
        let last = back + ahead;
        (last % every..=last).step_by(every).filter_map(state).collect()
    }

    /// What happened along the last states, oldest first.
    pub fn marks(&self) -> impl Iterator<Item = Mark> + '_ {
        self.timeline.marks()
    }
}

/// Undo.
impl Session {
    /// Takes note of what the user's hands do in a frame, before [`Session::advance`]: whether a
    /// pointer is pressed, and whether a pointer, a key or a text is held. What is edited from one
    /// press to its release is one edit to undo.
    pub fn follow_hands(&mut self, presses: bool, holds: bool) {
        self.undo.follow(presses, holds);
    }

    /// Keeps what is now, to be undone, unless what is about to be done goes on with the last edit;
    /// returns whether it was kept. To be called before anything that is to be undone.
    pub(in crate::session) fn remember(&mut self, deed: Deed) -> bool {
        self.settle();
        self.timeline.mark(self.runner().steps(), MarkKind::Edit);
        let begins = self.undo.begins(deed);
        if begins {
            let now = (self.run.runner(), &self.material);
            self.undo.keep(Before::new(deed, now));
        }
        begins
    }

    /// Undoes the last edit, pin, cut, freeze, wind or change of the solver: what was set is as it
    /// was before, and the motion goes on.
    pub fn undo(&mut self) {
        self.turn(true);
    }

    /// Does again what was undone last.
    pub fn redo(&mut self) {
        self.turn(false);
    }

    fn turn(&mut self, is_undo: bool) {
        self.release();
        self.settle();
        let now = (self.run.runner(), &self.material);
        let Some(before) = self.undo.turn(is_undo, now) else { return };
        let (runner, material) = match before.restored(now) {
            Ok(restored) => restored,
            Err(error) => return self.refusal = Some(error.to_string()),
        };
        let has_planes =
            |runner: &Runner| on!(runner, simulation => !simulation.model().planes().is_empty());
        let is_floored = !has_planes(self.run.runner()) && has_planes(&runner);
        self.material = material;
        self.change(|now| *now = runner);
        if is_floored {
            self.lift();
        }
        self.limit_of = self.runner().steps();
        self.record_start();
        self.follow_wind();
        self.blow();
        self.timeline.mark(self.runner().steps(), MarkKind::Edit);
        self.timeline.recount(self.runner().contacts().count);
        self.restart_twin();
    }

    /// What would be undone.
    pub fn undoes(&self) -> Option<Deed> {
        self.undo.last()
    }

    /// What would be done again.
    pub fn redoes(&self) -> Option<Deed> {
        self.undo.next()
    }
}
