//! Springs between bodies: each particle of one set to the nearest of another.

use super::NamedSets;
use crate::error::{FileError, plain};
use crate::file::budget::Budget;
use crate::file::schema::LinkRow;
use crate::nearby::Nearest;
use glam::DVec3;
use msd_core::{Material, Spring};
use std::collections::BTreeSet;

/// The springs of all rows, those of a row in the order of its particles.
///
/// # Errors
/// A row that chooses no particle, or that joins none; a value outside its domain; more springs
/// than fit.
pub(crate) fn links(
    sets: &NamedSets<'_>,
    rows: &[LinkRow],
    budget: &mut Budget,
) -> Result<Vec<Spring>, FileError> {
    let (source, scene) = (sets.source, sets.scene);
    let mut springs = Vec::new();
    for (row, link) in rows.iter().enumerate() {
        let key = format!("links[{row}]");
        let from = sets.particles(&format!("{key}.from"), &link.from)?;
        let to = sets.particles(&format!("{key}.to"), &link.to)?;
        budget.take(source, format_args!("{key}"), [0, from.len() as u128])?;
        let law = law(sets, &key, link)?;
        let places: Vec<DVec3> = to.iter().map(|&end| scene.particles[end].position).collect();
        let nearest = Nearest::new(&places);
        let within = match link.within {
            Some(within) => source.number(format_args!("{key}.within"), within)?,
            None => f64::INFINITY,
        };
        let mut closest = f64::INFINITY;
        let mut joined = BTreeSet::new();
        for a in from {
            let place = scene.particles[a].position;
            let Some(row) = nearest.find(place, |row| to[row] != a) else {
                let reason =
                    format!("joins particle {a} of the scene to itself; its ends must differ");
                return Err(source.refuse(format_args!("{key}"), reason));
            };
            let (b, distance) = (to[row], place.distance(places[row]));
            closest = closest.min(distance);
            // Two of one body may be the nearest of each other.
            if distance <= within && joined.insert([a.min(b), a.max(b)]) {
                let rest_length = law.rest_length.unwrap_or(distance);
                let Material { stiffness, damping, .. } = law.material;
                springs.push(Spring { ends: [a, b], rest_length, stiffness, damping });
            }
        }
        if joined.is_empty() {
            let least = plain(rounded_up(closest));
            let expected = format!("at least {least}, the distance of the nearest two");
            let key = format_args!("{key}.within");
            return Err(source.out_of_domain(key, plain(within), expected));
        }
    }
    Ok(springs)
}

/// A length in six digits, none shorter: whoever takes it has the length.
fn rounded_up(length: f64) -> f64 {
    let rounded = |length: f64| format!("{length:.5e}").parse().unwrap_or(length);
    let near = rounded(length);
    if length <= near { near } else { rounded(length * (1.0 + 1e-5)) }
}

/// What the springs of a row have in common.
struct Law {
    /// Length without force; none where it is the distance of the ends.
    rest_length: Option<f64>,
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
    let stiffness = link.stiffness.unwrap_or(default.stiffness);
    let damping = link.damping.unwrap_or(default.damping);
    let material = Material {
        stiffness: source.number(format_args!("{key}.stiffness"), stiffness)?,
        damping: source.number(format_args!("{key}.damping"), damping)?,
        ..default
    };
    Ok(Law { rest_length, material })
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
