//! The model: masses, springs, fields and obstacles of a system, as columns that a step reads.

use super::state::{Columns, State};
use crate::columns::slots::Slots;
use crate::columns::{Aligned, LANES, single};
use crate::elements::air::AirLoads;
use crate::elements::bends::Bends;
use crate::elements::fields::Fields;
use crate::elements::grabs::{Grab, Grabs, Pushes};
use crate::elements::springs::Springs;
use crate::elements::touches::{self, Touches, near::Near, tangent::TouchTangents};
use crate::elements::volumes::Volumes;
use crate::elements::{Element, ForceWork, Motion, Own, Vectors, column};
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::obstacles::resolve::{Bodies, Substep, resolve};
use crate::obstacles::rest::{Kick, Kicked, Places, is_any_on, settle};
use crate::obstacles::springs::Points;
use crate::obstacles::{Contacts, Obstacles, PlaneColumn, Radii};
use crate::scene::check::{
    check, check_air, check_bend, check_mass, check_not_negative, check_scene, check_vector,
    check_volume, is_finite,
};
use crate::scene::{Body, Particle, Scene, Solid};
use alloc::vec::Vec;
use fearless_simd::Level;
use glam::DVec3;

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
    /// Radii against obstacles, metres: of each slot, empty where none counts, and the largest.
    radii: (Aligned<R>, R),
    /// Contact points on springs.
    points: Points,
    pub(crate) fields: Fields<R>,
    pub(crate) springs: Springs<R>,
    pub(crate) bends: Bends<R>,
    pub(crate) volumes: Volumes<R>,
    pub(crate) touches: Touches,
    pub(crate) grabs: Grabs<R>,
    pub(crate) pushes: Pushes<R>,
    /// The air on surfaces; none in a scene without air.
    pub(crate) air: Option<AirLoads>,
    /// User-defined elements, each with its handle.
    pub(crate) own: Vec<(usize, Own)>,
    pub(crate) obstacles: Obstacles<R>,
    pub(crate) extent: R,
    pub(crate) size: f64,
    pub(crate) bodies: Vec<Body>,
}

impl<R: Real> Model<R> {
    /// Checks a scene and turns its rows into columns.
    ///
    /// # Errors
    /// The first row that is out of its domain in precision `R`: a mass that is not positive, a
    /// number that is not finite, an index that names nothing, a spring from a particle to itself.
    pub(crate) fn new(scene: &Scene) -> Result<(Self, State<R>), Error> {
        check_scene::<R>(scene)?;
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
        let (slots, springs) = Springs::new(masses.len(), &scene.springs, &bodies);
        let bends = Bends::new(&scene.bends, &slots);
        let volumes = Volumes::new(&scene.volumes, &slots);
        let touches = Touches::new(&scene.touches, &scene.exempt, springs.ends(), &slots);
        let mut model = Model {
            masses,
            inverse_masses,
            mass_column: Aligned::default(),
            inverse_mass_column: Aligned::default(),
            radii: (Aligned::default(), R::ZERO),
            points: Points::default(),
            fields: Fields {
                gravity: R::Vec3::of(scene.world.gravity),
                force: R::Vec3::of(scene.world.force),
                drag: R::of(scene.world.drag),
                weights: Aligned::default(),
            },
            springs,
            bends,
            volumes,
            touches,
            grabs: Grabs::default(),
            pushes: Pushes::default(),
            air: scene.world.air.as_ref().map(|air| AirLoads::new(air, &scene.bodies)),
            own: Vec::new(),
            obstacles: Obstacles {
                planes: scene.planes.iter().map(PlaneColumn::new).collect(),
                solids: scene.solids.clone(),
                own: Vec::new(),
            },
            extent: R::of(scene.world.extent),
            size: size(scene),
            bodies: scene.bodies.clone(),
            slots,
        };
        model.make_columns();
        if !model.touches.is_empty() {
            let columns = Columns::of(&model.slots, &state, 0);
            Near::check(&model.touches, &columns.positions)?;
        }
        Ok((model, state))
    }

    /// Where the numbers of each particle are in the columns.
    #[doc(hidden)]
    pub fn slots(&self) -> &Slots {
        &self.slots
    }

    /// Makes the columns in the order of slots.
    pub(crate) fn make_columns(&mut self) {
        self.mass_column = Aligned::new(self.slots.record_count() * LANES, 12);
        self.inverse_mass_column = column(&self.slots, 13);
        self.fields.weights = column(&self.slots, 14);
        self.renew_masses();
        self.renew_radii();
        self.points = Points::new(&self.obstacles.solids, &self.springs, &self.slots);
    }

    /// Updates the radii that count against obstacles for changed touches.
    pub(crate) fn renew_radii(&mut self) {
        self.radii = self.touches.radii_at_obstacles(&self.slots);
    }

    /// The radii that count against obstacles.
    pub(crate) fn radii(&self) -> Radii<'_, R> {
        Radii { column: &self.radii.0, largest: self.radii.1 }
    }

    /// Updates the columns for changed masses, pins and fields.
    pub(crate) fn renew_masses(&mut self) {
        let rows = self.slots.places().zip(self.masses.iter().zip(&self.inverse_masses));
        for (at, (&mass, &inverse_mass)) in rows {
            self.mass_column[single(at)] = mass;
            for axis in 0..3 {
                self.inverse_mass_column[at + axis * LANES] = inverse_mass;
            }
        }
        self.fields.weigh(&self.mass_column);
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
        let power = power + self.springs.add_all(level, motion, &mut work.springs, forces);
        let power = power + self.bends.add_all(level, motion, forces);
        let power = power + self.volumes.add_all(level, motion, forces);
        let power = power + self.add_touches(level, motion, &mut work.near, forces);
        power + self.add_single_forces(motion, work, forces)
    }

    /// Adds the forces of particles that touch, and returns the power that they dissipate.
    pub(crate) fn add_touches(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        near: &mut Near<R>,
        forces: &mut [R],
    ) -> f64 {
        if self.touches.is_empty() {
            return 0.0;
        }
        let listed = near.nearby(level, &self.touches, motion.positions);
        touches::add_forces(listed, motion, &self.inverse_mass_column, forces)
    }

    /// Overwrites `to` with the derivatives of what touches.
    pub(crate) fn set_touching(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        near: &mut Near<R>,
        to: &mut TouchTangents,
    ) {
        to.clear();
        if !self.touches.is_empty() {
            let listed = near.nearby(level, &self.touches, motion.positions);
            touches::add_tangents(listed, motion, &self.inverse_mass_column, to);
        }
    }

    /// Overwrites `forces` with all forces but those of springs, bends, volumes and touches.
    pub(crate) fn set_other_forces(
        &self,
        level: Level,
        motion: &Motion<'_, R>,
        work: &mut ForceWork<R>,
        forces: &mut [R],
    ) -> f64 {
        let power = self.fields.set_forces(level, motion.velocities, forces);
        power + self.add_single_forces(motion, work, forces)
    }

    /// Adds grabs, pushes, the air and user-defined elements.
    fn add_single_forces(
        &self,
        motion: &Motion<'_, R>,
        work: &mut ForceWork<R>,
        numbers: &mut [R],
    ) -> f64 {
        let mut forces = Vectors { slots: &self.slots, numbers };
        self.grabs.add_forces(motion, &mut forces);
        self.pushes.add_forces(motion, &mut forces);
        let own = self.drivers().map(|element| element.add_forces(motion, &mut forces));
        work.own_power = own.sum();
        work.own_power
    }

    /// Lets every particle that has come into an obstacle meet it, and every contact point, at the
    /// end of a substep.
    pub(crate) fn resolve(
        &self,
        level: Level,
        state: &mut Columns<R>,
        forces: &[R],
        substep: Substep<'_, R>,
    ) -> Contacts {
        let contacts = resolve(level, &self.obstacles, self.ending(state, forces, substep));
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
        }
    }

    /// Whether a particle at these positions is on an obstacle at a time, seconds; `are_far`: none
    /// is near a solid.
    pub(crate) fn is_any_on(
        &self,
        level: Level,
        (positions, are_far): (&[R], bool),
        time: f64,
    ) -> bool {
        is_any_on(level, &self.obstacles, self.places(positions), (time, are_far))
    }

    fn places<'a>(&'a self, positions: &'a [R]) -> Places<'a, R> {
        Places { positions, inverse_masses: &self.inverse_mass_column, radii: self.radii() }
    }

    /// Holds the particles that lie on an obstacle after a kick with these accelerations.
    pub(crate) fn settle(
        &self,
        level: Level,
        (positions, velocities): (&[R], &mut [R]),
        accelerations: &[R],
        kick: Kick<R>,
    ) -> Contacts {
        let (masses, places) = (&*self.mass_column, self.places(positions));
        let kicked = Kicked { masses, places, velocities, accelerations, kick };
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
            (self.masses[particle], self.inverse_masses[particle]) = (R::ZERO, R::ZERO);
        }
        let Model { masses, slots, springs, bends, volumes, touches, grabs, pushes, air, .. } =
            self;
        let is_removed = |particle: u32| masses[particle as usize] == R::ZERO;
        grabs.0.retain(|grab| !is_removed(grab.particle));
        pushes.0.retain(|push| !is_removed(push.0));
        bends.remove(is_removed);
        volumes.remove(is_removed);
        touches.remove(is_removed, springs.ends(), slots);
        air.iter_mut().for_each(|air| air.remove(is_removed));
        for spring in 0..springs.ends().len() {
            if springs.ends()[spring].into_iter().any(is_removed) {
                springs.cut(spring);
            }
        }
    }

    /// Whether a force depends on velocity, as far as is known.
    pub(crate) fn is_damped_at_all(&self) -> bool {
        let by_hand = !self.grabs.0.is_empty() || self.is_driven();
        by_hand || self.is_damped() || self.fields.drag != R::ZERO
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

    /// Whether any spring, bend or volume has a damper, or any touch one or friction.
    pub fn is_damped(&self) -> bool {
        let is_bound = self.springs.is_damped() || self.bends.is_damped();
        is_bound || self.volumes.is_damped() || self.touches.is_damped()
    }

    /// The bends.
    pub fn bends(&self) -> &Bends<R> {
        &self.bends
    }

    /// The volumes.
    pub fn volumes(&self) -> &Volumes<R> {
        &self.volumes
    }

    /// The touches.
    pub fn touches(&self) -> &Touches {
        &self.touches
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
    /// it; where that is 0 the longest rest length, and 1 where that is 0 too. Errors and
    /// tolerances are given as fractions of it.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The named parts.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Refuses the first number that another precision cannot hold.
    fn check_fits<S: Real>(&self) -> Result<(), Error> {
        for (row, mass) in self.masses.iter().enumerate().filter(|row| *row.1 != R::ZERO) {
            check_mass::<S>(("particle", row), mass.to_f64())?;
        }
        let world = ("world", 0);
        check_vector::<S>("gravity", world, self.gravity().to_f64())?;
        check_vector::<S>("force", world, self.force().to_f64())?;
        check_not_negative::<S>("drag", world, self.drag().to_f64())?;
        self.air().into_iter().try_for_each(check_air::<S>)?;
        for (row, plane) in self.planes().iter().enumerate() {
            let offset = plane.offset.to_f64();
            check(is_finite::<S>(offset), "offset", ("plane", row), offset, "finite")?;
        }
        for (row, grab) in self.grabs().iter().enumerate() {
            let at = ("grab", row);
            check_vector::<S>("target", at, grab.target.to_f64())?;
            check_not_negative::<S>("stiffness", at, grab.stiffness.to_f64())?;
            check_not_negative::<S>("damping", at, grab.damping.to_f64())?;
        }
        for (row, (_, force)) in self.pushes.0.iter().enumerate() {
            check_vector::<S>("force", ("push", row), force.to_f64())?;
        }
        for row in 0..self.ends().len() {
            let (at, law) = (("spring", row), self.springs.law(row));
            check_not_negative::<S>("rest length", at, law.rest.to_f64())?;
            check_not_negative::<S>("stiffness", at, law.stiffness.to_f64())?;
            check_not_negative::<S>("damping", at, law.damping.to_f64())?;
        }
        for (row, bend) in self.bends.rows().enumerate() {
            check_bend::<S>(row, &bend, self.particle_count())?;
        }
        for (row, volume) in self.volumes.rows().enumerate() {
            check_volume::<S>(row, &volume, self.particle_count())?;
        }
        Ok(())
    }

    /// The same model in another precision, each number rounded once.
    ///
    /// # Errors
    /// The first number that the other precision cannot hold.
    pub(crate) fn convert<S: Real>(&self) -> Result<Model<S>, Error> {
        self.check_fits::<S>()?;
        let scalar = |value: R| S::of(value.to_f64());
        let vector = |value: R::Vec3| S::Vec3::of(value.to_f64());
        let grab = |grab: &Grab<R>| Grab {
            particle: grab.particle,
            target: vector(grab.target),
            stiffness: scalar(grab.stiffness),
            damping: scalar(grab.damping),
            max_force: scalar(grab.max_force),
        };
        let plane = |plane: &PlaneColumn<R>| PlaneColumn {
            normal: vector(plane.normal),
            ..PlaneColumn::new(&plane.row())
        };
        let pushes = self.pushes.0.iter();
        // From the mass, as everywhere: a reciprocal rounded before would not fit it.
        let reciprocal = |(&w, &mass): (&R, &R)| {
            if w == R::ZERO { S::ZERO } else { S::ONE / scalar(mass) }
        };
        let mut model = Model {
            slots: self.slots.clone(),
            masses: self.masses.iter().map(|&mass| scalar(mass)).collect(),
            inverse_masses: self.inverse_masses.iter().zip(&self.masses).map(reciprocal).collect(),
            mass_column: Aligned::default(),
            inverse_mass_column: Aligned::default(),
            radii: (Aligned::default(), S::ZERO),
            points: Points::default(),
            fields: Fields {
                gravity: vector(self.gravity()),
                force: vector(self.force()),
                drag: scalar(self.drag()),
                weights: Aligned::default(),
            },
            springs: self.springs.convert(),
            bends: self.bends.convert(&self.slots),
            volumes: self.volumes.convert(&self.slots),
            touches: self.touches.clone(),
            grabs: Grabs(self.grabs().iter().map(grab).collect()),
            pushes: Pushes(pushes.map(|&(particle, force)| (particle, vector(force))).collect()),
            air: self.air.clone(),
            own: self.own.clone(),
            obstacles: Obstacles {
                planes: self.planes().iter().map(plane).collect(),
                solids: self.solids().to_vec(),
                own: self.obstacles.own.clone(),
            },
            extent: scalar(self.extent),
            size: self.size,
            bodies: self.bodies.clone(),
        };
        model.make_columns();
        Ok(model)
    }
}

fn size(scene: &Scene) -> f64 {
    let diagonal = |particles: &[Particle]| {
        let mut positions = particles.iter().map(|particle| particle.position);
        let first = positions.next().unwrap_or_default();
        let grow = |(low, high): (DVec3, DVec3), x: DVec3| (low.min(x), high.max(x));
        let (low, high) = positions.fold((first, first), grow);
        let across = high - low;
        Real::sqrt(across.dot(across))
    };
    let bodies = scene.bodies.iter().map(|body| &scene.particles[body.particles.clone()]);
    let largest = bodies.map(diagonal).fold(0.0, f64::max);
    let whole = || diagonal(&scene.particles);
    let longest = || scene.springs.iter().map(|spring| spring.rest_length).fold(0.0, f64::max);
    let positive = |size: &f64| 0.0 < *size;
    let found = Some(largest).filter(positive).or_else(|| Some(whole()).filter(positive));
    found.or_else(|| Some(longest()).filter(positive)).unwrap_or(1.0)
}
