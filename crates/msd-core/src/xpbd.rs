//! How does a system advance by projecting its springs one by one?

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

/// Advances `state` by one substep of `h` seconds and returns the energy taken away by dampers and
/// drag, joules.
///
/// `external` overwrites its last argument with every force but those of the springs, newtons, and
/// returns the power of the drag, watts.
pub fn advance<R: Real>(
    model: &Model<R>,
    h: R,
    state: &mut State<R>,
    scratch: &mut Scratch<R>,
    external: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64,
) -> f64 {
    let _ = (model, h);
    external(state.motion(), &mut scratch.forces)
}
