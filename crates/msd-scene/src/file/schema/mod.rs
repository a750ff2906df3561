//! The rows of a scene file, schema version 1; `docs/reference/scenes.md` explains every key.
//!
//! A key that is left out is `None` or empty here and takes its default where the scene is built,
//! so that a file that is read and written again says what its author said and no more.

use crate::file::decode::names_of;
use crate::file::keys::{Domain, Form, KeyRow, Live, Written, rows};
use crate::mesh::Filling;
use crate::model::parts::Part;
use crate::precision::Precision;
use msd_core::{Integrator, Pattern};
use serde::de::{Deserializer, Error, IntoDeserializer, Unexpected, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::marker::PhantomData;

mod air;
mod look;
mod sets;
mod touch;
mod world;
mod bodies;
mod edits;
pub(crate) mod elsewhere;

pub use air::{AirRow, GustRow};
pub use bodies::{BodyRow, Kind, ParticleRow, RotationRow, Spin, SpinRow, SpringRow};
pub use edits::Edits;
pub use look::{CameraRow, Finish, LookRow};
pub use sets::{BodyKey, BoxRow, EndRow, LinkRow, MassRow, MaterialRow, PinRow, SetRow, SphereRow};
pub use touch::{TouchRow, WithRow};
pub use world::{KeyFrameRow, PlaneRow, SolidKind, SolidRow, WindRow, WorldRow};

/// The version of the schema.
pub const VERSION: u32 = 1;
/// The largest number of Newton iterations.
pub const MOST_NEWTON: u32 = 1000;

/// Domain of a material's name, with its page as seen from `docs/reference/scenes.md`.
const MATERIAL_NAMES: &str = "a name of [materials.md](../explanation/materials.md)";

rows! {
    /// A scene of msd.
    SceneFile {
        /// Version of the schema.
        version: u32 { domain: Domain::Count(VERSION as u64, "1") },
        /// One line that describes the scene.
        title: Option<String> = "the name of the file",
        /// Method, step and precision.
        solver: SolverRow = "see below",
        /// Gravity, wind, air and obstacles.
        world: WorldRow = "see below",
        /// View of the scene.
        camera: Option<CameraRow> = "see below",
        /// The bodies, in the order of their particle numbers.
        bodies: Vec<BodyRow> = "required" { domain: Domain::Filled },
        /// Particles by name, for pins, masses, materials and links.
        sets: Vec<SetRow> = "none",
        /// Particles whose motion is prescribed.
        pins: Vec<PinRow> = "none",
        /// Masses added to particles.
        masses: Vec<MassRow> = "none",
        /// Materials of parts of bodies.
        materials: Vec<MaterialRow> = "none",
        /// Springs between bodies.
        links: Vec<LinkRow> = "none",
        /// Model terms that are switched off. Springs of these kinds stay, without stiffness and
        /// damping.
        off: Vec<Part> = "none" { live: Live::Off },
    }

    /// How a scene is stepped.
    SolverRow {
        /// Method.
        integrator: Option<Integrator> = "`velocity-verlet`",
        /// Length of a step; `"auto"` is another name for automatic substeps.
        step: OrAuto<f64> = "1/60" { unit: "s", domain: Domain::Step },
        /// Steps per second, instead of `step`.
        steps_per_second: Option<f64> = "60" { unit: "Hz", domain: Domain::Rate },
        /// Substeps per step; one lasts `step / substeps`. `dormand-prince` does not use them.
        substeps: Option<OrAuto<u64>> = "`\"auto\"`"
            { domain: Domain::Count(u32::MAX as u64, "from 1 to 4294967295, or \"auto\"") },
        /// Local error that `dormand-prince` allows per substep, as a fraction of the size of the
        /// scene.
        tolerance: Option<f64> = "1e-6" { domain: Domain::UpTo(1.0, "positive and at most 1") },
        /// Newton iterations of `backward-euler` and `implicit-midpoint` per substep.
        newton: Option<u64> = "1" { domain: Domain::Count(MOST_NEWTON as u64, "from 1 to 1000") },
        /// Precision of all numbers.
        precision: Option<Precision> = "`f32`; `f64` where f32 is [too coarse]\
            (../measured/extremes.md#single-precision-far-from-the-origin) so far from the origin",
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

choices!(Integrator, Precision, Kind, SolidKind, Filling, Finish, Pattern, Part);

/// A value, or `"auto"` where msd chooses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OrAuto<T> {
    /// Chosen from the predicted limit of stability, and again as the run goes on.
    #[default]
    Auto,
    /// This value.
    Given(T),
}

/// How the choice of msd is written.
const AUTO: &str = "auto";

impl<T: Written> Written for OrAuto<T> {
    const FORM: Form = Form::Either(&[T::FORM, Form::Choice(|| &[AUTO])]);
}

impl<T: Serialize> Serialize for OrAuto<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            OrAuto::Auto => serializer.serialize_str(AUTO),
            OrAuto::Given(value) => value.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de> + Written> Deserialize<'de> for OrAuto<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AutoVisitor(PhantomData))
    }
}

struct AutoVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Written> AutoVisitor<T> {
    fn given<E: Error>(
        self,
        value: impl Deserializer<'de, Error = E>,
        written: Unexpected<'_>,
    ) -> Result<OrAuto<T>, E> {
        T::deserialize(value).map(OrAuto::Given).map_err(|_| E::invalid_value(written, &self))
    }
}

impl<'de, T: Deserialize<'de> + Written> Visitor<'de> for AutoVisitor<T> {
    type Value = OrAuto<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match T::FORM {
            Form::Whole(_) => "a whole number from 1 to 4294967295, or \"auto\"",
            _ => "a number of seconds, or \"auto\"",
        })
    }

    fn visit_unit<E: Error>(self) -> Result<OrAuto<T>, E> {
        Ok(OrAuto::Auto)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Float(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Unsigned(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<OrAuto<T>, E> {
        self.given(value.into_deserializer(), Unexpected::Signed(value))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<OrAuto<T>, E> {
        match text == AUTO {
            true => Ok(OrAuto::Auto),
            false => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }
}
