//! A run: its parts, and what its methods do with them.

pub mod force;
pub mod lock;
pub mod stepping;
pub mod readings;

use crate::errors::{core_error, error, refused};
use crate::options::{Of, select};
use force::Callable;
use lock::{Shared, Threads};
use msd_core::{Error, Interaction};
use msd_run::Runner;
use msd_run::quantity::counted;
use msd_scene::{Loaded, Viewpoint};
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use stepping::turn;

/// A run of a scene.
///
/// Each keyword replaces what the scene says: `integrator` (see `msd.integrators`), `step`,
/// seconds, `substeps` (a number or "auto"), `tolerance` of dormand-prince, `newton` iterations of
/// an implicit method, `precision` ("f32" or "f64"). `step` alone also sets `substeps` to 1, and
/// `substeps` alone also sets `step` to 1/60 s, whatever the scene says.
///
/// Without keywords a run has `scene.settings`. The default precision is "f32", or "f64" far from
/// the origin.
///
/// `threads` is the number of threads that a step of a large body may use. The same scene and
/// keywords give the same bits as the command line, on any number of threads.
///
/// You may use a run from any thread; a thread waits while another one steps the run. Ctrl-C ends
/// `step`, `run` and `trajectory` between two steps; the run keeps the steps taken.
///
/// >>> import msd
/// >>> run = msd.Simulation(msd.open("cloth"), integrator="rk4", substeps=16)
/// >>> run.step(60)
/// >>> run.time, run.positions.shape
/// (1.0, (961, 3))
#[pyclass(frozen, module = "msd")]
pub struct Simulation {
    pub shared: Shared,
    pub name: String,
    pub title: String,
    /// The camera of its author.
    pub camera: Viewpoint,
    /// Its forces that are callables.
    pub forces: Mutex<Vec<Callable>>,
}

impl Simulation {
    pub fn of(loaded: &Loaded, runner: Runner, threads: usize) -> Self {
        let (name, title, camera) = (loaded.name.clone(), loaded.title.clone(), loaded.camera);
        let shared = Shared::new(runner, Threads::new(threads));
        Simulation { shared, name, title, camera, forces: Mutex::default() }
    }

    /// Opens what was saved.
    pub fn opened(py: Python<'_>, loaded: &Loaded, threads: usize) -> PyResult<Self> {
        let runner = py.detach(|| Runner::open(loaded)).map_err(|error| core_error(py, error))?;
        Ok(Simulation::of(loaded, runner, threads))
    }

    /// Reads something of the run, or changes it, while other threads of Python go on.
    pub fn work<T: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut Runner) -> T + Send,
    ) -> PyResult<T> {
        self.shared.work(py, act)
    }

    /// The same for what the core may refuse.
    pub fn try_work<T: Send>(
        &self,
        py: Python<'_>,
        act: impl FnOnce(&mut Runner) -> Result<T, msd_core::Error> + Send,
    ) -> PyResult<T> {
        self.work(py, act)?.map_err(|error| core_error(py, error))
    }

    /// Takes steps, and lets Python see to signals in between.
    pub fn advance(&self, py: Python<'_>, steps: u64) -> PyResult<()> {
        self.try_advance(py, steps)?.map_err(|error| core_error(py, error))
    }

    /// The same; returns the error of a step that failed beside what Python raised.
    pub fn try_advance(&self, py: Python<'_>, steps: u64) -> PyResult<Result<(), msd_core::Error>> {
        let mut left = steps;
        while 0 < left {
            match self.work(py, |runner| turn(runner, left))? {
                Ok(rest) => left = rest,
                Err(error) => return Ok(Err(error)),
            }
            py.check_signals()?;
        }
        Ok(Ok(()))
    }

    pub fn queue(&self, py: Python<'_>, interaction: Interaction) -> PyResult<()> {
        self.try_work(py, |runner| runner.queue(interaction))
    }

    /// Queues an interaction with what is selected.
    pub fn queue_of(
        &self,
        py: Python<'_>,
        of: &Of,
        interaction: impl FnOnce(msd_core::Select) -> Interaction + Send,
    ) -> PyResult<()> {
        let queued = self.work(py, |runner| {
            let selected = select(runner, of)?;
            match (runner.queue(interaction(selected)), of) {
                // The core names the end of a range, which is beyond its last row.
                (Err(Error::OutOfRange { target, .. }), &Of::Range(start, end)) => {
                    let is_spring = target == "spring";
                    let count =
                        if is_spring { runner.spring_count() } else { runner.particle_count() };
                    let last = start.max(end.saturating_sub(1));
                    let only = format!("there are only {count}, counted from 0");
                    Err(format!("of names {target} {last}, but {only}"))
                }
                (queued, _) => Ok(queued),
            }
        })?;
        queued.map_err(|reason| refused(py, reason))?.map_err(|error| core_error(py, error))
    }

    pub fn callables(&self) -> MutexGuard<'_, Vec<Callable>> {
        self.forces.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn saved(&self, py: Python<'_>) -> PyResult<Loaded> {
        match self.callables().len() {
            0 => self.work(py, |runner| runner.to_loaded(&self.name, &self.title)),
            count => Err(error(
                py,
                format!(
                    "the run has {} of your own, which a saved run does not hold; save a run \
                     without, and add forces after loading",
                    counted(count as u64, "force")
                ),
            )),
        }
    }
}
