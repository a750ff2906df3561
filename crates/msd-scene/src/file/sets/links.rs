//! Springs between bodies and to solids: each particle of one set to the nearest of another, or to
//! the nearest point of a surface.

use super::pins::own_place;
use super::{NamedSets, solid};
use crate::error::{FileError, plain};
use crate::file::budget::Budget;
use crate::file::schema::{EndRow, LinkRow, SolidRow};
use crate::nearby::Nearest;
use glam::DVec3;
use msd_core::obstacles::{Obstacle, Placed};
use msd_core::{Guide, Lead, Material, Particle, Pin, Scene, Spring};
use std::collections::BTreeSet;
use std::ops::Range;

/// The springs of all rows, those of a row in the order of its particles.
///
/// # Errors
/// A row that chooses no particle, or that joins none; a value outside its domain; more springs
/// than fit.
pub(crate) fn links(
    sets: &NamedSets<'_>,
    (rows, solids): (&[LinkRow], &[SolidRow]),
    budget: &mut Budget,
) -> Result<Links, FileError> {
    let mut all = Links::default();
    for (row, link) in rows.iter().enumerate() {
        let key = format!("links[{row}]");
        let source = sets.source;
        if link.from.solid.is_some() {
            let reason = "is of `to` alone: each particle of `from` is joined to a point of it";
            return Err(source.refuse(format_args!("{key}.from.solid"), reason));
        }
        let from = sets.particles(&format!("{key}.from"), &link.from)?;
        let law = law(sets, &key, link)?;
        let ends = match &link.to.solid {
            Some(solid) => {
                budget.take(source, format_args!("{key}"), [from.len() as u128; 2])?;
                let key = format!("{key}.to.solid");
                if let Some(name) = particles_of(&link.to) {
                    let reason = format!("and {name} exclude each other");
                    return Err(source.refuse(format_args!("{key}"), reason));
                }
                let solid = self::solid(source, &key, solid, solids)?;
                all.anchors.join(sets, &from, (solid, law.within))
            }
            None => {
                budget.take(source, format_args!("{key}"), [0, from.len() as u128])?;
                nearest(sets, (&key, link), &from, law.within)?
            }
        };
        if ends.joined.is_empty() {
            let least = plain(rounded_up(ends.closest));
            let expected = format!("at least {least}, the distance of the nearest two");
            let key = format_args!("{key}.within");
            return Err(source.out_of_domain(key, plain(law.within), expected));
        }
        let Material { stiffness, damping, .. } = law.material;
        let first = all.springs.len();
        all.springs.extend(ends.joined.into_iter().map(|(ends, distance)| Spring {
            ends,
            rest_length: law.rest_length.unwrap_or(distance) * law.rest_scale,
            stiffness,
            damping,
        }));
        all.scales.push((first..all.springs.len(), law.rest_scale));
    }
    Ok(all)
}

/// The links of a scene.
#[derive(Default)]
pub(crate) struct Links {
    pub(crate) springs: Vec<Spring>,
    /// The range of springs of each row, and its factor of their rest lengths.
    pub(crate) scales: Vec<(Range<usize>, f64)>,
    /// Where some of them end.
    pub(crate) anchors: Anchors,
}

/// The particles that the springs of a row join.
struct Ends {
    /// The two particles of each, with their distance, metres.
    joined: Vec<([usize; 2], f64)>,
    /// The distance of the nearest two that could be joined, metres.
    closest: f64,
}

/// The key by which an end chooses particles, if it does.
fn particles_of(end: &EndRow) -> Option<&'static str> {
    let EndRow { body, particle, at, set, .. } = end;
    let given = [
        ("body", body.is_some()),
        ("particle", particle.is_some()),
        ("at", at.is_some()),
        ("set", set.is_some()),
    ];
    given.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
}

/// Each particle with the nearest of the other end.
fn nearest(
    sets: &NamedSets<'_>,
    (key, link): (&str, &LinkRow),
    from: &[usize],
    within: f64,
) -> Result<Ends, FileError> {
    let scene = sets.scene;
    let to = sets.particles(&format!("{key}.to"), &link.to)?;
    let places: Vec<DVec3> = to.iter().map(|&end| scene.particles[end].position).collect();
    let nearest = Nearest::new(&places);
    let mut ends = Ends { joined: Vec::new(), closest: f64::INFINITY };
    let mut pairs = BTreeSet::new();
    for &a in from {
        let place = scene.particles[a].position;
        let Some(row) = nearest.find(place, |row| to[row] != a) else {
            let reason = format!("joins particle {a} of the scene to itself; its ends must differ");
            return Err(sets.source.refuse(format_args!("{key}"), reason));
        };
        let (b, distance) = (to[row], place.distance(places[row]));
        ends.closest = ends.closest.min(distance);
        // Two of one body may be the nearest of each other.
        if distance <= within && pairs.insert([a.min(b), a.max(b)]) {
            ends.joined.push(([a, b], distance));
        }
    }
    Ok(ends)
}

/// Points of solids, each a particle of its own that is pinned and follows its solid. None belongs
/// to a body.
#[derive(Default)]
pub(crate) struct Anchors {
    particles: Vec<Particle>,
    /// The solid of each.
    solids: Vec<usize>,
}

/// The mass of an anchor as a part of that of its particle: it is in no balance of energy then, nor
/// in a total mass.
const ANCHOR: f64 = 1e-6;

impl Anchors {
    /// Joins particles each to the nearest point of a solid at the start.
    fn join(
        &mut self,
        sets: &NamedSets<'_>,
        from: &[usize],
        (number, within): (usize, f64),
    ) -> Ends {
        let scene = sets.scene;
        let solid = Placed::new(&scene.solids[number], 0.0);
        let mut ends = Ends { joined: Vec::new(), closest: f64::INFINITY };
        for &a in from {
            let Particle { position, mass, .. } = scene.particles[a];
            let gap = Obstacle::<f64>::gap(&solid, position, 0.0);
            let point = position - Obstacle::<f64>::normal(&solid, position, 0.0) * gap;
            let distance = position.distance(point);
            ends.closest = ends.closest.min(distance);
            if distance <= within {
                let anchor = scene.particles.len() + self.particles.len();
                ends.joined.push(([a, anchor], distance));
                let (velocity, mass) = (DVec3::ZERO, mass * ANCHOR);
                self.particles.push(Particle { position: point, velocity, mass });
                self.solids.push(number);
            }
        }
        ends
    }

    /// Adds them to a scene, after all others, pinned and guided.
    pub(crate) fn add_to(self, scene: &mut Scene) {
        let first = scene.particles.len();
        for solid in self.solids.iter().copied().collect::<BTreeSet<usize>>() {
            let rows = (0..self.solids.len()).filter(|&row| self.solids[row] == solid);
            let place = |row: usize| own_place(&scene.solids[solid], self.particles[row].position);
            let held = rows.map(|row| (first + row, place(row))).collect();
            scene.guides.push(Guide { held, lead: Lead::Solid(solid), until: None });
        }
        let pin = |row| Pin { particle: first + row, velocity: DVec3::ZERO };
        scene.pins.extend((0..self.particles.len()).map(pin));
        scene.particles.extend(self.particles);
    }
}

/// A length in six digits, rounded up: a user who enters it has the length.
fn rounded_up(length: f64) -> f64 {
    let rounded = |length: f64| format!("{length:.5e}").parse().unwrap_or(length);
    let near = rounded(length);
    if length <= near { near } else { rounded(length * (1.0 + 1e-5)) }
}

/// The law that the springs of a row share.
struct Law {
    /// The largest distance at which it joins two, metres.
    within: f64,
    /// Length without force; none where it is the distance of the ends.
    rest_length: Option<f64>,
    /// The factor of that length.
    rest_scale: f64,
    /// Its stiffness and damping.
    material: Material,
}

fn law(sets: &NamedSets<'_>, key: &str, link: &LinkRow) -> Result<Law, FileError> {
    let source = sets.source;
    let default = Material::default();
    let rest_length = match link.rest_length {
        Some(length) => Some(source.number(format_args!("{key}.rest_length"), length)?),
        None => None,
    };
    let rest_scale = link.rest_scale.unwrap_or(1.0);
    let rest_scale = source.number(format_args!("{key}.rest_scale"), rest_scale)?;
    let stiffness = link.stiffness.unwrap_or(default.stiffness);
    let damping = link.damping.unwrap_or(default.damping);
    let material = Material {
        stiffness: source.number(format_args!("{key}.stiffness"), stiffness)?,
        damping: source.number(format_args!("{key}.damping"), damping)?,
        ..default
    };
    let within = match link.within {
        Some(within) => source.number(format_args!("{key}.within"), within)?,
        None => f64::INFINITY,
    };
    Ok(Law { within, rest_length, rest_scale, material })
}

#[cfg(test)]
mod tests {
    use super::rounded_up;

    #[test]
    fn a_length_is_rounded_to_one_that_is_enough() {
        let lengths = [0.49999999999999994, 0.1 + 0.2, 1.0000001, 3e-7, 0.0];
        assert_eq!(lengths.map(rounded_up), [0.5, 0.300003, 1.00001, 3e-7, 0.0]);
    }
}
