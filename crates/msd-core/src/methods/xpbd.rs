//! XPBD: springs, bends and volumes as compliant constraints, projected one by one.

use super::StepContext;
use super::context::Way;
use crate::columns::{Aligned, add_vector, set_vector, vector};
use crate::contact::Evaluated;
use crate::elements::{Projection, column};
use crate::number::{Real, Vector};
use crate::system::{Columns, Model};
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// Scratch of a substep. Positions in the order of the scene, in which springs name their ends.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// Positions at the start, metres.
    starts: Vec<R::Vec3>,
    /// The displacements as projected so far, metres: as differences of positions they would lose
    /// the digits that velocities need.
    ways: Vec<R::Vec3>,
    /// Multipliers that rows have applied in a substep, N s².
    multipliers: Vec<R>,
    /// The pull of springs, newtons, of which only the power of the dampers is wanted.
    pulls: Aligned<R>,
}

impl<R: Real> Scratch<R> {
    fn new(model: &Model<R>) -> Self {
        let vectors = || vec![R::Vec3::ZERO; model.particle_count()];
        let counts = model.inner().map(|kind| kind.multiplier_count());
        let multipliers = vec![R::ZERO; counts.into_iter().sum()];
        Scratch { starts: vectors(), ways: vectors(), multipliers, pulls: column(&model.slots, 21) }
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
    let Scratch { starts, ways, multipliers, .. } = scratch;
    let inverse_masses = model.inverse_masses();
    for (particle, at) in model.slots.places().enumerate() {
        let position = vector::<R>(&step.state.positions, at);
        let velocity = vector::<R>(&step.state.velocities, at);
        let force = vector::<R>(&step.scratch.forces, at);
        let velocity = velocity + force * (h * inverse_masses[particle]);
        starts[particle] = position;
        ways[particle] = velocity * h;
    }
    let mut projection =
        Projection { h, inverse_masses, starts, ways, multipliers, first: 0, is_back: false };
    sweep(model, &mut projection);
    let per_h = R::ONE / h;
    for (particle, at) in model.slots.places().enumerate() {
        // A pin keeps its velocity to the bit.
        if inverse_masses[particle] != R::ZERO {
            let before = vector::<R>(&step.state.velocities, at);
            let velocity = ways[particle] * per_h;
            set_vector(&mut step.state.velocities, at, velocity);
            // The pull of the springs follows from the change of velocity; contact needs it.
            let force = (velocity - before) * (per_h * model.masses()[particle]);
            set_vector(&mut step.scratch.forces, at, force);
        }
    }
    // Velocities have had their kick.
    let meets = step.find_rows(R::ZERO, false);
    if meets {
        step.meet_shells(h);
    }
    let Columns { positions, velocities } = &mut *step.state;
    for (particle, at) in model.slots.places().enumerate() {
        let way = if meets { vector::<R>(velocities, at) * h } else { ways[particle] };
        add_vector::<R>(positions, at, way);
    }
    power
}

/// Projects all rows to and fro.
fn sweep<R: Real>(model: &Model<R>, projection: &mut Projection<'_, R>) {
    projection.multipliers.fill(R::ZERO);
    for kind in model.inner() {
        kind.project(projection);
        projection.first += kind.multiplier_count();
    }
    projection.is_back = true;
    for kind in model.inner().into_iter().rev() {
        projection.first -= kind.multiplier_count();
        kind.project(projection);
    }
}
