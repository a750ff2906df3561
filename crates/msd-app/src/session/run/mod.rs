//! The run behind a single interface, and readings that each change of it voids.

mod device;
mod switch;

pub use device::DeviceRun;
pub(super) use switch::{GpuSwitch, gpu_obstacle};

use device::failure_of;
use msd_core::stability::Estimator;
use msd_core::{Error, Interaction};
use msd_gpu::{Device, GpuError};
use msd_run::{Moment, Runner};
use msd_scene::Loaded;
use msd_scene::schema::Solver;

/// Wall-clock time per frame for each prediction of the longest stable substep, seconds.
pub(super) const PREDICTING: f64 = 4e-3;
/// Whether the choice of automatic substeps after a change may take several frames: the page of a
/// browser should respond within 50 ms. Elsewhere the run chooses them at once.
const IS_LAZY: bool = cfg!(target_arch = "wasm32");

/// Counter of the changes of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Revision(u64);

/// A runner that only `Run::change` can change, so that no change goes unnoticed. Steps, motions of
/// grabbed objects, gusts and looks do not count as changes.
#[derive(Debug)]
pub struct Run {
    runner: Runner,
    revision: Revision,
    /// Whether gusts have done work since the last change.
    is_driven: bool,
    /// The device that takes its steps, and why it ended.
    device: (Option<Box<DeviceRun>>, Option<String>),
}

impl Run {
    /// A run at its first revision.
    pub(super) fn new(runner: Runner) -> Self {
        Run { runner, revision: Revision::default(), is_driven: false, device: (None, None) }
    }

    /// The runner.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// Returns the current revision.
    pub(crate) fn revision(&self) -> Revision {
        self.revision
    }

    /// Changes state, model, settings or precision: every earlier reading becomes void.
    pub(super) fn change<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        self.revision.0 += 1;
        self.is_driven = false;
        if let Some(device) = &mut self.device.0 {
            device.renew();
        }
        change(&mut self.runner)
    }

    /// Takes a step from the current moment. If it renews the automatic substeps, this voids every
    /// reading but those that are carried over.
    pub(super) fn step(&mut self, now: &Moment) -> Result<(), Error> {
        let before = self.runner.settings();
        self.runner.bound_work();
        let stepped = self.step_anywhere(now);
        if self.runner.settings() != before {
            self.revision.0 += 1;
        }
        stepped
    }

    /// Takes a step by the device, if there is one, or by the processor.
    fn step_anywhere(&mut self, before: &Moment) -> Result<(), Error> {
        let Some(device) = &mut self.device.0 else { return self.runner.step() };
        let Err(error) = device.step(&mut self.runner) else { return Ok(()) };
        let differs = matches!(error, GpuError::Differs { .. });
        self.end_device(error)?;
        if differs {
            // History and recording hold the steps since then.
            self.runner.go_back(before)?;
        }
        if before.steps < self.runner.steps() { Ok(()) } else { self.runner.step() }
    }

    /// Returns whether the next step can be taken now: a device may still be computing it.
    pub(super) fn is_ready(&mut self) -> bool {
        let Some(device) = &mut self.device.0 else { return true };
        // A step that fails on the processor fails there again.
        device.is_ready(&mut self.runner).unwrap_or_else(|error| self.end_device(error).is_err())
    }

    /// Gives the device up, unless a step has failed as it does on the processor.
    fn end_device(&mut self, error: GpuError) -> Result<(), Error> {
        match failure_of(error) {
            Ok(error) => Err(error),
            Err(reason) => {
                self.device = (None, Some(reason));
                Ok(())
            }
        }
    }

    /// The device that takes its steps.
    pub fn device(&self) -> Option<&DeviceRun> {
        self.device.0.as_deref()
    }

    /// Takes the reason why the device ended.
    pub(super) fn take_end_of_device(&mut self) -> Option<String> {
        self.device.1.take()
    }

    /// Lets a device take the steps to come, or the processor.
    ///
    /// # Errors
    /// See [`DeviceRun::new`]; nothing changes then.
    pub(super) fn set_device(&mut self, device: Option<Device>) -> Result<(), GpuError> {
        let device = device.map(|device| DeviceRun::new(device, &self.runner)).transpose()?;
        self.device = (device.map(Box::new), None);
        Ok(())
    }

    /// Works for a part of a frame on the choice of automatic substeps before the next step;
    /// returns whether the choice is complete. A change of the substeps voids every reading.
    pub(super) fn prepare(
        &mut self,
        estimator: &mut Estimator,
        stopwatch: &impl Fn() -> f64,
    ) -> Result<bool, Error> {
        let (before, start) = (self.runner.settings(), stopwatch());
        while self.runner.prepare(estimator)? {
            if PREDICTING < stopwatch() - start && self.runner.settings() == before {
                return Ok(false);
            }
        }
        if self.runner.settings() != before {
            self.revision.0 += 1;
        }
        Ok(true)
    }

    /// Returns whether gusts do work: the energy balance then does not measure the method.
    pub(crate) fn is_driven(&self) -> bool {
        self.is_driven
    }

    /// Sets a look, on which no reading depends.
    pub(super) fn paint(&mut self, look: Interaction) -> Result<(), Error> {
        act(&mut self.runner, look)
    }

    /// Moves the target of an existing grab or pin, or updates a gust.
    pub(super) fn move_held(&mut self, motion: Interaction) -> Result<(), Error> {
        self.is_driven |= matches!(motion, Interaction::SetForce { .. });
        if let Some(device) = &mut self.device.0 {
            device.void();
        }
        act(&mut self.runner, motion)
    }
}

/// Opens a run for display.
pub(super) fn open(loaded: &Loaded, solver: Solver) -> Result<Runner, Error> {
    let open = if IS_LAZY { Runner::open_lazily } else { Runner::open_with };
    let mut runner = open(loaded, solver)?;
    // The session sets gusts itself, in order to record them.
    runner.calm();
    Ok(runner)
}

/// Applies an interaction at once.
pub(super) fn act(runner: &mut Runner, interaction: Interaction) -> Result<(), Error> {
    runner.queue(interaction).and_then(|()| runner.apply_queued())
}

/// A value read from a run, accessible until the run is changed.
#[derive(Clone, Debug)]
pub struct Reading<T> {
    value: T,
    of: Revision,
}

impl<T> Reading<T> {
    /// Returns a value just read.
    pub(super) fn new(value: T, run: &Run) -> Self {
        Reading { value, of: run.revision }
    }

    /// Returns the value, unless the run was changed since.
    pub fn of(&self, run: &Run) -> Option<&T> {
        (self.of == run.revision).then_some(&self.value)
    }

    /// Keeps a value of an earlier revision if the change since does not affect it.
    pub(super) fn carry_over(&mut self, from: Revision, run: &Run) {
        if self.of == from {
            self.of = run.revision;
        }
    }

    /// Returns the value for an update, unless the run was changed since.
    pub(super) fn of_mut(&mut self, run: &Run) -> Option<&mut T> {
        (self.of == run.revision).then_some(&mut self.value)
    }
}
