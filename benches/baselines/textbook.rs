//! The textbook: arrays of structs, a loop over springs, the formulas as they are printed, in f32.

use msd::core::{Particle, Scene, Settings, Spring};

/// A particle as a textbook would store it.
struct TextbookParticle {
    position: [f32; 3],
    velocity: [f32; 3],
    force: [f32; 3],
    inverse_mass: f32,
}

/// A spring as a textbook would store it.
struct TextbookSpring {
    ends: [usize; 2],
    rest_length: f32,
    stiffness: f32,
    damping: f32,
}

/// A system as a textbook would step it: symplectic Euler, and a floor that returns no speed.
pub struct Textbook {
    particles: Vec<TextbookParticle>,
    springs: Vec<TextbookSpring>,
    gravity: f32,
    floor: f32,
    h: f32,
    substeps: u32,
}

impl Textbook {
    /// Makes a scene ready whose masses are one and whose only plane is a floor.
    pub fn new(scene: &Scene, settings: Settings) -> Self {
        let particle = |row: &Particle| TextbookParticle {
            position: row.position.as_vec3().to_array(),
            velocity: row.velocity.as_vec3().to_array(),
            force: [0.0; 3],
            inverse_mass: 1.0,
        };
        let spring = |row: &Spring| TextbookSpring {
            ends: row.ends,
            rest_length: row.rest_length as f32,
            stiffness: row.stiffness as f32,
            damping: row.damping as f32,
        };
        let mut particles: Vec<_> = scene.particles.iter().map(particle).collect();
        scene.pins.iter().for_each(|pin| particles[pin.particle].inverse_mass = 0.0);
        Textbook {
            particles,
            springs: scene.springs.iter().map(spring).collect(),
            gravity: scene.world.gravity.y as f32,
            floor: scene.planes[0].offset as f32,
            h: settings.substep() as f32,
            substeps: settings.substeps,
        }
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        for _ in 0..self.substeps {
            self.particles.iter_mut().for_each(|p| p.force = [0.0, self.gravity, 0.0]);
            self.add_spring_forces();
            self.move_particles();
        }
    }

    fn add_spring_forces(&mut self) {
        let particles = &mut self.particles;
        for spring in &self.springs {
            let [a, b] = spring.ends;
            let (from, to) = (&particles[a], &particles[b]);
            let across = [0, 1, 2].map(|i| to.position[i] - from.position[i]);
            let length = across.iter().map(|d| d * d).sum::<f32>().sqrt();
            let unit = across.map(|d| d / length);
            let rate: f32 = (0..3).map(|i| (to.velocity[i] - from.velocity[i]) * unit[i]).sum();
            let pull = spring.stiffness * (length - spring.rest_length) + spring.damping * rate;
            for (i, unit) in unit.into_iter().enumerate() {
                particles[a].force[i] += pull * unit;
                particles[b].force[i] -= pull * unit;
            }
        }
    }

    fn move_particles(&mut self) {
        for particle in &mut self.particles {
            for i in 0..3 {
                particle.velocity[i] += particle.force[i] * particle.inverse_mass * self.h;
                particle.position[i] += particle.velocity[i] * self.h;
            }
            if particle.position[1] < self.floor {
                particle.position[1] = self.floor;
                particle.velocity[1] = particle.velocity[1].max(0.0);
            }
        }
    }
}
