//! The explicit methods, as passes over columns between evaluations of the forces.
//!
//! | method | evaluations per substep |
//! |---|---|
//! | explicit Euler | 1 |
//! | symplectic Euler | 1 |
//! | velocity Verlet | 1, and 1 more per step and after a bounce |
//! | RK4 | 4 |

use super::StepContext;
use super::context::{Pass, Scratch, Way};
use crate::columns::threads::for_each_share;
use crate::contact::after_kick::{Drift, Kick};
use crate::contact::{Contacts, Evaluated};
use crate::elements::Force;
use crate::elements::springs::fused::Moving;
use crate::number::{Real, at_level};
use crate::system::{Columns, Model};

/// x' = x + h v, v' = v + h a(x, v).
pub(crate) fn explicit_euler<R: Real>(step: &mut StepContext<'_, R>) {
    let h = step.substep();
    for _ in 0..step.substeps() {
        let (power, level) = (step.set_forces(step.time()), step.level);
        if step.find_rows(h, false) {
            step.add_impulses();
            step.set_means(None);
        }
        for_each_share(step.pass(), |pass| at_level!(level, _simd => drift_kick(pass, h)));
        if step.has_rows() {
            step.end_shells(true);
        }
        step.done.counted += power * h.to_f64();
        step.done.drive(step.scratch.power_of_pins * h.to_f64());
        step.finish(Way::Kicked(1.0), Evaluated::AtStart);
    }
}

#[inline(always)]
fn drift_kick<R: Real>(pass: Pass<'_, R, 0>, h: R) {
    let Pass { positions: x, velocities: v, forces: f, inverse_masses: w, .. } = pass;
    let n = x.len();
    let (v, f, w) = (&mut v[..n], &f[..n], &w[..n]);
    for i in 0..n {
        x[i] += v[i] * h;
        v[i] += f[i] * (w[i] * h);
    }
}

/// v' = v + h a(x, v), x' = x + h v'.
pub(crate) fn symplectic_euler<R: Real>(step: &mut StepContext<'_, R>) {
    let h = step.substep();
    let is_fused = is_fused(step.model);
    for _ in 0..step.substeps() {
        let power = if is_fused { sweep(step, h) } else { evaluate_and_move(step, h) };
        step.finish_substep(power * h.to_f64());
    }
}

/// Whether one sweep does all of a substep but contact: where springs and fields without drag are
/// all that acts before it.
fn is_fused<R: Real>(model: &Model<R>) -> bool {
    let [_, inner @ ..] = model.inner();
    let [_, single @ ..] = model.single();
    let is_bare = inner.iter().chain(&single).chain(&model.other()).all(|kind| kind.count() == 0);
    is_bare && !model.fields.is_damped() && !model.do_bodies_meet() && model.springs.can_move()
}

/// A substep in one sweep, by [`crate::elements::springs::fused`]; returns the power dissipated.
fn sweep<R: Real>(step: &mut StepContext<'_, R>, h: R) -> f64 {
    step.place(step.time());
    let Scratch { forces, work, power_of_pins, .. } = &mut *step.scratch;
    let Columns { positions, velocities } = &mut *step.state;
    let Model { mass_column, inverse_mass_column, fields, springs, .. } = step.model;
    let mut moving = Moving {
        positions,
        velocities,
        forces,
        masses: mass_column,
        inverse_masses: inverse_mass_column,
        fields,
        h,
    };
    work.own_power = 0.0;
    let power = springs.move_particles(step.level, &mut work.springs, &mut moving);
    // Pins have no kick: their velocities are those of the start.
    *power_of_pins = step.model.power_of_pins(forces, velocities);
    power
}

/// The same in passes.
fn evaluate_and_move<R: Real>(step: &mut StepContext<'_, R>, h: R) -> f64 {
    let (power, level) = (step.set_forces(step.time()), step.level);
    if step.find_rows(h, true) {
        kick_meet_drift(step, h);
    } else {
        for_each_share(step.pass(), |pass| at_level!(level, _simd => kick_drift(pass, h)));
    }
    power
}

/// The same, with the contact of shells in between.
fn kick_meet_drift<R: Real>(step: &mut StepContext<'_, R>, h: R) {
    let level = step.level;
    for_each_share(step.pass(), |pass| at_level!(level, _simd => kick(pass, h)));
    step.meet_shells(h);
    for_each_share(step.pass(), |pass| at_level!(level, _simd => drift(pass, h)));
}

#[inline(always)]
fn kick<R: Real>(pass: Pass<'_, R, 0>, h: R) {
    let Pass { velocities: v, forces: f, inverse_masses: w, .. } = pass;
    let n = v.len();
    let (f, w) = (&f[..n], &w[..n]);
    for i in 0..n {
        v[i] += f[i] * (w[i] * h);
    }
}

#[inline(always)]
fn kick_drift<R: Real>(pass: Pass<'_, R, 0>, h: R) {
    let Pass { positions: x, velocities: v, forces: f, inverse_masses: w, .. } = pass;
    let n = x.len();
    let (v, f, w) = (&mut v[..n], &f[..n], &w[..n]);
    for i in 0..n {
        v[i] += f[i] * (w[i] * h);
        x[i] += v[i] * h;
    }
}

/// Work columns of velocity Verlet: the accelerations of the last evaluation and of the one before
/// it, and predicted velocities.
pub(crate) const VERLET_COLUMNS: usize = 3;
const NOW: usize = 0;
const BEFORE: usize = 1;
const PREDICTED: usize = 2;

/// Kick, drift, kick.
///
/// Dampers are evaluated at v + h/2 a_n + h/4 (a_n + a_(n−1)). The mean of two accelerations makes
/// the method second order with dampers too, at one evaluation. It vanishes for a motion that
/// changes sign every substep, so that the stable step is about that of symplectic Euler (see
/// [`crate::stability::Region`]; Groot and Warren, 1997, extrapolate with a_n alone, which costs up
/// to half of the stable step).
///
/// Particles that lie on an obstacle are held after each half kick: see
/// [`crate::contact::after_kick`]. A particle that arrives is inside where its dampers are
/// evaluated. The real share of their power is known at the start of a step, where they are
/// evaluated at the state. In substeps with an arrival that share is booked.
///
/// After a bounce forces are evaluated anew: the springs at the particle were pressed together
/// inside the obstacle.
pub(crate) fn velocity_verlet<R: Real>(step: &mut StepContext<'_, R>) {
    let (h, level) = (step.substep(), step.level);
    let is_damped = step.model.is_damped_at_all();
    let (mut real, mut met) = (1.0, false);
    // Whether particles lie on obstacles, where that is known.
    let mut lie = None;
    for _ in 0..step.substeps() {
        if !step.scratch.warm {
            step.scratch.power = step.set_forces(step.time());
            for_each_share(step.pass(), |pass| at_level!(level, _simd => set_accelerations(pass)));
        }
        let before = step.scratch.power;
        let given_before = step.scratch.power_of_pins;
        let lies = lie.unwrap_or_else(|| step.find(step.time(), Evaluated::AtEnd));
        if step.find_rows(h * R::HALF, true) || lies {
            kick_settle_drift(step, is_damped);
        } else if is_damped {
            let advance = |pass: Pass<'_, R, VERLET_COLUMNS>| {
                at_level!(level, _simd => kick_drift_predict(pass, h));
            };
            for_each_share(step.pass(), advance);
        } else {
            for_each_share(step.pass(), |pass| at_level!(level, _simd => half_kick_drift(pass, h)));
        }
        let power = if is_damped {
            step.set_forces_predicted(PREDICTED)
        } else {
            step.set_forces(step.time() + step.settings.substep())
        };
        step.scratch.power = power;
        step.scratch.columns.swap(NOW, BEFORE);
        for_each_share(step.pass(), |pass| at_level!(level, _simd => half_kick(pass, h)));
        if step.has_rows() {
            step.hold_shells(h * R::HALF);
        }
        lie = Some(step.find(step.end(), Evaluated::AtEnd));
        if lies {
            let kick = half_of(step, step.settings.substep(), false, Drift::Behind);
            let contacts = step.settle(None, NOW, kick);
            // Counted at the first kick.
            step.done.meet(Contacts { count: 0, ..contacts });
        }
        if step.finished == 0 && 0.0 <= before && before < power {
            real = before / power;
        }
        let contacts = step.finish(Way::BetweenKicks, Evaluated::AtEnd);
        step.scratch.warm = !contacts.bounced;
        met = 0 < contacts.count;
        // The next substep begins where this one ends.
        lie = lie.filter(|_| !met);
        let taken = 0.5 * (before + power) * h.to_f64();
        step.done.counted += if met { taken * real } else { taken };
        step.done.drive(0.5 * (given_before + step.scratch.power_of_pins) * h.to_f64());
    }
    // Kept only where the next step would compute the same to the bit.
    let is_alone = step.model.pushes.0.is_empty() && step.model.guides.0.is_empty();
    step.scratch.warm = is_alone && !is_damped && !met;
}

/// One of the two kicks of a substep, so many seconds after its start.
fn half_of<R: Real>(step: &StepContext<'_, R>, after: f64, loses: bool, drift: Drift) -> Kick<R> {
    let substep = step.substep();
    Kick { length: substep * R::HALF, substep, time: step.time() + after, loses, drift }
}

/// The first half kick and the drift where particles lie on obstacles, and the prediction of
/// velocities for dampers.
fn kick_settle_drift<R: Real>(step: &mut StepContext<'_, R>, is_damped: bool) {
    let (h, level) = (step.substep(), step.level);
    let kick = half_of(step, 0.0, true, Drift::Ahead);
    for_each_share(step.pass(), |pass| at_level!(level, _simd => kick_by_half(pass, h)));
    // Before obstacles: a row of its own bears a particle that lies on both.
    if step.has_rows() {
        step.meet_shells(kick.length);
    }
    let contacts = step.settle(None, NOW, kick);
    step.done.meet(contacts);
    if is_damped {
        for_each_share(step.pass(), |pass| at_level!(level, _simd => predict(pass, h)));
        if step.has_rows() {
            step.hold_predicted(PREDICTED);
        }
        step.settle(Some(PREDICTED), NOW, Kick { loses: false, drift: Drift::Absent, ..kick });
    }
    for_each_share(step.pass(), |pass| at_level!(level, _simd => drift(pass, h)));
}

#[inline(always)]
fn set_accelerations<R: Real>(pass: Pass<'_, R, 2>) {
    let Pass { forces: f, inverse_masses: w, work, .. } = pass;
    let [now, before] = work;
    let n = f.len();
    let (now, before, w) = (&mut now[..n], &mut before[..n], &w[..n]);
    for i in 0..n {
        now[i] = f[i] * w[i];
        before[i] = now[i];
    }
}

#[inline(always)]
fn kick_drift_predict<R: Real>(pass: Pass<'_, R, VERLET_COLUMNS>, h: R) {
    let Pass { positions: x, velocities: v, work, .. } = pass;
    let [now, before, predicted] = work;
    let n = x.len();
    let (v, now) = (&mut v[..n], &now[..n]);
    let (before, predicted) = (&before[..n], &mut predicted[..n]);
    let half = h * R::HALF;
    let quarter = half * R::HALF;
    for i in 0..n {
        v[i] += now[i] * half;
        x[i] += v[i] * h;
        predicted[i] = v[i] + (now[i] + before[i]) * quarter;
    }
}

#[inline(always)]
fn kick_by_half<R: Real>(pass: Pass<'_, R, 1>, h: R) {
    let Pass { velocities: v, work, .. } = pass;
    let n = v.len();
    let now = &work[NOW][..n];
    let half = h * R::HALF;
    for i in 0..n {
        v[i] += now[i] * half;
    }
}

#[inline(always)]
fn drift<R: Real>(pass: Pass<'_, R, 0>, h: R) {
    let Pass { positions: x, velocities: v, .. } = pass;
    let n = x.len();
    let v = &v[..n];
    for i in 0..n {
        x[i] += v[i] * h;
    }
}

#[inline(always)]
fn predict<R: Real>(pass: Pass<'_, R, VERLET_COLUMNS>, h: R) {
    let Pass { velocities: v, work, .. } = pass;
    let [now, before, predicted] = work;
    let n = v.len();
    let (v, now) = (&v[..n], &now[..n]);
    let (before, predicted) = (&before[..n], &mut predicted[..n]);
    let quarter = h * R::HALF * R::HALF;
    for i in 0..n {
        predicted[i] = v[i] + (now[i] + before[i]) * quarter;
    }
}

#[inline(always)]
fn half_kick_drift<R: Real>(pass: Pass<'_, R, 1>, h: R) {
    let Pass { positions: x, velocities: v, work, .. } = pass;
    let n = x.len();
    let (v, now) = (&mut v[..n], &work[0][..n]);
    let half = h * R::HALF;
    for i in 0..n {
        v[i] += now[i] * half;
        x[i] += v[i] * h;
    }
}

#[inline(always)]
fn half_kick<R: Real>(pass: Pass<'_, R, 1>, h: R) {
    let Pass { velocities: v, forces: f, inverse_masses: w, work, .. } = pass;
    let n = v.len();
    let (f, w, now) = (&f[..n], &w[..n], &mut work[0][..n]);
    let half = h * R::HALF;
    for i in 0..n {
        now[i] = f[i] * w[i];
        v[i] += now[i] * half;
    }
}

/// Work columns of RK4: positions, for contact too, and velocities at the start of the substep, the
/// weighted sums of their slopes, and the accelerations of a kick.
pub(crate) const RK4_COLUMNS: usize = 5;
const KICKS: usize = 4;

/// The classical method of Runge and Kutta.
///
/// Particles that lie on an obstacle are held in each stage: see [`crate::contact::after_kick`].
pub(crate) fn rk4<R: Real>(step: &mut StepContext<'_, R>) {
    let h = step.substep();
    let (half, two, sixth) = (h * R::HALF, R::ONE + R::ONE, h / R::of(6.0));
    let level = step.level;
    for _ in 0..step.substeps() {
        let (time, length) = (step.time(), step.settings.substep());
        let mut energy = step.set_forces(time);
        let mut given = step.scratch.power_of_pins;
        if step.find_rows(half, false) {
            step.add_impulses();
        }
        let lies = step.find(time, Evaluated::AtEnd);
        for_each_share(step.pass(), start);
        for (weight, reach, at) in [(R::ONE, half, 0.5), (two, half, 0.5), (two, h, 1.0)] {
            for_each_share(
                step.pass(),
                |pass| at_level!(level, _simd => next_stage(pass, weight, reach)),
            );
            if lies {
                settle_stage(step, reach, false);
            }
            let power = step.set_forces(time + at * length);
            if step.has_rows() {
                step.add_impulses();
            }
            let times = if at < 1.0 { 2.0 } else { 1.0 };
            energy += times * power;
            given += times * step.scratch.power_of_pins;
        }
        for_each_share(step.pass(), |pass| at_level!(level, _simd => last_stage(pass, sixth)));
        if lies {
            let contacts = settle_stage(step, h, true);
            step.done.meet(contacts);
        }
        if step.has_rows() {
            for_each_share(step.pass(), |pass| set_means(pass, h));
            step.set_means(Some(KICKS));
            step.end_shells(false);
        }
        step.done.counted += energy * sixth.to_f64();
        step.done.drive(given * sixth.to_f64());
        step.finish(Way::Kept, Evaluated::AtEnd);
    }
}

/// Holds particles on an obstacle at the velocities of a stage, `reach` seconds after the start, or
/// at the last, those of the end.
fn settle_stage<R: Real>(step: &mut StepContext<'_, R>, reach: R, is_last: bool) -> Contacts {
    for_each_share(step.pass(), |pass| set_kicks(pass, reach));
    let time = step.time() + reach.to_f64();
    let kick =
        Kick { length: reach, substep: step.substep(), time, loses: is_last, drift: Drift::Absent };
    step.find(time, Evaluated::AtEnd);
    step.settle(None, KICKS, kick)
}

fn set_kicks<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>, reach: R) {
    let [_, starts, _, _, kicks] = pass.work;
    for (kick, (&v, &start)) in kicks.iter_mut().zip(pass.velocities.iter().zip(&*starts)) {
        *kick = (v - start) / reach;
    }
}

fn set_means<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>, h: R) {
    let [starts, _, _, _, means] = pass.work;
    for (mean, (&x, &start)) in means.iter_mut().zip(pass.positions.iter().zip(&*starts)) {
        *mean = (x - start) / h;
    }
}

fn start<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>) {
    let [x0, v0, sx, sv, _] = pass.work;
    x0.copy_from_slice(pass.positions);
    v0.copy_from_slice(pass.velocities);
    sx.fill(R::ZERO);
    sv.fill(R::ZERO);
}

#[inline(always)]
fn next_stage<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>, weight: R, reach: R) {
    let Pass { positions: x, velocities: v, forces: f, inverse_masses: w, work } = pass;
    let [x0, v0, sx, sv, _] = work;
    let n = x.len();
    let (v, f, w) = (&mut v[..n], &f[..n], &w[..n]);
    let (x0, v0, sx, sv) = (&x0[..n], &v0[..n], &mut sx[..n], &mut sv[..n]);
    for i in 0..n {
        let (velocity, acceleration) = (v[i], f[i] * w[i]);
        sx[i] += velocity * weight;
        sv[i] += acceleration * weight;
        x[i] = x0[i] + velocity * reach;
        v[i] = v0[i] + acceleration * reach;
    }
}

#[inline(always)]
fn last_stage<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>, sixth: R) {
    let Pass { positions: x, velocities: v, forces: f, inverse_masses: w, work } = pass;
    let [x0, v0, sx, sv, _] = work;
    let n = x.len();
    let (v, f, w) = (&mut v[..n], &f[..n], &w[..n]);
    let (x0, v0, sx, sv) = (&x0[..n], &v0[..n], &sx[..n], &sv[..n]);
    for i in 0..n {
        x[i] = x0[i] + (sx[i] + v[i]) * sixth;
        v[i] = v0[i] + (sv[i] + f[i] * w[i]) * sixth;
    }
}
