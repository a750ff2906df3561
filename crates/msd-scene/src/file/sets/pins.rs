//! Pins and masses of chosen particles.

use super::NamedSets;
use crate::error::FileError;
use crate::file::keys::Domain;
use crate::file::schema::{BodyRow, MassRow, PinRow};
use crate::file::tree::Source;
use crate::file::turn::spin;
use glam::DVec3;
use msd_core::{Pin, Scene};
use std::collections::BTreeMap;

/// The pins of all rows.
///
/// # Errors
/// A row that chooses no particle, or one that is pinned already; sets may share particles that
/// they move alike.
pub(crate) fn pins(sets: &NamedSets<'_>, rows: &[PinRow]) -> Result<Vec<Pin>, FileError> {
    let source = sets.source;
    let mut held: BTreeMap<usize, (usize, DVec3)> = BTreeMap::new();
    let mut pins = Vec::new();
    for (row, pin) in rows.iter().enumerate() {
        let key = format!("pins[{row}]");
        let particles = sets.particles(&key, pin)?;
        let velocity = pin.velocity.unwrap_or_default();
        let velocity = source.vector(format_args!("{key}.velocity"), velocity)?;
        for particle in particles {
            let Some((other, pull)) = held.insert(particle, (row, velocity)) else {
                pins.push(Pin { particle, velocity });
                continue;
            };
            let are_sets = pin.set.is_some() && rows[other].set.is_some();
            if !are_sets || pull != velocity {
                let reason = format!(
                    "and pins[{other}] hold the same particle, number {particle} of the scene"
                );
                return Err(source.refuse(format_args!("{key}"), reason));
            }
        }
    }
    Ok(pins)
}

/// The masses that rows put on particles, kilograms.
///
/// # Errors
/// A row that chooses no particle; a mass outside its domain, or too large with that of a particle.
pub(crate) fn masses(
    sets: &NamedSets<'_>,
    rows: &[MassRow],
) -> Result<BTreeMap<usize, f64>, FileError> {
    let source = sets.source;
    let mut loads = BTreeMap::new();
    for (row, load) in rows.iter().enumerate() {
        let key = format!("masses[{row}]");
        source.number(format_args!("{key}.mass"), load.mass)?;
        for particle in sets.particles(&key, load)? {
            let sum = loads.entry(particle).or_insert(0.0);
            *sum += load.mass;
            let whole = sets.scene.particles[particle].mass + *sum;
            source.number_in(Domain::Mass, format_args!("{key}.mass"), whole)?;
        }
    }
    Ok(loads)
}

/// Puts masses on particles. A body that spins does so about the centre of mass that it then has.
///
/// # Errors
/// A spin that no body may have.
pub(crate) fn load(
    source: &Source<'_>,
    scene: &mut Scene,
    (bodies, loads): (&[BodyRow], &BTreeMap<usize, f64>),
) -> Result<(), FileError> {
    for (row, body) in bodies.iter().enumerate() {
        let range = scene.bodies[row].particles.clone();
        if loads.range(range.clone()).next().is_none() {
            continue;
        }
        let particles = &mut scene.particles[range.clone()];
        let centre = |particles: &[msd_core::Particle]| {
            let mass: f64 = particles.iter().map(|particle| particle.mass).sum();
            let moment: DVec3 = particles.iter().map(|p| p.position * p.mass).sum();
            moment / mass
        };
        let before = centre(particles);
        for (&particle, &mass) in loads.range(range.clone()) {
            particles[particle - range.start].mass += mass;
        }
        let spin = spin(source, &format!("bodies[{row}]"), body.spin)?;
        if spin != DVec3::ZERO {
            let change = spin.cross(before - centre(particles));
            particles.iter_mut().for_each(|particle| particle.velocity += change);
        }
    }
    Ok(())
}
