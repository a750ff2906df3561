//! Frame rates: a scene moves the same way at each of them.

use msd_app::session::{BUDGET, Session};
use msd_run::Runner;
use msd_scene::{open, state_hash};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::cell::Cell;

/// Simulated time of the test, seconds.
const LONG: f64 = 6.0;

/// The displayed states of a scene.
struct Shown {
    /// Steps taken and hash of the state, after each frame.
    moments: Vec<(u64, u64)>,
    /// Dropped simulated time, seconds.
    dropped: f64,
}

/// Shows a scene in frames of these lengths, seconds, with steps that take `cost` seconds.
fn show(name: &str, frames: &[f64], cost: f64) -> Shown {
    let mut session = Session::new(open(name).expect(name)).expect("a scene that runs");
    // The first frame after a start takes no steps.
    session.advance(0.0, &|| 0.0);
    let mut shown = Shown { moments: Vec::new(), dropped: 0.0 };
    let asked = Cell::new(0.0);
    for &real in frames {
        // The clock reads the stopwatch before each step and once at the end.
        let stopwatch = || {
            asked.set(asked.get() + 1.0);
            cost * asked.get()
        };
        shown.dropped += session.advance(real, &stopwatch).dropped;
        shown.moments.push((session.runner().steps(), state_hash(&session.runner().state())));
        assert_eq!(session.failure(), None);
    }
    shown
}

/// Returns the hash after each number of steps, from the start on, without a window.
fn hashes(name: &str) -> Vec<u64> {
    let mut runner = Runner::open(&open(name).expect(name)).expect("a scene that runs");
    let steps = (LONG / runner.settings().step).round() as usize + 1;
    let mut hashes = vec![state_hash(&runner.state())];
    hashes.extend((0..steps).map(|_| {
        runner.step().expect("a step");
        state_hash(&runner.state())
    }));
    hashes
}

/// Returns frames of a steady rate for [`LONG`] seconds.
fn steady(rate: f64) -> Vec<f64> {
    vec![1.0 / rate; (LONG * rate).round() as usize]
}

/// Returns random frames, from zero to `longest` seconds, for [`LONG`] seconds.
fn hitching(seed: u64, longest: f64) -> Vec<f64> {
    let mut lot = Pcg32::new(seed, 0);
    let mut left = LONG;
    let mut frames = Vec::new();
    while 0.0 < left {
        let unit = f64::from(lot.next_u32()) / f64::from(u32::MAX);
        // Most frames are short, a few are long.
        let real = (longest * unit * unit * unit).min(left);
        left -= real;
        frames.push(real);
    }
    frames
}

/// Asserts that every displayed state equals the one after the same number of steps.
fn assert_same_way(shown: &Shown, hashes: &[u64], what: &str) {
    for &(steps, hash) in &shown.moments {
        assert_eq!(hash, hashes[steps as usize], "{what} after {steps} steps");
    }
}

/// Asserts that of `all` steps at most the last is missing, by rounding.
fn assert_nothing_lost(shown: &Shown, all: usize, what: &str) {
    let last = shown.moments.last().map_or(0, |moment| moment.0);
    assert!(all - 3 <= last as usize && shown.dropped == 0.0, "{what}: {last} steps");
}

const SCENES: [&str; 2] = ["square", "dice"];

#[test]
fn states_at_equal_simulated_times_are_the_same_at_every_frame_rate() {
    for name in SCENES {
        let hashes = hashes(name);
        for rate in [24.0, 30.0, 60.0, 144.0] {
            let shown = show(name, &steady(rate), 0.0);
            let what = format!("{name} at {rate} Hz");
            assert_same_way(&shown, &hashes, &what);
            assert_nothing_lost(&shown, hashes.len(), &what);
        }
    }
}

#[test]
fn a_hitch_within_the_debt_that_is_allowed_is_caught_up_with() {
    for (seed, name) in (0..).zip(SCENES.repeat(4)) {
        let hashes = hashes(name);
        // A debt of a quarter of a second is allowed, including part of a step from earlier.
        let shown = show(name, &hitching(seed, 0.23), 0.0);
        let what = format!("{name} with hitches of seed {seed}");
        assert_same_way(&shown, &hashes, &what);
        assert_nothing_lost(&shown, hashes.len(), &what);
    }
}

#[test]
fn a_hitch_beyond_it_drops_time_and_changes_no_bit() {
    for (seed, name) in (0..).zip(SCENES.repeat(4)) {
        let shown = show(name, &hitching(seed, 1.5), 0.0);
        assert!(0.25 < shown.dropped, "seed {seed}: {} s dropped", shown.dropped);
        assert_same_way(&shown, &hashes(name), &format!("{name} with pauses of seed {seed}"));
    }
}

#[test]
fn a_machine_that_is_too_slow_drops_time_and_changes_no_bit() {
    for name in SCENES {
        let shown = show(name, &steady(24.0), 0.7 * BUDGET);
        assert!(0.25 < shown.dropped, "{name}: {} s dropped", shown.dropped);
        assert_same_way(&shown, &hashes(name), &format!("{name} on a slow machine"));
    }
}
