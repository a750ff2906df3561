//! Which numbers of the model can a person set while it runs?

use crate::edits::{self, Edits, Shown};
use crate::session::Session;
use glam::DVec3;
use msd_core::{Friction, Interaction, Select, Vector};
use msd_run::on;

impl Session {
    /// Reads again what the sliders show.
    pub(crate) fn refresh(&mut self) {
        let select = self.shown.select;
        let rest_scale = if self.shown.rest_scale == 0.0 { 1.0 } else { self.shown.rest_scale };
        let shown = on!(&self.runner, simulation => edits::read(simulation.model(), select));
        self.shown = Shown { rest_scale, ..shown };
        self.touch();
    }

    /// Chooses what the sliders of the material act on: all, or one body.
    pub fn set_select(&mut self, select: Select) {
        self.shown.select = select;
        // Each body may have been scaled on its own: the slider starts over.
        self.shown.rest_scale = 1.0;
        self.refresh();
    }

    fn edit(&mut self, edit: Interaction) {
        if self.act(edit) {
            self.edits.keep(edit);
        }
        self.refresh();
    }

    /// Sets the mass of each chosen particle, kilograms.
    pub fn set_mass(&mut self, value: f64) {
        self.edit(Interaction::SetMass { particles: self.shown.select, value });
    }

    /// Sets the stiffness of the chosen springs, newtons per metre.
    pub fn set_stiffness(&mut self, value: f64) {
        self.edit(Interaction::SetStiffness { springs: self.shown.select, value });
    }

    /// Sets the damping of the chosen springs, newton seconds per metre.
    pub fn set_damping(&mut self, value: f64) {
        self.edit(Interaction::SetDamping { springs: self.shown.select, value });
    }

    /// Sets the rest lengths of the chosen springs to a multiple of the scene's.
    pub fn set_rest_scale(&mut self, scale: f64) {
        let factor = scale / self.shown.rest_scale;
        if self.act(Interaction::ScaleRestLength { springs: self.shown.select, factor }) {
            self.shown.rest_scale = scale;
        }
        self.refresh();
    }

    /// Sets how strong gravity is, metres per second squared; its direction stays.
    pub fn set_gravity(&mut self, value: f64) {
        let now = on!(&self.runner, simulation => simulation.model().gravity().to_f64());
        let known = if now == DVec3::ZERO { self.loaded.scene.world.gravity } else { now };
        let direction = known.try_normalize().unwrap_or(DVec3::NEG_Y);
        self.edit(Interaction::SetGravity { value: direction * value });
    }

    /// Sets the restitution of every plane, 0 to 1.
    pub fn set_restitution(&mut self, value: f64) {
        self.edit_planes(|_, friction| (value, friction));
    }

    /// Sets the friction of every plane.
    pub fn set_friction(&mut self, friction: Friction) {
        self.edit_planes(|restitution, _| (restitution, friction));
    }

    fn edit_planes(&mut self, change: impl Fn(f64, Friction) -> (f64, Friction)) {
        let planes: Vec<(f64, Friction)> = on!(&self.runner, simulation => {
            let planes = simulation.model().planes().iter();
            planes.map(|plane| (plane.restitution(), plane.friction())).collect()
        });
        for (plane, (restitution, friction)) in planes.into_iter().enumerate() {
            let (restitution, friction) = change(restitution, friction);
            self.edit(Interaction::SetPlane { plane, restitution, friction });
        }
    }

    /// Whether a number differs from the scene's.
    pub fn is_edited(&self) -> bool {
        !self.edits.kept().is_empty()
    }

    /// Gives material and world the values of the scene again, and restarts.
    pub fn reset_values(&mut self) {
        self.edits = Edits::default();
        self.restart();
    }
}
