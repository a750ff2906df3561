//! XPBD: springs as compliant constraints, projected one by one.

use super::StepContext;
use crate::columns::{Aligned, set_vector, vector};
use crate::elements::column;
use crate::number::{Real, Vector};
use crate::system::Model;
use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

/// What a substep forgets. Positions in the order of the scene, since springs name their ends so.
#[derive(Clone, Debug)]
pub(crate) struct Scratch<R: Real> {
    /// Positions at the start, metres.
    start: Vec<R::Vec3>,
    /// Positions as projected so far, metres.
    predicted: Vec<R::Vec3>,
    /// The pull of springs, newtons, of which only the power of the dampers is wanted.
    pulls: Aligned<R>,
}

impl<R: Real> Scratch<R> {
    fn new(model: &Model<R>) -> Self {
        let vectors = || vec![R::Vec3::ZERO; model.particle_count()];
        Scratch { start: vectors(), predicted: vectors(), pulls: column(&model.slots, 21) }
    }
}

/// Advances by a step.
///
/// Particles first move by the outside forces alone to p = x + h (v + h w f). Then each spring,
/// once and in order, moves its ends along its direction u by −w λ and w λ, with C = |p_b − p_a| −
/// rest:
///
/// λ = −(k h² C + b h u·((p_b − x_b) − (p_a − x_a))) / (1 + (k h² + b h) (w_a + w_b))
///
/// Then v' = (p − x) / h. That is the paper's step with compliance 1/k and damping b, multiplied by
/// k h², so that k = 0 leaves a damper: alone, a spring does the step of backward Euler.
///
/// The error is of first order in h, and has two parts: backward Euler's, and that of a single
/// pass, in which a spring does not see what those after it do. The second makes a body too soft by
/// an amount that grows with k h² / m and with the number of springs in a row, and depends on their
/// order. It keeps linear momentum, since each spring moves its ends by opposite impulses.
///
/// Source: Macklin, Müller and Chentanez, 2016, equations 18 and 26; one iteration per substep as
/// in Macklin et al., 2019.
pub(crate) fn advance<R: Real>(step: &mut StepContext<'_, R>) {
    let scratch = step.scratch.xpbd.take();
    let mut scratch = scratch.unwrap_or_else(|| Box::new(Scratch::new(step.model)));
    for _ in 0..step.substeps() {
        let taken = advance_substep(step, &mut scratch);
        step.finish_substep(taken);
    }
    step.scratch.xpbd = Some(scratch);
}

/// Advances by one substep and returns the energy taken away by dampers and drag, joules.
fn advance_substep<R: Real>(step: &mut StepContext<'_, R>, scratch: &mut Scratch<R>) -> f64 {
    let (model, level, h) = (step.model, step.level, step.substep());
    let time = step.time();
    let motion = step.state.motion(&model.slots, time);
    let (work, forces) = (&mut step.scratch.springs, &mut step.scratch.forces);
    let mut power = model.set_other_forces(level, &motion, work, forces);
    let Scratch { start, predicted, pulls } = scratch;
    let inverse_masses = model.inverse_masses();
    for (particle, at) in model.slots.places().enumerate() {
        let position = vector::<R>(&step.state.positions, at);
        let velocity = vector::<R>(&step.state.velocities, at);
        let force = vector::<R>(&step.scratch.forces, at);
        let velocity = velocity + force * (h * inverse_masses[particle]);
        start[particle] = position;
        predicted[particle] = position + velocity * h;
    }
    project(model, h, start, predicted);
    let per_h = R::ONE / h;
    for (particle, at) in model.slots.places().enumerate() {
        set_vector(&mut step.state.positions, at, predicted[particle]);
        // A pin keeps its velocity to the bit.
        if inverse_masses[particle] != R::ZERO {
            let velocity = (predicted[particle] - start[particle]) * per_h;
            set_vector(&mut step.state.velocities, at, velocity);
        }
    }
    if model.is_damped() {
        let motion = step.state.motion(&model.slots, time + step.settings.substep());
        pulls.fill(R::ZERO);
        power += model.springs.add_all(level, &motion, &mut step.scratch.springs, pulls);
    }
    power * h.to_f64()
}

fn project<R: Real>(model: &Model<R>, h: R, start: &[R::Vec3], predicted: &mut [R::Vec3]) {
    let inverse_masses = model.inverse_masses();
    for (spring, [a, b]) in model.springs.present() {
        let across = predicted[b] - predicted[a];
        let squared = across.dot(across);
        if squared < R::SHORTEST_SQUARED {
            continue;
        }
        let law = model.springs.law(spring);
        let length = squared.sqrt();
        let direction = across * (R::ONE / length);
        let stiff = law.stiffness * h * h;
        let damp = law.damping * h;
        let moved = direction.dot(across - (start[b] - start[a]));
        let stretch = length - law.rest;
        let yielding = R::ONE + (stiff + damp) * (inverse_masses[a] + inverse_masses[b]);
        let pull = direction * ((stiff * stretch + damp * moved) / yielding);
        predicted[a] += pull * inverse_masses[a];
        predicted[b] -= pull * inverse_masses[b];
    }
}
