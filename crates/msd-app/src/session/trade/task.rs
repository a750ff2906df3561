//! The tasks of the trade: a study, the prices of the parts, a search.

use super::worker::{Job, Task};
use msd_core::Scene;
use msd_run::rescue::LASTING;
use msd_scene::Loaded;
use msd_study::Study;
use msd_study::conduct::{Course, Plan};
use msd_study::leave::Halt;
use msd_study::terms::{TermRow, terms_by_leave};
use msd_study::tune::{Elsewhere, Found, Goal, Tuned, retry, tune_followed};
use serde::{Deserialize, Serialize};

/// Simulated time of a study, seconds.
pub const STUDY_DURATION: f64 = 1.0;

/// A study, which when nothing is left of it waits for wishes.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StudyTask {
    loaded: Loaded,
    plan: Plan,
    /// Nothing before it began.
    #[serde(skip)]
    course: Option<Course>,
}

impl StudyTask {
    pub(super) fn new(loaded: Loaded, plan: Plan) -> Self {
        StudyTask { loaded, plan, course: None }
    }
}

impl Task for StudyTask {
    type Found = Study;
    const NAME: &'static str = "study";
    const IN_PIECES: bool = true;

    fn advance(&mut self, job: &mut Job<Study>) -> Result<bool, Halt> {
        let Some(course) = &mut self.course else {
            self.course = Some(Course::begin(self.loaded.clone(), self.plan, job)?);
            return Ok(true);
        };
        if course.advance(job)? {
            return Ok(true);
        }
        let Some(choice) = job.wished(true) else { return Ok(false) };
        course.grant(choice, job)?;
        Ok(true)
    }
}

/// The worth of the parts of a scene, as it is stepped.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TermsTask(pub(super) Loaded);

impl Task for TermsTask {
    type Found = Vec<TermRow>;
    const NAME: &'static str = "terms";
    const IN_PIECES: bool = false;

    fn advance(&mut self, job: &mut Job<Vec<TermRow>>) -> Result<bool, Halt> {
        if !job.may_go_on() {
            return Err(Halt::Stopped);
        }
        let rows = terms_by_leave(&self.0, STUDY_DURATION, &mut || job.may_go_on())?;
        job.show(rows);
        Ok(false)
    }
}

/// A search for one setting, as `msd tune` makes it.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SearchTask(pub(super) Scene, pub(super) Goal);

impl Task for SearchTask {
    type Found = Tuned;
    const NAME: &'static str = "search";
    const IN_PIECES: bool = false;

    fn advance(&mut self, job: &mut Job<Tuned>) -> Result<bool, Halt> {
        let tuned = tune_followed(&self.0, STUDY_DURATION, self.1, job)?;
        job.show(tuned);
        Ok(false)
    }
}

/// What a search has found, tried in the scene as it is now.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RetryTask {
    scene: Scene,
    found: Vec<Found>,
    goal: Goal,
}

impl RetryTask {
    pub(super) fn new(scene: Scene, Tuned { goal, best, others, .. }: &Tuned) -> Self {
        let found = std::iter::once(best).chain(others).cloned().collect();
        RetryTask { scene, found, goal: *goal }
    }
}

impl Task for RetryTask {
    type Found = Elsewhere;
    const NAME: &'static str = "retry";
    const IN_PIECES: bool = false;

    fn advance(&mut self, job: &mut Job<Elsewhere>) -> Result<bool, Halt> {
        let wish = (self.goal, STUDY_DURATION, LASTING);
        let elsewhere = retry(&self.scene, &self.found, wish, job)?;
        job.show(elsewhere);
        Ok(false)
    }
}
