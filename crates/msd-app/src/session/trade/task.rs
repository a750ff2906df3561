//! The tasks of the trade-off: a study, the terms, a search, trials of settings.

use super::worker::Task;
use msd_core::Scene;
use msd_run::rescue::LASTING;
use msd_scene::Loaded;
use msd_study::Study;
use msd_study::choice::Choice;
use msd_study::conduct::{Course, Plan};
use msd_study::monitor::{Deadline, Halt, Monitor};
use msd_study::terms::{TermRow, terms};
use msd_study::trial::{Trial, find_fault};
use msd_study::tune::{Elsewhere, Goal, Tuned, retry, tune};
use serde::{Deserialize, Serialize};
use std::iter;

/// Simulated time of a study, seconds.
pub const STUDY_DURATION: f64 = 1.0;

/// Time limit for the reference of a study, seconds.
const STUDYING: f64 = 120.0;
/// Time limits for a search and for a trial of its result, seconds.
const SEARCHING: f64 = 25.0;
const RETRYING: f64 = 15.0;

/// Least ratio by which a setting must be better than the current one: less is measurement noise.
const NOISE: f64 = 1.1;

/// A study, which then waits for requested choices.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StudyTask {
    loaded: Loaded,
    plan: Plan,
    /// `None` before it began.
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

    fn advance(
        &mut self,
        choice: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Study>, Halt> {
        match (&mut self.course, choice) {
            (None, _) => {
                let monitor = &mut Deadline::new(monitor, STUDYING);
                self.course = Some(Course::begin(self.loaded.clone(), self.plan, monitor)?);
            }
            (Some(course), Some(choice)) => course.grant(choice, monitor)?,
            (Some(course), None) => {
                if !course.advance(monitor)? {
                    return Ok(None);
                }
            }
        }
        Ok(self.course.as_ref().map(|course| course.study().clone()))
    }
}

/// Cost and effect of the terms of a scene with its solver.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TermsTask(pub(super) Loaded);

impl Task for TermsTask {
    type Found = Vec<TermRow>;
    const NAME: &'static str = "terms";
    const IN_PIECES: bool = false;

    fn advance(
        &mut self,
        _: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Vec<TermRow>>, Halt> {
        terms(&self.0, STUDY_DURATION, monitor).map(Some)
    }
}

/// A search for one setting, as in `msd tune`.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SearchTask(pub(super) Scene, pub(super) Goal);

impl Task for SearchTask {
    type Found = Tuned;
    const NAME: &'static str = "search";
    const IN_PIECES: bool = false;

    fn advance(
        &mut self,
        _: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Tuned>, Halt> {
        let monitor = &mut Deadline::new(monitor, SEARCHING);
        tune(&self.0, STUDY_DURATION, self.1, monitor).map(Some)
    }
}

/// Trials of the results of a search in the current scene.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RetryTask {
    scene: Scene,
    choices: Vec<Choice>,
    goal: Goal,
}

impl RetryTask {
    /// The study has tried the `present` choice, that of the run. It comes first if it meets the
    /// goal and is about as good as the results.
    pub(super) fn new(scene: Scene, tuned: &Tuned, present: Option<&Trial>) -> Self {
        let Tuned { goal, best, others, .. } = tuned;
        let found = iter::once(best).chain(others).map(|found| &found.trial);
        let mut trials: Vec<&Trial> = found.collect();
        if let Some(present) = present.filter(|trial| goal.is_met_by(trial)) {
            trials.retain(|trial| trial.choice != present.choice);
            let worth = |trial: &Trial| match goal {
                Goal::MaxError(_) => trial.cost,
                Goal::Budget(_) => trial.error(),
            };
            let is_no_better = |trial: &&Trial| worth(present) <= NOISE * worth(trial);
            let place = trials.iter().position(is_no_better).unwrap_or(trials.len());
            trials.insert(place, present);
        }
        let choices = trials.into_iter().map(|trial| trial.choice).collect();
        RetryTask { scene, choices, goal: *goal }
    }
}

impl Task for RetryTask {
    type Found = Elsewhere;
    const NAME: &'static str = "retry";
    const IN_PIECES: bool = false;

    fn advance(
        &mut self,
        _: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Elsewhere>, Halt> {
        let wish = (self.goal, STUDY_DURATION, LASTING);
        let monitor = &mut Deadline::new(monitor, RETRYING);
        retry(&self.scene, &self.choices, wish, monitor).map(Some)
    }
}

/// A trial of a setting in the current scene; finds why it should not be used, in words.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SoundnessTask(pub(super) Scene, pub(super) Choice);

impl Task for SoundnessTask {
    type Found = Option<String>;
    const NAME: &'static str = "soundness";
    const IN_PIECES: bool = false;

    fn advance(
        &mut self,
        _: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Option<String>>, Halt> {
        find_fault(&self.0, self.1, LASTING, monitor).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_scene::Precision;
    use msd_study::errors::Errors;
    use msd_study::tune::Found;

    /// Returns a trial with a number of substeps, a cost, s/s, and an error, metres.
    fn trial(substeps: u32, cost: f64, rms: f64) -> Trial {
        let mut choice = Choice::of(Default::default(), Precision::F32);
        choice.fineness = msd_study::choice::Fineness::Substeps(substeps);
        let errors = Some(Errors { rms, ..Errors::default() });
        Trial { choice, cost, errors, energies: Vec::new(), gained: 0.0, diverged: None }
    }

    fn order(goal: Goal, present: &Trial) -> Vec<u32> {
        let found = |trial| Found { trial, predicted_error: None };
        let tuned = Tuned {
            goal,
            best: found(trial(2, 1.0, 1e-3)),
            others: vec![found(trial(3, 2.0, 1e-4)), found(trial(4, 3.0, 1e-5))],
            met: true,
            uncertainty: 0.0,
            duration: 1.0,
            compared: 1.0,
            horizon: None,
            reference_tolerance: 0.0,
            tried: 3,
            is_cut_short: false,
        };
        let choices = RetryTask::new(Scene::default(), &tuned, Some(present)).choices;
        choices.iter().map(|choice| choice.settings().substeps).collect()
    }

    #[test]
    fn the_present_setting_is_tried_first_where_it_is_about_as_good() {
        let goal = Goal::MaxError(2e-3);
        assert_eq!(order(goal, &trial(7, 1.05, 1e-3)), [7, 2, 3, 4], "noise");
        assert_eq!(order(goal, &trial(7, 1.5, 1e-3)), [2, 7, 3, 4], "dearer than the best");
        assert_eq!(order(goal, &trial(7, 9.0, 1e-3)), [2, 3, 4, 7], "dearer than all");
        assert_eq!(order(goal, &trial(7, 0.1, 3e-3)), [2, 3, 4], "it does not meet the goal");
        assert_eq!(order(goal, &trial(3, 0.9, 1e-4)), [3, 2, 4], "it was found as well");
        let goal = Goal::Budget(4.0);
        assert_eq!(order(goal, &trial(7, 1.0, 1.05e-3)), [7, 2, 3, 4], "as accurate");
    }
}
