//! What is ready to run: a scene at its start, or a run that was saved on its way?

use crate::runner::{Precision, Runner};
use msd_core::{Progress, Scene, Settings};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A scene ready to run: rows, and how its author wants it stepped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// What was done to the input, one line each: welded vertices and the like. Not saved.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// The files that [`crate::open`] read it from, which nothing should be written over: a scene
    /// file and its meshes, or a saved run. Not saved.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
    /// Of a saved run: how far it is, and what holds it. The scene alone is how it stands then.
    pub progress: Option<Box<Progress>>,
}

impl Loaded {
    /// A run as it is now, to go on from here.
    pub fn of(name: &str, title: &str, runner: &Runner) -> Self {
        let (scene, progress) = runner.progress();
        Loaded {
            name: name.into(),
            title: title.into(),
            scene,
            settings: runner.settings(),
            precision: runner.precision(),
            notes: Vec::new(),
            files: Vec::new(),
            progress: Some(Box::new(progress)),
        }
    }

    /// Makes the scene ready to run, or a saved run ready to go on.
    ///
    /// # Errors
    /// See [`msd_core::Simulation::new`] and [`msd_core::Simulation::resume`].
    pub fn runner(&self) -> Result<Runner, msd_core::Error> {
        self.runner_with(self.settings, self.precision)
    }

    /// Makes it ready with another solver.
    ///
    /// # Errors
    /// See [`Loaded::runner`].
    pub fn runner_with(
        &self,
        settings: Settings,
        precision: Precision,
    ) -> Result<Runner, msd_core::Error> {
        let Some(progress) = &self.progress else {
            return Runner::new(&self.scene, settings, precision);
        };
        let mut runner = Runner::resume(&self.scene, progress, precision)?;
        if settings != progress.settings {
            runner.set_settings(settings)?;
        }
        Ok(runner)
    }
}

/// Whether a file from elsewhere calls its run by a name that other files may be called by, and
/// tells a title that is a line.
pub(crate) fn has_plain_name(loaded: &Loaded) -> bool {
    let Loaded { name, title, .. } = loaded;
    let is_line = |text: &str| !text.chars().any(char::is_control);
    let is_file = std::path::Path::new(name).file_name().is_some_and(|file| file == name.as_str());
    is_file && is_line(name) && is_line(title)
}
