//! Planes: half spaces that particles cannot enter.

use super::{ContactLaw, Obstacle};
use crate::number::{Real, Vector};
use crate::pack::dot_terms;
use crate::scene::{Friction, Plane};

/// A plane as a step reads it: its normal has length one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneColumn<R: Real> {
    /// Direction out of the solid, length one.
    pub normal: R::Vec3,
    /// Signed distance from the origin, metres.
    pub offset: R,
    /// Restitution and friction.
    pub(crate) law: ContactLaw<R>,
    /// The friction as written, not rounded.
    pub(crate) friction: Friction,
}

impl<R: Real> PlaneColumn<R> {
    /// Takes over a row.
    pub(crate) fn new(plane: &Plane) -> Self {
        // Divided by its largest component first: the square of a tiny or huge normal would not
        // fit.
        let scaled = plane.normal / plane.normal.abs().max_element();
        let length = Real::sqrt(scaled.dot(scaled));
        PlaneColumn {
            normal: R::Vec3::of(scaled / length),
            offset: R::of(plane.offset),
            law: ContactLaw::new(plane.restitution, plane.friction),
            friction: plane.friction,
        }
    }

    /// The current row.
    pub(crate) fn row(&self) -> Plane {
        Plane {
            normal: self.normal.to_f64(),
            offset: self.offset.to_f64(),
            restitution: self.restitution(),
            friction: self.friction(),
        }
    }

    /// As [`Obstacle::terms`].
    #[inline(always)]
    pub(crate) fn terms_of(&self, position: [R; 3]) -> R {
        dot_terms(self.normal.components(), position)
    }

    /// Fraction of the normal speed returned, 0 to 1.
    pub fn restitution(&self) -> f64 {
        self.law.restitution.to_f64()
    }

    /// Friction along the plane.
    pub fn friction(&self) -> Friction {
        self.friction
    }
}

impl<R: Real> Obstacle<R> for PlaneColumn<R> {
    #[inline]
    fn gap(&self, position: R::Vec3, _: f64) -> R {
        self.normal.dot(position) - self.offset
    }

    #[inline]
    fn normal(&self, _: R::Vec3, _: f64) -> R::Vec3 {
        self.normal
    }

    #[inline(always)]
    fn terms(&self, position: R::Vec3, _: f64) -> R {
        self.terms_of(position.components())
    }

    fn law(&self) -> ContactLaw<R> {
        self.law
    }
}
