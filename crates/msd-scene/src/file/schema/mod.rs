//! The rows of a scene file, schema version 1; `docs/scenes.md` explains every key.
//!
//! A key that is left out is `None` or empty here and takes its default where the scene is built,
//! so that a file that is read and written again says what its author said and no more.

use crate::file::decode::names_of;
use crate::file::keys::{Domain, Form, KeyRow, Written, rows};
use crate::mesh::Filling;
use crate::precision::Precision;
use msd_core::{Integrator, Pattern};
use serde::de::{Deserializer, Error, Unexpected, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

mod air;
mod look;
mod sets;
mod touch;
mod world;
mod bodies;
pub(crate) mod elsewhere;

pub use air::{AirRow, GustRow};
pub use bodies::{BodyRow, Kind, ParticleRow, RotationRow, Spin, SpinRow, SpringRow};
pub use look::{CameraRow, Finish, LookRow};
pub use sets::{BodyKey, BoxRow, EndRow, LinkRow, MassRow, MaterialRow, PinRow, SetRow, SphereRow};
pub use touch::{TouchRow, WithRow};
pub use world::{KeyFrameRow, PlaneRow, SolidKind, SolidRow, WorldRow};

/// The version of the schema.
pub const VERSION: u32 = 1;
/// The largest number of Newton iterations.
pub const MOST_NEWTON: u32 = 1000;

rows! {
    /// A scene of msd.
    SceneFile {
        /// Version of the schema.
        version: u32 { domain: Domain::Count(VERSION as u64, "1") },
        /// One line that describes the scene.
        title: Option<String> = "the name of the file",
        /// How the scene is stepped.
        solver: SolverRow = "see below",
        /// What acts on every particle.
        world: WorldRow = "see below",
        /// From where the scene is looked at.
        camera: Option<CameraRow> = "see below",
        /// The bodies; their particles are numbered in this order.
        bodies: Vec<BodyRow> = "must be given" { domain: Domain::Filled },
        /// Particles by name, for pins, masses, materials and links.
        sets: Vec<SetRow> = "none",
        /// Particles whose motion is prescribed.
        pins: Vec<PinRow> = "none",
        /// Masses put on particles.
        masses: Vec<MassRow> = "none",
        /// Materials of parts of bodies.
        materials: Vec<MaterialRow> = "none",
        /// Springs between bodies.
        links: Vec<LinkRow> = "none",
    }

    /// How a scene is stepped.
    SolverRow {
        /// Method.
        integrator: Option<Integrator> = "`velocity-verlet`",
        /// Length of a step; `"auto"` is another name for automatic substeps.
        step: StepLength = "1/60" { unit: "s", domain: Domain::Step },
        /// Steps per second, instead of `step`.
        steps_per_second: Option<f64> = "60" { unit: "Hz", domain: Domain::Rate },
        /// Substeps per step; one lasts `step / substeps`. `dormand-prince` does not use them.
        substeps: Option<Substeps> = "`\"auto\"`"
            { domain: Domain::Count(u32::MAX as u64, "from 1 to 4294967295, or \"auto\"") },
        /// Local error that `dormand-prince` allows per substep, as a fraction of the size of the
        /// scene.
        tolerance: Option<f64> = "1e-6" { domain: Domain::UpTo(1.0, "positive and at most 1") },
        /// Newton iterations of `backward-euler` and `implicit-midpoint` per substep.
        newton: Option<u64> = "1" { domain: Domain::Count(MOST_NEWTON as u64, "from 1 to 1000") },
        /// Precision of all numbers.
        precision: Option<Precision> = "`f32`; `f64` where f32 is [too \
            coarse](extremes.md#single-precision-far-from-the-origin) so far from the origin",
    }
}

/// The key at a path without numbers of rows, such as `bodies.mass`.
pub fn find(path: &str) -> Option<&'static KeyRow> {
    SceneFile::TABLE.find(path)
}

macro_rules! choices {
    ($($type:ty),+) => {$(
        impl Written for $type {
            const FORM: Form = Form::Choice(names_of::<$type>);
        }
    )+};
}

choices!(Integrator, Precision, Kind, SolidKind, Filling, Finish, Pattern);

/// Substeps per step: so many, or as many as the predicted limit of stability asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Chosen from the prediction, and again as the run goes on: `"auto"`.
    Auto,
    /// So many.
    Count(u64),
}

/// Length of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum StepLength {
    /// That of `steps_per_second`, divided into automatic substeps: `"auto"`, which is not written.
    #[default]
    Auto,
    /// So many seconds.
    Seconds(f64),
}

/// How automatic substeps are written.
const AUTO: &str = "auto";

impl Written for StepLength {
    const FORM: Form = Form::Either(&[Form::Number, Form::Choice(|| &[AUTO])]);
}

impl Written for Substeps {
    const FORM: Form = Form::Either(&[u64::FORM, Form::Choice(|| &[AUTO])]);
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

    fn visit_unit<E: Error>(self) -> Result<StepLength, E> {
        Ok(StepLength::Auto)
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
