//! Energy samples of the last seconds, for the plot.

use msd_core::Energy;
use std::collections::VecDeque;

/// Span of the plot, simulated seconds.
pub const WINDOW: f64 = 12.0;
/// Largest number of samples in the window: about one per pixel of the plot.
const SAMPLES: f64 = 400.0;

/// Energy at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Simulated time, seconds.
    pub time: f64,
    /// Energy at that time, joules.
    pub energy: Energy,
}

/// Least ratio of a peak to the last one, so that few peaks are kept.
const HIGHER: f64 = 1.01;

/// A ring buffer of energy samples, at the resolution of a plot.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    samples: VecDeque<Sample>,
    /// Times of new maxima of the plotted energy, and their values, joules.
    peaks: Vec<(f64, f64)>,
}

impl Trace {
    /// Returns whether a sample at this time would be far enough from the last one.
    pub fn is_due(&self, time: f64) -> bool {
        self.samples.back().is_none_or(|last| WINDOW / SAMPLES <= time - last.time)
    }

    /// Adds a sample, replaces one of the same time, and drops those before the window.
    pub fn push(&mut self, time: f64, energy: Energy) {
        if self.samples.back().is_some_and(|last| last.time == time) {
            self.samples.pop_back();
        }
        self.samples.push_back(Sample { time, energy });
        while self.samples.front().is_some_and(|first| first.time < time - WINDOW) {
            self.samples.pop_front();
        }
        let held = self.held(energy).total();
        if HIGHER * self.most() < held {
            self.peaks.push((time, held));
        }
    }

    /// Returns the plotted part of an energy: gravity above its minimum, dissipation since the
    /// start of the window, and no custom elements.
    pub fn held(&self, energy: Energy) -> Energy {
        let samples = || self.samples.iter().map(|sample| sample.energy);
        let lowest = samples().map(|then| then.gravitational).fold(energy.gravitational, f64::min);
        let before = samples().map(|then| then.dissipated).fold(energy.dissipated, f64::min);
        Energy {
            gravitational: energy.gravitational - lowest,
            dissipated: energy.dissipated - before,
            own: 0.0,
            supplied: 0.0,
            ..energy
        }
    }

    /// Returns the maximum of the plotted energy since the start of the run, to within a hundredth,
    /// joules; 0 before any motion.
    pub fn most(&self) -> f64 {
        self.peaks.last().map_or(0.0, |&(_, held)| held)
    }

    /// Drops the samples after a time, as when a step is taken back.
    pub fn rewind(&mut self, time: f64) {
        while self.samples.back().is_some_and(|last| time < last.time) {
            self.samples.pop_back();
        }
        while self.peaks.last().is_some_and(|&(last, _)| time < last) {
            self.peaks.pop();
        }
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.peaks.clear();
    }

    /// Returns the samples, oldest first.
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
    fn the_most_there_was_outlives_the_window_and_is_forgotten_by_a_rewind() {
        let kinetic = |joules| Energy { kinetic: joules, ..Energy::default() };
        let mut trace = Trace::default();
        for (time, joules) in [(0.0, 0.0), (1.0, 50.0), (2.0, 8.0), (30.0, 1e-9)] {
            trace.push(time, kinetic(joules));
        }
        assert_eq!(trace.samples().len(), 1);
        assert_eq!(trace.most(), 50.0, "28 s after it left the window");
        trace.push(31.0, kinetic(1e30));
        assert_eq!(trace.most(), 1e30);
        // As when a diverged run is taken back.
        trace.rewind(30.5);
        assert_eq!(trace.most(), 50.0);
        trace.clear();
        assert_eq!(trace.most(), 0.0);
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
