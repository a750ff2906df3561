//! Automatic substeps: as many as the predicted limit of stability asks for, and no clock involved.
//!
//! A run chooses them when it is opened and when its springs, masses or settings change. It renews
//! them after a fixed number of steps. They are a function of state, settings and the number of
//! steps, so that a saved or replayed run has the same bits. A lazy run chooses them no earlier
//! than at its next step, and piece by piece before that.
//!
//! Some steps are taken again with twice as many substeps, which stay until the next renewal:
//!
//! - a step in which shells may cross;
//! - a step with a substep in which a particle goes a tenth of a radian round a solid that it
//!   meets, or such a solid moves by more than half of its thickness;
//! - a step in which energy appears that nothing supplied: a body that is pressed flat is stiffer
//!   than at the last prediction.

use Automatic::{Begun, Chosen, Due, Wanted};
use msd_core::glam::DVec3;
use msd_core::stability::Estimator;
use msd_core::{Error, Integrator, Interaction, Model, Real, Settings, Simulation};
use msd_scene::Wind;

/// Part of the longest stable substep that is taken: springs that turn and stretch move the limit,
/// by up to 7 % in the built-in scenes whose limit is set by stiffness.
const AIM: f64 = 0.9;
/// The same where dampers set the limit, which falls further as they come to lie along one line:
/// by 23 % in `foam`, within a sixth of a second.
const AIM_OF_DAMPERS: f64 = 0.7;
/// Least ratio of the limit in any shape to the current limit for a body to be loose: a rope or a
/// cloth; a block has less.
const LOOSE: f64 = 0.6;
/// The most substeps that are chosen: a step of a large scene then takes seconds.
const MOST: f64 = 1e4;
/// The most that refused steps lead to, unless the limit asks for as many: where they do not help,
/// as in a body that is squeezed, more would not either.
const MOST_OF_REFUSALS: u32 = 1000;
/// The substeps of XPBD where bodies meet: with fewer, soft cubes do not hold each other.
const XPBD_OF_BODIES: u32 = 32;
/// The part of the work of a run that renewals may take by the costs below; on the built-in scenes
/// it is 3 % to 25 %.
const SHARE: f64 = 0.05;
/// Cost of a prediction, in evaluations of the forces: see `cargo bench --bench stability`.
const COST: f64 = 300.0;
/// Extra cost of a prediction where dampers couple motions, in springs evaluated.
const COUPLED_COST: f64 = 8e6;

/// State of the choice of substeps of a run: whether it is automatic, and whether it is due.
#[derive(Clone, Copy, Debug, Default)]
pub struct Substeps {
    /// Nothing where they are fixed.
    pub(crate) automatic: Option<Automatic>,
    /// Whether a choice waits for the next step.
    pub(crate) is_lazy: bool,
    /// The wind, and the uniform force without it, newtons, where it comes in gusts.
    pub(crate) gusts: Option<(Wind, DVec3)>,
}

/// Result of the last choice of substeps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// Steps from one renewal to the next.
    every: u64,
}

/// Why substeps are chosen before the next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The run was opened or changed: they are chosen from anew.
    Change,
    /// So many steps were taken: a renewal.
    Time,
}

/// The states of automatic substeps, all of which follow from the run that they belong to.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Automatic {
    /// They stay until it is time to renew them; `at` is the number of steps at which they were
    /// chosen, if nothing was changed since.
    Chosen { last: Choice, at: Option<u64> },
    /// They are chosen before the next step.
    Wanted { last: Choice, cause: Cause },
    /// The same, and a prediction for that is under way.
    Begun { last: Choice, cause: Cause },
    /// Something queued moves the limit: it is applied before the next step, and they are chosen
    /// from anew. `was_open` is whether they were to be without it.
    Due { last: Choice, was_open: bool },
}

impl Automatic {
    /// Goes on with a run that was saved: its substeps are those that were chosen last.
    pub(crate) fn resumed<R: Real>(simulation: &Simulation<R>, queue: &[Interaction]) -> Self {
        let last = Choice { every: steps_between(simulation, SHARE) };
        if queue.iter().any(|interaction| moves_limit(simulation.model(), interaction)) {
            return Due { last, was_open: false };
        }
        Chosen { last, at: None }
    }

    /// Those of a run that are to be chosen before its next step.
    pub(crate) fn open<R: Real>(simulation: &Simulation<R>) -> Self {
        let last = Choice { every: steps_between(simulation, SHARE) };
        Wanted { last, cause: Cause::Change }
    }

    fn last(self) -> Choice {
        let (Chosen { last, .. } | Wanted { last, .. } | Begun { last, .. } | Due { last, .. }) =
            self;
        last
    }

    /// Notes that something is queued for the next step.
    pub(crate) fn queued<R: Real>(self, model: &Model<R>, interaction: &Interaction) -> Self {
        if moves_limit(model, interaction) {
            return Due { last: self.last(), was_open: self.is_open() };
        }
        let effects = interaction.effects();
        let is_felt = effects.springs || effects.masses || effects.state || effects.grabs;
        if is_felt && !is_motion(model, interaction) { self.forgotten() } else { self }
    }

    /// Returns whether queued interactions move the limit.
    pub(crate) fn is_due(self) -> bool {
        matches!(self, Due { .. })
    }

    /// Returns whether the substeps are to be chosen anew before the next step.
    pub(crate) fn is_open(self) -> bool {
        match self {
            Chosen { .. } => false,
            Wanted { cause, .. } | Begun { cause, .. } => cause == Cause::Change,
            Due { was_open, .. } => was_open,
        }
    }

    /// Forgets the prediction, as something was changed.
    pub(crate) fn forgotten(self) -> Self {
        match self {
            Chosen { last, .. } | Begun { last, cause: Cause::Time } => Chosen { last, at: None },
            Begun { last, cause } => Wanted { last, cause },
            Wanted { .. } | Due { .. } => self,
        }
    }

    /// Why the next step of a run that has taken so many begins with a choice, if it does. Queued
    /// interactions are applied before that. `has_freed` is whether a pin ended in the last step.
    pub(crate) fn cause(self, steps: u64, has_freed: bool) -> Option<Cause> {
        match self {
            Chosen { at, .. } if has_freed && at != Some(steps) => Some(Cause::Change),
            Chosen { last, at } => {
                let is_time = 0 < steps && steps.is_multiple_of(last.every) && at != Some(steps);
                is_time.then_some(Cause::Time)
            }
            Wanted { cause, .. } | Begun { cause, .. } => Some(cause),
            Due { .. } => None,
        }
    }

    /// Does a piece of a choice for this cause.
    pub(crate) fn prepared<R: Real>(
        self,
        cause: Cause,
        simulation: &mut Simulation<R>,
        estimator: &mut Estimator,
    ) -> Result<Self, Error> {
        if !matches!(self, Begun { .. }) {
            estimator.restart();
        }
        let Some(stable) = predict(simulation, estimator) else {
            return Ok(Begun { last: self.last(), cause });
        };
        set(simulation, stable, if cause == Cause::Change { needed } else { needed_or_near })?;
        let last = Choice { every: steps_between(simulation, SHARE) };
        Ok(Chosen { last, at: Some(simulation.steps()) })
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

/// Returns whether an interaction may move the limit. A grab is kept weaker than any substep.
fn moves_limit<R: Real>(model: &Model<R>, interaction: &Interaction) -> bool {
    let effects = interaction.effects();
    effects.springs || effects.masses && !is_motion(model, interaction)
}

/// Returns whether an interaction only moves a held or pinned particle, which the limit does not
/// follow.
pub(crate) fn is_motion<R: Real>(model: &Model<R>, interaction: &Interaction) -> bool {
    match *interaction {
        Interaction::Pin { particle, .. } => model.is_pinned(particle),
        Interaction::Grab { particle, .. } => {
            model.grabs().iter().any(|grab| grab.particle as usize == particle)
        }
        _ => false,
    }
}

/// The longest substep that automatic ones may have, seconds: 0 where none is stable, infinite
/// where every one is.
pub(crate) fn longest_automatic<R: Real>(simulation: &Simulation<R>) -> f64 {
    let estimator = &mut Estimator::default();
    let stable = loop {
        if let Some(stable) = predict(simulation, estimator) {
            break stable;
        }
    };
    if has_limit(stable) { longest(simulation, stable) } else { stable }
}

/// The settings with twice the substeps, for a step that was refused; `None` of the most.
pub(crate) fn divided(settings: Settings) -> Option<Settings> {
    let most = if settings.substeps <= MOST_OF_REFUSALS { MOST_OF_REFUSALS } else { MOST as u32 };
    let substeps = settings.substeps.saturating_mul(2).min(most);
    (settings.substeps < substeps).then_some(Settings { substeps, ..settings })
}

/// Whether substeps are as many as automatic ones may be.
pub(crate) fn is_most(settings: Settings) -> bool {
    MOST <= f64::from(settings.substeps)
}

/// Whether the limit says how many are needed: not where no step is stable, or every one.
fn has_limit(stable: f64) -> bool {
    0.0 < stable && stable.is_finite()
}

/// Does a piece of the prediction of the longest stable substep, seconds, infinite of a method
/// without a limit; returns it at its end.
fn predict<R: Real>(simulation: &Simulation<R>, estimator: &mut Estimator) -> Option<f64> {
    let mut integrator = simulation.settings().integrator;
    if !Integrator::EXPLICIT.contains(&integrator) {
        return Some(f64::INFINITY);
    }
    // Contact is of first order, and asked once in a substep: stages make it no better.
    if integrator == Integrator::Rk4 && simulation.model().do_bodies_meet() {
        integrator = Integrator::VelocityVerlet;
    }
    // For a fixed number: the limit depends a little on it, and the choice would on itself.
    let substeps = Settings::default().substeps;
    simulation.stable_substep_piecewise(integrator, substeps, estimator)
}

/// The substeps where the limit says nothing: the current ones, but where particles meet shells or
/// solids at most the default ones, as refused steps may have raised them.
fn unlimited<R: Real>(simulation: &Simulation<R>) -> u32 {
    let (Settings { substeps: now, integrator, .. }, model) =
        (simulation.settings(), simulation.model());
    if integrator == Integrator::Xpbd && model.do_bodies_meet() {
        return XPBD_OF_BODIES;
    }
    let is_refusable = model.do_bodies_meet() || !model.solids().is_empty();
    if is_refusable { now.min(Settings::default().substeps) } else { now }
}

/// Sets the substeps by a rule for the longest that are to be taken, seconds.
fn set<R: Real>(
    simulation: &mut Simulation<R>,
    stable: f64,
    rule: fn(Settings, f64) -> u32,
) -> Result<(), Error> {
    let settings = simulation.settings();
    let substeps = match has_limit(stable) {
        true => rule(settings, longest(simulation, stable)),
        false => unlimited(simulation),
    };
    if substeps == settings.substeps {
        return Ok(());
    }
    simulation.set_settings(Settings { substeps, ..settings })
}

/// The longest substep to be taken, seconds.
///
/// h²/4 K + h/2 D reaches 1 at the limit h: a damper counts for more than its spring where h/2 c >
/// h²/4 k. Where nothing resists a fold, springs come to lie along one line in a moment, however
/// stiff they are; the limit of such a body in any shape is little shorter, and is taken.
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

/// The same, or the current number where that is enough and at most a third more: a limit that
/// wavers does not justify a change.
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
        assert_eq!([1e-9, 1e9].map(|longest| needed(at(8), longest)), [10_000, 1]);
    }
}
