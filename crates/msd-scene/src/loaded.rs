//! Scenes that are ready to run: at their start, or saved on their way.

use crate::file::schema::{LessonRow, Solver};
use crate::materials::Made;
use crate::model::Wind;
use crate::precision::Precision;
use crate::viewpoint::Viewpoint;
use glam::DVec3;
use msd_core::{Progress, Scene, Settings};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A scene ready to run: rows, and how its author wants it stepped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loaded {
    /// The name of the scene, without folder and extension.
    pub name: String,
    /// A description in one line.
    pub title: String,
    /// The rows.
    pub scene: Scene,
    /// Integrator, step and substeps.
    pub settings: Settings,
    /// Whether the substeps are automatic: chosen from the predicted limit of stability where the
    /// scene becomes a run, and again as it goes on.
    pub automatic: bool,
    /// Precision.
    pub precision: Precision,
    /// From where its author wants it looked at. Not of a saved run.
    pub camera: Viewpoint,
    /// Notes on the input, one line each: welded vertices and the like. Not saved.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// The files that [`open()`](crate::open()) read it from, which nothing should be written over:
    /// a scene file and its meshes, or a saved run. Not saved.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
    /// The material of each body; none of a body that is given by masses and springs, and empty for
    /// a saved run. Not saved.
    #[serde(skip)]
    pub made: Vec<Option<Made>>,
    /// The springs of each body, and of each row of links after them, with the factors of their
    /// rest lengths; empty for a saved run. Not saved.
    #[serde(skip)]
    pub rest_scales: Vec<(Range<usize>, f64)>,
    /// The particles of each row of pins that names a set, by that name, or as `pins[1]` where an
    /// earlier row names it too; nothing of a saved run. Not saved.
    #[serde(skip)]
    pub held: Vec<(String, Vec<usize>)>,
    /// The wind, whose mean the uniform force of the scene includes, and that force without it,
    /// newtons; `None` without a wind. In a saved run it follows the rest.
    #[serde(skip)]
    pub wind: Option<(Wind, DVec3)>,
    /// The lesson of the scene. Not saved.
    #[serde(skip)]
    pub lesson: Option<Box<LessonRow>>,
    /// Progress of a saved run, from which it resumes. The scene alone has its current places and
    /// velocities.
    pub progress: Option<Box<Progress>>,
}

impl Loaded {
    /// Rows that a program made, called by a name: in single precision, at fixed substeps.
    pub fn new(name: impl Into<String>, scene: Scene, settings: Settings) -> Self {
        Loaded {
            name: name.into(),
            title: String::new(),
            scene,
            settings,
            automatic: false,
            precision: Precision::F32,
            camera: Viewpoint::default(),
            notes: Vec::new(),
            files: Vec::new(),
            made: Vec::new(),
            rest_scales: Vec::new(),
            held: Vec::new(),
            wind: None,
            lesson: None,
            progress: None,
        }
    }

    /// The scene to be run from time 0 at the state of a saved run: its motions are as far on their
    /// way.
    pub fn restarted(mut self) -> Self {
        if let Some(progress) = &self.progress {
            self.scene.guides.clone_from(&progress.guides);
            self.scene = self.scene.from_time(progress.time());
        }
        self
    }

    /// Its solver.
    pub fn solver(&self) -> Solver {
        let Loaded { settings, precision, automatic, .. } = *self;
        Solver { settings, precision, automatic }
    }

    /// Steps it otherwise.
    pub fn set_solver(&mut self, solver: Solver) {
        Solver { settings: self.settings, precision: self.precision, automatic: self.automatic } =
            solver;
    }

    /// The wind of the scene.
    pub fn wind(&self) -> Wind {
        self.wind.map_or(Wind::default(), |(wind, _)| wind)
    }

    /// The uniform force of the scene in a wind, at a simulated time, newtons.
    pub fn force_in(&self, wind: Wind, time: f64) -> DVec3 {
        self.wind.map_or(self.scene.world.force, |(_, calm)| calm) + wind.force(time)
    }

    /// Returns whether this is a saved run with a usable file name and a title of one line: to be
    /// asked of runs that come from elsewhere.
    pub fn is_saved(&self) -> bool {
        let Loaded { name, title, progress, .. } = self;
        let is_line = |text: &str| !text.chars().any(char::is_control);
        let is_file = Path::new(name).file_name().is_some_and(|file| file == name.as_str());
        progress.is_some() && is_file && is_line(name) && is_line(title)
    }
}
