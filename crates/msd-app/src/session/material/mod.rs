//! Material and world: the user's edits and the values of the sliders.

mod looks;

pub use looks::{LookEdit, LookValues};

use super::{Deed, Session};
use glam::DVec3;
pub(super) use looks::{is_look, is_of_looks};
use msd_core::{Friction, Interaction, Model, Real, Scene, Select, Vector};
use msd_run::live::{Target, keep_off, off_again, set_all};
use msd_run::{Runner, on};
use msd_scene::materials::{Made, Named};
use msd_scene::{Assignment, Edits, Loaded};

/// An edit of the selected bodies, or of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialEdit {
    /// Mass of each selected particle, kilograms.
    Mass(f64),
    /// Stiffness of the selected springs, newtons per metre.
    Stiffness(f64),
    /// Damping of the selected springs, newton seconds per metre.
    Damping(f64),
    /// Rest lengths of the selected springs, as a multiple of the scene's.
    RestScale(f64),
    /// Young's modulus of a body that consists of a material, pascals.
    Young(f64),
    /// Thickness of such a body if it is a sheet, metres.
    Thickness(f64),
    /// Density of such a body, kilograms per cubic metre; of a woven sheet, per square metre.
    Density(f64),
    /// Viscosity over modulus of such a body, seconds.
    RelaxationTime(f64),
    /// A named material: its modulus, density and relaxation time. The body's Poisson's ratio
    /// stays.
    Named(&'static Named),
    /// Strength of gravity, metres per second squared; its direction stays.
    Gravity(f64),
    /// Restitution of every plane, 0 to 1.
    Restitution(f64),
    /// Friction of every plane.
    Friction(Friction),
}

impl MaterialEdit {
    /// Returns the edited property in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            MaterialEdit::Mass(_) => "mass",
            MaterialEdit::Stiffness(_) => "stiffness",
            MaterialEdit::Damping(_) => "damping",
            MaterialEdit::RestScale(_) => "rest length",
            MaterialEdit::Young(_) => "Young's modulus",
            MaterialEdit::Thickness(_) => "thickness",
            MaterialEdit::Density(_) => "density",
            MaterialEdit::RelaxationTime(_) => "relaxation time",
            MaterialEdit::Named(_) => "material",
            MaterialEdit::Gravity(_) => "gravity",
            MaterialEdit::Restitution(_) => "restitution",
            MaterialEdit::Friction(_) => "friction",
        }
    }
}

/// The key of the wind.
pub(super) const WIND: &str = "world.wind";

/// The edits since the scene was loaded, and the resulting values.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Keys of the scene that were set; a restart sets them again.
    pub(super) set: Edits,
    /// Current materials and rest scales of the bodies.
    pub(super) target: Target,
    values: MaterialValues,
}

impl Material {
    /// Returns the unedited material of a scene.
    pub(super) fn of(loaded: &Loaded) -> Self {
        Material { target: Target::written(loaded), ..Material::default() }
    }

    /// Returns the current material of each body: `None` for a body given by masses and springs, an
    /// empty slice if no body has a known material.
    pub fn made(&self) -> &[Option<Made>] {
        &self.target.made
    }

    /// Returns the selected body and its material, if it has one.
    pub fn selected(&self) -> Option<(usize, Made)> {
        let body = match (self.values.select, self.made().len()) {
            (Select::Body(body), _) => body,
            (Select::All, 1) => 0,
            _ => return None,
        };
        Some((body, (*self.made().get(body)?)?))
    }

    /// Returns the values of the sliders.
    pub fn values(&self) -> &MaterialValues {
        &self.values
    }

    /// Returns whether there are edits, which a restart keeps.
    pub fn is_edited(&self) -> bool {
        !self.set.is_empty()
    }

    /// Returns the keys of the scene that were set.
    pub fn set(&self) -> &Edits {
        &self.set
    }

    /// Sets the wind, or returns it to that of the scene.
    pub(super) fn set_wind(&mut self, edit: Option<Assignment>) {
        self.set.forget(WIND);
        edit.into_iter().for_each(|edit| self.set.set(edit));
    }

    /// Drops the edits: the scene gets its own values back.
    pub(super) fn forget(&mut self, loaded: &Loaded) {
        self.set.clear();
        self.target = Target::written(loaded);
    }

    /// Selects the target of the sliders: all bodies, or one.
    pub(super) fn select(&mut self, select: Select) {
        self.values.select = select;
    }

    /// Returns the keys of the rest lengths of the selection; `bodies` is the number of bodies.
    fn rest_keys(&self, bodies: usize) -> Vec<String> {
        match self.values.select {
            Select::Body(body) => vec![format!("bodies[{body}].rest_scale")],
            _ if bodies < self.target.rest_scales.len() => {
                vec!["bodies.rest_scale".into(), "links.rest_scale".into()]
            }
            _ => vec!["bodies.rest_scale".into()],
        }
    }

    /// Makes the current, frozen rest lengths the reference of the slider.
    fn reset_rest_scale(&mut self, bodies: usize) {
        self.rest_keys(bodies).iter().for_each(|key| self.set.forget(key));
        let select = self.values.select;
        let scales = self.target.rest_scales.iter_mut().enumerate();
        let frozen = scales.filter(|(row, _)| is_of(select, *row));
        frozen.for_each(|(_, (_, scale))| *scale = 1.0);
    }

    /// Returns the factors of the rest lengths of the selection.
    fn rest_scales(&self) -> impl Iterator<Item = f64> + '_ {
        let select = self.values.select;
        let rows = self.target.rest_scales.iter().enumerate();
        rows.filter(move |(row, _)| is_of(select, *row)).map(|(_, (_, scale))| *scale)
    }

    /// Reads the values of a run again.
    pub(super) fn read(&mut self, runner: &Runner) {
        let select = self.values.select;
        let values = on!(runner, simulation => read(simulation.model(), select));
        let rest_scale = MixedValue::of(self.rest_scales()).filter(|_| values.stiffness.is_some());
        self.values = MaterialValues { rest_scale, ..values };
    }

    /// Returns the keys that an edit sets; `scene` is the scene as loaded.
    fn keys(&self, edit: MaterialEdit, runner: &Runner, scene: &Scene) -> Vec<Assignment> {
        let select = self.values.select;
        let of_bodies = |name: &str| match select {
            Select::Body(body) => format!("bodies[{body}].{name}"),
            _ => format!("bodies.{name}"),
        };
        let of_springs = |name: &str, value: f64| {
            let own = scene.bodies.last().map_or(0, |body| body.springs.end);
            let has_links = select == Select::All && own < scene.springs.len();
            let links = has_links.then(|| Assignment::new(&format!("links.{name}"), value));
            [Assignment::new(&of_bodies(name), value)].into_iter().chain(links).collect()
        };
        let of_material = |name: &str, value: f64| match self.selected() {
            Some((body, _)) => vec![Assignment::new(&format!("bodies[{body}].{name}"), value)],
            None => Vec::new(),
        };
        let of_planes = |name: &str, value: f64| {
            let is_there = on!(runner, simulation => !simulation.model().planes().is_empty());
            let key = || Assignment::new(&format!("world.planes.{name}"), value);
            is_there.then(key).into_iter().collect()
        };
        match edit {
            MaterialEdit::Mass(value) => vec![Assignment::new(&of_bodies("mass"), value)],
            MaterialEdit::Stiffness(value) => of_springs("stiffness", value),
            MaterialEdit::Damping(value) => of_springs("damping", value),
            MaterialEdit::Young(value) => of_material("young", value),
            MaterialEdit::Thickness(value) => of_material("thickness", value),
            MaterialEdit::Density(value) => {
                let is_woven = self.selected().is_some_and(|(_, made)| made.young.is_none());
                of_material(if is_woven { "area_density" } else { "density" }, value)
            }
            MaterialEdit::RelaxationTime(value) => of_material("relaxation_time", value),
            MaterialEdit::Named(named) => {
                let key = |body| Assignment::new(&format!("bodies[{body}].material"), named.name);
                self.selected().map(|(body, _)| key(body)).into_iter().collect()
            }
            MaterialEdit::Gravity(value) => {
                let now = on!(runner, simulation => simulation.model().gravity().to_f64());
                let known = if now == DVec3::ZERO { scene.world.gravity } else { now };
                let direction = known.try_normalize().unwrap_or(DVec3::NEG_Y);
                vec![Assignment::new("world.gravity", (direction * value).to_array())]
            }
            MaterialEdit::Restitution(value) => of_planes("restitution", value),
            MaterialEdit::Friction(Friction::Coulomb(value)) => of_planes("friction", value),
            MaterialEdit::Friction(Friction::TangentialLoss(value)) => {
                of_planes("tangential_loss", value)
            }
            MaterialEdit::RestScale(value) => {
                let keys = self.rest_keys(scene.bodies.len()).into_iter();
                keys.map(|key| Assignment::new(&key, value)).collect()
            }
        }
    }
}

/// Returns whether a selection includes the springs of the body with this index.
fn is_of(select: Select, row: usize) -> bool {
    !matches!(select, Select::Body(body) if body != row)
}

/// Edits of material and world.
impl Session {
    /// Makes the current lengths of the selected springs their rest lengths.
    pub fn freeze(&mut self) {
        self.remember(Deed::Freeze);
        self.act(Interaction::Freeze { springs: self.material.values().select });
        self.material.reset_rest_scale(self.loaded.scene.bodies.len());
        self.material.read(self.run.runner());
    }

    /// Edits the selected bodies, or the world.
    pub fn edit(&mut self, edit: MaterialEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let keys = self.material.keys(edit, self.run.runner(), &self.loaded.scene);
        if !self.set(keys) && begins {
            self.undo.withdraw();
        }
    }

    /// Sets keys of the scene, also in the run; returns whether the run accepted them. All or none.
    pub(super) fn set(&mut self, keys: Vec<Assignment>) -> bool {
        let mut target = self.material.target.clone().of(self.runner());
        let (mut set, mut acts) = (self.material.set.clone(), self.on_again(&keys));
        let off = self.off_but_for(&keys);
        for key in keys {
            match target.set(&key, &self.loaded) {
                Ok(done) => acts.extend(done),
                Err(refusal) => {
                    self.refusal = Some(refusal);
                    return false;
                }
            }
            set.set(key);
        }
        acts.extend(off_again(&off, &acts, &self.loaded));
        keep_off(&off, &mut set);
        let accepted = match acts.iter().all(is_look) {
            // Looks affect none of the values that were read.
            true => !acts.is_empty() && acts.into_iter().all(|act| self.act(act)),
            false => self.act_all(&acts),
        };
        if accepted {
            (self.material.set, self.material.target) = (set, target);
            self.material.read(self.run.runner());
        }
        accepted
    }

    /// Applies edits from a link: all keys but those of the solver.
    pub(crate) fn edit_again(&mut self, mut set: Edits) {
        let Session { run, loaded, .. } = self;
        match run.change(|runner| set_all(runner, loaded, &set)) {
            Ok(target) => self.material.target = target,
            Err(refusal) => return self.refusal = Some(refusal),
        }
        // The run itself already has the solver.
        set.forget("solver");
        self.material.set = set;
        self.run.change(Runner::calm);
        self.follow_wind();
        self.change(|_| ());
        self.record_start();
        self.blow();
    }

    /// Selects the target of the material sliders: all bodies, or one.
    pub fn select(&mut self, select: Select) {
        self.material.select(select);
        self.material.read(self.run.runner());
    }

    /// Resets material and world to the values of the scene, and restarts.
    pub fn reset_material(&mut self) {
        self.material.forget(&self.loaded);
        self.restart();
    }
}

/// A property of the selected particles or springs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MixedValue {
    /// Value of the first one.
    pub first: f64,
    /// Whether others differ.
    pub mixed: bool,
}

impl MixedValue {
    pub(super) fn of(mut values: impl Iterator<Item = f64>) -> Option<Self> {
        let first = values.next()?;
        Some(MixedValue { first, mixed: values.any(|value| value != first) })
    }
}

/// Values of the sliders, read from the model after each change instead of in each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialValues {
    /// Selection that the material sliders act on.
    pub select: Select,
    /// Mass of a particle, kilograms; `None` without particles.
    pub mass: Option<MixedValue>,
    /// Stiffness, newtons per metre; `None` without springs.
    pub stiffness: Option<MixedValue>,
    /// Damping, newton seconds per metre; `None` without springs.
    pub damping: Option<MixedValue>,
    /// Factor of the rest lengths, relative to those of the scene or the frozen ones; `None`
    /// without springs.
    pub rest_scale: Option<MixedValue>,
    /// Gravity, metres per second squared.
    pub gravity: f64,
    /// Restitution of the first plane; `None` without planes.
    pub restitution: Option<MixedValue>,
    /// Friction of the first plane; `None` without planes.
    pub friction: Option<Friction>,
}

impl Default for MaterialValues {
    fn default() -> Self {
        MaterialValues {
            select: Select::All,
            mass: None,
            stiffness: None,
            damping: None,
            rest_scale: None,
            gravity: 0.0,
            restitution: None,
            friction: None,
        }
    }
}

/// Reads the values of the sliders for a selection.
fn read<R: Real>(model: &Model<R>, select: Select) -> MaterialValues {
    let (particles, springs) = match select {
        Select::Body(body) => {
            let body = &model.bodies()[body];
            (body.particles.clone(), body.springs.clone())
        }
        _ => (0..model.particle_count(), 0..model.ends().len()),
    };
    let springs = springs.filter(|&spring| !model.is_cut(spring));
    let planes = model.planes();
    MaterialValues {
        select,
        mass: MixedValue::of(particles.map(|particle| model.masses()[particle].to_f64())),
        stiffness: MixedValue::of(springs.clone().map(|row| model.stiffness(row).to_f64())),
        damping: MixedValue::of(springs.map(|row| model.damping(row).to_f64())),
        rest_scale: None,
        gravity: model.gravity().to_f64().length(),
        restitution: MixedValue::of(planes.iter().map(|plane| plane.restitution())),
        friction: planes.first().map(|plane| plane.friction()),
    }
}
