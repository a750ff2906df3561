//! Links of earlier formats, whose interactions are converted to keys of their scenes.

use super::{Changes, Look};
use msd_core::{Friction, Interaction, MaterialNumber, Select, Settings};
use msd_scene::materials::Made;
use msd_scene::parts::Part;
use msd_scene::schema::{Solver, WindRow};
use msd_scene::{Assignment, Edits, Loaded, Precision, Wind, look_row};
use serde::Deserialize;
use std::ops::Range;

/// Content of links of formats 3 and 4 besides keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Former {
    /// Changes of rest lengths; in format 3 all changes, the oldest first.
    edits: Vec<Interaction>,
    /// Strength, newtons, heading, radians, and gusts of the wind; in format 4 it is a key.
    wind: [f64; 3],
}

/// Content of formats 3 and 4. Format 3 ends with the look.
#[derive(Deserialize)]
struct Content {
    settings: Settings,
    automatic: bool,
    precision: Precision,
    edits: Vec<Interaction>,
    wind: [f64; 3],
    speed: f64,
    look: Look,
    set: Edits,
}

/// Decodes the changes in a link of an earlier format; `None` if it is damaged.
pub(super) fn changes(format: u8, mut content: Vec<u8>) -> Option<Changes> {
    if format == 3 {
        // Format 3 has no keys: an empty list stands for them.
        content.push(0);
    }
    let Content { settings, automatic, precision, edits, wind, speed, look, mut set } =
        postcard::from_bytes(&content).ok()?;
    let row = Solver { settings, precision, automatic }.row();
    row.assignments().for_each(|edit| set.set(edit));
    Some(Changes { speed, look, set, former: Some(Former { edits, wind }) })
}

impl Former {
    /// Returns whether it holds settings alone.
    pub(super) fn is_usable(&self) -> bool {
        use Interaction::*;
        let is_material = |edit: &Interaction| {
            matches!(
                edit,
                SetStiffness { .. }
                    | SetDamping { .. }
                    | SetMass { .. }
                    | ScaleRestLength { .. }
                    | ScaleMaterial { .. }
                    | SetRelaxationTime { .. }
            )
        };
        let is_world = |edit: &Interaction| {
            matches!(
                edit,
                SetGravity { .. }
                    | SetDrag { .. }
                    | SetPlane { .. }
                    | RemovePlanes
                    | AddPlane { .. }
                    | SetLook { .. }
            )
        };
        self.edits.iter().all(|edit| is_material(edit) || is_world(edit))
            && self.wind.iter().all(|number| number.is_finite())
    }

    /// Returns the same changes as keys of the scene.
    pub(super) fn keys(&self, loaded: &Loaded) -> Edits {
        keys_of(&self.edits, self.wind, loaded)
    }
}

/// Converts the interactions and the wind of a window to keys.
fn keys_of(edits: &[Interaction], wind: [f64; 3], loaded: &Loaded) -> Edits {
    use Interaction::*;
    let (mut set, mut off, mut made) = (Edits::default(), Vec::new(), loaded.made.clone());
    let mut stretched = loaded.rest_scales.clone();
    let scene = &loaded.scene;
    for edit in edits {
        match *edit {
            SetStiffness { springs: rows @ Select::Range(..), .. }
            | SetDamping { springs: rows @ Select::Range(..), .. } => {
                off.extend(kind(rows, loaded))
            }
            SetStiffness { springs, value } => {
                of_springs(&mut set, ("stiffness", springs, value), loaded);
            }
            SetDamping { springs: Select::All, value: 0.0 } => off.push(Part::Damping),
            SetDamping { springs, value } => {
                off.retain(|&part| part != Part::Damping);
                of_springs(&mut set, ("damping", springs, value), loaded);
            }
            SetMass { particles, value } => of_bodies(&mut set, ("mass", particles, value)),
            SetRelaxationTime { value: 0.0, .. } if off.contains(&Part::Damping) => {}
            SetRelaxationTime { bodies, value } => {
                of_bodies(&mut set, ("relaxation_time", bodies, value));
            }
            ScaleMaterial { bodies: Select::Body(body), number, factor } => {
                if let Some(Some(made)) = made.get_mut(body) {
                    of_material(&mut set, (body, made), (number, factor));
                }
            }
            ScaleRestLength { springs, factor } => {
                of_rest_lengths(&mut set, &mut stretched, (springs, factor), loaded);
            }
            SetGravity { value } => set.set(Assignment::new("world.gravity", value.to_array())),
            SetDrag { value } => set.set(Assignment::new("world.drag", value)),
            SetPlane { plane, restitution, friction } => {
                of_plane(&mut set, (plane, restitution, friction));
            }
            RemovePlanes => {
                set.forget("world.planes");
                off.push(Part::Contact);
            }
            AddPlane { .. } => off.retain(|&part| part != Part::Contact),
            SetLook { body, ref look } if body < scene.bodies.len() => {
                set.set(Assignment::new(&format!("bodies[{body}].look"), look_row(look)));
            }
            _ => {}
        }
    }
    let [strength, heading, gusts] = wind;
    if 0.0 < strength {
        let wind = WindRow::from(Wind { strength, heading, gusts });
        set.set(Assignment::new("world.wind", wind));
    }
    off.sort();
    off.dedup();
    if !off.is_empty() {
        set.set(Assignment::new("off", off));
    }
    set
}

/// Returns the kind of springs that a range belongs to.
fn kind(rows: Select, loaded: &Loaded) -> Option<Part> {
    let Select::Range(start, _) = rows else { return None };
    let kinds = [Part::FaceDiagonals, Part::SpaceDiagonals, Part::BendingSprings];
    kinds.into_iter().find(|kind| {
        let found = kind.found_in(&loaded.scene).unwrap_or_default();
        found.iter().any(|range| range.contains(&start))
    })
}

fn of_bodies(set: &mut Edits, (name, bodies, value): (&str, Select, f64)) {
    let key = match bodies {
        Select::Body(body) => format!("bodies[{body}].{name}"),
        _ => format!("bodies.{name}"),
    };
    set.set(Assignment::new(&key, value));
}

fn of_springs(set: &mut Edits, (name, springs, value): (&str, Select, f64), loaded: &Loaded) {
    of_bodies(set, (name, springs, value));
    let own = loaded.scene.bodies.last().map_or(0, |body| body.springs.end);
    if springs == Select::All && own < loaded.scene.springs.len() {
        set.set(Assignment::new(&format!("links.{name}"), value));
    }
}

/// Sets the keys of rest lengths that were multiplied, of all springs or of a body.
fn of_rest_lengths(
    set: &mut Edits,
    stretched: &mut [(Range<usize>, f64)],
    (springs, factor): (Select, f64),
    loaded: &Loaded,
) {
    let bodies = loaded.scene.bodies.len();
    for (row, (_, scale)) in stretched.iter_mut().enumerate() {
        if matches!(springs, Select::Body(body) if body != row) {
            continue;
        }
        *scale *= factor;
        let key = match row.checked_sub(bodies) {
            None => format!("bodies[{row}].rest_scale"),
            Some(link) => format!("links[{link}].rest_scale"),
        };
        set.set(Assignment::new(&key, *scale));
    }
}

fn of_material(
    set: &mut Edits,
    (body, made): (usize, &mut Made),
    (number, factor): (MaterialNumber, f64),
) {
    let is_woven = made.young.is_none();
    let (name, value) = match number {
        MaterialNumber::Young => ("young", made.young.as_mut()),
        MaterialNumber::Thickness => ("thickness", made.thickness.as_mut()),
        _ if is_woven => ("area_density", Some(&mut made.density)),
        _ => ("density", Some(&mut made.density)),
    };
    if let Some(value) = value {
        *value *= factor;
        of_bodies(set, (name, Select::Body(body), *value));
    }
}

fn of_plane(set: &mut Edits, (plane, restitution, friction): (usize, f64, Friction)) {
    let mut key = |name: &str, value: f64| {
        set.set(Assignment::new(&format!("world.planes[{plane}].{name}"), value));
    };
    key("restitution", restitution);
    match friction {
        Friction::Coulomb(friction) => key("friction", friction),
        Friction::TangentialLoss(loss) => key("tangential_loss", loss),
    }
}
