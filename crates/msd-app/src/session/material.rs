//! Which numbers of the model were set by hand, and what are they now?

use msd_core::{Friction, Interaction, Model, Real, Select, Vector};

/// What was set since the scene was loaded, to be set again after a restart.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    kept: Vec<Interaction>,
}

impl Edits {
    /// The edits that still count, oldest first.
    pub fn kept(&self) -> &[Interaction] {
        &self.kept
    }

    /// Keeps an edit instead of those that it replaces.
    pub(crate) fn keep(&mut self, edit: Interaction) {
        self.kept.retain(|old| !replaces(&edit, old));
        self.kept.push(edit);
    }
}

/// Whether an old edit has no effect any more after a new one.
fn replaces(new: &Interaction, old: &Interaction) -> bool {
    use Interaction::*;
    let covers = |new: &Select, old: &Select| *new == Select::All || new == old;
    match (new, old) {
        (SetStiffness { springs: new, .. }, SetStiffness { springs: old, .. })
        | (SetDamping { springs: new, .. }, SetDamping { springs: old, .. })
        | (SetMass { particles: new, .. }, SetMass { particles: old, .. }) => covers(new, old),
        (SetGravity { .. }, SetGravity { .. }) => true,
        (SetPlane { plane: new, .. }, SetPlane { plane: old, .. }) => new == old,
        _ => false,
    }
}

/// A number of the chosen particles or springs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Value {
    /// That of the first.
    pub first: f64,
    /// Whether others differ.
    pub mixed: bool,
}

impl Value {
    fn of(mut values: impl Iterator<Item = f64>) -> Option<Self> {
        let first = values.next()?;
        Some(Value { first, mixed: values.any(|value| value != first) })
    }
}

/// What the sliders show. Read from the model after each change, not in each frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown {
    /// What the sliders of the material act on.
    pub select: Select,
    /// Mass of a particle, kilograms; none without particles.
    pub mass: Option<Value>,
    /// Stiffness, newtons per metre; none without springs.
    pub stiffness: Option<Value>,
    /// Damping, newton seconds per metre; none without springs.
    pub damping: Option<Value>,
    /// Rest lengths as a multiple of the scene's, or of the frozen ones.
    pub rest_scale: f64,
    /// Gravity, metres per second squared.
    pub gravity: f64,
    /// Restitution of the first plane; none without planes.
    pub restitution: Option<Value>,
    /// Friction of the first plane; none without planes.
    pub friction: Option<Friction>,
}

/// Reads what the sliders show for a selection.
pub(crate) fn read<R: Real>(model: &Model<R>, select: Select) -> Shown {
    let (particles, springs) = match select {
        Select::Body(body) => {
            let body = &model.bodies()[body];
            (body.particles.clone(), body.springs.clone())
        }
        _ => (0..model.particle_count(), 0..model.ends().len()),
    };
    let springs = springs.filter(|&spring| !model.is_cut(spring));
    let planes = model.planes();
    Shown {
        select,
        mass: Value::of(particles.map(|particle| model.masses()[particle].to_f64())),
        stiffness: Value::of(springs.clone().map(|row| model.stiffness(row).to_f64())),
        damping: Value::of(springs.map(|row| model.damping(row).to_f64())),
        rest_scale: 1.0,
        gravity: model.gravity().to_f64().length(),
        restitution: Value::of(planes.iter().map(|plane| plane.restitution())),
        friction: planes.first().map(|plane| plane.friction()),
    }
}
