//! A live estimate of the error of the run: a finer copy runs for a window, then pauses.

use super::Session;
use super::run::{Revision, Run};
use msd_core::Interaction;
use msd_run::replay::as_felt;
use msd_study::live_error::{Estimator, LiveError};

/// Steps of a window: half a second at 60 steps per second.
pub const WINDOW: u32 = 30;
/// Steps from one window to the next: on average the copy costs three steps per four of the run.
const REST: u32 = 90;
/// The same after a window during which the run fell behind the clock.
const LONG_REST: u32 = 570;

/// Estimates the error of a run in windows of time. A session has one only if the user switches it
/// on.
#[derive(Clone, Debug)]
pub struct LiveErrorMeter {
    estimator: Estimator,
    /// Steps taken in the current window, and steps until the next one opens.
    taken: u32,
    rest: u32,
    /// Interactions since the last step, for the copy.
    pending: Vec<Interaction>,
    /// Whether the run fell behind the clock during this window.
    late: bool,
    last: Option<ErrorReading>,
    /// Whether the copy of the last window failed to reach its end.
    lost: bool,
    /// The revision of the run that these values belong to.
    of: Revision,
}

/// State of the estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorNow<'a> {
    /// No estimate until the current window ends.
    Measuring,
    /// No estimate, as the finer copy of the last window diverged or failed.
    Lost,
    /// Estimate of the last window.
    Known(&'a ErrorReading),
}

/// An estimate and its display values.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorReading {
    /// The estimate.
    pub error: LiveError,
    /// The particle with the largest error, and its error in metres.
    pub worst: (usize, f64),
}

impl Default for LiveErrorMeter {
    fn default() -> Self {
        LiveErrorMeter {
            estimator: Estimator::new(WINDOW, WINDOW),
            taken: 0,
            rest: 0,
            pending: Vec::new(),
            late: false,
            last: None,
            lost: false,
            of: Revision::default(),
        }
    }
}

impl LiveErrorMeter {
    /// Returns the estimate for a run; a change of the run voids an earlier one.
    pub fn now(&self, run: &Run) -> ErrorNow<'_> {
        match &self.last {
            _ if self.of != run.revision() => ErrorNow::Measuring,
            Some(last) => ErrorNow::Known(last),
            None if self.lost => ErrorNow::Lost,
            None => ErrorNow::Measuring,
        }
    }

    /// Returns whether a copy follows the current steps.
    fn is_measuring(&self) -> bool {
        0 < self.taken
    }

    /// Passes on a motion of a grabbed object. Between windows the motion does not matter: the next
    /// copy begins with the state at that time.
    pub(super) fn follow(&mut self, motion: Interaction, run: &Run) {
        if self.is_measuring() {
            self.pending.push(as_felt(motion, run.runner().settings().substep()));
        }
    }

    /// Notes that the run fell behind the clock.
    pub(super) fn fall_behind(&mut self) {
        self.late |= self.is_measuring();
    }

    /// Prepares for the next step of the run; restarts after a change of the run.
    pub(super) fn before_step(&mut self, run: &Run) {
        if self.of != run.revision() {
            *self = LiveErrorMeter { of: run.revision(), ..LiveErrorMeter::default() };
        }
        if 0 < self.rest {
            return;
        }
        let runner = run.runner();
        if self.pending.is_empty() {
            return self.estimator.before_step(runner);
        }
        // The window applies interactions at once, for display. A copy of the run gets them in its
        // queue, where the estimator looks for them.
        let mut followed = runner.clone();
        for interaction in self.pending.drain(..) {
            // The run has accepted it.
            followed.queue(interaction).ok();
        }
        self.estimator.before_step(&followed);
    }

    /// Updates the estimate after a step of the run.
    pub(super) fn after_step(&mut self, run: &Run) {
        let runner = run.runner();
        if 0 < self.rest {
            self.rest -= 1;
            return;
        }
        self.taken += 1;
        let found = self.estimator.after_step(runner).cloned();
        if self.taken < WINDOW {
            return;
        }
        // Without a copy, the estimator still reports the previous window.
        let found = found.filter(|error| error.at == runner.time());
        self.lost = found.is_none();
        self.last = found.map(|error| ErrorReading { worst: error.worst(), error });
        self.rest = if self.late { LONG_REST } else { REST };
        (self.taken, self.late) = (0, false);
    }
}

/// The estimate of a session.
impl Session {
    /// Starts or stops the estimate of the error; while it is off, no copy is made.
    pub fn set_estimating(&mut self, on: bool) {
        if on != self.live_error.is_some() {
            self.live_error = on.then(LiveErrorMeter::default);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use msd_core::{Material, Real, Scene, Settings, shape};
    use msd_run::{Runner, on};
    use msd_scene::Precision;

    fn rope() -> Runner {
        let part = shape::rope(5, 1.0, Material::default()).expect("a valid rope");
        Runner::new(&Scene::of("rope", part), Settings::default(), Precision::F64)
            .expect("a valid scene")
    }

    fn step(meter: &mut LiveErrorMeter, run: &mut Run) {
        meter.before_step(run);
        let now = run.runner().moment();
        run.step(&now).expect("a calm rope");
        meter.after_step(run);
    }

    #[test]
    fn a_window_ends_with_an_estimate_and_is_followed_by_a_rest() {
        let (mut meter, mut run) = (LiveErrorMeter::default(), Run::new(rope()));
        (1..WINDOW).for_each(|_| step(&mut meter, &mut run));
        assert!(meter.is_measuring() && meter.last.is_none());
        step(&mut meter, &mut run);
        let at = |meter: &LiveErrorMeter| meter.last.as_ref().map(|last| last.error.at);
        assert_eq!(at(&meter), Some(run.runner().time()));
        (0..REST).for_each(|_| {
            assert!(!meter.is_measuring());
            step(&mut meter, &mut run);
        });
        (0..WINDOW).for_each(|_| step(&mut meter, &mut run));
        assert_eq!(at(&meter), Some(run.runner().time()));
    }

    #[test]
    fn falling_behind_in_a_window_makes_the_rest_long() {
        let (mut meter, mut run) = (LiveErrorMeter::default(), Run::new(rope()));
        meter.fall_behind();
        (0..WINDOW).for_each(|_| step(&mut meter, &mut run));
        // No copy was running when the run fell behind.
        assert_eq!(meter.rest, REST);
        (0..REST + 1).for_each(|_| step(&mut meter, &mut run));
        meter.fall_behind();
        (1..WINDOW).for_each(|_| step(&mut meter, &mut run));
        assert_eq!(meter.rest, LONG_REST);
    }

    #[test]
    fn the_copy_feels_the_grab_that_the_run_feels() {
        let (h, mut runner) = (Settings::default().substep(), rope());
        let grab = Interaction::Grab {
            particle: 2,
            target: DVec3::ONE,
            frequency: 900.0,
            damping_ratio: 3.0,
            max_force: 100.0,
        };
        runner.queue(grab).expect("a valid grab");
        runner.apply_queued().expect("room for it");
        let mut copy = rope();
        let Settings { substeps, .. } = copy.settings();
        let finer = Settings { substeps: 2 * substeps, ..copy.settings() };
        copy.set_settings(finer).expect("valid settings");
        copy.queue(as_felt(grab, h)).expect("a valid grab");
        copy.apply_queued().expect("room for it");
        let held = |runner: &Runner| {
            on!(runner, simulation => {
                let grab = &simulation.model().grabs()[0];
                [grab.stiffness.to_f64(), grab.damping.to_f64()]
            })
        };
        for (run, copy) in held(&runner).into_iter().zip(held(&copy)) {
            // The products may differ by a few roundings.
            assert!((run - copy).abs() <= 1e-12 * run, "{run} {copy}");
        }
    }
}
