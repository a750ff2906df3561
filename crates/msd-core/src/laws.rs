//! The laws of a step of springs among planes, as functions over numbers.
//!
//! A law has no branches, so a [`Number`] may be one number, a register of numbers, or a symbol
//! that records each operation. Symbols turn a law into a program for another machine, which
//! computes the same bits. Vectors are three numbers; all units are SI.

pub use crate::elements::bends::pull as bend;
pub use crate::elements::springs::law::{Law, pull};
pub use crate::pack::Number;

use crate::contact::after_kick::{Drift, Kick};
use crate::contact::law::{Span, Touch, bounce, hold, is_inside, is_near, keeps, rounding};
use crate::contact::{Evaluated, law};
use crate::elements::{fields, grabs};
use crate::number::{Real, Vector};
use crate::obstacles::{ContactLaw, PlaneColumn};
use crate::pack::{dot, dot_terms, each, zip};

/// The sum of gravity, a uniform force and the drag of the air on a particle, newtons.
pub fn field<N: Number>([gravity, force]: [[N; 3]; 2], [mass, drag]: [N; 2], v: [N; 3]) -> [N; 3] {
    each(|axis| fields::pull(fields::weight(gravity[axis], force[axis], mass), v[axis], drag))
}

/// The force of a grab on a particle at a position and velocity, newtons. Stiffness, damping and
/// the largest force are those of [`crate::Grab`].
pub fn grab<N: Number>(
    [x, v]: [[N; 3]; 2],
    target: [N; 3],
    [stiffness, damping, most]: [N; 3],
) -> [N; 3] {
    let way = zip(target, x, |to, from| to - from);
    grabs::capped(grabs::wish(way, v, [stiffness, damping]), most)
}

/// The surface of a plane and its contact law.
#[derive(Clone, Copy, Debug)]
pub struct PlaneLaw<N> {
    /// Unit normal, out of the solid.
    pub normal: [N; 3],
    /// Signed distance from the origin, metres.
    pub offset: N,
    /// Fraction of the normal speed that a bounce returns.
    pub restitution: N,
    /// Coulomb's coefficient of friction.
    pub friction: N,
    /// Fraction of the tangential velocity that each contact takes.
    pub loss: N,
}

impl<R: Real> From<&PlaneColumn<R>> for PlaneLaw<R> {
    fn from(plane: &PlaneColumn<R>) -> Self {
        let ContactLaw { restitution, friction, loss } = plane.law;
        let normal = plane.normal.components();
        PlaneLaw { normal, offset: plane.offset, restitution, friction, loss }
    }
}

impl<N: Number> PlaneLaw<N> {
    fn contact(&self) -> ContactLaw<N> {
        ContactLaw { restitution: self.restitution, friction: self.friction, loss: self.loss }
    }

    /// Returns whether a point is on the surface or inside, up to rounding, and whether it is
    /// inside. If a method `holds` points on a surface after each kick, a point within rounding of
    /// the surface is not inside.
    pub fn is_near_and_inside(&self, x: [N; 3], holds: bool) -> [N::Mask; 2] {
        let gap = (dot(self.normal, x) - self.offset, dot_terms(self.normal, x));
        let radius = self.offset.zero();
        [is_near(gap, radius), is_inside(gap, radius, holds)]
    }

    /// Returns the velocity, along the plane, of a point on it after a kick by an acceleration,
    /// metres per second. Also returns whether the point lay on the plane and the kick presses it
    /// there.
    ///
    /// The durations of the kick and of the substep are in seconds. `loses` says whether the kick
    /// takes the tangential loss, which comes once in a substep.
    pub fn settle(
        &self,
        [velocity, acceleration]: [[N; 3]; 2],
        [length, substep]: [N; 2],
        loses: bool,
    ) -> ([N; 3], N::Mask) {
        let kick = Kick { length, substep, time: 0.0, loses, drift: Drift::Absent };
        let (law, still) = (kick.law(self.contact()), self.offset.zero());
        let settled = kick.settle(&law, self.normal, (velocity, acceleration), still);
        (settled.velocity, settled.lies)
    }

    /// Returns a point at the end of a substep of `h` seconds, after contact with the plane. The
    /// velocities of the method are `lag` seconds ahead of those that made the displacement.
    ///
    /// Unless `how` has `bounces`, the law of a bounce is left out.
    pub fn meet(&self, point: &Arrived<N>, [h, lag]: [N; 2], how: PlaneMeeting) -> AfterPlane<N> {
        let Arrived { position, velocity, start, pull, stiffness } = *point;
        let (contact, radius) = (self.contact(), self.offset.zero());
        let evaluated = if how.holds { Evaluated::AtEnd } else { Evaluated::AtStart };
        let span = Span { h, shift: lag - h.half(), evaluated, turn: radius };
        let touch = Touch {
            normal: self.normal,
            depth: law::depth(self.normal, self.offset, position) + radius,
            position,
            radius,
            noise: rounding(dot_terms(self.normal, position), radius),
            velocity,
            start,
            pull,
            before: pull,
            stiffness,
        };
        let inside = touch.is_inside(&span);
        let held = hold(&contact, &touch, &span);
        let choose = |yes, no| N::select(inside, yes, no);
        let mut met = AfterPlane {
            position: zip(held.position, position, choose),
            velocity: zip(held.velocity, velocity, choose),
            inside,
            keeps: inside,
        };
        if how.bounces {
            let (keeps, thrown) = (keeps(&contact, &touch, &span), bounce(&contact, &touch, &span));
            let of = |[held, thrown, free]: [[N; 3]; 3]| {
                each(|axis| choose(N::select(keeps, held[axis], thrown[axis]), free[axis]))
            };
            met.position = of([held.position, thrown.position, position]);
            met.velocity = of([held.velocity, thrown.velocity, velocity]);
            met.keeps = keeps;
        }
        met
    }
}

/// A point at the end of a substep.
#[derive(Clone, Copy, Debug)]
pub struct Arrived<N> {
    /// Metres.
    pub position: [N; 3],
    /// Metres per second.
    pub velocity: [N; 3],
    /// Its position at the start of the substep, metres.
    pub start: [N; 3],
    /// Its acceleration, metres per second squared.
    pub pull: [N; 3],
    /// Stiffness of all springs at the point divided by its mass, per second squared; only bounces
    /// read it.
    pub stiffness: N,
}

/// How points meet planes.
#[derive(Clone, Copy, Debug)]
pub struct PlaneMeeting {
    /// Whether the method holds points on a surface after each kick, and evaluates forces at the
    /// end of a substep.
    pub holds: bool,
    /// Whether planes may have a restitution.
    pub bounces: bool,
}

/// A point after a possible contact with a plane.
#[derive(Clone, Copy, Debug)]
pub struct AfterPlane<N: Number> {
    /// Metres.
    pub position: [N; 3],
    /// Metres per second.
    pub velocity: [N; 3],
    /// Whether it was inside; otherwise nothing has changed.
    pub inside: N::Mask,
    /// Whether the plane keeps a point inside; otherwise it bounces.
    pub keeps: N::Mask,
}
