//! The model: masses, springs, fields and obstacles of a system, as columns that a step reads.

use super::guides::{Guides, guides_at, power_of_pins};
use super::kinds::Kinds;
use super::state::{Columns, State};
use crate::columns::slots::Slots;
use crate::columns::{self, Aligned, LANES, RECORD, single};
use crate::contact::after_kick::{Kick, Kicked, settle};
use crate::contact::arrive::resolve;
use crate::contact::ending::{Bodies, Substep};
use crate::contact::found::{Contact, ContactSearch, Found, Places, When, find};
use crate::contact::points::Points;
use crate::contact::shells::{At, Shells};
use crate::contact::{Contacts, Radii};
use crate::elements::air::AirLoads;
use crate::elements::bends::Bends;
use crate::elements::fields::Fields;
use crate::elements::grabs::{Grab, Grabs, Pushes};
use crate::elements::springs::Springs;
use crate::elements::volumes::Volumes;
use crate::elements::{
    Element, Force, ForceWork, Moment, Motion, Owns, Resists, Rows, Torn, column,
};
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::obstacles::{Obstacles, PlaneColumn};
use crate::scene::check::check_scene;
use crate::scene::{Air, Body, Guide, Scene, Shell, Solid};
use alloc::borrow::Cow;
use alloc::vec::Vec;
use fearless_simd::Level;

/// The columns that a step reads. Those of particles are in the order of the scene unless stated
/// otherwise.
///
/// Built with a simulation, changed only between two steps. A particle that was removed keeps its
/// number and has no mass.
#[derive(Clone, Debug)]
pub struct Model<R: Real> {
    pub(crate) slots: Slots,
    pub(crate) masses: Vec<R>,
    /// 1 / mass, and 0 for a pinned particle: nothing moves it.
    pub(crate) inverse_masses: Vec<R>,
    /// The same in the order of slots: a mass for each, and its reciprocal three times.
    pub(crate) mass_column: Aligned<R>,
    pub(crate) inverse_mass_column: Aligned<R>,
    /// The slots of pins that were not removed, and the guides of some of them.
    pins: Vec<usize>,
    pub(crate) guides: Guides,
    /// Radii against obstacles, metres: of each slot, empty where none counts, and the largest.
    radii: (Aligned<R>, R),
    /// Contact points on springs.
    points: Points,
    pub(crate) fields: Fields<R>,
    pub(crate) springs: Springs<R>,
    pub(crate) bends: Bends<R>,
    pub(crate) volumes: Volumes<R>,
    pub(crate) shells: Shells,
    pub(crate) grabs: Grabs<R>,
    pub(crate) pushes: Pushes<R>,
    /// The air on surfaces; none in a scene without air.
    pub(crate) air: Option<AirLoads>,
    pub(crate) own: Owns,
    pub(crate) obstacles: Obstacles<R>,
    pub(crate) extent: R,
    pub(crate) size: f64,
    pub(crate) bodies: Vec<Body>,
}

impl<R: Real> Model<R> {
    /// Checks a scene and turns its rows into columns. Frees rows that it owns before others are
    /// made.
    ///
    /// # Errors
    /// The first row that is out of its domain in precision `R`: a mass that is not positive, a
    /// number that is not finite, an index that names nothing, a spring from a particle to itself.
    pub(crate) fn new(mut scene: Cow<'_, Scene>) -> Result<(Self, State<R>), Error> {
        check_scene::<R>(&scene)?;
        let masses: Vec<R> = scene.particles.iter().map(|p| R::of(p.mass)).collect();
        let mut inverse_masses: Vec<R> = masses.iter().map(|&mass| R::ONE / mass).collect();
        let mut state = State {
            positions: scene.particles.iter().map(|p| R::Vec3::of(p.position)).collect(),
            velocities: scene.particles.iter().map(|p| R::Vec3::of(p.velocity)).collect(),
        };
        for pin in &scene.pins {
            inverse_masses[pin.particle] = R::ZERO;
            state.velocities[pin.particle] = R::Vec3::of(pin.velocity);
        }
        let bodies: Vec<_> = scene.bodies.iter().map(|body| body.particles.clone()).collect();
        let (mut springs, size) = (Springs::new(&scene.springs), scene.size());
        if let Cow::Owned(scene) = &mut scene {
            (scene.particles, scene.springs) = Default::default();
        }
        let slots = springs.order(masses.len(), &bodies);
        let mut model = Model {
            masses,
            inverse_masses,
            mass_column: Aligned::default(),
            inverse_mass_column: Aligned::default(),
            pins: Vec::new(),
            guides: Guides(scene.guides.iter().map(|guide| (guide.clone(), false)).collect()),
            radii: (Aligned::default(), R::ZERO),
            points: Points::default(),
            fields: Fields::new(&scene.world),
            springs,
            bends: Bends::default(),
            volumes: Volumes::default(),
            shells: Shells::default(),
            grabs: Grabs::default(),
            pushes: Pushes::default(),
            air: scene.world.air.as_ref().map(|air| AirLoads::new(air, &[])),
            own: Owns::default(),
            obstacles: Obstacles {
                planes: scene.planes.iter().map(PlaneColumn::new).collect(),
                solids: scene.solids.clone(),
                own: Vec::new(),
            },
            extent: R::of(scene.world.extent),
            size,
            bodies: Vec::new(),
            slots,
        };
        model.add_rows(&scene);
        model.bodies = match scene {
            Cow::Owned(scene) => scene.bodies,
            Cow::Borrowed(scene) => scene.bodies.clone(),
        };
        Ok((model, state))
    }

    /// Where the numbers of each particle are in the columns.
    #[doc(hidden)]
    pub fn slots(&self) -> &Slots {
        &self.slots
    }

    /// Takes over the rows of a scene that elements have, beside those that are there, and makes
    /// the columns in the order of slots.
    pub(crate) fn add_rows(&mut self, rows: &Scene) {
        self.each_beside_springs(|kind, slots| kind.add(rows, slots));
        self.mass_column = Aligned::new(self.slots.record_count() * LANES, 12);
        self.inverse_mass_column = column(&self.slots, 13);
        self.fields.weights = column(&self.slots, 14);
        self.renew_masses();
        self.set_shells(self.shells.rows().iter().chain(&rows.shells).cloned().collect());
        self.points = Points::new(&self.obstacles.solids, &self.springs, &self.slots);
    }

    /// Replaces the shells.
    pub(crate) fn set_shells(&mut self, rows: Vec<Shell>) {
        self.shells = Shells::new(rows, &self.slots);
        let is_removed = |particle: u32| self.masses[particle as usize] == R::ZERO;
        self.shells.remove(&is_removed, &self.slots);
        self.radii = self.shells.radii_at_obstacles(&self.slots);
    }

    /// The radii that count against obstacles.
    pub(crate) fn radii(&self) -> Radii<'_, R> {
        Radii { column: &self.radii.0, largest: self.radii.1 }
    }

    /// Updates the columns for changed masses, pins and fields.
    pub(crate) fn renew_masses(&mut self) {
        self.pins.clear();
        let rows = self.slots.places().zip(self.masses.iter().zip(&self.inverse_masses));
        for (at, (&mass, &inverse_mass)) in rows {
            self.mass_column[single(at)] = mass;
            self.pins.extend((inverse_mass == R::ZERO && mass != R::ZERO).then_some(at));
            for axis in 0..3 {
                self.inverse_mass_column[at + axis * LANES] = inverse_mass;
            }
        }
        self.fields.weigh(&self.mass_column);
    }

    /// Pins the particles of the guides that guide at a time of steps of this length, seconds, and
    /// frees those of others; whether that changed any.
    pub(crate) fn hold(&mut self, time: f64, step: f64) -> bool {
        let mut changed = false;
        for (guide, guides) in &mut self.guides.0 {
            let are_held = guides_at(guide, time, step);
            if core::mem::replace(guides, are_held) == are_held {
                continue;
            }
            for &(particle, _) in &guide.held {
                let mass = self.masses[particle];
                let is_free = !are_held && mass != R::ZERO;
                self.inverse_masses[particle] = if is_free { R::ONE / mass } else { R::ZERO };
            }
            changed = true;
        }
        changed
    }

    /// Puts guided particles where they are at a time, seconds, with their velocities.
    pub(crate) fn place(&self, time: f64, columns: [&mut [R]; 2]) {
        self.guides.place((&self.obstacles.solids, &self.slots), time, columns);
    }

    /// Gives guided particles their mean velocities in a substep of h seconds up to a time.
    pub(crate) fn lead(&self, (time, h): (f64, f64), state: &mut Columns<R>) {
        self.guides.lead((&self.obstacles.solids, &self.slots), (time, h), state);
    }

    /// The power that pins give at these forces and velocities, watts.
    pub(crate) fn power_of_pins(&self, forces: &[R], velocities: &[R]) -> f64 {
        power_of_pins(&self.pins, forces, velocities)
    }

    /// Whether any pin moves at these velocities.
    pub(crate) fn do_pins_move(&self, velocities: &[R]) -> bool {
        self.pins.iter().any(|&at| columns::vector::<R>(velocities, at) != R::Vec3::ZERO)
    }

    /// The kinetic energy of pins, joules.
    pub(crate) fn energy_of_pins(&self, velocities: &[R]) -> f64 {
        let energy = |&at: &usize| {
            let velocity = columns::vector::<R>(velocities, at).to_f64();
            0.5 * self.mass_column[single(at)].to_f64() * velocity.dot(velocity)
        };
        self.pins.iter().map(energy).sum()
    }

    /// The kinds of elements that only join particles to each other, see [`Kinds`].
    pub(crate) fn inner(&self) -> [&dyn Force<R>; 3] {
        (Kinds::of_precision().inner)(self)
    }

    /// The kinds that act on each particle alone.
    pub(crate) fn single(&self) -> [&dyn Force<R>; 3] {
        (Kinds::of_precision().single)(self)
    }

    /// The kinds that may do anything.
    pub(crate) fn other(&self) -> [&dyn Force<R>; 2] {
        (Kinds::of_precision().other)(self)
    }

    /// All kinds, springs first.
    pub(crate) fn kinds(&self) -> impl Iterator<Item = &dyn Force<R>> {
        self.inner().into_iter().chain(self.single()).chain(self.other())
    }

    /// Changes all kinds but springs.
    fn each_beside_springs(&mut self, mut change: impl FnMut(&mut dyn Force<R>, &Slots)) {
        let (kinds, slots) = (Kinds::of_precision().beside_springs)(self);
        kinds.into_iter().for_each(|kind| change(kind, slots));
    }

    /// The inputs of the laws of forces at a motion.
    pub(crate) fn moment<'a>(&'a self, level: Level, motion: Motion<'a, R>) -> Moment<'a, R> {
        Moment { level, motion }
    }

    /// Overwrites `forces` with all forces at a motion, newtons, and returns the power dissipated,
    /// watts.
    pub(crate) fn set_forces(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        work: &mut ForceWork<R>,
        forces: &mut [R],
    ) -> f64 {
        let power = self.fields.set_forces(level, motion.velocities, forces);
        let moment = self.moment(level, *motion);
        let power = self
            .inner()
            .iter()
            .fold(power, |sum, kind| sum + kind.add_forces(&moment, work, forces));
        power + self.add_outer_forces(&moment, work, forces)
    }

    /// Overwrites `forces` with those that may push bodies as a whole.
    pub(crate) fn set_outer_forces(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        work: &mut ForceWork<R>,
        forces: &mut [R],
    ) -> f64 {
        let power = self.fields.set_forces(level, motion.velocities, forces);
        power + self.add_outer_forces(&self.moment(level, *motion), work, forces)
    }

    /// Adds the forces of grabs and pushes and of all that may do anything.
    fn add_outer_forces(
        &self,
        moment: &Moment<'_, R>,
        work: &mut ForceWork<R>,
        forces: &mut [R],
    ) -> f64 {
        let [_, single @ ..] = self.single();
        for kind in single {
            kind.add_forces(moment, work, forces);
        }
        let powers = self.other().map(|kind| kind.add_forces(moment, work, forces));
        work.own_power = powers.into_iter().sum();
        work.own_power
    }

    /// Lets every particle that has come into an obstacle meet it, and every contact point, at the
    /// end of a substep.
    pub(crate) fn resolve(
        &self,
        level: Level,
        state: &mut Columns<R>,
        (forces, contacts): (&[R], &[Contact]),
        substep: Substep<'_, R>,
    ) -> Contacts {
        let found = self.found(contacts);
        let bodies = Bodies { found, ..self.ending(state, forces, substep) };
        let contacts = resolve(level, &self.obstacles, bodies);
        contacts + self.meet_springs(state, forces, substep)
    }

    /// Lets the contact points on springs that have come into a solid meet it.
    pub(crate) fn meet_springs(
        &self,
        state: &mut Columns<R>,
        forces: &[R],
        substep: Substep<'_, R>,
    ) -> Contacts {
        if self.points.is_empty() {
            return Contacts::default();
        }
        let mut bodies = self.ending(state, forces, substep);
        self.points.meet(&self.obstacles.solids, &self.springs, &mut bodies)
    }

    fn ending<'a>(
        &'a self,
        state: &'a mut Columns<R>,
        forces: &'a [R],
        substep: Substep<'a, R>,
    ) -> Bodies<'a, R> {
        Bodies {
            masses: &self.mass_column,
            inverse_masses: &self.inverse_mass_column,
            stiffnesses: self.springs.stiffness_sums(),
            radii: self.radii(),
            forces,
            positions: &mut state.positions,
            velocities: &mut state.velocities,
            substep,
            found: Found::default(),
        }
    }

    /// Finds the contacts of these positions of particles that something moves; whether any lies on
    /// an obstacle, and whether there is a contact.
    pub(crate) fn find(
        &self,
        level: Level,
        positions: &[R],
        when: When,
        contacts: &mut Vec<Contact>,
    ) -> [bool; 2] {
        if self.obstacles.is_empty() {
            return [false; 2];
        }
        let (places, count) = (self.places(positions), self.obstacles.count());
        contacts.resize(positions.len() / RECORD * count, Contact::default());
        let search = ContactSearch { places, contacts, count, when, extent: self.extent };
        find(level, &self.obstacles, search)
    }

    fn found<'a>(&self, contacts: &'a [Contact]) -> Found<'a> {
        Found { contacts, count: self.obstacles.count() }
    }

    fn places<'a>(&'a self, positions: &'a [R]) -> Places<'a, R> {
        Places { positions, inverse_masses: &self.inverse_mass_column, radii: self.radii() }
    }

    /// Holds the particles that lie on an obstacle after a kick with these accelerations.
    pub(crate) fn settle(
        &self,
        level: Level,
        (positions, velocities): (&[R], &mut [R]),
        (accelerations, contacts): (&[R], &[Contact]),
        kick: Kick<R>,
    ) -> Contacts {
        let (masses, places) = (&*self.mass_column, self.places(positions));
        let found = self.found(contacts);
        let kicked = Kicked { masses, places, found, velocities, accelerations, kick };
        settle(level, &self.obstacles, kicked)
    }

    /// Makes the column that bounces are computed with, where there may be any.
    pub(crate) fn prepare_bounces(&mut self) {
        if self.obstacles.bounce() {
            self.springs.sum_stiffnesses(&self.slots);
        }
    }

    /// Removes particles: no force acts on them, nothing moves them, and they have no mass.
    pub(crate) fn remove_particles(&mut self, particles: impl Iterator<Item = usize>) {
        for particle in particles {
            self.guides.release(particle);
            (self.masses[particle], self.inverse_masses[particle]) = (R::ZERO, R::ZERO);
        }
        let masses = core::mem::take(&mut self.masses);
        let is_removed = |particle: u32| masses[particle as usize] == R::ZERO;
        self.each_beside_springs(|kind, _| kind.remove(&is_removed));
        for spring in 0..self.ends().len() {
            if self.ends()[spring].into_iter().any(is_removed) {
                self.springs.cut(spring);
            }
        }
        self.shells.remove(&is_removed, &self.slots);
        self.masses = masses;
    }

    /// Removes the rows across springs that were cut.
    pub(crate) fn tear(&mut self, springs: impl Iterator<Item = usize>) {
        let torn = Torn::new(springs.map(|spring| self.springs.ends()[spring]));
        self.each_beside_springs(|kind, _| kind.tear(&torn));
    }

    /// Changes stiffness and damping of all that some bodies are made of.
    pub(crate) fn change(&mut self, rows: &Rows, change: &dyn Fn(Resists, [R; 2]) -> [R; 2]) {
        self.springs.change(rows.1.clone(), |constants| change(Resists::Stretching, constants));
        self.each_beside_springs(|kind, _| kind.change(rows, change));
    }

    /// The air that acts on surfaces, if there is any.
    pub fn air(&self) -> Option<&Air> {
        self.air.as_ref().map(AirLoads::air)
    }

    /// All elements but springs: bends, volumes, fields, grabs, pushes and user-defined
    /// ones.
    pub fn elements_beside_springs(&self) -> impl Iterator<Item = &dyn Element<R>> + '_ {
        self.kinds().skip(1).filter_map(|kind| kind.element())
    }

    /// Whether a force depends on velocity, as far as is known.
    pub(crate) fn is_damped_at_all(&self) -> bool {
        self.kinds().any(|kind| kind.is_damped())
    }

    /// The number of particles, removed ones included.
    pub fn particle_count(&self) -> usize {
        self.masses.len()
    }

    /// The number of springs that are there.
    pub fn spring_count(&self) -> usize {
        self.springs.count()
    }

    /// Masses, kilograms; 0 for a particle that was removed.
    pub fn masses(&self) -> &[R] {
        &self.masses
    }

    /// Reciprocal masses, per kilogram; 0 for a pinned particle.
    pub fn inverse_masses(&self) -> &[R] {
        &self.inverse_masses
    }

    /// Whether a particle is pinned.
    pub fn is_pinned(&self, particle: usize) -> bool {
        self.inverse_masses[particle] == R::ZERO
    }

    /// Whether a particle was removed.
    pub fn is_removed(&self, particle: usize) -> bool {
        self.masses[particle] == R::ZERO
    }

    /// The springs.
    pub fn springs(&self) -> &Springs<R> {
        &self.springs
    }

    /// The two particles of each spring, cut or not.
    pub fn ends(&self) -> &[[u32; 2]] {
        self.springs.ends()
    }

    /// Whether a spring is cut.
    pub fn is_cut(&self, spring: usize) -> bool {
        self.springs.is_cut(spring)
    }

    /// Rest lengths, metres.
    pub fn rest_lengths(&self) -> &[R] {
        self.springs.rest_lengths()
    }

    /// Stiffness of a spring, newtons per metre.
    pub fn stiffness(&self, spring: usize) -> R {
        self.springs.law(spring).stiffness
    }

    /// Damping of a spring, newton seconds per metre.
    pub fn damping(&self, spring: usize) -> R {
        self.springs.law(spring).damping
    }

    /// Whether any spring, bend or volume has a damper.
    pub fn is_damped(&self) -> bool {
        self.inner().into_iter().any(|kind| kind.is_damped())
    }

    /// The bends.
    pub fn bends(&self) -> &Bends<R> {
        &self.bends
    }

    /// The volumes.
    pub fn volumes(&self) -> &Volumes<R> {
        &self.volumes
    }

    /// The inputs of the rows of shells at a time, beside positions and velocities.
    pub(crate) fn shells_at(&self, level: Level, time: f64) -> At<'_, R> {
        let Model { shells, obstacles, inverse_mass_column, .. } = self;
        At { level, shells, obstacles, inverse_masses: inverse_mass_column, time }
    }

    /// Whether any bodies meet each other or themselves.
    pub fn do_bodies_meet(&self) -> bool {
        self.shells.do_meet()
    }

    /// The surfaces, ropes and points that do not cross each other.
    pub fn shells(&self) -> &[Shell] {
        self.shells.rows()
    }

    /// The planes.
    pub fn planes(&self) -> &[PlaneColumn<R>] {
        &self.obstacles.planes
    }

    /// The solids.
    pub fn solids(&self) -> &[Solid] {
        &self.obstacles.solids
    }

    /// All obstacles, the planes first.
    pub fn obstacles(&self) -> &Obstacles<R> {
        &self.obstacles
    }

    /// The current guides of pinned particles.
    pub fn guides(&self) -> impl Iterator<Item = &Guide> {
        self.guides.0.iter().filter(|(_, guides)| *guides).map(|(guide, _)| guide)
    }

    /// The number of guides, whenever they guide, and that of user-defined elements.
    pub fn guide_and_own_counts(&self) -> [usize; 2] {
        [self.guides.0.len(), self.own.0.len()]
    }

    /// The forces of the next step on single particles, newtons.
    pub fn pushes(&self) -> &[(u32, R::Vec3)] {
        &self.pushes.0
    }

    /// The active grabs.
    pub fn grabs(&self) -> &[Grab<R>] {
        &self.grabs.0
    }

    /// Gravitational acceleration, metres per second squared.
    pub fn gravity(&self) -> R::Vec3 {
        self.fields.gravity
    }

    /// The uniform force on every particle, newtons.
    pub fn force(&self) -> R::Vec3 {
        self.fields.force
    }

    /// Air drag, newton seconds per metre.
    pub fn drag(&self) -> R {
        self.fields.drag
    }

    /// Bound of every coordinate, metres.
    pub fn extent(&self) -> R {
        self.extent
    }

    /// Size of the largest body at the start of the scene, metres: the diagonal of the box around
    /// it. Where that is 0 it is the longest rest length, and 1 where that is 0 too. Errors and
    /// tolerances are given as fractions of it.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The named parts.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }
}
