//! Errors of `--device` in a build without the feature `gpu`.

use super::{DeviceSteps, Refusal, Stop};
use crate::cli::arguments::{DeviceChoice, ListArguments};
use crate::cli::failure::Failure;
use msd_core::{Error, Scene};
use msd_run::Runner;
use msd_study::device::{Device, LoadError};

/// Advice of this build.
const ADVICE: &str = "build it with the default features";
const WHY: &str = "this build of msd does not step on a GPU";

/// The device, which is not there.
pub enum NoGpu {}

impl NoGpu {
    pub fn open(_: &DeviceChoice, _: &Runner) -> Result<Self, Refusal> {
        Err(Refusal::new(WHY, ADVICE))
    }

    pub fn win_race(&mut self, _: &Runner) -> Result<String, Refusal> {
        match *self {}
    }

    pub fn name(&self) -> String {
        match *self {}
    }

    pub fn verdict(&self) -> &str {
        match *self {}
    }

    pub fn steps(&self) -> DeviceSteps {
        match *self {}
    }

    pub fn advance(&mut self, _: &mut Runner, _: u64) -> Result<Option<String>, Stop> {
        match *self {}
    }

    pub fn finish(&mut self, _: &mut Runner) -> Result<(), Stop> {
        match *self {}
    }

    pub fn upload(&mut self, _: &Runner) -> Result<(), Failure> {
        match *self {}
    }

    pub fn compute(&mut self, _: u64) -> Result<(), Failure> {
        match *self {}
    }

    pub fn check_computed(&mut self) -> Result<(), Failure> {
        match *self {}
    }
}

/// The device of many runs, which is not there.
pub enum NoFleet {}

impl NoFleet {
    pub fn open(_: &DeviceChoice) -> Result<Self, Refusal> {
        Err(Refusal::new(WHY, ADVICE))
    }

    pub fn verdict(&self) -> &str {
        match *self {}
    }

    pub fn win_race(&mut self, _: &[Runner], _: usize) -> Result<String, Refusal> {
        match *self {}
    }
}

impl Device for NoFleet {
    fn name(&self) -> String {
        match *self {}
    }

    fn takes(&self, _: &Runner) -> bool {
        match *self {}
    }

    fn load(&mut self, _: &[Runner]) -> Result<(), LoadError> {
        match *self {}
    }

    fn advance(&mut self, _: &mut [Runner], _: u64) -> Result<Vec<Option<Error>>, String> {
        match *self {}
    }

    fn finish(&mut self) -> Result<(), String> {
        match *self {}
    }
}

/// Refuses every cell of a sweep.
pub fn check_cell(_: &Runner) -> Result<(), Refusal> {
    Err(Refusal::new(WHY, ADVICE))
}

/// Refuses every scene.
pub fn open_for_settings(_: &DeviceChoice, _: &Scene) -> Result<(NoFleet, String), Refusal> {
    Err(Refusal::new(WHY, ADVICE))
}

/// Refuses `msd devices`.
pub fn run_devices(_: &ListArguments) -> Result<(), Failure> {
    Err(Failure::input(format!("{WHY}: {ADVICE}")))
}
