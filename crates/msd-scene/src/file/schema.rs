//! The rows of a scene file, schema version 1; `docs/scenes.md` explains every key.
//!
//! A key that is left out is `None` or empty here and takes its default where the scene is built,
//! so that a file that is read and written again says what its author said and no more.

use crate::mesh::Filling;
use crate::precision::Precision;
use msd_core::Integrator;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

mod air;
mod look;
mod sets;
mod touch;
pub(crate) mod elsewhere;

pub use air::{AirRow, GustRow};
pub use look::{CameraRow, Finish, LookRow};
pub use sets::{BodyKey, BoxRow, EndRow, LinkRow, MassRow, MaterialRow, PinRow, SetRow, SphereRow};
pub use touch::{TouchRow, WithRow};

/// The version of the schema.
pub const VERSION: u32 = 1;

/// A scene file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// The version of the schema, 1.
    pub version: u32,
    /// One line on what is seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// How the scene is stepped unless the caller says otherwise.
    #[serde(default)]
    pub solver: SolverRow,
    /// What acts on every particle.
    #[serde(default)]
    pub world: WorldRow,
    /// From where the scene is looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraRow>,
    /// The bodies, in the order of the state file.
    #[serde(default)]
    pub bodies: Vec<BodyRow>,
    /// Named sets of particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<SetRow>,
    /// The pins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<PinRow>,
    /// Masses put on particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masses: Vec<MassRow>,
    /// Materials of parts of bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialRow>,
    /// Springs between bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<LinkRow>,
}

/// How a scene is stepped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverRow {
    /// The method. Default velocity-verlet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
    /// Length of a step, seconds; `"auto"` is another name for automatic substeps, the default.
    #[serde(skip_serializing_if = "is_default")]
    pub step: Option<StepLength>,
    /// Steps per second, hertz, instead of `step`. Default 60.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_per_second: Option<f64>,
    /// Substeps per step. Default auto.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub substeps: Option<Substeps>,
    /// Local error of dormand-prince per substep, as a fraction of the size of the scene. Default
    /// 1e-6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Newton iterations of an implicit method per substep. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newton: Option<u64>,
    /// Precision. Default f32.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
}

/// Substeps per step: so many, or as many as the predicted limit of stability asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Chosen from the prediction, and again as the run goes on: `"auto"`.
    Auto,
    /// So many.
    Count(u64),
}

/// Length of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepLength {
    /// That of `steps_per_second`, divided into automatic substeps: `"auto"`.
    Auto,
    /// So many seconds.
    Seconds(f64),
}

/// How automatic substeps are written.
const AUTO: &str = "auto";

/// Whether a length of a step says nothing: automatic substeps are written under their own name.
fn is_default(step: &Option<StepLength>) -> bool {
    !matches!(step, Some(StepLength::Seconds(_)))
}

impl Serialize for StepLength {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            StepLength::Auto => serializer.serialize_str(AUTO),
            StepLength::Seconds(seconds) => serializer.serialize_f64(*seconds),
        }
    }
}

impl<'de> Deserialize<'de> for StepLength {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StepVisitor)
    }
}

struct StepVisitor;

impl Visitor<'_> for StepVisitor {
    type Value = StepLength;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number of seconds, or \"auto\"")
    }

    fn visit_f64<E: Error>(self, seconds: f64) -> Result<StepLength, E> {
        Ok(StepLength::Seconds(seconds))
    }

    fn visit_u64<E: Error>(self, seconds: u64) -> Result<StepLength, E> {
        Ok(StepLength::Seconds(seconds as f64))
    }

    fn visit_i64<E: Error>(self, seconds: i64) -> Result<StepLength, E> {
        Ok(StepLength::Seconds(seconds as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<StepLength, E> {
        match text == AUTO {
            true => Ok(StepLength::Auto),
            false => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }
}

impl Serialize for Substeps {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Substeps::Auto => serializer.serialize_str(AUTO),
            Substeps::Count(count) => serializer.serialize_u64(*count),
        }
    }
}

impl<'de> Deserialize<'de> for Substeps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SubstepsVisitor)
    }
}

struct SubstepsVisitor;

impl Visitor<'_> for SubstepsVisitor {
    type Value = Substeps;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a whole number from 1 to 4294967295, or \"auto\"")
    }

    fn visit_u64<E: Error>(self, count: u64) -> Result<Substeps, E> {
        Ok(Substeps::Count(count))
    }

    fn visit_i64<E: Error>(self, count: i64) -> Result<Substeps, E> {
        let unexpected = Unexpected::Signed(count);
        u64::try_from(count).map(Substeps::Count).map_err(|_| E::invalid_value(unexpected, &self))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Substeps, E> {
        if text == AUTO {
            return Ok(Substeps::Auto);
        }
        Err(E::invalid_value(Unexpected::Str(text), &self))
    }
}

/// What acts on every particle and on every surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldRow {
    /// Gravitational acceleration, metres per second squared. Default (0, −9.82, 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[f64; 3]>,
    /// A uniform force on every particle, newtons. Default zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 3]>,
    /// Air drag, newton seconds per metre. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drag: Option<f64>,
    /// The air that acts on surfaces. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub air: Option<AirRow>,
    /// Bound of every coordinate, metres. Default 1e6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extent: Option<f64>,
    /// The planes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneRow>,
    /// The solids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solids: Vec<SolidRow>,
}

/// A half space that particles cannot enter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneRow {
    /// Direction out of the solid. Default (0, 1, 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Signed distance from the origin along the normal, metres. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Fraction of the normal speed that a bounce returns. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Coulomb's coefficient of friction. Default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Fraction of the tangential velocity lost per contact substep, instead of `friction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_loss: Option<f64>,
    /// Whether what touches the plane stops: short for `restitution = 0`, `tangential_loss = 1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sticky: Option<bool>,
}

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

/// A solid that particles cannot enter, still or moving. Which lengths it has depends on its kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidRow {
    /// Its shape.
    pub kind: SolidKind,
    /// Radius, metres; of a torus that of the middle of its tube.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Capsules: between the middles of the ends; cylinders: from end to end; meshes: the longest
    /// side of the box around them, by default 1; metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Boxes: the three sides, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 3]>,
    /// Tori: radius of the tube, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tube: Option<f64>,
    /// Meshes: the file, relative to that of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Meshes: the edge of a cell of the grid of distances, metres. Default a 64th of `length`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
    /// Where its middle is, metres. Default the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// How it is turned about its middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationRow>,
    /// Velocity, metres per second. Default zero: it stands still.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity about its middle. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// Where it is later, instead of `velocity` and `spin`; it moves smoothly in between.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key_frames: Option<Vec<KeyFrameRow>>,
    /// Fraction of the normal speed that a bounce returns. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Coulomb's coefficient of friction. Default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Fraction of the tangential velocity lost per contact substep, instead of `friction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_loss: Option<f64>,
    /// Whether what touches the solid stops: short for `restitution = 0`, `tangential_loss = 1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sticky: Option<bool>,
    /// Whether it meets points on springs that are longer than it is thick too. Default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub springs: Option<bool>,
}

/// Where a solid is at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyFrameRow {
    /// Seconds; each later than the one before.
    pub time: f64,
    /// Where its middle is, metres. Default as in the key frame before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// How it is turned about its middle. Default as in the key frame before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationRow>,
}

/// How a body is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A line of particles along x.
    Rope,
    /// A sheet in the plane z = 0: rows along y, columns along x.
    Cloth,
    /// A block: rows along y, columns along x, stacks along z.
    #[default]
    Block,
    /// A triangle mesh made a solid or a shell.
    Mesh,
    /// Particles and springs one by one.
    Explicit,
}

impl Kind {
    /// The name a user writes.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Rope => "rope",
            Kind::Cloth => "cloth",
            Kind::Block => "block",
            Kind::Mesh => "mesh",
            Kind::Explicit => "explicit",
        }
    }
}

/// A body. Which keys it may have depends on its kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyRow {
    /// How it is made.
    pub kind: Kind,
    /// What the user calls it. Default its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Lattices: particles along rows, columns, stacks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<Vec<u64>>,
    /// Distance of neighbouring particles, metres. Default 1; of a mesh chosen by its shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
    /// Lattices: how many neighbours a particle inside is joined to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub neighbours: Option<u32>,
    /// Meshes: the file, relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Meshes: what is made of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filling: Option<Filling>,
    /// Meshes: longest side of the box around it, metres. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Shells of a mesh: stiffness and damping of the springs against bending, as a fraction;
    /// default 1. Cloths and ropes of a material: bending stiffness, newton metres of a cloth,
    /// newton square metres of a rope; default that of a uniform plate or rod.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending: Option<f64>,
    /// Mass of each particle, of a mesh the whole, kilograms. Default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Stiffness of each spring, newtons per metre. Default 1000; of a closed mesh
    /// 200, of an open one 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping of each spring, newton seconds per metre. Default 0; of a closed mesh 0.04, of an
    /// open one 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Lattices: the name of what the body is made of, instead of mass, stiffness and damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Lattices: Young's modulus, pascals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub young: Option<f64>,
    /// Blocks: Poisson's ratio, 0 to 0.45; default 1/4, which springs give alone. Cloths: 1/3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson: Option<f64>,
    /// Lattices of a material: density, kilograms per cubic metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Lattices of a material: viscosity over modulus, seconds. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxation_time: Option<f64>,
    /// Lattices of a material: damping ratio of the slowest motion of the body on its own, instead
    /// of `relaxation_time`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_ratio: Option<f64>,
    /// Cloths: thickness, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Cloths: mass per area, kilograms per square metre, instead of `density` times `thickness`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_density: Option<f64>,
    /// Woven cloths: modulus along the rows, newtons per metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub young_warp: Option<f64>,
    /// Woven cloths: modulus along the columns, newtons per metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub young_weft: Option<f64>,
    /// Woven cloths: shear modulus, newtons per metre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<f64>,
    /// Cloths: bending stiffness along the rows, newton metres; with the two others, instead of
    /// `bending`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_warp: Option<f64>,
    /// Cloths: bending stiffness along the columns, newton metres; with the two others, instead of
    /// `bending`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_weft: Option<f64>,
    /// Cloths: bending stiffness at 45 degrees to both, newton metres; with the two others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_bias: Option<f64>,
    /// Ropes: diameter, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter: Option<f64>,
    /// How it meets itself and other bodies. Default: not at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touch: Option<TouchRow>,
    /// How it looks. Default by its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<LookRow>,
    /// Where the origin of the body is put, metres. Default the origin of the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// How it is turned about its origin first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationRow>,
    /// Velocity of every particle, metres per second. Default zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity about the centre of mass. Default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
    /// Explicit bodies: the particles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub particles: Vec<ParticleRow>,
    /// Explicit bodies: the springs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<SpringRow>,
}

/// A turn about an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotationRow {
    /// The axis, of any length but zero.
    pub axis: [f64; 3],
    /// The angle by the right-hand rule, degrees.
    pub angle_deg: f64,
}

/// An angular velocity: a vector, or an axis and a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Spin {
    /// The vector, radians per second.
    Vector([f64; 3]),
    /// An axis and a speed.
    About(SpinRow),
}

/// An axis, given or drawn by lot, and a speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpinRow {
    /// The axis, of any length but zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// The seed of a random axis, instead of `axis`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random_axis_seed: Option<u64>,
    /// The speed by the right-hand rule, radians per second.
    pub speed: f64,
}

impl<'de> Deserialize<'de> for Spin {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpinVisitor)
    }
}

/// Chooses by what was written: serde's own choice by trial would lose every message.
struct SpinVisitor;

impl<'de> Visitor<'de> for SpinVisitor {
    type Value = Spin;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of three numbers, or a table of axis and speed")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Spin, A::Error> {
        Deserialize::deserialize(SeqAccessDeserializer::new(list)).map(Spin::Vector)
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Spin, A::Error> {
        Deserialize::deserialize(MapAccessDeserializer::new(table)).map(Spin::About)
    }
}

/// A particle of an explicit body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleRow {
    /// Position about the origin of the body, metres.
    pub position: [f64; 3],
    /// Velocity besides that of the body, metres per second. Default zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Mass, kilograms. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
}

/// A spring of an explicit body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringRow {
    /// The two particles of the body it joins.
    pub ends: [u64; 2],
    /// Length without force, metres. Default the distance of the ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_length: Option<f64>,
    /// Stiffness, newtons per metre. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Damping, newton seconds per metre. Default that of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}
