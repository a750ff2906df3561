//! Undo of what hands have set: the model as it was before under the state and the settings of now,
//! or the settings as they were before for the model of now.

use crate::session::material::{Material, WIND};
use glam::DVec3;
use msd_core::{Error, Interaction};
use msd_run::{Runner, on};
use msd_scene::Assignment;
use msd_scene::schema::Solver;

/// The most that is kept to go back to, rows of particles and springs: a hundred bytes each.
const MOST_ROWS: usize = 2_000_000;
/// Edits of one kind that follow each other within so much of the wall clock are one, seconds, such
/// as those of arrow keys. While a hand holds something no time counts: a slider that is dragged is
/// put back where it was taken, however few frames there are.
const TOGETHER: f64 = 1.0;

/// What can be undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// A slider was moved.
    Edit(&'static str),
    /// A part of the model was switched off or on.
    Switch(&'static str),
    /// It was stepped otherwise: by another method, or more finely.
    Solver(&'static str),
    /// A particle was pinned or freed.
    Pin,
    /// Springs were cut.
    Cut,
    /// The present shape became the shape at rest.
    Freeze,
    /// The wind turned, or another blows.
    Wind,
}

impl Deed {
    /// What it was, in a few words.
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

/// What a deed has changed, to go back to.
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

/// What a deed may change: the run, and what was set of its scene, the wind included.
pub(in crate::session) type Now<'a> = (&'a Runner, &'a Material);

impl Before {
    /// What a deed is about to change.
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

    /// A run and what was set of its scene as they are now, but for what the deed has changed. The
    /// wind stays as it is now, unless the deed is of it.
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

/// The model of a run under the state, the settings and the precision of that of now; nothing is
/// held.
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
        // A pin that was being moved then would move on.
        if on!(&runner, simulation => simulation.model().is_pinned(particle)) {
            runner.queue(Interaction::Pin { particle, velocity: DVec3::ZERO })?;
        }
    }
    runner.apply_queued()?;
    runner.go_back(&now.moment())?;
    runner.set_automatic(now.is_automatic())?;
    Ok(runner)
}

/// What can be undone and done again, the last one last.
#[derive(Clone, Debug, Default)]
pub struct Undo {
    past: Vec<Before>,
    future: Vec<Before>,
    /// Wall-clock time since the last deed that counts, seconds.
    age: f64,
    /// Whether a hand holds something, and whether one did since the last frame.
    is_held: bool,
    was_held: bool,
}

impl Undo {
    /// Takes note of what hands do in a frame, before its time passes: whether they press, which
    /// begins an edit of its own, and whether they hold something.
    pub(in crate::session) fn follow(&mut self, presses: bool, holds: bool) {
        if presses {
            self.age = f64::INFINITY;
        }
        self.was_held = std::mem::replace(&mut self.is_held, holds);
    }

    /// Lets wall-clock time pass, seconds.
    pub(in crate::session) fn pass(&mut self, real: f64) {
        // In the frame of a release something was held until then.
        if !self.is_held && !self.was_held {
            self.age += real.max(0.0);
        }
    }

    /// Whether what is about to be done begins something new, or goes on with the last edit.
    pub(in crate::session) fn begins(&mut self, deed: Deed) -> bool {
        let goes_on = matches!(deed, Deed::Edit(_) | Deed::Solver(_) | Deed::Cut | Deed::Wind)
            && self.age <= TOGETHER
            && self.future.is_empty()
            && self.past.last().is_some_and(|last| last.deed == deed);
        self.age = 0.0;
        !goes_on
    }

    /// Keeps what was before something new, and forgets the oldest beyond the cap.
    pub(in crate::session) fn keep(&mut self, before: Before) {
        self.future.clear();
        self.past.push(before);
        while 1 < self.past.len() && MOST_ROWS < self.past.iter().map(Before::rows).sum() {
            self.past.remove(0);
        }
    }

    /// Takes back what was kept last: it was refused.
    pub(in crate::session) fn withdraw(&mut self) {
        self.past.pop();
    }

    /// What comes back: before the last deed, or after the one that was undone last. The run as it
    /// is takes its place on the other side.
    pub(in crate::session) fn turn(&mut self, is_undo: bool, now: Now<'_>) -> Option<Before> {
        let (from, to) = match is_undo {
            true => (&mut self.past, &mut self.future),
            false => (&mut self.future, &mut self.past),
        };
        let before = from.pop()?;
        to.push(Before::new(before.deed, now));
        // The next edit is one of its own.
        self.age = f64::INFINITY;
        Some(before)
    }

    /// What would be undone.
    pub fn last(&self) -> Option<Deed> {
        self.past.last().map(|before| before.deed)
    }

    /// What would be done again.
    pub fn next(&self) -> Option<Deed> {
        self.future.last().map(|before| before.deed)
    }

    /// Forgets everything, as at a restart.
    pub(in crate::session) fn clear(&mut self) {
        *self = Undo::default();
    }
}
