//! A background search for one setting, as in `msd tune`.

use super::subject::subject_here;
use super::task::{RetryTask, SearchTask};
use super::worker::Worker;
use super::{Trade, choice_of};
use crate::session::Session;
use crate::session::run::Run;
use msd_scene::schema::Solver;
use msd_study::choice::FRAME;
use msd_study::quantity::estimate;
use msd_study::tune::{Elsewhere, Found, Goal, Tuned};
use std::sync::Arc;

/// A search in the current scene.
#[derive(Debug)]
pub struct Search {
    goal: Goal,
    /// `None` until the scene stays unchanged for a while.
    worker: Option<Worker<Tuned>>,
    /// Trial of the result from the state of the run at that time.
    retrial: Option<Worker<Elsewhere>>,
    /// Solver of the run after the search applied its result, or failed to meet the goal.
    left: Option<Solver>,
}

impl Search {
    /// Creates a search that waits for the scene to stay unchanged.
    pub(super) fn new(goal: Goal) -> Self {
        Search { goal, worker: None, retrial: None, left: None }
    }

    /// Returns the goal.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// Returns whether it is in progress.
    pub fn is_busy(&self) -> bool {
        self.left.is_none()
    }

    /// Describes its progress or its result.
    pub fn words(&self) -> String {
        let wish = match self.goal {
            Goal::MaxError(error) => format!("error below {}", estimate(error, "m")),
            Goal::Budget(budget) => format!("time per frame below {}", estimate(budget, "s")),
        };
        let Some(report) = self.worker.as_ref().map(Worker::report) else {
            return format!("searching for {wish}: waiting until you stop editing…");
        };
        let retrial = self.retrial.as_ref().map(Worker::report);
        let elsewhere = retrial.as_ref().and_then(|retrial| retrial.found.as_deref());
        if let Some(why) = report.failure {
            return format!("{wish}: the search failed: {why}");
        }
        match (&report.found, retrial.as_ref().and_then(|retrial| retrial.failure.as_ref())) {
            (_, Some(why)) => format!("{wish}: cannot be tried from the current state: {why}"),
            (Some(tuned), None) if !tuned.met => nearest_words(&wish, tuned),
            (Some(tuned), None) => match elsewhere {
                Some(elsewhere) => found_words(&wish, tuned, elsewhere),
                None => {
                    let now = retrial.and_then(|retrial| retrial.progress);
                    let now = now.map_or(String::new(), |progress| progress.now);
                    format!("searching for {wish}: found {}; {now}…", tuned.best.trial.choice)
                }
            },
            (None, None) => match &report.progress {
                Some(progress) => {
                    format!("searching for {wish}: {} tried, {}…", progress.done, progress.words())
                }
                None => format!("searching for {wish}…"),
            },
        }
    }

    /// Returns the next action after the background work: a trial of the result from a state, or
    /// its application.
    fn next(&self) -> Option<Next> {
        let report = self.worker.as_ref()?.report();
        let tuned = report.found.filter(|tuned| report.idle && tuned.met);
        let Some(tuned) = tuned else { return report.idle.then_some(Next::Nothing) };
        let Some(retrial) = &self.retrial else { return Some(Next::Retry(tuned)) };
        let report = retrial.report();
        report.idle.then(|| report.found.map_or(Next::Nothing, Next::Take))
    }
}

/// Next action after a search.
enum Next {
    Retry(Arc<Tuned>),
    Take(Arc<Elsewhere>),
    Nothing,
}

fn nearest_words(wish: &str, tuned: &Tuned) -> String {
    let Found { trial, .. } = &tuned.best;
    format!(
        "{wish}: {}, nothing was changed; nearest: {}, error {}, {} per frame; {} tried",
        tuned.verdict(),
        trial.choice,
        estimate(trial.error(), "m"),
        estimate(trial.cost * FRAME, "s"),
        tuned.tried
    )
}

fn found_words(wish: &str, tuned: &Tuned, elsewhere: &Elsewhere) -> String {
    let refused = elsewhere.refused.iter();
    let refused = refused.map(|(choice, why)| format!("{choice}: {why}")).collect::<Vec<_>>();
    let Some(trial) = &elsewhere.held else {
        return format!(
            "{wish}: nothing was changed: no setting tried meets it from the current state. {}",
            refused.join("; ")
        );
    };
    let mut words = format!(
        "{wish}: found {}: error {} from the current state; {} tried",
        trial.choice,
        estimate(trial.error(), "m"),
        tuned.tried
    );
    if tuned.is_cut_short {
        words += " (timed out: a better one may exist)";
    }
    if !refused.is_empty() {
        words += &format!("; rejected after a trial: {}", refused.join("; "));
    }
    words
}

impl Trade {
    /// Returns the search, unless the scene or the solver has changed since its end.
    pub fn search(&self, run: &Run) -> Option<&Search> {
        let search = self.search.as_ref().filter(|_| self.of == run.revision())?;
        let now = run.runner().solver();
        search.left.is_none_or(|left| left == now).then_some(search)
    }

    /// Begins a waiting search once there is a scene, and pauses it at the user's request. Returns
    /// whether it is at work.
    pub(super) fn refresh_search(&mut self) -> bool {
        let (Some(search), Some((scene, _))) = (&mut self.search, &self.subject) else {
            return false;
        };
        let goal = search.goal;
        let worker =
            search.worker.get_or_insert_with(|| Worker::start(SearchTask(scene.clone(), goal)));
        worker.set_paused(self.paused);
        if let Some(retrial) = &search.retrial {
            retrial.set_paused(self.paused);
        }
        search.is_busy()
    }
}

/// The search in the window.
impl Session {
    /// Searches for the cheapest setting within an error, or the most accurate within a budget, and
    /// applies it, unless the scene changes.
    pub fn search(&mut self, goal: Goal) {
        self.trade.search = Some(Search::new(goal));
    }

    /// Cancels the search.
    pub fn end_search(&mut self) {
        self.trade.search = None;
    }

    /// Returns the search with its result.
    pub fn searched(&self) -> Option<&Search> {
        self.trade.search(&self.run)
    }

    /// Continues with the result of a search: tries it from the current state, and applies what is
    /// sound there, once.
    pub(in crate::session) fn take_found(&mut self) {
        let scene = (&self.loaded, self.steady_force());
        let report = self.study();
        let Some(search) = self.trade.search.as_mut().filter(|search| search.is_busy()) else {
            return;
        };
        let Some(next) = search.next() else { return };
        if let Next::Retry(tuned) = &next
            && let Some(scene) = subject_here(self.run.runner(), scene)
        {
            let study = report.and_then(|report| report.found);
            let now = choice_of(self.run.runner());
            let mut trials = study.iter().flat_map(|study| &study.trials);
            let present = trials.find(|trial| now == Some(trial.choice));
            let task = RetryTask::new(scene, tuned, present);
            return search.retrial = Some(Worker::start(task));
        }
        if let Next::Take(elsewhere) = next
            && let Some(trial) = &elsewhere.held
        {
            self.adopt_as(trial.choice, "found setting", true);
        }
        let left = self.run.runner().solver();
        if let Some(search) = &mut self.trade.search {
            search.left = Some(left);
        }
    }
}
