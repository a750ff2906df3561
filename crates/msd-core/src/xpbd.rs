//! How does a system advance by projecting its springs one by one?

use crate::forces;
use crate::real::{Real, Vector};
use crate::system::{Model, Motion, State};
use alloc::vec;
use alloc::vec::Vec;

/// What a substep forgets.
#[derive(Clone, Debug, Default)]
pub struct Scratch<R: Real> {
    forces: Vec<R::Vec3>,
    /// Positions as projected so far, metres.
    predicted: Vec<R::Vec3>,
}

impl<R: Real> Scratch<R> {
    /// Makes the work columns for `count` particles.
    pub fn new(count: usize) -> Self {
        Scratch { forces: vec![R::Vec3::ZERO; count], predicted: vec![R::Vec3::ZERO; count] }
    }

    /// The forces of the last evaluation, newtons.
    pub fn forces(&self) -> &[R::Vec3] {
        &self.forces
    }
}

/// Advances `state` by one substep of `h` seconds and returns the energy taken away by dampers and
/// drag, joules.
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
/// `external` overwrites its last argument with every force but those of the springs, newtons, and
/// returns the power of the drag, watts.
///
/// Source: Macklin, Müller and Chentanez, 2016, equations 18 and 26; one iteration per substep as
/// in Macklin et al., 2019.
pub fn advance<R: Real>(
    model: &Model<R>,
    h: R,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    external: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let Scratch { forces, predicted } = scratch;
    let drag = external(state.motion(), forces);
    for (row, predicted) in predicted.iter_mut().enumerate() {
        let velocity = state.velocities[row] + forces[row] * (h * model.inverse_masses[row]);
        *predicted = state.positions[row] + velocity * h;
    }
    project(model, h, &state.positions, predicted);
    let per_h = R::ONE / h;
    for (row, &predicted) in predicted.iter().enumerate() {
        // A pin keeps its velocity to the bit.
        if model.inverse_masses[row] != R::ZERO {
            state.velocities[row] = (predicted - state.positions[row]) * per_h;
        }
        state.positions[row] = predicted;
    }
    (drag + forces::damper_power(model, state.motion())) * h.to_f64()
}

fn project<R: Real>(model: &Model<R>, h: R, start: &[R::Vec3], predicted: &mut [R::Vec3]) {
    let inverse_masses = &model.inverse_masses;
    for (spring, &[a, b]) in model.ends.iter().enumerate() {
        let (a, b) = (a as usize, b as usize);
        let across = predicted[b] - predicted[a];
        let squared = across.dot(across);
        if squared < R::SHORTEST_SQUARED {
            continue;
        }
        let length = squared.sqrt();
        let direction = across * (R::ONE / length);
        let stiff = model.stiffnesses.get(spring) * h * h;
        let damp = model.dampings.get(spring) * h;
        let moved = direction.dot(across - (start[b] - start[a]));
        let stretch = length - model.rest_lengths[spring];
        let yielding = R::ONE + (stiff + damp) * (inverse_masses[a] + inverse_masses[b]);
        let pull = direction * ((stiff * stretch + damp * moved) / yielding);
        predicted[a] += pull * inverse_masses[a];
        predicted[b] -= pull * inverse_masses[b];
    }
}
