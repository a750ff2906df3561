//! The course of some points through a run that is as good as exact in time.

use crate::measure::cache;
use crate::measure::clock::CpuClock;
use crate::measure::errors::rms_between;
use crate::measure::reference::{Reference, exact, visit_frames};
use crate::monitor::{Halt, Monitor};
use msd_core::glam::DVec3;
use msd_core::{Scene, Surface};
use serde::{Deserialize, Serialize};

/// Positions of some points of a scene at the samples of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Track {
    /// The points at each sample, metres.
    pub samples: Vec<Vec<DVec3>>,
    /// Time of the processor that the run took, seconds.
    pub seconds: f64,
}

impl Track {
    /// The course of points of a reference.
    pub fn of(right: &Reference, points: &[usize]) -> Self {
        let sample =
            |state: &crate::measure::reference::Sample| picked(&state.positions, points).collect();
        Track { samples: right.states.iter().map(sample).collect(), seconds: right.seconds }
    }

    /// Root mean square distance from another course at each sample, metres.
    pub fn distances<'t>(&'t self, other: &'t Track) -> impl Iterator<Item = f64> + 't {
        self.samples.iter().zip(&other.samples).map(|(a, b)| rms_between(a, b))
    }

    /// The largest of those at the first `samples`.
    pub fn distance(&self, other: &Track, samples: usize) -> f64 {
        self.distances(other).take(samples).fold(0.0, f64::max)
    }
}

/// A scene without its surfaces: its looks do not matter.
pub(crate) fn undrawn(scene: &Scene) -> Scene {
    let mut plain = scene.clone();
    plain.bodies.iter_mut().for_each(|body| body.surface = Surface::default());
    plain
}

/// Positions of some particles.
pub(crate) fn picked<'p>(
    positions: &'p [DVec3],
    points: &'p [usize],
) -> impl Iterator<Item = DVec3> + 'p {
    points.iter().map(|&point| positions[point])
}

/// A scene to be run, and the points that are followed.
#[derive(Clone, Copy)]
pub(crate) struct Followed<'s> {
    pub scene: &'s Scene,
    pub points: &'s [usize],
    /// Frames of 1/60 s.
    pub frames: &'s [u64],
    pub tolerance: f64,
}

/// Follows points, or finds their course in the cache. `None` where that would take longer than
/// `most` seconds of the processor: as `predicted`, or as it turns out.
pub(crate) fn track(
    followed: Followed<'_>,
    (predicted, most): (f64, f64),
    monitor: &mut dyn Monitor,
) -> Result<Option<Track>, Halt> {
    let Followed { scene, points, frames, tolerance } = followed;
    let hash = cache::content_hash(&(&undrawn(scene), points, frames, tolerance));
    if let Some(track) = cache::get(TRACK, &hash) {
        return Ok(Some(track));
    }
    if most < predicted {
        return Ok(None);
    }
    let clock = CpuClock::start();
    let mut samples = Vec::with_capacity(frames.len());
    let mut see = |state: msd_core::State<f64>| {
        samples.push(picked(&state.positions, points).collect());
    };
    let mut is_late = false;
    let ran = visit_frames(scene, (frames, exact(scene, tolerance)?), &mut see, &mut || {
        is_late = most < clock.seconds();
        if is_late { Err(Halt::Deadline) } else { monitor.proceed() }
    });
    match ran {
        Err(Halt::Deadline) if is_late => return Ok(None),
        ran => ran?,
    }
    let track = Track { samples, seconds: clock.seconds() };
    cache::put(TRACK, &hash, &track);
    Ok(Some(track))
}

/// Courses in the cache.
const TRACK: &str = "track";
