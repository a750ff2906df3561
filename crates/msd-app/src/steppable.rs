//! The runs that a graphics device steps.

use msd_core::Simulation;
use msd_gpu::{GpuError, GpuSimulation};
use msd_run::Runner;

/// Why a device does not step a run.
#[derive(Debug)]
pub enum Unsteppable {
    /// It is in double precision.
    F64,
    /// It has a part that a device does not step.
    Part(GpuError),
    /// It chooses its substeps by the energy of each step, which a device does not measure.
    Automatic,
}

impl From<Unsteppable> for GpuError {
    fn from(why: Unsteppable) -> Self {
        let what = match why {
            Unsteppable::Part(error) => return error,
            Unsteppable::F64 => "f64",
            Unsteppable::Automatic => "automatic substeps, which depend on the energy of each step",
        };
        GpuError::Unsupported(what.to_owned())
    }
}

/// Returns the simulation of a run that a device steps, whatever the device.
///
/// # Errors
/// Why none does.
pub fn steppable(runner: &Runner) -> Result<&Simulation<f32>, Unsteppable> {
    let Runner::F32(simulation, _) = runner else { return Err(Unsteppable::F64) };
    GpuSimulation::check_supported(simulation).map_err(Unsteppable::Part)?;
    if runner.is_automatic() {
        return Err(Unsteppable::Automatic);
    }
    Ok(simulation)
}
