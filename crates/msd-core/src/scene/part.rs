//! Parts: bodies before they join a scene, as rows that count from zero.

use crate::scene::look::Look;
use crate::scene::surface::Surface;
use crate::scene::{Bend, Body, Particle, Scene, Spring, Volume};
use alloc::string::String;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// The material of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Mass of each particle, kilograms. Default 1.
    pub mass: f64,
    /// Stiffness of each spring, newtons per metre. Default 1000.
    pub stiffness: f64,
    /// Damping of each spring, newton seconds per metre. Default 0.
    pub damping: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self { mass: 1.0, stiffness: 1000.0, damping: 0.0 }
    }
}

/// Rows of one body; indices count from its own first particle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// The particles.
    pub particles: Vec<Particle>,
    /// The springs.
    pub springs: Vec<Spring>,
    /// The bends.
    pub bends: Vec<Bend>,
    /// The volumes.
    pub volumes: Vec<Volume>,
    /// Its surface.
    pub surface: Surface,
}

impl Part {
    /// The centre of mass, metres; the origin if there is no mass.
    pub fn centre(&self) -> DVec3 {
        let mass: f64 = self.particles.iter().map(|p| p.mass).sum();
        let moment: DVec3 = self.particles.iter().map(|p| p.position * p.mass).sum();
        if mass == 0.0 { DVec3::ZERO } else { moment / mass }
    }

    /// Turns and then moves every position: x becomes `rotation` x + `offset`.
    pub fn place(&mut self, rotation: DMat3, offset: DVec3) {
        for particle in &mut self.particles {
            particle.position = rotation * particle.position + offset;
        }
    }

    /// Sets velocities: `velocity` plus the turn `spin`, radians per second, about the centre.
    pub fn set_motion(&mut self, velocity: DVec3, spin: DVec3) {
        let centre = self.centre();
        for particle in &mut self.particles {
            particle.velocity = velocity + spin.cross(particle.position - centre);
        }
    }
}

impl Scene {
    /// Appends a part as a named body and returns the index of the body.
    pub fn add(&mut self, name: impl Into<String>, part: Part) -> usize {
        let (first, first_spring) = (self.particles.len(), self.springs.len());
        let Part { particles, mut springs, mut bends, mut volumes, mut surface } = part;
        // An index too large to be moved is out of range either way; the check of the scene reports
        // it.
        let later = |particle: usize| particle.saturating_add(first);
        springs.iter_mut().for_each(|spring| spring.ends = spring.ends.map(later));
        bends.iter_mut().for_each(|bend| bend.particles = bend.particles.map(later));
        volumes.iter_mut().for_each(|volume| volume.particles = volume.particles.map(later));
        append(&mut self.particles, particles);
        append(&mut self.springs, springs);
        append(&mut self.bends, bends);
        append(&mut self.volumes, volumes);
        let first_corner = u32::try_from(first).unwrap_or(u32::MAX);
        for corner in &mut surface.corners {
            corner.particle = corner.particle.saturating_add(first_corner);
        }
        self.bodies.push(Body {
            name: name.into(),
            particles: first..self.particles.len(),
            springs: first_spring..self.springs.len(),
            look: Look::of(&surface),
            surface,
        });
        self.bodies.len() - 1
    }
}

/// Appends rows, without a copy where they are the first.
fn append<T>(to: &mut Vec<T>, mut rows: Vec<T>) {
    if to.is_empty() {
        *to = rows;
    } else {
        to.append(&mut rows);
    }
}
