//! The report of a run: a summary, or one JSON object.

use super::prepare::Prepared;
use msd_core::methods::Solved;
use msd_core::{Contacts, Energy, Integrator, Momentum, Settings};
use msd_run::{Overturned, Pierced, Touched};
use msd_scene::{Assignment, Precision, state_hash};
use msd_study::quantity::{number, quantity, rounded};
use serde::Serialize;

/// Keys of a scene that the command line set, from the top, with their values.
pub type SetKeys = serde_json::Map<String, serde_json::Value>;

/// What the command line set, for a report.
pub fn set_keys(set: &[Assignment]) -> SetKeys {
    let value = |set: &Assignment| serde_json::to_value(set.value()).unwrap_or_default();
    set.iter().map(|set| (set.key().into(), value(set))).collect()
}

/// What came of a run; the keys of `--json`.
#[derive(Debug, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// Keys of the scene that the command line set, with their values.
    pub set: SetKeys,
    /// Number of particles.
    pub particles: usize,
    /// Number of springs.
    pub springs: usize,
    /// The method.
    pub integrator: Integrator,
    /// Length of an integration step, seconds; of an adaptive method, which divides it as it
    /// needs, that of a step of the scene.
    pub step: f64,
    /// Integration steps per row of the trace.
    pub substeps: u32,
    /// The fewest and the most substeps per row, where they are automatic: `step` and `substeps`
    /// are then those at the end. Null where they are not.
    pub automatic: Option<Chosen>,
    /// Local error that an adaptive method allows, as a fraction of the size; null for others.
    pub tolerance: Option<f64>,
    /// Newton iterations per substep of an implicit method; null for others.
    pub newton: Option<u32>,
    /// Precision.
    pub precision: Precision,
    /// Time simulated, seconds.
    pub duration: f64,
    /// Time of the scene at the end, seconds: more than the duration for a saved run that goes on.
    pub time: f64,
    /// Integration steps taken.
    pub steps: u64,
    /// Time that the steps took, seconds.
    pub wall_seconds: f64,
    /// Springs times force evaluations of the integration steps (without the one that velocity
    /// Verlet starts a step with) per second of the wall clock; null without a step and for methods
    /// that choose their own number of evaluations.
    pub spring_updates_per_second: Option<f64>,
    /// Time simulated by time taken; null without a step.
    pub real_time_factor: Option<f64>,
    /// Energy at the end, joules.
    pub energy: EnergyReport,
    /// What obstacles did: contacts, the energy that they took away and that they added, and the
    /// work of surfaces that move, joules.
    pub contacts: Contacts,
    /// Failures of contact between bodies: how often they may have crossed, and how many pairs of
    /// triangles cross at the end. Null where no bodies meet.
    pub touched: Option<Touched>,
    /// The most pairs of triangles that were seen to cross at once, and when; null if none was, and
    /// for a replay.
    pub most_crossings: Option<Crossed>,
    /// The first surface that a solid was seen to go through; null if none was, and for a replay.
    pub pierced: Option<Pierced>,
    /// The body of which most cells are flat or inside out at the end; null if none are, and for a
    /// replay.
    pub overturned: Option<Overturned>,
    /// Momentum at the end.
    pub momentum: Momentum,
    /// The longest integration step predicted stable at the start, seconds: 0 if none is, null if
    /// every one is.
    pub stable_step: Option<f64>,
    /// Hash of the last state, hexadecimal.
    pub state_hash: String,
    /// Energy that the integrator has added; null if it added none.
    pub energy_gain: Option<Gain>,
    /// The most energy that was missing and that nothing took by any account, joules, where it is
    /// more than a tenth of the most that was in motion; null where it is not.
    pub energy_loss: Option<f64>,
    /// Change of the total energy, joules, which is the error of the method and of contact in it;
    /// what adds up in a body at rest is left out. Null for a replay, in which a user does work.
    pub imbalance: Option<f64>,
    /// How far the solves of an implicit method got, the worst of the run; null for others.
    pub solved: Option<Solved>,
    /// Whether the run diverged; what is reported is then the last good state.
    pub diverged: bool,
    /// Whether the user ended it before its time, by Ctrl-C.
    pub interrupted: bool,
    /// What was done to the input, and what the user should know.
    pub notes: Vec<String>,
    /// What may be wrong.
    pub warnings: Vec<String>,
    /// Of a replay only: how it compares with what was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replay: Option<Comparison>,
}

/// Automatic substeps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Chosen {
    /// The fewest of a step.
    pub least: u32,
    /// The most of a step.
    pub most: u32,
}

impl Chosen {
    /// What is known after a step of so many.
    pub fn now(before: Option<Chosen>, substeps: u32) -> Chosen {
        let Chosen { least, most } = before.unwrap_or(Chosen { least: substeps, most: substeps });
        Chosen { least: least.min(substeps), most: most.max(substeps) }
    }

    /// The lengths of the shortest and the longest substep of a step.
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

/// What was done in a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Done {
    /// Steps taken.
    pub steps: u64,
    /// Substeps taken, where they are not the same in every step.
    pub substeps: Option<u64>,
    /// Automatic substeps.
    pub chosen: Option<Chosen>,
    /// Time simulated, seconds.
    pub simulated: f64,
    /// Time that the steps took, seconds.
    pub wall: f64,
    /// Whether it left the world.
    pub diverged: bool,
    /// Whether the user ended it.
    pub interrupted: bool,
    /// Energy that the integrator has added; `None` if it added none.
    pub gain: Option<Gain>,
    /// Change of the total energy that nothing explains, joules.
    pub imbalance: Option<f64>,
    /// The most energy that was missing, joules.
    pub loss: Option<f64>,
    /// How far the solves of an implicit method got.
    pub solved: Option<Solved>,
    /// The most pairs of triangles that were seen to cross at once.
    pub crossed: Option<Crossed>,
    /// The first surface that a solid was seen to go through.
    pub pierced: Option<Pierced>,
    /// The body of which most cells are flat or inside out at the end.
    pub overturned: Option<Overturned>,
}

/// How a replay compares with what was recorded.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Hash of the last state recorded, hexadecimal; null where the recording was cut short.
    pub recorded_hash: Option<String>,
    /// Whether the recorded run ended in that state again; null where the recording was cut short,
    /// or the replay diverged or was interrupted.
    pub same_bits: Option<bool>,
    /// Whether the end of the recording is missing.
    pub cut_short: bool,
    /// Bytes at its end that were left out, as `--salvage` allows; else 0.
    pub lost_bytes: usize,
    /// Of a replay with another solver: how far it is from the recorded run at the end.
    pub apart: Option<Distance>,
}

/// How far two runs are apart.
#[derive(Debug, Serialize)]
pub struct Distance {
    /// The solver of the recorded run.
    pub recorded_integrator: Integrator,
    /// Root of the mean square distance of the particles, metres.
    pub rms: f64,
    /// The largest distance of a particle, metres.
    pub max: f64,
    /// That particle.
    pub particle: usize,
    /// Size of the scene, metres.
    pub size: f64,
    /// When the root mean square distance passed a hundredth of the size, seconds; null if never.
    pub noticeable_at: Option<f64>,
}

/// Energy that nothing supplied.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Gain {
    /// The most that was seen, joules; null where it is NaN or infinite.
    joules: f64,
    /// When it was first seen, simulated seconds.
    since: f64,
    /// The elastic energy when it was the most, joules.
    #[serde(skip)]
    elastic: f64,
}

impl Gain {
    /// What is known after another look, at which there was so much elastic energy.
    pub fn now(before: Option<Gain>, joules: f64, (time, elastic): (f64, f64)) -> Option<Gain> {
        match before {
            None if 0.0 < joules => Some(Gain { joules, since: time, elastic }),
            Some(gain) if gain.joules < joules => Some(Gain { joules, elastic, ..gain }),
            known => known,
        }
    }

    /// Whether it is the softness of XPBD: its constraints yield more than springs of their
    /// stiffness, and what these would store then is more than the motion has given them.
    pub fn is_softness(&self, integrator: Integrator) -> bool {
        integrator == Integrator::Xpbd && self.joules <= self.elastic
    }

    /// The warning that XPBD is soft; a substep as long as `resolving`, seconds, is not.
    pub fn softness(&self, settings: Settings, resolving: f64) -> String {
        let needed = (settings.step / resolving).ceil();
        let needed = match needed.is_finite() && f64::from(settings.substeps) < needed {
            true => format!(", about {needed} resolve the stiffness of this scene"),
            false => String::new(),
        };
        format!(
            "xpbd holds bodies softer than asked at {} substeps: springs as stiff as asked would \
             store {} more than the motion gave them, since t = {}; take more substeps{needed}, or \
             an implicit method",
            settings.substeps,
            quantity(self.joules, "J"),
            quantity(self.since, "s")
        )
    }

    /// The warning of it.
    pub fn warning(&self, integrator: Integrator) -> String {
        let Gain { joules, since, .. } = self;
        format!(
            "{integrator} is adding energy: {} that nothing supplied, first seen at t = {}; \
             shorten the step or use another integrator",
            quantity(*joules, "J"),
            quantity(*since, "s")
        )
    }
}

/// Pairs of triangles that cross.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Crossed {
    pairs: u64,
    /// When, simulated seconds.
    time: f64,
}

impl Crossed {
    /// What is known after another count.
    pub fn now(before: Option<Crossed>, pairs: u64, time: f64) -> Option<Crossed> {
        let most = before.map_or(0, |before| before.pairs);
        if most < pairs { Some(Crossed { pairs, time }) } else { before }
    }

    /// The warning of it.
    pub fn warning(&self) -> String {
        format!(
            "{} pairs of surface triangles cross at t = {}, the most in this run; use more \
             substeps, a larger `touch.thickness`, or a finer spacing",
            self.pairs,
            quantity(self.time, "s")
        )
    }
}

/// Energy, joules.
#[derive(Debug, Serialize)]
pub struct EnergyReport {
    kinetic: f64,
    elastic: f64,
    gravitational: f64,
    dissipated: f64,
    /// By moving solids, wind and elements of a user's own.
    supplied: f64,
    total: f64,
}

impl From<Energy> for EnergyReport {
    fn from(energy: Energy) -> Self {
        let Energy { kinetic, elastic, gravitational, dissipated, supplied, .. } = energy;
        let total = energy.total();
        EnergyReport { kinetic, elastic, gravitational, dissipated, supplied, total }
    }
}

impl EnergyReport {
    fn summary(&self) -> String {
        let EnergyReport { kinetic, elastic, gravitational, dissipated, supplied, total } = *self;
        let [kinetic, elastic, gravitational, dissipated, total] =
            [kinetic, elastic, gravitational, dissipated, total].map(number);
        let supplied = match supplied {
            0.0 => String::new(),
            work => format!(", supplied by what drives it {}", number(work)),
        };
        format!(
            "energy, J: kinetic {kinetic}, elastic {elastic}, gravitational {gravitational}, \
             dissipated {dissipated}{supplied}, total {total}"
        )
    }
}

impl Comparison {
    fn summary(&self) -> String {
        let Some(apart) = &self.apart else {
            return match self.same_bits {
                Some(true) => "replayed to the same bits".into(),
                Some(false) => "replayed to another state".into(),
                None => "replayed as far as it goes".into(),
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

/// How often each spring is evaluated in an integration step, without the evaluation that starts a
/// step of Verlet; `None` where that depends on the motion.
pub fn evaluations(integrator: Integrator) -> Option<u64> {
    match integrator {
        Integrator::Rk4 => Some(4),
        Integrator::DormandPrince | Integrator::BackwardEuler | Integrator::ImplicitMidpoint => {
            None
        }
        _ => Some(1),
    }
}

impl RunReport {
    /// Collects what came of a run.
    pub fn new(prepared: Prepared, done: Done) -> Self {
        let Prepared { name, notes, runner, stable, warnings, .. } = prepared;
        let settings = runner.settings();
        let adaptive = settings.integrator.is_adaptive();
        let substeps = if adaptive { 1 } else { settings.substeps };
        let steps = done.substeps.filter(|_| !adaptive);
        let steps = steps.unwrap_or(done.steps * u64::from(substeps));
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
            wall_seconds: done.wall,
            spring_updates_per_second: updates.and_then(per_wall_second),
            real_time_factor: per_wall_second(done.simulated),
            energy: runner.energy().into(),
            contacts: runner.contacts(),
            touched: runner.touched(),
            most_crossings: done.crossed,
            pierced: done.pierced,
            overturned: done.overturned,
            momentum: runner.momentum(),
            stable_step: stable.is_finite().then_some(stable),
            state_hash: format!("{:016x}", state_hash(&runner.state())),
            energy_gain: done.gain,
            energy_loss: done.loss,
            imbalance: done.imbalance,
            solved: done.solved,
            diverged: done.diverged,
            interrupted: done.interrupted,
            notes,
            warnings,
            replay: None,
        }
    }

    /// One JSON object.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }

    /// A summary for the user.
    pub fn summary(&self) -> String {
        let mut lines = self.notes.clone();
        let RunReport { scene, particles, springs, integrator, precision, .. } = self;
        lines.push(format!(
            "{scene}: {particles} particles, {springs} springs, {integrator} in {precision}"
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
