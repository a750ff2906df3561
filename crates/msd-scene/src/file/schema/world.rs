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
/// Solids with a length, and those that must be given it.
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
        /// Spheres, boxes, half spaces that move and other solids that particles cannot enter,
        /// still or moving.
        solids: Vec<SolidRow> = "none",
    }

    /// A wind.
    WindRow: Copy {
        /// Mean force on every particle.
        strength: Option<f64> = "0"
            { unit: "N", domain: Domain::NotNegative, scale: Scale::SHARE },
        /// Where it blows to, about the vertical: at 0 along x, at 90 along −z.
        heading_deg: Option<f64> = "0" { unit: "°", domain: Domain::Finite },
        /// By what part of its strength it comes and goes.
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
        /// contact. Its effect depends on the substep and does not converge. It exists to repeat
        /// the report from which this project grew.
        tangential_loss: Option<f64> = "not used"
            { domain: Domain::Fraction, live: Live::Plane, instead_of: &["friction", "sticky"] },
        /// Short for `restitution = 0` and `tangential_loss = 1`: what touches the plane stops
        /// there, but is not glued: springs can pull it off.
        sticky: Option<bool> = "`false`",
    }

    /// A solid that particles cannot enter, still or moving.
    SolidRow {
        /// Its shape. Capsules, cylinders and tori have y as their axis until they are turned, and
        /// a half space is all that is not above its middle.
        kind: SolidKind,
        /// Name, for pins that follow it.
        name: Option<String> = "the kind",
        /// Radius; of a torus that of the circle in the middle of its tube.
        radius: Option<f64> = "must be given"
            { unit: "m", domain: LENGTH, kinds: ROUND, needed: ROUND },
        /// Between the middles of the two ends of a capsule, from end to end of a cylinder, the
        /// longest side of the box around a mesh.
        length: Option<f64> = "must be given; of a mesh 1"
            { unit: "m", domain: LENGTH, kinds: LONG, needed: RODS },
        /// The three sides.
        size: Option<[f64; 3]> = "must be given"
            { unit: "m", domain: LENGTH, kinds: &["box"], needed: &["box"] },
        /// Radius of the tube; smaller than that of the torus.
        tube: Option<f64> = "must be given"
            { unit: "m", domain: LENGTH, kinds: &["torus"], needed: &["torus"] },
        /// Mesh file, as that of a body; its surface must be closed.
        file: Option<String> = "must be given" { kinds: &["mesh"], needed: &["mesh"] },
        /// Distance between neighbouring points of the grid of distances.
        cell: Option<f64> = "a 64th of `length`" { unit: "m", domain: LENGTH, kinds: &["mesh"] },
        /// Where its middle is at the start; of a mesh that of the box around it.
        position: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m", domain: Domain::Place },
        /// How it is turned about its middle at the start, as that of a body.
        rotation: Option<RotationRow> = "none",
        /// Velocity; it never changes.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Angular velocity about its middle, as that of a body; it never changes.
        spin: Option<Spin> = "none"
            { unit: "rad/s", domain: Domain::Words("three finite numbers, or a table") },
        /// Where it is later, instead of `velocity` and `spin`; in order of time.
        key_frames: Option<Vec<KeyFrameRow>> = "none" { domain: Domain::Filled },
        /// Fraction of the normal speed that a bounce returns, as seen from the surface.
        restitution: Option<f64> = "0" { domain: Domain::Fraction },
        /// Coulomb's coefficient of friction.
        friction: Option<f64> = "0.5" { domain: Domain::Factor },
        /// As that of a plane.
        tangential_loss: Option<f64> = "not used" { domain: Domain::Fraction },
        /// As that of a plane.
        sticky: Option<bool> = "`false`",
        /// Whether it meets the springs that are longer than it is thick as well, not particles
        /// alone: see [thin solids](#thin-solids).
        springs: Option<bool> = "`false`",
    }

    /// Where a solid or the middle of pinned particles is at a time.
    KeyFrameRow {
        /// When; later than that of the key frame before.
        time: f64 { unit: "s", domain: Domain::Positive },
        /// Where its middle is then.
        position: Option<[f64; 3]> = "as in the key frame before"
            { unit: "m", domain: Domain::Place },
        /// How it is turned then, as at the start: from its own axes, not from the key frame
        /// before.
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
