//! The timeline: the states after the one that is shown, while one looks back, and marks.

use msd_run::Moment;
use std::collections::VecDeque;

/// The most marks.
const MOST_MARKS: usize = 1000;

/// What a mark stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// Something touched an obstacle that nothing had touched in the step before.
    Impact,
    /// The watch found something, or the run stopped by itself.
    Warning,
    /// Something was set, pinned or cut.
    Edit,
}

/// Something that happened after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Steps taken when it happened.
    pub step: u64,
    /// What happened.
    pub kind: MarkKind,
}

/// What lies after the state that is shown, and what happened along the run.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The states after the present one, the next one last; empty unless one looks back.
    pub(in crate::session) future: Vec<Moment>,
    marks: VecDeque<Mark>,
    contacts: u64,
    touched: bool,
    findings: usize,
}

impl Timeline {
    /// The marks, oldest first.
    pub fn marks(&self) -> impl Iterator<Item = Mark> + '_ {
        self.marks.iter().copied()
    }

    /// How many states come after the one that is shown.
    pub fn ahead(&self) -> usize {
        self.future.len()
    }

    /// Marks something after so many steps, once.
    pub(in crate::session) fn mark(&mut self, step: u64, kind: MarkKind) {
        let mark = Mark { step, kind };
        if self.marks.back() == Some(&mark) {
            return;
        }
        self.marks.push_back(mark);
        if MOST_MARKS < self.marks.len() {
            self.marks.pop_front();
        }
    }

    /// Looks at a run after a step: contacts and findings so far.
    pub(in crate::session) fn look(&mut self, step: u64, contacts: u64, findings: usize) {
        let touches = self.contacts < contacts;
        if touches && !self.touched {
            self.mark(step, MarkKind::Impact);
        }
        if self.findings < findings {
            self.mark(step, MarkKind::Warning);
        }
        (self.contacts, self.touched, self.findings) = (contacts, touches, findings);
    }

    /// Forgets what came after a step: the run goes on from there. Contacts are counted on.
    pub(in crate::session) fn drop_after(&mut self, step: u64, contacts: u64) {
        self.future.clear();
        self.marks.retain(|mark| mark.step <= step);
        self.contacts = contacts;
    }

    /// Counts contacts from so many on: the run was replaced by one that counted others.
    pub(in crate::session) fn recount(&mut self, contacts: u64) {
        self.contacts = contacts;
    }

    /// Forgets everything, as at a restart.
    pub(in crate::session) fn clear(&mut self) {
        *self = Timeline::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_is_marked_where_contact_begins() {
        let mut timeline = Timeline::default();
        for (step, contacts) in [(1, 0), (2, 3), (3, 5), (4, 5), (5, 6)] {
            timeline.look(step, contacts, 0);
        }
        let steps: Vec<u64> = timeline.marks().map(|mark| mark.step).collect();
        assert_eq!(steps, [2, 5]);
    }

    #[test]
    fn what_was_dropped_has_no_marks() {
        let mut timeline = Timeline::default();
        [3, 7, 9].into_iter().for_each(|step| timeline.mark(step, MarkKind::Edit));
        timeline.mark(9, MarkKind::Edit);
        timeline.drop_after(7, 0);
        assert_eq!(timeline.marks().count(), 2);
    }
}
