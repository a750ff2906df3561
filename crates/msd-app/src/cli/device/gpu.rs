//! A graphics adapter that takes the steps of a run, and the list of all.

use super::adapter::{MOST_RACED, open_adapter, refusal, renew, simulation_of, steps_of_race};
use super::{DeviceSteps, Refusal, Stop};
use crate::cli::arguments::{DeviceChoice, ListArguments};
use crate::cli::failure::{Failure, aligned, say, say_json};
use msd_core::Simulation;
use msd_film::quietly;
use msd_gpu::{Device, GpuError, GpuSimulation, Tally, adapters};
use msd_run::Runner;
use msd_study::quantity::quantity;
use pollster::block_on;
use serde::Serialize;
use web_time::Instant;
use wgpu::DeviceType;

/// An adapter of this machine; the keys of `--json`.
#[derive(Serialize)]
struct DeviceRow {
    name: String,
    /// Discrete, integrated, virtual, software or other.
    kind: &'static str,
    backend: String,
    driver: String,
    /// same-bits, differs or unusable.
    verdict: &'static str,
    /// The verdict in words.
    reason: String,
}

/// A device with the bits of the processor that takes the steps of a run.
pub struct Gpu {
    simulation: GpuSimulation,
    verdict: String,
}

impl Gpu {
    /// Opens the device of a choice, and checks its bits.
    pub fn open(choice: &DeviceChoice, runner: &Runner) -> Result<Self, Refusal> {
        let simulation = simulation_of(runner)?;
        quietly(|| Gpu::on(open_adapter(choice)?, simulation))
    }

    /// Prepares a device with its verdict.
    fn on((device, verdict): (Device, String), of: &Simulation<f32>) -> Result<Self, Refusal> {
        let simulation = block_on(GpuSimulation::new(&device, of)).map_err(refusal)?;
        Ok(Gpu { simulation, verdict })
    }

    /// Times steps of a copy of a run on both; returns the times in words if the device is faster.
    pub fn win_race(&mut self, runner: &Runner) -> Result<String, Refusal> {
        let (mut here, mut there) = (runner.clone(), runner.clone());
        let name = self.name();
        let failed = |_| Refusal::new("a copy of the run diverged while msd timed it", "");
        let lost = || Refusal::new(format!("{name} failed while msd timed it"), "");
        let first = timed(1, |_| here.step()).map_err(failed)?;
        let steps = steps_of_race(first, MOST_RACED);
        let ours = timed(steps, |_| here.step()).map_err(failed)?;
        // The first batch warms up the device.
        let mut batch = |steps: u64| {
            let whole = timed(1, |_| match self.advance(&mut there, steps) {
                Ok(None) => Ok(()),
                Ok(Some(_)) | Err(_) => Err(lost()),
            })?;
            Ok(whole / steps as f64)
        };
        let first = batch(1)?;
        let steps = steps_of_race(first, steps);
        let theirs = batch(steps)?;
        let [mine, its] = [ours, theirs].map(|seconds| quantity(seconds, "s"));
        if theirs < ours {
            // Without the steps of the race.
            let anew = GpuSimulation::new(self.simulation.device(), simulation_of(runner)?);
            self.simulation = block_on(anew).map_err(refusal)?;
            return Ok(format!("{its} per step, {mine} on the processor; {}", self.verdict));
        }
        Err(Refusal::new(format!("a step takes {mine}, and {its} on {name}"), ""))
    }

    /// The name of the adapter.
    pub fn name(&self) -> String {
        self.simulation.device().name()
    }

    /// The verdict on its bits, in words.
    pub fn verdict(&self) -> &str {
        &self.verdict
    }

    /// Steps that it took, and those of them that the processor has taken again.
    pub fn steps(&self) -> DeviceSteps {
        let Tally { device, checked, .. } = self.simulation.tally();
        DeviceSteps { device, checked }
    }

    /// Waits for the check of a step that is under way.
    pub fn finish(&mut self, runner: &mut Runner) -> Result<(), Stop> {
        let Runner::F32(simulation, _) = runner else { unreachable!("refused when it was opened") };
        let checked = self.simulation.finish_check(simulation);
        checked.map_err(|error| Stop::Device(Failure::input(error)))
    }

    /// Takes so many steps; returns why the device took no more, if it was lost.
    pub fn advance(&mut self, runner: &mut Runner, steps: u64) -> Result<Option<String>, Stop> {
        let Runner::F32(simulation, _) = runner else { unreachable!("refused when it was opened") };
        match self.simulation.advance(simulation, steps) {
            Ok(()) => Ok(None),
            Err(GpuError::Step(error)) => Err(Stop::Step(error)),
            Err(error @ (GpuError::Lost { .. } | GpuError::Refused { .. })) => {
                Ok(Some(error.to_string()))
            }
            Err(error) => Err(Stop::Device(Failure::input(error))),
        }
    }

    /// Uploads the state of a run, to compute steps from it.
    pub fn upload(&mut self, runner: &Runner) -> Result<(), Failure> {
        let Runner::F32(simulation, _) = runner else { unreachable!("refused when it was opened") };
        self.simulation.compute(simulation, 0).map_err(Failure::input)
    }

    /// Computes so many steps and waits for them; nothing is read back.
    pub fn compute(&mut self, steps: u64) -> Result<(), Failure> {
        self.simulation.compute_on(steps).map_err(Failure::input)
    }

    /// Refuses computed steps of which the device left one to the processor.
    pub fn check_computed(&mut self) -> Result<(), Failure> {
        let outcome = self.simulation.finish_computing().map_err(Failure::input)?;
        if !outcome.refused {
            return Ok(());
        }
        let name = self.name();
        Err(Failure::input(format!("{name} left a step to the processor: no speed measured")))
    }
}

/// The seconds of each of so many steps.
fn timed<E>(steps: u64, step: impl FnMut(u64) -> Result<(), E>) -> Result<f64, E> {
    let start = Instant::now();
    (0..steps).try_for_each(step)?;
    Ok(start.elapsed().as_secs_f64() / steps as f64)
}

/// Lists the adapters, each with the verdict on its bits.
pub fn run_devices(arguments: &ListArguments) -> Result<(), Failure> {
    let rows: Vec<DeviceRow> = quietly(|| block_on(adapters()).iter().map(row).collect());
    if arguments.json {
        return say_json(&rows);
    }
    if rows.is_empty() {
        return say("no graphics adapter: msd runs on the processor");
    }
    let cells =
        |row: DeviceRow| [row.name, row.kind.to_owned(), row.backend, row.driver, row.reason];
    let rows: Vec<_> = rows.into_iter().map(cells).collect();
    say(&aligned(&rows, &[]).join("\n"))
}

fn row(adapter: &wgpu::Adapter) -> DeviceRow {
    let info = adapter.get_info();
    let checked = block_on(Device::of_adapter(adapter)).and_then(|device| renew(&device));
    let (verdict, reason) = match &checked {
        Ok(verdict) if verdict.manner().is_some() => ("same-bits", verdict.to_string()),
        Ok(verdict) => ("differs", verdict.to_string()),
        Err(error) => ("unusable", error.to_string()),
    };
    DeviceRow {
        name: info.name,
        kind: match info.device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "software",
            DeviceType::Other => "other",
        },
        backend: info.backend.to_string(),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        verdict,
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Stepper;
    use super::super::adapter::judged;
    use super::*;
    use msd_scene::state_hash;

    #[test]
    fn a_run_goes_on_on_the_processor_if_its_device_is_lost() {
        let Ok(device) = quietly(|| block_on(Device::open(""))) else {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter");
            return println!("SKIPPED: no adapter");
        };
        let loaded = msd_scene::open("jelly").expect("a built-in scene");
        let mut runner = Runner::open(&loaded).expect("a valid scene");
        let mut alone = runner.clone();
        let adapter = judged(device.clone()).expect("the same bits");
        let simulation = simulation_of(&runner).expect("a scene of springs");
        let gpu = Gpu::on(adapter, simulation).expect("a scene that fits");
        let mut stepper = Stepper::of(Some(gpu));
        let mut advance = |steps| stepper.advance(&mut runner, steps).expect("no failure");
        assert_eq!(advance(3), None);
        device.lose();
        let warning = advance(3).expect("a warning");
        assert!(warning.ends_with("; the run continues on the processor"), "{warning}");
        assert_eq!(advance(3), None);
        assert_eq!(stepper.taken().device, 3);
        let steps = runner.steps();
        (0..steps).for_each(|_| alone.step().expect("a step"));
        assert_eq!(state_hash(&runner.state()), state_hash(&alone.state()));
        assert!(6 <= steps, "{steps}");
    }
}
