//! The effective stiffness and damping of a method: a weight is hung up, a string is plucked.
//!
//! The probe is a chain of the scene's own material, pinned at its top. Everything on it is known
//! in closed form: it hangs by Σ m g / k, and its lowest mode has the frequency w = 2 √(k/m) sin(π
//! / (4 n + 2)) and the damping ratio ζ = b w / (2 k). Along a line springs are linear, so neither
//! answer depends on how heavy the weight is or how hard the pluck. The runs are in double
//! precision: rounding is not the question here.

use crate::candidates::choice::{Choice, FRAME};
use msd_core::glam::DVec3;
use msd_core::{
    Error, Integrator, Part, Particle, Pin, Scene, Settings, Simulation, Spring, World,
};
use serde::{Deserialize, Serialize};

/// Behaviour of a spring under a choice, relative to the exact one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// The choice.
    pub choice: Choice,
    /// Measured stiffness over that of the springs.
    pub stiffness: f64,
    /// Measured damping ratio over the exact one. Where the exact one is below [`LEAST_DAMPING`],
    /// added damping counts in units of that instead, so that the number stays finite.
    pub damping: f64,
    /// Measured damping ratio less the exact one; negative where the method adds energy.
    pub added_damping: f64,
    /// Measured period over the exact one, less 1.
    pub period: f64,
}

/// The damping ratio below which damping is reported in units of it: a string of this ratio swings
/// 110 times before it has lost half its amplitude, and nobody sees less.
pub const LEAST_DAMPING: f64 = 1e-3;
/// The most links of a probe.
const MAX_LINKS: f64 = 20.0;
/// The largest damping ratio of a probe: a string that creeps back has no period.
const MOST_DAMPING: f64 = 0.5;
/// Strain of the most loaded link.
const STRAIN: f64 = 0.1;
/// Samples of a pluck, about a radian apart.
const SAMPLES: usize = 24;
/// Mean square that one mode may leave unexplained, as a fraction of that of the samples.
const ONE_MODE: f64 = 1e-3;
/// The most substeps between two looks at a run.
const PATIENCE: f64 = 20_000.0;

/// A chain that stands for a scene, pinned at its top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Number of links, and of particles that move.
    pub links: usize,
    /// Mass of each particle, kilograms.
    pub mass: f64,
    /// Length of each link without force, metres.
    pub length: f64,
    /// Stiffness of each link, newtons per metre.
    pub stiffness: f64,
    /// Damping of each link, newton seconds per metre.
    pub damping: f64,
}

impl Probe {
    /// The chain of a scene: its median mass, rest length, stiffness and damping. It has as many
    /// links as the largest body is springs long, but at most 20, and a damping ratio of at most
    /// 0.5. None for a scene in which no spring pulls or nothing moves.
    ///
    /// # Errors
    /// A scene that a simulation refuses.
    pub fn of(scene: &Scene) -> Result<Option<Probe>, Error> {
        let simulation = Simulation::<f64>::new(scene, Settings::default())?;
        let model = simulation.model();
        let stiff = || scene.springs.iter().filter(|spring| 0.0 < spring.stiffness);
        let length = median(stiff().map(|spring| spring.rest_length).filter(|&l| 0.0 < l));
        let free = (0..model.particle_count()).filter(|&particle| !model.is_pinned(particle));
        let mass = median(free.map(|particle| model.masses()[particle]));
        let stiffness = median(stiff().map(|spring| spring.stiffness));
        let damping = median(stiff().map(|spring| spring.damping));
        let (Some(mass), Some(stiffness), Some(damping)) = (mass, stiffness, damping) else {
            return Ok(None);
        };
        let length = length.unwrap_or(model.size());
        let links = (model.size() / length).round().clamp(1.0, MAX_LINKS) as usize;
        let probe = Probe { links, mass, length, stiffness, damping };
        let most = 2.0 * MOST_DAMPING * stiffness / probe.frequency();
        Ok(Some(Probe { damping: damping.min(most), ..probe }))
    }

    /// Angular frequency of the slowest mode without damping, radians per second.
    pub fn frequency(&self) -> f64 {
        2.0 * (self.stiffness / self.mass).sqrt() * (0.5 * self.phase()).sin()
    }

    /// Damping ratio of the slowest mode.
    pub fn damping_ratio(&self) -> f64 {
        0.5 * self.damping * self.frequency() / self.stiffness
    }

    /// Phase from one particle to the next in the slowest mode.
    fn phase(&self) -> f64 {
        std::f64::consts::PI / (2 * self.links + 1) as f64
    }

    /// The chain, each particle moved down by `down` of its number from the top, metres.
    fn scene(&self, world: World, down: impl Fn(usize) -> f64) -> Scene {
        let particle = |row: usize| Particle {
            position: DVec3::NEG_Y * (row as f64 * self.length + down(row)),
            velocity: DVec3::ZERO,
            mass: self.mass,
        };
        let spring = |row: usize| Spring {
            ends: [row, row + 1],
            rest_length: self.length,
            stiffness: self.stiffness,
            damping: self.damping,
        };
        let part = Part {
            particles: (0..=self.links).map(particle).collect(),
            springs: (0..self.links).map(spring).collect(),
            ..Part::default()
        };
        let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
        Scene { world, pins, ..Scene::of("probe", part) }
    }

    /// Hangs the chain under its own weight until it rests; returns the stiffness that follows from
    /// its length, over that of its springs; none if it does not stay in the world.
    fn hang(&self, choice: Choice) -> Option<f64> {
        let (count, settings) = (self.links as f64, choice.settings());
        let gravity = STRAIN * self.length * self.stiffness / (count * self.mass);
        let unit = self.mass * gravity / self.stiffness;
        // The links above particle n carry count, count − 1, ... weights.
        let down = |row: usize| unit * row as f64 * (count - 0.5 * (row as f64 - 1.0));
        let w = self.frequency();
        // Drag settles the chain and does nothing to it at rest. Not too much: it may be explicit.
        let drag = self.mass * (2.0 * w).min(0.5 / settings.substep());
        let world = World { gravity: DVec3::NEG_Y * gravity, drag, ..World::default() };
        let mut run = Simulation::<f64>::new(&self.scene(world, down), settings).ok()?;
        let projected = choice.integrator == Integrator::Xpbd;
        // A sweep carries a load over a link or over all of them; diffusion takes the square.
        let least = if projected { count * count } else { 1.0 };
        let substeps = f64::from(settings.substeps);
        let look = (substeps / (w * FRAME)).max(least).min(PATIENCE) / substeps;
        let (exact, mut before, mut calm) = (down(self.links), f64::NAN, 0);
        for _ in 0..60 {
            for _ in 0..look.ceil() as usize {
                run.step().ok()?;
            }
            let now = -run.position(self.links).y - count * self.length;
            calm = if (now - before).abs() <= 1e-7 * exact { calm + 1 } else { 0 };
            before = now;
            if calm == 2 {
                break;
            }
        }
        Some(exact / before)
    }

    /// Plucks the slowest mode; returns its damping ratio and its angular frequency, none if it
    /// does not stay in the world or does not swing as one mode.
    fn pluck(&self, choice: Choice) -> Option<[f64; 2]> {
        let shape = |row: usize| (row as f64 * self.phase()).sin();
        let world = World { gravity: DVec3::ZERO, ..World::default() };
        let size = STRAIN * self.length / self.phase();
        let scene = self.scene(world, |row| size * shape(row));
        let (settings, steps) = sampling(choice, self.frequency());
        let mut run = Simulation::<f64>::new(&scene, settings).ok()?;
        let mode = |run: &Simulation<f64>| -> f64 {
            let rows = run.positions().enumerate();
            rows.map(|(row, at)| (-at.y - row as f64 * self.length) * shape(row)).sum()
        };
        let mut samples = vec![mode(&run)];
        for _ in 0..SAMPLES {
            for _ in 0..steps {
                run.step().ok()?;
            }
            samples.push(mode(&run));
        }
        oscillation(&samples, settings.step * steps as f64)
    }
}

/// Settings for a choice, and steps from one sample to the next, so that samples are about a radian
/// of `frequency` apart. A frame that is short enough is not divided.
fn sampling(choice: Choice, frequency: f64) -> (Settings, usize) {
    let settings = choice.settings();
    let frames = (1.0 / (frequency * FRAME)).round();
    if 1.0 <= frames {
        let most = (PATIENCE / f64::from(settings.substeps)).max(1.0);
        return (settings, frames.min(most) as usize);
    }
    if choice.integrator.is_adaptive() {
        return (Settings { step: 1.0 / frequency, ..settings }, 1);
    }
    let h = settings.substep();
    let substeps = (1.0 / (frequency * h)).round().max(1.0);
    (Settings { step: h * substeps, substeps: substeps as u32, ..settings }, 1)
}

/// Damping ratio and angular frequency of a decaying oscillation sampled every `interval` seconds.
///
/// Samples of one mode follow q₂ = p q₁ − r q₀, and the roots of z² = p z − r are its factors per
/// sample: the log decrement and the phase, without waiting for a zero to be crossed, which under
/// heavy damping happens once. Least squares over all samples (Prony, 1795). None where the samples
/// are not those of one mode: another one is growing.
fn oscillation(samples: &[f64], interval: f64) -> Option<[f64; 2]> {
    let sum = |a: usize, b: usize| -> f64 {
        samples.windows(3).map(|window| window[a] * window[b]).sum()
    };
    let determinant = sum(1, 1) * sum(0, 0) - sum(0, 1) * sum(0, 1);
    let p = (sum(1, 2) * sum(0, 0) - sum(0, 1) * sum(0, 2)) / determinant;
    let r = (sum(0, 1) * sum(1, 2) - sum(1, 1) * sum(0, 2)) / determinant;
    let off = |window: &[f64]| (window[2] - p * window[1] + r * window[0]).powi(2);
    let left = samples.windows(3).map(off).sum::<f64>() / sum(2, 2);
    // Not `ONE_MODE < left`: a NaN is not a mode either.
    let found = if left <= ONE_MODE { roots([p, r], interval) } else { [f64::NAN; 2] };
    found.iter().all(|number| number.is_finite()).then_some(found)
}

/// Damping ratio and angular frequency of the roots of z² = p z − r per `interval` seconds.
fn roots([p, r]: [f64; 2], interval: f64) -> [f64; 2] {
    let discriminant = 0.25 * p * p - r;
    let swing = |factor: f64, phase: f64| {
        let decay = -factor.ln();
        [decay / decay.hypot(phase), phase / interval]
    };
    if discriminant < 0.0 {
        return swing(r.sqrt(), (0.5 * p / r.sqrt()).acos());
    }
    let far = 0.5 * p + discriminant.sqrt().copysign(p);
    if far < 0.0 {
        // It changes sign at every sample.
        return swing(-far, std::f64::consts::PI);
    }
    // It creeps back: only the frequency without damping is left.
    let rates = [far, r / far].map(|root| -root.abs().ln());
    let natural = (rates[0] * rates[1]).abs().sqrt();
    [0.5 * (rates[0] + rates[1]) / natural, natural / interval]
}

/// Audits a choice on a probe; none if the probe blows up.
pub fn audit(probe: &Probe, choice: Choice) -> Option<Audit> {
    let stiffness = probe.hang(choice)?;
    let [measured, frequency] = probe.pluck(choice)?;
    let exact = probe.damping_ratio();
    let added_damping = measured - exact;
    let damping = 1.0 + added_damping / exact.max(LEAST_DAMPING);
    let period = probe.frequency() * (1.0 - exact * exact).sqrt() / frequency - 1.0;
    let audit = Audit { choice, stiffness, damping, added_damping, period };
    [stiffness, damping, period].iter().all(|number| number.is_finite()).then_some(audit)
}

/// Audits choices on the probe of a scene; those whose probe blows up are left out, and all
/// of them in a scene without springs.
///
/// # Errors
/// A scene that a simulation refuses.
pub fn audit_all(scene: &Scene, choices: &[Choice]) -> Result<Vec<Audit>, Error> {
    let probe = Probe::of(scene)?;
    let audits = choices.iter().filter_map(|&choice| audit(probe.as_ref()?, choice));
    Ok(audits.collect())
}

/// The middle of some numbers; none of none.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
