//! A search for one setting in the background, as `msd tune` makes it.

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

/// A search that was asked for, of the scene as it is.
#[derive(Debug)]
pub struct Search {
    goal: Goal,
    /// Nothing before the scene was left alone.
    worker: Option<Worker<Tuned>>,
    /// What was found, tried from the state that the run was in then.
    retrial: Option<Worker<Elsewhere>>,
    /// How the run was stepped once what was found was applied, or did not meet the goal.
    left: Option<Solver>,
}

impl Search {
    /// Waits until the scene is left alone.
    pub(super) fn new(goal: Goal) -> Self {
        Search { goal, worker: None, retrial: None, left: None }
    }

    /// What was asked for.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// Whether it is being worked out.
    pub fn is_busy(&self) -> bool {
        self.left.is_none()
    }

    /// How far it is, or what came of it.
    pub fn words(&self) -> String {
        let wish = match self.goal {
            Goal::MaxError(error) => format!("within {}", estimate(error, "m")),
            Goal::Budget(budget) => format!("within {} per frame", estimate(budget, "s")),
        };
        let Some(report) = self.worker.as_ref().map(Worker::report) else {
            return format!("searching {wish}: waiting until the scene is left alone…");
        };
        let retrial = self.retrial.as_ref().map(Worker::report);
        let elsewhere = retrial.as_ref().and_then(|retrial| retrial.found.as_deref());
        if let Some(why) = report.failure {
            return format!("{wish}: cannot be searched: {why}");
        }
        match (&report.found, retrial.as_ref().and_then(|retrial| retrial.failure.as_ref())) {
            (_, Some(why)) => format!("{wish}: cannot be tried from the state of now: {why}"),
            (Some(tuned), None) if !tuned.met => nearest_words(&wish, tuned),
            (Some(tuned), None) => match elsewhere {
                Some(elsewhere) => found_words(&wish, tuned, elsewhere),
                None => {
                    let now = retrial.and_then(|retrial| retrial.progress);
                    let now = now.map_or(String::new(), |progress| progress.now);
                    format!("searching {wish}: found {}; {now}…", tuned.best.trial.choice)
                }
            },
            (None, None) => match &report.progress {
                Some(progress) => {
                    format!("searching {wish}: {} tried, {}…", progress.done, progress.words())
                }
                None => format!("searching {wish}…"),
            },
        }
    }

    /// What is left to do, once the background has done what there was: try what was found from a
    /// state, or take it.
    fn next(&self) -> Option<Next> {
        let report = self.worker.as_ref()?.report();
        let tuned = report.found.filter(|tuned| report.idle && tuned.met);
        let Some(tuned) = tuned else { return report.idle.then_some(Next::Nothing) };
        let Some(retrial) = &self.retrial else { return Some(Next::Retry(tuned)) };
        let report = retrial.report();
        report.idle.then(|| report.found.map_or(Next::Nothing, Next::Take))
    }
}

/// What is to be done with what a search has found.
enum Next {
    Retry(Arc<Tuned>),
    Take(Arc<Elsewhere>),
    Nothing,
}

fn nearest_words(wish: &str, tuned: &Tuned) -> String {
    let Found { trial, .. } = &tuned.best;
    format!(
        "{wish}: {}, nothing was changed; the nearest is {}: {} off, {} per frame; {} tried",
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
            "{wish}: nothing was changed: what meets it in the study does not from the state of \
             now. {}",
            refused.join("; ")
        );
    };
    let mut words = format!(
        "{wish}: found {}: {} off from the state of now; {} tried",
        trial.choice,
        estimate(trial.error(), "m"),
        tuned.tried
    );
    if tuned.is_cut_short {
        words += " before the time was over: another may be better";
    }
    if !refused.is_empty() {
        words += &format!("; passed over from that state: {}", refused.join("; "));
    }
    words
}

impl Trade {
    /// The search, as long as the scene is the one that it is of, and is stepped as it left it.
    pub fn search(&self, run: &Run) -> Option<&Search> {
        let search = self.search.as_ref().filter(|_| self.of == run.revision())?;
        let now = run.runner().solver();
        search.left.is_none_or(|left| left == now).then_some(search)
    }

    /// Begins the search that waits for a scene to search in; rests where the user wants that.
    /// Returns whether it works.
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

/// The search on screen.
impl Session {
    /// Searches for the cheapest setting within an error, or the most accurate within a budget, as
    /// long as the scene stays as it is, and steps it by what was found.
    pub fn search(&mut self, goal: Goal) {
        self.trade.search = Some(Search::new(goal));
    }

    /// Ends the search.
    pub fn end_search(&mut self) {
        self.trade.search = None;
    }

    /// The search, and what came of it.
    pub fn searched(&self) -> Option<&Search> {
        self.trade.search(&self.run)
    }

    /// Goes on with what a search has found: tries it from the state of now, and steps the run by
    /// what holds there, once.
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
            self.adopt_as(trial.choice, "the search's setting", true);
        }
        let left = self.run.runner().solver();
        if let Some(search) = &mut self.trade.search {
            search.left = Some(left);
        }
    }
}
