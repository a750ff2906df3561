//! The promise of tuning, kept over generated scenes: its error, and its cost beside the best
//! setting that an exhaustive search finds.

use msd_core::glam::{DQuat, DVec3};
use msd_core::{Error, Friction, Material, Pin, Plane, Scene, shape};
use msd_scene::{FileError, open_bytes};
use msd_study::choice::{Choice, Fineness};
use msd_study::ladder::ladders;
use msd_study::monitor::Halt;
use msd_study::reference::{Reference, Wish, frames_of, make_reference, size_of};
use msd_study::trial::{time_choice, try_choice};
use msd_study::tune::{Goal, tune};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// Time of the processor that a reference, or a trial of the search, may take, seconds: of hundreds
/// of scenes the hardest would take hours.
const PATIENCE: f64 = 2.0;

/// One scene, tuned and searched.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The error asked for, metres.
    pub asked: f64,
    /// The error delivered, against a separate reference, metres.
    pub delivered: f64,
    /// The choice of tuning; none if it reported that no choice meets the wish.
    pub chosen: Option<Choice>,
    /// The cheapest choice that an exhaustive search found within the error; none if none is.
    pub best: Option<Choice>,
    /// Cost of the choice over cost of the best, timed in turn.
    pub cost_ratio: f64,
}

impl Case {
    /// Returns whether the error delivered is within the wish; where tuning reported that no choice
    /// meets the wish, whether that is so.
    pub fn kept(&self) -> bool {
        match self.chosen {
            Some(_) => self.delivered <= self.asked,
            None => self.best.is_none(),
        }
    }

    /// Returns whether it cost at most 1.5 times the best.
    pub fn is_cheap(&self) -> bool {
        match (self.chosen, self.best) {
            (Some(_), _) => self.cost_ratio <= 1.5,
            (None, best) => best.is_none(),
        }
    }
}

/// Tunes a scene for an error of `fraction` of its size, and searches all choices beside it.
///
/// # Errors
/// A scene that the core refuses.
pub fn keep(scene: &Scene, duration: f64, fraction: f64) -> Result<Case, Halt> {
    let size = size_of(scene)?;
    let asked = fraction * size;
    let tuned = tune(scene, duration, Goal::MaxError(asked), &mut ())?;
    let right = independent(scene, duration, tuned.reference_tolerance)?;
    let reliable = right.reliable(0.25 * asked).max(1);
    let best = search(scene, (&right, reliable), asked)?;
    let chosen = tuned.met.then_some(tuned.best.trial.choice);
    // A choice that the search of fewer steps passed by may be the best all the same.
    let best = best.or(chosen);
    let delivered = match chosen {
        Some(choice) => try_choice(scene, choice, (&right, reliable), &mut ())?.error(),
        None => f64::INFINITY,
    };
    let cost_ratio = match (chosen, best) {
        (Some(chosen), Some(best)) if chosen != best => {
            compare_costs(scene, duration, chosen, best)?
        }
        _ => 1.0,
    };
    Ok(Case { asked, delivered, chosen, best, cost_ratio })
}

/// A reference that is not that of tuning, whose errors it would share: a hundred times as tight,
/// where that is in reach.
fn independent(scene: &Scene, duration: f64, tolerance: f64) -> Result<Reference, Halt> {
    let mut wish = Wish { duration, patience: PATIENCE, ..Wish::default() };
    loop {
        let right = make_reference(scene, wish, &mut ())?;
        if right.tolerance <= 0.011 * tolerance || wish.uncertainty < 1e-12 {
            return Ok(right);
        }
        wish.uncertainty *= 0.01;
    }
}

/// The cheapest sound choice within an error, of every method and precision. Each substep count is
/// a fifth more than the one before it, as long as it costs at most 1.3 times the best so far.
fn search(
    scene: &Scene,
    (right, reliable): (&Reference, usize),
    asked: f64,
) -> Result<Option<Choice>, Halt> {
    let mut best: Option<(f64, Choice)> = None;
    let frames = right.frames.last().copied().unwrap_or(1);
    let mut ladders = ladders(scene)?;
    // The method that always arrives comes first: it bounds the cost of the others.
    ladders.sort_by_key(|ladder| !ladder.integrator.is_adaptive());
    for ladder in ladders {
        for fineness in finenesses(ladder.fewest, ladder.integrator.is_adaptive()) {
            let choice = ladder.choice(fineness);
            if matches!(fineness, Fineness::Tolerance(t) if t < right.least_tolerance()) {
                break;
            }
            let Ok(trial) = try_choice(scene, choice, (right, reliable), &mut ()) else { break };
            let cheapest = best.map_or(f64::INFINITY, |(cost, _)| cost);
            let took = trial.cost * right.duration();
            // Dormand-Prince is a choice too: a run that takes longer than the reference cannot be
            // the best.
            let longest = right.seconds.min(PATIENCE);
            if trial.errors.is_some() && (1.3 * cheapest < trial.cost || longest < took) {
                break;
            }
            if trial.is_within(asked) {
                let again = (0..3).map(|_| time_choice(scene, choice, frames, &mut ()));
                let cost = again.flatten().fold(trial.cost, f64::min);
                if cost < cheapest {
                    best = Some((cost, choice));
                }
                break;
            }
        }
    }
    Ok(best.map(|(_, choice)| choice))
}

fn finenesses(fewest: Option<u32>, adaptive: bool) -> Vec<Fineness> {
    if adaptive {
        return (2..24)
            .map(|half| Fineness::Tolerance(10f64.powf(-0.5 * f64::from(half))))
            .collect();
    }
    let Some(fewest) = fewest else { return Vec::new() };
    let mut all = vec![fewest];
    while let Some(&last) = all.last().filter(|&&last| last < 20_000) {
        all.push((last + 1).max((1.2 * f64::from(last)).round() as u32));
    }
    all.into_iter().map(Fineness::Substeps).collect()
}

/// The cost of one choice over that of another, the best of runs in turn.
fn compare_costs(scene: &Scene, duration: f64, a: Choice, b: Choice) -> Result<f64, Halt> {
    let frames = frames_of(duration);
    let (mut best_a, mut best_b) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..7 {
        best_a = best_a.min(time_choice(scene, a, frames, &mut ())?);
        best_b = best_b.min(time_choice(scene, b, frames, &mut ())?);
    }
    Ok(best_a / best_b)
}

/// A random lattice: a rope, cloth or block with stiffness over six decades, with and without
/// dampers, pins, and a plane that it falls on.
///
/// # Errors
/// None that is known: every number is inside its domain.
pub fn random_scene(seed: u64) -> Result<Scene, Error> {
    let mut random = Pcg64::new(seed.into(), 7);
    let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let spacing = 10f64.powf(-1.5 * unit());
    let stiffness = 10f64.powf(1.0 + 6.0 * unit());
    let mass = 10f64.powf(-2.0 * unit());
    let ratio = if unit() < 0.25 { 0.0 } else { 0.3 * unit() };
    let damping = 2.0 * ratio * (stiffness * mass).sqrt();
    let material = Material { mass, stiffness, damping };
    let mut upto = |low: usize, high: usize| low + ((high - low) as f64 * unit()) as usize;
    let mut part = match upto(0, 3) {
        0 => shape::rope(upto(3, 30), spacing, material)?,
        1 => shape::cloth([upto(3, 12), upto(3, 12)], spacing, material)?,
        _ => shape::block([upto(2, 6), upto(2, 6), upto(2, 6)], spacing, material)?,
    };
    let axis = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5).normalize_or(DVec3::X);
    let turn = DQuat::from_axis_angle(axis, 3.0 * unit());
    let velocity = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * 2.0;
    part.particles.iter_mut().for_each(|p| p.position = turn * p.position);
    part.set_motion(velocity, axis * unit());
    let lowest = part.particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
    let mut scene = Scene::of("random", part);
    if unit() < 0.5 {
        let friction = Friction::Coulomb(unit());
        let offset = lowest - 0.2 * unit();
        let restitution = unit();
        scene.planes = vec![Plane { normal: DVec3::Y, offset, restitution, friction }];
    } else {
        scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    }
    Ok(scene)
}

/// Two bodies that meet, with friction. A jelly is set on another, slid over a wider one, or
/// dropped on a cloth that hangs by its corners, or two collide in flight.
///
/// # Errors
/// None that is known: every number is inside its domain.
pub fn touching_scene(seed: u64) -> Result<Scene, FileError> {
    let mut random = Pcg64::new(seed.into(), 11);
    let mut between = |low: f64, high: f64| {
        low + (high - low) * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    };
    let [aside, gap, speed, softer] =
        [(-0.01, 0.01), (0.002, 0.02), (0.3, 1.5), (2e4, 6e4)].map(|(a, b)| between(a, b));
    let [slippery, rough] = [0.1, 0.4].map(|least| between(least, 2.0 * least));
    let jelly = |size: [usize; 3], place: [f64; 3], speed: f64| {
        format!(
            "[[bodies]]\nkind = \"block\"\nsize = {size:?}\nspacing = 0.02\nyoung = {softer}\n\
             density = 1000\nrelaxation_time = 0.001\nposition = {place:?}\n\
             velocity = [{speed}, 0, 0]\ntouch = {{ friction = {rough} }}\n"
        )
    };
    let cloth = format!(
        "[[bodies]]\nname = \"cloth\"\nkind = \"cloth\"\nsize = [10, 10]\nspacing = 0.03\n\
         area_density = 0.3\nyoung_warp = 60\nyoung_weft = 60\nshear = 20\nbending = 1e-4\n\
         relaxation_time = 0.002\nposition = [0, 0.2, 0]\n\
         rotation = {{ axis = [1, 0, 0], angle_deg = 90 }}\ntouch = {{ friction = {slippery} }}\n\
         [[pins]]\nbody = \"cloth\"\nset = \"corners\"\n"
    );
    let floor = "[[world.planes]]\nfriction = 0.5\n";
    let bodies = match seed % 4 {
        0 => [jelly([4; 3], [0.0, 0.03, 0.0], 0.0), jelly([4; 3], [aside, 0.094 + gap, 0.0], 0.0)],
        1 => [jelly([3; 3], [-0.1, 0.0, 0.0], speed), jelly([4; 3], [0.1, aside, 0.0], -speed)],
        2 => [cloth, jelly([3; 3], [aside, 0.23 + gap, 0.0], 0.0)],
        _ => {
            let place = [aside, 0.046 + gap, 0.0];
            [jelly([2, 6, 6], [0.0, 0.01, 0.0], 0.0), jelly([3; 3], place, 0.4 * speed)]
        }
    };
    let floor = if seed % 4 == 1 { "" } else { floor };
    let text = format!("version = 1\n{floor}{}", bodies.concat());
    Ok(open_bytes("touching.toml", text.as_bytes())?.scene)
}
