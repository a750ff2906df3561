//! A throttle for expensive readings: they take a bounded share of steps and wall clock.

/// Largest share of the time of steps for readings.
const OF_STEPS: f64 = 0.03;
/// Largest share of the wall clock, if that is more: a light scene has time to spare.
const OF_CLOCK: f64 = 0.005;

/// A budget that grows with time until it covers a reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Throttle {
    saved: f64,
    /// Costs of the last two readings, seconds.
    costs: [f64; 2],
}

impl Throttle {
    /// Adds the share of `real` seconds of wall clock, `spent` of them on steps.
    pub fn save(&mut self, real: f64, spent: f64) {
        self.saved += (OF_STEPS * spent).max(OF_CLOCK * real.max(0.0));
    }

    /// Returns whether the budget covers the lower of the last two costs: the machine may have been
    /// busy during one of them.
    pub fn is_enough(&self) -> bool {
        self.costs[0].min(self.costs[1]) <= self.saved
    }

    /// Runs `act` and measures its cost; `stopwatch` gives seconds.
    pub fn spend<T>(&mut self, stopwatch: &impl Fn() -> f64, act: impl FnOnce() -> T) -> T {
        let start = stopwatch();
        let result = act();
        *self = Throttle { saved: 0.0, costs: [self.costs[1], stopwatch() - start] };
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Returns the number of frames, of 6000 of 1/60 s with steps of `spent` seconds, with an
    /// action of `cost` seconds.
    fn done(spent: f64, cost: f64) -> u32 {
        let (mut throttle, now, mut done) = (Throttle::default(), Cell::new(0.0), 0);
        for _ in 0..6000 {
            throttle.save(1.0 / 60.0, spent);
            if throttle.is_enough() {
                throttle.spend(&|| now.get(), || now.set(now.get() + cost));
                done += 1;
            }
        }
        done
    }

    #[test]
    fn what_is_dear_takes_its_share_and_no_more() {
        // 6000 frames save 6000 · 0.03 · 8 ms = 1.44 s: 144 times 10 ms.
        let times = done(8e-3, 10e-3);
        assert!((140..=146).contains(&times), "{times}");
    }

    #[test]
    fn a_single_time_that_took_long_is_not_waited_for() {
        let mut throttle = Throttle::default();
        for cost in [1e-3, 1e-3, 9.0] {
            let now = Cell::new(0.0);
            throttle.spend(&|| now.get(), || now.set(cost));
        }
        throttle.save(1.0, 1.0);
        assert!(throttle.is_enough());
    }

    #[test]
    fn what_is_cheap_beside_the_clock_is_done_in_every_frame() {
        assert_eq!(done(1e-5, 0.005 / 60.0 * 0.99), 6000);
    }
}
