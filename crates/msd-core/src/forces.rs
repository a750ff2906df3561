//! What pulls at each particle?
//!
//! Springs are summed by either algorithm of the source report, with the same bits: over the
//! springs (each evaluated once, [`add_spring_forces`]) or over the particles (each spring
//! evaluated from both ends, [`add_spring_forces_by_particle`]).

use crate::real::{Real, Vector};
use crate::system::{Column, Grab, Model, Motion};
use alloc::vec;
use alloc::vec::Vec;

/// Overwrites `forces` with gravity, the uniform force, drag, pushes and grabs, newtons.
///
/// Returns the power that drag takes away, watts.
pub fn set_external_forces<R: Real>(
    model: &Model<R>,
    motion: Motion<'_, R>,
    forces: &mut [R::Vec3],
) -> f64 {
    for (force, &mass) in forces.iter_mut().zip(&model.masses) {
        *force = model.gravity * mass + model.force;
    }
    for &(particle, push) in &model.pushes {
        forces[particle as usize] += push;
    }
    for grab in &model.grabs {
        let particle = grab.particle as usize;
        let (position, velocity) = (motion.positions[particle], motion.velocities[particle]);
        forces[particle] += grab_pull(grab, position, velocity);
    }
    if model.drag == R::ZERO { 0.0 } else { add_drag(model.drag, motion.velocities, forces) }
}

/// The force of a grab on its particle, newtons.
pub(crate) fn grab_pull<R: Real>(grab: &Grab<R>, position: R::Vec3, velocity: R::Vec3) -> R::Vec3 {
    let pull = (grab.target - position) * grab.stiffness - velocity * grab.damping;
    let strength = pull.dot(pull).sqrt();
    let scale = if grab.max_force < strength { grab.max_force / strength } else { R::ONE };
    pull * scale
}

fn add_drag<R: Real>(drag: R, velocities: &[R::Vec3], forces: &mut [R::Vec3]) -> f64 {
    let mut power = 0.0;
    for (force, &velocity) in forces.iter_mut().zip(velocities) {
        *force -= velocity * drag;
        power += (drag * velocity.dot(velocity)).to_f64();
    }
    power
}

/// Adds the pull of every spring to `forces`, newtons, each spring evaluated once.
///
/// With d the vector from `a` to `b` and u its direction, f = (k (|d| − rest) + b u·(v_b − v_a)) u
/// is added to `a` and taken from `b`. A spring whose ends coincide has no direction and is
/// skipped. Returns the power that the dampers take away, watts.
///
/// Source: algorithm 3 of the source report (2014).
pub fn add_spring_forces<R: Real>(
    model: &Model<R>,
    motion: Motion<'_, R>,
    forces: &mut [R::Vec3],
) -> f64 {
    use Column::{Each, Same};
    // Chosen once per call, so that each loop reads only the columns its scene needs.
    match (&model.stiffnesses, &model.dampings) {
        (Same(k), Same(b)) if *b == R::ZERO => scatter(model, (*k, Undamped), motion, forces),
        (Each(k), Same(b)) if *b == R::ZERO => scatter(model, (&k[..], Undamped), motion, forces),
        (Same(k), Same(b)) => scatter(model, (*k, *b), motion, forces),
        (Same(k), Each(b)) => scatter(model, (*k, &b[..]), motion, forces),
        (Each(k), Same(b)) => scatter(model, (&k[..], *b), motion, forces),
        (Each(k), Each(b)) => scatter(model, (&k[..], &b[..]), motion, forces),
    }
}

/// A column as a loop reads it.
trait Values<R>: Copy {
    /// Whether the loop needs the term at all.
    const USED: bool = true;
    fn at(self, spring: usize) -> R;
}

/// The damping of a system without dampers.
#[derive(Clone, Copy)]
struct Undamped;

impl<R: Real> Values<R> for Undamped {
    const USED: bool = false;
    #[inline(always)]
    fn at(self, _: usize) -> R {
        R::ZERO
    }
}

impl<R: Real> Values<R> for R {
    #[inline(always)]
    fn at(self, _: usize) -> R {
        self
    }
}

impl<R: Real> Values<R> for &[R] {
    #[inline(always)]
    fn at(self, spring: usize) -> R {
        self[spring]
    }
}

#[inline(always)]
fn scatter<R: Real, K: Values<R>, B: Values<R>>(
    model: &Model<R>,
    (stiffnesses, dampings): (K, B),
    motion: Motion<'_, R>,
    forces: &mut [R::Vec3],
) -> f64 {
    // Columns cut to one length let the compiler check each end once instead of three times.
    let count = model.particle_count();
    let (positions, velocities) = (&motion.positions[..count], &motion.velocities[..count]);
    let motion = Motion { positions, velocities };
    let forces = &mut forces[..count];
    let mut power = 0.0;
    let rows = model.ends.chunks(CHUNK).zip(model.rest_lengths.chunks(CHUNK));
    for (chunk, (ends, rests)) in rows.enumerate() {
        let mut burnt = R::ZERO;
        for (row, (&[a, b], &rest)) in ends.iter().zip(rests).enumerate() {
            let (a, b, spring) = (a as usize, b as usize, chunk * CHUNK + row);
            let damper = if B::USED { Some(dampings.at(spring)) } else { None };
            let law = (rest, stiffnesses.at(spring));
            let Some((pull, rate_power)) = pull(motion, (a, b), law, damper) else { continue };
            forces[a] += pull;
            forces[b] -= pull;
            burnt += rate_power;
        }
        power += burnt.to_f64();
    }
    power
}

/// Springs whose power is summed in the precision of the run before it joins the sum in `f64`: few
/// enough to lose at most four bits, enough to make the conversion free.
const CHUNK: usize = 32;

/// The force on `a` of a spring from `a` to `b`, newtons, and the power of its damper, watts.
#[inline(always)]
fn pull<R: Real>(
    motion: Motion<'_, R>,
    (a, b): (usize, usize),
    (rest, stiffness): (R, R),
    damping: Option<R>,
) -> Option<(R::Vec3, R)> {
    let across = motion.positions[b] - motion.positions[a];
    let squared = across.dot(across);
    if squared < R::SHORTEST_SQUARED {
        return None;
    }
    let length = squared.sqrt();
    let per_length = R::ONE / length;
    let tension = stiffness * (length - rest);
    let Some(damping) = damping else {
        return Some((across * (tension * per_length), R::ZERO));
    };
    let rate = across.dot(motion.velocities[b] - motion.velocities[a]) * per_length;
    let drag = damping * rate;
    Some((across * ((tension + drag) * per_length), drag * rate))
}

/// Measures the power that the dampers take away at a motion, watts: Σ b (u·(v_b − v_a))².
pub fn damper_power<R: Real>(model: &Model<R>, motion: Motion<'_, R>) -> f64 {
    if model.dampings.is_zero() {
        return 0.0;
    }
    let mut power = 0.0;
    for (spring, &[a, b]) in model.ends.iter().enumerate() {
        let (a, b) = (a as usize, b as usize);
        let across = motion.positions[b] - motion.positions[a];
        let squared = across.dot(across);
        if squared < R::SHORTEST_SQUARED {
            continue;
        }
        let along = across.dot(motion.velocities[b] - motion.velocities[a]);
        power += (model.dampings.get(spring) * (along * along / squared)).to_f64();
    }
    power
}

/// The springs at each particle: what the sum over particles walks along.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// The first row of each particle, and the number of rows at the end.
    starts: Vec<u32>,
    /// Spring and the particle at its other end, by particle and then by spring.
    rows: Vec<[u32; 2]>,
}

impl Incidence {
    /// Lists the springs at each particle by counting sort.
    pub fn new<R: Real>(model: &Model<R>) -> Self {
        let mut starts = vec![0u32; model.particle_count() + 1];
        for &end in model.ends.iter().flatten() {
            starts[end as usize + 1] += 1;
        }
        for particle in 0..model.particle_count() {
            starts[particle + 1] += starts[particle];
        }
        let mut next = starts.clone();
        let mut rows = vec![[0; 2]; 2 * model.spring_count()];
        for (spring, &[a, b]) in model.ends.iter().enumerate() {
            for (here, there) in [(a, b), (b, a)] {
                rows[next[here as usize] as usize] = [spring as u32, there];
                next[here as usize] += 1;
            }
        }
        Incidence { starts, rows }
    }

    /// Spring and other end of each row of a particle.
    pub fn of(&self, particle: usize) -> &[[u32; 2]] {
        &self.rows[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}

/// Adds the pull of every spring to `forces`, newtons, each spring evaluated from both ends.
///
/// The same numbers in the same order per particle as [`add_spring_forces`], hence the same bits;
/// no two particles write to the same row. Source: algorithm 2 of the source report (2014).
pub fn add_spring_forces_by_particle<R: Real>(
    model: &Model<R>,
    incidence: &Incidence,
    motion: Motion<'_, R>,
    forces: &mut [R::Vec3],
) {
    let damped = !model.dampings.is_zero();
    for (particle, force) in forces.iter_mut().enumerate() {
        for &[spring, other] in incidence.of(particle) {
            let spring = spring as usize;
            let rest_and_stiffness = (model.rest_lengths[spring], model.stiffnesses.get(spring));
            let damping = damped.then(|| model.dampings.get(spring));
            let ends = (particle, other as usize);
            if let Some((pull, _)) = pull(motion, ends, rest_and_stiffness, damping) {
                *force += pull;
            }
        }
    }
}
