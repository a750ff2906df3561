//! `--device`: who takes the steps of runs, the processor or a graphics adapter.

#[cfg(not(feature = "gpu"))]
mod absent;
#[cfg(feature = "gpu")]
mod adapter;
#[cfg(feature = "gpu")]
mod fleet;
#[cfg(feature = "gpu")]
mod gpu;

#[cfg(not(feature = "gpu"))]
pub use absent::{NoFleet as GpuFleet, NoGpu as Gpu, check_cell, open_for_settings, run_devices};
#[cfg(feature = "gpu")]
pub use fleet::{GpuFleet, check_cell, open_for_settings};
#[cfg(feature = "gpu")]
pub use gpu::{Gpu, run_devices};

use super::arguments::DeviceChoice;
use super::failure::Failure;
use msd_core::Error;
use msd_run::Runner;
use web_time::Instant;

/// Steps between two readings of the energy of a run on a device: each costs the processor about as
/// much as an evaluation of all forces, and the device a read-back.
const READING: u64 = 32;
/// The longest that Ctrl-C waits for a device, seconds.
const PATIENCE: f64 = 0.25;

/// Why a device does not take the steps of a run.
#[derive(Debug)]
pub struct Refusal {
    /// The reason.
    pub why: String,
    /// What to do; empty if the reason says it.
    pub advice: String,
}

impl Refusal {
    pub fn new(why: impl ToString, advice: &str) -> Self {
        Refusal { why: why.to_string(), advice: advice.to_owned() }
    }

    /// The error for somebody who asked for the device.
    pub fn failure(&self, scene: &str) -> Failure {
        let Refusal { why, advice } = self;
        let semicolon = if advice.is_empty() { "" } else { "; " };
        Failure::input(format!("{scene}: {why}{semicolon}{advice}"))
    }
}

/// Settles who takes the steps, by a function that opens a device and returns a note on it. It
/// learns whether the choice is `auto`. The processor needs neither; a refusal is an error unless
/// the choice is `auto`.
pub fn settle<T>(
    choice: &DeviceChoice,
    what: &str,
    open: impl FnOnce(bool) -> Result<(T, String), Refusal>,
) -> Result<(Option<T>, Option<String>), Failure> {
    if *choice == DeviceChoice::Processor {
        return Ok((None, None));
    }
    let is_auto = *choice == DeviceChoice::Auto;
    match open(is_auto) {
        Ok((device, note)) => Ok((Some(device), Some(format!("device: {note}")))),
        Err(refusal) if is_auto => {
            Ok((None, Some(format!("device: processor, as {}", refusal.why))))
        }
        Err(refusal) => Err(refusal.failure(what)),
    }
}

/// Why a run stopped before its end.
#[derive(Debug)]
pub enum Stop {
    /// A step failed.
    Step(Error),
    /// The device computed other bits than the processor.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "no device stops a run"))]
    Device(Failure),
}

/// Steps of a run that a device took.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceSteps {
    /// All of them.
    pub device: u64,
    /// Those that the processor has taken again, with the same bits.
    pub checked: u64,
}

impl DeviceSteps {
    /// Returns the counts in substeps, of which a step has `parts`.
    pub fn times(self, parts: u64) -> Self {
        DeviceSteps { device: self.device * parts, checked: self.checked * parts }
    }
}

/// Who takes the steps of a run.
pub struct Stepper {
    gpu: Option<Gpu>,
    name: String,
    /// Steps of the device until it was lost.
    taken: DeviceSteps,
    /// Steps that it takes within a moment.
    at_once: u64,
}

impl Stepper {
    /// Opens the device of a choice for a run, and returns notes on it.
    pub fn open(
        choice: &DeviceChoice,
        scene: &str,
        runner: &Runner,
    ) -> Result<(Self, Option<String>), Failure> {
        let (gpu, note) = settle(choice, scene, |is_auto| {
            let mut gpu = Gpu::open(choice, runner)?;
            let note = if is_auto { gpu.win_race(runner)? } else { gpu.verdict().to_owned() };
            let note = format!("{}, {note}", gpu.name());
            Ok((gpu, note))
        })?;
        Ok((Stepper::of(gpu), note))
    }

    fn of(gpu: Option<Gpu>) -> Self {
        let name = gpu.as_ref().map_or("processor".to_owned(), Gpu::name);
        Stepper { gpu, name, taken: DeviceSteps::default(), at_once: 1 }
    }

    /// `processor`, or the adapter that the run was begun on.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Steps that the device took.
    pub fn taken(&self) -> DeviceSteps {
        self.gpu.as_ref().map_or(self.taken, Gpu::steps)
    }

    /// The most steps to take at once, for a run that has taken so many.
    pub fn most(&self, taken: u64) -> u64 {
        let until_reading = READING - taken % READING;
        if self.gpu.is_some() { self.at_once.min(until_reading) } else { 1 }
    }

    /// Returns whether the watch reads the run after so many steps.
    pub fn is_read(&self, taken: u64) -> bool {
        self.gpu.is_none() || taken.is_multiple_of(READING)
    }

    /// Takes so many steps; returns a warning if the processor has to go on alone.
    pub fn advance(&mut self, runner: &mut Runner, steps: u64) -> Result<Option<String>, Stop> {
        let Some(gpu) = &mut self.gpu else {
            let each = (0..steps).try_for_each(|_| runner.step());
            return each.map(|()| None).map_err(Stop::Step);
        };
        let start = Instant::now();
        let lost = gpu.advance(runner, steps)?;
        let each = start.elapsed().as_secs_f64() / steps as f64;
        self.at_once = ((PATIENCE / each.max(1e-9)) as u64).clamp(1, READING);
        if lost.is_some() {
            (self.taken, self.gpu) = (gpu.steps(), None);
        }
        Ok(lost.map(|why| format!("{why}; the run continues on the processor")))
    }

    /// Waits at the end of a run for the check of a step of the device.
    pub fn finish(&mut self, runner: &mut Runner) -> Result<(), Stop> {
        self.gpu.as_mut().map_or(Ok(()), |gpu| gpu.finish(runner))
    }
}
