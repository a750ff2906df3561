//! The conduct of a study to its end.

use crate::behaviour::audit::audit_all;
use crate::behaviour::limits::limits;
use crate::candidates::choice::Choice;
use crate::measure::device::Device;
use crate::measure::reference::frames_of;
use crate::measure::trial::{DeviceTime, Trial, time_on};
use crate::monitor::{Halt, Monitor, Progress};
use crate::space::{SpacePlan, balance, halve, of_file};
use crate::study::words::words;
use crate::study::{OnDevice, Study};
use msd_core::Scene;
use msd_scene::{Draft, FileError, Loaded};

pub use crate::study::course::{Course, Plan};

/// Adds the error of space, and the balance of errors, to a study of a scene as a user writes it.
/// It takes up to as much time again as the plan gives to trials.
///
/// # Errors
/// A body that has no spacing; a finer scene that the core refuses; the error of
/// [`Monitor::proceed`].
pub fn add_space(
    study: &mut Study,
    draft: &Draft,
    plan: Plan,
    monitor: &mut dyn Monitor,
) -> Result<(), Halt<FileError>> {
    let Plan { duration, budget, uncertainty, patience, .. } = plan;
    let plan = SpacePlan { duration, budget, uncertainty, patience };
    let found = halve(draft, plan, monitor)?;
    monitor.report(Progress::of("balancing space, time and precision"));
    let loaded = draft.load(&draft.source()?)?;
    let finer = &found.finer[0].loaded.scene;
    let balance = balance(&loaded, finer, &found.space, &found.reference);
    study.balance = Some(balance.map_err(|error| of_file(draft, error))?);
    study.space = Some(found.space);
    Ok(())
}

/// The fault of a timing on a device that a monitor has ended.
pub const INTERRUPTED: &str = "interrupted";

/// Adds the cost on a device of those trials of a study that it steps and that did not diverge, and
/// a sentence on it. A cancelled measurement keeps the costs that are known.
///
/// # Errors
/// A scene that the core refuses.
pub fn add_device(
    study: &mut Study,
    scene: &Scene,
    device: &mut dyn Device,
    monitor: &mut dyn Monitor,
) -> Result<(), Halt> {
    let mut on_device = OnDevice { name: device.name(), costs: Vec::new(), fault: None };
    let frames = frames_of(study.duration);
    for trial in study.trials.iter().filter(|trial| trial.errors.is_some()) {
        let choice = trial.choice;
        monitor.report(Progress::of(format!("timing {choice} on {}", on_device.name)));
        match time_on(device, (scene, choice), frames, monitor) {
            Ok(DeviceTime::Cost(cost)) => on_device.costs.push((choice, cost)),
            Ok(DeviceTime::Untaken) => {}
            Ok(DeviceTime::Failed(why)) => {
                on_device.fault = Some(why);
                break;
            }
            Err(Halt::Cancelled | Halt::Deadline) => {
                on_device.fault = Some(INTERRUPTED.to_owned());
                break;
            }
            Err(halt) => return Err(halt),
        }
    }
    study.on_device = Some(on_device);
    study.words = words(study);
    Ok(())
}

/// Studies a scene; returns whether the study is complete, too. A cancelled study has the trials
/// made by then, and another study of the scene resumes it.
///
/// # Errors
/// A scene that the core refuses; [`Halt::Cancelled`] before the first trial.
pub fn study(
    loaded: &Loaded,
    plan: Plan,
    monitor: &mut dyn Monitor,
) -> Result<(Study, bool), Halt> {
    let scene = &loaded.scene;
    let mut course = Course::begin(loaded.clone(), plan, monitor)?;
    loop {
        match course.advance(monitor) {
            Err(Halt::Cancelled) if !course.study.trials.is_empty() => {
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
    monitor.report(course.progress("observing the limits".into()));
    let mut limits = limits(scene, loaded.settings.substeps)?;
    limits.retain(|limit| limit.predicted.is_finite());
    course.study.limits = limits;
    monitor.report(course.progress("auditing".into()));
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
