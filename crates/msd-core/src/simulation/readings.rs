//! Readings of a simulation: stability, positions, forces, energy, momentum and strain.

use super::Simulation;
use super::compiled::Compiled;
use crate::columns;
use crate::contact::Contacts;
use crate::contact::shells::ShellRows;
use crate::elements::{ForceWork, collected, column};
use crate::energy::{self, Energy, Momentum};
use crate::methods::{Integrator, Method, Solved, Work};
use crate::number::{Real, Vector};
use crate::stability::{self, Estimator, Mode};
use crate::system::{Columns, Snapshot, State};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use glam::DVec3;

impl<R: Real> Simulation<R> {
    /// Returns whether unaccounted work is done: by a grab, by a push, or by a pin that went from
    /// one key frame to another within a few substeps of the last step.
    pub fn is_handled(&self) -> bool {
        self.is_handled_until(self.time())
    }

    /// The same of the step that ends at a time, seconds.
    pub(super) fn is_handled_until(&self, time: f64) -> bool {
        let lengths = [self.settings.step, self.settings.substep()];
        !self.model.grabs.0.is_empty()
            || !self.model.pushes.0.is_empty()
            || self.model.guides.jump(self.model.solids(), time, lengths)
    }

    /// The work of the steps of an adaptive method since it was chosen; `None` for others.
    pub fn work(&self) -> Option<Work> {
        if !self.settings.integrator.is_adaptive() {
            return None;
        }
        Some(self.scratch.dormand_prince.as_ref().map_or(Work::default(), |scratch| scratch.work()))
    }

    /// Convergence of the solves in the last step of an implicit method; `None` for others, and
    /// before the first step.
    pub fn solved(&self) -> Option<Solved> {
        self.scratch.implicit.as_ref().map(|scratch| scratch.solved())
    }

    /// Predicts the largest stable substep at the current state, seconds: 0 if no step is stable,
    /// infinite if every step is.
    pub fn stable_substep(&self) -> f64 {
        self.stable_substep_by(&mut Estimator::default())
    }

    /// Predicts like [`Simulation::stable_substep`], with columns that are kept for the next call.
    pub fn stable_substep_by(&self, estimator: &mut Estimator) -> f64 {
        (Compiled::of_precision().predict)(self, estimator)
    }

    /// The body of [`Simulation::stable_substep_by`].
    pub(super) fn predict(&self, estimator: &mut Estimator) -> f64 {
        self.largest_substep_at(&self.state, estimator)
    }

    /// Predicts the largest substep that another method would take stably at the current state, in
    /// steps of so many substeps, seconds.
    pub fn stable_substep_of(&self, integrator: Integrator, substeps: u32) -> f64 {
        let how = (Method::<R>::region(&integrator), substeps);
        Estimator::default().limit((&self.model, &self.state), self.time(), how)
    }

    /// Does a piece of that prediction, some two evaluations of the forces long, or some thousands
    /// of products of small matrices; returns it at its end. Between two pieces the simulation must
    /// not change, unless the estimator is restarted.
    pub fn stable_substep_piecewise(
        &self,
        integrator: Integrator,
        substeps: u32,
        estimator: &mut Estimator,
    ) -> Option<f64> {
        (Compiled::of_precision().predict_on)(self, integrator, substeps, estimator)
    }

    /// The body of [`Simulation::stable_substep_piecewise`].
    pub(super) fn predict_on(
        &self,
        integrator: Integrator,
        substeps: u32,
        estimator: &mut Estimator,
    ) -> Option<f64> {
        let how = (Method::<R>::region(&integrator), substeps);
        estimator.advance((&self.model, &self.state), self.time(), how)
    }

    /// A substep that is stable at every state in which no spring is compressed to nothing,
    /// seconds. It comes from sums over springs alone, two to four times shorter than the
    /// prediction; 0 for explicit Euler, for which such sums give no bound.
    pub fn guaranteed_substep(&self, integrator: Integrator) -> f64 {
        stability::guaranteed_limit(
            (&self.model, &self.state),
            self.time(),
            Method::<R>::region(&integrator),
        )
    }

    /// The pairs of particles of one shell whose triangles, edges and points are closer than it
    /// stops itself at, see [`Shell::exempt`](crate::scene::Shell::exempt).
    pub fn closed_pairs(&self) -> Vec<[usize; 2]> {
        let at = self.model.shells_at(self.level, self.time());
        let still = vec![R::ZERO; self.state.positions.len()];
        let mut rows = ShellRows::default();
        if at.shells.do_meet() {
            rows.find(&at, [&self.state.positions, &still, &still], (R::ZERO, R::ONE, R::ZERO));
        }
        rows.closed_pairs(at.shells)
    }

    /// The fastest motion at the current state, taken for a single oscillator: that is exact where
    /// damping goes with stiffness.
    pub fn fastest_mode(&self) -> Mode {
        stability::fastest_mode(&self.model, &self.state, self.time())
    }

    /// The slowest motions at the current state, `count` of them and at most five. Each is taken
    /// for a single oscillator: that is exact where damping goes with stiffness. Motions that
    /// nothing resists, as those of a free body as a whole, are left out. None are found where
    /// those are more than ten, as in a cloth that does not resist bending. Takes some thousand
    /// products with the stiffness.
    pub fn slowest_modes(&self, count: usize) -> Vec<Mode> {
        stability::slowest_modes((&self.model, &self.state), self.time(), count)
    }

    /// The displacement of each particle in the fastest motion at the current state, the largest of
    /// length 1. That motion limits the substep of most methods. Empty where nothing pulls.
    pub fn fastest_motion(&self) -> Vec<DVec3> {
        stability::fastest_motion(&self.model, &self.state, self.time())
    }

    /// The positions of all particles in the order of the scene, metres.
    pub fn positions(&self) -> impl Iterator<Item = R::Vec3> + '_ {
        self.model.slots.places().map(|at| columns::vector(&self.state.positions, at))
    }

    /// The velocities of all particles in the order of the scene, metres per second.
    pub fn velocities(&self) -> impl Iterator<Item = R::Vec3> + '_ {
        self.model.slots.places().map(|at| columns::vector(&self.state.velocities, at))
    }

    /// The position of a particle, metres.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn position(&self, particle: usize) -> R::Vec3 {
        self.state.get(self.model.slots.at(particle)).0
    }

    /// The velocity of a particle, metres per second.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn velocity(&self, particle: usize) -> R::Vec3 {
        self.state.get(self.model.slots.at(particle)).1
    }

    /// Overwrites `to` with all positions in single precision, metres.
    pub fn copy_positions(&self, to: &mut Vec<[f32; 3]>) {
        self.snapshot().copy_positions(to);
    }

    /// The forces on all particles in the order of the scene, newtons, and the power dissipated,
    /// watts.
    pub fn forces(&self) -> (Vec<R::Vec3>, f64) {
        (Compiled::of_precision().forces)(self, &self.state)
    }

    /// The forces that would act in another state of the system at the current time.
    ///
    /// # Panics
    /// If the state has another number of particles.
    pub fn forces_at(&self, state: &State<R>) -> (Vec<R::Vec3>, f64) {
        (Compiled::of_precision().forces)(self, &self.columns_of(state))
    }

    /// The force with which pins hold those of these particles that are pinned, newtons: minus the
    /// forces on them, as a pin that moves steadily gives it.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn pin_force(&self, particles: impl IntoIterator<Item = usize>) -> DVec3 {
        self.pin_forces([particles])[0]
    }

    /// The same of several groups of particles, for one evaluation of the forces.
    ///
    /// # Panics
    /// If there is no such particle.
    pub fn pin_forces<G: IntoIterator<Item = usize>>(
        &self,
        groups: impl IntoIterator<Item = G>,
    ) -> Vec<DVec3> {
        let forces = self.forces().0;
        let sum = |group: G| {
            let pinned = group.into_iter().filter(|&particle| self.model.is_pinned(particle));
            -pinned.map(|particle| forces[particle].to_f64()).sum::<DVec3>()
        };
        groups.into_iter().map(sum).collect()
    }

    /// The body of [`Simulation::forces`] and [`Simulation::forces_at`].
    pub(super) fn forces_in(&self, columns: &Columns<R>) -> (Vec<R::Vec3>, f64) {
        let slots = &self.model.slots;
        let mut work = ForceWork::new(&self.model.springs, slots);
        let mut forces = column(slots, 0);
        let motion = columns.motion(slots, self.time());
        let power = self.model.set_forces(self.level, &motion, &mut work, &mut forces);
        (collected(slots, &forces), power)
    }

    fn columns_of(&self, state: &State<R>) -> Columns<R> {
        let slots = &self.model.slots;
        let counts = [state.positions.len(), state.velocities.len()];
        assert_eq!(counts, [slots.particle_count(); 2], "a state of this system");
        Columns::of(slots, state, 0)
    }

    /// A borrowed view of the current state, for a renderer.
    pub fn snapshot(&self) -> Snapshot<'_, R> {
        Snapshot::new(&self.model, &self.state, self.time())
    }

    /// The energy of the system, by kind.
    pub fn energy(&self) -> Energy {
        self.energy_and_rounding().0
    }

    /// The energy of the system, and the most by which rounding every coordinate and speed once can
    /// change it, joules.
    pub fn energy_and_rounding(&self) -> (Energy, f64) {
        let (energy, rounding) = (Compiled::of_precision().measure)(self);
        (Energy { dissipated: self.dissipated(), supplied: self.given(), ..energy }, rounding)
    }

    /// Energy and rounding without the energy dissipated.
    pub(super) fn measure(&self) -> (Energy, f64) {
        energy::energy_and_rounding(
            &self.model,
            &self.state,
            (self.time(), self.settings.substep()),
            self.level,
        )
    }

    /// Energy dissipated since the start by dampers, drag and contact, joules.
    pub fn dissipated(&self) -> f64 {
        self.ledger.dissipated()
    }

    /// The effect of obstacles since the start: the energy they dissipated, and the energy they
    /// added, which is an error.
    pub fn contacts(&self) -> Contacts {
        self.ledger.contacts()
    }

    /// Energy that moving solids, moving pins and user-defined elements have driven into the system
    /// since the start, joules.
    pub fn given(&self) -> f64 {
        self.ledger.given()
    }

    /// The energy of another state of the system, with nothing dissipated.
    ///
    /// # Panics
    /// If the state has another number of particles.
    pub fn energy_at(&self, state: &State<R>) -> Energy {
        let columns = self.columns_of(state);
        let at = (self.time(), 0.0);
        energy::energy_and_rounding(&self.model, &columns, at, self.level).0
    }

    /// The centre of mass of a range of particles, metres.
    ///
    /// # Panics
    /// If there are no such particles.
    pub fn centre_of_mass(&self, particles: Range<usize>) -> DVec3 {
        energy::centre_of_mass(&self.model, &self.state, particles)
    }

    /// The present length of a spring, metres.
    ///
    /// # Panics
    /// If there is no such spring.
    pub fn length(&self, spring: usize) -> f64 {
        energy::length(&self.model, &self.state, spring)
    }

    /// The strain of a spring, (length − rest) / rest; its length in metres where the rest length
    /// is 0.
    ///
    /// # Panics
    /// If there is no such spring.
    pub fn strain(&self, spring: usize) -> f64 {
        self.snapshot().strain(spring)
    }

    /// The force of a spring and its damper along it, newtons: positive where it pulls its ends
    /// together. 0 where it is cut, and where its ends coincide.
    ///
    /// # Panics
    /// If there is no such spring.
    pub fn tension(&self, spring: usize) -> f64 {
        self.snapshot().tension(spring)
    }

    /// Linear and angular momentum.
    pub fn momentum(&self) -> Momentum {
        energy::momentum(&self.model, &self.state)
    }
}
