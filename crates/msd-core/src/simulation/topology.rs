//! Changes of topology: particles, springs, bodies and planes, added to a running system or
//! removed, and which particles touch.
//!
//! Particles, springs and bodies keep their numbers for good. New ones are numbered after those
//! there, and the springs are put in order anew; a removed one leaves a gap.

use super::Simulation;
use crate::elements::touches::Touches;
use crate::elements::touches::near::Near;
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::obstacles::PlaneColumn;
use crate::scene::check::{
    check_bend, check_body, check_count, check_index, check_particle, check_plane, check_spring,
    check_touches, check_volume,
};
use crate::scene::{Bend, Body, Part, Particle, Plane, Scene, Spring, Touch, Volume};
use crate::scene::{MAX_PARTICLES, MAX_SPRINGS};
use crate::system::{Columns, State};

/// Rows that join particles.
#[derive(Clone, Copy, Default)]
struct Joints<'a> {
    springs: &'a [Spring],
    bends: &'a [Bend],
    volumes: &'a [Volume],
}

impl<R: Real> Simulation<R> {
    /// Adds a particle; returns its number.
    ///
    /// # Errors
    /// A number out of its domain; nothing is added then.
    pub fn add_particle(&mut self, particle: Particle) -> Result<usize, Error> {
        let number = self.model.particle_count();
        self.add_rows(&[particle], Joints::default(), None)?;
        Ok(number)
    }

    /// Adds a spring; returns its number.
    ///
    /// # Errors
    /// An end that is out of range or a number out of its domain; nothing is added then.
    pub fn add_spring(&mut self, spring: Spring) -> Result<usize, Error> {
        let number = self.model.ends().len();
        self.add_rows(&[], Joints { springs: &[spring], ..Joints::default() }, None)?;
        Ok(number)
    }

    /// Adds a part as a named body; returns the number of the body.
    ///
    /// # Errors
    /// A row that is out of its domain; nothing is added then.
    pub fn add_body(&mut self, name: &str, part: Part) -> Result<usize, Error> {
        let (particles, springs) = (self.model.particle_count(), self.model.ends().len());
        // Numbered from those there on, by the same function that builds scenes.
        let mut scene = Scene::default();
        let blank =
            Particle { position: Default::default(), velocity: Default::default(), mass: 1.0 };
        scene.particles.resize(particles, blank);
        scene.add(name, part);
        check_body(0, &scene.bodies[0], &scene)?;
        let body = scene
            .bodies
            .pop()
            .map(|body| Body { springs: springs..springs + scene.springs.len(), ..body });
        let Scene { springs, bends, volumes, .. } = &scene;
        let joints = Joints { springs, bends, volumes };
        self.add_rows(&scene.particles[particles..], joints, body)?;
        Ok(self.model.bodies.len() - 1)
    }

    /// Removes a particle, its bends and volumes, and cuts its springs.
    ///
    /// # Errors
    /// A number that names nothing.
    pub fn remove_particle(&mut self, particle: usize) -> Result<(), Error> {
        check_index(("removal", 0), "particle", particle, self.model.particle_count())?;
        self.take_out(particle..particle + 1);
        Ok(())
    }

    /// Cuts a spring for good, and removes the bends and volumes across it.
    ///
    /// # Errors
    /// A number that names nothing.
    pub fn remove_spring(&mut self, spring: usize) -> Result<(), Error> {
        check_index(("removal", 0), "spring", spring, self.model.ends().len())?;
        self.model.springs.cut(spring);
        self.model.tear(core::iter::once(spring));
        self.scratch.warm = false;
        Ok(())
    }

    /// Removes a body: its particles, and what joins them. Its number and name stay.
    ///
    /// # Errors
    /// A number that names nothing.
    pub fn remove_body(&mut self, body: usize) -> Result<(), Error> {
        check_index(("removal", 0), "body", body, self.model.bodies.len())?;
        self.take_out(self.model.bodies[body].particles.clone());
        self.model.bodies[body].surface = Default::default();
        Ok(())
    }

    /// Adds a plane and moves out the particles inside it; returns its place among the planes.
    ///
    /// # Errors
    /// A number out of its domain, or a particle that it pushes out of the world; nothing is added
    /// then.
    pub fn add_plane(&mut self, plane: &Plane) -> Result<usize, Error> {
        let number = self.model.planes().len();
        check_plane::<R>(number, plane)?;
        self.add_to_obstacles(|obstacles| obstacles.planes.push(PlaneColumn::new(plane)))?;
        Ok(number)
    }

    /// Replaces how particles touch: the rows, and the pairs that do not touch beside those that
    /// springs join, as [`Scene::touches`] and [`Scene::exempt`] have them.
    ///
    /// # Errors
    /// A number out of its domain, or particles of which too many are within reach of each other;
    /// nothing is changed then.
    pub fn set_touches(&mut self, rows: &[Touch], exempt: &[[usize; 2]]) -> Result<(), Error> {
        check_touches::<R>((rows, exempt), self.model.particle_count())?;
        let (ends, slots) = (self.model.springs.ends(), &self.model.slots);
        let mut touches = Touches::new(rows, exempt, ends, slots);
        touches.remove(|particle| self.model.is_removed(particle as usize), ends, slots);
        Near::check(&touches, &self.state.positions)?;
        self.model.touches = touches;
        self.model.renew_radii();
        self.renew_scratch();
        Ok(())
    }

    fn take_out(&mut self, particles: core::ops::Range<usize>) {
        self.model.remove_particles(particles.clone());
        for particle in particles {
            let at = self.model.slots.at(particle);
            let (position, _) = self.state.get(at);
            self.state.put(at, (position, R::Vec3::ZERO));
        }
        self.model.renew_masses();
        self.scratch.work.near.forget();
        self.scratch.warm = false;
    }

    /// Adds rows, and puts all springs in order anew.
    fn add_rows(
        &mut self,
        particles: &[Particle],
        joints: Joints<'_>,
        body: Option<Body>,
    ) -> Result<(), Error> {
        let Joints { springs, bends, volumes } = joints;
        let count = self.model.particle_count() + particles.len();
        check_count("the number of particles", count, MAX_PARTICLES)?;
        let spring_count = self.model.ends().len() + springs.len();
        check_count("the number of springs", spring_count, MAX_SPRINGS)?;
        for (row, particle) in particles.iter().enumerate() {
            let row = self.model.particle_count() + row;
            check_particle::<R>(row, particle, self.model.extent.to_f64())?;
        }
        for (row, spring) in springs.iter().enumerate() {
            check_spring::<R>(self.model.ends().len() + row, spring, count)?;
        }
        check_count("the number of bends", self.model.bends.count() + bends.len(), MAX_SPRINGS)?;
        for (row, bend) in bends.iter().enumerate() {
            check_bend::<R>(row, bend, count)?;
        }
        let volume_count = self.model.volumes.count() + volumes.len();
        check_count("the number of volumes", volume_count, MAX_PARTICLES)?;
        for (row, volume) in volumes.iter().enumerate() {
            check_volume::<R>(row, volume, count)?;
        }
        let mut state = self.state();
        for particle in particles {
            let mass = R::of(particle.mass);
            self.model.masses.push(mass);
            self.model.inverse_masses.push(R::ONE / mass);
            state.positions.push(R::Vec3::of(particle.position));
            state.velocities.push(R::Vec3::of(particle.velocity));
        }
        // Before the springs are put in order: a body has a block of its own.
        self.model.air.iter_mut().zip(&body).for_each(|(air, body)| air.add(body));
        self.model.bodies.extend(body);
        self.order_anew(joints, &state);
        Ok(())
    }

    fn order_anew(&mut self, joints: Joints<'_>, state: &State<R>) {
        let model = &mut self.model;
        let bodies: alloc::vec::Vec<_> =
            model.bodies.iter().map(|body| body.particles.clone()).collect();
        model.slots = model.springs.add(model.masses.len(), joints.springs, &bodies);
        model.bends.add(joints.bends, &model.slots);
        model.volumes.add(joints.volumes, &model.slots);
        model.touches.order(model.springs.ends(), &model.slots);
        model.make_columns();
        self.state = Columns::of(&self.model.slots, state, 0);
        self.good = Columns::new(&self.model.slots, 2);
        self.renew_scratch();
        self.leave_obstacles();
    }
}
