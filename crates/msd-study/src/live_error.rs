//! The error of a run while it goes on, estimated by a finer copy that runs along for a while.

use crate::candidates::choice::FRAME;
use crate::measure::reference::{Wish, make_reference};
use crate::measure::trial::state;
use crate::monitor::Halt;
use msd_core::{Error, Scene, Settings, State};
use msd_run::Runner;
use msd_scene::{AnyState, Loaded, Precision};

/// The error that a run made over a window of time, as estimated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LiveError {
    /// Length of the window, seconds.
    pub over: f64,
    /// Simulated time at its end, seconds.
    pub at: f64,
    /// Root mean square error of the positions at its end, metres.
    pub rms: f64,
    /// Error of each particle at its end, metres.
    pub particles: Vec<f64>,
    /// One rounding of the largest coordinate in the precision of the run, metres: a smaller
    /// estimate says no more than that the error is below it.
    pub rounding: f64,
}

impl LiveError {
    /// The particle that is most wrong, and its error in metres.
    pub fn worst(&self) -> (usize, f64) {
        let rows = self.particles.iter().copied().enumerate();
        rows.fold((0, 0.0), |worst, row| if worst.1 < row.1 { row } else { worst })
    }
}

/// Estimates the error of a run by step doubling: in every `every` steps, a copy of the run in
/// double precision takes `window` steps with twice the substeps (an adaptive method: a hundredth
/// of the tolerance in half the step), from the same state, with the same interactions.
///
/// With p the order of the method the error is the distance of the two times 2^p / (2^p − 1)
/// (Richardson, 1911); with p = 1 where anything touched a plane, for contact is of first order.
/// Rounding counts in full, for the copy has hardly any. Costs about 3 `window` / `every` of the
/// run.
#[derive(Clone, Debug)]
pub struct Estimator {
    window: u32,
    every: u32,
    /// Steps since the start of the current round.
    step: u32,
    copy: Option<Runner>,
    touched: bool,
    last: Option<LiveError>,
}

impl Estimator {
    /// An estimator whose first window starts with the next step; both lengths are at least 1 and
    /// `every` at least `window`.
    pub fn new(window: u32, every: u32) -> Self {
        let window = window.max(1);
        let every = every.max(window);
        Estimator { window, every, step: 0, copy: None, touched: false, last: None }
    }

    /// The last estimate.
    pub fn last(&self) -> Option<&LiveError> {
        self.last.as_ref()
    }

    /// Starts over with the next step, as after a state or a setting was replaced.
    pub fn restart(&mut self) {
        *self = Estimator::new(self.window, self.every);
    }

    /// Gets ready for the next step of a run.
    pub fn before_step(&mut self, runner: &Runner) {
        if self.step == 0 {
            self.copy = finer(runner).ok();
            self.touched = false;
        } else if let Some(copy) = &mut self.copy {
            // These interactions were found to fit when they were queued.
            let queued = msd_run::on!(runner, simulation => simulation.queued());
            let told = queued.iter().try_for_each(|&interaction| copy.queue(interaction));
            if told.is_err() {
                self.copy = None;
            }
        }
    }

    /// Follows a step of the run; returns an estimate where a window ends with it.
    pub fn after_step(&mut self, runner: &Runner) -> Option<&LiveError> {
        self.step += 1;
        if let Some(copy) = &mut self.copy {
            let follow = |copy: &mut Runner| -> Result<(), Error> {
                (0..steps_of_copy(runner)).try_for_each(|_| copy.step())
            };
            if follow(copy).is_err() {
                self.copy = None;
            }
            self.touched |= msd_run::on!(runner, simulation => simulation.touched());
        }
        let ends = self.step == self.window;
        if ends && let Some(copy) = self.copy.take() {
            let over = f64::from(self.window) * runner.settings().step;
            self.last = Some(compare(runner, &copy, (over, self.touched)));
        }
        self.step %= self.every;
        if ends { self.last.as_ref() } else { None }
    }
}

/// Steps that the copy takes for one of the run: an adaptive method may take a whole step at once
/// however small the tolerance.
fn steps_of_copy(runner: &Runner) -> u32 {
    if runner.integrator().is_adaptive() { 2 } else { 1 }
}

fn finer(runner: &Runner) -> Result<Runner, Error> {
    let mut copy = runner.convert(Precision::F64)?;
    let settings = copy.settings();
    copy.set_settings(Settings {
        step: settings.step / f64::from(steps_of_copy(runner)),
        substeps: settings.substeps.saturating_mul(2),
        tolerance: (0.01 * settings.tolerance).max(1e-13),
        ..settings
    })?;
    Ok(copy)
}

fn compare(runner: &Runner, copy: &Runner, (over, touched): (f64, bool)) -> LiveError {
    let integrator = runner.integrator();
    let order = if touched { 1 } else { integrator.order() };
    let power = f64::from(1u32 << order);
    // The copy of an adaptive run is a hundred times as accurate: nothing to extrapolate.
    let factor = if integrator.is_adaptive() { 1.0 } else { power / (power - 1.0) };
    let (here, there) = (state(runner), state(copy));
    let pairs = here.positions.iter().zip(&there.positions);
    let particles: Vec<f64> = pairs.map(|(a, b)| factor * (*a - *b).length()).collect();
    let squares: f64 = particles.iter().map(|error| error * error).sum();
    let rms = (squares / particles.len() as f64).sqrt();
    let far = here.positions.iter().map(|at| at.abs().max_element()).fold(0.0, f64::max);
    let epsilon = match runner.precision() {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    };
    LiveError { over, at: runner.time(), rms, particles, rounding: epsilon * far }
}

/// An estimate beside the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Simulated time at which the window starts, seconds.
    pub start: f64,
    /// The estimate, root mean square, metres.
    pub estimated: f64,
    /// The true error against a reference from the same state, metres.
    pub true_error: f64,
    /// Error of rounding alone, metres: see [`LiveError::rounding`].
    pub rounding: f64,
}

/// Compares estimates with the truth for windows of `frames` frames that start at the given times,
/// with the settings of the scene. Windows of a scene whose steps are not a whole part of a frame
/// are left out.
///
/// # Errors
/// A scene that the core refuses, and runs that diverge.
pub fn calibrate(loaded: &Loaded, starts: &[f64], frames: u32) -> Result<Vec<Calibration>, Halt> {
    let mut runner = Runner::open(loaded)?;
    let mut found = Vec::new();
    for &start in starts {
        while runner.time() + 0.5 * FRAME < start {
            runner.step()?;
        }
        let scene = scene_at(&loaded.scene, &runner);
        let steps = (f64::from(frames) * FRAME / runner.settings().step).round().max(1.0) as u32;
        let duration = f64::from(steps) * runner.settings().step;
        // Contact may keep a reference from ever being that certain: not too much patience.
        let wish = Wish { duration, uncertainty: 1e-9, patience: 2.0 };
        let right = make_reference(&scene, wish, &mut ())?;
        let mut estimator = Estimator::new(steps, steps);
        for _ in 0..steps {
            estimator.before_step(&runner);
            runner.step()?;
            estimator.after_step(&runner);
        }
        let Some(last) = right.states.last() else { continue };
        if 1e-9 < (right.duration() - duration).abs() {
            continue;
        }
        let true_error = crate::measure::errors::rms_distance(&state(&runner), &last.state());
        let last = estimator.last();
        let (estimated, rounding) = last.map_or((f64::NAN, 0.0), |last| (last.rms, last.rounding));
        found.push(Calibration { start, estimated, true_error, rounding });
    }
    Ok(found)
}

/// The scene in its state after a while.
fn scene_at(scene: &Scene, runner: &Runner) -> Scene {
    let now: State<f64> = match runner.state() {
        AnyState::F32(state) => state.convert(),
        AnyState::F64(state) => state,
    };
    let mut scene = scene.clone();
    for (row, particle) in scene.particles.iter_mut().enumerate() {
        (particle.position, particle.velocity) = (now.positions[row], now.velocities[row]);
    }
    scene
}
