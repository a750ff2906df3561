//! How does a system advance by a step whose error is controlled?
//!
//! The reference method: the pair of orders 5 and 4 of Dormand and Prince (1980), with its own
//! substeps and with contact as located events. Its numbers are in `tableau.rs`, its substeps are
//! chosen in `pace.rs`, and planes act in `holds.rs` and `events.rs`; sources are named there.

use crate::events;
use crate::holds::{Holds, Met};
use crate::pace::{Pace, fifth_root};
use crate::real::{Real, Vector};
use crate::stages::{ROUNDINGS, Stages, copy};
use crate::system::{Model, Motion, State};
use crate::tableau::STAGES;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::AddAssign;

/// What a step forgets.
#[derive(Clone, Debug, Default)]
pub struct Scratch<R: Real> {
    forces: Vec<R::Vec3>,
    /// Power taken away at the last evaluation, watts.
    power: f64,
    /// The last substep.
    stages: Stages<R>,
    holds: Holds<R>,
    /// What the step has come to so far.
    done: Advance,
    /// What all steps took.
    work: Work,
}

impl<R: Real> Scratch<R> {
    /// Makes the work columns for `count` particles.
    pub fn new(count: usize) -> Self {
        Scratch {
            forces: vec![R::Vec3::ZERO; count],
            stages: Stages::new(count),
            ..Scratch::default()
        }
    }

    /// The forces of the last evaluation, newtons.
    pub fn forces(&self) -> &[R::Vec3] {
        &self.forces
    }

    /// What all steps took.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Overwrites `state` with the one at a fraction, 0 to 1, of the last accepted substep, as it
    /// was before it was cut.
    ///
    /// Fourth order in the length of the substep. Source: Shampine (1986).
    pub fn interpolate(&self, fraction: f64, state: &mut State<R>) {
        self.stages.interpolate(fraction, state);
    }

    /// Length of the last accepted substep, seconds.
    pub fn substep(&self) -> f64 {
        self.stages.length
    }
}

/// What a step came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advance {
    /// Energy taken away by dampers, drag and contact, joules.
    pub counted: f64,
    /// Whether anything touched a plane.
    pub touched: bool,
    /// What it took.
    pub work: Work,
    /// The particle with the largest error, where the tolerance could not be reached; the state is
    /// then somewhere within the step.
    pub stuck: Option<usize>,
}

/// What a step or many took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Substeps accepted.
    pub substeps: u64,
    /// Substeps rejected for their error.
    pub rejected: u64,
    /// Evaluations of all forces.
    pub evaluations: u64,
    /// Substeps cut short at an impact or at the end of a slide.
    pub events: u64,
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.substeps += other.substeps;
        self.rejected += other.rejected;
        self.evaluations += other.evaluations;
        self.events += other.events;
    }
}

/// Advances `state` by `step` seconds with contact, at a local error of at most `tolerance` times
/// the size of the model per substep.
///
/// The error of a substep is the root mean square over particles of √(|δx|² + h² |δv|²), δ being
/// the difference between the results of order 5, which is kept, and 4. With planes h is replaced
/// by the time in which the motion changes, where that is longer: a substep cut short would allow
/// any error in v. Per particle the tolerance is at least 64 times the rounding of a coordinate as
/// large as the size of the model or as its distance from the origin. Below that rounding looks
/// like error, and the step would stall.
///
/// `force` overwrites its last argument with all forces at a motion, newtons, and returns the power
/// taken away, watts.
pub fn advance<R: Real>(
    model: &Model<R>,
    (step, tolerance): (f64, f64),
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> Advance {
    scratch.done = Advance::default();
    scratch.done.stuck = run(model, (step, tolerance), state, scratch, force).err();
    scratch.work += scratch.done.work;
    scratch.done
}

/// Runs a step; the error is the particle for which it is given up.
fn run<R: Real>(
    model: &Model<R>,
    (step, tolerance): (f64, f64),
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> Result<(), usize> {
    let allowed = allowed_error(model, tolerance);
    scratch.start(model, allowed, state, force);
    let (first, horizon) = scratch.first_length(model, (step, allowed), state, force);
    let mut pace = Pace::new(first, step);
    let mut left = step;
    loop {
        let length = pace.attempt(left);
        scratch.stages.start(state, length);
        scratch.run_stages(model, force);
        let error = scratch.stages.error(allowed, horizon);
        let accepted = error <= 1.0;
        if accepted {
            pace.accept(length, error);
        } else {
            scratch.done.work.rejected += 1;
            pace.reject(length, error);
        }
        if pace.is_hopeless() {
            return Err(scratch.stages.worst(allowed, horizon));
        }
        if !accepted {
            continue;
        }
        scratch.done.work.substeps += 1;
        let part = scratch.accept(model, state);
        left = match part {
            None if length == left => 0.0,
            _ => left - scratch.stages.length * part.unwrap_or(1.0),
        };
        if part.is_some() {
            scratch.evaluate(state, force);
        }
        let met = scratch.meet(model, state);
        if left <= 0.0 {
            return Ok(());
        }
        if met.changed {
            scratch.evaluate(state, force);
        }
        scratch.go_on(model, state);
    }
}

/// The local error per particle that a tolerance allows, metres.
fn allowed_error<R: Real>(model: &Model<R>, tolerance: f64) -> f64 {
    Real::max(tolerance, ROUNDINGS * R::EPSILON.to_f64()) * model.size
}

/// Events in one step; the substeps after them are not cut: what is inside a plane at their end is
/// put on it and bounces there. Only a scene that hardly moves on between its events has more.
const MOST_EVENTS: u64 = 20_000;

fn root_mean_square<R: Real>(column: &[R::Vec3]) -> f64 {
    let sum: f64 = column.iter().map(|value| value.dot(*value).to_f64()).sum();
    Real::sqrt(sum / column.len() as f64)
}

impl<R: Real> Scratch<R> {
    /// Evaluates the slopes at the start of a step, once everything has met the planes it is at.
    fn start(
        &mut self,
        model: &Model<R>,
        allowed: f64,
        state: &mut State<R>,
        force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
    ) {
        self.holds.reset(allowed / model.size, model.size);
        self.evaluate(state, force);
        if self.meet(model, state).changed {
            self.evaluate(state, force);
        }
        self.set_slopes(model, 0, &state.velocities);
    }

    /// The length of the first substep of a step, seconds: at most the step.
    ///
    /// One more evaluation, at the positions moved along the accelerations, x + τ² a, gives the
    /// fourth derivative of the motion: s = (a(x + τ² a, v) − a) / τ². With w² = |s| / |a| the
    /// fifth is about w |s|, and the error of a substep about h⁵ w |s| / 4000, set equal to what
    /// is allowed. Unlike the rule of Hairer, Nørsett and Wanner (1993), section II.4, it does not
    /// change with the units.
    fn first_length(
        &mut self,
        model: &Model<R>,
        (step, allowed): (f64, f64),
        state: &State<R>,
        force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
    ) -> (f64, f64) {
        let pulled = root_mean_square::<R>(&self.stages.slopes[0]);
        if !(0.0 < pulled && pulled.is_finite()) {
            return (step, 0.0);
        }
        let moved = Real::sqrt(R::EPSILON.to_f64()) * model.size;
        let reach = R::of(moved / pulled);
        let Stages { here, slopes: [slope, ..], .. } = &mut self.stages;
        for (row, &slope) in slope.iter().enumerate() {
            here.positions[row] = state.positions[row] + slope * reach;
        }
        here.velocities.copy_from_slice(&state.velocities);
        self.evaluate_stage(model, 1, force);
        let [before, after, ..] = &mut self.stages.slopes;
        for (after, &before) in after.iter_mut().zip(before.iter()) {
            *after -= before;
        }
        let bent = root_mean_square::<R>(&self.stages.slopes[1]) * pulled / moved;
        let rate = Real::sqrt(bent / pulled);
        let error = bent * rate * step * step * step * step * step / 4000.0;
        let horizon = if model.planes.is_empty() { 0.0 } else { Real::min(1.0 / rate, step) };
        (step / Real::max(fifth_root(error / allowed), 1.0), horizon)
    }

    /// Lets every particle meet the planes it is at.
    fn meet(&mut self, model: &Model<R>, state: &mut State<R>) -> Met {
        if model.planes.is_empty() {
            return Met::default();
        }
        let met = self.holds.meet(model, &self.forces, state);
        self.done.counted += met.energy;
        self.done.touched |= met.touched;
        met
    }

    /// Moves to the end of the last substep or to the first event in it, and returns the fraction
    /// of the substep if it was cut.
    fn accept(&mut self, model: &Model<R>, state: &mut State<R>) -> Option<f64> {
        let looks = !model.planes.is_empty() && self.done.work.events < MOST_EVENTS;
        let part = if looks { events::first_event(model, &self.holds, &self.stages) } else { None };
        match part {
            Some(part) => {
                self.interpolate(part, state);
                self.done.work.events += 1;
            }
            None => copy(&self.stages.here, state),
        }
        self.done.counted += self.stages.taken(part.unwrap_or(1.0));
        part
    }

    /// Makes the slopes at the end of a substep those at the start of the next.
    fn go_on(&mut self, model: &Model<R>, state: &State<R>) {
        if model.planes.is_empty() {
            self.stages.shift();
        } else {
            // Forces may be those of another state, and other particles held.
            self.set_slopes(model, 0, &state.velocities);
        }
    }

    /// Evaluates the forces at `state`.
    fn evaluate(
        &mut self,
        state: &State<R>,
        force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
    ) {
        self.power = force(state.motion(), &mut self.forces);
        self.done.work.evaluations += 1;
    }

    /// Turns the forces of the last evaluation into the slopes of a stage.
    fn set_slopes(&mut self, model: &Model<R>, stage: usize, velocities: &[R::Vec3]) {
        let slopes = &mut self.stages.slopes[stage];
        let rows = slopes.iter_mut().zip(&self.forces).zip(&model.inverse_masses);
        for ((slope, &force), &inverse_mass) in rows {
            *slope = force * inverse_mass;
        }
        self.stages.powers[stage] = self.power + self.holds.act(model, stage, velocities, slopes);
    }

    /// Evaluates the stages after the first; the last is at the end of the substep.
    fn run_stages(
        &mut self,
        model: &Model<R>,
        force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
    ) {
        for stage in 1..STAGES {
            self.stages.go_to(stage);
            self.evaluate_stage(model, stage, force);
        }
    }

    /// Evaluates the slopes of a stage where it is.
    fn evaluate_stage(
        &mut self,
        model: &Model<R>,
        stage: usize,
        force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
    ) {
        // Taken out and put back, so that it can be read while the slopes are written.
        let here = core::mem::take(&mut self.stages.here);
        self.power = force(here.motion(), &mut self.forces);
        self.done.work.evaluations += 1;
        self.set_slopes(model, stage, &here.velocities);
        self.stages.here = here;
    }
}
