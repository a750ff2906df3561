//! Automatic substeps: as many as the predicted limit of stability asks for, and no clock involved.
//!
//! They are chosen where a run is opened and where its springs, masses or settings change, and
//! renewed after every so many steps: a function of state, settings and the number of steps alone,
//! so that a run that was saved or replayed has the same bits.

use msd_core::{Error, Integrator, Interaction, Model, Real, Settings, Simulation};

/// Part of the longest stable substep that is taken: springs that turn and stretch move the limit,
/// by up to 7 % in the built-in scenes whose limit is set by stiffness.
const AIM: f64 = 0.9;
/// The same where dampers set the limit, which falls further as they come to lie along one line:
/// by 23 % in `foam`, within a sixth of a second.
const AIM_OF_DAMPERS: f64 = 0.7;
/// A body is loose where what is stable in any shape is at least this part of what is stable now:
/// a rope or a cloth; of a block it is less.
const LOOSE: f64 = 0.6;
/// The most substeps that are chosen: beyond them another method is the better answer, and a step
/// of a large scene would take seconds.
const MOST: f64 = 1000.0;
/// The part of the work of a run that renewals may take by the costs below; on the built-in scenes
/// it is 3 % to 25 %.
const SHARE: f64 = 0.05;
/// What a prediction costs in evaluations of the forces: see `cargo bench --bench stability`.
const COST: f64 = 300.0;
/// What it costs besides where dampers couple motions, in springs evaluated.
const COUPLED_COST: f64 = 8e6;

/// The state of automatic substeps, all of which follows from the run that they belong to.
#[derive(Clone, Copy, Debug)]
pub struct Automatic {
    /// Steps from one renewal to the next.
    every: u64,
    /// Whether something was queued that moves the limit.
    is_due: bool,
}

impl Automatic {
    /// Goes on with a run that was saved: its substeps are those that were chosen last.
    pub(crate) fn resumed<R: Real>(simulation: &Simulation<R>, queue: &[Interaction]) -> Self {
        let is_due = queue.iter().any(|interaction| moves_limit(simulation.model(), interaction));
        Automatic { every: steps_between(simulation, SHARE), is_due }
    }

    /// Chooses the substeps of a run as it is now.
    pub(crate) fn chosen<R: Real>(simulation: &mut Simulation<R>) -> Result<Self, Error> {
        choose(simulation, needed)
    }

    /// Notes that something is queued for the next step.
    pub(crate) fn queue<R: Real>(&mut self, model: &Model<R>, interaction: &Interaction) {
        self.is_due |= moves_limit(model, interaction);
    }

    /// Whether what is queued moves the limit.
    pub(crate) fn is_due(self) -> bool {
        self.is_due
    }

    /// Renews the substeps before a step, if it is time to.
    pub(crate) fn renew<R: Real>(self, simulation: &mut Simulation<R>) -> Result<Self, Error> {
        let steps = simulation.steps();
        if 0 < steps && steps.is_multiple_of(self.every) {
            return choose(simulation, needed_or_near);
        }
        Ok(self)
    }
}

/// The steps from one prediction of the limit to the next, where predictions are to take about this
/// share of the work of a run.
pub fn steps_between<R: Real>(simulation: &Simulation<R>, share: f64) -> u64 {
    let (model, settings) = (simulation.model(), simulation.settings());
    let coupled = if is_damped_unevenly(model) { COUPLED_COST } else { 0.0 };
    let cost = COST + coupled / model.spring_count().max(1) as f64;
    // Only explicit methods are predicted for.
    let evaluations = if settings.integrator == Integrator::Rk4 { 4.0 } else { 1.0 };
    (cost / (share * evaluations * f64::from(settings.substeps))).ceil() as u64
}

/// Whether springs differ in damping.
fn is_damped_unevenly<R: Real>(model: &Model<R>) -> bool {
    let springs = (0..model.ends().len()).filter(|&spring| !model.is_cut(spring));
    let mut dampings = springs.map(|spring| model.damping(spring));
    let first = dampings.next();
    dampings.any(|damping| Some(damping) != first)
}

/// Whether an interaction may move the limit. A pin that is moved stays a pin, and a hand is kept
/// weaker than any substep.
fn moves_limit<R: Real>(model: &Model<R>, interaction: &Interaction) -> bool {
    let effects = interaction.effects();
    let moves_pin =
        matches!(interaction, Interaction::Pin { particle, .. } if model.is_pinned(*particle));
    effects.springs || effects.masses && !moves_pin
}

/// Sets the substeps by a rule for the longest that are to be taken, seconds.
fn choose<R: Real>(
    simulation: &mut Simulation<R>,
    rule: impl Fn(Settings, f64) -> u32,
) -> Result<Automatic, Error> {
    let settings = simulation.settings();
    let stable = match Integrator::EXPLICIT.contains(&settings.integrator) {
        // For a fixed number: the limit depends a little on it, and the choice would on itself.
        true => simulation.stable_substep_of(settings.integrator, Settings::default().substeps),
        false => f64::INFINITY,
    };
    // Where no step is stable, or every one is, the limit says nothing.
    if 0.0 < stable && stable.is_finite() {
        let substeps = rule(settings, longest(simulation, stable));
        if substeps != settings.substeps {
            simulation.set_settings(Settings { substeps, ..settings })?;
        }
    }
    Ok(Automatic { every: steps_between(simulation, SHARE), is_due: false })
}

/// The longest substep to be taken, seconds.
///
/// h²/4 K + h/2 D reaches 1 at the limit h: a damper counts for more than its spring where
/// h/2 c > h²/4 k. Where nothing resists a fold, springs come to lie along one line in a moment,
/// however stiff they are; what such a body bears in any shape is little shorter, and is taken.
fn longest<R: Real>(simulation: &Simulation<R>, stable: f64) -> f64 {
    let model = simulation.model();
    let mut springs = (0..model.ends().len()).filter(|&spring| !model.is_cut(spring));
    let damps_more = |spring: usize| {
        0.5 * stable * model.stiffness(spring).to_f64() < model.damping(spring).to_f64()
    };
    let longest = if springs.any(damps_more) { AIM_OF_DAMPERS } else { AIM } * stable;
    let guaranteed = simulation.guaranteed_substep(simulation.settings().integrator);
    if LOOSE * stable <= guaranteed { longest.min(guaranteed) } else { longest }
}

/// The fewest substeps that are at most so long, seconds.
fn needed(settings: Settings, longest: f64) -> u32 {
    (settings.step / longest).ceil().clamp(1.0, MOST) as u32
}

/// The same, or the present number where that is enough and at most a third more: a limit that
/// wavers is no reason to change.
fn needed_or_near(settings: Settings, longest: f64) -> u32 {
    let needed = needed(settings, longest);
    let is_near = (needed..=needed + needed / 3).contains(&settings.substeps);
    if is_near { settings.substeps } else { needed }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_renewal_changes_what_is_too_few_and_what_is_far_too_many() {
        let at = |substeps| Settings { substeps, ..Settings::default() };
        // Twelve substeps are needed.
        let longest = 1.001 / 60.0 / 12.0;
        let renewed = [1, 11, 12, 16, 17, 900].map(|now| needed_or_near(at(now), longest));
        assert_eq!(renewed, [12, 12, 12, 16, 12, 12]);
        assert_eq!([1e-9, 1e9].map(|longest| needed(at(8), longest)), [1000, 1]);
    }
}
