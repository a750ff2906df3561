//! Undo of the user's edits: either the previous model with the current state and settings, or the
//! previous settings with the current model.

use crate::session::material::{Material, WIND};
use glam::DVec3;
use msd_core::{Error, Interaction};
use msd_run::{Runner, on};
use msd_scene::Assignment;
use msd_scene::schema::Solver;

/// Limit on the kept models, rows of particles and springs: a hundred bytes each.
const MOST_ROWS: usize = 2_000_000;
/// Longest wall-clock time between two edits of one kind, such as those of arrow keys, that undo
/// reverts together, seconds. While a button or key is held, time does not count: undo returns a
/// dragged slider to its start, even at a low frame rate.
const TOGETHER: f64 = 1.0;

/// An undoable edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// A move of a slider.
    Edit(&'static str),
    /// A switch of a term of the model.
    Switch(&'static str),
    /// A change of the solver.
    Solver(&'static str),
    /// A particle pinned or freed.
    Pin,
    /// A cut of springs.
    Cut,
    /// The current shape made the rest shape.
    Freeze,
    /// A change of the wind.
    Wind,
}

impl Deed {
    /// Returns a description in a few words.
    pub fn words(self) -> &'static str {
        match self {
            Deed::Edit(what) | Deed::Switch(what) | Deed::Solver(what) => what,
            Deed::Pin => "pin",
            Deed::Cut => "cut",
            Deed::Freeze => "freeze",
            Deed::Wind => "wind",
        }
    }
}

/// The state before an edit, for undo.
#[derive(Clone, Debug)]
pub struct Before {
    deed: Deed,
    kept: Kept,
}

#[derive(Clone, Debug)]
enum Kept {
    Model(Box<(Runner, Material)>),
    Solver(Solver),
    Wind(Option<Assignment>),
}

/// The objects that an edit may change: the run, and the edits of its scene, the wind included.
pub(in crate::session) type Now<'a> = (&'a Runner, &'a Material);

impl Before {
    /// Keeps the state that an edit is about to change.
    pub(in crate::session) fn new(deed: Deed, (runner, material): Now<'_>) -> Self {
        let kept = match deed {
            Deed::Solver(_) => Kept::Solver(runner.solver()),
            Deed::Wind => Kept::Wind(material.set().of(WIND).cloned()),
            _ => Kept::Model(Box::new((runner.clone(), material.clone()))),
        };
        Before { deed, kept }
    }

    fn rows(&self) -> usize {
        match &self.kept {
            Kept::Model(model) => model.0.particle_count() + model.0.spring_count(),
            Kept::Solver(_) | Kept::Wind(_) => 1,
        }
    }

    /// Returns the current run and edits with this edit reverted. The wind stays as it is, unless
    /// the edit changed it.
    pub(in crate::session) fn restored(
        self,
        (now, material): Now<'_>,
    ) -> Result<(Runner, Material), Error> {
        match self.kept {
            Kept::Model(model) => {
                let (runner, mut before) = *model;
                before.set_wind(material.set().of(WIND).cloned());
                Ok((under(runner, now)?, before))
            }
            Kept::Wind(edit) => {
                let mut material = material.clone();
                material.set_wind(edit);
                Ok((now.clone(), material))
            }
            Kept::Solver(solver) => {
                let mut runner = now.clone();
                runner.set_solver(solver)?;
                Ok((runner, material.clone()))
            }
        }
    }
}

/// Returns the model of a run with the state, settings and precision of the current one, and
/// without grabs.
fn under(mut runner: Runner, now: &Runner) -> Result<Runner, Error> {
    if runner.precision() != now.precision() {
        runner = runner.convert(now.precision())?;
    }
    runner.set_automatic(false)?;
    runner.set_settings(now.settings())?;
    let grabs = on!(&runner, simulation => {
        simulation.model().grabs().iter().map(|grab| grab.particle).collect::<Vec<u32>>()
    });
    for particle in grabs.into_iter().map(|particle| particle as usize) {
        runner.queue(Interaction::Release { particle })?;
        // A pin that was moving at that time would move on.
        if on!(&runner, simulation => simulation.model().is_pinned(particle)) {
            runner.queue(Interaction::Pin { particle, velocity: DVec3::ZERO })?;
        }
    }
    runner.apply_queued()?;
    runner.go_back(&now.moment())?;
    runner.set_automatic(now.is_automatic())?;
    Ok(runner)
}

/// The edits for undo and redo, the next one last.
#[derive(Clone, Debug, Default)]
pub struct Undo {
    past: Vec<Before>,
    future: Vec<Before>,
    /// Wall-clock time since the last edit, seconds.
    age: f64,
    /// Whether a button or key is held, and whether one was since the last frame.
    is_held: bool,
    was_held: bool,
}

impl Undo {
    /// Notes the user input of a frame before its time passes. `presses` begins a separate edit;
    /// `holds` is whether a button or key is down.
    pub(in crate::session) fn follow(&mut self, presses: bool, holds: bool) {
        if presses {
            self.age = f64::INFINITY;
        }
        self.was_held = std::mem::replace(&mut self.is_held, holds);
    }

    /// Advances by `real` seconds of wall clock.
    pub(in crate::session) fn pass(&mut self, real: f64) {
        // In the frame of a release, the button was held until then.
        if !self.is_held && !self.was_held {
            self.age += real.max(0.0);
        }
    }

    /// Returns whether an edit begins a new undo step, instead of continuing the last one.
    pub(in crate::session) fn begins(&mut self, deed: Deed) -> bool {
        let goes_on = matches!(deed, Deed::Edit(_) | Deed::Solver(_) | Deed::Cut | Deed::Wind)
            && self.age <= TOGETHER
            && self.future.is_empty()
            && self.past.last().is_some_and(|last| last.deed == deed);
        self.age = 0.0;
        !goes_on
    }

    /// Keeps the state before an edit, and drops the oldest ones beyond the limit.
    pub(in crate::session) fn keep(&mut self, before: Before) {
        self.future.clear();
        self.past.push(before);
        while 1 < self.past.len() && MOST_ROWS < self.past.iter().map(Before::rows).sum() {
            self.past.remove(0);
        }
    }

    /// Drops the last state: its edit was refused.
    pub(in crate::session) fn withdraw(&mut self) {
        self.past.pop();
    }

    /// Takes the state before the last edit, or after the last undone one. The current state takes
    /// its place on the other stack.
    pub(in crate::session) fn turn(&mut self, is_undo: bool, now: Now<'_>) -> Option<Before> {
        let (from, to) = match is_undo {
            true => (&mut self.past, &mut self.future),
            false => (&mut self.future, &mut self.past),
        };
        let before = from.pop()?;
        to.push(Before::new(before.deed, now));
        // The next edit begins a separate undo step.
        self.age = f64::INFINITY;
        Some(before)
    }

    /// Returns the edit that undo would revert.
    pub fn last(&self) -> Option<Deed> {
        self.past.last().map(|before| before.deed)
    }

    /// Returns the edit that redo would repeat.
    pub fn next(&self) -> Option<Deed> {
        self.future.last().map(|before| before.deed)
    }

    /// Drops everything, as at a restart.
    pub(in crate::session) fn clear(&mut self) {
        *self = Undo::default();
    }
}
