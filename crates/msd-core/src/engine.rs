//! Which machinery advances a system by a step, and what does it remember from one to the next?

use crate::collision;
use crate::dormand_prince::{self, Advance, Work};
use crate::explicit::{self, Substep};
use crate::forces;
use crate::implicit;
use crate::integrator::{Explicit, Family, Implicit, Integrator};
use crate::kernel::{Instructions, Kernel, Known, Substeps};
use crate::real::Real;
use crate::settings::Settings;
use crate::system::{Model, Motion, State};
use crate::xpbd;

/// A method with its work columns.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one for each simulation")]
enum Method<R: Real> {
    /// Columns are made when a caller's own force first needs them: [`Kernel`] has those of others.
    Explicit(Explicit, Option<explicit::Scratch<R>>),
    Adaptive(dormand_prince::Scratch<R>),
    Implicit(Implicit, implicit::Scratch<R>),
    Projected(xpbd::Scratch<R>),
}

/// The springs, compiled when they are needed first.
#[derive(Clone, Debug)]
struct Springs<R: Real> {
    kernel: Option<Kernel<R>>,
    instructions: Instructions,
}

impl<R: Real> Springs<R> {
    fn of(&mut self, model: &Model<R>) -> &mut Kernel<R> {
        self.kernel.get_or_insert_with(|| Kernel::new(model, self.instructions))
    }
}

/// A method, and the springs compiled for it.
#[derive(Clone, Debug)]
pub(crate) struct Engine<R: Real> {
    method: Method<R>,
    springs: Springs<R>,
    /// Whether the accelerations of velocity Verlet at the present state are known.
    warm: bool,
    /// Whether the kernel is at the present state.
    here: bool,
}

impl<R: Real> Engine<R> {
    /// Makes a method ready for a model.
    pub(crate) fn new(integrator: Integrator, model: &Model<R>) -> Self {
        Engine {
            method: Method::new(integrator, model),
            springs: Springs { kernel: None, instructions: Instructions::best() },
            warm: false,
            here: false,
        }
    }

    /// Replaces the method.
    pub(crate) fn set_method(&mut self, integrator: Integrator, model: &Model<R>) {
        self.method = Method::new(integrator, model);
        self.warm = false;
        if let Some(kernel) = &mut self.springs.kernel {
            kernel.forget_method();
        }
    }

    /// Replaces the instructions.
    pub(crate) fn set_instructions(&mut self, instructions: Instructions) {
        self.springs = Springs { kernel: None, instructions };
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
        self.springs.kernel = None;
    }

    /// Takes over masses and pins, which may have changed.
    pub(crate) fn renew(&mut self, model: &Model<R>) {
        if let Some(kernel) = &mut self.springs.kernel {
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
        let (old, alone) = (self.springs.kernel.is_some(), own_force.is_none());
        let known = Known { here: self.here && old, warm: self.warm && old && alone, damped };
        let Engine { method, springs, .. } = self;
        let parts = (model, settings, springs);
        let (here, done) = match (method, own_force) {
            (Method::Explicit(method, _), None) => {
                let substeps = (*method, settings.substep(), settings.substeps);
                (true, parts.2.of(model).advance(model, substeps, known, state))
            }
            (method, Some(own_force)) => (false, method.advance(parts, damped, state, own_force)),
            (method, None) => (false, method.advance(parts, damped, state, &mut |_, _| {})),
        };
        self.here = here;
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
        (model, settings, springs): (&Model<R>, &Settings, &mut Springs<R>),
        damped: bool,
        state: &mut State<R>,
        own_force: &mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
    ) -> Substeps {
        if let Method::Adaptive(scratch) = self {
            let mut force = all_forces(model, springs, own_force);
            let bounds = (settings.step, settings.tolerance);
            let Advance { counted, touched, stuck, .. } =
                dormand_prince::advance(model, bounds, state, scratch, &mut force);
            return Substeps { counted, touched, last_met: touched, stuck, inside: false };
        }
        let mut done = Substeps::default();
        for substep in 0..settings.substeps {
            let known = (0 < substep, damped);
            done.counted +=
                self.advance_substep((model, settings, springs), known, state, own_force);
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
        (model, settings, springs): (&Model<R>, &Settings, &mut Springs<R>),
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
                let mut force = all_forces(model, springs, own_force);
                explicit::advance(*method, substep, state, scratch, &mut force)
            }
            Method::Implicit(method, scratch) => {
                let substep = implicit::Substep { h, newton: settings.newton };
                let parts = (model, substep, springs.of(model));
                implicit::advance(*method, parts, state, scratch, own_force)
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
    springs: &'a mut Springs<R>,
    own_force: &'a mut impl FnMut(Motion<'_, R>, &mut [R::Vec3]),
) -> impl FnMut(Motion<'_, R>, &mut [R::Vec3]) -> f64 + 'a {
    move |motion, forces| {
        let power = springs.of(model).set_forces(model, motion, forces);
        own_force(motion, forces);
        power
    }
}
