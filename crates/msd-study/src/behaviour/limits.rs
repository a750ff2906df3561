//! Limits of stability, observed by bisection, beside the prediction.
//!
//! A scene is held in its start state: its springs, masses, pins and drag stay. Every force of that
//! state is balanced, so that only a disturbance of 1e-9 of the size of the scene moves. The
//! prediction is about the same state; contact and large stretch come later in a run and change
//! both. A run is some hundred substeps: about 2 million spring updates, but at least 200 substeps.
//! All methods together take a second of CPU time for a cloth of 31 x 31, and three for the bunny.
//! Beyond 10,000 springs they take longer in proportion.
//!
//! Explicit Euler is special: sideways motions of a stretched spring have no damper, and make it
//! grow, if slowly, at any step. The prediction, which looks at the fastest motions, need not know
//! them.

use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::DVec3;
use msd_core::methods::Method;
use msd_core::{Error, Integrator, Real, Scene, Settings, Simulation, State, Vector};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex};

/// The largest stable substep of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The method.
    pub integrator: Integrator,
    /// Predicted from the spectrum at the start, seconds; 0 where no substep is stable.
    pub predicted: f64,
    /// Longest substep that stayed bounded, found by bisection, seconds; 0 where no substep did.
    /// None where it was not looked for: explicit Euler with little or no damping blows up so
    /// slowly that no run of some hundred substeps shows it.
    pub observed: Option<f64>,
}

/// Spring updates of a run, and the fewest and the most substeps.
const WORK: usize = 2_000_000;
const SUBSTEPS: (usize, usize) = (200, 2000);
/// A disturbance, as a fraction of the size of the scene.
const DISTURBANCE: f64 = 1e-9;
/// A run has blown up where the second half is this much faster than the first; a beat of a stable
/// run does not last longer than a half.
const GROWTH: f64 = 1.5;
/// A run is over where it is this much faster than at its start.
const EXPLOSION: f64 = 1e4;
/// Bisection ends at this ratio of the bounds: the growth of a run does not resolve less.
const RESOLUTION: f64 = 1.0005;

/// Finds the largest stable substep of each explicit method, predicted and observed, for steps of
/// `substeps` substeps: damped Verlet knows less at the start of a step.
///
/// Empty for a scene in which nothing pulls: every substep is stable there.
///
/// # Errors
/// A scene or a number of substeps that a simulation refuses.
pub fn limits(scene: &Scene, substeps: u32) -> Result<Vec<Limit>, Error> {
    let held = Held::new(scene)?;
    let mut limits = Vec::new();
    for integrator in Integrator::EXPLICIT {
        let predicted = held.simulation.stable_substep_of(integrator, substeps);
        if predicted == f64::INFINITY {
            continue;
        }
        let mut stable = |h: f64| {
            let step = h * f64::from(substeps);
            held.stays(Settings { integrator, step, substeps, ..Settings::default() })
        };
        let observed = if held.shows(integrator, predicted) {
            Some(edge(predicted, &mut stable)?)
        } else {
            None
        };
        limits.push(Limit { integrator, predicted, observed });
    }
    Ok(limits)
}

/// Finds where `stable` turns false, by bisection around a guess; 0 where it is false even far
/// below, and a bound far above where it never turns.
///
/// # Errors
/// The error of `stable`.
pub fn edge(guess: f64, stable: &mut impl FnMut(f64) -> Result<bool, Error>) -> Result<f64, Error> {
    let (mut low, mut high) = (0.98 * guess, 1.02 * guess);
    if stable(low)? {
        while stable(high)? {
            (low, high) = (high, 2.0 * high);
            if 1e3 * guess < high {
                return Ok(low);
            }
        }
    } else {
        loop {
            (low, high) = (0.5 * low, low);
            if low < 1e-3 * guess {
                return Ok(0.0);
            }
            if stable(low)? {
                break;
            }
        }
    }
    while RESOLUTION * low < high {
        let middle = 0.5 * (low + high);
        if stable(middle)? { low = middle } else { high = middle }
    }
    Ok(low)
}

/// A scene held in its start state.
#[derive(Clone, Debug)]
pub struct Held {
    scene: Scene,
    /// The start state at rest, and a copy of it.
    pub simulation: Simulation<f64>,
    rest: State<f64>,
    /// The forces of that state, newtons.
    balance: Vec<DVec3>,
    /// Velocities with a part of every mode and more of the fastest, of length 1.
    disturbance: Vec<DVec3>,
}

impl Held {
    /// Holds a scene at rest, its obstacles left out.
    ///
    /// # Errors
    /// See [`Simulation::new`].
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let mut scene = Scene { planes: Vec::new(), solids: Vec::new(), ..scene.clone() };
        scene.particles.iter_mut().for_each(|particle| particle.velocity = DVec3::ZERO);
        scene.pins.iter_mut().for_each(|pin| pin.velocity = DVec3::ZERO);
        for spring in &mut scene.springs {
            let ends = spring.ends.map(|end| scene.particles.get(end));
            // A chain under pressure buckles, slowly and at any step: that is physics.
            if let [Some(a), Some(b)] = ends {
                spring.rest_length = spring.rest_length.min(a.position.distance(b.position));
            }
        }
        let simulation = Simulation::<f64>::new(&scene, Settings::default())?;
        let rest = simulation.state();
        let (balance, _) = simulation.forces();
        let disturbance = Vec::new();
        let mut held = Held { scene, simulation, rest, balance, disturbance };
        held.disturbance = held.disturb();
        Ok(held)
    }

    /// The unbalanced forces of a state, newtons.
    fn forces(&self, state: &State<f64>) -> Vec<DVec3> {
        let (mut forces, _) = self.simulation.forces_at(state);
        forces.iter_mut().zip(&self.balance).for_each(|(force, &balance)| *force -= balance);
        forces
    }

    /// The state disturbed, for substeps of `h` seconds.
    fn disturbed(&self, h: f64) -> State<f64> {
        let speed = DISTURBANCE * self.simulation.model().size() / h;
        let velocities = self.disturbance.iter().map(|&velocity| velocity * speed).collect();
        State { velocities, ..self.rest.clone() }
    }

    /// A random vector and, as long, the same vector after the stiffest modes have filtered it: a
    /// mode that blows up should not have to grow out of nothing first.
    fn disturb(&self) -> Vec<DVec3> {
        use rand_pcg::rand_core::Rng;
        let mut random = rand_pcg::Pcg32::new(1, 1);
        let mut next = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        let model = self.simulation.model();
        let inverse_masses = model.inverse_masses();
        let free = |w: f64| f64::from(u8::from(0.0 < w));
        let mut start: Vec<DVec3> =
            inverse_masses.iter().map(|&w| DVec3::new(next(), next(), next()) * free(w)).collect();
        normalise(&mut start);
        let mut fast = start.clone();
        let (size, mut state) = (1e-6 * model.size(), self.rest.clone());
        for _ in 0..30 {
            for ((x, &rest), &fast) in
                state.positions.iter_mut().zip(&self.rest.positions).zip(&fast)
            {
                *x = rest + fast * size;
            }
            let forces = self.forces(&state);
            let rows = fast.iter_mut().zip(&forces).zip(inverse_masses);
            rows.for_each(|((fast, &force), &w)| *fast = force * -w);
            normalise(&mut fast);
        }
        start.iter_mut().zip(&fast).for_each(|(start, &fast)| *start += fast);
        normalise(&mut start);
        start
    }

    /// Whether a disturbance stays bounded.
    pub fn stays(&self, settings: Settings) -> Result<bool, Error> {
        self.remains(Simulation::<f64>::new(&self.scene, settings)?)
    }

    /// Returns whether a disturbance stays bounded under a custom method.
    pub fn stays_under(
        &self,
        settings: Settings,
        method: impl Method<f32> + Method<f64> + 'static,
    ) -> Result<bool, Error> {
        let mut run = Simulation::<f64>::new(&self.scene, settings)?;
        run.set_method(method);
        self.remains(run)
    }

    fn remains(&self, mut run: Simulation<f64>) -> Result<bool, Error> {
        let settings = run.settings();
        run.set_state(&self.disturbed(settings.substep()), 0)?;
        let fastest = Arc::new(Mutex::new(0.0));
        run.add_element(Balance { forces: self.balance.clone(), fastest: Arc::clone(&fastest) });
        let steps = self.substeps().div_ceil(settings.substeps as usize);
        let step = |_| {
            run.step().ok()?;
            // Seen at every evaluation: the beat of a stable run, seen once in a step, can seem to
            // last for ever.
            fastest.lock().ok().map(|mut fastest| std::mem::take(&mut *fastest))
        };
        Ok(is_bounded((0..steps.max(2)).map(step), steps.max(2)))
    }

    /// Whether a run is long enough to see the growth of a method about a limit of `h` seconds.
    fn shows(&self, integrator: Integrator, h: f64) -> bool {
        // Explicit Euler grows by h² w² / 2 per substep, by `GROWTH` in half a run at `least`; the
        // others grow by the root of their excess over the limit.
        let fastest = self.simulation.fastest_mode().stiffness.sqrt();
        let least = (4.0 * GROWTH.ln() / self.substeps() as f64).sqrt() / fastest;
        integrator != Integrator::ExplicitEuler || 3.0 * least < h
    }

    fn substeps(&self) -> usize {
        (WORK / self.simulation.model().spring_count().max(1)).clamp(SUBSTEPS.0, SUBSTEPS.1)
    }
}

/// Forces that balance those of a start state, and the fastest motion that they have met.
#[derive(Debug)]
struct Balance {
    /// The balanced forces, newtons.
    forces: Vec<DVec3>,
    /// Root of the sum of squares of all speeds, metres per second.
    fastest: Arc<Mutex<f64>>,
}

impl<R: Real> Element<R> for Balance {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        for (particle, &force) in self.forces.iter().enumerate() {
            forces.add(particle, R::Vec3::of(-force));
        }
        if let Ok(mut fastest) = self.fastest.lock() {
            let squares = motion.velocities().map(|velocity| velocity.to_f64().length_squared());
            *fastest = f64::max(*fastest, squares.sum::<f64>().sqrt());
        }
        0.0
    }
}

/// Returns whether a run of `count` speeds does not grow; `None` is the speed of a run that
/// diverged.
fn is_bounded(speeds: impl Iterator<Item = Option<f64>>, count: usize) -> bool {
    let mut halves = [0.0f64; 2];
    let mut start = None;
    for (row, speed) in speeds.enumerate() {
        let Some(speed) = speed.filter(|speed| speed.is_finite()) else { return false };
        if EXPLOSION * *start.get_or_insert(speed) < speed {
            return false;
        }
        let half = &mut halves[usize::from(count <= 2 * row)];
        *half = half.max(speed);
    }
    halves[1] <= GROWTH * halves[0]
}

fn norm(vectors: &[DVec3]) -> f64 {
    vectors.iter().map(|vector| vector.length_squared()).sum::<f64>().sqrt()
}

fn normalise(vectors: &mut [DVec3]) {
    let length = norm(vectors);
    if 0.0 < length {
        vectors.iter_mut().for_each(|vector| *vector /= length);
    }
}
