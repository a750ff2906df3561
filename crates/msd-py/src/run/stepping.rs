//! Many steps, in turns between which Python may interrupt them.

use msd_core::Error;
use msd_run::Runner;
use std::time::{Duration, Instant};

/// Longest time between two interrupts, seconds.
pub const TURN: Duration = Duration::from_millis(40);
/// Least time between two readings of the clock, each of which costs as much as a few springs.
const LOOK: Duration = Duration::from_micros(200);

/// Takes up to `left` steps within a turn; returns the number of remaining steps.
///
/// # Errors
/// See [`Runner::step`].
pub fn turn(runner: &mut Runner, left: u64) -> Result<u64, Error> {
    let (start, mut left, mut batch) = (Instant::now(), left, 1);
    let mut looked = start;
    while 0 < left {
        let steps = left.min(batch);
        for _ in 0..steps {
            runner.step()?;
        }
        left -= steps;
        let now = Instant::now();
        if TURN < now - start {
            break;
        }
        if now - looked < LOOK {
            batch *= 2;
        } else {
            batch = (batch / 2).max(1);
        }
        looked = now;
    }
    Ok(left)
}

/// Returns the number of steps nearest to a time, at least one unless the time is 0.
///
/// # Errors
/// A message with the valid range of the seconds.
pub fn steps_in(seconds: f64, step: f64) -> Result<u64, String> {
    /// As on the command line: weeks on any machine.
    const MOST: f64 = 1e10;
    let steps = (seconds / step).round();
    if !(0.0 <= seconds && steps <= MOST) {
        let must = format!("at least 0 and at most {MOST:e} steps of {step} s");
        return Err(format!("seconds is {seconds}; it must be {must}"));
    }
    Ok(if 0.0 < seconds { steps.max(1.0) as u64 } else { 0 })
}
