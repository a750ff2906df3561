//! The visible parts of a scene for other programs: the surfaces of its bodies, and lines and
//! points where there is none.

use crate::on;
use crate::runner::Runner;
use msd_core::{Body, Real, Simulation, Surface};
use std::ops::Range;

/// The visible parts of a scene.
#[derive(Debug)]
pub struct Skin {
    /// The bodies in the order of the scene, then the particles and springs that belong to none.
    pub parts: Vec<Part>,
    /// The particles that are seen, in ascending order.
    pub particles: Vec<usize>,
}

/// A body, or the particles and springs that belong to none.
#[derive(Debug)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// The number of the body that it is.
    pub body: Option<usize>,
    /// Its visible form.
    pub form: Form,
}

/// Visible form of a part; the numbers are of particles of the scene.
#[derive(Debug)]
pub enum Form {
    /// Triangles.
    Surface(Surface),
    /// Springs.
    Lines(Vec<[u32; 2]>),
    /// Particles.
    Points(Vec<u32>),
}

impl Skin {
    /// The visible parts of a run in its current state, without removed particles and cut springs.
    /// A surface stays whole where springs under it are cut.
    pub fn of(runner: &Runner) -> Self {
        on!(runner, simulation => Skin::read(simulation))
    }

    fn read<R: Real>(simulation: &Simulation<R>) -> Self {
        let model = simulation.model();
        let bodies = model.bodies();
        let lines = |springs: Range<usize>| {
            let there = springs.filter(|&spring| !model.is_cut(spring));
            there.map(|spring| model.ends()[spring]).collect::<Vec<_>>()
        };
        let is_there = |particle: &u32| !model.is_removed(*particle as usize);
        let form = |body: &Body| {
            let springs = || lines(body.springs.clone());
            let particles = body.particles.start as u32..body.particles.end as u32;
            match &body.surface {
                surface if !surface.triangles.is_empty() => Form::Surface(surface.clone()),
                _ if body.springs.is_empty() => Form::Points(particles.filter(is_there).collect()),
                _ => Form::Lines(springs()),
            }
        };
        let part = |(number, body): (usize, &Body)| Part {
            name: body.name.clone(),
            body: Some(number),
            form: form(body),
        };
        let mut parts: Vec<Part> = bodies.iter().enumerate().map(part).collect();
        let ends = bodies.last().map_or([0, 0], |body| [body.particles.end, body.springs.end]);
        let links = lines(ends[1]..model.spring_count());
        if !links.is_empty() {
            parts.push(Part { name: "links".into(), body: None, form: Form::Lines(links) });
        }
        let alone = ends[0] as u32..model.particle_count() as u32;
        let alone: Vec<u32> = alone.filter(is_there).collect();
        if !alone.is_empty() {
            parts.push(Part { name: "particles".into(), body: None, form: Form::Points(alone) });
        }
        parts.retain(|part| !part.form.particles().is_empty());
        let mut seen = vec![false; model.particle_count()];
        let particles = parts.iter().flat_map(|part| part.form.particles());
        particles.for_each(|particle| seen[particle as usize] = true);
        let particles = (0..seen.len()).filter(|&particle| seen[particle]).collect();
        Skin { parts, particles }
    }

    /// The place of each particle of the scene among those that are seen.
    pub fn places(&self) -> Vec<u32> {
        let mut places = vec![u32::MAX; self.particles.last().map_or(0, |last| last + 1)];
        for (place, &particle) in self.particles.iter().enumerate() {
            places[particle] = place as u32;
        }
        places
    }
}

impl Form {
    /// The particle of each vertex: of a surface those of its corners.
    pub fn particles(&self) -> Vec<u32> {
        match self {
            Form::Surface(surface) => {
                surface.corners.iter().map(|corner| corner.particle).collect()
            }
            Form::Lines(lines) => {
                let mut ends = lines.concat();
                ends.sort_unstable();
                ends.dedup();
                ends
            }
            Form::Points(points) => points.clone(),
        }
    }
}

/// The positions of all particles, metres; those of single precision convert exactly.
pub fn positions(runner: &Runner) -> Vec<[f64; 3]> {
    use msd_core::Vector;
    on!(runner, simulation => {
        simulation.positions().map(|position| position.to_f64().to_array()).collect()
    })
}

/// The velocities of all particles, metres per second.
pub fn velocities(runner: &Runner) -> Vec<[f64; 3]> {
    use msd_core::Vector;
    on!(runner, simulation => {
        simulation.velocities().map(|velocity| velocity.to_f64().to_array()).collect()
    })
}

/// The position of each particle that is seen, metres, single precision.
pub fn seen_positions<'a>(
    runner: &Runner,
    particles: &'a [usize],
) -> impl Iterator<Item = [f32; 3]> + use<'a> {
    let all = positions(runner);
    particles.iter().map(move |&particle| all[particle].map(|component| component as f32))
}
