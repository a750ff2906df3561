//! The explicit methods, as passes over columns between evaluations of the forces.
//!
//! | method | evaluations per substep |
//! |---|---|
//! | explicit Euler | 1 |
//! | symplectic Euler | 1 |
//! | velocity Verlet | 1, and 1 more per step and after a bounce |
//! | RK4 | 4 |

use super::StepContext;
use super::context::{Pass, Way};
use crate::columns::threads::for_each_share;
use crate::number::{Real, at_level};
use crate::obstacles::Evaluated;

/// x' = x + h v, v' = v + h a(x, v).
pub(crate) fn explicit_euler<R: Real>(step: &mut StepContext<'_, R>) {
    let h = step.substep();
    for _ in 0..step.substeps() {
        let (power, level) = (step.set_forces(step.time()), step.level);
        for_each_share(step.pass(), |pass| at_level!(level, _simd => drift_kick(pass, h)));
        step.done.counted += power * h.to_f64();
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
    for _ in 0..step.substeps() {
        let (power, level) = (step.set_forces(step.time()), step.level);
        for_each_share(step.pass(), |pass| at_level!(level, _simd => kick_drift(pass, h)));
        step.finish_substep(power * h.to_f64());
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
const PREDICTED: usize = 2;

/// Kick, drift, kick.
///
/// Dampers are evaluated at v + h/2 a_n + h/4 (a_n + a_(n−1)). The mean of two accelerations makes
/// the method second order with dampers too, at one evaluation, and vanishes for a motion that
/// changes sign every substep, so that the stable step is about that of symplectic Euler (see
/// [`crate::stability::Region`]; Groot and Warren, 1997, extrapolate with a_n alone, which costs up
/// to half of the stable step).
///
/// A particle on an obstacle falls a little before it is held, and dampers are evaluated at that
/// motion. The real share of their power is known at the start of a step, where they are evaluated
/// at the state: in substeps with contact that share is booked.
///
/// After a bounce forces are evaluated anew: the springs at the particle were pressed together
/// inside the obstacle.
pub(crate) fn velocity_verlet<R: Real>(step: &mut StepContext<'_, R>) {
    let (h, level) = (step.substep(), step.level);
    let is_damped = step.model.is_damped_at_all();
    let (mut real, mut met) = (1.0, false);
    for _ in 0..step.substeps() {
        if !step.scratch.warm {
            step.scratch.power = step.set_forces(step.time());
            for_each_share(step.pass(), |pass| at_level!(level, _simd => set_accelerations(pass)));
        }
        let before = step.scratch.power;
        let power = if is_damped {
            let advance = |pass: Pass<'_, R, VERLET_COLUMNS>| {
                at_level!(level, _simd => kick_drift_predict(pass, h));
            };
            for_each_share(step.pass(), advance);
            step.set_forces_predicted(PREDICTED)
        } else {
            for_each_share(step.pass(), |pass| at_level!(level, _simd => half_kick_drift(pass, h)));
            step.set_forces(step.time() + step.settings.substep())
        };
        step.scratch.power = power;
        for_each_share(step.pass(), |pass| at_level!(level, _simd => half_kick(pass, h)));
        if step.finished == 0 && 0.0 <= before && before < power {
            real = before / power;
        }
        let contacts = step.finish(Way::Kicked(0.5), Evaluated::AtEnd);
        step.scratch.warm = !contacts.bounced;
        met = 0 < contacts.count;
        let taken = 0.5 * (before + power) * h.to_f64();
        step.done.counted += if met { taken * real } else { taken };
    }
    // Kept only where the next step would compute the same to the bit.
    step.scratch.warm = step.model.pushes.0.is_empty() && !is_damped && !met;
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
    let (before, predicted) = (&mut before[..n], &mut predicted[..n]);
    let half = h * R::HALF;
    let quarter = half * R::HALF;
    for i in 0..n {
        v[i] += now[i] * half;
        x[i] += v[i] * h;
        predicted[i] = v[i] + (now[i] + before[i]) * quarter;
        before[i] = now[i];
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

/// Work columns of RK4: positions, for contact too, and velocities at the start of the substep, and
/// the weighted sums of their slopes.
pub(crate) const RK4_COLUMNS: usize = 4;

/// The classical method of Runge and Kutta.
pub(crate) fn rk4<R: Real>(step: &mut StepContext<'_, R>) {
    let h = step.substep();
    let (half, two, sixth) = (h * R::HALF, R::ONE + R::ONE, h / R::of(6.0));
    let level = step.level;
    for _ in 0..step.substeps() {
        let (time, length) = (step.time(), step.settings.substep());
        let (mut energy, mut first) = (0.0, 0.0);
        let stages = [(R::ONE, half, 0.0), (two, half, 0.5), (two, h, 0.5)];
        for (stage, (weight, reach, at)) in stages.into_iter().enumerate() {
            let power = step.set_forces(time + at * length);
            energy += weight.to_f64() * power;
            if stage == 0 {
                first = power;
                for_each_share(step.pass(), start);
            }
            for_each_share(
                step.pass(),
                |pass| at_level!(level, _simd => next_stage(pass, weight, reach)),
            );
        }
        energy += step.set_forces(time + length);
        for_each_share(step.pass(), |pass| at_level!(level, _simd => last_stage(pass, sixth)));
        // A particle on an obstacle falls a little in all stages but the first.
        let met = 0 < step.finish(Way::Kept, Evaluated::AtEnd).count;
        step.done.counted += if met { first * h.to_f64() } else { energy * sixth.to_f64() };
    }
}

fn start<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>) {
    let [x0, v0, sx, sv] = pass.work;
    x0.copy_from_slice(pass.positions);
    v0.copy_from_slice(pass.velocities);
    sx.fill(R::ZERO);
    sv.fill(R::ZERO);
}

#[inline(always)]
fn next_stage<R: Real>(pass: Pass<'_, R, RK4_COLUMNS>, weight: R, reach: R) {
    let Pass { positions: x, velocities: v, forces: f, inverse_masses: w, work } = pass;
    let [x0, v0, sx, sv] = work;
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
    let [x0, v0, sx, sv] = work;
    let n = x.len();
    let (v, f, w) = (&mut v[..n], &f[..n], &w[..n]);
    let (x0, v0, sx, sv) = (&x0[..n], &v0[..n], &sx[..n], &sv[..n]);
    for i in 0..n {
        x[i] = x0[i] + (sx[i] + v[i]) * sixth;
        v[i] = v0[i] + (sv[i] + f[i] * w[i]) * sixth;
    }
}
