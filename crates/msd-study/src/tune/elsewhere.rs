//! Trials of found choices at another state of the scene: that of a run to step by them.

use super::{Goal, UNLUCKY, hurried};
use crate::candidates::choice::{Choice, FRAME};
use crate::measure::reference::{Reference, reference, size_of};
use crate::measure::trial::{Trial, adds, find_fault, try_choice};
use crate::monitor::{Halt, Monitor, Progress};
use crate::quantity::estimate;
use msd_core::Scene;
use serde::{Deserialize, Serialize};

/// Result of the trials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elsewhere {
    /// The trial of the first choice that serves the goal there too; none where none does.
    pub held: Option<Trial>,
    /// The choices before it, and why they do not, in words.
    pub refused: Vec<(Choice, String)>,
}

/// Tries choices that were found, the best first, in a `scene` that is at another state.
///
/// A choice must stay in the world there and add no energy for the `lasting` seconds. Its error
/// against a reference counts for the `duration`, seconds. A deadline ends the trial, and the rest
/// are not tried.
///
/// # Errors
/// A scene that the core refuses; [`Halt::Cancelled`].
pub fn retry(
    scene: &Scene,
    choices: &[Choice],
    (goal, duration, lasting): (Goal, f64, f64),
    monitor: &mut dyn Monitor,
) -> Result<Elsewhere, Halt> {
    let (mut right, mut refused) = (None, Vec::new());
    for choice in choices {
        let (now, done) = (format!("trying {choice} from the state of now"), refused.len());
        monitor.report(Progress { done, ..Progress::of(now) });
        let wish = (goal, duration, lasting);
        match try_here((scene, &mut right), *choice, wish, monitor) {
            Ok(Ok(trial)) => return Ok(Elsewhere { held: Some(trial), refused }),
            Ok(Err(why)) => refused.push((*choice, why)),
            Err(Halt::Deadline) => {
                refused.push((*choice, "the time was over before it could be told".into()));
                break;
            }
            Err(halt) => return Err(halt),
        }
    }
    Ok(Elsewhere { held: None, refused })
}

/// The trial of a choice, or why it does not serve the goal, in words. The reference is made once,
/// for the first choice that lasts.
fn try_here(
    (scene, right): (&Scene, &mut Option<Reference>),
    choice: Choice,
    (goal, duration, lasting): (Goal, f64, f64),
    monitor: &mut dyn Monitor,
) -> Result<Result<Trial, String>, Halt> {
    match find_fault(scene, choice, lasting, monitor) {
        Err(Halt::Refused(error)) => return Ok(Err(error.to_string())),
        Err(halt) => return Err(halt),
        Ok(Some(why)) => return Ok(Err(why)),
        Ok(None) => {}
    }
    let size = size_of(scene)?;
    let wanted = match goal {
        Goal::MaxError(error) => error,
        Goal::Budget(_) => 1e-6 * size,
    };
    let right = match right {
        Some(right) => right,
        None => {
            let uncertainty = (0.02 * wanted / size).clamp(1e-11, 1e-4);
            let wish = hurried(duration, uncertainty, monitor);
            right.insert(reference(scene, wish, monitor)?)
        }
    };
    let is_certain = matches!(goal, Goal::Budget(_)) || 0 < right.reliable(0.25 * wanted);
    let reliable = right.comparable(0.25 * wanted);
    let trial = try_choice(scene, choice, (right, reliable), monitor)?;
    Ok(match objection(goal, &trial, is_certain) {
        Some(why) => Err(why),
        None => Ok(trial),
    })
}

/// Why a trial does not serve a goal.
fn objection(goal: Goal, trial: &Trial, is_certain: bool) -> Option<String> {
    if let Some(why) = &trial.diverged {
        return Some(why.clone());
    }
    if 0.0 < trial.gained {
        return Some(adds(trial.gained));
    }
    match goal {
        Goal::MaxError(_) if !is_certain => Some("no reference is certain enough".into()),
        Goal::MaxError(error) if error < trial.error() => {
            Some(format!("is {} off", estimate(trial.error(), "m")))
        }
        Goal::Budget(budget) if UNLUCKY * budget < trial.cost * FRAME => {
            Some(format!("takes {} per frame", estimate(trial.cost * FRAME, "s")))
        }
        _ => None,
    }
}
