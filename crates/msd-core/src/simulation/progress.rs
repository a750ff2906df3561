//! Checkpoint of a run: with the rows of its scene, all that it takes to resume it to the last bit.
//!
//! A step starts from the columns of the model, the state, the settings and the queue. No method
//! keeps anything from one step to the next that changes the bits. So a run is its current scene,
//! particles moved, and a [`Progress`]. Both are in `f64`: widening a number of a run in `f32` and
//! rounding it back is exact. Springs that are cut stay in the rows, since the order of sums
//! follows from all of them. User-defined elements, obstacles and methods are not kept.

use super::compiled::Compiled;
use super::{Interaction, Simulation, step_start};
use crate::contact::shells::RowImpulse;
use crate::elements::grabs::Grab;
use crate::energy::Ledger;
use crate::error::Error;
use crate::methods::Settings;
use crate::number::{Real, Vector};
use crate::obstacles::PlaneColumn;
use crate::scene::check::{
    check, check_guides, check_index, check_not_negative, check_steps, check_vector,
};
use crate::scene::{Guide, Particle, Pin, Scene, World};
use crate::system::Model;
use crate::system::guides::Guides;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use glam::DVec3;

/// The progress of a run, and the user input that acts on it, which no scene holds. Any values;
/// checked by [`Simulation::resume`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Progress {
    /// The settings of the run.
    pub settings: Settings,
    /// Steps taken.
    pub steps: u64,
    /// Steps and time, seconds, at which the length of a step changed last.
    pub epoch: (u64, f64),
    /// Size of the largest body at the start of the scene, metres.
    pub size: f64,
    /// The active grabs.
    pub grabs: Vec<Held>,
    /// Forces of the next step on single particles, newtons.
    pub pushes: Vec<(usize, DVec3)>,
    /// The interactions queued for the start of the next step.
    pub queue: Vec<Interaction>,
    /// The energy dissipated so far.
    pub ledger: Ledger,
    /// Whether anything touched an obstacle in the last step.
    pub touched: bool,
    /// The springs that are cut.
    pub cut: Vec<usize>,
    /// The particles that were removed.
    pub removed: Vec<usize>,
    /// The impulses from which the shells start the next substep, in the order of their keys.
    pub impulses: Vec<RowImpulse>,
    /// Guides of pinned particles. Last, as runs that were saved before there were any end here.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "or_none"))]
    pub guides: Vec<Guide>,
}

impl Progress {
    /// Simulated time, seconds.
    pub fn time(&self) -> f64 {
        step_start(self.epoch, self.steps, self.settings.step)
    }
}

/// Guides, or none where the data ends.
#[cfg(feature = "serde")]
fn or_none<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<Guide>, D::Error> {
    Ok(serde::Deserialize::deserialize(deserializer).unwrap_or_default())
}

/// An active grab, weakened so that the substep can follow it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Held {
    /// The particle held.
    pub particle: usize,
    /// The point that it is pulled to, metres.
    pub target: DVec3,
    /// Stiffness, newtons per metre.
    pub stiffness: f64,
    /// Damping, newton seconds per metre.
    pub damping: f64,
    /// The largest force, newtons; infinite for a cap that single precision cannot hold.
    pub max_force: f64,
}

impl<R: Real> Simulation<R> {
    /// Sets whether anything touched an obstacle in the last step, which another machine has taken.
    pub fn set_touched(&mut self, touched: bool) {
        self.touched = touched;
    }

    /// Returns a checkpoint of the run: the current rows of its scene, and its progress.
    pub fn progress(&self) -> (Scene, Progress) {
        let grabs = self.model.grabs().iter().map(held::<R>);
        let pushes = self.model.pushes.0.iter();
        let progress = Progress {
            settings: self.settings,
            steps: self.steps,
            epoch: self.epoch,
            size: self.model.size,
            grabs: grabs.collect(),
            pushes: pushes.map(|&(particle, force)| (particle as usize, force.to_f64())).collect(),
            queue: self.queue.clone(),
            ledger: self.ledger.clone(),
            touched: self.touched,
            cut: (0..self.model.ends().len()).filter(|&row| self.model.is_cut(row)).collect(),
            removed: (0..self.model.particle_count())
                .filter(|&row| self.model.is_removed(row))
                .collect(),
            impulses: self.rows.impulses(),
            guides: self.model.guides.0.iter().map(|(guide, _)| guide.clone()).collect(),
        };
        (rows(self), progress)
    }

    /// Resumes a run from a checkpoint: its steps have the bits of a run that never stopped.
    ///
    /// In another precision each number is rounded once, as by [`Simulation::convert`].
    ///
    /// # Errors
    /// The first row or setting that is out of its domain: a scene and a progress may come from
    /// outside.
    pub fn resume(scene: &Scene, progress: &Progress) -> Result<Self, Error> {
        (Compiled::of_precision().resume)(scene, progress)
    }

    /// The body of [`Simulation::resume`].
    pub(super) fn resume_from(scene: &Scene, progress: &Progress) -> Result<Self, Error> {
        let (mut model, state) = Model::<R>::new(Cow::Borrowed(scene))?;
        check_progress::<R>(progress, [model.particle_count(), model.ends().len()])?;
        check_guides::<R>(&progress.guides, model.particle_count(), scene.solids.len())?;
        model.guides = Guides(progress.guides.iter().map(|guide| (guide.clone(), false)).collect());
        for (row, (column, plane)) in
            model.obstacles.planes.iter_mut().zip(&scene.planes).enumerate()
        {
            // A normal of length one up to rounding in single precision is kept: normalised once
            // more, it would change in the last bit.
            let squared = Vector::dot(plane.normal, plane.normal);
            let unit = Real::abs(squared - 1.0) <= 1e-6;
            check(unit, "square of the normal", ("plane", row), squared, "1")?;
            column.normal = R::Vec3::of(plane.normal);
        }
        model.size = progress.size;
        model.grabs.0 = progress.grabs.iter().map(grab::<R>).collect();
        let pushes = progress.pushes.iter();
        model.pushes.0 = pushes.map(|&(row, force)| (row as u32, R::Vec3::of(force))).collect();
        progress.cut.iter().for_each(|&spring| model.springs.cut(spring));
        if model.air.is_some() {
            // Rows have been torn, the surfaces of bodies are whole.
            model.tear(progress.cut.iter().copied());
        }
        model.remove_particles(progress.removed.iter().copied());
        model.renew_masses();
        let mut simulation = Simulation::from_parts(model, state, progress.settings)?;
        for &interaction in &progress.queue {
            simulation.queue(interaction)?;
        }
        simulation.ledger = progress.ledger.clone();
        simulation.touched = progress.touched;
        simulation.rows.set_impulses(&progress.impulses);
        (simulation.steps, simulation.epoch) = (progress.steps, progress.epoch);
        simulation.follow_guides();
        Ok(simulation)
    }
}

fn check_progress<R: Real>(
    progress: &Progress,
    [particles, springs]: [usize; 2],
) -> Result<(), Error> {
    let Progress { steps, epoch: (before, time), size, .. } = *progress;
    let at = ("run", 0);
    check_steps("number of steps", at, steps)?;
    let in_past = before <= steps;
    check(in_past, "start of the epoch", at, before as f64, "at most the number of steps")?;
    check_not_negative::<f64>("time of the epoch", at, time)?;
    check(0.0 < size && size.is_finite(), "size", at, size, "positive and finite")?;
    let dissipated = progress.ledger.dissipated();
    // NaN after steps of a graphics device, which does not measure it.
    let is_energy = !dissipated.is_infinite();
    check(is_energy, "energy taken away", at, dissipated, "finite or unknown")?;
    check_not_negative::<f64>("energy given", at, progress.ledger.given())?;
    for (row, held) in progress.grabs.iter().enumerate() {
        let at = ("grab", row);
        check_index(at, "particle", held.particle, particles)?;
        check_vector::<R>("target", at, held.target)?;
        let Held { stiffness, damping, max_force, .. } = *held;
        check_not_negative::<R>("stiffness", at, stiffness)?;
        check_not_negative::<R>("damping", at, damping)?;
        check(0.0 <= max_force, "largest force", at, max_force, "not negative")?;
    }
    for (row, &(particle, force)) in progress.pushes.iter().enumerate() {
        check_index(("push", row), "particle", particle, particles)?;
        check_vector::<R>("force", ("push", row), force)?;
    }
    for (row, &spring) in progress.cut.iter().enumerate() {
        check_index(("cut", row), "spring", spring, springs)?;
    }
    for (row, &particle) in progress.removed.iter().enumerate() {
        check_index(("removed", row), "particle", particle, particles)?;
    }
    for (row, impulse) in progress.impulses.iter().enumerate() {
        let at = ("impulse", row);
        let is_sorted = row == 0 || progress.impulses[row - 1].key < impulse.key;
        check(is_sorted, "key", at, impulse.key as f64, "above that of the row before")?;
        check_not_negative::<R>("push", at, impulse.push)?;
        check_vector::<R>("friction", at, impulse.rub)?;
    }
    Ok(())
}

/// The rows of a scene from the columns of a run.
fn rows<R: Real>(simulation: &Simulation<R>) -> Scene {
    let model = &simulation.model;
    let state = simulation.state();
    // A particle that was removed has no mass; the rows must have one.
    let mass = |mass: &R| if *mass == R::ZERO { 1.0 } else { mass.to_f64() };
    let particles = model.masses.iter().enumerate().map(|(row, own)| Particle {
        position: state.positions[row].to_f64(),
        velocity: state.velocities[row].to_f64(),
        mass: mass(own),
    });
    let pinned = |&particle: &usize| model.is_pinned(particle) && !model.is_removed(particle);
    let pin = |particle| Pin { particle, velocity: state.velocities[particle].to_f64() };
    let mut scene = Scene {
        world: World { extent: model.extent.to_f64(), ..World::default() },
        particles: particles.collect(),
        planes: model.planes().iter().map(PlaneColumn::row).collect(),
        solids: model.solids().to_vec(),
        pins: (0..model.particle_count()).filter(pinned).map(pin).collect(),
        shells: model.shells().to_vec(),
        bodies: model.bodies.clone(),
        ..Scene::default()
    };
    model.kinds().for_each(|kind| kind.write(&mut scene));
    scene
}

fn held<R: Real>(grab: &Grab<R>) -> Held {
    Held {
        particle: grab.particle as usize,
        target: grab.target.to_f64(),
        stiffness: grab.stiffness.to_f64(),
        damping: grab.damping.to_f64(),
        max_force: grab.max_force.to_f64(),
    }
}

fn grab<R: Real>(held: &Held) -> Grab<R> {
    Grab {
        particle: held.particle as u32,
        target: R::Vec3::of(held.target),
        stiffness: R::of(held.stiffness),
        damping: R::of(held.damping),
        max_force: R::of(held.max_force),
    }
}
