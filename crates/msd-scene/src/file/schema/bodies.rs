//! Rows of bodies.

use super::{LookRow, MATERIAL_NAMES, TouchRow};
use crate::file::keys::{Domain, Form, Live, Scale, Written, rows};
use crate::mesh::Filling;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

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

const LATTICES: &[&str] = &["rope", "cloth", "block"];
/// Bodies with a spacing.
const SPACED: &[&str] = &["rope", "cloth", "block", "mesh"];
const BROAD: &[&str] = &["cloth", "block", "mesh"];
const SHEETS: &[&str] = &["cloth", "mesh"];

rows! {
    /// A body. Which keys it may have depends on its kind.
    BodyRow {
        /// Kind of body.
        kind: Kind,
        /// Name.
        name: Option<String> = "its kind",
        /// Particles: `[count]` of a rope along x, `[rows, columns]` of a cloth along y and x,
        /// `[rows, columns, stacks]` of a block along y, x and z.
        size: Option<Vec<u64>> = "required"
            { domain: Domain::Count(u64::MAX, "at least 1"), kinds: LATTICES, needed: LATTICES },
        /// Distance between neighbouring particles; in a mesh, in its interior lattice.
        spacing: Option<f64> = "1; of a mesh by the size of its triangles"
            { unit: "m", domain: Domain::Positive, kinds: SPACED, scale: Scale::LENGTH },
        /// Number of neighbours of an interior particle.
        neighbours: Option<u32> = "2, 8, 26: with diagonals"
            { domain: Domain::Words("2 of a rope; 4, 8 of a cloth; 6, 26 of a block"),
              kinds: LATTICES },
        /// Mesh file, relative to the scene file: `.obj`, `.stl`, `.ply`, `.gltf`, `.glb`.
        /// `bunny.obj` and `teapot.obj` are built in and need no file.
        file: Option<String> = "required" { kinds: &["mesh"], needed: &["mesh"] },
        /// `solid`: a lattice inside the surface, with holes of the surface treated as closed;
        /// `shell`: the surface alone; `auto`: solid if the mesh is closed. msd does not join
        /// closed parts of a file that touch.
        filling: Option<Filling> = "`auto`" { kinds: &["mesh"] },
        /// Longest side of the box around the mesh.
        length: Option<f64> = "1" { unit: "m", domain: Domain::Positive, kinds: &["mesh"] },
        /// For a shell without a material: stiffness and damping of the springs that resist
        /// bending, as a fraction of those of the other springs. With a material: bending
        /// stiffness, N m for a cloth or a shell, N m² for a rope.
        bending: Option<f64> = "without a material 1; uniform cloth or shell E t³/(12 (1 − 1/9)), \
                                woven 0; rope E π d⁴/64"
            { domain: Domain::NotNegative, kinds: &["rope", "cloth", "mesh"] },
        /// The particles.
        particles: Vec<ParticleRow> = "required"
            { domain: Domain::Filled, kinds: &["explicit"], needed: &["explicit"] },
        /// The springs.
        springs: Vec<SpringRow> = "none" { kinds: &["explicit"] },
        /// Mass of each particle, or of a whole mesh.
        mass: Option<f64> = "1"
            { unit: "kg", domain: Domain::Mass, scale: Scale::SHARE, live: Live::Mass },
        /// Stiffness of each spring: force per change of length.
        stiffness: Option<f64> = "1000; for a closed mesh 200, for an open mesh 1000"
            { unit: "N/m", domain: Domain::NotNegative, scale: Scale::SPRING,
              live: Live::Stiffness },
        /// Damping of each spring along its direction: force per stretch rate.
        damping: Option<f64> = "0; for a closed mesh 0.04, for an open mesh 0.2"
            { unit: "N s/m", domain: Domain::NotNegative, scale: Scale::SPRING,
              live: Live::Damping },
        /// Factor on the rest lengths of its springs; below 1 the body starts in tension.
        rest_scale: Option<f64> = "1" { domain: Domain::Positive, live: Live::RestScale },
        /// Place of the origin of the body: the centre of a lattice or of the box around a mesh,
        /// (0, 0, 0) in an explicit body.
        position: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m", domain: Domain::Place },
        /// Rotation about that origin, before `position` moves the body.
        rotation: Option<RotationRow> = "none",
        /// Velocity of every particle.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Collisions with itself and other bodies, see [`touch`](#touch).
        touch: Option<TouchRow> = "none: not at all" { live: Live::Touch },
        /// Appearance, see [`look`](#look).
        look: Option<LookRow> = "by its kind" { live: Live::Look },
        /// Angular velocity about the centre of mass: a vector, or a table.
        spin: Option<Spin> = "none"
            { unit: "rad/s", domain: Domain::Words("three finite numbers, or a table") },
        /// Name of a material.
        material: Option<String> = "none"
            { domain: Domain::Words(MATERIAL_NAMES), kinds: SPACED,
              live: Live::Material,
              instead_of: &["young", "density", "relaxation_time", "damping_ratio"] },
        /// Young's modulus.
        young: Option<f64> = "that of the material"
            { unit: "Pa", domain: Domain::Positive, kinds: SPACED, live: Live::Young },
        /// Poisson's ratio. For a block 0 to 0.45. Springs alone give 1/4; with another ratio,
        /// cells also resist a change of volume. For a solid mesh 1/4; for a cloth or a shell 1/3.
        poisson: Option<f64> = "1/4 for a block or a solid mesh, 1/3 for a cloth or a shell"
            { domain: Domain::Finite, kinds: BROAD },
        /// Density: mass per volume.
        density: Option<f64> = "that of the material"
            { unit: "kg/m³", domain: Domain::Positive, kinds: SPACED, live: Live::Density,
              instead_of: &["area_density"] },
        /// Relaxation time: viscosity divided by modulus (Kelvin-Voigt), or damping of a spring
        /// divided by its stiffness.
        relaxation_time: Option<f64> = "that of the material, or 0"
            { unit: "s", domain: Domain::NotNegative, kinds: SPACED, live: Live::RelaxationTime,
              instead_of: &["damping_ratio"] },
        /// Damping ratio of the lowest mode of the free body, without pins, instead of
        /// `relaxation_time`; for at most 4000 particles.
        damping_ratio: Option<f64> = "none" { domain: Domain::NotNegative, kinds: SPACED },
        /// Thickness of a cloth or a shell: bending stiffness grows with its third power.
        thickness: Option<f64> = "required, unless the cloth is woven and has an \
                                  `area_density`"
            { unit: "m", domain: Domain::Positive, kinds: SHEETS, live: Live::Thickness },
        /// Mass per area, instead of `density` times `thickness`.
        area_density: Option<f64> = "that of the material"
            { unit: "kg/m²", domain: Domain::Positive, kinds: SHEETS, live: Live::Density,
              instead_of: &["density"] },
        /// For a woven cloth: modulus along the rows (y); `young_warp`, `young_weft` and `shear`
        /// replace `young`.
        young_warp: Option<f64> = "that of the material"
            { unit: "N/m", domain: Domain::Positive, kinds: &["cloth"] },
        /// For a woven cloth: modulus along the columns (x).
        young_weft: Option<f64> = "that of the material"
            { unit: "N/m", domain: Domain::Positive, kinds: &["cloth"] },
        /// For a woven cloth: shear modulus, at most the product of the two others divided by their
        /// difference.
        shear: Option<f64> = "that of the material"
            { unit: "N/m", domain: Domain::Positive, kinds: &["cloth"] },
        /// Bending stiffness along the rows; `bending_warp`, `bending_weft` and `bending_bias`
        /// replace `bending`.
        bending_warp: Option<f64> = "`bending`"
            { unit: "N m", domain: Domain::NotNegative, kinds: &["cloth"] },
        /// Bending stiffness along the columns.
        bending_weft: Option<f64> = "`bending`"
            { unit: "N m", domain: Domain::NotNegative, kinds: &["cloth"] },
        /// Bending stiffness at 45° to both, at least a quarter of the sum of the two others.
        bending_bias: Option<f64> = "`bending`"
            { unit: "N m", domain: Domain::NotNegative, kinds: &["cloth"] },
        /// Diameter of a rope.
        diameter: Option<f64> = "required"
            { unit: "m", domain: Domain::Positive, kinds: &["rope"] },
    }

    /// A turn about an axis.
    RotationRow: Copy {
        /// The axis.
        axis: [f64; 3] { domain: Domain::Direction },
        /// The angle by the right-hand rule.
        angle_deg: f64 { unit: "°", domain: Domain::Finite },
    }

    /// An axis, given or drawn by lot, and a speed.
    SpinRow: Copy {
        /// The axis.
        axis: Option<[f64; 3]> = "this or the next" { domain: Domain::Direction },
        /// Seed of a random axis, uniform over all directions and the same on every machine.
        random_axis_seed: Option<u64> = "this or the one before"
            { domain: Domain::Words("whole, not negative") },
        /// Angular speed by the right-hand rule.
        speed: f64 { unit: "rad/s", domain: Domain::Finite },
    }

    /// A particle of an explicit body.
    ParticleRow: Copy {
        /// Position relative to the origin of the body.
        position: [f64; 3] { unit: "m", domain: Domain::Place },
        /// Velocity in addition to the body's; rotated with the body.
        velocity: Option<[f64; 3]> = "`[0, 0, 0]`" { unit: "m/s", domain: Domain::Vector },
        /// Mass.
        mass: Option<f64> = "that of the body" { unit: "kg", domain: Domain::Mass },
    }

    /// A spring of an explicit body.
    SpringRow: Copy {
        /// The two particles it joins, by their numbers from 0 in the body.
        ends: [u64; 2] { domain: Domain::Words("two different particles") },
        /// Length at which the spring exerts no force.
        rest_length: Option<f64> = "the distance of its ends"
            { unit: "m", domain: Domain::NotNegative },
        /// Stiffness.
        stiffness: Option<f64> = "that of the body" { unit: "N/m", domain: Domain::NotNegative },
        /// Damping.
        damping: Option<f64> = "that of the body" { unit: "N s/m", domain: Domain::NotNegative },
    }
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

impl Written for Spin {
    const FORM: Form = Form::Either(&[<[f64; 3]>::FORM, SpinRow::FORM]);
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
