//! States that a run can step back to.

use crate::runner::Moment;
use msd_core::{Real, State};
use msd_scene::AnyState;
use std::collections::VecDeque;

/// The most states kept: ten seconds at 60 steps per second.
const MOST_STATES: usize = 600;
/// The most memory for them, bytes.
const MOST_BYTES: usize = 256 << 20;

fn bytes_of(moment: &Moment) -> usize {
    let state = match &moment.state {
        AnyState::F32(state) => bytes(state),
        AnyState::F64(state) => bytes(state),
    };
    state + size_of_val(&*moment.impulses)
}

fn bytes<R: Real>(state: &State<R>) -> usize {
    size_of_val(&*state.positions) + size_of_val(&*state.velocities)
}

/// The last states, as many as fit. A step back is a return to one, never a negative step.
#[derive(Clone, Debug, Default)]
pub struct History {
    moments: VecDeque<Moment>,
    bytes: usize,
}

impl History {
    /// Keeps a state, and forgets the oldest ones beyond the caps.
    pub fn push(&mut self, moment: Moment) {
        self.bytes += bytes_of(&moment);
        self.moments.push_back(moment);
        while MOST_STATES < self.moments.len() || MOST_BYTES < self.bytes {
            let Some(oldest) = self.moments.pop_front() else { return };
            self.bytes -= bytes_of(&oldest);
        }
    }

    /// Forgets the oldest states beyond so many.
    pub fn keep(&mut self, most: usize) {
        while most < self.moments.len() {
            let Some(oldest) = self.moments.pop_front() else { return };
            self.bytes -= bytes_of(&oldest);
        }
    }

    /// Takes out the latest state.
    pub fn pop(&mut self) -> Option<Moment> {
        let latest = self.moments.pop_back()?;
        self.bytes -= bytes_of(&latest);
        Some(latest)
    }

    /// The state of so many steps before the current one, at least 1.
    pub fn nth_back(&self, steps: usize) -> Option<&Moment> {
        self.moments.len().checked_sub(steps).and_then(|at| self.moments.get(at))
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = History::default();
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.moments.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.moments.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Ledger;
    use msd_core::glam::DVec3;

    fn moment(particles: usize, steps: u64) -> Moment {
        let column = vec![DVec3::ZERO; particles];
        let state = AnyState::F64(State { positions: column.clone(), velocities: column });
        Moment { state, steps, ledger: Ledger::default(), substeps: 8, impulses: Vec::new() }
    }

    #[test]
    fn the_number_of_states_is_capped() {
        let mut history = History::default();
        (0..1000).for_each(|steps| history.push(moment(1, steps)));
        assert_eq!(history.len(), MOST_STATES);
        let at = |back| history.nth_back(back).map(|moment| moment.steps);
        assert_eq!([at(0), at(1), at(MOST_STATES)], [None, Some(999), Some(400)]);
        assert_eq!(history.pop().map(|latest| latest.steps), Some(999));
        history.keep(3);
        let at = |back| history.nth_back(back).map(|moment| moment.steps);
        assert_eq!([at(1), at(3), at(4)], [Some(998), Some(996), None]);
    }

    #[test]
    fn the_memory_is_capped() {
        let mut history = History::default();
        // 2^20 particles of 48 bytes: five of them fit into 256 MiB.
        (0..9).for_each(|steps| history.push(moment(1 << 20, steps)));
        assert_eq!(history.len(), 5);
    }

    #[test]
    fn an_empty_history_gives_nothing() {
        let mut history = History::default();
        history.push(moment(3, 0));
        assert!(history.pop().is_some() && history.pop().is_none() && history.is_empty());
        assert_eq!(history.bytes, 0);
    }
}
