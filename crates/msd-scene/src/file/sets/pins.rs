//! Pins, their guides, and masses of chosen particles.

use super::{NamedSets, solid};
use crate::error::FileError;
use crate::file::keys::Domain;
use crate::file::schema::{BodyRow, MassRow, PinRow, SolidRow};
use crate::file::tree::Source;
use crate::file::turn::{key_frames, spin};
use glam::{DMat3, DVec3};
use msd_core::{Guide, KeyFrame, Lead, Pin, Scene, Solid};
use std::collections::BTreeMap;

/// The pins of all rows.
#[derive(Default)]
pub(crate) struct Pins {
    pub(crate) pins: Vec<Pin>,
    /// The guides of some of them.
    pub(crate) guides: Vec<Guide>,
    /// See [`crate::Loaded::held`].
    pub(crate) held: Vec<(String, Vec<usize>)>,
}

/// Reads the pins of all rows.
///
/// # Errors
/// A row that chooses no particle, or one that is pinned already; sets may share particles that
/// they move alike. A motion that is given twice, or of a solid that is not there.
pub(crate) fn pins(
    sets: &NamedSets<'_>,
    (rows, solids): (&[PinRow], &[SolidRow]),
) -> Result<Pins, FileError> {
    let source = sets.source;
    let mut holders: BTreeMap<usize, usize> = BTreeMap::new();
    let mut all = Pins::default();
    for (row, pin) in rows.iter().enumerate() {
        let key = format!("pins[{row}]");
        let particles = sets.particles(&key, pin)?;
        let velocity = pin.velocity.unwrap_or_default();
        let velocity = source.vector(format_args!("{key}.velocity"), velocity)?;
        let lead = lead(sets, (&key, pin), &particles, solids)?;
        if let Some(set) = &pin.set {
            let is_taken = all.held.iter().any(|(name, _)| name == set);
            let name = if is_taken { key.clone() } else { set.clone() };
            all.held.push((name, particles.clone()));
        }
        let mut held = Vec::new();
        for particle in particles {
            let Some(other) = holders.insert(particle, row) else {
                all.pins.push(Pin { particle, velocity });
                held.push(particle);
                continue;
            };
            if let Some(why) = apart(pin, &rows[other]) {
                let reason = format!(
                    "and pins[{other}] hold the same particle, number {particle} of the scene{why}"
                );
                return Err(source.refuse(format_args!("{key}"), reason));
            }
        }
        if let Some(lead) = lead {
            let place = |particle: usize| {
                let place = sets.scene.particles[particle].position;
                match &lead {
                    Lead::Solid(solid) => own_place(&sets.scene.solids[*solid], place),
                    Lead::Path { position, .. } => place - *position,
                }
            };
            let held = held.into_iter().map(|particle| (particle, place(particle))).collect();
            all.guides.push(Guide { held, lead, until: pin.until });
        }
    }
    Ok(all)
}

/// A place from the middle of a solid at the start, in the axes of that, metres.
pub(super) fn own_place(solid: &Solid, place: DVec3) -> DVec3 {
    solid.axes.transpose() * (place - solid.position)
}

/// Why two pins may not share particles, if they may not: sets may that move alike.
fn apart(one: &PinRow, other: &PinRow) -> Option<&'static str> {
    let speed = |pin: &PinRow| pin.velocity.unwrap_or_default();
    match () {
        () if one.set.is_none() || other.set.is_none() => Some(""),
        () if one.key_frames.is_some() || other.key_frames.is_some() => {
            Some("; sets on `key_frames` may not, as each turns about its own middle")
        }
        () if one.follow != other.follow => Some("; their `follow` differs"),
        () if speed(one) != speed(other) => Some("; their `velocity` differs"),
        () if one.until != other.until => Some("; their `until` differs"),
        () => None,
    }
}

/// The lead of the particles of the pin at `key`; none where it is a velocity that never ends.
fn lead(
    sets: &NamedSets<'_>,
    (key, pin): (&str, &PinRow),
    particles: &[usize],
    solids: &[SolidRow],
) -> Result<Option<Lead>, FileError> {
    let source = sets.source;
    let given = [
        ("velocity", pin.velocity.is_some()),
        ("follow", pin.follow.is_some()),
        ("key_frames", pin.key_frames.is_some()),
    ];
    let mut given = given.iter().filter(|(_, is_given)| *is_given).map(|&(name, _)| name);
    if let (Some(one), Some(other)) = (given.next(), given.next()) {
        let reason = format!("and {other} exclude each other: a pin moves by one of them");
        return Err(source.refuse(format_args!("{key}.{one}"), reason));
    }
    if let Some(until) = pin.until {
        source.number(format_args!("{key}.until"), until)?;
    }
    if let Some(solid) = &pin.follow {
        let solid = self::solid(source, &format!("{key}.follow"), solid, solids)?;
        return Ok(Some(Lead::Solid(solid)));
    }
    let places = particles.iter().map(|&particle| sets.scene.particles[particle].position);
    let first = sets.scene.particles[particles[0]].position;
    let (low, high) = places.fold((first, first), |(low, high), x| (low.min(x), high.max(x)));
    let position = low + (high - low) * 0.5;
    let keys = match &pin.key_frames {
        None if pin.until.is_none() => return Ok(None),
        None => Vec::new(),
        Some(rows) => {
            let start = KeyFrame { time: 0.0, position, axes: DMat3::IDENTITY };
            key_frames(source, (key, rows), start, sets.scene.world.extent)?
        }
    };
    let velocity = DVec3::from_array(pin.velocity.unwrap_or_default());
    Ok(Some(Lead::Path { since: 0.0, position, velocity, keys }))
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
