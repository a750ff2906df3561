//! A fixed-step clock: the steps due in a frame, and averages of pace and cost.

use super::run::Revision;
use std::collections::VecDeque;

/// Largest debt of simulated time, seconds. The clock drops the rest, as after a long pause of the
/// machine, instead of catching up.
const LARGEST_DEBT: f64 = 0.25;

/// Largest wall-clock time that one frame may spend on steps, seconds. In a browser they share
/// their thread with the whole page, which should respond within 50 ms.
///
/// The number of steps alone would not do. If a step costs more than it simulates, catching up
/// would increase the debt with each frame.
pub const BUDGET: f64 = if cfg!(target_arch = "wasm32") { 1.0 / 60.0 } else { 1.0 / 30.0 };

/// Span of the averages of the status line, seconds.
const AVERAGED: f64 = 1.0;

/// Time for which the status line shows dropped time, seconds.
const SHOWN: f64 = 4.0;

/// Counts and times of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Wall-clock time since the previous frame, seconds.
    pub real: f64,
    /// Steps taken.
    pub steps: u32,
    /// Simulated time of those steps, seconds.
    pub simulated: f64,
    /// Wall-clock time of those steps, seconds.
    pub spent: f64,
    /// Dropped simulated time, seconds.
    pub dropped: f64,
}

/// A frame in progress.
#[derive(Clone, Copy, Debug)]
pub struct OpenFrame {
    frame: Frame,
    /// Whether it is the first frame after a pause.
    fresh: bool,
    /// Length of a step, seconds.
    step: f64,
    /// Stopwatch at the beginning of the frame, seconds.
    start: f64,
}

/// Averages over recent frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Simulated seconds per second of wall clock.
    pub real_time_factor: f64,
    /// Steps per frame.
    pub steps_per_frame: f64,
    /// Wall-clock time of a step, milliseconds; 0 without steps.
    pub step_ms: f64,
    /// Frames per second.
    pub frame_rate: f64,
    /// Recently dropped simulated time, seconds.
    pub dropped: f64,
}

/// A fixed-step clock: turns wall-clock time into whole steps and never into a longer step.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Simulated seconds per second, 1 for real time; infinite for as fast as possible.
    speed: f64,
    /// Simulated time that is due but not stepped yet, seconds.
    owed: f64,
    /// Whether the next frame follows a pause, whose time the clock does not catch up with.
    fresh: bool,
    /// Frames of one revision of the run: the cost of a step before a change is no longer valid.
    frames: VecDeque<Frame>,
    revision: Revision,
}

impl Default for Clock {
    fn default() -> Self {
        Clock {
            speed: 1.0,
            owed: 0.0,
            fresh: true,
            frames: VecDeque::new(),
            revision: Revision::default(),
        }
    }
}

impl Clock {
    /// Returns the target speed, simulated seconds per second of wall clock.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Sets the speed of simulated time, not the length of a step.
    pub fn set_speed(&mut self, speed: f64) {
        self.speed = speed;
        self.resume();
    }

    /// Ignores the time up to the next frame: it was a pause.
    pub fn resume(&mut self) {
        self.fresh = true;
        self.owed = 0.0;
        self.frames.clear();
    }

    /// Begins a frame, `real` seconds of wall clock after the previous one.
    ///
    /// `step` is the length of a step in seconds; `stopwatch` gives the seconds spent in this
    /// frame. Call [`Clock::takes_step`] until it returns false, then [`Clock::end`].
    pub fn begin(&mut self, real: f64, step: f64, stopwatch: &impl Fn() -> f64) -> OpenFrame {
        let fresh = std::mem::take(&mut self.fresh);
        let is_bounded = self.speed.is_finite();
        self.owed += match fresh {
            true => 0.0,
            false if is_bounded => real.max(0.0) * self.speed,
            // Only the budget ends the frame.
            false => f64::INFINITY,
        };
        // After the scaling: a limit on wall-clock time alone would allow bursts at high speeds. A
        // step longer than the limit must still become due.
        let largest = LARGEST_DEBT.max(2.0 * step);
        let dropped = if is_bounded { (self.owed - largest).max(0.0) } else { 0.0 };
        self.owed -= dropped;
        OpenFrame {
            frame: Frame { real, dropped, ..Frame::default() },
            fresh,
            step,
            start: stopwatch(),
        }
    }

    /// Returns whether another step is due and within the budget, and takes it off the debt.
    pub(crate) fn takes_step(
        &mut self,
        open: &mut OpenFrame,
        stopwatch: &impl Fn() -> f64,
    ) -> bool {
        let step = open.step;
        if self.owed < step {
            return false;
        }
        if BUDGET <= stopwatch() - open.start {
            if self.owed == f64::INFINITY {
                self.owed = 0.0;
                return false;
            }
            let late = (self.owed / step).floor() * step;
            self.owed -= late;
            open.frame.dropped += late;
            return false;
        }
        self.owed -= step;
        true
    }

    /// Ends a frame with its number of steps and the revision of the run.
    pub fn end(
        &mut self,
        open: OpenFrame,
        (steps, revision): (u32, Revision),
        stopwatch: &impl Fn() -> f64,
    ) -> Frame {
        let OpenFrame { mut frame, fresh, step, start } = open;
        frame.steps = steps;
        frame.spent = stopwatch() - start;
        frame.simulated = f64::from(steps) * step;
        if self.revision != revision {
            self.frames.clear();
            self.revision = revision;
        }
        // The time before a first frame does not belong to the averages.
        if !fresh {
            self.frames.push_back(frame);
            let mut span: f64 = self.frames.iter().map(|frame| frame.real).sum();
            while SHOWN < span && 1 < self.frames.len() {
                span -= self.frames.pop_front().map_or(0.0, |frame| frame.real);
            }
        }
        frame
    }

    /// Returns averages over about the last second, and dropped time over the last four; `None`
    /// before the first frame of this revision of the run.
    pub fn pace(&self, revision: Revision) -> Option<Pace> {
        if self.revision != revision || self.frames.is_empty() {
            return None;
        }
        let (mut sum, mut count) = (Frame::default(), 0.0);
        for frame in self.frames.iter().rev() {
            count += 1.0;
            sum.real += frame.real;
            sum.steps += frame.steps;
            sum.simulated += frame.simulated;
            sum.spent += frame.spent;
            if AVERAGED <= sum.real {
                break;
            }
        }
        let per = |value: f64, of: f64| if of == 0.0 { 0.0 } else { value / of };
        let steps = f64::from(sum.steps);
        Some(Pace {
            real_time_factor: per(sum.simulated, sum.real),
            steps_per_frame: per(steps, count),
            step_ms: per(sum.spent * 1e3, steps),
            frame_rate: per(count, sum.real),
            dropped: self.frames.iter().map(|frame| frame.dropped).sum(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    const STEP: f64 = 1.0 / 60.0;

    /// Runs frames of `real` seconds with steps that cost `cost` seconds each.
    fn run(clock: &mut Clock, frames: usize, real: f64, cost: f64) -> u32 {
        let now = Cell::new(0.0);
        let stopwatch = || now.get();
        let frame = |clock: &mut Clock| {
            let (mut open, mut steps) = (clock.begin(real, STEP, &stopwatch), 0);
            while clock.takes_step(&mut open, &stopwatch) {
                now.set(now.get() + cost);
                steps += 1;
            }
            clock.end(open, (steps, Revision::default()), &stopwatch).steps
        };
        (0..frames).map(|_| frame(clock)).sum()
    }

    fn pace(clock: &Clock) -> Option<Pace> {
        clock.pace(Revision::default())
    }

    fn known(clock: &Clock) -> Pace {
        pace(clock).expect("frames were measured")
    }

    fn started() -> Clock {
        let mut clock = Clock::default();
        run(&mut clock, 1, 5.0, 0.0);
        clock
    }

    #[test]
    fn steps_follow_the_wall_clock_whatever_the_frame_rate() {
        for rate in [24.0, 60.0, 144.0] {
            let steps = run(&mut started(), rate as usize * 10, 1.0 / rate, 0.0);
            // Whole steps only: the last one may still be due.
            assert!((599..=600).contains(&steps), "{steps} steps at {rate} frames per second");
        }
    }

    #[test]
    fn the_first_frame_owes_nothing() {
        let mut clock = Clock::default();
        assert_eq!(run(&mut clock, 1, 3600.0, 0.0), 0);
        assert_eq!(pace(&clock), None);
    }

    #[test]
    fn slow_motion_takes_fewer_steps() {
        let mut clock = started();
        clock.set_speed(0.1);
        run(&mut clock, 1, STEP, 0.0);
        let steps = run(&mut clock, 600, STEP, 0.0);
        assert!((59..=60).contains(&steps), "{steps}");
        assert!((known(&clock).real_time_factor - 0.1).abs() < 0.02);
    }

    #[test]
    fn the_highest_speed_takes_what_the_budget_gives_and_drops_nothing() {
        let mut clock = started();
        clock.set_speed(f64::INFINITY);
        run(&mut clock, 1, STEP, 0.001);
        let steps = run(&mut clock, 100, 0.04, 0.001);
        // A step of 1 ms: all that begin within the budget.
        let most = (BUDGET / 0.001).ceil() as u32;
        assert!((most..=most + 1).contains(&(steps / 100)), "{steps}");
        assert_eq!(known(&clock).dropped, 0.0);
        clock.set_speed(1.0);
        run(&mut clock, 1, STEP, 0.0);
        assert!(run(&mut clock, 60, STEP, 0.0) <= 60, "nothing is owed from before");
    }

    #[test]
    fn a_pause_of_the_machine_is_dropped_and_said() {
        let mut clock = started();
        run(&mut clock, 60, STEP, 0.0);
        let steps = run(&mut clock, 1, 1.05, 0.0);
        assert!(steps <= 15, "{steps} steps burst out of a pause");
        assert!((known(&clock).dropped - 0.8).abs() < 0.02);
        assert!(known(&clock).real_time_factor < 0.5);
        run(&mut clock, 300, STEP, 0.0);
        assert_eq!(known(&clock).dropped, 0.0);
    }

    #[test]
    fn steps_that_cost_more_than_they_simulate_do_not_spiral() {
        let mut clock = started();
        // A step of 1/60 s takes 1/20 s: a third of real time at best, one step per frame.
        let steps = run(&mut clock, 100, 0.05, 0.05);
        assert!((95..=100).contains(&steps), "{steps}");
        let pace = known(&clock);
        assert!((pace.real_time_factor - 1.0 / 3.0).abs() < 0.03);
        assert!((pace.step_ms - 50.0).abs() < 1e-6);
        assert!(0.0 < pace.dropped);
    }
}
