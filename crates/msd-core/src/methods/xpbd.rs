//! XPBD: springs, bends and volumes as compliant constraints, projected one by one.

use super::StepContext;
use super::context::Way;
use crate::columns::{Aligned, LANES};
use crate::contact::Evaluated;
use crate::elements::springs::project::Batches;
use crate::elements::{Projection, column};
use crate::number::{Real, at_level};
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Scratch of a substep.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// The displacements as projected so far, metres: as differences of positions they would lose
    /// the digits that velocities need.
    ways: Aligned<R>,
    batches: Batches<R>,
    /// Multipliers that rows have applied in a substep, N s².
    multipliers: Vec<R>,
    /// The pull of springs, newtons, of which only the power of the dampers is wanted.
    pulls: Aligned<R>,
}

impl<R: Real> Scratch<R> {
    fn new(model: &Model<R>) -> Self {
        let batches = Batches::new(&model.springs, &model.slots);
        let [pulls, ways] = [21, 22].map(|place| column(&model.slots, place));
        Scratch { ways, batches, multipliers: Vec::new(), pulls }
    }
}

/// Advances by a step.
///
/// Particles first move by the outside forces alone to p = x + d, d = h (v + h w f). Then each
/// spring, in order, moves its ends along its direction u by −w Δλ and w Δλ, with C = |p_b − p_a| −
/// rest and the sum λ of its previous Δλ in the substep:
///
/// Δλ = −(λ + k h² C + b h u·(d_b − d_a)) / (1 + (k h² + b h) (w_a + w_b))
///
/// Bends follow, likewise, along the direction of their sum, and volumes along their gradient; then
/// volumes, bends and springs once more, backwards. Then v' = d / h, and where shells meet their
/// rows correct v' and with it d. It is the paper's step with compliance 1/k and damping b,
/// multiplied by k h², so that k = 0 leaves a damper: alone, a spring does the step of backward
/// Euler.
///
/// **It is stable at every h where no shells meet**: to and fro, the sweeps of Gauss and Seidel
/// are a symmetric P with 0 < P <= A⁻¹, A = J W Jᵀ + 1/(k h²). With S = √W Jᵀ P J √W the step is
/// x' = (1 − S) (2 x − x₋), and 0 <= s < 1 for its eigenvalues s: |z|² = 1 − s or less of both
/// roots of z² − 2 (1 − s) z + (1 − s). One sweep alone is not symmetric: a hub of sixteen spokes
/// that rests gains energy by it.
///
/// The error is of first order in h, and has two parts: backward Euler's, and that of so few
/// sweeps. The second makes a body too soft by an amount that grows with k h² / m and with the
/// number of springs in a row. It keeps linear momentum, since each spring moves its ends by
/// opposite impulses.
///
/// Source: Macklin, Müller and Chentanez, 2016, equations 18 and 26, with one iteration per substep
/// as in Macklin et al., 2019; here it is a symmetric one.
pub(crate) fn advance<R: Real>(step: &mut StepContext<'_, R>) {
    let scratch = step.scratch.xpbd.take();
    let mut scratch = scratch.unwrap_or_else(|| Box::new(Scratch::new(step.model)));
    if !step.scratch.warm {
        let (model, batches) = (step.model, &mut scratch.batches);
        batches.renew(&model.springs, model.inverse_masses(), step.substep());
        let counts = model.inner().map(|kind| kind.multiplier_count(batches));
        scratch.multipliers.resize(counts.into_iter().sum(), R::ZERO);
        step.scratch.warm = true;
    }
    for _ in 0..step.substeps() {
        let power = advance_substep(step, &mut scratch);
        step.done.counted += power * step.settings.substep();
        step.finish(Way::Kicked(0.0), Evaluated::Nowhere);
        // Measured once particles on obstacles are at rest again.
        let pulled = power_of_springs(step, &mut scratch.pulls);
        step.done.counted += pulled * step.settings.substep();
        if step.model.do_pins_move(&step.state.velocities) {
            step.set_forces(step.time());
            step.done.drive(step.scratch.power_of_pins * step.settings.substep());
        }
    }
    step.scratch.xpbd = Some(scratch);
}

/// The power that springs, bends and volumes dissipate at the state, watts.
fn power_of_springs<R: Real>(step: &mut StepContext<'_, R>, pulls: &mut Aligned<R>) -> f64 {
    let model = step.model;
    if !model.is_damped() {
        return 0.0;
    }
    pulls.fill(R::ZERO);
    let moment = model.moment(step.level, step.state.motion(&model.slots, step.time()));
    let work = &mut step.scratch.work;
    model.inner().iter().map(|kind| kind.add_forces(&moment, work, pulls)).sum()
}

/// Advances by one substep and returns the power dissipated by other elements, watts.
fn advance_substep<R: Real>(step: &mut StepContext<'_, R>, scratch: &mut Scratch<R>) -> f64 {
    let (model, level, h) = (step.model, step.level, step.substep());
    let time = step.time();
    step.lead();
    let motion = step.state.motion(&model.slots, time);
    let (work, forces) = (&mut step.scratch.work, &mut step.scratch.forces);
    let power = model.set_outer_forces(level, &motion, work, forces);
    let (forces, velocities) = (&mut step.scratch.forces, &mut step.state.velocities);
    let masses = [&*model.mass_column, &*model.inverse_mass_column];
    at_level!(level, _simd => kick(&mut scratch.ways, velocities, forces, masses[1], h));
    sweep(step, scratch);
    let (forces, velocities) = (&mut step.scratch.forces, &mut step.state.velocities);
    at_level!(level, _simd => end_kick(&scratch.ways, [velocities, forces], masses, R::ONE / h));
    // Velocities have had their kick.
    let meets = step.find_rows(R::ZERO, false);
    if meets {
        step.meet_shells(h);
    }
    let Columns { positions, velocities } = &mut *step.state;
    let (ways, per) = if meets { (velocities, h) } else { (&mut scratch.ways, R::ONE) };
    at_level!(level, _simd => drift(positions, ways, per));
    power
}

/// Sets the ways that outside forces alone would make.
#[inline(always)]
fn kick<R: Real>(ways: &mut [R], v: &[R], f: &[R], w: &[R], h: R) {
    let n = ways.len();
    let (v, f, w) = (&v[..n], &f[..n], &w[..n]);
    for i in 0..n {
        ways[i] = (v[i] + f[i] * (h * w[i])) * h;
    }
}

/// Sets velocities, and forces by their change, which contact needs. A pin keeps its velocity to
/// the bit.
#[inline(always)]
fn end_kick<R: Real>(
    ways: &[R],
    [velocities, forces]: [&mut [R]; 2],
    [masses, inverse_masses]: [&[R]; 2],
    per_h: R,
) {
    let masses = masses.as_chunks::<LANES>().0.iter().flat_map(|masses| [masses; 3]);
    let columns = ways.as_chunks::<LANES>().0.iter().zip(inverse_masses.as_chunks::<LANES>().0);
    let outputs = velocities.as_chunks_mut::<LANES>().0.iter_mut();
    let outputs = outputs.zip(forces.as_chunks_mut::<LANES>().0);
    for ((m, (ways, w)), (v, f)) in masses.zip(columns).zip(outputs) {
        for lane in 0..LANES {
            let velocity = ways[lane] * per_h;
            let force = (velocity - v[lane]) * (per_h * m[lane]);
            let is_free = w[lane] != R::ZERO;
            f[lane] = if is_free { force } else { f[lane] };
            v[lane] = if is_free { velocity } else { v[lane] };
        }
    }
}

#[inline(always)]
fn drift<R: Real>(x: &mut [R], ways: &[R], per: R) {
    for (x, &way) in x.iter_mut().zip(ways) {
        *x += way * per;
    }
}

/// Projects all rows to and fro.
fn sweep<R: Real>(step: &mut StepContext<'_, R>, scratch: &mut Scratch<R>) {
    let kinds = step.model.inner();
    let mut projection = Projection {
        level: step.level,
        h: step.substep(),
        batches: &mut scratch.batches,
        inverse_masses: &step.model.inverse_mass_column,
        positions: &step.state.positions,
        ways: &mut scratch.ways,
        multipliers: &mut scratch.multipliers,
        first: 0,
        is_back: false,
        has_springs_alone: kinds[1..].iter().all(|kind| kind.count() == 0),
    };
    for kind in kinds {
        kind.project(&mut projection);
        projection.first += kind.multiplier_count(projection.batches);
    }
    projection.is_back = true;
    for kind in kinds.into_iter().rev() {
        projection.first -= kind.multiplier_count(projection.batches);
        kind.project(&mut projection);
    }
}
