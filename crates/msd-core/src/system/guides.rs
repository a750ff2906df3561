//! Guided pins: where they are, how they move, and the power that all pins give.

use crate::columns::set_vector;
use crate::columns::slots::Slots;
use crate::columns::vector;
use crate::number::{Real, Vector};
use crate::obstacles::motion::{Route, SolidMotion};
use crate::scene::{Guide, Lead, Solid};
use crate::system::Columns;
use alloc::vec::Vec;
use glam::{DMat3, DVec3};

/// The part of a step by which a guide ends before its end: times are products of floating point.
const EARLY: f64 = 1e-6;
/// The substeps between two key frames from which on methods book the work between them well. The
/// error of a trapezoid is a sixteenth of it there, less than the watch over the energy allows.
const LEG: f64 = 4.0;

/// The guides of a model, each with a flag: whether it currently guides.
#[derive(Clone, Debug, Default)]
pub(crate) struct Guides(pub(crate) Vec<(Guide, bool)>);

impl Guides {
    /// Calls `put` with each guided particle, its position and its velocity at a time, seconds.
    fn each(&self, solids: &[Solid], time: f64, mut put: impl FnMut(usize, DVec3, DVec3)) {
        for (guide, _) in self.0.iter().filter(|(_, guides)| *guides) {
            let moves = SolidMotion::at(route(guide, solids), time);
            let SolidMotion { middle, axes, velocity, spin } = moves;
            for &(particle, place) in &guide.held {
                let arm = axes * place;
                put(particle, middle + arm, velocity + spin.cross(arm));
            }
        }
    }

    /// Puts guided particles where they are at a time, seconds, with their velocities.
    pub(crate) fn place<R: Real>(
        &self,
        (solids, slots): (&[Solid], &Slots),
        time: f64,
        [positions, velocities]: [&mut [R]; 2],
    ) {
        self.each(solids, time, |particle, position, velocity| {
            let at = slots.at(particle);
            set_vector(positions, at, R::Vec3::of(position));
            set_vector(velocities, at, R::Vec3::of(velocity));
        });
    }

    /// Gives guided particles the mean velocities of a substep that ends at a time and lasts `h`,
    /// seconds: by these they get to where they are then.
    pub(crate) fn lead<R: Real>(
        &self,
        (solids, slots): (&[Solid], &Slots),
        (time, h): (f64, f64),
        state: &mut Columns<R>,
    ) {
        self.each(solids, time, |particle, position, _| {
            let at = slots.at(particle);
            let way = position - vector::<R>(&state.positions, at).to_f64();
            set_vector(&mut state.velocities, at, R::Vec3::of(way / h));
        });
    }

    /// Whether a guide ended in the step of this length that ended at a time, seconds.
    pub(crate) fn has_ended(&self, time: f64, step: f64) -> bool {
        let ends =
            |guide: &Guide| !guides_at(guide, time, step) && guides_at(guide, time - step, step);
        self.0.iter().any(|(guide, _)| ends(guide))
    }

    /// Whether a guide moves from one key frame to another in fewer than [`LEG`] substeps, in the
    /// step of this length that ended at a time, seconds.
    pub(crate) fn jump(&self, solids: &[Solid], time: f64, [step, substep]: [f64; 2]) -> bool {
        let span = [time - step, time];
        let jumps = |guide: &Guide| route(guide, solids).jumps(span, LEG * substep);
        self.0.iter().any(|(guide, _)| guides_at(guide, span[0], step) && jumps(guide))
    }

    /// Lets go of a particle for good.
    pub(crate) fn release(&mut self, particle: usize) {
        for (guide, _) in &mut self.0 {
            guide.held.retain(|&(held, _)| held != particle);
        }
        self.0.retain(|(guide, _)| !guide.held.is_empty());
    }
}

/// The motion that a guide follows.
fn route<'a>(guide: &'a Guide, solids: &'a [Solid]) -> Route<'a> {
    match &guide.lead {
        Lead::Solid(solid) => Route::of(&solids[*solid]),
        Lead::Path { since, position, velocity, keys } => Route {
            position: *position,
            axes: DMat3::IDENTITY,
            velocity: *velocity,
            spin: DVec3::ZERO,
            since: *since,
            keys,
        },
    }
}

/// Whether a guide guides at a time of a run with steps of this length, seconds: at the start each
/// does, however soon it ends.
pub(crate) fn guides_at(guide: &Guide, time: f64, step: f64) -> bool {
    guide.until.is_none_or(|until| time <= 0.0 || time + EARLY * step < until)
}

/// The power that pins at these slots give: minus that of the forces on them, watts.
pub(crate) fn power_of_pins<R: Real>(pins: &[usize], forces: &[R], velocities: &[R]) -> f64 {
    let given = pins.iter().map(|&at| {
        let velocity = vector::<R>(velocities, at).to_f64();
        // The force on a pin that stands still may be any.
        if velocity == DVec3::ZERO { 0.0 } else { vector::<R>(forces, at).to_f64().dot(velocity) }
    });
    -given.sum::<f64>()
}
