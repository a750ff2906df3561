//! The conduct of a study: round by round from coarse to fine, resumable, each choice timed often.

use crate::behaviour::audit::audit_all;
use crate::behaviour::limits::limits;
use crate::candidates::choice::{Choice, FRAME, Fineness};
use crate::candidates::ladder::{Ladder, ladders};
use crate::measure::clock::CpuClock;
use crate::measure::reference::{Reference, Wish, frames_of, reference};
use crate::measure::trial::{Trial, time_choice, try_choice};
use crate::measure::{cache, machine};
use crate::study::words::words;
use crate::study::{ReferenceNote, Study};
use msd_core::{Error, Friction, Plane, Settings, Simulation};
use msd_scene::Loaded;

/// What a study is to cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Time to simulate, seconds.
    pub duration: f64,
    /// The error that the words are about, metres; none for a thousandth of the size.
    pub wanted: Option<f64>,
    /// Time of the processor to spend on trials and timing, seconds; the reference comes on top.
    pub budget: f64,
    /// Whether what an interrupted study left is forgotten.
    pub fresh: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { duration: 1.0, wanted: None, budget: 60.0, fresh: false }
    }
}

/// How far a study is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub now: String,
    /// Trials done.
    pub done: usize,
    /// Time of the processor still to be spent, at most, seconds; none before it can be told.
    pub left: Option<f64>,
}

/// What is still to be tried of one method.
struct Climb {
    rungs: std::vec::IntoIter<Choice>,
    /// The best error so far and how many rungs did not better it.
    best: f64,
    idle: usize,
}

/// A trial may take this share of the budget.
const SHARE: f64 = 0.1;
/// Rungs that may pass without a better error: then rounding or contact rules.
const IDLE: usize = 2;
/// A climb ends where another trial is better at this part of the cost.
const HOPELESS: f64 = 8.0;
/// How often each choice is timed at most.
const ROUNDS: usize = 5;

/// Studies a scene. `tell` hears how far it is.
///
/// # Errors
/// What the core refuses of the scene.
pub fn study(loaded: &Loaded, plan: Plan, tell: &mut dyn FnMut(Progress)) -> Result<Study, Error> {
    let scene = &loaded.scene;
    let simulation = Simulation::<f64>::new(scene, Settings::default())?;
    let model = simulation.model();
    let wanted = plan.wanted.unwrap_or(1e-3 * model.size());
    let now = |now: &str| Progress { now: now.into(), done: 0, left: None };
    tell(now("making the reference"));
    let wish = Wish { duration: plan.duration, ..Wish::default() };
    let right = reference(scene, wish)?;
    let reliable = right.comparable(0.1 * wanted);
    let mut run = Course::resume(loaded, plan, (&right, reliable));
    let mut left_out = run.climb_all(ladders(scene)?, tell)?;
    let steppy = |plane: &Plane| is_steppy(plane.friction);
    if scene.planes.iter().any(steppy) {
        left_out.push(STEPPY.into());
    }
    run.time_again(tell)?;
    tell(Progress { now: "observing the limits".into(), done: run.trials.len(), left: None });
    let mut limits = limits(scene, loaded.settings.substeps)?;
    limits.retain(|limit| limit.predicted.is_finite());
    let mut study = Study {
        scene: loaded.name.clone(),
        title: loaded.title.clone(),
        particles: model.particle_count(),
        springs: model.spring_count(),
        size: model.size(),
        duration: right.duration(),
        wanted,
        reference: note(&right, reliable, wanted),
        times: right.frames.iter().map(|&frame| frame as f64 * FRAME).collect(),
        energies: right.states.iter().map(|s| simulation.energy_at(&s.state()).total()).collect(),
        trials: std::mem::take(&mut run.trials),
        left_out,
        limits,
        audit: Vec::new(),
        words: String::new(),
        machine: machine::name(),
        date: machine::date(),
    };
    tell(Progress { now: "auditing".into(), done: study.trials.len(), left: None });
    study.audit = audit_all(scene, &representatives(&study))?;
    study.words = words(&study);
    run.forget();
    Ok(study)
}

fn is_steppy(friction: Friction) -> bool {
    matches!(friction, Friction::TangentialLoss(loss) if 0.0 < loss && loss < 1.0)
}

fn note(right: &Reference, reliable: usize, wanted: f64) -> ReferenceNote {
    let compared = &right.moved[..reliable.min(right.moved.len())];
    ReferenceNote {
        tolerance: right.tolerance,
        uncertainty: compared.iter().copied().fold(0.0, f64::max),
        reliable_until: right.frames[reliable.min(right.frames.len()) - 1] as f64 * FRAME,
        horizon: right.horizon(wanted),
        seconds: right.seconds,
    }
}

/// Of each method the cheapest choice within the wanted error, or else its best.
pub fn representatives(study: &Study) -> Vec<Choice> {
    let best = |integrator| {
        let fine = |trial: &&Trial| trial.error() <= study.wanted;
        let cheapest = study.of(integrator).filter(fine).min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = || study.of(integrator).min_by(|a, b| a.error().total_cmp(&b.error()));
        cheapest.or_else(best).map(|trial| trial.choice)
    };
    msd_core::Integrator::ALL.into_iter().filter_map(best).collect()
}

/// A study that is under way.
struct Course<'a> {
    loaded: &'a Loaded,
    plan: Plan,
    right: &'a Reference,
    reliable: usize,
    trials: Vec<Trial>,
    hash: String,
    spent: f64,
}

impl<'a> Course<'a> {
    fn resume(loaded: &'a Loaded, plan: Plan, (right, reliable): (&'a Reference, usize)) -> Self {
        let bounds = (plan.duration, reliable);
        let hash = cache::content_hash(&(&loaded.scene, bounds, machine::name()));
        let kept = if plan.fresh { None } else { cache::get(JOURNAL, &hash) };
        Course { loaded, plan, right, reliable, trials: kept.unwrap_or_default(), hash, spent: 0.0 }
    }

    fn forget(&self) {
        cache::remove(JOURNAL, &self.hash);
    }

    /// Climbs all ladders side by side, so that what is cheap comes first.
    fn climb_all(
        &mut self,
        ladders: Vec<Ladder>,
        tell: &mut dyn FnMut(Progress),
    ) -> Result<Vec<String>, Error> {
        let mut left_out = Vec::new();
        let mut climbs = Vec::new();
        let least = self.right.least_tolerance();
        for ladder in ladders {
            if ladder.fewest.is_none()
                && ladder.precision == crate::candidates::ladder::PRECISIONS[0]
            {
                let integrator = ladder.integrator;
                left_out.push(format!("{integrator}: predicted unstable here at any step"));
            }
            let mut rungs = ladder.rungs();
            rungs.retain(|choice| match choice.fineness {
                Fineness::Tolerance(tolerance) => least <= tolerance,
                Fineness::Substeps(_) => true,
            });
            let rungs = rungs.into_iter();
            climbs.push(Climb { rungs, best: f64::INFINITY, idle: 0 });
        }
        while !climbs.is_empty() {
            let mut kept = Vec::new();
            for mut climb in climbs {
                let Some(choice) = climb.rungs.next() else { continue };
                tell(self.progress(choice));
                match self.climb_one(&mut climb, choice)? {
                    None => kept.push(climb),
                    Some(why) => left_out.extend(why),
                }
            }
            climbs = kept;
        }
        Ok(left_out)
    }

    fn progress(&self, choice: Choice) -> Progress {
        let left = (self.plan.budget - self.spent).max(0.0);
        Progress { now: choice.to_string(), done: self.trials.len(), left: Some(left) }
    }

    /// Tries one rung; returns whether the climb ends here, and what to say of it.
    fn climb_one(
        &mut self,
        climb: &mut Climb,
        choice: Choice,
    ) -> Result<Option<Option<String>>, Error> {
        let kept = self.trials.iter().position(|trial| trial.choice == choice);
        if kept.is_none() {
            if self.plan.budget * (1.0 - 0.4) < self.spent {
                return Ok(Some(Some(format!("{choice} and finer: the time was up"))));
            }
            let clock = CpuClock::start();
            let (scene, right) = (&self.loaded.scene, self.right);
            let trial = match try_choice(scene, choice, right, self.reliable) {
                Ok(trial) => trial,
                Err(error) => return Ok(Some(Some(format!("{choice}: {error}")))),
            };
            self.spent += clock.seconds();
            self.trials.push(trial);
            cache::put(JOURNAL, &self.hash, &self.trials);
        }
        let trial = &self.trials[kept.unwrap_or(self.trials.len() - 1)];
        climb.idle = if trial.error() < 0.8 * climb.best { 0 } else { climb.idle + 1 };
        // What diverges on the first rungs may do better on the next.
        if trial.errors.is_none() {
            climb.idle = 0;
        }
        climb.best = climb.best.min(trial.error());
        if IDLE <= climb.idle || self.is_beaten(trial) {
            return Ok(Some(None));
        }
        if self.plan.budget * SHARE < 1.5 * trial.cost * self.right.duration() {
            return Ok(Some(Some(format!("finer than {choice}: takes too long"))));
        }
        Ok(None)
    }

    /// Whether another trial is better at a small part of the cost: finer ones of this method will
    /// not catch up.
    fn is_beaten(&self, trial: &Trial) -> bool {
        let beats =
            |other: &Trial| other.error() < trial.error() && other.cost * HOPELESS < trial.cost;
        // A tolerance ten times as tight costs little and may gain much.
        let steep = trial.choice.integrator.is_adaptive();
        !steep && trial.errors.is_some() && self.trials.iter().any(beats)
    }

    /// Times every choice again, in turn, and keeps its best.
    fn time_again(&mut self, tell: &mut dyn FnMut(Progress)) -> Result<(), Error> {
        let frames = frames_of(self.right.duration());
        for round in 1..ROUNDS {
            for row in 0..self.trials.len() {
                let Trial { choice, cost, errors, .. } = self.trials[row].clone();
                let seconds = cost * self.right.duration();
                let left = self.plan.budget - self.spent;
                // Long runs average over what disturbs short ones.
                if errors.is_none() || left < seconds || 0.5 < seconds * round as f64 {
                    continue;
                }
                tell(Progress {
                    now: format!("timing, round {} of {ROUNDS}", round + 1),
                    done: self.trials.len(),
                    left: Some(left),
                });
                let cost = time_choice(&self.loaded.scene, choice, frames)?;
                self.spent += cost * self.right.duration();
                self.trials[row].cost = self.trials[row].cost.min(cost);
            }
        }
        Ok(())
    }
}

/// What is said of a scene with the friction of the source report.
pub const STEPPY: &str = "The tangential_loss of a plane takes its share in every substep of \
                          contact: after contact no two settings agree, and none converges to the \
                          reference, which takes it once per impact. Coulomb friction converges.";

/// What the cache calls the trials of a study that is not finished.
const JOURNAL: &str = "study";
