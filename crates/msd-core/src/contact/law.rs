//! The law of contact: position and velocity of a particle that has met an obstacle.
//!
//! A substep ends somewhere inside the obstacle. There the surface gives an impulse P along its
//! normal and, by Coulomb's law, at most μ P along itself. The law is about the impulse *and* the
//! time at which it acts. A particle that met the surface τ seconds before the end of the substep
//! has gone on for τ seconds with a velocity that it did not have. So positions and velocities
//! change together, and neither how a particle rests nor how it slides or bounces depends on the
//! substep:
//!
//! * **held:** the particle is put on the surface, its speed into it is removed, and where friction
//!   holds it goes back to where it met the surface, so that nothing creeps;
//! * **bounce:** time and speed of the impact are those of a constant acceleration, which is exact
//!   under gravity, less the change that the springs at the particle have caused since: see
//!   [`Touch::impact`].
//!
//! Everything is as seen from the surface. [`super::after_kick`] holds particles that lie on it
//! already, under the methods that need that. Laws have no branches and compute with any
//! [`Number`].

use crate::number::{Real, Vector};
use crate::obstacles::ContactLaw;
use crate::pack::{Number, Pack, dot, splat};
use fearless_simd::Simd;

/// Coulomb's law: the fraction of a slip that is left by friction, which takes at most so much of
/// it, and the reciprocal of the slip, 0 where friction holds it.
#[inline(always)]
pub(crate) fn coulomb<N: Number>(slip: N, most: N) -> (N, N) {
    let (held, zero, one) = (slip.is_at_most(most), slip.zero(), slip.one());
    let per_slip = one / slip;
    let left = one - most * per_slip;
    (N::select(held, zero, left), N::select(held, zero, per_slip))
}

/// The velocity after a bounce that takes no time, metres per second.
///
/// Source: algorithm 1 of the source report (2014), with Coulomb's law beside its factor.
pub(crate) fn bounced<R: Real>(law: &ContactLaw<R>, normal: R::Vec3, velocity: R::Vec3) -> R::Vec3 {
    let speed = velocity.dot(normal);
    let along = velocity - normal * speed;
    let push = -speed * (R::ONE + law.restitution);
    let (kept, _) = rub(law, along.dot(along).sqrt(), push);
    normal * (speed + push) + along * kept
}

/// The fraction of a slip that friction leaves at a push, both in metres per second, and the
/// reciprocal of the slip, 0 where friction holds it.
#[inline(always)]
pub(crate) fn rub<N: Number>(law: &ContactLaw<N>, slip: N, push: N) -> (N, N) {
    let (left, per_slip) = coulomb(slip, law.friction * push);
    (left * (slip.one() - law.loss), per_slip)
}

/// Whether the surface keeps the particle for the rest of the substep.
///
/// It does where the restitution is 0, and where the particle is on its way out already. It also
/// does where the pull into the surface makes up the speed of the impact within two substeps. A
/// bounce would be over before it could be resolved, and a particle at rest would buzz.
#[inline(always)]
pub(crate) fn keeps<N: Number>(law: &ContactLaw<N>, touch: &Touch<N>, span: &Span<N>) -> N::Mask {
    let (speed, pull) = (touch.along_normal(touch.velocity), touch.along_normal(touch.pull));
    let ((real, squared), zero) = (touch.impact(span), speed.zero());
    let limit = (span.h + span.h) * pull;
    let is_slow = squared.is_less(limit * limit);
    let is_free = zero.is_at_most(speed) | zero.is_at_most(real);
    law.restitution.is_at_most(zero) | is_free | (pull.is_less(zero) & is_slow)
}

/// The outcome for a particle that the surface keeps.
///
/// The energy along the normal is that at the start of the substep, which is 0 at rest. Gains and
/// losses of a method within a substep, while a surface holds the particle, are undone.
#[inline(always)]
pub(crate) fn hold<N: Number>(law: &ContactLaw<N>, touch: &Touch<N>, span: &Span<N>) -> Outcome<N> {
    let (speed, pull) = (touch.along_normal(touch.velocity), touch.along_normal(touch.pull));
    let push = N::select(speed.is_less(speed.zero()), -speed, speed.zero());
    let (before, after) = (speed - pull * span.h, speed + push);
    let moved = touch.along_normal(touch.way()) + touch.depth;
    let taken = (before * before - after * after).half() + pull * moved + touch.eased();
    let push = Push { push, lift: touch.depth, reach: touch.depth, taken };
    finish(law, (touch, span), push)
}

/// The outcome for a particle that bounces.
///
/// The particle went through the surface at u, see [`Touch::impact`], 2 d / (U + u) seconds
/// before. It is put there and leaves at e u: with as much energy as at the impact for e = 1, a
/// part of a substep late. Letting it fly on would move it against its springs once more, which
/// adds energy to a stiff body.
pub(crate) fn bounce<N: Number>(
    law: &ContactLaw<N>,
    touch: &Touch<N>,
    span: &Span<N>,
) -> Outcome<N> {
    let (real, squared) = touch.impact(span);
    let impact = squared.max(squared.zero()).sqrt();
    let after = law.restitution * impact;
    let time = ((touch.depth + touch.depth) / (impact - real)).min(span.h);
    let mut push = after - real;
    if let Evaluated::AtStart = span.evaluated {
        // The next acceleration is that at the surface.
        push = push - (touch.strain(span) * span.h).half();
    }
    let taken = (impact * impact - after * after).half();
    let (lift, reach) = (touch.depth, push * time);
    finish(law, (touch, span), Push { push, lift, reach, taken })
}

/// Adds friction and returns the outcome.
///
/// A particle that sticks goes back by the part of its path since it met the surface. A particle
/// that slides goes back by the distance that it would not have gone at its current velocity.
#[inline(always)]
fn finish<N: Number>(
    law: &ContactLaw<N>,
    (touch, span): (&Touch<N>, &Span<N>),
    push: Push<N>,
) -> Outcome<N> {
    let (Touch { normal: n, velocity: v, pull, depth, .. }, moved) = (*touch, touch.way());
    let (speed, way) = (touch.along_normal(v), touch.along_normal(moved));
    let pressing = touch.along_normal(pull);
    let (zero, one) = (depth.zero(), depth.one());
    let along = [v[0] - n[0] * speed, v[1] - n[1] * speed, v[2] - n[2] * speed];
    let squared = dot(along, along);
    let (slip, grip) = (squared.sqrt(), law.friction * push.push);
    let (kept, per_slip) = rub(law, slip, push.push);
    let sticks = slip.is_at_most(grip) & zero.is_less(grip);
    // A gap within rounding counts as zero: small steps out of it would add up to a drift.
    let (gap, noise) = (-(way + depth), touch.noise);
    let since = N::select(gap.is_at_most(noise), one, depth / -way);
    let lift = N::select(gap.abs().is_at_most(noise), zero, push.lift + way);
    let slid = law.friction * push.reach * per_slip;
    let mut outcome = Outcome { position: touch.position, velocity: v, taken: zero };
    for axis in 0..3 {
        // From where it was: going back and forth would accumulate rounding.
        let before = (moved[axis] - n[axis] * way) * (one - since);
        let stuck = touch.start[axis] + (n[axis] * lift + before);
        let slides = touch.position[axis] + (n[axis] * push.lift - along[axis] * slid);
        outcome.position[axis] = N::select(sticks, stuck, slides);
        outcome.velocity[axis] = n[axis] * (speed + push.push) + along[axis] * kept;
    }
    let drive = dot(pull, v) - pressing * speed;
    let still = (dot(pull, pull) - pressing * pressing) * span.h - (drive + drive);
    let stuck =
        (squared + still * span.h).half() + (dot(pull, moved) - pressing * way) * (one - since);
    let slowed = (squared * (one - kept * kept)).half() - drive * slid;
    outcome.taken = push.taken + N::select(sticks, stuck, slowed);
    outcome
}

/// The gap up to which a particle of some radius lies on a surface, metres: four roundings of the
/// terms of its gap, see [`crate::obstacles::Obstacle::terms`].
#[inline(always)]
pub(crate) fn rounding<N: Number>(terms: N, radius: N) -> N {
    (terms + radius) * terms.splat(N::Scalar::EPSILON * N::Scalar::of(4.0))
}

/// Whether a particle of some radius is on a surface or inside, by the gap of its middle and the
/// terms of that.
#[inline(always)]
pub(crate) fn is_near<N: Number>((gap, terms): (N, N), radius: N) -> N::Mask {
    (-rounding(terms, radius)).is_at_most(radius - gap)
}

/// Whether it is inside; for a method that holds particles on a surface, by more than rounding.
#[inline(always)]
pub(crate) fn is_inside<N: Number>((gap, terms): (N, N), radius: N, holds: bool) -> N::Mask {
    let least = if holds { rounding(terms, radius) } else { gap.zero() };
    least.is_less(radius - gap)
}

/// Depth of a point inside a plane, metres.
#[inline(always)]
pub(crate) fn depth<N: Number>(normal: [N; 3], offset: N, x: [N; 3]) -> N {
    offset - dot(normal, x)
}

/// The speed towards a surface below which a contact rests, metres per second: the speed that
/// gravity adds in two substeps.
pub(crate) fn resting_speed<R: Real>(normal: R::Vec3, gravity: R::Vec3, h: R) -> R {
    (h + h) * gravity.dot(normal).abs()
}

/// A particle inside an obstacle at the end of a substep, as seen from the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch<R> {
    pub(crate) normal: [R; 3],
    /// Penetration, metres; positive.
    pub(crate) depth: R,
    pub(crate) position: [R; 3],
    /// Its radius, metres; 0 of a point.
    pub(crate) radius: R,
    /// The gap up to which it lies on the surface, metres.
    pub(crate) noise: R,
    pub(crate) velocity: [R; 3],
    /// Where it was at the start of the substep.
    pub(crate) start: [R; 3],
    /// Its acceleration without the surface, metres per second squared.
    pub(crate) pull: [R; 3],
    /// That at the start of the substep; the same where it is not known.
    pub(crate) before: [R; 3],
    /// Stiffness of all springs at it by its mass, per second squared.
    pub(crate) stiffness: R,
}

impl<N: Number> Touch<N> {
    /// Displacement in the substep, metres.
    #[inline(always)]
    pub(crate) fn way(&self) -> [N; 3] {
        let (to, from) = (self.position, self.start);
        [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
    }

    /// The speed along the normal at the end of the substep, −U, and the square of that at which it
    /// met the surface, metres per second.
    ///
    /// With a the acceleration into the surface, s the distance from it at which a was evaluated
    /// and κ the stiffness by mass along the normal, u² = U² − 2 a d − κ s². At the end of the
    /// substep the springs at a particle at the depth s = d have stored κ d²/2 of its energy. An
    /// acceleration of the start is by κ s too small, which comes to the same. All springs count as
    /// if they were along the normal and their other ends stood still. A bounce thus rather takes
    /// energy out of a stiff body than adds some; both fall with the square of the substep.
    #[inline(always)]
    pub(crate) fn impact(&self, span: &Span<N>) -> (N, N) {
        let pull = self.along_normal(self.pull);
        let real = self.along_normal(self.velocity) - span.shift * pull;
        let stored = self.strain(span) * self.distance(span);
        (real, real * real + (pull + pull) * self.depth - stored)
    }

    /// Energy by mass that the springs hold less at the surface than under a constant acceleration,
    /// joules per kilogram. With an acceleration that changes by a₁ − a₀ along the way w, all the
    /// way to the depth d, they push back by their compression there.
    #[inline(always)]
    pub(crate) fn eased(&self) -> N {
        let eased = self.along_normal(self.before) - self.along_normal(self.pull);
        let way = self.along_normal(self.way()).abs().max(self.depth);
        eased.half() * self.depth * self.depth / way
    }

    /// Distance from the surface at which the acceleration was evaluated, metres.
    #[inline(always)]
    fn distance(&self, span: &Span<N>) -> N {
        // Without a branch, as `is_inside`: sixteen are computed at once.
        let at_start = (self.along_normal(self.way()) + self.depth).abs();
        match span.evaluated {
            Evaluated::AtStart => at_start,
            Evaluated::AtEnd => self.depth,
            Evaluated::Solved | Evaluated::Nowhere => self.depth.zero(),
        }
    }

    /// The part by which the springs pull less at the surface than there, metres per second
    /// squared.
    #[inline(always)]
    fn strain(&self, span: &Span<N>) -> N {
        self.stiffness * self.distance(span)
    }

    /// Whether it is inside: a particle that lies may be so by rounding.
    #[inline(always)]
    pub(crate) fn is_inside(&self, span: &Span<N>) -> N::Mask {
        (if span.settles() { self.noise } else { self.noise.zero() }).is_less(self.depth)
    }

    #[inline(always)]
    fn along_normal(&self, vector: [N; 3]) -> N {
        dot(self.normal, vector)
    }
}

/// A substep, in seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span<R> {
    pub(crate) h: R,
    /// The time by which the velocities of the method are ahead of its positions.
    pub(crate) shift: R,
    /// Where the acceleration is from.
    pub(crate) evaluated: Evaluated,
    /// A way, metres, on which the surface turns by [`TURN`].
    pub(crate) turn: R,
}

/// The most that a surface may turn on the way of a particle in a substep, radians. A larger angle
/// pushes it to where it would not have slid, and a small ball parts a cloth without much work.
pub(crate) const TURN: f64 = 0.1;

impl<R: Real> Span<R> {
    /// As many as a register holds.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S) -> Span<Pack<S, R>> {
        let [h, shift, turn] = splat(simd, [self.h, self.shift, self.turn]);
        Span { h, shift, evaluated: self.evaluated, turn }
    }
}

impl<R> Span<R> {
    /// Whether the method holds particles that lie on an obstacle.
    #[inline(always)]
    pub(crate) fn settles(&self) -> bool {
        self.evaluated.settles()
    }
}

/// Where in a substep the forces of springs were evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Evaluated {
    /// At the positions of its start.
    AtStart,
    /// At those of its end, by a method that holds particles on an obstacle by
    /// [`super::after_kick`].
    AtEnd,
    /// At those of a stage, by a method that solves for the particles on an obstacle.
    Solved,
    /// Nowhere: the method projects.
    Nowhere,
}

impl Evaluated {
    /// As of [`Span::settles`].
    #[inline(always)]
    pub(crate) fn settles(self) -> bool {
        matches!(self, Evaluated::AtEnd | Evaluated::Solved)
    }
}

/// The push of a surface along its normal.
struct Push<R> {
    /// Impulse by mass, metres per second.
    push: R,
    /// Distance by which the particle is moved, metres.
    lift: R,
    /// Impulse by mass times the time that it has acted, metres.
    reach: R,
    /// Energy dissipated per mass, joules per kilogram.
    taken: R,
}

/// A particle after contact.
pub(crate) struct Outcome<R> {
    pub(crate) position: [R; 3],
    pub(crate) velocity: [R; 3],
    /// Energy dissipated per mass, joules per kilogram.
    pub(crate) taken: R,
}

/// The effect of obstacles.
///
/// The energy is that of the motion as seen from the surface: energy that a moving surface drives
/// in is separate. The force on a particle is taken as constant over a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contacts {
    /// Particles stopped, once for each obstacle and substep.
    pub count: u64,
    /// Energy dissipated by contacts that lost some, joules.
    pub taken: f64,
    /// Energy added by contacts that added some, joules: an error, which a shorter substep lowers.
    pub added: f64,
    /// Work of surfaces that move, joules.
    pub driven: f64,
    /// Whether a particle was between obstacles that left it no room, since the run was opened: its
    /// energy means nothing then. Not seen by Dormand-Prince, which meets them one by one.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub squeezed: bool,
    /// Whether one of them gave speed back; of a single substep.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) bounced: bool,
    /// Whether a surface turned by too much on the way of one, or moved by more than half of the
    /// thickness of its solid, in a substep.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) turned: bool,
}

impl Contacts {
    /// One contact that dissipated this much energy, joules.
    pub(crate) fn one(taken: f64) -> Self {
        let (taken, added) = (taken.max(0.0), (-taken).max(0.0));
        Contacts { count: 1, taken, added, ..Contacts::default() }
    }
}

impl core::ops::Add for Contacts {
    type Output = Contacts;

    fn add(mut self, other: Contacts) -> Contacts {
        self += other;
        self
    }
}

impl core::ops::AddAssign for Contacts {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.taken += other.taken;
        self.added += other.added;
        self.driven += other.driven;
        self.bounced |= other.bounced;
        self.turned |= other.turned;
        self.squeezed |= other.squeezed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::lanes::{Law, check};

    struct Arriving;

    impl Law<27, 45> for Arriving {
        fn of<N: Number>(numbers: [N; 27]) -> [N; 45] {
            let [normal, position, start, velocity, pull, before] =
                [0, 3, 6, 9, 12, 15].map(|at| [numbers[at], numbers[at + 1], numbers[at + 2]]);
            let [depth, noise, stiffness, h, restitution, friction, loss] =
                [18, 19, 20, 21, 22, 23, 24].map(|at| numbers[at].abs());
            let (radius, [shift, turn]) = (depth.zero(), [numbers[25], numbers[26]]);
            let law = ContactLaw { restitution, friction, loss };
            let touch = Touch {
                normal,
                depth,
                position,
                radius,
                noise,
                velocity,
                start,
                pull,
                before,
                stiffness,
            };
            let mut all = [depth; 45];
            let moments = [Evaluated::AtStart, Evaluated::AtEnd, Evaluated::Solved];
            for (evaluated, all) in moments.into_iter().zip(all.as_chunks_mut::<15>().0) {
                let span = Span { h, shift, evaluated, turn };
                let outcomes = [hold(&law, &touch, &span), bounce(&law, &touch, &span)];
                for (outcome, all) in outcomes.iter().zip(all.as_chunks_mut::<7>().0) {
                    all[..3].copy_from_slice(&outcome.position);
                    all[3..6].copy_from_slice(&outcome.velocity);
                    all[6] = outcome.taken;
                }
                all[14] = N::select(keeps(&law, &touch, &span), depth.one(), depth.zero());
            }
            all
        }
    }

    #[test]
    fn particles_that_arrive_together_have_the_bits_of_each() {
        check::<Arriving, 27, 45>();
    }
}
