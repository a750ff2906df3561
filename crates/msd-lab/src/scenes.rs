//! Which scene does a name stand for: a built-in one, a scene file or a mesh?

use crate::runner::{Precision, Runner};
use msd_core::{Scene, Settings};

/// A scene ready to run: rows, and how its author wants it stepped.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The name of the scene, without folder and extension.
    pub name: String,
    /// One line on what is seen.
    pub title: String,
    /// The rows.
    pub scene: Scene,
    /// Integrator, step and substeps.
    pub settings: Settings,
    /// Precision.
    pub precision: Precision,
    /// What was done to the input, one line each: welded vertices and the like.
    pub notes: Vec<String>,
}

impl Loaded {
    /// Makes the scene ready to run.
    ///
    /// # Errors
    /// See [`msd_core::Simulation::new`].
    pub fn runner(&self) -> Result<Runner, msd_core::Error> {
        Runner::new(&self.scene, self.settings, self.precision)
    }
}

/// A built-in scene: its name and one line on what is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// The name a user writes.
    pub name: &'static str,
    /// One line on what is seen.
    pub title: &'static str,
    /// The scene file, TOML.
    pub text: &'static str,
}
