//! User forces in a session: grabs, groups, pins, cuts and wind.

use super::grab::{Grab, HeldSolid, MOST_HELD, force};
use crate::session::material::WIND;
use crate::session::{Deed, Session, Wind};
use glam::DVec3;
use msd_core::{Interaction, Vector};
use msd_run::on;
use msd_scene::Assignment;
use msd_scene::schema::WindRow;

/// Interactions of the user with single particles and springs.
impl Session {
    /// Grabs a particle with the mouse, together with its group.
    pub fn grab(&mut self, particle: usize, target: DVec3) {
        self.release();
        if !self.grab.group.contains(&particle) {
            self.grab.group.clear();
        }
        let held = self.grab.hold(self.run.runner(), particle, target);
        let grabs: Vec<_> = held.iter().map(|held| held.interaction()).collect();
        if self.act_all(&grabs) {
            (self.grab.held, self.grab.selected) = (held, Some(particle));
        }
    }

    /// Grabs a solid with the mouse, which then sets its motion.
    pub fn grab_solid(&mut self, solid: usize) {
        self.release();
        let held = HeldSolid::new(self.runner(), solid);
        if self.act(held.rest(self.run.runner())) {
            self.grab.solid = Some(held);
        }
    }

    /// Moves the grabbed objects: the first particle to `target` and the others with it, or the
    /// centre of a solid.
    pub fn move_grab(&mut self, target: DVec3) {
        if let Some(held) = &mut self.grab.solid {
            held.target = target;
            return;
        }
        let moved = self.grab.moved(target);
        if moved.iter().all(|held| self.act(held.interaction())) {
            self.grab.held = moved;
        }
    }

    /// Releases the grabbed objects; a particle keeps its velocity, a solid stops.
    pub fn release(&mut self) {
        if let Some(held) = self.grab.solid {
            self.act(held.rest(self.run.runner()));
            self.grab.solid = None;
        }
        let held: Vec<_> = self.grab.held.drain(..).map(|held| held.particle).collect();
        if held.is_empty() {
            return;
        }
        let release = held.iter().map(|&particle| Interaction::Release { particle });
        let pinned = held.iter().filter(|&&particle| self.is_pinned(particle));
        let velocity = DVec3::ZERO;
        let stop = pinned.map(|&particle| Interaction::Pin { particle, velocity });
        let all: Vec<_> = release.chain(stop).collect();
        self.act_all(&all);
    }

    /// Selects the particles that a grab takes together: at most [`MOST_HELD`], evenly chosen if
    /// there are more.
    pub fn select_group(&mut self, mut particles: Vec<usize>) {
        self.release();
        let count = particles.len();
        if MOST_HELD < count {
            particles = (0..MOST_HELD).map(|row| particles[row * count / MOST_HELD]).collect();
        }
        (self.grab.group, self.grab.selected) = (particles, None);
    }

    /// Cuts springs for good; a restart brings them back.
    pub fn cut(&mut self, springs: &[usize]) {
        if !springs.is_empty() {
            self.remember(Deed::Cut);
            let cuts: Vec<_> = springs.iter().map(|&spring| Interaction::Cut { spring }).collect();
            self.act_all(&cuts);
        }
    }

    /// Sets the wind, which can be undone; strength 0 ends it.
    pub fn set_wind(&mut self, wind: Wind) {
        self.remember(Deed::Wind);
        let row = (wind != self.loaded.wind()).then(|| WindRow::from(wind));
        let edit = row.map(|row| Assignment::new(WIND, row));
        self.material.set_wind(edit);
        self.follow_wind();
        self.blow();
    }

    /// Reads the wind from the edits, or else from the scene.
    pub(in crate::session) fn follow_wind(&mut self) {
        let row = self.material.set().of(WIND).and_then(|edit| edit.read::<WindRow>().ok());
        (self.wind, self.is_blowing) = (row.map_or(self.loaded.wind(), Wind::from), false);
    }

    /// Moves the grabbed pins and solid and applies the wind, before each step.
    pub(in crate::session) fn before_step(&mut self) {
        let held = self.grab.held.iter();
        let pins = held.filter_map(|held| held.pin_motion(self.run.runner()));
        let solid = self.grab.solid.map(|held| held.motion(self.run.runner()));
        let motions: Vec<_> = pins.chain(solid).collect();
        motions.into_iter().for_each(|motion| _ = self.act(motion));
        self.blow();
    }

    /// Applies the wind: once after a change, and before each step if it is gusty.
    pub(in crate::session) fn blow(&mut self) {
        let wind = self.wind;
        if self.is_blowing && !wind.is_gusty() {
            return;
        }
        let value = self.loaded.force_in(wind, self.runner().time());
        let is_so =
            on!(self.runner(), simulation => simulation.model().force() == Vector::of(value));
        self.is_blowing = is_so || self.act(Interaction::SetForce { value });
    }

    /// Releases everything and selects nothing.
    pub(crate) fn deselect(&mut self) {
        self.release();
        self.grab = Grab::default();
    }

    /// Selects a particle, if one with this number exists, without a grab.
    pub fn select_particle(&mut self, particle: Option<usize>) {
        let count = self.runner().particle_count();
        self.grab.selected = particle.filter(|&particle| particle < count);
    }

    /// Pins a free particle at its position, or frees a pinned one.
    pub fn pin_toggle(&mut self, particle: usize) {
        self.remember(Deed::Pin);
        if self.is_pinned(particle) {
            self.act(Interaction::Unpin { particle });
        } else {
            if self.held().is_some() {
                self.release();
            }
            self.act(Interaction::Pin { particle, velocity: DVec3::ZERO });
        }
        self.grab.selected = Some(particle);
    }
}

/// The objects that the user grabs or selects.
impl Session {
    /// Returns the grabbed particle; in a group, the one under the pointer.
    pub fn held(&self) -> Option<usize> {
        self.grab.held.first().map(|held| held.particle)
    }

    /// Returns the grabbed solid.
    pub fn held_solid(&self) -> Option<usize> {
        self.grab.solid.map(|held| held.solid)
    }

    /// Returns whether the mouse has grabbed anything.
    pub fn is_holding(&self) -> bool {
        self.held().is_some() || self.grab.solid.is_some()
    }

    /// Returns the target of the grabbed particle or of the centre of the grabbed solid, metres.
    pub fn grab_target(&self) -> Option<DVec3> {
        let solid = self.grab.solid.map(|held| held.target);
        solid.or(self.grab.held.first().map(|held| held.target))
    }

    /// Returns the total force of the mouse in the current state, newtons; `None` without a grab,
    /// or if a pin is grabbed, which no force moves.
    pub fn grab_force(&self) -> Option<f64> {
        self.held().filter(|&held| !self.is_pinned(held))?;
        Some(on!(self.runner(), simulation => force(simulation)).length())
    }

    /// Returns the particles that a grab takes together.
    pub fn group(&self) -> &[usize] {
        &self.grab.group
    }

    /// Returns the uniform force of the scene with the mean of a gusty wind, newtons; `None` if the
    /// force of the run is steady.
    pub(in crate::session) fn steady_force(&self) -> Option<DVec3> {
        self.wind.is_gusty().then(|| self.loaded.force_in(self.wind.mean(), 0.0))
    }

    /// Returns the current wind, from the edits or the scene.
    pub fn wind(&self) -> Wind {
        self.wind
    }

    /// Returns the selected particle, which buttons and keys act on.
    pub fn selected(&self) -> Option<usize> {
        self.grab.selected
    }
}
