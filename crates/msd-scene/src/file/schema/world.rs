//! Rows of the world: what acts on every particle, and what particles cannot enter.

use super::{AirRow, RotationRow, Spin};
use crate::file::keys::{Domain, LENGTH, Live, Scale, rows};
use crate::model::Wind;
use serde::{Deserialize, Serialize};

/// The shape of a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolidKind {
    /// All points within `radius`.
    #[default]
    Sphere,
    /// All points within `radius` of a line of `length` along y.
    Capsule,
    /// A cuboid of three sides.
    Box,
    /// A round rod along y.
    Cylinder,
    /// A ring about y.
    Torus,
    /// The inside of a closed triangle mesh.
    Mesh,
    /// All that is below, without end.
    HalfSpace,
}

impl SolidKind {
    /// The name a user writes.
    pub fn name(self) -> &'static str {
        match self {
            SolidKind::Sphere => "sphere",
            SolidKind::Capsule => "capsule",
            SolidKind::Box => "box",
            SolidKind::Cylinder => "cylinder",
            SolidKind::Torus => "torus",
            SolidKind::Mesh => "mesh",
            SolidKind::HalfSpace => "half_space",
        }
    }
}

/// Solids with a radius.
const ROUND: &[&str] = &["sphere", "capsule", "cylinder", "torus"];
/// Solids with a length, and those that required it.
const LONG: &[&str] = &["capsule", "cylinder", "mesh"];
const RODS: &[&str] = &["capsule", "cylinder"];

rows! {
    /// What acts on every particle and on every surface.
    WorldRow {
        /// Gravitational acceleration.
        gravity: Option<[f64; 3]> = "`[0, -9.82, 0]`"
            { unit: "m/s²", domain: Domain::Vector, live: Live::Gravity },
        /// The same force on every particle.
        force: Option<[f64; 3]> = "`[0, 0, 0]`"
            { unit: "N", domain: Domain::Vector, scale: Scale::SHARE },
        /// Wind: a force on every particle besides `force`, steady or in gusts; see
        /// [`world.wind`](#worldwind).
        wind: Option<WindRow> = "none" { live: Live::Wind },
        /// Air drag: the force −drag · v on every particle.
        drag: Option<f64> = "0"
            { unit: "N s/m", domain: Domain::NotNegative, scale: Scale::SHARE,
              live: Live::Drag },
        /// Air that acts on surfaces by their area: drag, lift, wind and gusts.
        air: Option<AirRow> = "none",
        /// Bound on every coordinate. A run whose particle leaves it has diverged.
        extent: Option<f64> = "1e6" { unit: "m", domain: LENGTH },
        /// Half spaces that particles cannot enter.
        planes: Vec<PlaneRow> = "none",
        /// Spheres, boxes, moving half spaces and other solids that particles cannot enter.
        solids: Vec<SolidRow> = "none",
    }

    /// A wind.
    WindRow: Copy {
        /// Mean force on every particle.
        strength: Option<f64> = "0"
            { unit: "N", domain: Domain::NotNegative, scale: Scale::SHARE },
        /// Heading about the vertical: 0 is along x, 90 along −z.
        heading_deg: Option<f64> = "0" { unit: "°", domain: Domain::Finite },
        /// Amplitude of the gusts, as a fraction of the strength.
        gusts: Option<f64> = "0" { domain: Domain::Fraction },
    }

    /// A half space that particles cannot enter.
    PlaneRow {
        /// Direction out of the solid.
        normal: Option<[f64; 3]> = "`[0, 1, 0]`" { domain: Domain::Direction },
        /// Signed distance of the plane from the origin along the normal.
        offset: Option<f64> = "0" { unit: "m", domain: Domain::Finite },
        /// Fraction of the normal speed that a bounce returns.
        restitution: Option<f64> = "0"
            { domain: Domain::Fraction, live: Live::Plane, instead_of: &["sticky"] },
        /// Coulomb's coefficient of friction.
        friction: Option<f64> = "0.5"
            { domain: Domain::Factor, live: Live::Plane,
              instead_of: &["tangential_loss", "sticky"] },
        /// Instead of `friction`: fraction of the tangential velocity lost in each substep of
        /// contact. Its effect depends on the substep and does not converge. It serves to repeat
        /// the 2014 report.
        tangential_loss: Option<f64> = "not used"
            { domain: Domain::Fraction, live: Live::Plane, instead_of: &["friction", "sticky"] },
        /// Short for `restitution = 0` and `tangential_loss = 1`: particles stop where they touch
        /// the plane, and springs can pull them off.
        sticky: Option<bool> = "`false`",
    }

    /// A solid that particles cannot enter, still or moving.
    SolidRow {
        /// Shape. Capsules, cylinders and tori have y as their axis before `rotation`; a half space
        /// is everything below its centre.
        kind: SolidKind,
        /// Name, for pins that follow it.
        name: Option<String> = "the kind",
        /// Radius; of a torus, that of the centre line of its tube.
        radius: Option<f64> = "required"
            { unit: "m", domain: LENGTH, kinds: ROUND, needed: ROUND },
        /// Distance between the end centres of a capsule, length of a cylinder, longest side of the
        /// box around a mesh.
        length: Option<f64> = "required; of a mesh 1"
            { unit: "m", domain: LENGTH, kinds: LONG, needed: RODS },
        /// The three sides.
        size: Option<[f64; 3]> = "required"
            { unit: "m", domain: LENGTH, kinds: &["box"], needed: &["box"] },
        /// Radius of the tube; smaller than that of the torus.
        tube: Option<f64> = "required"
            { unit: "m", domain: LENGTH, kinds: &["torus"], needed: &["torus"] },
        /// Mesh file, as of a body, with a closed surface.
        file: Option<String> = "required" { kinds: &["mesh"], needed: &["mesh"] },
        /// Spacing of the grid of distances.
        cell: Option<f64> = "a 64th of `length`" { unit: "m", domain: LENGTH, kinds: &["mesh"] },
        /// Initial centre; of a mesh, that of the box around it.
        position: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m", domain: Domain::Place },
        /// Initial rotation about its centre, as of a body.
        rotation: Option<RotationRow> = "none",
        /// Constant velocity.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Constant angular velocity about its centre, as of a body.
        spin: Option<Spin> = "none"
            { unit: "rad/s", domain: Domain::Words("three finite numbers, or a table") },
        /// Later positions and rotations, in order of time, instead of `velocity` and `spin`.
        key_frames: Option<Vec<KeyFrameRow>> = "none" { domain: Domain::Filled },
        /// Fraction of the normal speed that a bounce returns, relative to the surface.
        restitution: Option<f64> = "0" { domain: Domain::Fraction },
        /// Coulomb's coefficient of friction.
        friction: Option<f64> = "0.5" { domain: Domain::Factor },
        /// As of a plane.
        tangential_loss: Option<f64> = "not used" { domain: Domain::Fraction },
        /// As of a plane.
        sticky: Option<bool> = "`false`",
        /// Whether it also stops springs longer than its thickness: see [thin
        /// solids](#thin-solids).
        springs: Option<bool> = "`false`",
    }

    /// Where a solid or the middle of pinned particles is at a time.
    KeyFrameRow {
        /// Time, later than that of the previous key frame.
        time: f64 { unit: "s", domain: Domain::Positive },
        /// Centre at that time.
        position: Option<[f64; 3]> = "as in the key frame before"
            { unit: "m", domain: Domain::Place },
        /// Rotation at that time, relative to the unrotated shape, not to the previous key frame.
        rotation: Option<RotationRow> = "as in the key frame before",
    }
}

impl From<WindRow> for Wind {
    fn from(row: WindRow) -> Self {
        Wind {
            strength: row.strength.unwrap_or(0.0),
            heading: row.heading_deg.unwrap_or(0.0).to_radians(),
            gusts: row.gusts.unwrap_or(0.0),
        }
    }
}

impl From<Wind> for WindRow {
    fn from(wind: Wind) -> Self {
        let number = |value: f64| (value != 0.0).then_some(value);
        WindRow {
            strength: number(wind.strength),
            heading_deg: number(wind.heading.to_degrees()),
            gusts: number(wind.gusts),
        }
    }
}
