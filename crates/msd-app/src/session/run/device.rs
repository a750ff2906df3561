//! Steps on a graphics device, computed while frames are drawn.

use crate::steppable::steppable;
use msd_core::{Error, Settings};
use msd_gpu::{CAN_WAIT, Device, GpuError, GpuSimulation, Outcome, Tally};
use msd_run::Runner;

/// A device that takes the steps of a run.
///
/// A step is begun in one frame and taken in a later one, once it is there; no frame waits for it.
/// What changes the run in between makes the step void, and it is begun anew. While the user moves
/// what they hold, each frame would void it, so that frame waits for its step. In a browser no
/// frame can wait: there the processor takes that step.
#[derive(Debug)]
pub struct DeviceRun {
    device: Device,
    gpu: GpuSimulation,
    /// The settings that the device was prepared for.
    settings: Settings,
    step: NextStep,
    /// Whether the run was changed since the step was begun, and whether the user moves something.
    is_void: bool,
    is_moved: bool,
    /// Whether the device must be prepared anew.
    is_stale: bool,
    /// Steps before the device was prepared last.
    past: Tally,
}

/// The next step of a device.
#[derive(Debug)]
enum NextStep {
    None,
    /// It is being computed.
    Begun,
    /// It is there.
    Done(Box<Outcome>),
    /// The processor takes it.
    OfProcessor,
}

impl DeviceRun {
    /// Prepares a device for a run.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] with the reason, and as of [`GpuSimulation::new`].
    pub(super) fn new(device: Device, runner: &Runner) -> Result<Self, GpuError> {
        let simulation = steppable(runner)?;
        let gpu = GpuSimulation::prepare(&device, simulation)?;
        Ok(DeviceRun {
            device,
            gpu,
            settings: simulation.settings(),
            step: NextStep::None,
            is_void: false,
            is_moved: false,
            is_stale: false,
            past: Tally::default(),
        })
    }

    /// Its name.
    pub fn name(&self) -> String {
        self.device.name()
    }

    /// Destroys the device, for tests.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn lose(&self) {
        self.device.lose();
    }

    /// The steps so far by who took them.
    pub fn tally(&self) -> Tally {
        let (past, now) = (self.past, self.gpu.tally());
        Tally {
            device: past.device + now.device,
            processor: past.processor + now.processor,
            checked: past.checked + now.checked,
        }
    }

    /// Voids the step under way: the user moves what they hold.
    pub(in crate::session) fn void(&mut self) {
        (self.is_void, self.is_moved) = (true, true);
        // A gust or a pin.
        self.gpu.renew_check();
    }

    /// Prepares the device anew before the next step: the model may have changed.
    pub(super) fn renew(&mut self) {
        (self.is_void, self.is_stale) = (true, true);
    }

    /// Begins the next step, and returns whether it can be taken; never waits for the device.
    pub(super) fn is_ready(&mut self, runner: &mut Runner) -> Result<bool, GpuError> {
        if self.is_moved {
            self.wait()?;
        }
        if let NextStep::Begun = self.step {
            match self.gpu.poll()? {
                Some(outcome) => self.step = NextStep::Done(Box::new(outcome)),
                None => return Ok(false),
            }
        }
        if std::mem::take(&mut self.is_void) {
            self.step = NextStep::None;
        }
        if matches!(self.step, NextStep::Done(_) | NextStep::OfProcessor) {
            return Ok(true);
        }
        let settings = steppable(runner)?.settings();
        if std::mem::take(&mut self.is_stale) || settings != self.settings {
            let past = self.tally();
            *self = DeviceRun { past, ..DeviceRun::new(self.device.clone(), runner)? };
        }
        let Runner::F32(simulation, _) = runner else { return Ok(false) };
        let is_moved = std::mem::take(&mut self.is_moved);
        let is_begun = (CAN_WAIT || !is_moved) && self.gpu.begin(simulation, 1)?;
        self.step = if is_begun { NextStep::Begun } else { NextStep::OfProcessor };
        if is_moved {
            self.wait()?;
        }
        Ok(!matches!(self.step, NextStep::Begun))
    }

    /// Waits for the step under way, if there is one and a program can wait; returns whether it
    /// did.
    fn wait(&mut self) -> Result<bool, GpuError> {
        let waits = CAN_WAIT && matches!(self.step, NextStep::Begun);
        if waits {
            self.step = NextStep::Done(Box::new(self.gpu.wait()?));
        }
        Ok(waits)
    }

    /// Takes the next step, and waits for it if it is not there yet. Where a program cannot wait,
    /// the processor takes it.
    pub(super) fn step(&mut self, runner: &mut Runner) -> Result<(), GpuError> {
        while !self.is_ready(runner)? && self.wait()? {}
        let Runner::F32(simulation, _) = runner else { return Ok(()) };
        if let NextStep::Begun = self.step {
            self.is_void = true;
            self.gpu.step_on_processor(simulation)?;
            // A change of the model has prepared the device anew.
            if !self.gpu.is_begun() {
                self.step = NextStep::None;
            }
            return Ok(());
        }
        match std::mem::replace(&mut self.step, NextStep::None) {
            NextStep::Done(outcome) => self.gpu.take(simulation, &outcome),
            _ => self.gpu.step_on_processor(simulation),
        }
    }
}

/// The failure of a step on the processor, or why the device takes no more steps, in words.
pub(super) fn failure_of(error: GpuError) -> Result<Error, String> {
    match error {
        GpuError::Step(error) => Ok(error),
        GpuError::Differs { adapter, step, .. } => Err(format!(
            "{adapter} computed other bits than the processor in step {step}; the run continues on \
             the processor from its current state"
        )),
        other => Err(format!("{other}; the run continues on the processor")),
    }
}
