//! Fields: gravity, a uniform force and the drag of the air.

use super::{Derivatives, Element, Force, Motion, Products, Stage, Vectors};
use crate::columns::threads::{for_each_share, merge_shares};
use crate::columns::{Aligned, LANES, RECORD};
use crate::number::{Real, Vector, at_level};
use crate::pack::{Number, Pack, each};
use crate::scene::{Scene, World};
use fearless_simd::{Level, Simd};
use glam::DVec3;

/// The fields, which act on every particle.
#[derive(Clone, Debug)]
pub struct Fields<R: Real> {
    /// Gravitational acceleration, metres per second squared.
    pub(crate) gravity: R::Vec3,
    /// A uniform force on every particle, newtons.
    pub(crate) force: R::Vec3,
    /// Air drag, newton seconds per metre.
    pub(crate) drag: R,
    /// Gravity and uniform force on each particle, newtons.
    pub(crate) weights: Aligned<R>,
}

/// Gravity and a uniform force on a mass along an axis, newtons; 0 where there is no mass.
#[inline(always)]
pub(crate) fn weight<N: Number>(gravity: N, force: N, mass: N) -> N {
    let zero = mass.splat(N::Scalar::ZERO);
    // Plus zero: a sum that starts at minus zero would differ from one that starts at zero where
    // nothing pulls.
    N::select(zero.is_less(mass), gravity * mass + force + zero, zero)
}

/// The force on a particle along an axis, of its weight and the drag of the air, newtons.
#[inline(always)]
pub(crate) fn pull<N: Number>(weight: N, velocity: N, drag: N) -> N {
    weight - velocity * drag
}

impl<R: Real> Fields<R> {
    pub(crate) fn new(world: &World) -> Self {
        Fields {
            gravity: R::Vec3::of(world.gravity),
            force: R::Vec3::of(world.force),
            drag: R::of(world.drag),
            weights: Aligned::default(),
        }
    }

    /// Overwrites the weights from masses, a number for each slot.
    pub(crate) fn weigh(&mut self, masses: &[R]) {
        let (gravity, force) = (self.gravity.components(), self.force.components());
        let records = self.weights.as_chunks_mut::<RECORD>().0;
        for (weights, masses) in records.iter_mut().zip(masses.as_chunks::<LANES>().0) {
            for (lane, &mass) in masses.iter().enumerate() {
                for axis in 0..3 {
                    weights[axis * LANES + lane] = weight(gravity[axis], force[axis], mass);
                }
            }
        }
    }

    /// The weights of some particles of these masses, newtons.
    #[inline(always)]
    pub(crate) fn weights_of<S: Simd>(&self, simd: S, masses: Pack<S, R>) -> [Pack<S, R>; 3] {
        let (gravity, force) = (self.gravity.components(), self.force.components());
        let splat = |value| Pack::new(simd, value);
        each(|axis| weight(splat(gravity[axis]), splat(force[axis]), masses))
    }

    /// Overwrites forces with those of the fields, newtons, and returns the power of the drag,
    /// watts.
    pub(crate) fn set_forces(&self, level: Level, velocities: &[R], forces: &mut [R]) -> f64 {
        if self.drag == R::ZERO {
            for_each_share((forces, &*self.weights), |(forces, weights)| {
                forces.copy_from_slice(weights);
            });
            return 0.0;
        }
        let set = |share| set_share(level, self.drag, share);
        merge_shares((forces, (&*self.weights, velocities)), &set, &|low, high| low + high)
    }

    /// The energy in the fields, joules, −g·Σ m x − f·Σ x by these sums; zero at the origin.
    pub(crate) fn potential(&self, moments: [f64; 3], places: [f64; 3]) -> f64 {
        let [of_gravity, of_force] = [moments, places].map(DVec3::from_array);
        -self.gravity.to_f64().dot(of_gravity) - self.force.to_f64().dot(of_force)
    }
}

fn set_share<R: Real>(
    level: Level,
    drag: R,
    (forces, (weights, velocities)): (&mut [R], (&[R], &[R])),
) -> f64 {
    at_level!(level, _simd => set_dragged(weights, drag, velocities, forces))
}

#[inline(always)]
fn set_dragged<R: Real>(weights: &[R], drag: R, velocities: &[R], forces: &mut [R]) -> f64 {
    // Squares are summed over a particle's axes before they are widened: three times as fast.
    let mut squares = [0.0; LANES];
    let records = forces.as_chunks_mut::<RECORD>().0.iter_mut();
    let others = weights.as_chunks::<RECORD>().0.iter().zip(velocities.as_chunks::<RECORD>().0);
    for (forces, (weights, velocities)) in records.zip(others) {
        for number in 0..RECORD {
            forces[number] = pull(weights[number], velocities[number], drag);
        }
        for (lane, sum) in squares.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| velocities[axis * LANES + lane]);
            *sum += (x * x + y * y + z * z).to_f64();
        }
    }
    drag.to_f64() * squares.iter().sum::<f64>()
}

impl<R: Real> Element<R> for Fields<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let mut power = 0.0;
        for (at, (force, weight)) in forces.numbers.iter_mut().zip(&*self.weights).enumerate() {
            let velocity = motion.velocities[at];
            *force += pull(*weight, velocity, self.drag);
            power += (self.drag * (velocity * velocity)).to_f64();
        }
        power
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        let numbers = motion.positions.iter().zip(&*self.weights);
        numbers.map(|(position, weight)| -(position.to_f64() * weight.to_f64())).sum()
    }

    fn add_products(&self, _: &Motion<'_, R>, direction: &[DVec3], products: &mut Products<'_>) {
        let drag = self.drag.to_f64();
        for (product, direction) in products.damping.iter_mut().zip(direction) {
            *product += *direction * drag;
        }
    }
}

/// The fields start every sum of forces, by [`Fields::set_forces`].
impl<R: Real> Force<R> for Fields<R> {
    fn element(&self) -> Option<&dyn Element<R>> {
        Some(self)
    }

    fn count(&self) -> usize {
        1
    }

    fn is_damped(&self) -> bool {
        self.drag != R::ZERO
    }

    fn add_row_sums(&self, _: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        sums.iter_mut().for_each(|sum| sum[1] += self.drag.to_f64());
    }

    fn add_diagonals(&self, stage: &Stage<'_, R>, diagonals: &mut [R]) {
        let add = stage.tau * self.drag;
        diagonals.iter_mut().for_each(|diagonal| *diagonal += add);
    }

    fn write(&self, rows: &mut Scene) {
        let World { gravity, force, drag, .. } = &mut rows.world;
        (*gravity, *force) = (self.gravity.to_f64(), self.force.to_f64());
        *drag = self.drag.to_f64();
    }
}
