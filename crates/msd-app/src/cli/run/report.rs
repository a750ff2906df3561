//! The report of a run: a summary, or one JSON object.

use super::prepare::Prepared;
use crate::cli::device::DeviceSteps;
use msd_core::methods::Solved;
use msd_core::{Contacts, Integrator, Momentum};
use msd_run::{EnergyReport, Finding, Kind, Overturned, Pierced, Runner, Touched};
use msd_scene::{Precision, SetKeys, state_hash};
use msd_study::quantity::{counted, number, quantity, rounded};
use serde::Serialize;
use serde_json::{Value, json};

/// Result of a run, the keys of `--json`. A test checks that `docs/reference/command-line.md`
/// explains each of them.
#[derive(Debug, Serialize)]
pub struct RunReport {
    pub scene: String,
    pub set: SetKeys,
    pub particles: usize,
    pub springs: usize,
    pub integrator: Integrator,
    pub step: f64,
    pub substeps: u32,
    pub automatic: Option<Chosen>,
    pub tolerance: Option<f64>,
    pub newton: Option<u32>,
    pub precision: Precision,
    pub duration: f64,
    pub time: f64,
    pub steps: u64,
    pub device: String,
    pub device_steps: u64,
    pub checked_steps: u64,
    pub processor_steps: u64,
    pub wall_seconds: f64,
    pub spring_updates_per_second: Option<f64>,
    pub real_time_factor: Option<f64>,
    pub energy: EnergyReport,
    pub contacts: Option<Contacts>,
    pub touched: Option<Touched>,
    pub most_crossings: Option<Value>,
    pub pierced: Option<Pierced>,
    pub overturned: Option<Overturned>,
    pub momentum: Momentum,
    pub stable_step: Option<f64>,
    pub state_hash: String,
    pub energy_gain: Option<Value>,
    pub energy_loss: Option<f64>,
    pub imbalance: Option<f64>,
    pub solved: Option<Solved>,
    pub diverged: bool,
    pub interrupted: bool,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
    pub findings: Vec<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replay: Option<Comparison>,
}

/// Automatic substeps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Chosen {
    /// Smallest number of a step.
    pub least: u32,
    /// Largest number of a step.
    pub most: u32,
}

impl Chosen {
    /// Updates the range with the substeps of a step.
    pub fn now(before: Option<Chosen>, substeps: u32) -> Chosen {
        let Chosen { least, most } = before.unwrap_or(Chosen { least: substeps, most: substeps });
        Chosen { least: least.min(substeps), most: most.max(substeps) }
    }

    /// Formats the lengths of the shortest and the longest substep.
    fn lengths(&self, step: f64) -> String {
        let [shortest, longest] =
            [self.most, self.least].map(|count| quantity(step / f64::from(count), "s"));
        format!("{shortest} to {longest}")
    }

    fn summary(&self, step: f64, last: u32) -> String {
        let Chosen { least, most } = self;
        let range = match least == most {
            true => least.to_string(),
            false => format!("{least} to {most}, at the end {last},"),
        };
        format!("substeps chosen: {range} in each {}", quantity(step, "s"))
    }
}

/// Totals of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done {
    /// Steps taken.
    pub steps: u64,
    /// Substeps taken.
    pub substeps: u64,
    /// Steps that a graphics device took.
    pub on_device: DeviceSteps,
    /// Automatic substeps.
    pub chosen: Option<Chosen>,
    /// Time simulated, seconds.
    pub simulated: f64,
    /// Time that the steps took, seconds.
    pub wall: f64,
    /// Whether the run diverged.
    pub diverged: bool,
    /// Whether the user interrupted the run.
    pub interrupted: bool,
}

impl Done {
    /// Notes steps of a run.
    pub fn note(&mut self, runner: &Runner, steps: u64) {
        let substeps = runner.settings().substeps;
        self.steps += steps;
        self.substeps += steps * u64::from(substeps);
        if runner.is_automatic() && !runner.integrator().is_adaptive() {
            self.chosen = Some(Chosen::now(self.chosen, substeps));
        }
    }
}

/// Comparison of a replay with its recording.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Hash of the last recorded state, hexadecimal; null if the recording was cut short.
    pub recorded_hash: Option<String>,
    /// Whether the replay ended in that state to the bit. Null if the recording was cut short, or
    /// the replay diverged or was interrupted.
    pub same_bits: Option<bool>,
    /// Whether the end of the recording is missing.
    pub cut_short: bool,
    /// Bytes at its end that `--salvage` dropped; else 0.
    pub lost_bytes: usize,
    /// For a replay with another solver: distance from the recorded run at the end.
    pub apart: Option<Distance>,
}

/// Distance between two runs.
#[derive(Debug, Serialize)]
pub struct Distance {
    /// The solver of the recorded run.
    pub recorded_integrator: Integrator,
    /// Root of the mean square distance of the particles, metres.
    pub rms: f64,
    /// The largest distance of a particle, metres.
    pub max: f64,
    /// The particle with this distance.
    pub particle: usize,
    /// Size of the scene, metres.
    pub size: f64,
    /// Time at which the root mean square distance passed 1 % of the size, seconds; null if never.
    pub noticeable_at: Option<f64>,
}

impl Comparison {
    fn summary(&self) -> String {
        let Some(apart) = &self.apart else {
            return match self.same_bits {
                Some(true) => "replayed to the same bits".into(),
                Some(false) => "replayed to a different state".into(),
                None => "replayed the intact part".into(),
            };
        };
        let Distance { recorded_integrator, rms, max, particle, size, noticeable_at } = apart;
        let size = quantity(*size, "m");
        let noticed = match noticeable_at {
            Some(time) => {
                format!("1 % of the size of {size} was passed at {}", quantity(*time, "s"))
            }
            None => format!("never more than 1 % of the size of {size}"),
        };
        let [rms, max] = [rms, max].map(|&length| quantity(length, "m"));
        format!(
            "from the recorded run ({recorded_integrator}): {rms} rms, {max} at most (particle \
             {particle}); {noticed}"
        )
    }
}

/// Returns the evaluations of each spring per integration step, without the one that starts a step
/// of Verlet; `None` if their number depends on the motion.
pub fn evaluations(integrator: Integrator) -> Option<u64> {
    match integrator {
        Integrator::Rk4 => Some(4),
        Integrator::DormandPrince | Integrator::BackwardEuler | Integrator::ImplicitMidpoint => {
            None
        }
        _ => Some(1),
    }
}

/// Returns a finding with its words.
fn in_words(finding: &Finding) -> Value {
    let mut value = serde_json::to_value(finding).unwrap_or_default();
    value["sentence"] = finding.sentence().into();
    value["advice"] = finding.advice().into();
    value
}

impl RunReport {
    /// Collects the results of a run.
    pub fn new(prepared: Prepared, done: Done) -> Self {
        let Prepared { name, notes, runner, stable, warnings, watch, .. } = prepared;
        let settings = runner.settings();
        let adaptive = settings.integrator.is_adaptive();
        let substeps = if adaptive { 1 } else { settings.substeps };
        let steps = if adaptive { done.steps } else { done.substeps };
        // Only fixed substeps are taken on a device.
        let DeviceSteps { device, checked } = done.on_device.times(substeps.into());
        let findings = watch.findings(&runner);
        let find = |is: fn(&Kind) -> bool| findings.iter().find(|finding| is(&finding.kind));
        let gain = find(|kind| matches!(kind, Kind::EnergyAdded | Kind::TooSoft { .. }));
        let loss = find(|kind| matches!(kind, Kind::EnergyLost | Kind::Damped));
        let crossed = find(|kind| matches!(kind, Kind::CrossingTriangles));
        let crossed = crossed.map(|found| json!({ "pairs": found.worst as u64, "time": found.at }));
        let energy = EnergyReport::from(runner.energy());
        let imbalance =
            (!watch.is_handled() && energy.is_measured()).then(|| watch.read().witness.imbalance());
        let springs = runner.spring_count() as u64;
        let updates = evaluations(settings.integrator).map(|each| (steps * each * springs) as f64);
        let per_wall_second = |amount: f64| (0.0 < done.wall).then_some(amount / done.wall);
        RunReport {
            scene: name,
            set: SetKeys::new(),
            particles: runner.particle_count(),
            springs: runner.spring_count(),
            integrator: settings.integrator,
            step: settings.step / f64::from(substeps),
            substeps,
            automatic: done.chosen,
            tolerance: adaptive.then_some(settings.tolerance),
            newton: settings.integrator.is_implicit().then_some(settings.newton),
            precision: runner.precision(),
            duration: done.simulated,
            time: runner.time(),
            steps,
            device: "processor".to_owned(),
            device_steps: device,
            checked_steps: checked,
            processor_steps: steps - device,
            wall_seconds: done.wall,
            spring_updates_per_second: updates.and_then(per_wall_second),
            real_time_factor: per_wall_second(done.simulated),
            energy,
            contacts: energy.is_measured().then(|| runner.contacts()),
            touched: runner.touched(),
            most_crossings: crossed,
            pierced: watch.read().pierced,
            overturned: watch.read().overturned,
            momentum: runner.momentum(),
            stable_step: stable.is_finite().then_some(stable),
            state_hash: format!("{:016x}", state_hash(&runner.state())),
            energy_gain: gain.map(|found| json!({ "joules": found.worst, "since": found.since })),
            energy_loss: loss.map(|found| found.worst),
            imbalance,
            solved: watch.read().solved,
            diverged: done.diverged,
            interrupted: done.interrupted,
            notes,
            warnings,
            findings: findings.iter().map(in_words).collect(),
            replay: None,
        }
    }

    /// Formats the report as one JSON object.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }

    /// Formats the report as a summary for the user.
    pub fn summary(&self) -> String {
        let mut lines = self.notes.clone();
        let RunReport { scene, particles, springs, integrator, precision, .. } = self;
        let springs = counted(*springs as u64, "spring");
        lines.push(format!(
            "{scene}: {particles} particles, {springs}, {integrator} in {precision}"
        ));
        let stable = match self.stable_step {
            Some(0.0) => "no step is predicted to be stable".into(),
            Some(stable) => format!("predicted to be stable up to {}", quantity(stable, "s")),
            None => "any step is stable".into(),
        };
        let row = self.step * f64::from(self.substeps);
        lines.push(match self.automatic.filter(|chosen| chosen.least < chosen.most) {
            Some(chosen) => format!("{} steps of {} ({stable})", self.steps, chosen.lengths(row)),
            None => format!("{} steps of {} ({stable})", self.steps, quantity(self.step, "s")),
        });
        lines.extend(self.automatic.map(|chosen| chosen.summary(row, self.substeps)));
        let factor = self.real_time_factor.map(|factor| {
            format!(" in {}: {} x real time", quantity(self.wall_seconds, "s"), rounded(factor, 2))
        });
        let updates = self.spring_updates_per_second;
        let updates =
            updates.map(|updates| format!(", {} G spring updates/s", number(1e-9 * updates)));
        let speed = factor.unwrap_or_default() + &updates.unwrap_or_default();
        lines.push(format!("{} simulated{speed}", quantity(self.duration, "s")));
        let RunReport { device_steps, checked_steps, processor_steps, .. } = self;
        lines.extend((0 < *device_steps).then(|| {
            format!(
                "{device_steps} steps on the GPU, {checked_steps} of them checked; \
                 {processor_steps} on the processor"
            )
        }));
        let imbalance = self.imbalance.map(|change| {
            let sign = if change < 0.0 { '-' } else { '+' };
            format!(" ({sign}{} by errors of the method)", number(change.abs()))
        });
        lines.push(self.energy.summary() + &imbalance.unwrap_or_default());
        lines.push(format!("state hash {}", self.state_hash));
        lines.extend(self.replay.iter().map(Comparison::summary));
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_substeps_have_a_least_a_most_and_a_last_number() {
        let chosen =
            [12, 28, 20].into_iter().fold(None, |before, now| Some(Chosen::now(before, now)));
        let chosen = chosen.expect("some steps");
        assert_eq!(chosen.lengths(0.0168), "600 µs to 1.4 ms");
        let summary = "substeps chosen: 12 to 28, at the end 20, in each 16.8 ms";
        assert_eq!(chosen.summary(0.0168, 20), summary);
        let alike = Chosen { least: 12, most: 12 };
        assert_eq!(alike.summary(0.0168, 12), "substeps chosen: 12 in each 16.8 ms");
    }
}
