//! Tuning: the cheapest choice within an error, or the most accurate within a budget, searched by
//! measuring, method by method, and verified against the reference.

mod slope;
mod solver_section;
mod elsewhere;
mod spacing;
mod report;

use crate::candidates::choice::{Choice, FRAME, Fineness};
use crate::candidates::ladder::{Ladder, PREDICTION, ladders};
use crate::measure::device::Device;
use crate::measure::reference::{Reference, Wish, exact, frames_of, reference, size_of};
use crate::measure::trial::{DeviceTime, Trial, time_choice, time_on, try_choice};
use crate::monitor::{Halt, Monitor, Progress, unless_refused};
use crate::tune::slope::{is_coarsest, is_stuck, order, predict, scaled};
use msd_core::{Error, Integrator, Scene};
use msd_run::Runner;
use msd_scene::Precision;
use serde::{Deserialize, Serialize};

pub use elsewhere::{Elsewhere, retry};
pub use report::{ChoiceReport, TuneReport};
pub use solver_section::{put, with_choice};
pub use spacing::{FoundSpacing, TunedSpacing, tune_spacing};

/// The goal of a search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// The cheapest choice whose error is at most this, metres.
    MaxError(f64),
    /// The most accurate choice that takes at most this time of the processor per frame, seconds.
    Budget(f64),
}

impl Goal {
    /// Whether a trial meets it, as far as the reference of the trial is certain.
    pub fn is_met_by(&self, trial: &Trial) -> bool {
        match *self {
            Goal::MaxError(error) => trial.is_within(error),
            Goal::Budget(budget) => trial.is_sound() && trial.cost * FRAME <= budget,
        }
    }
}

/// A choice with its predictions and its results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The trial that verified it.
    pub trial: Trial,
    /// Error predicted from the trials of its method before it, metres; of the first one from a
    /// trial of twice the fineness. None where those blew up.
    pub predicted_error: Option<f64>,
}

/// Result of tuning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuned {
    /// The goal that was asked for.
    pub goal: Goal,
    /// The choice, or the nearest where nothing meets the goal.
    pub best: Found,
    /// The best of other methods and precisions that meet the goal too, the next best first.
    pub others: Vec<Found>,
    /// Whether the choice meets the goal.
    pub met: bool,
    /// Uncertainty of the reference, metres.
    pub uncertainty: f64,
    /// Time simulated, seconds.
    pub duration: f64,
    /// Time up to which particles could be compared, seconds: further on the reference is not
    /// certain enough, or the scene is chaotic.
    pub compared: f64,
    /// The time at which the scene becomes chaotic at the error delivered, seconds; none if it does
    /// not.
    pub horizon: Option<f64>,
    /// Tolerance of the reference; 0 where it is a closed form.
    pub reference_tolerance: f64,
    /// Number of choices that were tried.
    pub tried: usize,
    /// Whether its time was over before all choices that are worth a trial were tried.
    pub is_cut_short: bool,
}

impl Tuned {
    /// Whether the best stayed within the error asked for, but the reference is too uncertain to
    /// say that it meets it.
    pub fn is_undecided(&self) -> bool {
        matches!(self.goal, Goal::MaxError(error) if !self.met && self.best.trial.is_within(error))
    }

    /// The reason why no choice meets the goal, in words.
    pub fn verdict(&self) -> &'static str {
        match (self.is_undecided(), self.is_cut_short) {
            (true, _) => {
                "the reference is too uncertain to say what meets it; ask for a larger error"
            }
            (false, true) => "none was found in time",
            (false, false) => "no setting meets it",
        }
    }
}

/// The part of the time of a search after which its reference is not tightened further.
const REFERENCE: f64 = 0.3;
/// Factor by which the search aims below the goal: the remaining error of the reference must fit.
const AIM: f64 = 0.8;
/// A method is given up where another is as good at this part of its cost.
const HOPELESS: f64 = 4.0;
/// Time of the processor that a trial may take however quick the reference was, seconds.
const LEAST_PATIENCE: f64 = 0.05;
/// The most trials of one method.
const TRIALS: usize = 8;
/// Factor by which a single timing of a choice within a budget may exceed it.
const UNLUCKY: f64 = 1.3;

/// A device by whose time choices are tuned.
pub struct Tuner<'a> {
    device: &'a mut dyn Device,
    /// Why the device took no more steps, if it failed: the search is then cancelled.
    pub fault: Option<String>,
}

impl<'a> Tuner<'a> {
    /// Begins to time choices on a device.
    pub fn new(device: &'a mut dyn Device) -> Self {
        Tuner { device, fault: None }
    }

    /// Returns whether the device steps a choice.
    fn takes(&self, scene: &Scene, choice: Choice) -> bool {
        let runner = Runner::new(scene, choice.settings(), choice.precision);
        runner.is_ok_and(|runner| self.device.takes(&runner))
    }

    /// Wall-clock time per simulated second, seconds; infinite for a run that diverges.
    fn time(
        &mut self,
        (scene, choice): (&Scene, Choice),
        frames: u64,
        monitor: &mut dyn Monitor,
    ) -> Result<f64, Halt> {
        match time_on(self.device, (scene, choice), frames, monitor)? {
            DeviceTime::Cost(cost) => Ok(cost),
            DeviceTime::Untaken => Ok(f64::INFINITY),
            DeviceTime::Failed(why) => {
                self.fault = Some(why);
                Err(Halt::Cancelled)
            }
        }
    }
}

/// Tunes a scene over some seconds. A search that the monitor ends returns the best by then.
///
/// # Errors
/// A scene that the core refuses; an error of [`Monitor::proceed`] before the end of the first
/// trial.
pub fn tune(
    scene: &Scene,
    duration: f64,
    goal: Goal,
    monitor: &mut dyn Monitor,
) -> Result<Tuned, Halt> {
    tune_by((scene, None), duration, goal, monitor)
}

/// Tunes a scene for a device, among the choices that it steps. Costs are wall-clock times there,
/// transfers of the state included; errors and gains of energy are those of the processor, which
/// has the same bits.
///
/// # Errors
/// See [`tune`].
pub fn tune_on(
    (scene, tuner): (&Scene, &mut Tuner<'_>),
    duration: f64,
    goal: Goal,
    monitor: &mut dyn Monitor,
) -> Result<Tuned, Halt> {
    tune_by((scene, Some(tuner)), duration, goal, monitor)
}

fn tune_by(
    (scene, mut tuner): (&Scene, Option<&mut Tuner<'_>>),
    duration: f64,
    goal: Goal,
    monitor: &mut dyn Monitor,
) -> Result<Tuned, Halt> {
    let tuned = search((scene, tuner.as_deref_mut()), (duration, 0.02), goal, monitor)?;
    let is_whole = tuner.is_some() || matches!(goal, Goal::Budget(_));
    if tuned.met || tuned.is_cut_short || is_whole {
        return Ok(tuned);
    }
    // No device steps Dormand-Prince. It cannot be judged near the tolerance of its reference: a
    // tighter one lets it try the tolerances that the first could not judge.
    match search((scene, None), (duration, 0.0002), goal, monitor) {
        Err(Halt::Cancelled | Halt::Deadline) => Ok(Tuned { is_cut_short: true, ..tuned }),
        Ok(again) if again.met => Ok(again),
        Ok(again) => Ok(Tuned { is_cut_short: again.is_cut_short, ..tuned }),
        Err(halt) => Err(halt),
    }
}

/// Searches by a reference that is certain to a part of the wish.
fn search(
    (scene, tuner): (&Scene, Option<&mut Tuner<'_>>),
    (duration, part): (f64, f64),
    goal: Goal,
    monitor: &mut dyn Monitor,
) -> Result<Tuned, Halt> {
    let size = size_of(scene)?;
    let wanted = match goal {
        Goal::MaxError(error) => error,
        // The accuracy for a budget is not known yet: a reference good enough for most of it.
        Goal::Budget(_) => 1e-6 * size,
    };
    let uncertainty = (part * wanted / size).clamp(1e-11, 1e-4);
    let wish = hurried(duration, uncertainty, monitor);
    let right = reference(scene, wish, monitor)?;
    let (certain, reliable) = match goal {
        Goal::MaxError(error) => (0 < right.reliable(0.25 * error), right.comparable(0.25 * error)),
        Goal::Budget(_) => (true, right.comparable(2.0 * right.uncertainty())),
    };
    monitor.report(Progress::of(PREDICTION));
    let mut ladders = in_order_of_merit(ladders(scene)?);
    ladders.retain(|ladder| ladder.integrator.is_adaptive() || ladder.fewest.is_some());
    if let Some(tuner) = &tuner {
        ladders.retain(|ladder| {
            let fewest = ladder.fewest.map(Fineness::Substeps);
            fewest.is_some_and(|fewest| tuner.takes(scene, ladder.choice(fewest)))
        });
    }
    let (methods, found, seen) = ([0, ladders.len()], Vec::new(), Vec::new());
    let right = &right;
    let mut search = Search { scene, right, tuner, reliable, goal, certain, methods, found, seen };
    let mut ended = None;
    for ladder in ladders {
        match search.climb(ladder, monitor) {
            Ok(()) => search.methods[0] += 1,
            Err(Halt::Refused(error)) => return Err(error.into()),
            Err(halt) => {
                ended = Some(halt);
                break;
            }
        }
    }
    search.decide(ended, monitor)
}

/// The wish for the reference of a search, which is not tightened further after a part of the time
/// that the search may take.
fn hurried(duration: f64, uncertainty: f64, monitor: &dyn Monitor) -> Wish {
    let wish = Wish { duration, uncertainty, ..Wish::default() };
    Wish { patience: wish.patience.min(REFERENCE * monitor.time_limit()), ..wish }
}

/// Sorts ladders: first the method that always arrives, then those that win most often, so that the
/// others can be given up early.
fn in_order_of_merit(mut ladders: Vec<Ladder>) -> Vec<Ladder> {
    let merit = |integrator| match integrator {
        Integrator::VelocityVerlet => 1,
        Integrator::SymplecticEuler => 2,
        Integrator::Rk4 => 3,
        Integrator::ImplicitMidpoint => 4,
        Integrator::BackwardEuler => 5,
        Integrator::DormandPrince => 0,
        Integrator::Xpbd => 6,
        Integrator::ExplicitEuler => 7,
        // A method that nobody has tuned by yet.
        _ => 8,
    };
    ladders.sort_by_key(|ladder| (merit(ladder.integrator), ladder.precision == Precision::F64));
    ladders
}

/// A search under way.
struct Search<'a, 't> {
    scene: &'a Scene,
    right: &'a Reference,
    tuner: Option<&'a mut Tuner<'t>>,
    reliable: usize,
    goal: Goal,
    /// Whether the reference is accurate enough for any verdict.
    certain: bool,
    /// Ladders that were climbed, and all of them.
    methods: [usize; 2],
    /// The best of each ladder.
    found: Vec<Found>,
    /// Cost and error of every trial; the error of an unsound one is infinite.
    seen: Vec<(f64, f64)>,
}

impl Search<'_, '_> {
    /// Looks for the best choice of one method and precision; trials made before an early end
    /// count.
    fn climb(&mut self, ladder: Ladder, monitor: &mut dyn Monitor) -> Result<(), Halt> {
        let (mut trials, mut predicted) = (Vec::new(), Vec::new());
        let tried = self.try_all(ladder, (&mut trials, &mut predicted), monitor);
        let rows = trials.into_iter().zip(predicted);
        if let Some((trial, predicted)) = rows.min_by(|a, b| self.compare(&a.0, &b.0)) {
            let predicted_error = match predicted {
                None if tried.is_ok() => self.double(&trial, ladder, monitor).unwrap_or_default(),
                known => known,
            };
            self.found.push(Found { trial, predicted_error });
        }
        tried
    }

    /// Tries the choices that are worth it; notes the predicted error of each, metres.
    fn try_all(
        &mut self,
        ladder: Ladder,
        (trials, predicted): (&mut Vec<Trial>, &mut Vec<Option<f64>>),
        monitor: &mut dyn Monitor,
    ) -> Result<(), Halt> {
        let Some(mut fineness) = self.start(&ladder, monitor)? else { return Ok(()) };
        while trials.len() < TRIALS {
            if matches!(fineness, Fineness::Tolerance(t) if t < self.right.least_tolerance()) {
                break;
            }
            let choice = ladder.choice(fineness);
            if trials.iter().any(|trial| trial.choice == choice) || self.is_hopeless(trials) {
                break;
            }
            let (now, done) = (choice.to_string(), self.seen.len());
            monitor.report(Progress { now, done, parts: Some(self.methods), left: None });
            // A precision that cannot hold the scene is not a choice for it.
            let Some(mut trial) = self.attempt(choice, monitor)? else { break };
            // A setting that diverged costs nothing that would be compared.
            if self.tuner.is_some() && trial.errors.is_some() {
                trial.cost = self.time(choice, frames_of(self.right.duration()), monitor)?;
            }
            let error = if trial.is_sound() { trial.error() } else { f64::INFINITY };
            self.seen.push((trial.cost, error));
            predicted.push(predict(trials, fineness, ladder));
            trials.push(trial);
            let Some(next) = self.next(trials, ladder) else { break };
            fineness = next;
        }
        Ok(())
    }

    /// Tries a choice; `None` where the core refuses it.
    fn attempt(&self, choice: Choice, monitor: &mut dyn Monitor) -> Result<Option<Trial>, Halt> {
        unless_refused(try_choice(self.scene, choice, (self.right, self.reliable), monitor))
    }

    /// The cost of a choice, on the device if there is one.
    fn time(
        &mut self,
        choice: Choice,
        frames: u64,
        monitor: &mut dyn Monitor,
    ) -> Result<f64, Halt> {
        match &mut self.tuner {
            Some(tuner) => tuner.time((self.scene, choice), frames, monitor),
            None => time_choice(self.scene, choice, frames, monitor),
        }
    }

    /// The coarsest fineness that is worth a trial.
    fn start(
        &mut self,
        ladder: &Ladder,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Fineness>, Halt> {
        if ladder.integrator.is_adaptive() {
            let tolerance = match self.goal {
                Goal::MaxError(error) => error / self.right.size,
                Goal::Budget(_) => 1e-4,
            };
            return Ok(Some(Fineness::Tolerance(tolerance.clamp(1e-12, 1e-2))));
        }
        let Some(fewest) = ladder.fewest else { return Ok(None) };
        let Goal::Budget(budget) = self.goal else {
            return Ok(Some(Fineness::Substeps(fewest)));
        };
        // As fine as the budget allows, by the cost of a few frames of the coarsest.
        let frames = frames_of(self.right.duration()).min(6);
        let coarsest = ladder.choice(Fineness::Substeps(fewest));
        let cost = self.time(coarsest, frames, monitor);
        let Some(cost) = unless_refused(cost)? else { return Ok(None) };
        // A run that takes much longer than the reference is below its uncertainty: nothing to
        // choose by.
        let patience = (2.0 * self.right.seconds).max(0.5) / self.right.duration();
        let factor = (budget / FRAME).min(patience) / cost;
        let substeps = (f64::from(fewest) * factor).floor().min(1e6) as u32;
        // Where even the coarsest is too dear it is still the nearest.
        Ok(Some(Fineness::Substeps(substeps.max(fewest))))
    }

    /// Returns whether all that is left of a ladder costs too much: more than the best so far, much
    /// more than an equally good choice, or so much that the reference itself was cheaper.
    fn is_hopeless(&self, trials: &[Trial]) -> bool {
        let (Goal::MaxError(_), Some(last)) = (self.goal, trials.last()) else { return false };
        if self.meets(last) {
            return false;
        }
        let best = self.found.iter().filter(|found| self.meets(&found.trial));
        let best = best.map(|found| found.trial.cost).fold(f64::INFINITY, f64::min);
        let beats =
            |&(cost, error): &(f64, f64)| error < last.error() && HOPELESS * cost < last.cost;
        let patience = self.right.seconds.max(LEAST_PATIENCE);
        1.2 * best < last.cost
            || self.seen.iter().any(beats)
            || self.tuner.is_none() && patience < last.cost * self.right.duration()
    }

    fn meets(&self, trial: &Trial) -> bool {
        // Within a budget it is certain from the first.
        self.certain && self.goal.is_met_by(trial)
    }

    /// Which of two trials serves the goal better.
    fn compare(&self, a: &Trial, b: &Trial) -> std::cmp::Ordering {
        let (meets_a, meets_b) = (self.meets(a), self.meets(b));
        let by_cost = a.cost.total_cmp(&b.cost);
        let by_error = a.error().total_cmp(&b.error());
        let sound_first = b.is_sound().cmp(&a.is_sound());
        meets_b.cmp(&meets_a).then(sound_first).then(match (self.goal, meets_a) {
            (Goal::MaxError(_), true) | (Goal::Budget(_), false) => by_cost,
            _ => by_error,
        })
    }

    /// The next fineness to try on a ladder.
    fn next(&self, trials: &[Trial], ladder: Ladder) -> Option<Fineness> {
        let last = trials.last()?;
        let finer = match self.goal {
            // It blew up although it was predicted not to, as contact made it stiffer, or would.
            _ if !last.is_sound() && ladder.integrator.is_adaptive() => 10.0,
            _ if !last.is_sound() => 1.5,
            Goal::MaxError(error) => {
                let off = (last.error() / (AIM * error)).max(1e-12);
                if self.meets(last) && (0.8 < off || is_coarsest(last.choice, ladder)) {
                    return None;
                }
                // No better for being much finer: rounding or contact rules.
                let patient = ladder.integrator.is_adaptive() && ladder.precision == Precision::F64;
                if !patient && is_stuck(trials, error) {
                    return None;
                }
                // A tolerance ten times as tight costs little; ten times the substeps cost tenfold.
                let most = if ladder.integrator.is_adaptive() { 1e3 } else { 8.0 };
                off.powf(1.0 / order(trials, ladder)).clamp(0.1, most)
            }
            Goal::Budget(budget) => {
                let patience = (2.0 * self.right.seconds).max(0.5) / self.right.duration();
                let share = (budget / FRAME).min(patience) / last.cost;
                if share < 1.0 && is_coarsest(last.choice, ladder) {
                    return None;
                }
                let late = trials.len() > 3;
                if (0.85..=1.0).contains(&share) || (late && share <= 1.0) {
                    return None;
                }
                // The cost of an adaptive method goes as the fifth root of its tolerance.
                let power = if ladder.integrator.is_adaptive() { 5 } else { 1 };
                (0.97 * share).powi(power)
            }
        };
        Some(scaled(last.choice.fineness, finer, ladder))
    }

    /// The error that a trial of twice the fineness predicts for the first one of a ladder, metres:
    /// step doubling.
    fn double(
        &self,
        first: &Trial,
        ladder: Ladder,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<f64>, Halt> {
        let finer = ladder.choice(scaled(first.choice.fineness, 2.0, ladder));
        let finer = self.attempt(finer, monitor)?;
        Ok(finer.and_then(|finer| predict(&[finer], first.choice.fineness, ladder)))
    }

    /// Times the best of all ladders again, in turn, and chooses; `ended` is why the search ended
    /// before the last ladder, if it did.
    fn decide(mut self, ended: Option<Halt>, monitor: &mut dyn Monitor) -> Result<Tuned, Halt> {
        let frames = frames_of(self.right.duration());
        // A choice that missed a budget by a little may have been unlucky.
        let good = |row: &usize| {
            let trial = &self.found[*row].trial;
            let near =
                matches!(self.goal, Goal::Budget(budget) if trial.cost * FRAME < UNLUCKY * budget);
            self.meets(trial) || (near && trial.is_sound())
        };
        let good: Vec<usize> = (0..self.found.len()).filter(good).collect();
        let cost = |found: &Found| found.trial.cost;
        let least = good.iter().map(|&row| cost(&self.found[row])).fold(f64::INFINITY, f64::min);
        let rounds = (0.3 / (least * self.right.duration())).clamp(1.0, 9.0) as usize;
        for row in good.iter().cycle().take(rounds * good.len()) {
            let Trial { choice, cost, .. } = self.found[*row].trial;
            if cost < 3.0 * least || matches!(self.goal, Goal::Budget(_)) {
                match self.time(choice, frames, monitor) {
                    Err(Halt::Cancelled | Halt::Deadline) => break,
                    again => self.found[*row].trial.cost = cost.min(again?),
                }
            }
        }
        let is_cut_short = ended.is_some();
        let mut found = std::mem::take(&mut self.found);
        found.sort_by(|a, b| self.compare(&a.trial, &b.trial));
        found.retain(|found| found.trial.errors.is_some());
        let mut found = found.into_iter();
        let Some(best) = found.next() else {
            return Err(ended.unwrap_or_else(|| nothing_runs(self.scene).into()));
        };
        let reliable = self.reliable.min(self.right.frames.len());
        let moved = self.right.moved[..reliable].iter().copied();
        Ok(Tuned {
            goal: self.goal,
            met: self.meets(&best.trial),
            duration: self.right.duration(),
            horizon: self.right.horizon(best.trial.error().max(1e-9 * self.right.size)),
            reference_tolerance: self.right.tolerance,
            others: found.filter(|other| self.meets(&other.trial)).collect(),
            best,
            uncertainty: moved.fold(0.0, f64::max),
            compared: self.right.frames[reliable - 1] as f64 * FRAME,
            tried: self.seen.len(),
            is_cut_short,
        })
    }
}

/// The error of the most patient method explains best why a scene cannot be run.
fn nothing_runs(scene: &Scene) -> Error {
    let run = || -> Result<(), Error> {
        let settings = exact(scene, 1e-4)?.settings();
        let mut simulation = msd_core::Simulation::<f64>::new(scene, settings)?;
        (0..60).try_for_each(|_| simulation.step())
    };
    run().err().unwrap_or(Error::Empty)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::errors::Errors;

    #[test]
    fn an_error_within_the_wish_is_not_called_too_large() {
        let fineness = Fineness::Substeps(4);
        let (integrator, precision) = (Integrator::Rk4, Precision::F64);
        let trial = Trial {
            choice: Choice { integrator, fineness, precision },
            cost: 1e-3,
            errors: Some(Errors { rms: 1e-3, ..Errors::default() }),
            energies: Vec::new(),
            gained: 0.0,
            diverged: None,
        };
        let mut tuned = Tuned {
            goal: Goal::MaxError(2e-3),
            best: Found { trial, predicted_error: None },
            others: Vec::new(),
            met: false,
            uncertainty: 1e-2,
            duration: 1.0,
            compared: 1.0 / 60.0,
            horizon: None,
            reference_tolerance: 1e-9,
            tried: 1,
            is_cut_short: false,
        };
        assert!(tuned.verdict().starts_with("the reference is too uncertain"));
        tuned.goal = Goal::MaxError(5e-4);
        assert_eq!(tuned.verdict(), "no setting meets it");
    }
}
