//! The adapter of a choice, and the verdict on its bits, which the cache keeps.

use super::Refusal;
use crate::cli::arguments::DeviceChoice;
use msd_app::steppable::{Unsteppable, steppable};
use msd_core::{Settings, Simulation};
use msd_gpu::{Device, GpuError, Verdict, manners, probe, sources};
use msd_run::Runner;
use msd_study::{cache, machine};
use pollster::block_on;
use std::time::SystemTime;

/// Name of verdicts in the cache.
const VERDICT: &str = "verdict";
/// Time of each side of a race between a device and the processor, seconds, and its most steps.
const RACE: f64 = 0.1;
pub const MOST_RACED: u64 = 256;
/// Advice where a device does not step a run.
pub const ADVICE: &str = "run the scene on the processor (--device cpu)";

/// Opens the first adapter of a choice and sets the manner in which it has the bits of the
/// processor; returns it with the verdict in words. Refuses an adapter that has other bits.
pub fn open_adapter(choice: &DeviceChoice) -> Result<(Device, String), Refusal> {
    let name = if let DeviceChoice::Named(name) = choice { name } else { "" };
    judged(block_on(Device::open(name)).map_err(refusal)?)
}

/// Checks the bits of a device, unless the cache holds the verdict of an earlier command.
pub fn judged(device: Device) -> Result<(Device, String), Refusal> {
    let verdict = known(&device).map_or_else(|| renew(&device), Ok).map_err(refusal)?;
    let manner = verdict.manner().ok_or_else(|| {
        let why = format!("{} computes {verdict}", device.name());
        Refusal::new(why, "use the processor (--device cpu) or another adapter")
    })?;
    Ok((device.with_manner(manner), verdict.to_string()))
}

/// The verdict that the cache holds on a device. It holds those with the same bits alone: of any
/// other, a new driver or a new msd may be better.
fn known(device: &Device) -> Option<Verdict> {
    let name: String = cache::get(VERDICT, &key(device))?;
    let manner = manners().find(|manner| format!("{manner:?}") == name)?;
    Some(Verdict::SameBits(manner))
}

/// Checks the bits of a device, and renews the verdict in the cache.
pub fn renew(device: &Device) -> Result<Verdict, GpuError> {
    let key = key(device);
    let verdict = block_on(probe(device));
    match verdict.as_ref().ok().and_then(Verdict::manner) {
        Some(manner) => cache::put(VERDICT, &key, &format!("{manner:?}")),
        None => cache::remove(VERDICT, &key),
    }
    verdict
}

/// The hash of all that a verdict depends on: adapter, driver and processor (which computes for an
/// adapter in software); the version of msd, its programs, and the file of msd, whose libraries
/// translate the programs for the driver.
fn key(device: &Device) -> String {
    let info = device.info();
    let adapter = (&info.name, info.vendor, info.device, format!("{:?}", info.device_type));
    let driver = (&info.driver, &info.driver_info, info.backend.to_string());
    let file = std::env::current_exe().and_then(std::fs::metadata).ok().map(|file| {
        let changed = file.modified().ok();
        let since = changed.and_then(|time| time.duration_since(SystemTime::UNIX_EPOCH).ok());
        (file.len(), since)
    });
    cache::content_hash(&(adapter, driver, machine::name(), sources(), file))
}

/// The simulation of a run that a device steps with the same bits.
pub fn simulation_of(runner: &Runner) -> Result<&Simulation<f32>, Refusal> {
    let simulation = steppable(runner).map_err(|why| {
        let advice = match &why {
            Unsteppable::F64 => "add --precision f32".to_owned(),
            Unsteppable::Automatic => {
                format!("add --substeps {}, the first choice of auto", first_choice(runner))
            }
            Unsteppable::Part(_) => ADVICE.to_owned(),
        };
        Refusal::new(GpuError::from(why), &advice)
    })?;
    check_calm(runner)?;
    Ok(simulation)
}

/// The steps that one side of a race takes, by the seconds of its first step, and at most so many.
pub fn steps_of_race(first: f64, most: u64) -> u64 {
    ((RACE / first.max(1e-9)) as u64).clamp(1, most)
}

/// Refuses a run in gusts of wind, which change the force in each step.
pub fn check_calm(runner: &Runner) -> Result<(), Refusal> {
    match runner.gust() {
        Some(_) => Err(refusal(GpuError::Unsupported("gusts of wind".to_owned()))),
        None => Ok(()),
    }
}

/// The substeps per frame that automatic ones have chosen first.
pub fn first_choice(runner: &Runner) -> f64 {
    let (Settings { step, substeps, .. }, frame) = (runner.settings(), 1.0 / 60.0);
    (f64::from(substeps) * frame / step - 1e-6).ceil()
}

/// The refusal of an error.
pub fn refusal(error: GpuError) -> Refusal {
    let advice = if matches!(error, GpuError::NoAdapter(_)) { "" } else { ADVICE };
    Refusal::new(error, advice)
}
