//! Grabs and pushes: user input that acts on single particles.

use super::{Derivatives, Element, Force, Motion, Products, Stage, Vectors};
use crate::columns::LANES;
use crate::number::{Real, Vector};
use crate::pack::{Number, dot, zip};
use alloc::vec::Vec;
use glam::DVec3;

/// A spring that holds a particle to a point in the world, such as the mouse pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grab<R: Real> {
    /// The particle held.
    pub particle: u32,
    /// The point that it is pulled to, metres.
    pub target: R::Vec3,
    /// Stiffness, newtons per metre.
    pub stiffness: R,
    /// Damping, newton seconds per metre.
    pub damping: R,
    /// The largest force, newtons.
    pub max_force: R,
}

/// The force of a grab before it is capped, newtons: k times the way to its target, less b v.
pub(crate) fn wish<N: Number>(
    way: [N; 3],
    velocity: [N; 3],
    [stiffness, damping]: [N; 2],
) -> [N; 3] {
    zip(way, velocity, |way, velocity| way * stiffness - velocity * damping)
}

/// A force, at most so strong, newtons.
pub(crate) fn capped<N: Number>(force: [N; 3], most: N) -> [N; 3] {
    let strength = dot(force, force).sqrt();
    let one = most.splat(N::Scalar::ONE);
    let scale = N::select(most.is_less(strength), most / strength, one);
    force.map(|force| force * scale)
}

impl<R: Real> Grab<R> {
    fn wish(&self, position: R::Vec3, velocity: R::Vec3) -> [R; 3] {
        let way = (self.target - position).components();
        wish(way, velocity.components(), [self.stiffness, self.damping])
    }

    /// The force on the particle, newtons.
    pub fn pull(&self, position: R::Vec3, velocity: R::Vec3) -> R::Vec3 {
        R::Vec3::from_components(capped(self.wish(position, velocity), self.max_force))
    }

    /// The energy stored, joules: k d² / 2, and from the largest force on that force times d.
    fn energy(&self, position: R::Vec3) -> f64 {
        let apart = (self.target - position).to_f64();
        let distance = Real::sqrt(apart.dot(apart));
        let (stiffness, most) = (self.stiffness.to_f64(), self.max_force.to_f64());
        let reach = distance.min(most / stiffness);
        0.5 * stiffness * reach * reach + (distance - reach) * most
    }

    /// Stiffness and damping at a motion: both 0 at the largest force, which is taken as constant.
    pub(crate) fn tangent(&self, position: R::Vec3, velocity: R::Vec3) -> [f64; 2] {
        let wish = self.wish(position, velocity);
        let is_free = dot(wish, wish) <= self.max_force * self.max_force;
        [self.stiffness, self.damping].map(|value| if is_free { value.to_f64() } else { 0.0 })
    }
}

/// The active grabs. The energy that they store and supply is the user's, and is in no
/// [`Energy`](crate::Energy).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grabs<R: Real>(pub(crate) Vec<Grab<R>>);

impl<R: Real> Element<R> for Grabs<R> {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        for grab in &self.0 {
            let particle = grab.particle as usize;
            let (position, velocity) = (motion.position(particle), motion.velocity(particle));
            forces.add(particle, grab.pull(position, velocity));
        }
        0.0
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        self.0.iter().map(|grab| grab.energy(motion.position(grab.particle as usize))).sum()
    }

    fn add_products(
        &self,
        motion: &Motion<'_, R>,
        direction: &[DVec3],
        products: &mut Products<'_>,
    ) {
        for grab in &self.0 {
            let particle = grab.particle as usize;
            let tangent = grab.tangent(motion.position(particle), motion.velocity(particle));
            products.add(particle, tangent.map(|value| direction[particle] * value));
        }
    }
}

/// Forces of one step on single particles, newtons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pushes<R: Real>(pub(crate) Vec<(u32, R::Vec3)>);

impl<R: Real> Element<R> for Pushes<R> {
    fn add_forces(&self, _: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        for &(particle, force) in &self.0 {
            forces.add(particle as usize, force);
        }
        0.0
    }

    fn energy(&self, motion: &Motion<'_, R>) -> f64 {
        let energy = |&(particle, force): &(u32, R::Vec3)| {
            -force.to_f64().dot(motion.position(particle as usize).to_f64())
        };
        self.0.iter().map(energy).sum()
    }

    fn add_products(&self, _: &Motion<'_, R>, _: &[DVec3], _: &mut Products<'_>) {}
}

impl<R: Real> Force<R> for Grabs<R> {
    fn element(&self) -> Option<&dyn Element<R>> {
        Some(self)
    }

    fn count(&self) -> usize {
        self.0.len()
    }

    /// In full also where the largest force caps it now.
    fn add_row_sums(&self, _: &Motion<'_, R>, _: &Derivatives, sums: &mut [[f64; 2]]) {
        for grab in &self.0 {
            let sum = &mut sums[grab.particle as usize];
            sum[0] += grab.stiffness.to_f64();
            sum[1] += grab.damping.to_f64();
        }
    }

    fn add_diagonals(&self, stage: &Stage<'_, R>, diagonals: &mut [R]) {
        let (tau, motion) = (stage.tau, &stage.moment.motion);
        for grab in &self.0 {
            let particle = grab.particle as usize;
            let tangent = grab.tangent(motion.position(particle), motion.velocity(particle));
            let [stiffness, damping] = tangent.map(R::of);
            let at = motion.slots.at(particle);
            for axis in 0..3 {
                diagonals[at + axis * LANES] += tau * (tau * stiffness + damping);
            }
        }
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool) {
        self.0.retain(|grab| !is_removed(grab.particle));
    }
}

impl<R: Real> Force<R> for Pushes<R> {
    fn element(&self) -> Option<&dyn Element<R>> {
        Some(self)
    }

    fn count(&self) -> usize {
        self.0.len()
    }

    fn is_damped(&self) -> bool {
        false
    }

    fn remove(&mut self, is_removed: &dyn Fn(u32) -> bool) {
        self.0.retain(|push| !is_removed(push.0));
    }
}
