//! The errors of space, time and precision of a scene side by side, with their prices.

use crate::candidates::choice::{Choice, Fineness};
use crate::candidates::ladder::ladders;
use crate::measure::clock::CpuClock;
use crate::measure::errors::rms_between;
use crate::measure::reference::Reference;
use crate::measure::trial::{state, time_choice};
use crate::quantity::{estimate, rounded};
use crate::space::{Space, Verdict};
use msd_core::glam::DVec3;
use msd_core::{Error, Scene};
use msd_run::Runner;
use msd_scene::{Loaded, Precision};
use serde::{Deserialize, Serialize};

/// The error of a scene at its own settings, by its sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorBalance {
    /// The choice by which the scene is stepped.
    pub choice: Choice,
    /// Time of the processor per simulated second, seconds.
    pub cost: f64,
    /// The error of the spacing; none where that is not known.
    pub space: Option<Share>,
    /// The error of the step; none for a run that diverged.
    pub time: Option<Share>,
    /// The error of the precision; none for a run that diverged.
    pub precision: Option<Share>,
    /// Advice, in words.
    pub advice: String,
}

/// An error, and the price of having less of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// The error, root mean square, metres.
    pub error: f64,
    /// Whether the error is less than that, and no more is known.
    #[serde(default)]
    pub is_bound: bool,
    /// The remedy that makes it less, in words; empty where nothing does.
    pub remedy: String,
    /// The error with that, metres.
    pub left: f64,
    /// Time of the processor per simulated second with that, seconds; infinite where it diverges.
    pub cost: f64,
}

/// An error that is so many times as large as another rules.
const RULES: f64 = 2.0;
/// A step may be made so long that the error of time is at most this part of that of space.
const LONGEST: f64 = 0.2;
/// Frames of a finer scene that are run to know its price.
const PRICED: u64 = 6;
/// Rounding of f64 relative to that of f32: 2⁻⁵² to 2⁻²³.
const FINER: f64 = 1.0 / (1u64 << 29) as f64;

/// A run that was followed.
struct Stepped {
    cost: f64,
    positions: Vec<Vec<DVec3>>,
}

/// Measures the errors of time and precision of a scene at its own settings, beside that of
/// `space`; `finer` is the scene at half its spacing.
///
/// # Errors
/// A scene that the core refuses.
pub fn balance(
    loaded: &Loaded,
    finer: &Scene,
    space: &Space,
    reference: &Reference,
) -> Result<ErrorBalance, Error> {
    let Loaded { scene, precision, .. } = loaded;
    let choice = Choice::of(Runner::open(loaded)?.settings(), *precision);
    let samples = reference.comparable(1e-4 * reference.size);
    let frames = &reference.frames[..samples];
    let follow = |choice: Choice| follow(scene, choice, frames);
    let right = |run: &Stepped| {
        let rows = run.positions.iter().zip(&reference.states);
        rows.map(|(here, right)| rms_between(here, &right.positions)).fold(0.0, f64::max)
    };
    let single = follow(Choice { precision: Precision::F32, ..choice })?;
    let double = follow(Choice { precision: Precision::F64, ..choice })?;
    let closer = closer(choice);
    let less = follow(Choice { precision: Precision::F64, ..closer })?;
    let is_single = *precision == Precision::F32;
    let own = if is_single { &single } else { &double };
    let cost = own.as_ref().map_or(f64::INFINITY, |run| run.cost);
    let time = double.as_ref().zip(own.as_ref()).map(|(double, own)| Share {
        error: right(double),
        is_bound: false,
        remedy: closer.fineness(),
        left: less.as_ref().map_or(f64::INFINITY, right),
        cost: less.as_ref().map_or(f64::INFINITY, |less| own.cost * less.cost / double.cost),
    });
    let precision = single.as_ref().zip(double.as_ref()).map(|(single, double)| {
        let rows = single.positions.iter().zip(&double.positions);
        let apart = rows.map(|(single, double)| rms_between(single, double)).fold(0.0, f64::max);
        let remedy = if is_single { "f64".into() } else { String::new() };
        let error = if is_single { apart } else { FINER * apart };
        Share { error, is_bound: false, remedy, left: FINER * apart, cost: double.cost }
    });
    let space = space.error().map(|error| Share {
        error,
        is_bound: matches!(space.verdict, Verdict::Below { .. }),
        remedy: "half the spacing".into(),
        left: space.spacings.get(1).and_then(|finer| finer.error).unwrap_or(error),
        cost: price(finer, choice),
    });
    let mut balance = ErrorBalance { choice, cost, space, time, precision, advice: String::new() };
    let mut longer = None;
    if let Some(most) = balance.room()
        && let Some(longest) = longest(scene, choice)?
    {
        let run = follow(Choice { precision: Precision::F64, ..longest })?;
        let off = run.as_ref().map(right).filter(|off| *off <= most);
        longer = off.map(|off| (longest, off));
    }
    balance.advice = balance.words(longer);
    Ok(balance)
}

impl Share {
    /// The error in words: a length, or below one.
    pub fn size(&self) -> String {
        let below = if self.is_bound { "below " } else { "" };
        format!("{below}{}", estimate(self.error, "m"))
    }
}

impl ErrorBalance {
    /// The error of time that would be small beside that of space, metres; none where time costs
    /// as much already, or space is not known.
    fn room(&self) -> Option<f64> {
        let (space, time) = (self.space.as_ref()?, self.time.as_ref()?);
        if space.is_bound {
            return None;
        }
        let room = LONGEST * space.error;
        (time.error < 0.5 * room).then_some(room)
    }

    /// Returns the advice; `longer` is the longest step that would do, with its error.
    fn words(&self, longer: Option<(Choice, f64)>) -> String {
        let Some(time) = &self.time else {
            return format!("shorten the step: with {} the run leaves the world", self.choice);
        };
        let shown = |error: f64| estimate(error, "m");
        let in_time = shown(time.error);
        let precision = self.precision.as_ref().filter(|precision| !precision.remedy.is_empty());
        let Some(space) = &self.space else {
            let precision = precision.map(|precision| shown(precision.error));
            let precision = precision.map_or(String::new(), |error| format!(", precision {error}"));
            return format!("time costs you {in_time}{precision}; what space costs is not known");
        };
        let in_space = space.size();
        let rules = |a: &Share, b: &Share| RULES * b.error <= a.error;
        if let Some(precision) = precision
            && rules(precision, space)
            && rules(precision, time)
        {
            let (error, others) =
                (shown(precision.error), format!("space {in_space}, time {in_time}"));
            return format!("take f64: precision costs you {error}, {others}");
        }
        if rules(time, space) {
            return format!(
                "shorten the step: time costs you {in_time}, space {in_space}; {} leave {}",
                time.remedy,
                shown(time.left)
            );
        }
        if space.is_bound {
            return format!("space costs you {in_space}, time {in_time}");
        }
        if rules(space, time) {
            let costs = format!("space costs you {in_space}, time {in_time}");
            return match longer {
                Some((longer, off)) => format!(
                    "refine the mesh, or lengthen the step: {costs}, and {} would cost {}",
                    longer.fineness(),
                    shown(off)
                ),
                None => format!("refine the mesh: {costs}"),
            };
        }
        format!("space and time are in balance: {in_space} and {in_time}")
    }

    /// The source of each error, and the error; none where that is not known.
    pub fn shares(&self) -> [(&'static str, Option<&Share>); 3] {
        let ErrorBalance { space, time, precision, .. } = self;
        [("space", space.as_ref()), ("time", time.as_ref()), ("precision", precision.as_ref())]
    }

    /// The errors in rows: the source, the error in metres, of a size, and the price of less.
    pub fn rows(&self, size: f64) -> Vec<[String; 5]> {
        let row = |(name, share): (&str, Option<&Share>)| match share {
            Some(share) => {
                let is_better = !share.remedy.is_empty();
                let better = |text: String| if is_better { text } else { String::new() };
                [
                    name.into(),
                    share.size(),
                    format!("{} %", rounded(100.0 * share.error / size, 2)),
                    better(format!("{}: {}", share.remedy, estimate(share.left, "m"))),
                    better(format!(
                        "{} ({} times)",
                        estimate(share.cost, "s"),
                        rounded(share.cost / self.cost, 2)
                    )),
                ]
            }
            None => [name.into(), "not known".into(), String::new(), String::new(), String::new()],
        };
        self.shares().into_iter().map(row).collect()
    }
}

/// Runs a choice and follows all particles; `None` where it diverges or is refused.
fn follow(scene: &Scene, choice: Choice, frames: &[u64]) -> Result<Option<Stepped>, Error> {
    // A precision that cannot hold the scene is none to compare with.
    let Ok(mut runner) = Runner::new(scene, choice.settings(), choice.precision) else {
        return Ok(None);
    };
    let (mut seconds, mut positions) = (0.0, Vec::with_capacity(frames.len()));
    for &frame in frames {
        let clock = CpuClock::start();
        while runner.steps() < frame {
            if runner.step().is_err() {
                return Ok(None);
            }
        }
        seconds += clock.seconds();
        positions.push(state(&runner).positions);
    }
    Ok(Some(Stepped { cost: seconds / runner.time(), positions }))
}

/// The same method, its step halved or its tolerance ten times as tight.
fn closer(choice: Choice) -> Choice {
    let fineness = match choice.fineness {
        Fineness::Substeps(substeps) => Fineness::Substeps(substeps.saturating_mul(2)),
        Fineness::Tolerance(tolerance) => Fineness::Tolerance((0.1 * tolerance).max(1e-13)),
    };
    Choice { fineness, ..choice }
}

/// The fewest substeps of the same method that are predicted stable, where those are fewer.
fn longest(scene: &Scene, choice: Choice) -> Result<Option<Choice>, Error> {
    let Fineness::Substeps(substeps) = choice.fineness else { return Ok(None) };
    let is_own = |ladder: &&crate::candidates::ladder::Ladder| {
        ladder.integrator == choice.integrator && ladder.precision == choice.precision
    };
    let fewest = ladders(scene)?.iter().find(is_own).and_then(|ladder| ladder.fewest);
    let fewest = fewest.filter(|&fewest| fewest < substeps);
    Ok(fewest.map(|fewest| Choice { fineness: Fineness::Substeps(fewest), ..choice }))
}

/// Time of the processor per simulated second of a finer scene, seconds: its steps are as much
/// shorter, or, where bending asks for that, with the square of the spacing.
fn price(finer: &Scene, choice: Choice) -> f64 {
    // A precision that cannot hold the finer scene has no price.
    let of = |choice| time_choice(finer, choice, PRICED, &mut ()).unwrap_or(f64::INFINITY);
    match choice.fineness {
        Fineness::Substeps(_) => {
            let price = of(closer(choice));
            if price.is_finite() { price } else { of(closer(closer(choice))) }
        }
        Fineness::Tolerance(_) => of(choice),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Integrator;

    fn share(error: f64) -> Option<Share> {
        Some(Share { error, is_bound: false, remedy: "more".into(), left: 0.25 * error, cost: 2.0 })
    }

    fn advice([space, time, precision]: [Option<Share>; 3]) -> String {
        let fineness = Fineness::Substeps(8);
        let (integrator, precision_name) = (Integrator::VelocityVerlet, Precision::F32);
        let choice = Choice { integrator, fineness, precision: precision_name };
        let advice = String::new();
        ErrorBalance { choice, cost: 1.0, space, time, precision, advice }.words(None)
    }

    #[test]
    fn the_advice_is_about_the_largest_error() {
        let words = advice([share(12e-3), share(3e-6), share(1e-6)]);
        assert_eq!(words, "refine the mesh: space costs you 12 mm, time 3 µm");
        let words = advice([share(3e-6), share(12e-3), share(1e-6)]);
        assert!(words.starts_with("shorten the step: time costs you 12 mm, space 3 µm"), "{words}");
        let words = advice([share(3e-6), share(3e-6), share(1e-3)]);
        assert!(words.starts_with("take f64: precision costs you 1 mm"), "{words}");
        // An error of which only a bound is known is not a reason to refine anything.
        let below = Share { is_bound: true, ..share(12e-3).unwrap() };
        let words = advice([Some(below), share(3e-6), share(1e-6)]);
        assert_eq!(words, "space costs you below 12 mm, time 3 µm");
        let words = advice([share(3e-3), share(2e-3), share(1e-6)]);
        assert!(words.contains("in balance"), "{words}");
        assert!(advice([None, share(1e-3), share(1e-6)]).contains("is not known"));
        assert!(advice([share(1e-3), None, None]).contains("leaves the world"));
    }
}
