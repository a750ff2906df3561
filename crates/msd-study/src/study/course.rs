//! A study under way: round by round from coarse to fine, resumable, each choice timed often.

use crate::candidates::choice::{Choice, FRAME, Fineness};
use crate::candidates::ladder::{Ladder, PRECISIONS, PREDICTION, ladders};
use crate::measure::clock::CpuClock;
use crate::measure::reference::{Reference, Sample, Wish, frames_of, reference};
use crate::measure::trial::{Trial, time_choice, try_choice};
use crate::measure::{cache, machine};
use crate::monitor::{Halt, Monitor, Progress};
use crate::space::known;
use crate::study::{ReferenceNote, Study};
use msd_core::{Friction, Scene, Settings, Simulation};
use msd_scene::Loaded;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Extent of a study.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Time to simulate, seconds.
    pub duration: f64,
    /// The error that the words are about, metres; none for a thousandth of the size.
    pub wanted: Option<f64>,
    /// Time of the processor to spend on trials and timing, seconds; the reference comes on top.
    pub budget: f64,
    /// Whether the rest of an interrupted study is forgotten.
    pub fresh: bool,
    /// Largest error of the reference, root mean square, as a fraction of the size of the scene.
    pub uncertainty: f64,
    /// Time of the processor after which the reference is not tightened further, seconds.
    pub patience: f64,
}

impl Default for Plan {
    fn default() -> Self {
        let Wish { duration, uncertainty, patience } = Wish::default();
        Plan { duration, wanted: None, budget: 60.0, fresh: false, uncertainty, patience }
    }
}

/// The remaining trials of one method.
#[derive(Debug)]
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
/// The most times that a choice is timed.
const ROUNDS: usize = 5;

/// A study that is under way: the reference is made, and trials follow one by one, in as many
/// calls of [`Course::advance`].
///
/// It neither observes limits nor audits, as [`study`](crate::study::conduct::study) does.
#[derive(Debug)]
pub struct Course {
    loaded: Loaded,
    plan: Plan,
    right: Reference,
    reliable: usize,
    /// The results so far.
    pub(super) study: Study,
    hash: String,
    spent: f64,
    /// Methods that are done, and all of them.
    methods: [usize; 2],
    /// Methods still to be tried, in turn; none before it is predicted which.
    climbs: Option<VecDeque<Climb>>,
    /// The round of timing, and the trial that is timed next in it.
    timed: (usize, usize),
}

impl Course {
    /// Makes the reference, and resumes an interrupted study.
    ///
    /// # Errors
    /// A scene that the core refuses; the error of [`Monitor::proceed`].
    pub fn begin(loaded: Loaded, plan: Plan, monitor: &mut dyn Monitor) -> Result<Self, Halt> {
        let scene = &loaded.scene;
        let simulation = Simulation::<f64>::new(scene, Settings::default())?;
        let model = simulation.model();
        let wanted = plan.wanted.unwrap_or(1e-3 * model.size());
        let Plan { duration, uncertainty, patience, .. } = plan;
        let wish = Wish { duration, uncertainty, patience };
        let right = reference(scene, wish, monitor)?;
        let reliable = right.comparable(0.1 * wanted);
        let bounds = (plan.duration, reliable);
        let hash = cache::content_hash(&(scene, bounds, machine::name()));
        let kept = if plan.fresh { None } else { cache::get(JOURNAL, &hash) };
        let energy = |sample: &Sample| simulation.energy_at(&sample.state()).total();
        let study = Study {
            scene: loaded.name.clone(),
            title: loaded.title.clone(),
            particles: model.particle_count(),
            springs: model.spring_count(),
            size: model.size(),
            duration: right.duration(),
            wanted,
            reference: note(&right, reliable, wanted),
            times: right.frames.iter().map(|&frame| frame as f64 * FRAME).collect(),
            energies: right.states.iter().map(energy).collect(),
            trials: kept.unwrap_or_default(),
            left_out: Vec::new(),
            limits: Vec::new(),
            audit: Vec::new(),
            space: known(scene),
            balance: None,
            on_device: None,
            words: String::new(),
            machine: machine::name(),
            date: machine::date(),
        };
        let (spent, methods, climbs, timed) = (0.0, [0, 0], None, (1, 0));
        Ok(Course { loaded, plan, right, reliable, study, hash, spent, methods, climbs, timed })
    }

    /// The study so far.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Predicts which methods are to be tried, then with each call makes the next trial or times
    /// one again. All methods climb side by side, and cheap trials come first. Returns whether
    /// there was anything to do.
    ///
    /// # Errors
    /// See [`Course::begin`].
    pub fn advance(&mut self, monitor: &mut dyn Monitor) -> Result<bool, Halt> {
        let Some(climbs) = &mut self.climbs else {
            monitor.report(Progress::of(PREDICTION));
            return self.predict().map(|()| true);
        };
        let Some(mut climb) = climbs.pop_front() else { return self.time_again(monitor) };
        let Some(choice) = climb.rungs.next() else {
            self.methods[0] += 1;
            return Ok(true);
        };
        monitor.report(self.progress(choice.to_string()));
        match self.climb_one(&mut climb, choice, monitor)? {
            None => self.climbs.get_or_insert_default().push_back(climb),
            Some(why) => {
                self.methods[0] += 1;
                self.study.left_out.extend(why);
            }
        }
        Ok(true)
    }

    /// Removes the stored trials, so that the study cannot be resumed.
    pub(super) fn forget(&self) {
        cache::remove(JOURNAL, &self.hash);
    }

    /// Predicts which methods are to be tried, and from where.
    fn predict(&mut self) -> Result<(), Halt> {
        let ladders = ladders(&self.loaded.scene)?.into_iter();
        let climbs = ladders.map(|ladder| self.climb(ladder));
        let climbs: VecDeque<_> =
            climbs.filter(|climb| !climb.rungs.as_slice().is_empty()).collect();
        self.methods[1] = climbs.len();
        self.climbs = Some(climbs);
        let Scene { planes, solids, .. } = &self.loaded.scene;
        let frictions = planes.iter().map(|plane| plane.friction);
        if frictions.chain(solids.iter().map(|solid| solid.friction)).any(is_steppy) {
            self.study.left_out.push(STEPPY.into());
        }
        Ok(())
    }

    /// The trials to make of a method.
    fn climb(&mut self, ladder: Ladder) -> Climb {
        if ladder.fewest.is_none() && ladder.precision == PRECISIONS[0] {
            let line = format!("{}: predicted unstable here at any step", ladder.integrator);
            self.study.left_out.push(line);
        }
        let least = self.right.least_tolerance();
        let mut rungs = ladder.rungs();
        rungs.retain(|choice| match choice.fineness {
            Fineness::Tolerance(tolerance) => least <= tolerance,
            Fineness::Substeps(_) => true,
        });
        Climb { rungs: rungs.into_iter(), best: f64::INFINITY, idle: 0 }
    }

    /// Tries a choice that the user asks for, unless it was tried before.
    ///
    /// # Errors
    /// See [`Course::begin`].
    pub fn grant(&mut self, choice: Choice, monitor: &mut dyn Monitor) -> Result<(), Halt> {
        if self.study.trials.iter().any(|trial| trial.choice == choice) {
            return Ok(());
        }
        monitor.report(self.progress(choice.to_string()));
        let trial = match self.attempt(choice, monitor) {
            Err(Halt::Refused(error)) => {
                let diverged = Some(error.to_string());
                let (cost, energies) = (f64::INFINITY, Vec::new());
                Trial { choice, cost, errors: None, energies, gained: 0.0, diverged }
            }
            trial => trial?,
        };
        self.study.trials.push(trial);
        Ok(())
    }

    fn attempt(&self, choice: Choice, monitor: &mut dyn Monitor) -> Result<Trial, Halt> {
        try_choice(&self.loaded.scene, choice, (&self.right, self.reliable), monitor)
    }

    /// The current work, and how far it is.
    pub(super) fn progress(&self, now: String) -> Progress {
        let left = (self.plan.budget - self.spent).max(0.0);
        let [tried, all] = self.methods;
        let (done, parts) = (self.study.trials.len(), (tried < all).then_some(self.methods));
        Progress { now, done, parts, left: Some(left) }
    }

    /// Tries one rung; returns whether the climb ends here, and a remark on it.
    fn climb_one(
        &mut self,
        climb: &mut Climb,
        choice: Choice,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Option<String>>, Halt> {
        let kept = self.study.trials.iter().position(|trial| trial.choice == choice);
        if kept.is_none() {
            if self.plan.budget * (1.0 - 0.4) < self.spent {
                return Ok(Some(Some(format!("{choice} and finer: the time was up"))));
            }
            let clock = CpuClock::start();
            let trial = match self.attempt(choice, monitor) {
                Err(Halt::Refused(error)) => {
                    return Ok(Some(Some(format!("{choice}: {error}"))));
                }
                trial => trial?,
            };
            self.spent += clock.seconds();
            self.study.trials.push(trial);
            cache::put(JOURNAL, &self.hash, &self.study.trials);
        }
        let trials = &self.study.trials;
        let trial = &trials[kept.unwrap_or(trials.len() - 1)];
        climb.idle = if trial.error() < 0.8 * climb.best { 0 } else { climb.idle + 1 };
        // A choice that diverges on the first rungs, or adds energy, may do better on the next.
        if trial.is_sound() {
            climb.best = climb.best.min(trial.error());
        } else {
            climb.idle = 0;
        }
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
        let beats = |other: &Trial| {
            let is_better = other.is_sound() && other.error() < trial.error();
            is_better && other.cost * HOPELESS < trial.cost
        };
        // A tolerance ten times as tight costs little and may gain much.
        let steep = trial.choice.integrator.is_adaptive();
        !steep && trial.errors.is_some() && self.study.trials.iter().any(beats)
    }

    /// Times the next choice again, in turn, and keeps its best; returns whether there was one.
    fn time_again(&mut self, monitor: &mut dyn Monitor) -> Result<bool, Halt> {
        while self.timed.0 < ROUNDS {
            let (round, row) = self.timed;
            let Some(trial) = self.study.trials.get(row) else {
                self.timed = (round + 1, 0);
                continue;
            };
            self.timed.1 += 1;
            let seconds = trial.cost * self.right.duration();
            let left = self.plan.budget - self.spent;
            // Long runs average over disturbances of short ones.
            if trial.errors.is_none() || left < seconds || 0.5 < seconds * round as f64 {
                continue;
            }
            let (choice, now) = (trial.choice, format!("timing, round {} of {ROUNDS}", round + 1));
            monitor.report(self.progress(now));
            let frames = frames_of(self.right.duration());
            let cost = time_choice(&self.loaded.scene, choice, frames, monitor)?;
            self.spent += cost * self.right.duration();
            let known = &mut self.study.trials[row].cost;
            *known = known.min(cost);
            return Ok(true);
        }
        Ok(false)
    }
}

fn is_steppy(friction: Friction) -> bool {
    matches!(friction, Friction::TangentialLoss(loss) if 0.0 < loss && loss < 1.0)
}

/// Remark on a scene with the friction of the source report.
const STEPPY: &str = "A tangential_loss takes its share in every substep of \
                          contact: after contact no two settings agree, and none converges to the \
                          reference, which takes it once per impact. Coulomb friction converges.";

fn note(right: &Reference, reliable: usize, wanted: f64) -> ReferenceNote {
    let compared = &right.moved[..reliable.min(right.moved.len())];
    ReferenceNote {
        tolerance: right.tolerance,
        substeps: right.substeps,
        uncertainty: compared.iter().copied().fold(0.0, f64::max),
        reliable_until: right.frames[reliable.min(right.frames.len()) - 1] as f64 * FRAME,
        horizon: right.horizon(wanted),
        seconds: right.seconds,
    }
}

/// Name of the trials of an unfinished study in the cache.
const JOURNAL: &str = "study";
