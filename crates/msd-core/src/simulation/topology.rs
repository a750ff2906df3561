//! Changes of topology: particles, springs, bodies and planes, added to a running system or
//! removed, and which shells meet.
//!
//! Particles, springs and bodies keep their numbers for good. New ones are numbered after those
//! there, and the springs are put in order anew; a removed one leaves a gap.

use super::Simulation;
use super::compiled::Compiled;
use crate::contact::shells::ShellRows;
use crate::error::Error;
use crate::number::{Real, Vector};
use crate::obstacles::PlaneColumn;
use crate::scene::check::{
    MAX_PARTICLES, check_body, check_count, check_index, check_joints, check_particle, check_plane,
    check_shells,
};
use crate::scene::{Body, Part, Particle, Plane, Scene, Shell, Spring};
use crate::system::Columns;
use alloc::vec;
use alloc::vec::Vec;

impl<R: Real> Simulation<R> {
    /// Adds a particle; returns its number.
    ///
    /// # Errors
    /// A number out of its domain; nothing is added then.
    pub fn add_particle(&mut self, particle: Particle) -> Result<usize, Error> {
        let number = self.model.particle_count();
        let rows = Scene { particles: vec![particle], ..Scene::default() };
        self.add_rows(&rows, None)?;
        Ok(number)
    }

    /// Adds a spring; returns its number.
    ///
    /// # Errors
    /// An end that is out of range or a number out of its domain; nothing is added then.
    pub fn add_spring(&mut self, spring: Spring) -> Result<usize, Error> {
        let number = self.model.ends().len();
        let rows = Scene { springs: vec![spring], ..Scene::default() };
        self.add_rows(&rows, None)?;
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
        scene.particles.drain(..particles);
        self.add_rows(&scene, body)?;
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

    /// Removes a body: its particles, and the elements that join them. Its number and name stay.
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

    /// Replaces the shells and discards their impulses.
    ///
    /// # Errors
    /// A number out of its domain, or a method that lets no shells meet; nothing is changed then.
    pub fn set_shells(&mut self, rows: &[Shell]) -> Result<(), Error> {
        check_shells(rows, self.model.particle_count())?;
        self.settings.integrator.check_shells(rows)?;
        self.model.set_shells(rows.to_vec());
        self.rows = ShellRows::default();
        self.start_shells();
        self.renew_scratch();
        Ok(())
    }

    /// Lets shells that cross each other be pushed apart.
    pub(super) fn start_shells(&mut self) {
        let springs = self.model.springs.present().map(|(_, ends)| ends);
        let at = self.model.shells_at(self.level, self.time());
        self.rows.start(&at, &self.state.positions, springs);
    }

    fn take_out(&mut self, particles: core::ops::Range<usize>) {
        self.model.remove_particles(particles.clone());
        for particle in particles {
            let at = self.model.slots.at(particle);
            let (position, _) = self.state.get(at);
            self.state.put(at, (position, R::Vec3::ZERO));
        }
        self.model.renew_masses();
        self.rows = ShellRows::default();
        self.scratch.warm = false;
    }

    /// Adds the particles, springs, bends and volumes of a scene, which name particles by the
    /// numbers that they get here, and puts all springs in order anew.
    fn add_rows(&mut self, rows: &Scene, body: Option<Body>) -> Result<(), Error> {
        let (model, before) = (&self.model, self.model.particle_count());
        let count = before + rows.particles.len();
        check_count("the number of particles", count, MAX_PARTICLES)?;
        let joints = [model.springs.ends().len(), model.bends.count(), model.volumes.count()];
        check_joints::<R>(rows, joints, count)?;
        for (row, particle) in (before..).zip(&rows.particles) {
            check_particle::<R>(row, particle, model.extent.to_f64())?;
        }
        let mut state = self.state();
        let model = &mut self.model;
        for particle in &rows.particles {
            let mass = R::of(particle.mass);
            model.masses.push(mass);
            model.inverse_masses.push(R::ONE / mass);
            state.positions.push(R::Vec3::of(particle.position));
            state.velocities.push(R::Vec3::of(particle.velocity));
        }
        // Before the springs are put in order: a body has a block of its own.
        model.air.iter_mut().zip(&body).for_each(|(air, body)| air.add(body));
        model.bodies.extend(body);
        let bodies: Vec<_> = model.bodies.iter().map(|body| body.particles.clone()).collect();
        model.springs.add(&rows.springs);
        model.slots = model.springs.order(model.masses.len(), &bodies);
        model.add_rows(rows);
        self.state = Columns::of(&self.model.slots, &state, 0);
        self.good = Columns::new(&self.model.slots, 2);
        self.rows.forget();
        self.renew_scratch();
        (Compiled::of_precision().leave_obstacles)(self);
        Ok(())
    }
}
