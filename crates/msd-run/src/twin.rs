//! Twins: two replays of one recording, stepped differently, and how far they drift apart.

use crate::on;
use crate::recording::Recording;
use crate::replay::Replay;
use crate::runner::Runner;
use msd_core::glam::DVec3;
use msd_core::{Error, Vector};
use msd_scene::schema::SolverRow;

/// The first line of a file of distances.
pub const HEADER: &str = "step,time,rms,max,particle";

/// The distance that counts as noticeable, as a fraction of the size of the scene.
pub const NOTICEABLE: f64 = 0.01;

/// Distance between two runs after a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// The step.
    pub step: u64,
    /// Simulated time, seconds.
    pub time: f64,
    /// Root of the mean square distance of the particles, metres.
    pub rms: f64,
    /// The largest distance of a particle, metres.
    pub max: f64,
    /// The particle that is farthest off.
    pub particle: usize,
}

impl Apart {
    /// The line of a file of distances, with as many digits as read back as the same numbers.
    pub fn line(&self) -> String {
        let Apart { step, time, rms, max, particle } = self;
        format!("{step},{time:?},{rms:?},{max:?},{particle}")
    }
}

/// A recording replayed twice at once: as it was, and with changes.
#[derive(Clone, Debug)]
pub struct Twin<'a> {
    recorded: Replay<'a>,
    changed: Replay<'a>,
    last: Apart,
    noticed: Option<Apart>,
}

impl<'a> Twin<'a> {
    /// Gets ready to replay a recording.
    ///
    /// # Errors
    /// See [`Replay::new`].
    pub fn new(recording: &'a Recording, changes: SolverRow) -> Result<Self, Error> {
        Ok(Twin {
            recorded: Replay::new(recording, SolverRow::default())?,
            changed: Replay::new(recording, changes)?,
            last: Apart::default(),
            noticed: None,
        })
    }

    /// Takes the next step of both and returns how far they are apart; nothing where the recording
    /// ends.
    ///
    /// # Errors
    /// See [`Replay::advance`].
    pub fn advance(&mut self) -> Result<Option<Apart>, Error> {
        if !(self.recorded.advance()? & self.changed.advance()?) {
            return Ok(None);
        }
        self.last = apart(self.recorded.runner(), self.changed.runner());
        if self.noticed.is_none() && NOTICEABLE * self.size() < self.last.rms {
            self.noticed = Some(self.last);
        }
        Ok(Some(self.last))
    }

    /// The run as it was recorded.
    pub fn recorded(&self) -> &Replay<'a> {
        &self.recorded
    }

    /// The run with changes.
    pub fn changed(&self) -> &Replay<'a> {
        &self.changed
    }

    /// The current distance between them.
    pub fn last(&self) -> Apart {
        self.last
    }

    /// When the root mean square distance first passed [`NOTICEABLE`], if it did.
    pub fn noticed(&self) -> Option<Apart> {
        self.noticed
    }

    /// Size of the scene at its start, metres.
    pub fn size(&self) -> f64 {
        on!(self.recorded.runner(), simulation => simulation.model().size())
    }
}

/// Returns the distance of a run from another of the same particles; step and time are those of the
/// first.
pub fn apart(a: &Runner, b: &Runner) -> Apart {
    let (mut squares, mut farthest) = (0.0, (0, 0.0));
    for (particle, (a, b)) in positions(a).into_iter().zip(positions(b)).enumerate() {
        let squared = (a - b).length_squared();
        squares += squared;
        if farthest.1 < squared {
            farthest = (particle, squared);
        }
    }
    let (particle, squared) = farthest;
    let rms = (squares / a.particle_count() as f64).sqrt();
    Apart { step: a.steps(), time: a.time(), rms, max: squared.sqrt(), particle }
}

fn positions(runner: &Runner) -> Vec<DVec3> {
    on!(runner, simulation => {
        simulation.positions().map(|position| position.to_f64()).collect()
    })
}
