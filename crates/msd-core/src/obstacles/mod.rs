//! Obstacles: solids that particles cannot enter.
//!
//! An obstacle knows the gap and the normal at a point, the velocity of its surface and the law of
//! contact there. `contact/` holds the response of a particle that meets it.

pub(crate) mod motion;
mod plane;
pub(crate) mod solid;

pub use plane::PlaneColumn;
pub use solid::Placed;

use crate::columns::extent::Extent;
use crate::number::{Real, Vector, of_type};
use crate::pack::{Pack, splat};
use crate::scene::{Friction, Solid};
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt::Debug;
use fearless_simd::Simd;
use glam::DVec3;

/// Restitution and friction of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactLaw<R> {
    /// Fraction of the normal speed that a bounce returns, 0 to 1.
    pub(crate) restitution: R,
    /// Coulomb's factor.
    pub(crate) friction: R,
    /// The fraction of the tangential velocity that each contact takes, 0 to 1.
    pub(crate) loss: R,
}

impl<R: Real> ContactLaw<R> {
    /// The law of a surface that returns a fraction of the normal speed, with some friction.
    pub fn new(restitution: f64, friction: Friction) -> Self {
        let (friction, loss) = match friction {
            Friction::Coulomb(factor) => (factor, 0.0),
            Friction::TangentialLoss(loss) => (0.0, loss),
        };
        ContactLaw { restitution: R::of(restitution), friction: R::of(friction), loss: R::of(loss) }
    }

    /// As many as a register holds.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S) -> ContactLaw<Pack<S, R>> {
        let numbers = [self.restitution, self.friction, self.loss];
        let [restitution, friction, loss] = splat(simd, numbers);
        ContactLaw { restitution, friction, loss }
    }
}

/// A solid that particles cannot enter.
///
/// ```
/// use msd_core::obstacles::Obstacle;
/// use msd_core::{Real, Vector};
///
/// /// A ball of 1 m about the origin, smooth and without bounce.
/// #[derive(Debug)]
/// struct Ball;
///
/// impl<R: Real> Obstacle<R> for Ball {
///     fn gap(&self, position: R::Vec3, _: f64) -> R {
///         Real::sqrt(position.dot(position)) - R::ONE
///     }
///     fn normal(&self, position: R::Vec3, _: f64) -> R::Vec3 {
///         position * (R::ONE / Real::sqrt(position.dot(position)))
///     }
/// }
/// ```
pub trait Obstacle<R: Real>: Debug + Send + Sync {
    /// The distance of a point from the surface at a time, metres; negative inside.
    fn gap(&self, position: R::Vec3, time: f64) -> R;

    /// The direction out of the solid at a point near its surface, length one.
    fn normal(&self, position: R::Vec3, time: f64) -> R::Vec3;

    /// The velocity of the surface near a point, metres per second. Default: it stands still.
    fn velocity(&self, position: R::Vec3, time: f64) -> R::Vec3 {
        let _ = (position, time);
        R::Vec3::ZERO
    }

    /// The sum of the lengths that the gap at a point is the difference of, metres.
    ///
    /// A particle lies on the surface if its gap is at most four roundings of this sum and its
    /// radius. Default: the sum of the coordinates; say more if the gap is computed from larger
    /// numbers.
    fn terms(&self, position: R::Vec3, time: f64) -> R {
        let _ = time;
        let [x, y, z] = position.components();
        x.abs() + y.abs() + z.abs()
    }

    /// Restitution and friction of the surface. Default: neither bounce nor friction.
    fn law(&self) -> ContactLaw<R> {
        ContactLaw::default()
    }
}

/// A user-defined obstacle, for either precision.
#[derive(Clone, Debug)]
pub(crate) struct OwnObstacle {
    single: Arc<dyn Obstacle<f32>>,
    double: Arc<dyn Obstacle<f64>>,
}

impl OwnObstacle {
    pub(crate) fn new<O: Obstacle<f32> + Obstacle<f64> + 'static>(obstacle: O) -> Self {
        let obstacle = Arc::new(obstacle);
        OwnObstacle { single: obstacle.clone(), double: obstacle }
    }

    pub(crate) fn of<R: Real>(&self) -> &dyn Obstacle<R> {
        &**of_type::<Arc<dyn Obstacle<R>>>(&self.single, &self.double)
    }
}

/// The obstacles of a model: its planes, its solids, then the user-defined ones.
#[derive(Clone, Debug)]
pub struct Obstacles<R: Real> {
    pub(crate) planes: Vec<PlaneColumn<R>>,
    pub(crate) solids: Vec<Solid>,
    /// Each with the handle it was given.
    pub(crate) own: Vec<(usize, OwnObstacle)>,
}

impl<R: Real> Obstacles<R> {
    /// The number of obstacles.
    pub fn count(&self) -> usize {
        self.planes.len() + self.solids.len() + self.own.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// Whether all stand still and are farther from a box than some distance, metres; user-defined
    /// ones are not known to.
    pub(crate) fn are_beyond(&self, around: Extent<R>, distance: R) -> bool {
        let (middle, half) = (around.middle(), (around.high() - around.low()) * R::HALF);
        let plane_is = |plane: &PlaneColumn<R>| {
            let each = plane.normal.components().into_iter().zip(half.components());
            let half = each.fold(R::ZERO, |sum, (part, half)| sum + part.abs() * half);
            distance + half < plane.gap(middle, 0.0)
        };
        let half = half.dot(half).sqrt();
        let solid_is = |solid: &Solid| {
            let stands = solid.keys.is_empty() && [solid.velocity, solid.spin] == [DVec3::ZERO; 2];
            stands && distance + half < Obstacle::<R>::gap(solid, middle, solid.since)
        };
        self.own.is_empty() && self.planes.iter().all(plane_is) && self.solids.iter().all(solid_is)
    }

    /// Whether one of them gives speed back.
    pub(crate) fn bounce(&self) -> bool {
        let planes = self.planes.iter().map(|plane| plane.law);
        planes.chain(self.curved().map(Obstacle::law)).any(|law| law.restitution != R::ZERO)
    }

    /// The obstacles that are not planes.
    pub(crate) fn curved(&self) -> impl Iterator<Item = &dyn Obstacle<R>> {
        let solids = self.solids.iter().map(|solid| solid as &dyn Obstacle<R>);
        solids.chain(self.own.iter().map(|(_, own)| own.of::<R>()))
    }

    /// An obstacle by its place among all.
    ///
    /// # Panics
    /// If there is no such obstacle.
    #[inline]
    pub fn get(&self, index: usize) -> &dyn Obstacle<R> {
        let Obstacles { planes, solids, own } = self;
        if let Some(plane) = planes.get(index) {
            return plane;
        }
        let index = index - planes.len();
        match solids.get(index) {
            Some(solid) => solid,
            None => own[index - solids.len()].1.of::<R>(),
        }
    }
}
