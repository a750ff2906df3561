//! Material and world: what the user has set, and what the sliders show.

use super::{Deed, Session};
use glam::DVec3;
use msd_core::{Friction, Interaction, Model, Real, Scene, Select, Vector};
use msd_run::{Runner, on};

/// A number of the selected bodies, or of the world, that the user sets.
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
    /// Strength of gravity, metres per second squared; its direction stays.
    Gravity(f64),
    /// Restitution of every plane, 0 to 1.
    Restitution(f64),
    /// Friction of every plane.
    Friction(Friction),
}

impl MaterialEdit {
    /// What is set, in a word or two.
    pub fn words(self) -> &'static str {
        match self {
            MaterialEdit::Mass(_) => "mass",
            MaterialEdit::Stiffness(_) => "stiffness",
            MaterialEdit::Damping(_) => "damping",
            MaterialEdit::RestScale(_) => "rest length",
            MaterialEdit::Gravity(_) => "gravity",
            MaterialEdit::Restitution(_) => "restitution",
            MaterialEdit::Friction(_) => "friction",
        }
    }
}

/// What was set since the scene was loaded, and the values that resulted.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// The edits that still count, oldest first, to be applied again after a restart.
    kept: Vec<Interaction>,
    /// How much longer springs are at rest than those of the scene, since the last restart.
    scales: Vec<(Select, f64)>,
    values: MaterialValues,
}

impl Material {
    /// What the sliders show.
    pub fn values(&self) -> &MaterialValues {
        &self.values
    }

    /// Whether a number was set that a restart keeps.
    pub fn is_edited(&self) -> bool {
        !self.kept.is_empty()
    }

    /// The edits that still count, oldest first.
    pub fn kept(&self) -> &[Interaction] {
        &self.kept
    }

    /// Gives up edits: what they had set was set back.
    pub(super) fn give_up(&mut self, edits: &[Interaction]) {
        self.kept.retain(|edit| !edits.contains(edit));
    }

    /// All that makes the scene as it is set now: the edits that still count and the rest lengths,
    /// which a restart gives back.
    pub fn edits(&self) -> Vec<Interaction> {
        let scale =
            |&(springs, factor): &(Select, f64)| Interaction::ScaleRestLength { springs, factor };
        self.kept.iter().copied().chain(self.scales.iter().map(scale)).collect()
    }

    /// Forgets the edits, as the scene is to have its own values again.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
    }

    /// Chooses what the sliders act on: all, or one body.
    pub(super) fn select(&mut self, select: Select) {
        self.values.select = select;
        // Each body may have been scaled on its own: the slider starts over.
        self.values.rest_scale = 1.0;
    }

    /// Makes the present rest lengths those that the slider counts from, as they were frozen.
    fn reset_rest_scale(&mut self) {
        let frozen = self.values.select;
        self.scales.retain(|(select, _)| frozen != Select::All && *select != frozen);
        self.values.rest_scale = 1.0;
    }

    /// Forgets what was done to rest lengths, as the scene's come back.
    pub(super) fn forget_rest_lengths(&mut self) {
        self.scales.clear();
        self.values.rest_scale = 1.0;
    }

    /// Reads the values of a run again.
    pub(super) fn read(&mut self, runner: &Runner) {
        let MaterialValues { select, rest_scale, .. } = self.values;
        let values = on!(runner, simulation => read(simulation.model(), select));
        self.values = MaterialValues { rest_scale, ..values };
    }

    /// What an edit of a run of `scene` does to the simulation.
    pub(super) fn interactions(
        &self,
        edit: MaterialEdit,
        runner: &Runner,
        scene: &Scene,
    ) -> Vec<Interaction> {
        let MaterialValues { select, rest_scale, .. } = self.values;
        vec![match edit {
            MaterialEdit::Mass(value) => Interaction::SetMass { particles: select, value },
            MaterialEdit::Stiffness(value) => Interaction::SetStiffness { springs: select, value },
            MaterialEdit::Damping(value) => Interaction::SetDamping { springs: select, value },
            MaterialEdit::RestScale(scale) => {
                Interaction::ScaleRestLength { springs: select, factor: scale / rest_scale }
            }
            MaterialEdit::Gravity(value) => {
                let now = on!(runner, simulation => simulation.model().gravity().to_f64());
                let known = if now == DVec3::ZERO { scene.world.gravity } else { now };
                let direction = known.try_normalize().unwrap_or(DVec3::NEG_Y);
                Interaction::SetGravity { value: direction * value }
            }
            MaterialEdit::Restitution(restitution) => {
                return set_planes(runner, |_, friction| (restitution, friction));
            }
            MaterialEdit::Friction(friction) => {
                return set_planes(runner, |restitution, _| (restitution, friction));
            }
        }]
    }

    /// Keeps what was done, instead of the edits that it replaces.
    pub(super) fn keep(&mut self, done: Interaction) {
        if let Interaction::ScaleRestLength { springs, factor } = done {
            return self.keep_scale(springs, factor);
        }
        self.kept.retain(|old| !replaces(&done, old));
        self.kept.push(done);
    }

    /// Keeps that springs are so many times as long at rest as before.
    fn keep_scale(&mut self, springs: Select, factor: f64) {
        match self.scales.iter_mut().find(|(select, _)| *select == springs) {
            Some((_, scale)) => *scale *= factor,
            None => self.scales.push((springs, factor)),
        }
        self.scales.retain(|&(_, scale)| scale != 1.0);
        if springs == self.values.select {
            self.values.rest_scale *= factor;
        }
    }

    /// Shows the very number that was set, which products miss by rounding.
    fn show(&mut self, edit: MaterialEdit) {
        if let MaterialEdit::RestScale(scale) = edit {
            self.values.rest_scale = scale;
        }
    }
}

/// What the user sets of material and world.
impl Session {
    /// Makes the present lengths of the selected springs their rest lengths.
    pub fn freeze(&mut self) {
        self.remember(Deed::Freeze);
        self.act(Interaction::Freeze { springs: self.material.values().select });
        self.material.reset_rest_scale();
    }

    /// Sets a number of the selected bodies, or of the world.
    pub fn edit(&mut self, edit: MaterialEdit) {
        let begins = self.remember(Deed::Edit(edit.words()));
        let mut accepted = false;
        for interaction in self.material.interactions(edit, self.runner(), &self.loaded.scene) {
            let off_again = self.off_again(&interaction);
            let all: Vec<_> = std::iter::once(interaction).chain(off_again).collect();
            if self.act_all(&all) {
                all.into_iter().for_each(|done| self.material.keep(done));
                self.material.show(edit);
                accepted = true;
            }
        }
        if begins && !accepted {
            self.undo.withdraw();
        }
    }

    /// Makes edits of material and world that were made elsewhere, as a link holds them.
    pub fn edit_again(&mut self, edits: &[Interaction]) {
        for &edit in edits {
            if self.act(edit) {
                self.material.keep(edit);
            }
        }
    }

    /// Chooses what the sliders of the material act on: all, or one body.
    pub fn select(&mut self, select: Select) {
        self.material.select(select);
        self.material.read(self.run.runner());
    }

    /// Gives material and world the values of the scene again, and restarts.
    pub fn reset_material(&mut self) {
        self.material.forget();
        self.wind = None;
        self.restart();
    }
}

/// Sets restitution and friction of every plane to a function of the present ones.
fn set_planes(
    runner: &Runner,
    change: impl Fn(f64, Friction) -> (f64, Friction),
) -> Vec<Interaction> {
    let set = |(plane, (restitution, friction)): (usize, (f64, Friction))| {
        let (restitution, friction) = change(restitution, friction);
        Interaction::SetPlane { plane, restitution, friction }
    };
    on!(runner, simulation => {
        let planes = simulation.model().planes().iter();
        let laws = planes.map(|plane| (plane.restitution(), plane.friction()));
        laws.enumerate().map(set).collect()
    })
}

/// Whether an old edit has no effect any more after a new one.
fn replaces(new: &Interaction, old: &Interaction) -> bool {
    use Interaction::*;
    let covers = |new: &Select, old: &Select| *new == Select::All || new == old;
    match (new, old) {
        (SetStiffness { springs: new, .. }, SetStiffness { springs: old, .. })
        | (SetDamping { springs: new, .. }, SetDamping { springs: old, .. })
        | (SetMass { particles: new, .. }, SetMass { particles: old, .. }) => covers(new, old),
        (SetGravity { .. }, SetGravity { .. }) | (SetDrag { .. }, SetDrag { .. }) => true,
        (RemovePlanes, SetPlane { .. } | RemovePlanes | AddPlane { .. }) => true,
        (SetPlane { plane: new, .. }, SetPlane { plane: old, .. }) => new == old,
        _ => false,
    }
}

/// A number of the chosen particles or springs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MixedValue {
    /// That of the first.
    pub first: f64,
    /// Whether others differ.
    pub mixed: bool,
}

impl MixedValue {
    fn of(mut values: impl Iterator<Item = f64>) -> Option<Self> {
        let first = values.next()?;
        Some(MixedValue { first, mixed: values.any(|value| value != first) })
    }
}

/// What the sliders show. Read from the model after each change, not in each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialValues {
    /// What the sliders of the material act on.
    pub select: Select,
    /// Mass of a particle, kilograms; `None` without particles.
    pub mass: Option<MixedValue>,
    /// Stiffness, newtons per metre; `None` without springs.
    pub stiffness: Option<MixedValue>,
    /// Damping, newton seconds per metre; `None` without springs.
    pub damping: Option<MixedValue>,
    /// Rest lengths as a multiple of the scene's, or of the frozen ones.
    pub rest_scale: f64,
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
            rest_scale: 1.0,
            gravity: 0.0,
            restitution: None,
            friction: None,
        }
    }
}

/// Reads what the sliders show for a selection.
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
        rest_scale: 1.0,
        gravity: model.gravity().to_f64().length(),
        restitution: MixedValue::of(planes.iter().map(|plane| plane.restitution())),
        friction: planes.first().map(|plane| plane.friction()),
    }
}
