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

mod air;
mod look;
mod lesson;
mod sets;
mod touch;
mod world;
mod bodies;
mod edits;
mod solver;
pub(crate) mod elsewhere;

pub use air::{AirRow, GustRow};
pub use bodies::{BodyRow, Kind, ParticleRow, RotationRow, Spin, SpinRow, SpringRow};
pub use edits::Edits;
pub use lesson::{Answer, LessonRow, MistakeRow};
pub use look::{CameraRow, Finish, LookRow};
pub use sets::{BodyKey, BoxRow, EndRow, LinkRow, MassRow, MaterialRow, PinRow, SetRow, SphereRow};
pub use solver::{MOST_NEWTON, OrAuto, Solver, SolverRow};
pub use touch::{TouchRow, WithRow};
pub use world::{KeyFrameRow, PlaneRow, SolidKind, SolidRow, WindRow, WorldRow};

/// The version of the schema.
pub const VERSION: u32 = 1;

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
        /// A question whose answer msd computes from the scene.
        lesson: Option<LessonRow> = "none",
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

choices!(Integrator, Precision, Kind, SolidKind, Filling, Finish, Pattern, Part, Answer);
