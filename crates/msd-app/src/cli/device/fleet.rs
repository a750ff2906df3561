//! A graphics adapter that takes the steps of many runs at once: sweeps, studies and tuning.

use super::Refusal;
use super::adapter::{
    ADVICE, MOST_RACED, check_calm, first_choice, open_adapter, refusal, steps_of_race,
};
use crate::cli::arguments::DeviceChoice;
use msd_app::steppable::{Unsteppable, steppable};
use msd_core::{Error, Integrator, Scene, Settings, Simulation};
use msd_film::quietly;
use msd_gpu::{Device, Ensemble, GpuError};
use msd_run::Runner;
use msd_scene::Precision;
use msd_study::device::{Device as StudyDevice, LoadError};
use msd_study::quantity::quantity;
use pollster::block_on;
use std::thread;
use web_time::Instant;

/// Runs that each thread of the processor steps in a race, at most.
const EACH: usize = 8;

/// A device with the bits of the processor that steps many runs at once.
pub struct GpuFleet {
    device: Device,
    verdict: String,
    ensemble: Option<Ensemble>,
}

impl GpuFleet {
    /// Opens the device of a choice, and checks its bits.
    pub fn open(choice: &DeviceChoice) -> Result<Self, Refusal> {
        let (device, verdict) = quietly(|| open_adapter(choice))?;
        Ok(GpuFleet { device, verdict, ensemble: None })
    }

    /// The verdict on its bits, in words.
    pub fn verdict(&self) -> &str {
        &self.verdict
    }

    /// Times steps of runs of one pace on both, with so many threads of the processor; returns the
    /// times in words if the device is faster.
    pub fn win_race(&mut self, runners: &[Runner], jobs: usize) -> Result<String, Refusal> {
        let name = self.name();
        let count = runners.len();
        let threads = jobs.min(count);
        let mut here: Vec<Runner> = runners.iter().take(EACH * threads).cloned().collect();
        let part = here.len() as f64 / count as f64;
        let ours = timed(|steps| step_all(&mut here, threads, steps)) / part;
        let mut there = runners.to_vec();
        let lost =
            |why: String| Refusal::new(format!("{name} failed while msd timed it: {why}"), "");
        self.load(&there).map_err(|why| lost(why.into()))?;
        // The first steps warm up the device.
        self.advance(&mut there, 1).map_err(lost)?;
        let mut failed = None;
        let theirs = timed(|steps| {
            failed = self.advance(&mut there, steps).err().or(failed.take());
        });
        failed.map_or(Ok(()), |why| Err(lost(why)))?;
        let [mine, its] = [ours, theirs].map(|seconds| quantity(seconds, "s"));
        let (cells, steps) = (format!("a step of {count} cells takes"), "on the processor");
        if theirs < ours {
            return Ok(format!("{cells} {its}, {mine} {steps}; {}", self.verdict));
        }
        Err(Refusal::new(format!("{cells} {mine}, and {its} on {name}"), ""))
    }
}

impl StudyDevice for GpuFleet {
    fn name(&self) -> String {
        self.device.name()
    }

    fn takes(&self, runner: &Runner) -> bool {
        check_cell(runner).is_ok()
    }

    fn load(&mut self, runners: &[Runner]) -> Result<(), LoadError> {
        let told = |error: GpuError| match error {
            GpuError::TooLarge { .. } | GpuError::Refused { .. } => {
                LoadError::TooLarge(error.to_string())
            }
            error => LoadError::Failed(error.to_string()),
        };
        // The one before it frees its memory first.
        self.ensemble = None;
        let simulations: Result<Vec<_>, _> = runners.iter().map(steppable).collect();
        let simulations = simulations.map_err(|why| told(why.into()))?;
        self.ensemble = Some(block_on(Ensemble::new(&self.device, &simulations)).map_err(told)?);
        Ok(())
    }

    fn advance(
        &mut self,
        runners: &mut [Runner],
        steps: u64,
    ) -> Result<Vec<Option<Error>>, String> {
        let Some(ensemble) = &mut self.ensemble else { return Err("no runs are loaded".into()) };
        let mut simulations: Vec<_> = runners.iter_mut().filter_map(single).collect();
        let ended = ensemble.advance(&mut simulations, steps);
        ended.map(<[_]>::to_vec).map_err(|error| error.to_string())
    }

    fn finish(&mut self) -> Result<(), String> {
        let checked = self.ensemble.as_mut().map_or(Ok(()), Ensemble::finish_check);
        checked.map_err(|error| error.to_string())
    }
}

/// The simulation of a run in single precision.
fn single(runner: &mut Runner) -> Option<&mut Simulation<f32>> {
    let Runner::F32(simulation, _) = runner else { return None };
    Some(simulation)
}

/// Takes steps of runs on threads of the processor; one that fails ends its run.
fn step_all(runners: &mut [Runner], threads: usize, steps: u64) {
    let part = runners.len().div_ceil(threads.max(1)).max(1);
    thread::scope(|scope| {
        for part in runners.chunks_mut(part) {
            scope.spawn(move || {
                for runner in part {
                    let _ = (0..steps).try_for_each(|_| runner.step());
                }
            });
        }
    });
}

/// The seconds of a step, from about as many steps as take the time of a race.
fn timed(mut steps: impl FnMut(u64)) -> f64 {
    let mut seconds = |count: u64| {
        let start = Instant::now();
        steps(count);
        start.elapsed().as_secs_f64() / count as f64
    };
    let first = seconds(1);
    seconds(steps_of_race(first, MOST_RACED))
}

/// Refuses a cell of a sweep that a device does not step.
pub fn check_cell(runner: &Runner) -> Result<(), Refusal> {
    if let Err(why) = steppable(runner) {
        let advice = match &why {
            Unsteppable::F64 => "set solver.precision = \"f32\" in the grid or the scene".into(),
            Unsteppable::Automatic => {
                let count = first_choice(runner);
                format!("set solver.substeps = {count}, the first choice of \"auto\"")
            }
            Unsteppable::Part(_) => ADVICE.replace("scene", "sweep"),
        };
        return Err(Refusal::new(GpuError::from(why), &advice));
    }
    check_calm(runner)
}

/// Opens a device that times settings of a scene; returns also a note on it. Refuses a scene of
/// which a device steps no setting.
pub fn open_for_settings(
    choice: &DeviceChoice,
    scene: &Scene,
) -> Result<(GpuFleet, String), Refusal> {
    let settings = Settings { integrator: Integrator::VelocityVerlet, ..Settings::default() };
    // A scene that does not run is refused by whoever runs it.
    if let Ok(runner) = Runner::new(scene, settings, Precision::F32) {
        steppable(&runner).map_err(|why| refusal(why.into()))?;
    }
    let fleet = GpuFleet::open(choice)?;
    let note = format!("{}, {}", fleet.name(), fleet.verdict());
    Ok((fleet, note))
}
