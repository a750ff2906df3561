//! Keys of a scene that a run takes while it goes on: the interactions that give them values.

use crate::on;
use crate::runner::Runner;
use msd_core::{Friction, Interaction, MaterialNumber, Select};
use msd_scene::keys::Live;
use msd_scene::materials::{Made, Numbers, named};
use msd_scene::parts::Part;
use msd_scene::schema::WindRow;
use msd_scene::{Assignment, Edits, Loaded, Wind, look_of, shells_of};
use std::fmt::Display;
use std::mem::discriminant;
use std::ops::Range;

/// Data on which values of a run depend and which it does not hold, and how its planes stop.
#[derive(Clone, Debug, Default)]
pub struct Target {
    /// The material of each body; `None` for one that is given by masses and springs.
    pub made: Vec<Option<Made>>,
    /// The springs of each body, and of each row of links after them, with the factor of their rest
    /// lengths.
    pub rest_scales: Vec<(Range<usize>, f64)>,
    planes: Vec<(f64, Friction)>,
}

impl Target {
    /// That of a run of a scene as its author wants it.
    pub fn written(loaded: &Loaded) -> Self {
        let Loaded { made, rest_scales, .. } = loaded.clone();
        Target { made, rest_scales, planes: Vec::new() }
    }

    /// The same, with the current planes of a run.
    pub fn of(self, runner: &Runner) -> Self {
        let planes = on!(runner, simulation => {
            let planes = simulation.model().planes().iter();
            planes.map(|plane| (plane.restitution(), plane.friction())).collect()
        });
        Target { planes, ..self }
    }

    /// Returns the interactions that give a key a value in a run of a scene. Collisions of bodies
    /// are set up anew by [`shells_of`] instead, and a solver is set by [`Runner::set_solver`].
    ///
    /// # Errors
    /// A line on a value that the key cannot have, or a key that a run cannot be given.
    pub fn set(&mut self, edit: &Assignment, loaded: &Loaded) -> Result<Vec<Interaction>, String> {
        let row = edit.row();
        let select = row.map_or(Select::All, Select::Body);
        let number = || edit.read::<f64>();
        let scene = &loaded.scene;
        Ok(match edit.live() {
            Live::Restart => return Err(format!("{} cannot change while it runs", edit.key())),
            Live::Touch | Live::Solver => Vec::new(),
            Live::RestScale => self.stretch(edit, scene.bodies.len())?,
            Live::Gravity => {
                vec![Interaction::SetGravity { value: edit.read::<[f64; 3]>()?.into() }]
            }
            Live::Wind => {
                let wind = Wind::from(edit.read::<WindRow>()?).mean();
                vec![Interaction::SetForce { value: loaded.force_in(wind, 0.0) }]
            }
            Live::Drag => vec![Interaction::SetDrag { value: number()? }],
            Live::Plane => return self.set_planes(edit),
            Live::Mass => {
                self.unmake(select);
                vec![Interaction::SetMass { particles: select, value: number()? }]
            }
            Live::Stiffness | Live::Damping => {
                self.unmake(select);
                let own = scene.bodies.last().map_or(0, |body| body.springs.end);
                let count = scene.springs.len();
                let springs = match row {
                    _ if edit.key().starts_with("links") => Select::Range(own, count),
                    None if own < count => Select::Range(0, own),
                    _ => select,
                };
                let value = number()?;
                vec![match edit.live() {
                    Live::Stiffness => Interaction::SetStiffness { springs, value },
                    _ => Interaction::SetDamping { springs, value },
                }]
            }
            Live::Young
            | Live::Thickness
            | Live::Density
            | Live::RelaxationTime
            | Live::Material => {
                let body = row.filter(|&body| self.made.get(body).is_some_and(Option::is_some));
                let body = body.ok_or_else(|| {
                    format!("{} needs a body that is made of a material", edit.key())
                })?;
                return self.remake(body, edit);
            }
            Live::Look => {
                let body = row.filter(|&body| body < scene.bodies.len());
                let body = body
                    .ok_or_else(|| format!("{} names a body that the scene lacks", edit.key()))?;
                let is_sheet = scene.bodies[body].surface.two_sided;
                let look = look_of(edit.read()?, is_sheet).map_err(|error| error.to_string())?;
                vec![Interaction::SetLook { body, look }]
            }
            Live::Off => {
                let parts: Vec<Part> = edit.read()?;
                parts.into_iter().flat_map(|part| off(part, loaded)).collect()
            }
        })
    }

    fn set_planes(&mut self, edit: &Assignment) -> Result<Vec<Interaction>, String> {
        let value: f64 = edit.read()?;
        let mut set = Vec::new();
        for (plane, law) in self.planes.iter_mut().enumerate() {
            if edit.row().is_some_and(|row| row != plane) {
                continue;
            }
            match edit.name() {
                "restitution" => law.0 = value,
                "friction" => law.1 = Friction::Coulomb(value),
                "tangential_loss" => law.1 = Friction::TangentialLoss(value),
                _ => return Err(format!("{} cannot change while it runs", edit.key())),
            }
            let (restitution, friction) = *law;
            set.push(Interaction::SetPlane { plane, restitution, friction });
        }
        Ok(set)
    }

    /// Multiplies rest lengths of bodies or links, of which the scene has so many bodies.
    fn stretch(&mut self, edit: &Assignment, bodies: usize) -> Result<Vec<Interaction>, String> {
        let value: f64 = edit.read()?;
        let first = if edit.key().starts_with("links") { bodies } else { 0 };
        let groups = self.rest_scales.len();
        let rows = match edit.row() {
            Some(row) => first + row..(first + row + 1).min(groups),
            None if first == 0 => 0..bodies.min(groups),
            None => bodies.min(groups)..groups,
        };
        let scale = |(springs, scale): &mut (Range<usize>, f64)| {
            let factor = value / std::mem::replace(scale, value);
            let springs = Select::Range(springs.start, springs.end);
            Interaction::ScaleRestLength { springs, factor }
        };
        let groups = self.rest_scales.get_mut(rows).unwrap_or_default();
        let groups = groups.iter_mut().filter(|(springs, _)| !springs.is_empty());
        Ok(groups.map(scale).collect())
    }

    /// Makes a body of another material.
    fn remake(&mut self, body: usize, edit: &Assignment) -> Result<Vec<Interaction>, String> {
        let Some(made) = &mut self.made[body] else { return Ok(Vec::new()) };
        let bodies = Select::Body(body);
        let lacking = || format!("{} does not apply to this body", edit.key());
        let scale = |number, was: &mut f64, value: f64| {
            let factor = value / *was;
            *was = value;
            Interaction::ScaleMaterial { bodies, number, factor }
        };
        let young = |made: &mut Made, value| {
            let was = made.young.as_mut().ok_or_else(lacking)?;
            Ok::<_, String>(scale(MaterialNumber::Young, was, value))
        };
        let damp = |made: &mut Made, value| {
            made.relaxation_time = value;
            Interaction::SetRelaxationTime { bodies, value }
        };
        let name = made.material.take();
        Ok(match edit.live() {
            Live::Young => vec![young(made, edit.read()?)?],
            Live::Thickness => {
                let was = made.thickness.as_mut().ok_or_else(lacking)?;
                vec![scale(MaterialNumber::Thickness, was, edit.read()?)]
            }
            Live::Density => {
                vec![scale(MaterialNumber::Density, &mut made.density, edit.read()?)]
            }
            Live::RelaxationTime => vec![damp(made, edit.read()?)],
            _ => {
                made.material = name;
                let known = named(&edit.read::<String>()?).ok_or_else(lacking)?;
                let Numbers::Uniform { young: modulus, density, relaxation_time, .. } =
                    known.numbers
                else {
                    return Err(lacking());
                };
                let acts = vec![
                    young(made, modulus)?,
                    scale(MaterialNumber::Density, &mut made.density, density),
                    damp(made, relaxation_time),
                ];
                made.material = Some(known.name);
                acts
            }
        })
    }

    /// Springs or masses of some bodies are set alike: these are made of that material no more.
    fn unmake(&mut self, bodies: Select) {
        match bodies {
            Select::Body(body) => self.made.get_mut(body).into_iter().for_each(|made| *made = None),
            _ => self.made.fill(None),
        }
    }
}

/// Gives a run of a scene all edited values except its solver; returns the data on which they then
/// depend.
///
/// # Errors
/// A line on a value that the scene refuses.
pub fn set_all(runner: &mut Runner, loaded: &Loaded, edits: &Edits) -> Result<Target, String> {
    let set = queue_all(runner, loaded, edits);
    if set.is_err() {
        on!(runner, simulation => simulation.clear_queue());
    }
    set
}

fn queue_all(runner: &mut Runner, loaded: &Loaded, edits: &Edits) -> Result<Target, String> {
    let mut target = Target::written(loaded).of(runner);
    let refused = |error: &dyn Display| format!("{}: {error}", loaded.name);
    let (last, first): (Vec<_>, Vec<_>) = edits.iter().partition(|edit| edit.live() == Live::Off);
    for edit in first.into_iter().chain(last) {
        let acts = target.set(edit, loaded).map_err(|error| refused(&error))?;
        acts.into_iter().try_for_each(|act| runner.queue(act)).map_err(|error| refused(&error))?;
    }
    runner.apply_queued().map_err(|error| refused(&error))?;
    if let Some(edit) = edits.of("world.wind") {
        runner.set_wind(loaded, edit.read::<WindRow>()?.into());
    }
    if edits.iter().any(|edit| edit.live() == Live::Touch) {
        let shells = shells_of(&loaded.scene, edits.iter()).map_err(|error| refused(&error))?;
        runner.set_shells(&shells).map_err(|error| refused(&error))?;
    }
    Ok(target)
}

/// Returns the interactions that switch a part of a scene off: its springs stay in place, with
/// neither stiffness nor damping.
pub fn off(part: Part, loaded: &Loaded) -> Vec<Interaction> {
    let scene = &loaded.scene;
    let count = scene.springs.len();
    let damping = |springs| Interaction::SetDamping { springs, value: 0.0 };
    match part {
        Part::Gravity => vec![Interaction::SetGravity { value: Default::default() }],
        Part::Drag => vec![Interaction::SetDrag { value: 0.0 }],
        Part::Contact => vec![Interaction::RemovePlanes],
        Part::Damping => {
            // Bends and volumes, which bodies of a material have, are damped too.
            let undamped = |bodies| Interaction::SetRelaxationTime { bodies, value: 0.0 };
            let made = made_bodies(loaded).map(undamped);
            std::iter::once(damping(Select::All)).chain(made).collect()
        }
        Part::FaceDiagonals | Part::SpaceDiagonals | Part::BendingSprings => {
            let rows = part.found_in(scene).unwrap_or_default().into_iter();
            rows.flat_map(|range| {
                let springs = select(range, count);
                [damping(springs), Interaction::SetStiffness { springs, value: 0.0 }]
            })
            .collect()
        }
    }
}

/// The key of the parts that are switched off.
const OFF: &str = "off";

/// The parts that are switched off.
pub fn parts_off(set: &Edits) -> Vec<Part> {
    set.of(OFF).and_then(|edit| edit.read().ok()).unwrap_or_default()
}

/// Says which parts are switched off.
pub fn keep_off(parts: &[Part], set: &mut Edits) {
    set.forget(OFF);
    if !parts.is_empty() {
        set.set(Assignment::new(OFF, parts));
    }
}

/// Returns the interactions that keep springs of parts off after acts that set constants of
/// springs.
pub fn off_again(parts: &[Part], acts: &[Interaction], loaded: &Loaded) -> Vec<Interaction> {
    use Part::{BendingSprings, FaceDiagonals, SpaceDiagonals};
    let sets = |off: &Interaction| acts.iter().any(|act| discriminant(act) == discriminant(off));
    let kinds =
        parts.iter().filter(|part| matches!(part, FaceDiagonals | SpaceDiagonals | BendingSprings));
    kinds.flat_map(|&part| off(part, loaded)).filter(sets).collect()
}

/// The bodies of a scene that are made of a material.
pub fn made_bodies(loaded: &Loaded) -> impl Iterator<Item = Select> + '_ {
    let made = loaded.made.iter().enumerate();
    made.filter(|(_, made)| made.is_some()).map(|(body, _)| Select::Body(body))
}

/// The springs of a range of rows, of so many in all.
pub fn select(range: Range<usize>, count: usize) -> Select {
    if range == (0..count) { Select::All } else { Select::Range(range.start, range.end) }
}
