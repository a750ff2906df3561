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
#[derive(Clone, Copy, Debug, Default)]
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

pub(super) type Slot = Arc<OnceLock<Result<Reference, Halt>>>;

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

/// The reference of a cell, or the reason why there is none, in words.
///
/// # Errors
/// The error of [`Monitor::proceed`].
fn right_of<'s>(
    loaded: &Loaded,
    (duration, slot): (f64, Option<&'s Slot>),
    monitor: &mut dyn Monitor,
) -> Result<Option<Result<&'s Reference, String>>, Halt> {
    let wish = Wish { duration, ..Wish::default() };
    let make = || reference(&loaded.scene, wish, monitor);
    match slot.map(|slot| slot.get_or_init(make)) {
        Some(Ok(right)) => Ok(Some(Ok(right))),
        Some(Err(Halt::Refused(error))) => Ok(Some(Err(format!("there is no reference: {error}")))),
        Some(Err(halt)) => Err(halt.clone()),
        None => Ok(None),
    }
}

/// Runs a scene and measures it, against a reference if there is a slot for one.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`]. A run that diverges is a result, not an
/// error.
pub(super) fn measure(
    loaded: &Loaded,
    (duration, slot): (f64, Option<Slot>),
    monitor: &mut dyn Monitor,
) -> Result<Measured, Halt> {
    let (mut cell, mut runner) = CellRun::begin(loaded, (duration, slot), monitor)?;
    while let Some(stop) = cell.next_stop() {
        let (clock, wall) = (CpuClock::start(), Instant::now());
        let mut stepped = Ok(());
        while stepped.is_ok() && runner.steps() < stop {
            let proceeds = monitor.proceed();
            stepped = proceeds.and_then(|()| runner.step().map_err(Halt::from));
        }
        cell.times[0] += clock.seconds();
        cell.times[1] += wall.elapsed().as_secs_f64();
        match stepped {
            Ok(()) => cell.arrive(&runner),
            Err(Halt::Refused(error)) => cell.end(error)?,
            Err(halt) => return Err(halt),
        }
    }
    Ok(cell.finish(&runner))
}

/// The measurement of a cell under way. Whoever takes the steps of its run stops at each of its
/// stops.
pub(super) struct CellRun {
    settings: Settings,
    precision: Precision,
    /// Largest substep predicted stable at the start, seconds.
    stable: f64,
    /// Time that the steps took, by the processor and by the clock on the wall, seconds.
    times: [f64; 2],
    /// The reference, and the system in which states are compared with it.
    right: Option<(Slot, Simulation<f64>)>,
    /// The steps at which to stop, in descending order, each with the row of the reference to
    /// compare with; none at the end.
    stops: Vec<(u64, Option<usize>)>,
    /// The comparison so far.
    comparison: Comparison,
    note: Option<String>,
    diverged: Option<Divergence>,
    has_ended: bool,
}

impl CellRun {
    /// Begins to measure a scene, and opens its run.
    ///
    /// # Errors
    /// See [`measure`].
    pub(super) fn begin(
        loaded: &Loaded,
        (duration, slot): (f64, Option<Slot>),
        monitor: &mut dyn Monitor,
    ) -> Result<(Self, Runner), Halt> {
        let right = right_of(loaded, (duration, slot.as_ref()), monitor)?;
        let runner = Runner::open(loaded)?;
        let steps = count_steps(loaded.settings, duration);
        let mut stops = vec![(steps, None)];
        let (mut comparison, mut note, mut system) = (Comparison::default(), None, None);
        match right {
            Some(Ok(right)) => {
                let step = runner.settings().step;
                let frames = right.frames.iter().enumerate().rev();
                let met = frames.filter_map(|(row, &frame)| Some((steps_to(frame, step)?, row)));
                let met = met.filter(|&(met, _)| met <= steps);
                stops.extend(met.map(|(met, row)| (met, Some(row))));
                comparison.size = right.size;
                system = Some(Simulation::new(&loaded.scene, Settings::default())?);
            }
            Some(Err(why)) => note = Some(why),
            None => {}
        }
        let cell = CellRun {
            // Automatic substeps may be others later.
            settings: runner.settings(),
            precision: loaded.precision,
            stable: runner.stable_substep(),
            times: [0.0; 2],
            right: slot.zip(system),
            stops,
            comparison,
            note,
            diverged: None,
            has_ended: false,
        };
        Ok((cell, runner))
    }

    /// The steps of the run at which it is to stop next; none once it has ended.
    pub(super) fn next_stop(&self) -> Option<u64> {
        self.stops.last().filter(|_| !self.has_ended).map(|stop| stop.0)
    }

    /// Compares the run at its next stop with the reference: particle by particle as long as the
    /// reference knows where they are.
    pub(super) fn arrive(&mut self, runner: &Runner) {
        let Some((_, Some(row))) = self.stops.pop() else { return };
        let Some((right, system)) = self.right() else { return };
        let reliable = right.reliable(RELIABLE * right.size).max(1);
        let here = compare(system, &state(runner), &right.states[row].state());
        let Errors { centre, energy, penetration, .. } = here;
        let coarse = Errors { centre, energy, penetration, ..Errors::default() };
        let until = right.frames[row] as f64 * FRAME;
        let known = &right.moved[..reliable.min(right.moved.len())];
        let uncertainty = known.iter().copied().fold(0.0, f64::max);
        let is_known = row < reliable;
        let comparison = &mut self.comparison;
        comparison.errors = comparison.errors.worse(if is_known { &here } else { &coarse });
        comparison.uncertainty = uncertainty;
        if is_known {
            (comparison.samples, comparison.until) = (comparison.samples + 1, until);
        }
    }

    fn right(&self) -> Option<(&Reference, &Simulation<f64>)> {
        let (slot, system) = self.right.as_ref()?;
        Some((slot.get()?.as_ref().ok()?, system))
    }

    /// Ends the run by the error of a step, which is a result: this choice does not get through
    /// this scene.
    ///
    /// # Errors
    /// An error of anything but a step.
    pub(super) fn end(&mut self, error: Error) -> Result<(), Error> {
        self.has_ended = true;
        match error {
            Error::Diverged(divergence) => self.diverged = Some(divergence),
            error if error.is_of_step() => self.note = Some(error.to_string()),
            error => return Err(error),
        }
        Ok(())
    }

    /// Notes that a device takes the steps. It does not measure the columns of the processor.
    pub(super) fn hand_over(&mut self) {
        self.times = [f64::NAN; 2];
    }

    /// The measurements of a run that has come to its end.
    pub(super) fn finish(self, runner: &Runner) -> Measured {
        let is_compared = 0 < self.comparison.samples && !self.has_ended;
        let no_sample = "no step ends where the reference has a state".to_owned();
        let has_no_sample = self.right().is_some() && !is_compared && !self.has_ended;
        let [cpu, wall] = self.times;
        let mut energy = runner.energy();
        if cpu.is_nan() {
            (energy.dissipated, energy.supplied) = (f64::NAN, f64::NAN);
        }
        Measured {
            settings: self.settings,
            precision: self.precision,
            particles: runner.particle_count(),
            springs: runner.spring_count(),
            steps: runner.steps(),
            time: runner.time(),
            cpu,
            wall,
            stable: self.stable,
            energy,
            state_hash: state_hash(&runner.state()),
            diverged: self.diverged,
            comparison: is_compared.then_some(self.comparison),
            note: if has_no_sample { Some(no_sample) } else { self.note },
        }
    }
}
