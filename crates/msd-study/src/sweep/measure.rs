//! Measurement of a cell: one run, timed, compared with its reference.

use crate::candidates::choice::FRAME;
use crate::measure::clock::CpuClock;
use crate::measure::errors::{Errors, compare};
use crate::measure::reference::{Reference, Wish, frames_of, reference};
use crate::measure::trial::state;
use crate::monitor::{Halt, Monitor};
use msd_core::{Divergence, Energy, Error, Settings, Simulation};
use msd_run::Runner;
use msd_scene::{Loaded, Precision, state_hash};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// Result of a cell.
pub(super) struct Measured {
    pub(super) settings: Settings,
    pub(super) precision: Precision,
    pub(super) particles: usize,
    pub(super) springs: usize,
    pub(super) steps: u64,
    /// Simulated time, seconds.
    pub(super) time: f64,
    /// Time of the processor that the steps took, seconds.
    pub(super) cpu: f64,
    /// Time by the clock on the wall that the steps took, seconds.
    pub(super) wall: f64,
    /// Largest substep predicted stable at the start, seconds.
    pub(super) stable: f64,
    pub(super) energy: Energy,
    pub(super) state_hash: u64,
    pub(super) diverged: Option<Divergence>,
    pub(super) comparison: Option<Comparison>,
    /// The reason why there is no comparison.
    pub(super) note: Option<String>,
}

/// Error of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comparison {
    pub(super) errors: Errors,
    /// Size of the scene, metres.
    pub(super) size: f64,
    /// Samples compared particle by particle, and the time of the last, seconds.
    pub(super) samples: usize,
    pub(super) until: f64,
    /// Uncertainty of the reference over those samples, metres.
    pub(super) uncertainty: f64,
}

/// The share of the size of a scene to which the reference must be known, chaos included, where
/// particles are compared: a tenth of the error that studies look for.
const RELIABLE: f64 = 1e-4;

/// Steps after which a run is at a frame of 1/60 s, if it ever is.
fn steps_to(frame: u64, step: f64) -> Option<u64> {
    let time = frame as f64 * FRAME;
    let steps = (time / step).round();
    // Rounding of both products stays far below this; a particle moves by nothing in that time.
    let meets = 1.0 <= steps && (steps * step - time).abs() <= 1e-9 * step.max(time);
    meets.then_some(steps as u64)
}

/// The number of steps of a cell.
fn count_steps(settings: Settings, duration: f64) -> u64 {
    (duration / settings.step).round().max(1.0) as u64
}

/// Returns whether a step ends at a frame of 1/60 s.
pub(super) fn meets_frames(settings: Settings, duration: f64) -> bool {
    let steps = count_steps(settings, duration);
    let mut frames = 1..=frames_of(duration);
    frames.any(|frame| steps_to(frame, settings.step).is_some_and(|met| met <= steps))
}

/// References in use, so that the threads of a process that need the same one make it once.
pub(super) struct References {
    slots: Mutex<Vec<(String, Slot)>>,
    /// Number of references that are kept: cells that share one follow each other.
    kept: usize,
}

type Slot = Arc<OnceLock<Result<Reference, Halt>>>;

impl References {
    pub(super) fn new(kept: usize) -> Self {
        References { slots: Mutex::default(), kept }
    }

    /// The slot of a reference, to be filled by the first who needs it.
    pub(super) fn slot(&self, hash: &str) -> Slot {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = match slots.iter().position(|slot| slot.0 == hash) {
            Some(place) => slots.remove(place),
            None => (hash.to_owned(), Slot::default()),
        };
        slots.insert(0, slot.clone());
        slots.truncate(self.kept);
        slot.1
    }
}

/// Runs a scene and measures it, against a reference if there is a slot for one.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`]. A run that diverges is a result, not an
/// error.
pub(super) fn measure(
    loaded: &Loaded,
    (duration, slot): (f64, Option<&Slot>),
    monitor: &mut dyn Monitor,
) -> Result<Measured, Halt> {
    let wish = Wish { duration, ..Wish::default() };
    let make = || reference(&loaded.scene, wish, monitor);
    let (right, note) = match slot.map(|slot| slot.get_or_init(make)) {
        Some(Ok(right)) => (Some(right), None),
        Some(Err(Halt::Refused(error))) => (None, Some(format!("there is no reference: {error}"))),
        Some(Err(halt)) => return Err(halt.clone()),
        None => (None, None),
    };
    let mut run = TimedRun::start(loaded, monitor)?;
    // Automatic substeps may be others later.
    let settings = run.runner.settings();
    let steps = count_steps(loaded.settings, duration);
    let compared = match right {
        Some(right) => {
            let system = Simulation::new(&loaded.scene, Settings::default())?;
            run.compare_with(right, (&system, steps))
        }
        None => Ok(None),
    };
    let ended = compared.and_then(|comparison| run.step_to(steps).map(|()| comparison));
    let (comparison, diverged, note) = match ended {
        Ok(None) if right.is_some() => {
            let reason = "no step ends where the reference has a state";
            (None, None, Some(reason.to_owned()))
        }
        Ok(comparison) => (comparison, None, note),
        Err(Halt::Refused(Error::Diverged(divergence))) => (None, Some(divergence), note),
        // A result like any other, too: this choice does not get through this scene.
        Err(Halt::Refused(error)) if error.is_of_step() => (None, None, Some(error.to_string())),
        Err(halt) => return Err(halt),
    };
    let TimedRun { runner, cpu, wall, stable, .. } = run;
    Ok(Measured {
        settings,
        precision: loaded.precision,
        particles: runner.particle_count(),
        springs: runner.spring_count(),
        steps: runner.steps(),
        time: runner.time(),
        cpu,
        wall,
        stable,
        energy: runner.energy(),
        state_hash: state_hash(&runner.state()),
        diverged,
        comparison,
        note,
    })
}

/// A run whose steps are timed.
struct TimedRun<'a> {
    runner: Runner,
    monitor: &'a mut dyn Monitor,
    cpu: f64,
    wall: f64,
    stable: f64,
}

impl<'a> TimedRun<'a> {
    fn start(loaded: &Loaded, monitor: &'a mut dyn Monitor) -> Result<Self, Error> {
        let runner = Runner::open(loaded)?;
        let stable = runner.stable_substep();
        Ok(TimedRun { runner, monitor, cpu: 0.0, wall: 0.0, stable })
    }

    fn step_to(&mut self, steps: u64) -> Result<(), Halt> {
        let (clock, wall) = (CpuClock::start(), Instant::now());
        let mut stepped = Ok(());
        while stepped.is_ok() && self.runner.steps() < steps {
            let proceeds = self.monitor.proceed();
            stepped = proceeds.and_then(|()| self.runner.step().map_err(Halt::from));
        }
        self.cpu += clock.seconds();
        self.wall += wall.elapsed().as_secs_f64();
        stepped
    }

    /// Steps to each state of the reference that a step meets, at most `steps` of them, and
    /// compares: particle by particle as long as the reference knows where they are.
    fn compare_with(
        &mut self,
        right: &Reference,
        (system, steps): (&Simulation<f64>, u64),
    ) -> Result<Option<Comparison>, Halt> {
        let reliable = right.reliable(RELIABLE * right.size).max(1);
        let (mut errors, mut samples, mut until) = (Errors::default(), 0, 0.0);
        for (row, (&frame, sample)) in right.frames.iter().zip(&right.states).enumerate() {
            let met = steps_to(frame, self.runner.settings().step).filter(|&met| met <= steps);
            let Some(met) = met else { continue };
            self.step_to(met)?;
            let here = compare(system, &state(&self.runner), &sample.state());
            let Errors { centre, energy, penetration, .. } = here;
            let coarse = Errors { centre, energy, penetration, ..Errors::default() };
            errors = errors.worse(if row < reliable { &here } else { &coarse });
            if row < reliable {
                (samples, until) = (samples + 1, frame as f64 * FRAME);
            }
        }
        let known = &right.moved[..reliable.min(right.moved.len())];
        let uncertainty = known.iter().copied().fold(0.0, f64::max);
        let comparison = Comparison { errors, size: right.size, samples, until, uncertainty };
        Ok((0 < samples).then_some(comparison))
    }
}
