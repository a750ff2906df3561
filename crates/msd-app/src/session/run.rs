//! The run behind one gate, and readings of it that are void once it was changed.

use msd_core::stability::Estimator;
use msd_core::{Error, Interaction};
use msd_run::Runner;
use msd_scene::Loaded;
use msd_scene::schema::Solver;

/// The wall-clock time that each prediction of the longest stable substep takes of a frame,
/// seconds.
pub(super) const PREDICTING: f64 = 4e-3;
/// Whether automatic substeps are chosen over several frames after a change: a page of a browser is
/// to answer within 50 ms. Elsewhere they are known at once.
const IS_LAZY: bool = cfg!(target_arch = "wasm32");

/// A count of the changes of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Revision(u64);

/// A runner that can be changed by `Run::change` alone, so that no change goes unnoticed. Steps,
/// motions of what the mouse holds, gusts and looks are no changes: the run goes on by them.
#[derive(Debug)]
pub struct Run {
    runner: Runner,
    revision: Revision,
    /// Whether gusts have done work since the last change.
    is_driven: bool,
}

impl Run {
    /// A run at its first revision.
    pub(super) fn new(runner: Runner) -> Self {
        Run { runner, revision: Revision::default(), is_driven: false }
    }

    /// The runner.
    pub fn runner(&self) -> &Runner {
        &self.runner
    }

    /// The present revision.
    pub fn revision(&self) -> Revision {
        self.revision
    }

    /// Changes state, model, settings or precision: every reading from before is void.
    pub(super) fn change<T>(&mut self, change: impl FnOnce(&mut Runner) -> T) -> T {
        self.revision.0 += 1;
        self.is_driven = false;
        change(&mut self.runner)
    }

    /// Takes a step. Automatic substeps that were renewed before it void every reading, but for
    /// those that are carried over.
    pub(super) fn step(&mut self) -> Result<(), Error> {
        let before = self.runner.settings();
        self.runner.bound_work();
        let stepped = self.runner.step();
        if self.runner.settings() != before {
            self.revision.0 += 1;
        }
        stepped
    }

    /// Goes on for a part of a frame with what the next step begins with, a choice of automatic
    /// substeps; whether nothing is left of it. Others than before void every reading.
    pub(super) fn prepare(
        &mut self,
        estimator: &mut Estimator,
        stopwatch: &impl Fn() -> f64,
    ) -> Result<bool, Error> {
        let (before, start) = (self.runner.settings(), stopwatch());
        while self.runner.prepare(estimator)? {
            if PREDICTING < stopwatch() - start && self.runner.settings() == before {
                return Ok(false);
            }
        }
        if self.runner.settings() != before {
            self.revision.0 += 1;
        }
        Ok(true)
    }

    /// Whether gusts do work, so that the balance of the energy says nothing of the method.
    pub fn is_driven(&self) -> bool {
        self.is_driven
    }

    /// Sets a look, which no reading depends on.
    pub(super) fn paint(&mut self, look: Interaction) -> Result<(), Error> {
        act(&mut self.runner, look)
    }

    /// Moves what the mouse holds already, the target of a grab or a pin, or goes on with a gust.
    pub(super) fn move_held(&mut self, motion: Interaction) -> Result<(), Error> {
        self.is_driven |= matches!(motion, Interaction::SetForce { .. });
        act(&mut self.runner, motion)
    }
}

/// Opens a run to be shown.
pub(super) fn open(loaded: &Loaded, solver: Solver) -> Result<Runner, Error> {
    let open = if IS_LAZY { Runner::open_lazily } else { Runner::open_with };
    let mut runner = open(loaded, solver)?;
    // The session sets gusts itself, as it records them.
    runner.calm();
    Ok(runner)
}

/// Does something to a simulation at once.
pub(super) fn act(runner: &mut Runner, interaction: Interaction) -> Result<(), Error> {
    runner.queue(interaction).and_then(|()| runner.apply_queued())
}

/// A value read from a run, which can be had only while the run has not been changed since.
#[derive(Clone, Debug)]
pub struct Reading<T> {
    value: T,
    of: Revision,
}

impl<T> Reading<T> {
    /// A value read just now.
    pub(super) fn new(value: T, run: &Run) -> Self {
        Reading { value, of: run.revision }
    }

    /// The value, unless the run was changed since.
    pub fn of(&self, run: &Run) -> Option<&T> {
        (self.of == run.revision).then_some(&self.value)
    }

    /// Keeps a value of an earlier revision that the change since does not concern.
    pub(super) fn carry_over(&mut self, from: Revision, run: &Run) {
        if self.of == from {
            self.of = run.revision;
        }
    }

    /// Like [`Reading::of`], to go on with the value.
    pub(super) fn of_mut(&mut self, run: &Run) -> Option<&mut T> {
        (self.of == run.revision).then_some(&mut self.value)
    }
}
