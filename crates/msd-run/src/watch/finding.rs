//! Findings: for each kind of them its rule, its words and its advice.

use super::{Overturned, Pierced, Readings};
use crate::automatic::is_most;
use crate::crossings::{WentThrough, body_name};
use crate::quantity::{counted, estimate, quantity, rounded};
use crate::{Runner, on};
use msd_core::methods::Solved;
use msd_core::{Integrator, Settings};
use msd_scene::{Precision, Rounding};
use serde::Serialize;
use std::fmt;

/// Kinds of problems of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Kind {
    /// The substep is longer than the longest that is predicted to be stable, by this factor.
    StabilityLimit {
        /// Whether substeps are automatic, and as many as there may be.
        automatic: bool,
    },
    /// The method has added this energy, joules.
    EnergyAdded,
    /// Springs as stiff as asked would store so much more than the motion gave them, joules.
    TooSoft {
        /// The fewest substeps that resolve the stiffness, if that is known.
        needed: Option<u32>,
    },
    /// The balance of energy is too high by so much, joules.
    EnergyRisen,
    /// So much energy is missing, joules.
    EnergyLost,
    /// The method has damped so much energy by design, joules.
    Damped,
    /// Obstacles left particles no room, whose energy means nothing.
    Squeezed,
    /// A solve of an implicit method left this relative residual.
    PoorSolves {
        /// The part that it may leave.
        tolerance: f64,
    },
    /// A body was seen to go through another one or itself.
    WentThrough(WentThrough),
    /// Bodies may have crossed so many times.
    PossibleCrossings {
        /// Whether substeps are automatic, and were as many as there may be.
        automatic: bool,
    },
    /// So many pairs of triangles crossed at once.
    CrossingTriangles,
    /// A solid went through the surface of a body.
    Pierced(Pierced),
    /// So many corners of the cells of a body are flat or inside out.
    InsideOut(Overturned),
    /// Single precision puts so much energy into the springs, joules.
    LostDigits {
        /// The largest coordinate, metres.
        distance: f64,
        /// The distance of neighbouring numbers there, metres.
        spacing: f64,
        /// That energy as a part of the energy at stake.
        part: f64,
    },
}

/// Something that went wrong in a run. It prints as one line: a sentence, then its advice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Its kind, with its measures.
    #[serde(flatten)]
    pub kind: Kind,
    /// When it was first seen, simulated seconds.
    pub since: f64,
    /// The most of it, in the unit that its kind names; 1 where it names none.
    pub worst: f64,
    /// When that was seen, simulated seconds.
    pub at: f64,
    /// The name of the body that it is about; empty where its kind has no number of one.
    #[serde(skip)]
    body: String,
    /// The settings of the run at that time.
    #[serde(skip)]
    settings: Settings,
    /// Whether it stays once it was seen: else it is known while its rule finds it.
    #[serde(skip)]
    stays: bool,
}

impl Kind {
    /// Returns whether it has happened to the bodies, so that a change of settings keeps it.
    pub(super) fn outlives_changes(&self) -> bool {
        use Kind::{LostDigits, Pierced, PossibleCrossings, Squeezed, WentThrough};
        let is_past = matches!(self, WentThrough(_) | PossibleCrossings { .. } | Pierced(_));
        is_past || matches!(self, Squeezed | LostDigits { .. })
    }

    /// Returns whether another one has the same cause, and differs only in its measures.
    fn is_same(&self, other: &Kind) -> bool {
        match self {
            Kind::WentThrough(_) => self == other,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

impl Finding {
    /// A current finding. One that stays is kept with its worst value so far; any other is known
    /// only while its rule finds it.
    fn now(runner: &Runner, kind: Kind, worst: f64, stays: bool) -> Self {
        let (time, settings) = (runner.time(), runner.settings());
        let body = match kind {
            Kind::Pierced(Pierced { body, .. }) | Kind::InsideOut(Overturned { body, .. }) => {
                on!(runner, simulation => body_name(simulation.model(), body))
            }
            _ => String::new(),
        };
        Finding { kind, since: time, worst, at: time, body, settings, stays }
    }

    /// Returns whether it is of the same kind, and differs only in its measures.
    pub fn is_same(&self, other: &Finding) -> bool {
        self.kind.is_same(&other.kind)
    }

    /// Returns whether another finding explains the energy of this one.
    fn is_explained_by(&self, other: &Finding) -> bool {
        use Kind::{Damped, EnergyAdded, EnergyLost, EnergyRisen, Squeezed, TooSoft};
        match (&self.kind, &other.kind) {
            (EnergyAdded, TooSoft { .. }) | (TooSoft { .. }, EnergyAdded) => {
                // Both are of one gain, which was first less and then more than the energy that the
                // springs store.
                let is_one = matches!(self.kind, EnergyAdded) && self.worst == other.worst;
                self.worst < other.worst || is_one
            }
            (EnergyRisen, EnergyAdded | TooSoft { .. }) => true,
            (kind, Squeezed) => {
                matches!(kind, EnergyAdded | TooSoft { .. } | EnergyRisen | EnergyLost | Damped)
            }
            _ => false,
        }
    }

    /// Returns whether it stays once it was seen.
    pub(super) fn stays(&self) -> bool {
        self.stays || self.kind.outlives_changes()
    }

    /// The problem, in words.
    pub fn sentence(&self) -> String {
        let &Finding { ref kind, ref body, since, worst, settings, .. } = self;
        let Settings { integrator, substeps, .. } = settings;
        let (t, energy) = (quantity(since, "s"), quantity(worst, "J"));
        let first = format!(", first seen at t = {t}");
        let errors = format!("errors of {integrator} or of bounces");
        match kind {
            Kind::StabilityLimit { automatic } => self.over_limit(*automatic) + &first,
            Kind::EnergyAdded => {
                format!("{integrator} is adding energy: {energy} that nothing supplied{first}")
            }
            Kind::TooSoft { .. } => format!(
                "{integrator} holds bodies softer than asked at {substeps} substeps: springs as \
                 stiff as asked would store {energy} more than the motion gave them, since t = {t}"
            ),
            Kind::EnergyRisen => {
                format!("the total energy has risen by {energy}, and nothing supplied it: {errors}")
            }
            Kind::EnergyLost => {
                format!("the total energy has fallen by {energy}, and nothing took it: {errors}")
            }
            Kind::Damped => {
                format!("{integrator} has damped {energy} of energy beside what is dissipated")
            }
            Kind::Squeezed => format!(
                "obstacles leave particles no room between them since t = {t}: the energy of \
                 squeezed particles means nothing"
            ),
            Kind::PoorSolves { tolerance } => format!(
                "the solver of {integrator} stopped at a relative residual of up to {}, not {}",
                rounded(worst, 2),
                rounded(*tolerance, 1)
            ),
            Kind::WentThrough(went) => format!("{went} at t = {t}"),
            Kind::PossibleCrossings { automatic } => {
                let most = if *automatic { ", even at the most automatic substeps" } else { "" };
                format!("bodies may have crossed {}{most}", counted(worst as u64, "time"))
            }
            Kind::CrossingTriangles => {
                format!(
                    "up to {} of surface triangles crossed at once",
                    counted(worst as u64, "pair")
                )
            }
            Kind::Pierced(Pierced { solid, .. }) => {
                format!("solid {solid} went through {body} at t = {t}, between particles")
            }
            Kind::InsideOut(Overturned { of, .. }) => {
                format!("{worst} of the {of} corners of cells in {body} are flat or inside out")
            }
            Kind::LostDigits { distance, spacing, part } => format!(
                "{} from the origin, single precision rounds positions to {}; that alone puts \
                 about {} into the springs, {:.1} % of the energy at stake",
                quantity(*distance, "m"),
                estimate(*spacing, "m"),
                estimate(worst, "J"),
                100.0 * part
            ),
        }
    }

    fn over_limit(&self, automatic: bool) -> String {
        let Settings { integrator, substeps, .. } = self.settings;
        if self.worst.is_infinite() {
            return format!("{integrator} is predicted to be unstable here at any step");
        }
        let step = self.settings.substep();
        let [step, stable] = [step, step / self.worst].map(|time| quantity(time, "s"));
        let most = if automatic {
            format!(", by the most automatic substeps ({substeps}),")
        } else {
            String::new()
        };
        format!(
            "the step of {step}{most} is longer than {stable}, the longest predicted to be stable \
             for {integrator}"
        )
    }

    /// Advice against it.
    pub fn advice(&self) -> String {
        let Settings { integrator, substeps, .. } = self.settings;
        let finer =
            if integrator.is_adaptive() { "take a tighter tolerance" } else { "shorten the step" };
        let text = match &self.kind {
            Kind::StabilityLimit { .. } => "use more substeps or another method",
            Kind::EnergyAdded | Kind::EnergyRisen | Kind::EnergyLost => {
                return format!("{finer} or use another method");
            }
            Kind::TooSoft { needed } => {
                let needed = needed.filter(|&needed| substeps < needed);
                let needed = needed.map(|count| format!(" ({count} resolve its stiffness)"));
                let needed = needed.unwrap_or_default();
                return format!("use more substeps{needed} or an implicit method");
            }
            Kind::Damped => "it does so by design, and less with more substeps",
            Kind::Squeezed => "leave more room, or lift what closes on them",
            Kind::PoorSolves { .. } => {
                "slow motions among stiff ones may be lost: use f64 or more substeps"
            }
            Kind::WentThrough(_) => "shorten the step, or use a larger `touch.thickness`",
            Kind::PossibleCrossings { .. } => {
                "they went through each other, or were too fast for msd to find all contacts: \
                 shorten the step"
            }
            Kind::CrossingTriangles => {
                "use more substeps, a larger `touch.thickness`, or a finer spacing; or move bodies \
                 apart that start in each other"
            }
            Kind::Pierced(_) => {
                "use more substeps, a finer spacing, stiffer springs or less speed, or \
                 `springs = true` of a thin solid"
            }
            Kind::InsideOut(_) => {
                "use a stiffer material, a softer impact or, for a block, `poisson = 0.45`"
            }
            Kind::LostDigits { .. } => "use f64, or move the scene to the origin",
        };
        text.to_owned()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.sentence(), self.advice())
    }
}

/// The rules: the current problems, from readings of a run.
pub(super) fn rules(read: &Readings, runner: &Runner) -> Vec<Finding> {
    let now = |kind, worst, stays| Finding::now(runner, kind, worst, stays);
    let single =
        [limit(read, runner), gained(read, runner), risen(read), lost(read, runner), solved(read)];
    let in_contact =
        [squeezed(runner), passed(read, runner), crossed(read), inside_out(read, runner)];
    let known = single.into_iter().chain(in_contact).chain([lost_digits(read, runner)]).flatten();
    let known = known.map(|(kind, worst, stays)| now(kind, worst, stays));
    let pierced = read.pierced.map(|pierced| (pierced.time, Kind::Pierced(pierced), true));
    let went = runner.went_through().into_iter();
    let went = went.map(|went| (went.time, Kind::WentThrough(went), false));
    let through = pierced.into_iter().chain(went);
    let through = through.map(|(since, kind, stays)| Finding { since, ..now(kind, 1.0, stays) });
    known.chain(through).collect()
}

/// A kind, the most of it, and whether it stays once it was seen.
type Found = Option<(Kind, f64, bool)>;

fn limit(read: &Readings, runner: &Runner) -> Found {
    let [stable, substep] = read.limit?;
    let automatic = runner.is_automatic() && is_most(runner.settings());
    (stable < substep).then_some((Kind::StabilityLimit { automatic }, substep / stable, true))
}

/// XPBD's constraints yield more than springs of their stiffness. Springs as long would store more
/// energy than the motion has given them, which looks like a gain.
fn gained(read: &Readings, runner: &Runner) -> Found {
    let Settings { integrator, step, .. } = runner.settings();
    let (gain, rise) = (read.witness.gain(), read.witness.rise());
    let joules = if 0.0 < gain { gain } else { rise.max(read.witness.surplus()) };
    if integrator == Integrator::Xpbd && 0.0 < joules && joules <= read.most_elastic {
        let needed = read.resolving.map(|longest| (step / longest).ceil());
        let needed = needed.filter(|needed| needed.is_finite()).map(|needed| needed as u32);
        return Some((Kind::TooSoft { needed }, joules, 0.0 < gain.max(rise)));
    }
    (0.0 < gain).then_some((Kind::EnergyAdded, gain, true))
}

fn risen(read: &Readings) -> Found {
    let (rise, surplus) = (read.witness.rise(), read.witness.surplus());
    let risen = rise.max(surplus);
    (0.0 < risen).then_some((Kind::EnergyRisen, risen, 0.0 < rise))
}

/// Energy that nothing took by any account: an error, or the damping that a method has by design.
fn lost(read: &Readings, runner: &Runner) -> Found {
    let loss = read.witness.loss();
    let kind = match runner.integrator() {
        Integrator::BackwardEuler | Integrator::Xpbd => Kind::Damped,
        _ => Kind::EnergyLost,
    };
    (0.0 < loss).then_some((kind, loss, true))
}

fn squeezed(runner: &Runner) -> Found {
    runner.contacts().squeezed.then_some((Kind::Squeezed, 1.0, false))
}

fn solved(read: &Readings) -> Found {
    let Solved { residual, tolerance, .. } = read.solved.filter(Solved::is_poor)?;
    Some((Kind::PoorSolves { tolerance }, residual, true))
}

fn passed(read: &Readings, runner: &Runner) -> Found {
    let passes = runner.passes().saturating_sub(read.passes);
    let automatic = runner.is_automatic();
    (0 < passes).then_some((Kind::PossibleCrossings { automatic }, passes as f64, false))
}

fn crossed(read: &Readings) -> Found {
    let pairs = read.crossings.filter(|&pairs| 0 < pairs)?;
    Some((Kind::CrossingTriangles, pairs as f64, true))
}

/// A hard edge of an impact leaves a few corners inside out in thousands, which changes no shape. A
/// body that a grab pulls out of shape may return to it.
fn inside_out(read: &Readings, runner: &Runner) -> Found {
    if on!(runner, simulation => !simulation.model().grabs().is_empty()) {
        return None;
    }
    let found = read.overturned.filter(|found| found.of <= 100 * found.corners)?;
    Some((Kind::InsideOut(found), found.corners as f64, false))
}

fn lost_digits(read: &Readings, runner: &Runner) -> Found {
    let Rounding { distance, spacing, energy, stake } = read.rounding?;
    let part = energy / stake;
    let kind = Kind::LostDigits { distance, spacing, part };
    (runner.precision() == Precision::F32).then_some((kind, energy, false))
}

/// Adds current findings to those that were found before.
pub(super) fn merge(found: &mut Vec<Finding>, now: Vec<Finding>) {
    found.retain(|old| old.stays || now.iter().any(|new| new.kind.is_same(&old.kind)));
    for new in now {
        let Some(old) = found.iter_mut().find(|old| old.kind.is_same(&new.kind)) else {
            found.push(new);
            continue;
        };
        // Of findings that stay the worst one is kept; any other is replaced by the current one.
        if !old.stays || new.stays && old.worst < new.worst {
            *old = Finding { since: old.since, ..new };
        }
    }
}

/// The findings up to a time of the run, without those that other findings explain.
pub(super) fn known(found: &[Finding], time: f64) -> Vec<Finding> {
    let until = || found.iter().filter(|finding| finding.since <= time);
    let stands = |finding: &&Finding| !until().any(|other| finding.is_explained_by(other));
    until().filter(stands).cloned().collect()
}
