//! The search for a spacing, and for the choice that goes with it.

use crate::candidates::choice::Choice;
use crate::measure::errors::rms_between;
use crate::measure::trial::state;
use crate::monitor::{Halt, Monitor, Progress};
use crate::space::{Space, SpacePlan, Track, Verdict, halve, of_file, picked};
use crate::tune::{Goal, Tuned, tune};
use msd_core::{Error, Scene};
use msd_run::Runner;
use msd_scene::schema::SceneFile;
use msd_scene::{Draft, FileError};

/// The result of tuning spacing, method, fineness and precision together.
#[derive(Clone, Debug, PartialEq)]
pub struct TunedSpacing {
    /// The error asked for, metres.
    pub wanted: f64,
    /// The estimate of the error of space.
    pub space: Space,
    /// Uncertainty of the limit of ever finer spacings, metres: the goal is met where that and a
    /// verified error together are within it. Infinite where the limit is not known over all of the
    /// time.
    pub doubt: f64,
    /// The coarsest spacing that meets the goal, or else the last that was tried. None where the
    /// error of space, with its uncertainty, is too large at all spacings that were run.
    pub found: Option<FoundSpacing>,
}

/// A spacing and a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSpacing {
    /// Parts that the spacing of the scene is cut into.
    pub parts: u32,
    /// Rows of the scene at that spacing; none where it is as it was.
    pub rows: Option<SceneFile>,
    /// Error of space at that spacing, metres.
    pub space_error: f64,
    /// The choice, tuned at that spacing to the error that the error of space leaves.
    pub tuned: Tuned,
    /// Root mean square distance of the particles from the limit of ever finer spacings, in a run
    /// of the choice at that spacing: space, time and precision together, metres.
    pub verified: f64,
}

impl TunedSpacing {
    /// Whether the goal is met.
    pub fn is_met(&self) -> bool {
        self.found.as_ref().is_some_and(|found| found.meets(self.wanted - self.doubt))
    }
}

impl FoundSpacing {
    fn meets(&self, within: f64) -> bool {
        self.tuned.met && self.verified <= within
    }
}

/// Tunes a scene to an error against the limit of ever finer spacings.
///
/// # Errors
/// A body that has no spacing; a scene that the core refuses; the error of [`Monitor::proceed`].
pub fn tune_spacing(
    draft: &Draft,
    plan: SpacePlan,
    wanted: f64,
    monitor: &mut dyn Monitor,
) -> Result<TunedSpacing, Halt<FileError>> {
    let ran = halve(draft, plan, monitor)?;
    let space = ran.space.clone();
    let (doubt, is_bound) = doubt(&space);
    let mut result = TunedSpacing { wanted, space, doubt, found: None };
    let Some((limit, samples)) = ran.right.filter(|_| doubt.is_finite()) else {
        return Ok(result);
    };
    let frames = &ran.reference.frames[..samples];
    let coarse = draft.load(&draft.source()?)?.scene;
    for (row, spacing) in result.space.spacings.clone().into_iter().enumerate() {
        let Some(space_error) = spacing.error else { continue };
        let left = wanted - doubt - if is_bound { 0.0 } else { space_error };
        if left <= 0.0 {
            continue;
        }
        let finer = row.checked_sub(1).map(|row| &ran.finer[row]);
        let scene = finer.map_or(&coarse, |finer| &finer.loaded.scene);
        let common = ran.finer[row.saturating_sub(1)].common.iter();
        let points: Vec<usize> = common.map(|pair| pair[usize::from(finer.is_some())]).collect();
        let goal = Goal::MaxError(left);
        let now = format!("tuning at 1/{} of the spacing", spacing.parts);
        monitor.report(Progress::of(now));
        let tuned = tune(scene, result.space.duration, goal, monitor);
        let tuned = tuned.map_err(|halt| of_file(draft, halt))?;
        let choice = tuned.best.trial.choice;
        let verified = distance((scene, &points), choice, (frames, &limit));
        let verified = verified.map_err(|error| of_file(draft, error))?;
        let rows = finer.map(|finer| finer.rows.clone());
        let parts = spacing.parts;
        let found = FoundSpacing { parts, rows, space_error, tuned, verified };
        let is_met = found.meets(wanted - doubt);
        result.found = Some(found);
        // A coarser one is cheaper by far: half the spacing takes several times as long.
        if is_met {
            break;
        }
    }
    Ok(result)
}

/// The uncertainty of the limit of ever finer spacings, metres, infinite where the limit is not
/// known over all of the time; and whether it is only a bound of the errors of spacings.
fn doubt(space: &Space) -> (f64, bool) {
    match space.verdict {
        Verdict::Known { band, until, .. } if space.duration <= until + 1e-9 => (band, false),
        Verdict::Below { error } => (error, true),
        Verdict::Known { .. } | Verdict::Lost { .. } | Verdict::Untold => (f64::INFINITY, true),
    }
}

/// The largest root mean square distance of points from a course, in a run of a choice, metres;
/// infinite for a run that leaves the world.
fn distance(
    (scene, points): (&Scene, &[usize]),
    choice: Choice,
    (frames, right): (&[u64], &Track),
) -> Result<f64, Error> {
    let mut runner = Runner::new(scene, choice.settings(), choice.precision)?;
    let mut largest = 0.0f64;
    for (&frame, right) in frames.iter().zip(&right.samples) {
        while runner.steps() < frame {
            if runner.step().is_err() {
                return Ok(f64::INFINITY);
            }
        }
        let here: Vec<_> = picked(&state(&runner).positions, points).collect();
        largest = largest.max(rms_between(&here, right));
    }
    Ok(largest)
}
