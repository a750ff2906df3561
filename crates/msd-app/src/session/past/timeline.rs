//! The timeline: the states after the shown one, and marks.

use msd_run::Moment;
use std::collections::VecDeque;

/// Largest number of marks.
const MOST_MARKS: usize = 1000;

/// Kind of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// First contact with an obstacle after a step without contact.
    Impact,
    /// A finding of the watch, or a run that stopped by itself.
    Warning,
    /// An edit, a pin or a cut.
    Edit,
}

/// An event after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Number of steps before it.
    pub step: u64,
    /// Kind of the event.
    pub kind: MarkKind,
}

/// Later states than the shown one, and events along the run.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The states after the shown one, the next one last; empty unless the user looks back.
    pub(in crate::session) future: Vec<Moment>,
    marks: VecDeque<Mark>,
    contacts: u64,
    touched: bool,
    findings: usize,
}

impl Timeline {
    /// Returns the marks, oldest first.
    pub fn marks(&self) -> impl Iterator<Item = Mark> + '_ {
        self.marks.iter().copied()
    }

    /// Returns the number of states after the shown one.
    pub fn ahead(&self) -> usize {
        self.future.len()
    }

    /// Adds a mark after a number of steps, unless the last one is equal.
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

    /// Adds marks for the contacts and findings of a step; both arguments are totals of the run.
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

    /// Drops states and marks after a step, where the run resumes, and sets the count of contacts.
    pub(in crate::session) fn drop_after(&mut self, step: u64, contacts: u64) {
        self.future.clear();
        self.marks.retain(|mark| mark.step <= step);
        self.contacts = contacts;
    }

    /// Sets the count of contacts to that of another run, which replaced the previous one.
    pub(in crate::session) fn recount(&mut self, contacts: u64) {
        self.contacts = contacts;
    }

    /// Drops everything, as at a restart.
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
