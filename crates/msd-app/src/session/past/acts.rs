//! Looking back, resuming from an earlier state, undo and redo.

use super::{Before, Deed, Mark, MarkKind};
use crate::session::Session;
use crate::session::recording::now;
use msd_run::recording::Event;
use msd_run::{Moment, Runner, on};

/// Looking back.
impl Session {
    /// Pauses and shows the state `back` steps before the latest one. Later states stay until the
    /// run resumes, or is changed, from there.
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

    /// Makes the shown state the latest one, and drops later states, also from the recording.
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

    /// Returns the number of states after the shown one.
    pub fn steps_ahead(&self) -> usize {
        self.timeline.ahead()
    }

    /// Returns every `every`-th state of the timeline and the last one, oldest first, for looking
    /// back and ahead.
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

    /// Returns the events along the recent states, oldest first.
    pub fn marks(&self) -> impl Iterator<Item = Mark> + '_ {
        self.timeline.marks()
    }
}

/// Undo.
impl Session {
    /// Notes the user input of a frame, before [`Session::advance`]. `presses`: a button was
    /// pressed; `holds`: a button or key is down, or a text field has the focus. Edits from a press
    /// to its release are a single undo step.
    pub(crate) fn follow_hands(&mut self, presses: bool, holds: bool) {
        self.undo.follow(presses, holds);
    }

    /// Keeps the current model for undo, unless the next edit continues the last one; returns
    /// whether it was kept. Call it before each undoable edit.
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

    /// Undoes the last edit, pin, cut, freeze, wind or change of the solver. The previous values
    /// return, and the motion goes on.
    pub fn undo(&mut self) {
        self.turn(true);
    }

    /// Redoes the edit that was undone last.
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

    /// Returns the edit that undo would revert.
    pub fn undoes(&self) -> Option<Deed> {
        self.undo.last()
    }

    /// Returns the edit that redo would repeat.
    pub fn redoes(&self) -> Option<Deed> {
        self.undo.next()
    }
}
