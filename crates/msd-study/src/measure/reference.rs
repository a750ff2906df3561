//! Reference runs, exact to a stated uncertainty.

use crate::candidates::choice::{Choice, FRAME, Fineness};
use crate::measure::cache;
use crate::measure::clock::CpuClock;
use crate::measure::errors::rms_distance;
use crate::monitor::{Halt, Monitor, Progress};
use crate::quantity::rounded;
use msd_core::glam::DVec3;
use msd_core::scene::any_meet;
use msd_core::{Error, Integrator, Scene, Settings, Simulation, State, Surface};
use msd_scene::Precision;
use serde::{Deserialize, Serialize};

/// The way in which a reference is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wish {
    /// Time to cover, seconds; brought to a whole number of frames of 1/60 s.
    pub duration: f64,
    /// Distance by which a tighter tolerance may still move the particles, root mean square, as a
    /// fraction of the size of the scene.
    pub uncertainty: f64,
    /// Time of the processor after which it is not tightened further, seconds.
    pub patience: f64,
}

impl Default for Wish {
    fn default() -> Self {
        Wish { duration: 1.0, uncertainty: 1e-8, patience: 30.0 }
    }
}

/// The right states of a scene, and how right they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Frames of 1/60 s at which states are kept, ascending.
    pub frames: Vec<u64>,
    /// Positions and velocities at those frames.
    pub states: Vec<Sample>,
    /// Root mean square distance by which the last tightening of the tolerance moved the particles
    /// at each of those frames, metres; at least the distance that the tolerance allows. It is an
    /// upper estimate of the remaining error.
    pub moved: Vec<f64>,
    /// Distance to which a perturbation of 1e-12 times the size of the scene has grown at each of
    /// those frames, root mean square, metres.
    pub grown: Vec<f64>,
    /// Tolerance of the run; 0 where a closed form gave the states.
    pub tolerance: f64,
    /// Substeps in a frame of 1/60 s of the run of RK4 that stands for that tolerance where shells
    /// meet; 0 of Dormand-Prince.
    pub substeps: u32,
    /// Size of the scene, metres: see [`size_of`].
    pub size: f64,
    /// Time of the processor that it took, seconds.
    pub seconds: f64,
}

/// A state in double precision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Positions, metres.
    pub positions: Vec<DVec3>,
    /// Velocities, metres per second.
    pub velocities: Vec<DVec3>,
}

impl Sample {
    /// The state of a run.
    pub fn of(State { positions, velocities }: State<f64>) -> Self {
        Sample { positions, velocities }
    }

    /// The sample as a state.
    pub fn state(&self) -> State<f64> {
        State { positions: self.positions.clone(), velocities: self.velocities.clone() }
    }
}

/// The most samples that a reference keeps.
const MAX_SAMPLES: u64 = 60;
/// A perturbation that a predictable scene forgets, as a fraction of its size.
const PERTURBATION: f64 = 1e-12;
/// The tolerances that a reference may start from.
const FIRST_TOLERANCES: [f64; 3] = [1e-6, 1e-5, 1e-4];
/// The last tolerance that a reference is tightened to: below it rounding rules.
const LAST_TOLERANCE: f64 = 1e-13;
/// Dormand-Prince is not judged at less than this times the tolerance of its reference.
const APART: f64 = 30.0;

impl Reference {
    /// Largest uncertainty over all samples, metres.
    pub fn uncertainty(&self) -> f64 {
        self.moved.iter().copied().fold(0.0, f64::max)
    }

    /// The least tolerance at which Dormand-Prince can be judged by this reference, which is itself
    /// a run of it.
    pub fn least_tolerance(&self) -> f64 {
        APART * self.tolerance
    }

    /// Time covered, seconds.
    pub fn duration(&self) -> f64 {
        self.frames.last().copied().unwrap_or(0) as f64 * FRAME
    }

    /// Samples from the start at which particles can be compared to within `wanted` metres: further
    /// on rounding alone, or the remaining error of the reference, reaches it.
    pub fn reliable(&self, wanted: f64) -> usize {
        let mut rows = self.moved.iter().zip(&self.grown);
        let lost = |(&moved, &grown): (&f64, &f64)| wanted < moved.max(grown);
        rows.position(lost).unwrap_or(self.frames.len())
    }

    /// Samples to compare at: those reliable to within `wanted` metres, or where none is, those
    /// reliable to a ten thousandth of the size, and the first one at least.
    pub fn comparable(&self, wanted: f64) -> usize {
        match self.reliable(wanted) {
            0 => self.reliable(1e-4 * self.size).max(1),
            reliable => reliable,
        }
    }

    /// The predictability horizon, seconds: where a perturbation has grown a thousandfold and to
    /// `wanted` metres, so that the scene is chaotic from there on; none if it does not.
    pub fn horizon(&self, wanted: f64) -> Option<f64> {
        let large = wanted.max(1e3 * PERTURBATION * self.size);
        let row = self.grown.iter().position(|&grown| large < grown)?;
        Some(self.frames[row] as f64 * FRAME)
    }
}

/// The reference of a scene, from the cache if it was made before with the same wish.
///
/// # Errors
/// See [`make_reference`].
pub fn reference(scene: &Scene, wish: Wish, monitor: &mut dyn Monitor) -> Result<Reference, Halt> {
    monitor.report(Progress::of(NOW));
    // The name of a scene and its looks do not matter.
    let mut plain = scene.clone();
    plain.bodies.iter_mut().for_each(|body| body.surface = Surface::default());
    let hash = cache::content_hash(&(&plain, wish));
    if let Some(reference) = cache::get("reference", &hash) {
        return Ok(reference);
    }
    let reference = make_reference(scene, wish, monitor)?;
    cache::put("reference", &hash, &reference);
    Ok(reference)
}

/// The size of a scene, metres: see [`msd_core::Model::size`].
///
/// # Errors
/// A scene that [`Simulation::new`] refuses.
pub fn size_of(scene: &Scene) -> Result<f64, Error> {
    Ok(Simulation::<f64>::new(scene, Settings::default())?.model().size())
}

/// The number of frames of a duration, at least 1.
pub fn frames_of(duration: f64) -> u64 {
    (duration / FRAME).round().max(1.0) as u64
}

/// The frames at which states of a duration are kept, ascending.
fn sample_frames(duration: f64) -> Vec<u64> {
    let total = frames_of(duration);
    let stride = total.div_ceil(MAX_SAMPLES);
    let mut frames: Vec<u64> = (1..=total / stride).map(|row| row * stride).collect();
    if frames.last() != Some(&total) {
        frames.push(total);
    }
    frames
}

/// Makes the reference of a scene: Dormand-Prince in double precision, its tolerance tightened
/// tenfold until that moves the particles by no more than the wish allows. Where shells meet it is
/// RK4 with twice the substeps each time.
///
/// # Errors
/// The errors of [`Simulation::new`], [`Simulation::step`] and [`Monitor::proceed`].
pub fn make_reference(
    scene: &Scene,
    wish: Wish,
    monitor: &mut dyn Monitor,
) -> Result<Reference, Halt> {
    let clock = CpuClock::start();
    let size = size_of(scene)?;
    let frames = sample_frames(wish.duration);
    if let Some(states) = in_closed_form(scene, &frames) {
        let moved = vec![0.0; frames.len()];
        let grown = vec![0.0; frames.len()];
        let seconds = clock.seconds();
        let (tolerance, substeps) = (0.0, 0);
        return Ok(Reference { frames, states, moved, grown, tolerance, substeps, size, seconds });
    }
    let wanted = wish.uncertainty * size;
    let mut runs = Runs { frames: &frames, run: 0, monitor };
    let (mut tolerance, mut states) = runs.first(scene)?;
    let mut moved = vec![f64::INFINITY; frames.len()];
    loop {
        let spent = clock.seconds();
        let worst = moved.iter().copied().fold(0.0, f64::max);
        // The next run takes about as long as all before it: tenfold is 1.6 times the substeps.
        let exhausted = worst.is_finite() && wish.patience < 2.0 * spent;
        if worst <= wanted || tolerance <= 1.5 * LAST_TOLERANCE || exhausted {
            break;
        }
        // Contact may put a tolerance out of reach: the tightest one that was reached is the best.
        let tighter = match runs.states(scene, 0.1 * tolerance) {
            Ok(tighter) => tighter,
            Err(halt @ (Halt::Cancelled | Halt::Deadline)) => return Err(halt),
            Err(Halt::Refused(_)) if worst.is_infinite() => {
                let looser = runs.states(scene, 10.0 * tolerance)?;
                let allowed = allowed(scene, 10.0 * tolerance, (size, &looser))?;
                moved = at_least(distances(&looser, &states), allowed);
                break;
            }
            Err(Halt::Refused(_)) => break,
        };
        tolerance *= 0.1;
        let allowed = allowed(scene, tolerance, (size, &tighter))?;
        moved = at_least(distances(&states, &tighter), allowed);
        states = tighter;
    }
    let choice = exact(scene, tolerance)?;
    let perturbed = runs.states_by(&perturb(scene, PERTURBATION * size), choice)?;
    let grown = distances(&states, &perturbed);
    let seconds = clock.seconds();
    let substeps = match choice.fineness {
        Fineness::Substeps(substeps) => substeps,
        Fineness::Tolerance(_) => 0,
    };
    Ok(Reference { frames, states, moved, grown, tolerance, substeps, size, seconds })
}

/// The runs of a reference, one after the other.
struct Runs<'a> {
    frames: &'a [u64],
    run: u32,
    monitor: &'a mut dyn Monitor,
}

impl Runs<'_> {
    /// The tightest of the first tolerances that is in reach, from 1e-6 up, and the states of its
    /// run.
    fn first(&mut self, scene: &Scene) -> Result<(f64, Vec<Sample>), Halt> {
        let mut last = Error::Empty;
        for tolerance in FIRST_TOLERANCES {
            match self.states(scene, tolerance) {
                Ok(states) => return Ok((tolerance, states)),
                Err(Halt::Refused(error)) => last = error,
                Err(halt) => return Err(halt),
            }
        }
        Err(Halt::Refused(last))
    }

    /// The states of one more run, of a tolerance.
    fn states(&mut self, scene: &Scene, tolerance: f64) -> Result<Vec<Sample>, Halt> {
        self.states_by(scene, exact(scene, tolerance)?)
    }

    /// The states of one more run.
    fn states_by(&mut self, scene: &Scene, choice: Choice) -> Result<Vec<Sample>, Halt> {
        self.run += 1;
        let (run, frames) = (self.run, self.frames);
        let end = frames.last().map_or(0.0, |&last| last as f64 * FRAME);
        let mut states = Vec::with_capacity(frames.len());
        let mut frame = 0;
        let proceed = &mut || {
            let [time, end] = [f64::from(frame) * FRAME, end].map(|time| rounded(time, 2));
            frame += 1;
            // One, one ten times as tight and a perturbed one.
            let least = run.max(3);
            let now = format!("{NOW}: run {run} of {least} at least, {time} s of {end} s");
            self.monitor.report(Progress::of(now));
            self.monitor.proceed()
        };
        let see = &mut |state| states.push(Sample::of(state));
        visit_frames(scene, (frames, choice), see, proceed)?;
        Ok(states)
    }
}

/// The current work, in words.
const NOW: &str = "making the reference";
/// Part of the longest stable substep that a reference of RK4 begins with.
const FIRST_PART: f64 = 0.25;

/// The run that a tolerance stands for.
pub(crate) fn exact(scene: &Scene, tolerance: f64) -> Result<Choice, Error> {
    let precision = Precision::F64;
    if !any_meet(&scene.shells) {
        let fineness = Fineness::Tolerance(tolerance);
        return Ok(Choice { integrator: Integrator::DormandPrince, fineness, precision });
    }
    let integrator = Integrator::Rk4;
    let settings = Settings { integrator, ..Settings::default() };
    let stable = Simulation::<f64>::new(scene, settings)?.stable_substep_of(integrator, 64);
    let tenths = (FIRST_TOLERANCES[0] / tolerance).log10().round();
    let substeps = FRAME / (FIRST_PART * stable) * tenths.exp2();
    let fineness = Fineness::Substeps(substeps.ceil().clamp(1.0, 1e6) as u32);
    Ok(Choice { integrator, fineness, precision })
}

/// Shows the states at some frames of a run in double precision; `proceed` is called before each
/// frame.
pub(crate) fn visit_frames(
    scene: &Scene,
    (frames, choice): (&[u64], Choice),
    see: &mut dyn FnMut(State<f64>),
    proceed: &mut dyn FnMut() -> Result<(), Halt>,
) -> Result<(), Halt> {
    let mut simulation = Simulation::<f64>::new(scene, choice.settings())?;
    for &frame in frames {
        while simulation.steps() < frame {
            proceed()?;
            simulation.step()?;
        }
        see(simulation.state());
    }
    Ok(())
}

/// The least uncertainty that a run of these states may claim, metres.
///
/// Shells that meet are located to a substep, sooner or later by chance: one doubling may move them
/// by far less than the next, but not by more than they go in two substeps.
fn allowed(scene: &Scene, tolerance: f64, (size, states): (f64, &[Sample])) -> Result<f64, Error> {
    if !any_meet(&scene.shells) {
        return Ok(tolerance * size);
    }
    let speeds = states.iter().flat_map(|sample| &sample.velocities).map(|v| v.length());
    let substep = exact(scene, tolerance)?.settings().substep();
    Ok(2.0 * substep * speeds.fold(0.0, f64::max))
}

/// Where both runs took one substep per frame nothing moves, and nothing is learnt: the tolerance
/// itself is the least that may be claimed.
fn at_least(distances: Vec<f64>, allowed: f64) -> Vec<f64> {
    distances.into_iter().map(|far| far.max(allowed)).collect()
}

fn distances(a: &[Sample], b: &[Sample]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| rms_distance(&a.state(), &b.state())).collect()
}

/// Moves every particle by `distance` metres, each in another direction.
fn perturb(scene: &Scene, distance: f64) -> Scene {
    use rand_pcg::rand_core::Rng;
    let mut scene = scene.clone();
    let mut random = rand_pcg::Pcg32::new(1, 1);
    let mut next = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    for particle in &mut scene.particles {
        let direction = DVec3::new(next(), next(), next()).normalize_or(DVec3::X);
        particle.position += direction * distance;
    }
    scene
}

/// Free fall: without springs, bends, volumes, obstacles, shells, drag and air each particle
/// follows its parabola.
fn in_closed_form(scene: &Scene, frames: &[u64]) -> Option<Vec<Sample>> {
    let is_joined =
        !scene.springs.is_empty() || !scene.bends.is_empty() || !scene.volumes.is_empty();
    let is_stopped = !scene.planes.is_empty() || !scene.solids.is_empty();
    let is_dragged = scene.world.drag != 0.0 || scene.world.air.is_some();
    if is_joined || is_stopped || any_meet(&scene.shells) || is_dragged {
        return None;
    }
    let start = Simulation::<f64>::new(scene, Settings::default()).ok()?.state();
    let mut accelerations: Vec<DVec3> = scene
        .particles
        .iter()
        .map(|particle| scene.world.gravity + scene.world.force / particle.mass)
        .collect();
    scene.pins.iter().for_each(|pin| accelerations[pin.particle] = DVec3::ZERO);
    let at = |&frame: &u64| {
        let time = frame as f64 * FRAME;
        let mut sample = Sample::of(start.clone());
        let rows = sample.positions.iter_mut().zip(&mut sample.velocities).zip(&accelerations);
        for ((position, velocity), &acceleration) in rows {
            *position += *velocity * time + acceleration * (0.5 * time * time);
            *velocity += acceleration * time;
        }
        sample
    };
    Some(frames.iter().map(at).collect())
}
