//! The trade-off between speed and accuracy, measured in the background: a study of the current
//! scene, cost and effect of its terms, and choice of a setting.
//!
//! A study does not depend on the solver of the run: method, substeps and precision may change in
//! the meantime. Any other change voids it.

mod subject;
mod worker;
mod task;
mod search;
mod adopted;

pub use search::Search;
pub use subject::StudyFrom;
pub use task::STUDY_DURATION;
#[cfg(target_arch = "wasm32")]
pub(crate) use task::{RetryTask, SearchTask, SoundnessTask};
pub(crate) use task::{StudyTask, TermsTask};
#[cfg(target_arch = "wasm32")]
pub(crate) use worker::{Drive, Note, Order, Task, drive};
pub use worker::{MANNERS as STUDY_MANNERS, Report};

use super::Session;
use super::run::{Revision, Run};
use adopted::Adopted;
use msd_core::{Scene, Settings};
use msd_run::Runner;
use msd_scene::schema::{OrAuto, Solver, SolverRow};
use msd_scene::{Loaded, Precision};
use msd_study::Study;
use msd_study::choice::{Choice, Fineness};
use msd_study::conduct::Plan;
use msd_study::terms::TermRow;
use std::sync::Arc;
pub(super) use subject::subject;
use subject::{Now, is_same, loaded_of};
use worker::Worker;

/// CPU time for trials and timing, seconds.
const BUDGET: f64 = 30.0;
/// CPU time for the reference, seconds: short, so that the first points appear soon.
const PATIENCE: f64 = 4.0;
/// Target uncertainty of the reference, relative to the size of the scene.
const UNCERTAINTY: f64 = 1e-7;
/// Number of points before the terms of the scene are measured.
const FIRST: usize = 8;
/// Time without a change before a study begins, seconds of wall clock.
const CALM: f64 = 0.4;

/// The background study of a session.
#[derive(Debug, Default)]
pub struct Trade {
    /// Whether the user has opened it.
    on: bool,
    paused: bool,
    from: StudyFrom,
    /// The studied scene, and the simulated time of its start, seconds.
    subject: Option<(Scene, f64)>,
    /// The revision of the run at the last comparison with the subject.
    of: Revision,
    /// Wall-clock time since the last change of the scene, seconds.
    calm: f64,
    study: Option<Worker<Study>>,
    terms: Option<Terms>,
    former_terms: Option<FormerTerms>,
    search: Option<Search>,
    /// The last choice in the trade-off.
    adopted: Option<Adopted>,
}

/// Cost and effect of the terms of the scene, and the solver of the measurement.
#[derive(Debug)]
struct Terms {
    solver: Solver,
    /// The solver in words.
    of: String,
    worker: Worker<Vec<TermRow>>,
}

/// Cost and effect of the terms of the scene with the previous solver.
#[derive(Clone, Debug)]
pub struct FormerTerms {
    /// The previous solver, in words.
    pub of: String,
    /// A row for each term.
    pub rows: Arc<Vec<TermRow>>,
}

impl Trade {
    /// Returns whether it is open and at work.
    pub fn is_on(&self) -> bool {
        self.on
    }

    /// Returns whether the user has paused it.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Returns the state that the study starts from.
    pub fn from(&self) -> StudyFrom {
        self.from
    }

    /// Returns the simulated time of the start of the study, seconds; `None` before it began.
    pub fn start(&self) -> Option<f64> {
        self.subject.as_ref().map(|(_, start)| *start)
    }

    /// Returns the study so far; `None` if there is none of the current scene.
    pub fn study(&self, run: &Run) -> Option<Report<Study>> {
        (self.of == run.revision()).then(|| self.study.as_ref().map(Worker::report)).flatten()
    }

    /// Returns cost and effect of each term; `None` if there are none for the current run.
    pub fn terms(&self, run: &Run) -> Option<Report<Vec<TermRow>>> {
        let terms = self.terms.as_ref().filter(|_| self.of == run.revision())?;
        (terms.solver == run.runner().solver()).then(|| terms.worker.report())
    }

    /// Returns cost and effect of each term of the current scene with the previous solver.
    pub fn former_terms(&self, run: &Run) -> Option<FormerTerms> {
        self.former_terms.clone().filter(|_| self.of == run.revision())
    }

    /// Returns the changes of the last choice, unless another change followed.
    pub fn adopted(&self, run: &Run) -> Option<&str> {
        self.adopted_now(run).map(|adopted| &*adopted.text)
    }

    /// Returns why that choice should not stay: from the state at the time of the choice, it
    /// diverges or gains energy.
    pub fn fault(&self, run: &Run) -> Option<String> {
        self.adopted_now(run).and_then(Adopted::fault)
    }

    fn adopted_now(&self, run: &Run) -> Option<&Adopted> {
        let now = choice_of(run.runner());
        self.adopted.as_ref().filter(|adopted| now == Some(adopted.choice))
    }

    /// Voids results of an earlier scene; called after every change of the run.
    pub(super) fn follow(&mut self, run: &Run, scene: Now<'_>) {
        if !self.on || self.of == run.revision() {
            return;
        }
        self.of = run.revision();
        let now = subject(run.runner(), scene, self.from);
        let is_kept = matches!((&self.subject, &now), (Some((a, _)), Some(b)) if is_same(a, b));
        if !is_kept {
            self.void();
        }
    }

    fn void(&mut self) {
        (self.study, self.search) = (None, None);
        (self.terms, self.former_terms) = (None, None);
        (self.subject, self.calm) = (None, 0.0);
    }

    /// Begins pending work, and requests a trial of the current setting.
    pub(super) fn refresh(&mut self, run: &Run, scene: Now<'_>, real: f64) {
        if !self.on {
            return;
        }
        self.follow(run, scene);
        self.calm += real.max(0.0);
        let runner = run.runner();
        if self.subject.is_none() && CALM <= self.calm {
            self.begin(runner, scene);
        }
        self.refresh_terms(runner, scene.0);
        let is_searching = self.refresh_search() | self.refresh_adopted(run, scene, real);
        let Some(study) = &self.study else { return };
        // One at a time: together they must not exceed their share.
        let terms = self.terms.as_ref().map(|terms| terms.worker.report());
        let report = study.report();
        let points = report.found.as_ref().map_or(0, |study| study.trials.len());
        let is_first = !report.idle && points < FIRST;
        let is_busy = terms.is_some_and(|terms| !terms.idle);
        study.set_paused(self.paused || is_searching || (is_busy && !is_first));
        if let Some(terms) = &self.terms {
            terms.worker.set_paused(self.paused || is_searching || is_first);
        }
        if let Some(choice) = choice_of(runner)
            && let Some(found) = report.found
            && found.trials.iter().all(|trial| trial.choice != choice)
        {
            study.wish(choice);
        }
    }

    fn begin(&mut self, runner: &Runner, now: Now<'_>) {
        self.calm = 0.0;
        let Some(scene) = subject(runner, now, self.from) else { return };
        let start = match self.from {
            StudyFrom::Start => 0.0,
            StudyFrom::Here => runner.time(),
        };
        let studied = loaded_of(scene.clone().from_time(start), now.0, solver(runner));
        self.subject = Some((scene, start));
        let plan = Plan {
            duration: STUDY_DURATION,
            budget: BUDGET,
            uncertainty: UNCERTAINTY,
            patience: PATIENCE,
            ..Plan::default()
        };
        self.study = Some(Worker::start(StudyTask::new(studied, plan)));
    }

    /// Begins to measure the terms of the scene with the current solver; until then, the results
    /// with the previous one are kept.
    fn refresh_terms(&mut self, runner: &Runner, loaded: &Loaded) {
        let Some((scene, _)) = &self.subject else { return };
        let now = runner.solver();
        if let Some(terms) = self.terms.take_if(|terms| terms.solver != now)
            && let Some(rows) = terms.worker.report().found
        {
            self.former_terms = Some(FormerTerms { of: terms.of, rows });
        }
        self.terms.get_or_insert_with(|| {
            let solver = solver(runner);
            let studied = loaded_of(scene.clone(), loaded, solver);
            let worker = Worker::start(TermsTask(studied));
            worker.set_paused(true);
            Terms { solver: now, of: Choice::of(solver.0, solver.1).to_string(), worker }
        });
    }

    /// Begins a trial of the last choice from the current state; returns whether it is in progress.
    fn refresh_adopted(&mut self, run: &Run, scene: Now<'_>, real: f64) -> bool {
        let now = choice_of(run.runner());
        // The trial of a replaced choice ends.
        self.adopted.take_if(|adopted| now != Some(adopted.choice));
        let Some(adopted) = &mut self.adopted else { return false };
        adopted.refresh((run.runner(), scene), real, self.paused)
    }
}

fn solver(runner: &Runner) -> (Settings, Precision) {
    (runner.settings(), runner.precision())
}

/// Returns the choice that matches the solver of a run. `None` if its substeps do not divide a
/// frame, or its Newton iterations differ from those of a study: no measurement applies to it.
pub fn choice_of(runner: &Runner) -> Option<Choice> {
    let (settings, precision) = solver(runner);
    let choice = Choice::of(settings, precision);
    let measured = choice.settings();
    let is_newton = !settings.integrator.is_implicit() || settings.newton == measured.newton;
    let is_whole = settings.integrator.is_adaptive()
        || (measured.substep() / settings.substep() - 1.0).abs() < 1e-9;
    (is_newton && is_whole).then_some(choice)
}

/// The trade-off in the window.
impl Session {
    /// Returns the measurements of the trade-off.
    pub fn trade(&self) -> &Trade {
        &self.trade
    }

    /// Returns the study of the current scene so far.
    pub fn study(&self) -> Option<Report<Study>> {
        self.trade.study(&self.run)
    }

    /// Returns cost and effect of the terms of the current scene.
    pub fn terms(&self) -> Option<Report<Vec<TermRow>>> {
        self.trade.terms(&self.run)
    }

    /// Returns the same with the previous solver.
    pub fn former_terms(&self) -> Option<FormerTerms> {
        self.trade.former_terms(&self.run)
    }

    /// Returns the changes of the last choice.
    pub fn adopted(&self) -> Option<&str> {
        self.trade.adopted(&self.run)
    }

    /// Returns why that choice should not stay, from the state at the time of the choice.
    pub fn fault_of_adopted(&self) -> Option<String> {
        self.trade.fault(&self.run)
    }

    /// Opens the trade-off and begins to measure, or closes it.
    pub fn set_trading(&mut self, on: bool) {
        if on != self.trade.on {
            let Trade { paused, from, .. } = self.trade;
            self.trade = Trade { on, paused, from, calm: CALM, ..Trade::default() };
        }
    }

    /// Pauses or resumes the study.
    pub fn set_study_paused(&mut self, paused: bool) {
        self.trade.paused = paused;
    }

    /// Restarts the study from the initial or the current state.
    pub fn study_from(&mut self, from: StudyFrom) {
        self.trade.void();
        (self.trade.from, self.trade.calm) = (from, CALM);
    }

    /// Gives the run a choice as its solver: method, substeps or tolerance, precision.
    ///
    /// A choice is for frames of 1/60 s; for a step of another length, the substeps are at most as
    /// long. A trial from the current state runs in the background.
    pub fn adopt(&mut self, choice: Choice) {
        self.adopt_as(choice, "chosen setting", false);
    }

    /// Does the same, with a name for undo, and whether a trial from the current state was made.
    fn adopt_as(&mut self, choice: Choice, words: &'static str, is_tried: bool) {
        let before = solver(self.runner());
        let measured = choice.settings();
        let mut change = SolverRow::precision(choice.precision);
        change.integrator = Some(choice.integrator);
        match choice.fineness {
            Fineness::Substeps(_) => {
                let substeps = (before.0.step / measured.substep() - 1e-9).ceil().max(1.0);
                change.substeps = Some(OrAuto::Given(substeps as u64));
            }
            Fineness::Tolerance(tolerance) => change.tolerance = Some(tolerance),
        }
        if choice.integrator.is_implicit() {
            change.newton = Some(measured.newton.into());
        }
        if self.runner().solver().with(&change) != self.runner().solver() {
            self.tune_as(change, words);
        }
        let text = changes(before, solver(self.runner()));
        let taken = choice_of(self.runner());
        self.trade.adopted = taken.map(|choice| Adopted::new(text, choice, is_tried));
    }
}

/// Describes the differences between two solvers.
fn changes(before: (Settings, Precision), after: (Settings, Precision)) -> String {
    let [old, new] = [before, after].map(|(settings, precision)| Choice::of(settings, precision));
    let mut changes = Vec::new();
    if old.integrator != new.integrator {
        changes.push(format!("{} to {}", old.integrator, new.integrator));
    }
    if old.fineness != new.fineness {
        changes.push(format!("{} to {}", old.fineness(), new.fineness()));
    }
    if old.precision != new.precision {
        changes.push(format!("{} to {}", old.precision, new.precision));
    }
    if changes.is_empty() { "nothing".into() } else { changes.join(", ") }
}
