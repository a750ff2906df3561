//! A search for one setting in the background, as `msd tune` makes it.

use super::Trade;
use super::task::SearchTask;
use super::worker::{Report, Worker};
use crate::session::Session;
use crate::session::run::Run;
use msd_study::choice::FRAME;
use msd_study::quantity::estimate;
use msd_study::tune::{Goal, Tuned};

/// A search that was asked for, of the scene as it is.
#[derive(Debug)]
pub struct Search {
    goal: Goal,
    /// Nothing before the scene was left alone.
    worker: Option<Worker<Tuned>>,
    /// Whether what was found was applied, or did not meet the goal.
    is_over: bool,
}

impl Search {
    /// Waits until the scene is left alone.
    pub(super) fn new(goal: Goal) -> Self {
        Search { goal, worker: None, is_over: false }
    }

    /// What was asked for.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// Whether it is being worked out.
    pub fn is_busy(&self) -> bool {
        !self.is_over
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
        match (&report.found, &report.failure, &report.progress) {
            (_, Some(why), _) => format!("{wish}: cannot be searched: {why}"),
            (Some(tuned), ..) => found_words(&wish, tuned),
            (.., Some(progress)) => {
                format!("searching {wish}: {} tried; {}…", progress.done, progress.now)
            }
            _ => format!("searching {wish}…"),
        }
    }

    fn report(&self) -> Option<Report<Tuned>> {
        self.worker.as_ref().map(Worker::report)
    }
}

fn found_words(wish: &str, tuned: &Tuned) -> String {
    let trial = &tuned.best.trial;
    let verdict = match tuned.met {
        true => "found",
        false => "no setting meets it, nothing was changed; the nearest is",
    };
    format!(
        "{wish}: {verdict} {}: {} off, {} per frame; {} tried",
        trial.choice,
        estimate(trial.error(), "m"),
        estimate(trial.cost * FRAME, "s"),
        tuned.tried
    )
}

impl Trade {
    /// The search, as long as the scene is the one that it is of.
    pub fn search(&self, run: &Run) -> Option<&Search> {
        self.search.as_ref().filter(|_| self.of == run.revision())
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
        !worker.report().idle
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

    /// Applies what a search has found, once.
    pub(in crate::session) fn take_found(&mut self) {
        let Some(search) = self.trade.search.as_mut().filter(|search| !search.is_over) else {
            return;
        };
        let Some(report) = search.report().filter(|report| report.idle) else { return };
        search.is_over = true;
        if let Some(tuned) = report.found.filter(|tuned| tuned.met) {
            self.adopt(tuned.best.trial.choice);
        }
    }
}
