//! A scene at ever finer spacings, as far as the time and the memory allow.

use crate::candidates::choice::FRAME;
use crate::measure::cache;
use crate::measure::clock::CpuClock;
use crate::measure::reference::{Reference, Wish, reference};
use crate::monitor::{Halt, Monitor, Progress};
use crate::quantity::estimate;
use crate::space::limit::{Verdict, extrapolate};
use crate::space::track::{Followed, Track, track, undrawn};
use crate::space::{Space, Spacing};
use msd_core::Scene;
use msd_core::glam::DVec3;
use msd_scene::tree::Source;
use msd_scene::{Draft, FileError, Finer};

/// Limits of the search for the error of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePlan {
    /// Time to simulate, seconds.
    pub duration: f64,
    /// CPU time to spend on finer spacings, seconds, besides the reference of the scene at its own
    /// spacing.
    pub budget: f64,
    /// Largest error of that reference, root mean square, as a fraction of the size of the scene.
    pub uncertainty: f64,
    /// Time of the processor after which it is not tightened further, seconds.
    pub patience: f64,
}

impl Default for SpacePlan {
    fn default() -> Self {
        let Wish { duration, uncertainty, patience } = Wish::default();
        SpacePlan { duration, budget: 60.0, uncertainty, patience }
    }
}

/// The most times that a spacing is halved.
const MOST_HALVINGS: u32 = 2;
/// Tolerances at which finer spacings are run: the first that is good enough.
const TOLERANCES: [f64; 3] = [1e-6, 1e-8, 1e-10];
/// The part of the difference of two spacings that the error of time may be.
const TIME_PART: f64 = 0.05;
/// The remaining error of a run, as a part of the distance by which a tolerance a hundred times as
/// tight moved it.
const MOVED_PART: f64 = 0.1;
/// Where the error of time is more than this part, the difference does not show the error of space.
const LOST_PART: f64 = 0.5;
/// Roundings after a run, as a part of the size of the scene.
const ROUNDING: f64 = 1e-10;
/// The least error of a run, as a part of the error that its tolerance allows.
const ALLOWED: f64 = 0.01;
/// Kept in the cache by the scene.
const SPACE: &str = "space-2";

/// A scene that was run at several spacings.
pub(crate) struct Halved {
    pub space: Space,
    /// The points without an error of space, and the number of samples at which they are known.
    pub right: Option<(Track, usize)>,
    /// The reference of the scene at its own spacing.
    pub reference: Reference,
    /// The finer scenes that were run, finest last.
    pub finer: Vec<Finer>,
}

/// Finds the error of space of a scene.
///
/// # Errors
/// A body that has no spacing; a scene that the core refuses; the error of [`Monitor::proceed`].
pub fn space(
    draft: &Draft,
    plan: SpacePlan,
    monitor: &mut dyn Monitor,
) -> Result<Space, Halt<FileError>> {
    Ok(halve(draft, plan, monitor)?.space)
}

/// Returns an earlier result for a scene, for whatever duration.
pub fn known(scene: &Scene) -> Option<Space> {
    cache::get(SPACE, &scene_hash(scene))
}

/// The hash of a scene as a run in either precision has it: rounded to f32, bends and volumes in
/// one order.
fn scene_hash(scene: &Scene) -> String {
    let mut scene = undrawn(scene);
    let round = |value: &mut f64| *value = f64::from(*value as f32);
    let single = |vector: &mut DVec3| *vector = vector.as_vec3().into();
    for row in &mut scene.particles {
        [&mut row.position, &mut row.velocity].into_iter().for_each(single);
        round(&mut row.mass);
    }
    for row in &mut scene.springs {
        [&mut row.rest_length, &mut row.stiffness, &mut row.damping].into_iter().for_each(round);
    }
    for row in &mut scene.bends {
        row.weights.iter_mut().for_each(round);
        [&mut row.rest, &mut row.stiffness, &mut row.damping].into_iter().for_each(round);
    }
    for row in &mut scene.volumes {
        [&mut row.rest_volume, &mut row.modulus, &mut row.damping].into_iter().for_each(round);
    }
    scene.pins.iter_mut().for_each(|row| single(&mut row.velocity));
    scene.planes.iter_mut().for_each(|row| single(&mut row.normal));
    let world = &mut scene.world;
    [&mut world.gravity, &mut world.force].into_iter().for_each(single);
    [&mut world.drag, &mut world.extent].into_iter().for_each(round);
    scene.bends.sort_by_key(|row| row.particles);
    scene.volumes.sort_by_key(|row| row.particles);
    cache::content_hash(&scene)
}

/// Runs a scene at ever finer spacings.
pub(crate) fn halve(
    draft: &Draft,
    plan: SpacePlan,
    monitor: &mut dyn Monitor,
) -> Result<Halved, Halt<FileError>> {
    let source = draft.source()?;
    let scene = draft.load(&source)?.scene;
    let finer = vec![draft.finer(&source, &scene, 1)?];
    let SpacePlan { duration, budget, uncertainty, patience } = plan;
    let wish = Wish { duration, uncertainty, patience };
    let reference = reference(&scene, wish, monitor).map_err(|halt| of_file(draft, halt))?;
    // Samples beyond which rounding alone moves the particles.
    let samples = reference.comparable(1e-4 * reference.size);
    let points: Vec<usize> = finer[0].common.iter().map(|pair| pair[0]).collect();
    let mut halving = Halving { draft, source, scene, finer, points, reference, samples, budget };
    let mut run = Run { tracks: Vec::new(), off: 0.0, stopped: String::new() };
    for tolerance in TOLERANCES {
        // Contact may put a tolerance out of reach, as it did for the reference.
        let tolerance = tolerance.max(halving.reference.tolerance);
        let mut tighter = halving.run(tolerance, monitor)?;
        tighter.off = tighter.off.max(MOVED_PART * run.moved(&tighter));
        // An error that is not affordable to the last digit is known to the first.
        let is_poorer = tighter.tracks.len() < run.tracks.len();
        if !is_poorer {
            run = tighter;
        }
        if is_poorer || run.is_resolved() || run.tracks.len() < 2 {
            break;
        }
    }
    Ok(halving.limit(run))
}

/// A scene and its finer ones.
struct Halving<'d> {
    draft: &'d Draft,
    source: Source<'d>,
    scene: Scene,
    finer: Vec<Finer>,
    /// Particles of the scene that all finer ones have too.
    points: Vec<usize>,
    reference: Reference,
    /// Samples that are compared.
    samples: usize,
    /// Time of the processor that is left, seconds.
    budget: f64,
}

/// Result of running them at one tolerance.
struct Run {
    /// Coarsest first; that of the scene's own spacing comes from its reference.
    tracks: Vec<Track>,
    /// The error of time that the tolerance leaves in the scene at its own spacing, metres; at
    /// least the error of rounding.
    off: f64,
    /// The reason why the spacing was not halved further.
    stopped: String,
}

impl Run {
    /// The largest distance between the two coarsest, metres.
    fn first_difference(&self) -> f64 {
        match &self.tracks[..] {
            [coarse, fine, ..] => coarse.distance(fine, coarse.samples.len()),
            _ => 0.0,
        }
    }

    /// The largest distance between a course here and the same at another tolerance, metres.
    fn moved(&self, other: &Run) -> f64 {
        let pairs = self.tracks.iter().zip(&other.tracks);
        pairs.map(|(a, b)| a.distance(b, a.samples.len())).fold(0.0, f64::max)
    }

    /// Returns whether the error of time is a small part of the error of the spacing. Where finer
    /// spacings lie farther apart than coarse ones, it may be theirs.
    fn is_resolved(&self) -> bool {
        let diverges = match &self.tracks[..] {
            [_, middle, fine] => {
                self.first_difference() < middle.distance(fine, middle.samples.len())
            }
            _ => false,
        };
        !diverges && self.off <= TIME_PART * self.first_difference()
    }
}

impl Halving<'_> {
    fn run(&mut self, tolerance: f64, monitor: &mut dyn Monitor) -> Result<Run, Halt<FileError>> {
        let mut coarse = Track::of(&self.reference, &self.points);
        coarse.samples.truncate(self.samples);
        let frames = &self.reference.frames[..self.samples];
        let own = Followed { scene: &self.scene, points: &self.points, frames, tolerance };
        let own = track(own, (0.0, f64::INFINITY), monitor);
        let own = own.map_err(|halt| of_file(self.draft, halt))?.unwrap_or_else(|| coarse.clone());
        // Finer runs may be off where this one happens not to be.
        let least = ROUNDING.max(ALLOWED * tolerance) * self.reference.size;
        let off = own.distance(&coarse, self.samples).max(least);
        let stopped = "a spacing is halved twice at most".into();
        let mut run = Run { tracks: vec![coarse], off, stopped };
        let mut before = (self.scene.springs.len(), own.seconds);
        for halvings in 1..=MOST_HALVINGS {
            let now = format!("running it at 1/{} of its spacing", 1 << halvings);
            monitor.report(Progress::of(now));
            match self.run_finer(halvings, tolerance, before, monitor)? {
                Ok((springs, track)) => {
                    before = (springs, track.seconds);
                    run.tracks.push(track);
                }
                Err(why) => {
                    run.stopped = why;
                    break;
                }
            }
        }
        Ok(run)
    }

    /// Runs the scene at a part of its spacing, by springs and seconds of the next
    /// coarser one. Returns the number of springs as well, or why it was not run.
    fn run_finer(
        &mut self,
        halvings: u32,
        tolerance: f64,
        (springs, seconds): (usize, f64),
        monitor: &mut dyn Monitor,
    ) -> Result<Result<(usize, Track), String>, Halt<FileError>> {
        if self.finer.len() < halvings as usize {
            let finer = self.draft.finer(&self.source, &self.scene, halvings);
            match finer {
                Ok(finer) => self.finer.push(finer),
                Err(error) => return Ok(Err(error.to_string())),
            }
        }
        let Finer { loaded, common, .. } = &self.finer[halvings as usize - 1];
        let scene = &loaded.scene;
        let points: Vec<usize> = common.iter().map(|pair| pair[1]).collect();
        // Twice as many steps, each of more springs.
        let predicted = 2.0 * scene.springs.len() as f64 / springs.max(1) as f64 * seconds;
        let frames = &self.reference.frames[..self.samples];
        let followed = Followed { scene, points: &points, frames, tolerance };
        let clock = CpuClock::start();
        let found = track(followed, (predicted, self.budget), monitor);
        // Results from the cache cost nothing.
        self.budget -= clock.seconds();
        let parts = 1 << halvings;
        match found.map_err(|halt| of_file(self.draft, halt)) {
            Ok(Some(track)) => Ok(Ok((scene.springs.len(), track))),
            Ok(None) => Ok(Err(format!(
                "1/{parts} of the spacing takes about {} of processor time: --time gives more",
                estimate(predicted, "s")
            ))),
            Err(Halt::Refused(error)) => Ok(Err(format!("at 1/{parts} of the spacing, {error}"))),
            Err(halt) => Err(halt),
        }
    }

    /// The conclusion from the runs.
    fn limit(self, run: Run) -> Halved {
        let Halving { scene, mut finer, points, reference, samples, .. } = self;
        let frames = &reference.frames[..samples];
        let times: Vec<f64> = frames.iter().map(|&frame| frame as f64 * FRAME).collect();
        let (mut right, mut verdict) = extrapolate(&run.tracks, &times);
        let mut below = None;
        if 1 < run.tracks.len() && LOST_PART * run.first_difference() < run.off {
            // An order of less than 1 is not to be expected: twice the first difference.
            let error = run.off + 2.0 * run.first_difference();
            (verdict, below) = (Verdict::Below { error }, Some(error));
            // As good as the limit.
            right = run.tracks.last().map(|finest| (finest.clone(), samples));
        } else if let Verdict::Known { band, .. } = &mut verdict {
            // Each of the two that the limit is made of may be off by that much.
            *band += 2.0 * run.off;
        }
        let scenes = std::iter::once(&scene).chain(finer.iter().map(|finer| &finer.loaded.scene));
        let spacing = |(row, (scene, track)): (usize, (&Scene, &Track))| Spacing {
            parts: 1 << row,
            particles: scene.particles.len(),
            springs: scene.springs.len(),
            error: below
                .or_else(|| right.as_ref().map(|(limit, samples)| track.distance(limit, *samples))),
            seconds: track.seconds,
        };
        let spacings = scenes.zip(&run.tracks).enumerate().map(spacing).collect();
        let (duration, points) = (reference.duration(), points.len());
        let compared = times.last().copied().unwrap_or(0.0);
        let space = Space { duration, compared, points, spacings, verdict, stopped: run.stopped };
        if !matches!(space.verdict, Verdict::Untold) {
            cache::put(SPACE, &scene_hash(&scene), &space);
        }
        finer.truncate(run.tracks.len().max(2) - 1);
        Halved { space, right, reference, finer }
    }
}

/// The same, a refusal with the name of the file.
pub(crate) fn of_file(draft: &Draft, halt: impl Into<Halt>) -> Halt<FileError> {
    let file = draft.name.clone();
    halt.into().map(|error| FileError::Core { file, source: Box::new(error) })
}
