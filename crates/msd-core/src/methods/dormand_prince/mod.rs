//! The adaptive reference method, of Dormand and Prince: steps whose error is controlled.
//!
//! The pair of orders 5 and 4 of Dormand and Prince (1980), with substeps of its own choice and
//! with contact as located events. Its numbers are in [`tableau`], a substep is in [`stages`], its
//! length is chosen in [`pace`], and obstacles act in [`holds`], [`meeting`], [`support`] and
//! [`events`]. Sources are named there.

mod tableau;
mod stages;
mod pace;
mod support;
mod holds;
mod meeting;
mod events;

use super::{Failure, StepContext, context};
use crate::columns::LANES;
use crate::columns::slots::Slots;
use crate::contact::Contacts;
use crate::contact::ending::Substep;
use crate::number::{Real, at_level};
use crate::stability::{Mode, Region};
use crate::system::Columns;
use alloc::boxed::Box;
use core::ops::AddAssign;
use holds::{Holds, Met};
use pace::{Pace, fifth_root};
use stages::{Allowance, ROUNDINGS, Stages};
use tableau::STAGES;

/// Scratch of a step, and the work of all steps.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// Power dissipated at the last evaluation, watts.
    power: f64,
    /// The last substep.
    stages: Stages<R>,
    holds: Holds<R>,
    /// Events that a step may still cut a substep at.
    events_left: u32,
    work: Work,
}

/// The work of one step or of many.
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

/// Advances the state by one step with contact, at a local error of at most the tolerance times the
/// size of the model per substep.
///
/// The error of a substep is the root mean square over particles of √(|δx|² + h² |δv|²), δ being
/// the difference between the results of order 5, which is kept, and 4. With obstacles h is
/// replaced by the time in which the motion changes, where that is longer: a substep cut short
/// would allow any error in v. Per particle the tolerance is at least 64 times the rounding
/// of a coordinate as large as the size of the model or as its distance from the origin. Below that
/// rounding looks like error, and the step would stall.
///
/// Where the tolerance cannot be reached, the state is left somewhere within the step, and the
/// particle with the largest error is named.
pub(crate) fn advance<R: Real>(step: &mut StepContext<'_, R>) {
    let kept = step.scratch.dormand_prince.take();
    let mut scratch = kept.unwrap_or_else(|| Box::new(Scratch::new(&step.model.slots)));
    step.done.failure = scratch.run(step).err();
    step.scratch.dormand_prince = Some(scratch);
}

/// The local error per particle that a tolerance allows, metres.
fn allowed_error<R: Real>(size: f64, tolerance: f64) -> f64 {
    Real::max(tolerance, ROUNDINGS * R::EPSILON.to_f64()) * size
}

/// Products that find the fastest motion of bodies at rest, to a few parts in a hundred, and the
/// part of its largest stable substep in which it dies out.
const CALM_PRODUCTS: usize = 5;
const CALM: f64 = 0.8;

/// Events in one step; the substeps after them are not cut: a particle inside an obstacle at their
/// end is put on it and bounces there. Only a scene that hardly advances between its events has
/// more.
const MOST_EVENTS: u32 = 20_000;

impl<R: Real> Scratch<R> {
    fn new(slots: &Slots) -> Self {
        Scratch {
            power: 0.0,
            stages: Stages::new(slots),
            holds: Holds::new(slots),
            events_left: 0,
            work: Work::default(),
        }
    }

    /// The work of all steps.
    pub(crate) fn work(&self) -> Work {
        self.work
    }

    /// Runs a step.
    fn run(&mut self, step: &mut StepContext<'_, R>) -> Result<(), Failure> {
        let taken = self.work.evaluations;
        let (slots, level, whole) = (&step.model.slots, step.level, step.settings.step);
        let allowed = allowed_error::<R>(step.model.size, step.settings.tolerance);
        self.start(step, allowed);
        let (first, horizon) = self.first_length(step, allowed);
        let allowance = Allowance { error: allowed, horizon };
        let calm = self.calm_length(step);
        let mut pace = Pace::new(first, whole);
        let (mut left, mut time) = (whole, step.start);
        loop {
            if step.most_evaluations <= self.work.evaluations - taken {
                return Err(Failure::Evaluations(1.0 - left / whole));
            }
            let most = Real::min(self.holds.longest(), calm);
            let length = pace.attempt_within(left, most);
            self.stages.start(step.state, time, length);
            self.run_stages(step);
            let error = self.stages.error(level, slots, allowance);
            let accepted = error <= 1.0;
            if accepted {
                pace.accept(length, error);
            } else {
                self.work.rejected += 1;
                pace.reject(length, error);
            }
            if pace.is_hopeless() {
                return Err(Failure::Tolerance(self.stages.worst(slots, allowance)));
            }
            if !accepted {
                continue;
            }
            self.work.substeps += 1;
            let part = self.accept(step);
            left = match part {
                None if length == left => 0.0,
                _ => left - self.stages.length * part.unwrap_or(1.0),
            };
            time = step.start + (whole - left);
            if part.is_some() {
                self.evaluate(step, time);
            }
            let met = self.meet(step, time);
            if left <= 0.0 {
                return Ok(());
            }
            if met.changed {
                self.evaluate(step, time);
            }
            self.go_on(step, time);
        }
    }

    /// Evaluates the slopes at the start of a step, once everything has met the obstacles it is at.
    fn start(&mut self, step: &mut StepContext<'_, R>, allowed: f64) {
        let size = step.model.size;
        self.events_left = MOST_EVENTS;
        self.holds.reset(allowed / size, size);
        self.evaluate(step, step.start);
        if self.meet(step, step.start).changed {
            self.evaluate(step, step.start);
        }
        self.set_slopes(step, 0, step.start);
    }

    /// The length of the first substep of a step, seconds, at most the step; and the time in which
    /// the motion changes, seconds, 0 without obstacles.
    ///
    /// One more evaluation, at the positions moved along the accelerations, x + τ² a, gives the
    /// fourth derivative of the motion: s = (a(x + τ² a, v) − a) / τ². With w² = |s| / |a| the
    /// fifth is about w |s|, and the error of a substep about h⁵ w |s| / 4000, set equal to the
    /// tolerance. Unlike the rule of Hairer, Nørsett and Wanner (1993), section II.4, it does not
    /// change with the units.
    fn first_length(&mut self, step: &mut StepContext<'_, R>, allowed: f64) -> (f64, f64) {
        let (level, whole) = (step.level, step.settings.step);
        let pulled = root_mean_square(step, &self.stages.slopes[0]);
        if !(0.0 < pulled && pulled.is_finite()) {
            return (whole, 0.0);
        }
        let moved = Real::sqrt(R::EPSILON.to_f64()) * step.model.size;
        let reach = R::of(moved / pulled);
        let Stages { here, slopes, .. } = &mut self.stages;
        here.copy_from(step.state);
        at_level!(level, _simd => add_product(&slopes[0], reach, &mut here.positions));
        self.evaluate_stage(step, 1, step.start);
        let [before, after, ..] = &mut self.stages.slopes;
        at_level!(level, _simd => add_product(before, -R::ONE, after));
        let bent = root_mean_square(step, after) * pulled / moved;
        let rate = Real::sqrt(bent / pulled);
        let error = bent * rate * whole * whole * whole * whole * whole / 4000.0;
        let is_free = step.model.obstacles.is_empty();
        let horizon = if is_free { 0.0 } else { Real::min(1.0 / rate, whole) };
        (whole / Real::max(fifth_root(error / allowed), 1.0), horizon)
    }

    /// The longest substep in which vibrations of bodies that obstacles hold die out, seconds;
    /// infinite where none is held.
    ///
    /// Error control takes the substep to the limit of stability, where it keeps a vibration of the
    /// size of the tolerance going. In a stiff body that is enough to lift it off and to let it
    /// slide. The fastest motion is found by products with the stiffness, as differences of
    /// accelerations (power iteration), and its damping by one more.
    fn calm_length(&mut self, step: &mut StepContext<'_, R>) -> f64 {
        if self.holds.rows().is_empty() {
            return f64::INFINITY;
        }
        let level = step.level;
        let moved = Real::sqrt(R::EPSILON.to_f64()) * step.model.size;
        let mut mode = Mode::default();
        let [now, way, ..] = &mut self.stages.slopes;
        way.copy_from_slice(now);
        for product in 0..=CALM_PRODUCTS {
            let Stages { here, slopes: [_, way, ..], .. } = &mut self.stages;
            let length = root_mean_square(step, way);
            if !(0.0 < length && length.is_finite()) {
                return f64::INFINITY;
            }
            let is_last = product == CALM_PRODUCTS;
            here.copy_from(step.state);
            let (column, reach) = if is_last {
                (&mut here.velocities, moved * Real::sqrt(mode.stiffness))
            } else {
                (&mut here.positions, moved)
            };
            at_level!(level, _simd => add_product(way, R::of(reach / length), column));
            self.evaluate_stage(step, 1, step.start);
            let [now, way, ..] = &mut self.stages.slopes;
            at_level!(level, _simd => add_product(now, -R::ONE, way));
            let resisted = if is_last { &mut mode.damping } else { &mut mode.stiffness };
            *resisted = root_mean_square(step, way) / reach;
        }
        let calm = CALM * mode.largest_substep(Region::DORMAND_PRINCE, 1);
        // A NaN does not limit the substep.
        if 0.0 < calm { calm } else { f64::INFINITY }
    }

    /// Lets every particle meet the obstacles it is at.
    fn meet(&mut self, step: &mut StepContext<'_, R>, time: f64) -> Met {
        if step.model.obstacles.is_empty() {
            return Met::default();
        }
        let system = (step.level, step.model);
        let mut met = self.holds.meet(system, &step.scratch.forces, time, step.state);
        // Points on springs are met at once wherever a substep ends: their impacts are not events.
        let substep = Substep::instant(time);
        met.add(step.model.meet_springs(step.state, &step.scratch.forces, substep));
        step.done.meet(met.contacts);
        step.done.touched |= met.touched;
        met
    }

    /// Moves to the end of the last substep or to the first event in it, and returns the fraction
    /// of the substep if it was cut.
    fn accept(&mut self, step: &mut StepContext<'_, R>) -> Option<f64> {
        let looks = !step.model.obstacles.is_empty() && 0 < self.events_left;
        let part = if looks { self.first_event(step) } else { None };
        match part {
            Some(part) => {
                self.stages.interpolate(step.level, part, step.state);
                self.work.events += 1;
                self.events_left -= 1;
            }
            None => step.state.copy_from(&self.stages.here),
        }
        let fraction = part.unwrap_or(1.0);
        let [elements, friction, driven, pins] = self.stages.energies(fraction);
        step.done.counted += elements;
        step.done.drive(pins);
        step.done.meet(Contacts { count: 0, driven, ..Contacts::one(friction) });
        let driven = -step.scratch.work.own_power.min(0.0);
        step.done.given += driven * fraction * self.stages.length;
        part
    }

    /// The first event in the last substep, as a fraction of it.
    fn first_event(&mut self, step: &StepContext<'_, R>) -> Option<f64> {
        let (stages, slots) = (&self.stages, &step.model.slots);
        let end = stages.here.motion(slots, stages.time_at(1.0));
        let start = stages.start.motion(slots, stages.time);
        let motions = [(end, R::ZERO), (start, R::of(stages.length))];
        self.holds.set_gaps(step.level, step.model, &motions);
        events::first_event(step.model, &self.holds, stages)
    }

    /// Makes the slopes at the end of a substep those at the start of the next.
    fn go_on(&mut self, step: &StepContext<'_, R>, time: f64) {
        if step.model.obstacles.is_empty() {
            self.stages.shift();
        } else {
            // Forces may be those of another state, and other particles held.
            self.set_slopes(step, 0, time);
        }
    }

    /// Evaluates the forces at the state.
    fn evaluate(&mut self, step: &mut StepContext<'_, R>, time: f64) {
        self.power = step.set_forces(time);
        self.work.evaluations += 1;
    }

    /// Evaluates the stages after the first; the last is at the end of the substep.
    fn run_stages(&mut self, step: &mut StepContext<'_, R>) {
        for stage in 1..STAGES {
            self.stages.go_to(step.level, stage);
            self.evaluate_stage(step, stage, self.stages.time_of(stage));
        }
    }

    /// Evaluates the slopes of a stage after the first where it is.
    fn evaluate_stage(&mut self, step: &mut StepContext<'_, R>, stage: usize, time: f64) {
        let (model, level) = (step.model, step.level);
        let context::Scratch { forces, work, .. } = &mut *step.scratch;
        let Columns { positions, velocities } = &mut self.stages.here;
        model.place(time, [positions, velocities]);
        let motion = self.stages.here.motion(&model.slots, time);
        self.power = model.set_forces(level, &motion, work, forces);
        self.work.evaluations += 1;
        self.set_slopes(step, stage, time);
    }

    /// Turns the forces of the last evaluation into the slopes of a stage: of the first at the
    /// state, of another where that stage is.
    fn set_slopes(&mut self, step: &StepContext<'_, R>, stage: usize, time: f64) {
        let (model, forces) = (step.model, &*step.scratch.forces);
        let Stages { here, slopes, powers, .. } = &mut self.stages;
        let columns = if stage == 0 { &*step.state } else { here };
        let (motion, slopes) = (columns.motion(&model.slots, time), &mut *slopes[stage]);
        let inverse_masses = &*model.inverse_mass_column;
        at_level!(step.level, _simd => set_products(forces, inverse_masses, slopes));
        powers.elements[stage] = self.power;
        powers.pins[stage] = model.power_of_pins(forces, motion.velocities);
        [powers.friction[stage], powers.driven[stage]] =
            self.holds.act(model, stage, &motion, slopes);
    }
}

/// Over the particles, of a column of vectors.
fn root_mean_square<R: Real>(step: &StepContext<'_, R>, column: &[R]) -> f64 {
    let sum = at_level!(step.level, _simd => sum_of_squares(column));
    Real::sqrt(sum / step.model.particle_count() as f64)
}

/// c = a b.
#[inline(always)]
fn set_products<R: Real>(a: &[R], b: &[R], c: &mut [R]) {
    let n = c.len();
    let (a, b) = (&a[..n], &b[..n]);
    for i in 0..n {
        c[i] = a[i] * b[i];
    }
}

/// b' = b + s a.
#[inline(always)]
fn add_product<R: Real>(a: &[R], s: R, b: &mut [R]) {
    let n = b.len();
    let a = &a[..n];
    for i in 0..n {
        b[i] += a[i] * s;
    }
}

#[inline(always)]
fn sum_of_squares<R: Real>(column: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    for row in column.as_chunks::<LANES>().0 {
        for lane in 0..LANES {
            sums[lane] += (row[lane] * row[lane]).to_f64();
        }
    }
    sums.iter().sum()
}
