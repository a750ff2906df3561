//! Material and world: what the user has set, and what the sliders show.

mod looks;

pub use looks::{LookEdit, LookValues};

use super::{Deed, Session};
use glam::DVec3;
pub(super) use looks::is_look;
use msd_core::{Friction, Interaction, MaterialNumber, Model, Real, Scene, Select, Vector};
use msd_run::{Runner, on};
use msd_scene::materials::{Made, Named, Numbers};

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
    /// Young's modulus of a body that is made of a material, pascals.
    Young(f64),
    /// Thickness of one that is a sheet, metres.
    Thickness(f64),
    /// Density of one, kilograms per cubic metre, of a woven sheet per square metre.
    Density(f64),
    /// Viscosity over modulus of one, seconds.
    RelaxationTime(f64),
    /// The material of one, by name: modulus, density and relaxation time. Its Poisson's ratio
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
    /// What is set, in a word or two.
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

/// What was set since the scene was loaded, and the values that resulted.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// The edits that still count, oldest first, to be applied again after a restart.
    kept: Vec<Interaction>,
    /// How much longer springs are at rest than those of the scene, since the last restart.
    scales: Vec<(Select, f64)>,
    /// What each body is made of now; none of one that is given by masses and springs.
    made: Vec<Option<Made>>,
    values: MaterialValues,
}

impl Material {
    /// That of a scene, of which nothing was set yet.
    pub(super) fn of(made: &[Option<Made>]) -> Self {
        Material { made: made.to_vec(), ..Material::default() }
    }

    /// What each body is made of now; none of one that is given by masses and springs, nothing
    /// where no body is known to be made of anything.
    pub fn made(&self) -> &[Option<Made>] {
        &self.made
    }

    /// The selected body and what it is made of, if it is one that is made of a material.
    pub fn selected(&self) -> Option<(usize, Made)> {
        let body = match (self.values.select, self.made.len()) {
            (Select::Body(body), _) => body,
            (Select::All, 1) => 0,
            _ => return None,
        };
        Some((body, (*self.made.get(body)?)?))
    }

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
    pub(super) fn forget(&mut self, made: &[Option<Made>]) {
        self.kept.clear();
        self.made = made.to_vec();
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
        if let Some((body, made)) = self.selected()
            && let Some(edits) = remake((Select::Body(body), made), edit)
        {
            return edits;
        }
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
            MaterialEdit::Young(_)
            | MaterialEdit::Thickness(_)
            | MaterialEdit::Density(_)
            | MaterialEdit::RelaxationTime(_)
            | MaterialEdit::Named(_) => return Vec::new(),
        }]
    }

    /// Keeps what was done, instead of the edits that it replaces.
    pub(super) fn keep(&mut self, done: Interaction) {
        if let Interaction::ScaleRestLength { springs, factor } = done {
            return self.keep_scale(springs, factor);
        }
        self.follow(&done);
        if let (Some(last), Interaction::ScaleMaterial { bodies, number, factor }) =
            (self.kept.last_mut(), done)
            && let Interaction::ScaleMaterial { bodies: of, number: before, factor: all } = last
            && (*of, *before) == (bodies, number)
        {
            *all *= factor;
            return;
        }
        self.kept.retain(|old| !replaces(&done, old));
        self.kept.push(done);
    }

    /// Takes note of what was done to what bodies are made of.
    pub(super) fn follow(&mut self, done: &Interaction) {
        for (body, made) in self.made.iter_mut().enumerate() {
            let Some(made) = made else { continue };
            let is_of = |bodies: Select| bodies == Select::All || bodies == Select::Body(body);
            match *done {
                Interaction::ScaleMaterial { bodies, number, factor } if is_of(bodies) => {
                    match number {
                        MaterialNumber::Young => made.young = made.young.map(|was| was * factor),
                        MaterialNumber::Thickness => {
                            made.thickness = made.thickness.map(|was| was * factor);
                        }
                        MaterialNumber::Density => made.density *= factor,
                    }
                }
                Interaction::SetRelaxationTime { bodies, value } if is_of(bodies) => {
                    made.relaxation_time = value;
                }
                _ => continue,
            }
            made.material = None;
        }
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
        // Its springs are set alike: it is made of that material no more.
        if let MaterialEdit::Mass(_) | MaterialEdit::Stiffness(_) | MaterialEdit::Damping(_) = edit
        {
            self.unmake();
        }
        let Some((body, _)) = self.selected() else { return };
        let Some(made) = &mut self.made[body] else { return };
        match edit {
            MaterialEdit::Young(young) => made.young = Some(young),
            MaterialEdit::Thickness(thickness) => made.thickness = Some(thickness),
            MaterialEdit::Density(density) => made.density = density,
            MaterialEdit::Named(named) => made.material = Some(named.name),
            _ => {}
        }
    }

    /// Forgets what the selected bodies were made of.
    fn unmake(&mut self) {
        match self.values.select {
            Select::Body(body) => {
                self.made.get_mut(body).into_iter().for_each(|made| *made = None);
            }
            _ => self.made.fill(None),
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
        self.material.forget(&self.loaded.made);
        self.wind = None;
        self.reset_touches();
        self.restart();
    }
}

/// What makes bodies of another material; `None` where an edit is of something else.
fn remake((bodies, made): (Select, Made), edit: MaterialEdit) -> Option<Vec<Interaction>> {
    use MaterialNumber::{Density, Thickness, Young};
    let scale = |number, from: f64, to: f64| {
        let factor = to / from;
        Interaction::ScaleMaterial { bodies, number, factor }
    };
    let damp = |value| Interaction::SetRelaxationTime { bodies, value };
    Some(match edit {
        MaterialEdit::Young(young) => vec![scale(Young, made.young?, young)],
        MaterialEdit::Thickness(thickness) => {
            vec![scale(Thickness, made.thickness?, thickness)]
        }
        MaterialEdit::Density(density) => vec![scale(Density, made.density, density)],
        MaterialEdit::RelaxationTime(time) => vec![damp(time)],
        MaterialEdit::Named(named) => match named.numbers {
            Numbers::Uniform { young, density, relaxation_time, .. } => vec![
                scale(Young, made.young?, young),
                scale(Density, made.density, density),
                damp(relaxation_time),
            ],
            Numbers::Fabric { .. } => return None,
        },
        _ => return None,
    })
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
        | (SetMass { particles: new, .. }, SetMass { particles: old, .. })
        | (SetRelaxationTime { bodies: new, .. }, SetRelaxationTime { bodies: old, .. }) => {
            covers(new, old)
        }
        (SetGravity { .. }, SetGravity { .. }) | (SetDrag { .. }, SetDrag { .. }) => true,
        (RemovePlanes, SetPlane { .. } | RemovePlanes | AddPlane { .. }) => true,
        (SetPlane { plane: new, .. }, SetPlane { plane: old, .. }) => new == old,
        (SetLook { body: new, .. }, SetLook { body: old, .. }) => new == old,
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
    pub(super) fn of(mut values: impl Iterator<Item = f64>) -> Option<Self> {
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
