//! Which machinery advances a system by a step, and what does it remember from one to the next?

use crate::collision;
use crate::dormand_prince::{self, Advance, Work};
use crate::explicit::{self, Substep};
use crate::forces;
use crate::implicit;
use crate::integrator::{Explicit, Family, Implicit, Integrator};
use crate::kernel::{Instructions, Kernel, Known, Outcome};
use crate::real::Real;
use crate::settings::Settings;
use crate::system::{Model, Motion, State};
use crate::xpbd;

/// A method with its work columns.
#[derive(Clone, Debug)]
enum Method<R: Real> {
    /// Columns are made when a caller's own force first needs them: [`Kernel`] has those of others.
    Explicit(Explicit, Option<explicit::Scratch<R>>),
    Adaptive(dormand_prince::Scratch<R>),
    Implicit(Implicit, implicit::Scratch<R>),
    Projected(xpbd::Scratch<R>),
}

/// A method, and the springs compiled for it.
#[derive(Clone, Debug)]
pub(crate) struct Engine<R: Real> {
    method: Method<R>,
    /// `None` until it is needed, and again after a change of springs.
    kernel: Option<Kernel<R>>,
    instructions: Instructions,
    /// Whether the accelerations of velocity Verlet at the present state are known.
    warm: bool,
    /// Whether the kernel is at the present state.
    here: bool,
}

/// What the substeps of a step came to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Substeps {
    /// Energy taken away, joules.
    pub(crate) counted: f64,
    /// Whether anything touched a plane, and whether it did in the last substep.
    pub(crate) touched: bool,
    pub(crate) last_met: bool,
    /// Whether the state is known to be inside the world.
    pub(crate) inside: bool,
    /// The particle for which an adaptive method gave up.
    pub(crate) stuck: Option<usize>,
}

impl<R: Real> Engine<R> {
    /// Makes a method ready for a model.
    pub(crate) fn new(integrator: Integrator, model: &Model<R>) -> Self {
        Engine {
            method: Method::new(integrator, model),
            kernel: None,
            instructions: Instructions::best(),
            warm: false,
            here: false,
        }
    }

    /// Replaces the method.
    pub(crate) fn set_method(&mut self, integrator: Integrator, model: &Model<R>) {
        self.method = Method::new(integrator, model);
        self.warm = false;
    }

    /// Replaces the instructions.
    pub(crate) fn set_instructions(&mut self, instructions: Instructions) {
        self.instructions = instructions;
        self.kernel = None;
    }

    /// What the steps of an adaptive method have taken.
    pub(crate) fn work(&self) -> Option<Work> {
        if let Method::Adaptive(scratch) = &self.method { Some(scratch.work()) } else { None }
    }

    /// Forgets what belonged to another state.
    pub(crate) fn forget_state(&mut self) {
        (self.warm, self.here) = (false, false);
    }

    /// Forgets what belonged to other forces or another step; the state is the same.
    pub(crate) fn forget_forces(&mut self) {
        self.warm = false;
    }

    /// Forgets the springs: they have changed.
    pub(crate) fn forget_springs(&mut self) {
        self.kernel = None;
    }

    /// Takes over masses and pins, which may have changed.
    pub(crate) fn renew(&mut self, model: &Model<R>) {
        if let Some(kernel) = &mut self.kernel {
            kernel.renew(model);
        }
    }

    /// Advances `state` by one step, contact included. A caller's own force, if there is one, adds
    /// to its last argument, newtons.
    pub(crate) fn advance(
        &mut self,
        (model, settings): (&Model<R>, &Settings),
        state: &mut State<R>,
        own_force: Option<&mut impl FnMut(Motion<'_, R>, &mut [R::Vec3])>,
    ) -> Substeps {
        let damped = !model.dampings.is_zero() || model.drag != R::ZERO || !model.grabs.is_empty();
        let damped = damped || own_force.is_some();
        // What the next step may remember: accelerations that it would find again to the bit.
        let lasting = model.pushes.is_empty() && !damped;
        // A new kernel remembers nothing.
        let warm = self.warm && (own_force.is_none() && self.kernel.is_some());
        let known = Known { here: self.here && self.kernel.is_some(), warm, damped };
        let Engine { method, kernel, instructions, .. } = self;
        let kernel = kernel.get_or_insert_with(|| Kernel::new(model, *instructions));
        let done = match (method, own_force) {
            (Method::Explicit(method, _), None) => {
                let substeps = (*method, settings.substep(), settings.substeps);
                let Outcome { counted, touched, last_met, inside } =
                    kernel.advance(model, substeps, known, state);
                self.here = true;
                Substeps { counted, touched, last_met, inside, stuck: None }
            }
            (method, Some(own_force)) => {
                self.here = false;
                method.advance((model, settings, kernel), damped, state, own_force)
            }
            (method, None) => {
                self.here = false;
                method.advance((model, settings, kernel), damped, state, &mut |_, _| {})
            }
        };
        self.warm = lasting && !done.last_met;
        done
    }
}

impl<R: Real> Method<R> {
    fn new(integrator: Integrator, model: &Model<R>) -> Self {
        let count = model.particle_count();
        match integrator.family() {
            Family::Explicit(method) => Method::Explicit(method, None),
            Family::Adaptive => Method::Adaptive(dormand_prince::Scratch::new(count)),
            Family::Implicit(method) => Method::Implicit(method, implicit::Scratch::new(model)),
            Family::Projected => Method::Projected(xpbd::Scratch::new(count)),
        }
    }

    /// The forces of the last evaluation, newtons.
    fn forces(&self) -> &[R::Vec3] {
        match self {
            Method::Explicit(_, scratch) => {
                scratch.as_ref().map_or(&[], |scratch| scratch.forces())
            }
            Method::Adaptive(scratch) => scratch.forces(),
            Method::Implicit(_, scratch) => scratch.forces(),
            Method::Projected(scratch) => scratch.forces(),
        }
    }

    fn advance(
        &mut self,
        (model, settings, kernel): (&Model<R>, &Settings, &mut Kernel<R>),
        damped: bool,
        state: &mut State<R>,
        own_force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> Substeps {
        if let Method::Adaptive(scratch) = self {
            let mut force = all_forces(model, kernel, own_force);
            let bounds = (settings.step, settings.tolerance);
            let Advance { counted, touched, stuck, .. } =
                dormand_prince::advance(model, bounds, state, scratch, &mut force);
            return Substeps { counted, touched, last_met: touched, stuck, inside: false };
        }
        let mut done = Substeps::default();
        for substep in 0..settings.substeps {
            let known = (0 < substep, damped);
            done.counted +=
                self.advance_substep((model, settings, kernel), known, state, own_force);
            let h = R::of(settings.substep());
            let contacts = collision::resolve(model, h, self.forces(), state);
            done.counted += contacts.energy;
            done.last_met = 0 < contacts.count;
            done.touched |= done.last_met;
        }
        done
    }

    /// Advances `state` by one substep without contact and returns the energy taken away by dampers
    /// and drag, joules. `warm` and `damped` are those of [`Substep`].
    fn advance_substep(
        &mut self,
        (model, settings, kernel): (&Model<R>, &Settings, &mut Kernel<R>),
        (warm, damped): (bool, bool),
        state: &mut State<R>,
        own_force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> f64 {
        let h = settings.substep();
        match self {
            Method::Explicit(method, scratch) => {
                let count = model.particle_count();
                let scratch = scratch.get_or_insert_with(|| explicit::Scratch::new(*method, count));
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
