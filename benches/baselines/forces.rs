//! The forces of the simple kernel: plain loops over columns, by either algorithm of the source
//! report, with the same bits.

#![allow(dead_code, reason = "each benchmark uses some of it")]

use msd::core::{Real, Scene, Vector};

/// A value per spring, stored once if all springs share it.
#[derive(Clone)]
enum Column<R> {
    Same(R),
    Each(Vec<R>),
}

impl<R: Real> Column<R> {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<R> = values.map(R::of).collect();
        let first = values.first().copied().unwrap_or(R::ZERO);
        if values.iter().all(|&value| value == first) {
            Column::Same(first)
        } else {
            Column::Each(values)
        }
    }
}

/// The forces on particles.
#[derive(Clone)]
pub struct Forces<R: Real> {
    masses: Vec<R>,
    gravity: R::Vec3,
    force: R::Vec3,
    drag: R,
    ends: Vec<[u32; 2]>,
    rest_lengths: Vec<R>,
    stiffnesses: Column<R>,
    dampings: Column<R>,
}

/// Positions and velocities at which forces are wanted, one row per particle.
#[derive(Clone, Copy)]
pub struct Motion<'a, R: Real> {
    pub positions: &'a [R::Vec3],
    pub velocities: &'a [R::Vec3],
}

impl<R: Real> Forces<R> {
    /// Turns the rows of a scene into columns.
    pub fn new(scene: &Scene) -> Self {
        let springs = || scene.springs.iter();
        Forces {
            masses: scene.particles.iter().map(|particle| R::of(particle.mass)).collect(),
            gravity: R::Vec3::of(scene.world.gravity),
            force: R::Vec3::of(scene.world.force),
            drag: R::of(scene.world.drag),
            ends: springs().map(|spring| spring.ends.map(|end| end as u32)).collect(),
            rest_lengths: springs().map(|spring| R::of(spring.rest_length)).collect(),
            stiffnesses: Column::of(springs().map(|spring| spring.stiffness)),
            dampings: Column::of(springs().map(|spring| spring.damping)),
        }
    }

    /// Whether a force depends on velocity.
    pub fn is_damped(&self) -> bool {
        self.has_dampers() || self.drag != R::ZERO
    }

    fn has_dampers(&self) -> bool {
        !matches!(self.dampings, Column::Same(damping) if damping == R::ZERO)
    }

    /// Overwrites `forces` with gravity, the uniform force and drag, newtons; returns the power
    /// that drag dissipates, watts.
    pub fn set_external(&self, motion: Motion<'_, R>, forces: &mut [R::Vec3]) -> f64 {
        for (force, &mass) in forces.iter_mut().zip(&self.masses) {
            *force = self.gravity * mass + self.force;
        }
        let mut power = 0.0;
        if self.drag != R::ZERO {
            for (force, &velocity) in forces.iter_mut().zip(motion.velocities) {
                *force -= velocity * self.drag;
                power += (self.drag * velocity.dot(velocity)).to_f64();
            }
        }
        power
    }

    /// Adds the pull of every spring to `forces`, newtons, each spring evaluated once; returns the
    /// power that the dampers dissipate, watts. Algorithm 3 of the source report (2014).
    pub fn add_springs(&self, motion: Motion<'_, R>, forces: &mut [R::Vec3]) -> f64 {
        use Column::{Each, Same};
        // Chosen once per call, so that each loop reads only the columns its scene needs.
        match (&self.stiffnesses, &self.dampings) {
            (Same(k), Same(b)) if *b == R::ZERO => self.scatter((*k, Undamped), motion, forces),
            (Each(k), Same(b)) if *b == R::ZERO => self.scatter((&k[..], Undamped), motion, forces),
            (Same(k), Same(b)) => self.scatter((*k, *b), motion, forces),
            (Same(k), Each(b)) => self.scatter((*k, &b[..]), motion, forces),
            (Each(k), Same(b)) => self.scatter((&k[..], *b), motion, forces),
            (Each(k), Each(b)) => self.scatter((&k[..], &b[..]), motion, forces),
        }
    }

    #[inline(always)]
    fn scatter<K: Values<R>, B: Values<R>>(
        &self,
        (stiffnesses, dampings): (K, B),
        motion: Motion<'_, R>,
        forces: &mut [R::Vec3],
    ) -> f64 {
        // Columns cut to one length let the compiler check each end once instead of three times.
        let count = self.masses.len();
        let (positions, velocities) = (&motion.positions[..count], &motion.velocities[..count]);
        let motion = Motion { positions, velocities };
        let forces = &mut forces[..count];
        let mut power = 0.0;
        let rows = self.ends.chunks(CHUNK).zip(self.rest_lengths.chunks(CHUNK));
        for (chunk, (ends, rests)) in rows.enumerate() {
            let mut burnt = R::ZERO;
            for (row, (&[a, b], &rest)) in ends.iter().zip(rests).enumerate() {
                let (a, b, spring) = (a as usize, b as usize, chunk * CHUNK + row);
                let damper = if B::USED { Some(dampings.at(spring)) } else { None };
                let law = (rest, stiffnesses.at(spring), damper);
                let Some((pull, rate_power)) = pull(motion, (a, b), law) else { continue };
                forces[a] += pull;
                forces[b] -= pull;
                burnt += rate_power;
            }
            power += burnt.to_f64();
        }
        power
    }

    /// Adds the pull of every spring to `forces`, newtons, each spring evaluated from both ends.
    /// Algorithm 2 of the source report (2014).
    pub fn add_springs_by_particle(
        &self,
        incidence: &Incidence,
        motion: Motion<'_, R>,
        forces: &mut [R::Vec3],
    ) {
        let at = |column: &Column<R>, spring: usize| match column {
            Column::Same(value) => *value,
            Column::Each(values) => values[spring],
        };
        let damped = self.has_dampers();
        for (particle, force) in forces.iter_mut().enumerate() {
            for &[spring, other] in incidence.of(particle) {
                let spring = spring as usize;
                let damper = damped.then(|| at(&self.dampings, spring));
                let law = (self.rest_lengths[spring], at(&self.stiffnesses, spring), damper);
                if let Some((pull, _)) = pull(motion, (particle, other as usize), law) {
                    *force += pull;
                }
            }
        }
    }
}

/// Springs whose power is summed in the precision of the run before it joins the sum in `f64`.
const CHUNK: usize = 32;

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

/// The force on `a` of a spring from `a` to `b`, newtons, and the power of its damper, watts.
#[inline(always)]
fn pull<R: Real>(
    motion: Motion<'_, R>,
    (a, b): (usize, usize),
    (rest, stiffness, damping): (R, R, Option<R>),
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

/// The springs at each particle: what the sum over particles walks along.
pub struct Incidence {
    /// The first row of each particle, and the number of rows at the end.
    starts: Vec<u32>,
    /// Spring and the particle at its other end, by particle and then by spring.
    rows: Vec<[u32; 2]>,
}

impl Incidence {
    /// Lists the springs at each particle by counting sort.
    pub fn new<R: Real>(Forces { masses, ends, .. }: &Forces<R>) -> Self {
        let mut starts = vec![0u32; masses.len() + 1];
        for &end in ends.iter().flatten() {
            starts[end as usize + 1] += 1;
        }
        for particle in 0..masses.len() {
            starts[particle + 1] += starts[particle];
        }
        let mut next = starts.clone();
        let mut rows = vec![[0; 2]; 2 * ends.len()];
        for (spring, &[a, b]) in ends.iter().enumerate() {
            for (here, there) in [(a, b), (b, a)] {
                rows[next[here as usize] as usize] = [spring as u32, there];
                next[here as usize] += 1;
            }
        }
        Incidence { starts, rows }
    }

    fn of(&self, particle: usize) -> &[[u32; 2]] {
        &self.rows[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}
