//! Trials: cost and error of one choice, from a run against the reference.

use crate::candidates::choice::{Choice, FRAME};
use crate::measure::clock::CpuClock;
use crate::measure::device::{Device, LoadError};
use crate::measure::errors::{Errors, compare};
use crate::measure::reference::{Reference, frames_of};
use crate::monitor::{Halt, Monitor};
use crate::quantity::estimate;
use msd_core::{Error, Scene, Settings, Simulation, State, Witness};
use msd_run::Runner;
use msd_scene::{AnyState, state_hash};
use serde::{Deserialize, Serialize};
use std::slice;
use web_time::Instant;

/// Result of a choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The choice.
    pub choice: Choice,
    /// Time of the processor per simulated second, the best of all runs, seconds.
    pub cost: f64,
    /// Errors over the samples at which particles can be compared; none for a run that diverged.
    pub errors: Option<Errors>,
    /// Kinetic, elastic and gravitational energy at each sample, joules.
    pub energies: Vec<f64>,
    /// The most energy that the method was seen to have added for good, joules; 0 where it added
    /// none. It is the bound of the drift detector, [`Witness`], by which `msd run` warns.
    pub gained: f64,
    /// Why the run ended early, in words: it left the world, or its tolerance was out of reach.
    pub diverged: Option<String>,
}

impl Trial {
    /// The error that choices are judged by, metres: infinite for a run that diverged.
    pub fn error(&self) -> f64 {
        self.errors.map_or(f64::INFINITY, |errors| errors.rms)
    }

    /// Returns whether it can be chosen: it stayed in the world, and added no energy. A source of
    /// energy may be near the reference for as long as it was tried, and blow up later.
    pub fn is_sound(&self) -> bool {
        self.errors.is_some() && self.gained == 0.0
    }

    /// Returns whether it can be chosen where an error of so many metres is allowed.
    pub fn is_within(&self, error: f64) -> bool {
        self.is_sound() && self.error() <= error
    }
}

/// Runs a choice and compares it with the reference: at `reliable` samples particle by particle,
/// and at the others by energy and centre of mass only.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`]. A run that diverges is a result, not an
/// error.
pub fn try_choice(
    scene: &Scene,
    choice: Choice,
    (reference, reliable): (&Reference, usize),
    monitor: &mut dyn Monitor,
) -> Result<Trial, Halt> {
    let system = Simulation::<f64>::new(scene, Settings::default())?;
    let mut runner = Runner::new(scene, choice.settings(), choice.precision)?;
    let (mut seconds, mut worst, mut energies) = (0.0, Errors::default(), Vec::new());
    let (mut witness, mut gained) = (Witness::default(), 0.0f64);
    runner.show_to(&mut witness);
    for (row, (&frame, right)) in reference.frames.iter().zip(&reference.states).enumerate() {
        // Not while the clock runs: it may wait.
        monitor.proceed()?;
        let clock = CpuClock::start();
        let stepped = step_to(&mut runner, frame);
        seconds += clock.seconds();
        if let Err(error) = stepped {
            // Per second that it got through, and the step that it did not.
            let reached = runner.time() + runner.settings().step;
            let (diverged, cost) = (Some(error.to_string()), seconds / reached);
            return Ok(Trial { choice, cost, errors: None, energies, gained, diverged });
        }
        let errors = compare(&system, &state(&runner), &right.state());
        let Errors { centre, energy, penetration, .. } = errors;
        let coarse = Errors { centre, energy, penetration, ..Errors::default() };
        worst = worst.worse(if row < reliable { &errors } else { &coarse });
        let energy = runner.show_to(&mut witness);
        gained = gained.max(witness.gain());
        energies.push(energy.mechanical());
    }
    let cost = match seconds < CpuClock::SURE {
        true => time_choice(scene, choice, runner.steps(), monitor)?,
        false => seconds / reference.duration(),
    };
    Ok(Trial { choice, cost, errors: Some(worst), energies, gained, diverged: None })
}

/// Runs a choice for some seconds for its soundness alone. If it leaves the world or adds energy,
/// returns the reason in words.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`].
pub fn find_fault(
    scene: &Scene,
    choice: Choice,
    duration: f64,
    monitor: &mut dyn Monitor,
) -> Result<Option<String>, Halt> {
    let mut runner = Runner::new(scene, choice.settings(), choice.precision)?;
    let mut witness = Witness::default();
    runner.show_to(&mut witness);
    for _ in 0..frames_of(duration) {
        monitor.proceed()?;
        if let Err(error) = runner.step() {
            return Ok(Some(error.to_string()));
        }
        runner.show_to(&mut witness);
        if 0.0 < witness.gain() {
            return Ok(Some(adds(witness.gain())));
        }
    }
    Ok(None)
}

/// That energy is added, joules, in words.
pub fn adds(gained: f64) -> String {
    format!("adds {} that nothing supplied", estimate(gained, "J"))
}

/// Runs a choice once more for its cost alone: CPU time per simulated second, seconds; infinite for
/// a run that diverges.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`].
pub fn time_choice(
    scene: &Scene,
    choice: Choice,
    frames: u64,
    monitor: &mut dyn Monitor,
) -> Result<f64, Halt> {
    time_run(Runner::new(scene, choice.settings(), choice.precision)?, frames, monitor)
}

/// Takes so many steps for their cost alone: time of the processor per simulated second, seconds;
/// infinite for a run that diverges.
pub(crate) fn time_run(
    mut runner: Runner,
    steps: u64,
    monitor: &mut dyn Monitor,
) -> Result<f64, Halt> {
    let start = runner.moment();
    let mut seconds = 0.0;
    // Few parts: reading the clock takes as long as a step of the smallest scenes.
    for part in 1..=PARTS {
        monitor.proceed()?;
        let clock = CpuClock::start();
        let stepped = step_to(&mut runner, part * steps / PARTS);
        seconds += clock.seconds();
        if stepped.is_err() {
            return Ok(f64::INFINITY);
        }
    }
    if CpuClock::SURE <= seconds {
        return Ok(seconds / runner.time());
    }
    // Again and again, until the ticks of the clock are many.
    let (clock, mut runs) = (CpuClock::start(), 0);
    while clock.seconds() < CpuClock::SURE {
        runner.go_back(&start)?;
        step_to(&mut runner, steps)?;
        runs += 1;
    }
    Ok(clock.seconds() / (f64::from(runs) * runner.time()))
}

/// Result of a choice on a device.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceTime {
    /// Wall-clock time per simulated second, seconds. It includes the transfers of the state; it is
    /// infinite for a run that diverges.
    Cost(f64),
    /// The device does not step it.
    Untaken,
    /// Why the device takes no more steps, in words.
    Failed(String),
}

/// Time of a device, and of the processor that repeats its steps, after which a choice is known,
/// seconds.
const KNOWN: f64 = 0.25;

/// Runs a choice on a device for its cost, over so many frames at most. The processor repeats the
/// first frames, and more while they take little time, and compares all bits.
///
/// # Errors
/// The errors of [`Runner::new`] and [`Monitor::proceed`].
pub fn time_on(
    device: &mut dyn Device,
    (scene, choice): (&Scene, Choice),
    frames: u64,
    monitor: &mut dyn Monitor,
) -> Result<DeviceTime, Halt> {
    let mut there = Runner::new(scene, choice.settings(), choice.precision)?;
    if !device.takes(&there) {
        return Ok(DeviceTime::Untaken);
    }
    let mut here = there.clone();
    match device.load(slice::from_ref(&there)) {
        Ok(()) => {}
        Err(LoadError::TooLarge(_)) => return Ok(DeviceTime::Untaken),
        Err(LoadError::Failed(why)) => return Ok(DeviceTime::Failed(why)),
    }
    let (mut best, mut spent, mut repeated, mut part) = (f64::INFINITY, 0.0, 0.0, 1);
    while there.steps() < frames.max(2) && spent < KNOWN {
        monitor.proceed()?;
        let start = Instant::now();
        let ended = device.advance(slice::from_mut(&mut there), part);
        let seconds = start.elapsed().as_secs_f64();
        match ended {
            Err(why) => return Ok(DeviceTime::Failed(why)),
            Ok(ended) if ended.iter().any(Option::is_some) => {
                return Ok(DeviceTime::Cost(f64::INFINITY));
            }
            Ok(_) => {}
        }
        // The first frame warms up the device.
        if part < there.steps() {
            (best, spent) = (seconds.min(best * part as f64) / part as f64, spent + seconds);
        }
        if repeated < KNOWN {
            let start = Instant::now();
            let stepped = step_to(&mut here, there.steps());
            repeated += start.elapsed().as_secs_f64();
            if stepped.is_err() || state_hash(&here.state()) != state_hash(&there.state()) {
                let name = device.name();
                let why = format!("{name} computed other bits than the processor by {choice}");
                return Ok(DeviceTime::Failed(why));
            }
        }
        let left = frames.max(2) - there.steps();
        part = (2 * part).min(left.max(1));
    }
    Ok(device.finish().map_or_else(DeviceTime::Failed, |()| DeviceTime::Cost(best / FRAME)))
}

/// Number of times that a timed run asks its monitor.
const PARTS: u64 = 8;

fn step_to(runner: &mut Runner, frame: u64) -> Result<(), Error> {
    while runner.steps() < frame {
        runner.step()?;
    }
    Ok(())
}

/// The state of a run in double precision.
pub fn state(runner: &Runner) -> State<f64> {
    match runner.state() {
        AnyState::F32(state) => state.convert(),
        AnyState::F64(state) => state,
    }
}
