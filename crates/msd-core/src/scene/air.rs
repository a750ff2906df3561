//! The air that acts on the surfaces of bodies.

use glam::DVec3;

/// Air that acts on the triangles of the surfaces of bodies; see [`crate::elements::air`] for the
/// law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Air {
    /// Density, kilograms per cubic metre; not negative. Default 1.2.
    pub density: f64,
    /// Velocity of the mean wind, metres per second. Default zero.
    pub velocity: DVec3,
    /// Drag coefficient of a sheet that is face-on to the wind; not negative. Default 1.2, that of
    /// a square plate.
    pub drag: f64,
    /// Lift coefficient, from 0 to the drag coefficient. Default 0.98 times that: a sheet edge-on
    /// has the difference of both as its drag coefficient.
    pub lift: f64,
    /// Gusts beside the mean wind. Default none.
    pub gust: Gust,
}

impl Air {
    /// The default lift coefficient, as a fraction of the drag coefficient.
    pub const LIFT_OF_DRAG: f64 = 0.98;
}

impl Default for Air {
    fn default() -> Self {
        let drag = 1.2;
        let lift = Air::LIFT_OF_DRAG * drag;
        Air { density: 1.2, velocity: DVec3::ZERO, drag, lift, gust: Gust::default() }
    }
}

/// Gusts: a random velocity of the air that is smooth in space and time, the same for the same
/// seed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gust {
    /// Root mean square of the velocity, metres per second; not negative. Default 0.
    pub strength: f64,
    /// Length of a gust, metres; positive and at most 1e12. Default 1.
    pub length: f64,
    /// Time in which gusts change as they drift with the mean wind, seconds; positive and at most
    /// 1e12. Default 1.
    pub time: f64,
    /// The seed. Default 0.
    pub seed: u32,
    /// The point from which gusts are laid out, metres. Default the origin.
    pub origin: DVec3,
}

impl Default for Gust {
    fn default() -> Self {
        Gust { strength: 0.0, length: 1.0, time: 1.0, seed: 0, origin: DVec3::ZERO }
    }
}
