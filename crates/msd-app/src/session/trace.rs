//! Energy samples of the last seconds, for the plot.

use msd_core::Energy;
use std::collections::VecDeque;

/// How far back the plot looks, simulated seconds.
pub const WINDOW: f64 = 12.0;
/// The most samples in the window: about one per pixel of the plot.
const SAMPLES: f64 = 400.0;

/// Energy at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Simulated time, seconds.
    pub time: f64,
    /// The energy then, joules.
    pub energy: Energy,
}

/// A ring of energy samples, thinned to what a plot can show.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    samples: VecDeque<Sample>,
}

impl Trace {
    /// Whether a sample at this time would be far enough from the last one.
    pub fn is_due(&self, time: f64) -> bool {
        self.samples.back().is_none_or(|last| WINDOW / SAMPLES <= time - last.time)
    }

    /// Adds a sample, in place of one of the same time, and forgets those that left the window.
    pub fn push(&mut self, time: f64, energy: Energy) {
        if self.samples.back().is_some_and(|last| last.time == time) {
            self.samples.pop_back();
        }
        self.samples.push_back(Sample { time, energy });
        while self.samples.front().is_some_and(|first| first.time < time - WINDOW) {
            self.samples.pop_front();
        }
    }

    /// Forgets the samples after a time, as when a step is taken back.
    pub fn rewind(&mut self, time: f64) {
        while self.samples.back().is_some_and(|last| time < last.time) {
            self.samples.pop_back();
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The samples, oldest first.
    pub fn samples(&self) -> impl ExactSizeIterator<Item = &Sample> + Clone {
        self.samples.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_keeps_a_bounded_number_of_samples() {
        let mut trace = Trace::default();
        for step in 0..20_000 {
            let time = f64::from(step) / 600.0;
            if trace.is_due(time) {
                trace.push(time, Energy::default());
            }
        }
        let count = trace.samples().len();
        assert!((SAMPLES as usize * 9 / 10..=SAMPLES as usize + 1).contains(&count), "{count}");
    }

    #[test]
    fn a_change_while_time_stands_still_adds_no_sample() {
        let mut trace = Trace::default();
        (0..5).for_each(|_| trace.push(1.0, Energy::default()));
        assert_eq!(trace.samples().len(), 1);
    }

    #[test]
    fn rewinding_forgets_the_future() {
        let mut trace = Trace::default();
        (0..5).for_each(|second| trace.push(f64::from(second), Energy::default()));
        trace.rewind(2.5);
        assert_eq!(trace.samples().last().map(|last| last.time), Some(2.0));
        assert!(trace.is_due(2.6) && !trace.is_due(2.01));
    }
}
