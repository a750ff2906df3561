//! Interactions of links of the former format, as keys of their scenes.

use super::FormerWind;
use msd_core::{Friction, Interaction, MaterialNumber, Select};
use msd_scene::materials::Made;
use msd_scene::parts::Part;
use msd_scene::schema::WindRow;
use msd_scene::{Assignment, Edits, Loaded, Wind, look_row};

/// The keys that interactions and a wind have set, which a window has made.
pub(super) fn keys_of(edits: &[Interaction], wind: FormerWind, loaded: &Loaded) -> Edits {
    use Interaction::*;
    let (mut set, mut off, mut made) = (Edits::default(), Vec::new(), loaded.made.clone());
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

/// The kind of springs that rows are of.
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
