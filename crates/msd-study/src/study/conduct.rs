//! The conduct of a study to its end.

use crate::behaviour::audit::audit_all;
use crate::behaviour::limits::limits;
use crate::candidates::choice::Choice;
use crate::measure::leave::{Halt, unstopped};
use crate::measure::trial::Trial;
use crate::space::{SpacePlan, balance, halve};
use crate::study::Study;
use crate::study::words::words;
use msd_core::Error;
use msd_scene::{Draft, FileError, Loaded};

pub use crate::study::course::{Course, Plan};
pub(crate) use crate::study::follower::Listener;
pub use crate::study::follower::{Follower, Progress};

/// Studies a scene. `tell` hears how far it is.
///
/// # Errors
/// What the core refuses of the scene.
pub fn study(loaded: &Loaded, plan: Plan, tell: &mut dyn FnMut(Progress)) -> Result<Study, Error> {
    unstopped(|_| study_followed(loaded, plan, &mut Listener(tell))).map(|(study, _)| study)
}

/// Adds the error of space to a study of a scene as a user writes it, and the balance of its
/// errors; takes up to as much time again as the plan gives to trials.
///
/// # Errors
/// A body that has no spacing; what the core refuses of a finer scene.
pub fn add_space(
    study: &mut Study,
    draft: &Draft,
    plan: Plan,
    tell: &mut dyn FnMut(&str),
) -> Result<(), FileError> {
    let Plan { duration, budget, uncertainty, patience, .. } = plan;
    let plan = SpacePlan { duration, budget, uncertainty, patience };
    let found = halve(draft, plan, tell)?;
    tell("balancing space, time and precision");
    let loaded = draft.load(&draft.source()?)?;
    let finer = &found.finer[0].loaded.scene;
    let balance = balance(&loaded, finer, &found.space, &found.reference);
    let refused = |error| FileError::Core { file: draft.name.clone(), source: Box::new(error) };
    study.balance = Some(balance.map_err(refused)?);
    study.space = Some(found.space);
    Ok(())
}

/// The same for one who follows, as long as that one goes on; returns whether it came to its end
/// too. One that did not has what was tried by then, and another study of the scene takes it up.
///
/// # Errors
/// See [`study`]; [`Halt::Stopped`] where the follower ended it before the first trial.
pub fn study_followed(
    loaded: &Loaded,
    plan: Plan,
    follower: &mut dyn Follower,
) -> Result<(Study, bool), Halt> {
    let scene = &loaded.scene;
    let mut course = Course::begin(loaded.clone(), plan, follower)?;
    loop {
        match course.advance(follower) {
            Err(Halt::Stopped) if !course.study.trials.is_empty() => {
                course.study.words = words(&course.study);
                return Ok((course.study, false));
            }
            advanced => {
                if !advanced? {
                    break;
                }
            }
        }
    }
    follower.hear(course.progress("observing the limits".into()));
    let mut limits = limits(scene, loaded.settings.substeps)?;
    limits.retain(|limit| limit.predicted.is_finite());
    course.study.limits = limits;
    follower.hear(course.progress("auditing".into()));
    course.study.audit = audit_all(scene, &representatives(&course.study))?;
    course.study.words = words(&course.study);
    course.forget();
    Ok((course.study, true))
}

/// Of each method the cheapest choice within the wanted error, or else its best.
pub fn representatives(study: &Study) -> Vec<Choice> {
    let best = |integrator| {
        let fine = |trial: &&Trial| trial.is_within(study.wanted);
        let cheapest = study.of(integrator).filter(fine).min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = || {
            let sound_first = |a: &&Trial, b: &&Trial| b.is_sound().cmp(&a.is_sound());
            let by_error = |a: &&Trial, b: &&Trial| a.error().total_cmp(&b.error());
            study.of(integrator).min_by(|a, b| sound_first(a, b).then(by_error(a, b)))
        };
        cheapest.or_else(best).map(|trial| trial.choice)
    };
    msd_core::Integrator::ALL.into_iter().filter_map(best).collect()
}
