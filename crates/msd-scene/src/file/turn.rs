//! Rotations, spins and key frames of bodies, solids and pins, the same bits on every machine.

use crate::error::FileError;
use crate::file::keys::Domain;
use crate::file::schema::{KeyFrameRow, RotationRow, Spin};
use crate::file::tree::Source;
use glam::{DMat3, DVec3};
use msd_core::KeyFrame;
use msd_core::scene::solid::rotation;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// The rotation of the row at `key`.
pub(crate) fn turn(
    source: &Source<'_>,
    key: &str,
    row: Option<RotationRow>,
) -> Result<DMat3, FileError> {
    let Some(row) = row else { return Ok(DMat3::IDENTITY) };
    let axis = source.direction(format_args!("{key}.rotation.axis"), row.axis)?;
    let angle = format_args!("{key}.rotation.angle_deg");
    Ok(rotation(axis, source.number_in(Domain::Finite, angle, row.angle_deg)?.to_radians()))
}

/// The key frames of the row at `key`, after its start.
pub(crate) fn key_frames(
    source: &Source<'_>,
    (key, rows): (&str, &[KeyFrameRow]),
    start: KeyFrame,
    extent: f64,
) -> Result<Vec<KeyFrame>, FileError> {
    if rows.is_empty() {
        let reason = "must not be empty; omit it for what stays where it is";
        return Err(source.refuse(format_args!("{key}.key_frames"), reason));
    }
    let mut before = start;
    let mut frames = Vec::with_capacity(rows.len());
    for (row, frame) in rows.iter().enumerate() {
        let key = format!("{key}.key_frames[{row}]");
        let time = source.number(format_args!("{key}.time"), frame.time)?;
        if time <= before.time {
            let reason = format!("is {time}; it must be later than {}", before.time);
            return Err(source.refuse(format_args!("{key}.time"), reason));
        }
        let position = match frame.position {
            Some(position) => source.position(format_args!("{key}.position"), position, extent)?,
            None => before.position,
        };
        let axes = match frame.rotation {
            Some(rotation) => turn(source, &key, Some(rotation))?,
            None => before.axes,
        };
        before = KeyFrame { time, position, axes };
        frames.push(before);
    }
    Ok(frames)
}

/// The angular velocity of the row at `key`, radians per second.
pub(crate) fn spin(source: &Source<'_>, key: &str, row: Option<Spin>) -> Result<DVec3, FileError> {
    let about = match row {
        None => return Ok(DVec3::ZERO),
        Some(Spin::Vector(spin)) => return source.vector(format_args!("{key}.spin"), spin),
        Some(Spin::About(about)) => about,
    };
    let speed = format_args!("{key}.spin.speed");
    let speed = source.number_in(Domain::Finite, speed, about.speed)?;
    let axis = match (about.axis, about.random_axis_seed) {
        (Some(axis), None) => source.direction(format_args!("{key}.spin.axis"), axis)?,
        (None, Some(seed)) => random_axis(seed),
        _ => {
            let reason = "needs one of the keys `axis` and `random_axis_seed`";
            return Err(source.refuse(format_args!("{key}.spin"), reason));
        }
    };
    Ok(axis * speed)
}

/// An axis of length one drawn by lot: every direction is equally likely (Archimedes: height on a
/// sphere is uniform).
fn random_axis(seed: u64) -> DVec3 {
    // The stream is the generator's customary one; any fixed number would do.
    let mut lot = Pcg32::new(seed, 0xa02b_dbf7_bb3c_0a7a);
    let mut uniform = || f64::from(lot.next_u32()) / f64::from(u32::MAX);
    let (height, turn) = (2.0 * uniform() - 1.0, std::f64::consts::TAU * uniform());
    let radius = (1.0 - height * height).sqrt();
    let (sin, cos) = libm::sincos(turn);
    DVec3::new(radius * cos, height, radius * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turned = rotation(DVec3::Z, std::f64::consts::FRAC_PI_2) * DVec3::X;
        assert!((turned - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn a_turn_keeps_its_axis_and_lengths() {
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let turn = rotation(axis, 0.7);
        assert!((turn * axis - axis).length() < 1e-15);
        assert!((turn.determinant() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_random_axis_has_length_one_and_follows_its_seed() {
        for seed in 0..100 {
            assert!((random_axis(seed).length() - 1.0).abs() < 1e-15);
            assert_eq!(random_axis(seed), random_axis(seed));
        }
        assert_ne!(random_axis(1), random_axis(2));
    }
}
