//! Which machinery advances a system, and what does it remember within a step?

use crate::dormand_prince::{self, Advance, Work};
use crate::explicit::{self, Substep};
use crate::forces;
use crate::implicit;
use crate::integrator::{Explicit, Family, Implicit, Integrator};
use crate::kernel::Kernel;
use crate::real::Real;
use crate::settings::Settings;
use crate::system::{Model, Motion, State};
use crate::xpbd;

/// A method with its work columns.
#[derive(Clone, Debug)]
pub(crate) enum Method<R: Real> {
    Explicit(Explicit, explicit::Scratch<R>),
    Adaptive(dormand_prince::Scratch<R>),
    Implicit(Implicit, implicit::Scratch<R>),
    Projected(xpbd::Scratch<R>),
}

impl<R: Real> Method<R> {
    /// Makes the work columns that a method needs.
    pub(crate) fn new(integrator: Integrator, model: &Model<R>) -> Self {
        let count = model.particle_count();
        match integrator.family() {
            Family::Explicit(method) => {
                Method::Explicit(method, explicit::Scratch::new(method, count))
            }
            Family::Adaptive => Method::Adaptive(dormand_prince::Scratch::new(count)),
            Family::Implicit(method) => Method::Implicit(method, implicit::Scratch::new(model)),
            Family::Projected => Method::Projected(xpbd::Scratch::new(count)),
        }
    }

    /// The forces of the last evaluation, newtons.
    pub(crate) fn forces(&self) -> &[R::Vec3] {
        match self {
            Method::Explicit(_, scratch) => scratch.forces(),
            Method::Adaptive(scratch) => scratch.forces(),
            Method::Implicit(_, scratch) => scratch.forces(),
            Method::Projected(scratch) => scratch.forces(),
        }
    }

    /// What the steps of an adaptive method have taken.
    pub(crate) fn work(&self) -> Option<Work> {
        if let Method::Adaptive(scratch) = self { Some(scratch.work()) } else { None }
    }

    /// Advances `state` by one substep without contact and returns the energy taken away by dampers
    /// and drag, joules. `warm` and `damped` are those of [`Substep`].
    pub(crate) fn advance(
        &mut self,
        (model, settings, kernel): (&Model<R>, &Settings, &mut Kernel<R>),
        (warm, damped): (bool, bool),
        state: &mut State<R>,
        own_force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> f64 {
        let h = settings.substep();
        match self {
            Method::Explicit(method, scratch) => {
                let (h, inverse_masses) = (R::of(h), &model.inverse_masses[..]);
                let substep = Substep { h, inverse_masses, warm, damped };
                let mut force = all_forces(model, kernel, own_force);
                explicit::advance(*method, substep, state, scratch, &mut force)
            }
            Method::Implicit(method, scratch) => {
                let substep = implicit::Substep { h, newton: settings.newton };
                let mut force = all_forces(model, kernel, own_force);
                implicit::advance(*method, (model, substep), state, scratch, &mut force)
            }
            Method::Projected(scratch) => {
                let mut external = |motion: Motion<'_, R>, forces: &mut [R::Vec3]| {
                    let drag = forces::set_external_forces(model, motion, forces);
                    own_force(motion, forces);
                    drag
                };
                xpbd::advance(model, R::of(h), state, scratch, &mut external)
            }
            Method::Adaptive(_) => 0.0,
        }
    }

    /// Advances `state` by one step of an adaptive method, with contact.
    pub(crate) fn advance_step(
        &mut self,
        (model, settings, kernel): (&Model<R>, &Settings, &mut Kernel<R>),
        state: &mut State<R>,
        own_force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> Advance {
        let Method::Adaptive(scratch) = self else { return Advance::default() };
        let mut force = all_forces(model, kernel, own_force);
        let bounds = (settings.step, settings.tolerance);
        dormand_prince::advance(model, bounds, state, scratch, &mut force)
    }
}

/// Every force of a step: a closure that overwrites its last argument with forces, newtons, and
/// returns the power taken away, watts.
fn all_forces<'a, R: Real>(
    model: &'a Model<R>,
    kernel: &'a mut Kernel<R>,
    own_force: &'a mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
) -> impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64 + 'a {
    move |motion, forces| {
        let power = kernel.set_forces(model, motion, forces);
        own_force(motion, forces);
        power
    }
}
