//! The law of contact: where a particle that has come to an obstacle goes, and how fast.
//!
//! A substep ends somewhere inside the obstacle. What the surface gives in it is an impulse P along
//! its normal and, by Coulomb, at most μ P along itself. The law is about the impulse *and* the time
//! at which it acts: a particle that met the surface τ seconds before the end of the substep has
//! gone on for τ seconds with a velocity that it did not have. So positions and velocities change
//! together, and neither how a particle rests nor how it slides or bounces depends on the substep:
//!
//! * **held:** the particle is put on the surface, its speed into it is taken away, and what friction
//!   holds goes back to where it was when it met the surface, so that nothing creeps;
//! * **bounce:** time and speed of the impact are those of a constant acceleration, which is exact
//!   under gravity.
//!
//! Everything is as seen from the surface.

use super::{Obstacle, Obstacles, PlaneColumn};
use crate::columns::threads::{Split, merge_shares};
use crate::columns::{LANES, RECORD, single};
use crate::number::{Real, Vector, at_level};
use crate::scene::Friction;
use fearless_simd::Level;

/// How a surface gives back and slows what touches it.
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

    /// The velocity after a bounce that takes no time, metres per second.
    ///
    /// Source: algorithm 1 of the source report (2014), with Coulomb's law beside its factor.
    pub(crate) fn bounced(&self, normal: R::Vec3, velocity: R::Vec3) -> R::Vec3 {
        let speed = velocity.dot(normal);
        let along = velocity - normal * speed;
        let push = -speed * (R::ONE + self.restitution);
        let (kept, _) = self.rub(along.dot(along).sqrt(), push);
        normal * (speed + push) + along * kept
    }

    /// The fraction of a slip that is left where the surface pushes by so much, both metres per
    /// second, and the reciprocal of the slip, 0 where friction holds it.
    #[inline(always)]
    fn rub(&self, slip: R, push: R) -> (R, R) {
        let loss = self.friction * push;
        let held = slip <= loss;
        let per_slip = R::ONE / slip;
        let left = if held { R::ZERO } else { R::ONE - loss * per_slip };
        (left * (R::ONE - self.loss), if held { R::ZERO } else { per_slip })
    }

    /// Whether the surface keeps the particle for the rest of the substep.
    ///
    /// It does where it gives nothing back, and where the particle is on its way out already. It
    /// does as well where the pull into the surface makes up the speed of the impact within two
    /// substeps: a bounce would be over before it could be followed, and what rests would buzz.
    #[inline(always)]
    fn keeps(&self, touch: &Touch<R>, span: &Span<R>) -> bool {
        let (speed, pull) = (touch.along_normal(touch.velocity), touch.along_normal(touch.pull));
        let real = speed - span.shift * pull;
        let limit = (span.h + span.h) * pull;
        let is_slow = real * real + (pull + pull) * touch.depth < limit * limit;
        let is_free = (R::ZERO <= speed) | (R::ZERO <= real);
        (self.restitution == R::ZERO) | is_free | ((pull < R::ZERO) & is_slow)
    }

    /// What a surface makes of a particle that it keeps.
    ///
    /// The energy along the normal is that at the start of the substep, which is none at rest: what
    /// a method gains or loses within a substep while a surface holds the particle is undone.
    #[inline(always)]
    fn hold(&self, touch: &Touch<R>, span: &Span<R>) -> Outcome<R> {
        let (speed, pull) = (touch.along_normal(touch.velocity), touch.along_normal(touch.pull));
        let push = if speed < R::ZERO { -speed } else { R::ZERO };
        let (before, after) = (speed - pull * span.h, speed + push);
        let moved = touch.along_normal(touch.way()) + touch.depth;
        let taken = (before * before - after * after) * R::HALF + pull * moved;
        self.finish(touch, span, Push { push, lift: touch.depth, reach: touch.depth, taken })
    }

    /// What a surface makes of a particle that it gives back.
    ///
    /// With U the speed into the surface at the end of the substep and a the acceleration into it,
    /// the particle went through the surface at u = √(U² − 2 a d), 2 d / (U + u) seconds before. It
    /// left at e u. A constant acceleration changes nothing else.
    fn bounce(&self, touch: &Touch<R>, span: &Span<R>) -> Outcome<R> {
        let pull = touch.along_normal(touch.pull);
        let real = touch.along_normal(touch.velocity) - span.shift * pull;
        let squared = real * real + (pull + pull) * touch.depth;
        let impact = squared.max(R::ZERO).sqrt();
        let after = self.restitution * impact;
        let time = ((touch.depth + touch.depth) / (impact - real)).min(span.h);
        let height = (after + pull * R::HALF * time) * time;
        let push = impact + after;
        let taken = (impact * impact - after * after) * R::HALF;
        let lift = touch.depth + height.max(R::ZERO);
        self.finish(touch, span, Push { push, lift, reach: push * time, taken })
    }

    /// Friction, and what all comes to.
    ///
    /// What sticks goes back by the part of its way that it made since it met the surface. What
    /// slides goes back by what it would not have gone at the velocity it has now.
    #[inline(always)]
    fn finish(&self, touch: &Touch<R>, span: &Span<R>, push: Push<R>) -> Outcome<R> {
        let (Touch { normal: n, velocity: v, pull, depth, .. }, moved) = (*touch, touch.way());
        let [speed, way, pressing] = [v, moved, pull].map(|vector| touch.along_normal(vector));
        let along = [v[0] - n[0] * speed, v[1] - n[1] * speed, v[2] - n[2] * speed];
        let squared = dot(along, along);
        let (slip, grip) = (squared.sqrt(), self.friction * push.push);
        let (kept, per_slip) = self.rub(slip, push.push);
        let sticks = (slip <= grip) & (R::ZERO < grip);
        // A gap that rounding leaves is none: small steps out of it would add up to a way.
        let (gap, noise) = (-(way + depth), touch.rounding());
        let since = if gap <= noise { R::ONE } else { depth / -way };
        let lift = if gap.abs() <= noise { R::ZERO } else { push.lift + way };
        let slid = self.friction * push.reach * per_slip;
        let mut outcome = Outcome { position: touch.position, velocity: v, taken: R::ZERO };
        for axis in 0..3 {
            // From where it was: to go back and forth would add up roundings.
            let before = (moved[axis] - n[axis] * way) * (R::ONE - since);
            let stuck = touch.start[axis] + (n[axis] * lift + before);
            let slides = touch.position[axis] + (n[axis] * push.lift - along[axis] * slid);
            outcome.position[axis] = if sticks { stuck } else { slides };
            outcome.velocity[axis] = n[axis] * (speed + push.push) + along[axis] * kept;
        }
        let drive = dot(pull, v) - pressing * speed;
        let still = (dot(pull, pull) - pressing * pressing) * span.h - (drive + drive);
        let stuck = (squared + still * span.h) * R::HALF
            + (dot(pull, moved) - pressing * way) * (R::ONE - since);
        let slowed = squared * (R::ONE - kept * kept) * R::HALF - drive * slid;
        outcome.taken = push.taken + if sticks { stuck } else { slowed };
        outcome
    }
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The speed towards a surface below which a contact rests, metres per second: what gravity adds in
/// two substeps.
pub(crate) fn resting_speed<R: Real>(normal: R::Vec3, gravity: R::Vec3, h: R) -> R {
    (h + h) * gravity.dot(normal).abs()
}

/// A particle inside an obstacle at the end of a substep, as seen from the surface.
#[derive(Clone, Copy, Debug)]
struct Touch<R> {
    normal: [R; 3],
    /// How far inside, metres; positive.
    depth: R,
    position: [R; 3],
    velocity: [R; 3],
    /// Where it was at the start of the substep.
    start: [R; 3],
    /// Its acceleration without the surface, metres per second squared.
    pull: [R; 3],
}

impl<R: Real> Touch<R> {
    /// How it moved in the substep, metres.
    #[inline(always)]
    fn way(&self) -> [R; 3] {
        let (to, from) = (self.position, self.start);
        [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
    }

    /// The rounding of a gap, metres.
    #[inline(always)]
    fn rounding(&self) -> R {
        let (n, x) = (self.normal, self.position);
        let sum = (n[0] * x[0]).abs() + (n[1] * x[1]).abs() + (n[2] * x[2]).abs();
        sum * (R::EPSILON * R::of(4.0))
    }

    #[inline(always)]
    fn along_normal(&self, vector: [R; 3]) -> R {
        dot(self.normal, vector)
    }
}

/// A substep, in seconds.
#[derive(Clone, Copy, Debug)]
struct Span<R> {
    h: R,
    /// By how much the velocities of the method are ahead of its positions.
    shift: R,
}

/// What a surface gives along its normal.
struct Push<R> {
    /// Impulse by mass, metres per second.
    push: R,
    /// How far the particle is moved, metres.
    lift: R,
    /// Impulse by mass times how long it has acted, metres.
    reach: R,
    /// Energy taken away by mass, joules per kilogram.
    taken: R,
}

/// A particle after contact.
struct Outcome<R> {
    position: [R; 3],
    velocity: [R; 3],
    /// Energy taken away by mass, joules per kilogram.
    taken: R,
}

/// What obstacles did.
///
/// The energy is that of the motion as seen from the surface: what a surface that moves drives in
/// is apart. The force on a particle is taken as constant over a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contacts {
    /// Particles stopped, once for each obstacle and substep.
    pub count: u64,
    /// Energy taken away by contacts that took some, joules.
    pub taken: f64,
    /// Energy added by contacts that added some, joules: an error, which a shorter substep lowers.
    pub added: f64,
    /// Work of surfaces that move, joules.
    pub driven: f64,
}

impl Contacts {
    /// One contact that took so much energy, joules.
    pub(crate) fn one(taken: f64) -> Self {
        Contacts { count: 1, taken: taken.max(0.0), added: (-taken).max(0.0), driven: 0.0 }
    }
}

impl core::ops::AddAssign for Contacts {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.taken += other.taken;
        self.added += other.added;
        self.driven += other.driven;
    }
}

/// What a substep ends with, as contact needs it.
#[derive(Debug)]
pub(crate) struct Bodies<'a, R: Real> {
    /// Masses, a number for each slot, and their reciprocals, three for each.
    pub(crate) masses: &'a [R],
    pub(crate) inverse_masses: &'a [R],
    /// Forces of the last evaluation, newtons.
    pub(crate) forces: &'a [R],
    pub(crate) positions: &'a mut [R],
    pub(crate) velocities: &'a mut [R],
    pub(crate) substep: Substep<'a, R>,
}

/// A substep that ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Substep<'a, R> {
    /// Its length, seconds.
    pub(crate) h: R,
    /// Simulated time at its end, seconds.
    pub(crate) time: f64,
    /// By how much velocities are ahead of those that made the way, seconds: under an acceleration
    /// a the way was h (v − lag a).
    pub(crate) lag: R,
    /// Positions at its start, metres, where the way was another.
    pub(crate) starts: Option<&'a [R]>,
}

impl<R: Real> Split for Bodies<'_, R> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_masses, masses) = self.masses.split_at(numbers / 3);
        let (low_inverse_masses, inverse_masses) = self.inverse_masses.split_at(numbers);
        let (low_forces, forces) = self.forces.split_at(numbers);
        let (low_positions, positions) = self.positions.split_at_mut(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let (low_starts, starts) =
            self.substep.starts.map(|column| column.split_at(numbers)).unzip();
        let (low_substep, substep) =
            (Substep { starts: low_starts, ..self.substep }, Substep { starts, ..self.substep });
        let low = Bodies {
            masses: low_masses,
            inverse_masses: low_inverse_masses,
            forces: low_forces,
            positions: low_positions,
            velocities: low_velocities,
            substep: low_substep,
        };
        (low, Bodies { masses, inverse_masses, forces, positions, velocities, substep })
    }
}

/// Lets every particle that has come into an obstacle meet it.
pub(crate) fn resolve<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    bodies: Bodies<'_, R>,
) -> Contacts {
    let resolve =
        |bodies: Bodies<'_, R>| at_level!(level, _simd => resolve_records(obstacles, bodies));
    let add = |mut low: Contacts, high| {
        low += high;
        low
    };
    merge_shares(bodies, &resolve, &add)
}

#[inline(always)]
fn resolve_records<R: Real>(obstacles: &Obstacles<R>, mut bodies: Bodies<'_, R>) -> Contacts {
    let mut tally = Tally::default();
    let mut few = Batch::default();
    for record in 0..bodies.positions.len() / RECORD {
        let inside = inside(obstacles, &bodies, record);
        if inside == 0 {
            continue;
        }
        if MANY <= inside.count_ones() {
            let mut batch = Batch::of_record(&bodies, record);
            batch.meet(obstacles, &bodies.substep, &mut tally);
            batch.leave(&mut bodies);
            continue;
        }
        let mut left = inside;
        while left != 0 {
            few.add(&bodies, record * RECORD + left.trailing_zeros() as usize);
            left &= left - 1;
            if few.count == LANES {
                few.meet(obstacles, &bodies.substep, &mut tally);
                few.leave(&mut bodies);
                few = Batch::default();
            }
        }
    }
    few.meet(obstacles, &bodies.substep, &mut tally);
    few.leave(&mut bodies);
    tally.contacts()
}

/// Particles of a record from which on the whole record is computed as it is.
const MANY: u32 = 8;

/// Which particles of a record are inside a plane, a bit for each; all where there are other
/// obstacles.
#[inline(always)]
fn inside<R: Real>(obstacles: &Obstacles<R>, bodies: &Bodies<'_, R>, record: usize) -> u32 {
    if !obstacles.own.is_empty() {
        return (1 << LANES) - 1;
    }
    let x: &[R; RECORD] = bodies.positions[record * RECORD..].first_chunk().expect("a record");
    let mut bits = 0;
    for plane in &obstacles.planes {
        let mut below = [0u32; LANES];
        for (lane, below) in below.iter_mut().enumerate() {
            *below = u32::from(R::ZERO < depth(plane, x, lane)) << lane;
        }
        bits |= below.iter().fold(0, |bits, bit| bits | bit);
    }
    bits
}

#[inline(always)]
fn depth<R: Real>(plane: &PlaneColumn<R>, x: &[R; RECORD], lane: usize) -> R {
    plane.offset - dot(plane.normal.components(), lane_of(x, lane))
}

#[inline(always)]
fn lane_of<R: Real>(record: &[R; RECORD], lane: usize) -> [R; 3] {
    [record[lane], record[LANES + lane], record[2 * LANES + lane]]
}

/// Sixteen particles at most that may be inside an obstacle.
struct Batch<R> {
    count: usize,
    /// Their places in the columns.
    places: [usize; LANES],
    positions: [R; RECORD],
    velocities: [R; RECORD],
    /// Where they were at the start of the substep, if that is known already.
    starts: [R; RECORD],
    /// Accelerations; forces at first.
    pulls: [R; RECORD],
    inverse_masses: [R; LANES],
    masses: [R; LANES],
}

impl<R: Real> Default for Batch<R> {
    fn default() -> Self {
        Batch {
            count: 0,
            places: [0; LANES],
            positions: [R::ZERO; RECORD],
            velocities: [R::ZERO; RECORD],
            starts: [R::ZERO; RECORD],
            pulls: [R::ZERO; RECORD],
            inverse_masses: [R::ZERO; LANES],
            masses: [R::ZERO; LANES],
        }
    }
}

impl<R: Real> Batch<R> {
    #[inline(always)]
    fn of_record(bodies: &Bodies<'_, R>, record: usize) -> Self {
        let at = record * RECORD;
        let of = |column: &[R]| *column[at..].first_chunk().expect("a record");
        Batch {
            count: LANES,
            places: core::array::from_fn(|lane| at + lane),
            positions: of(bodies.positions),
            velocities: of(bodies.velocities),
            starts: bodies.substep.starts.map_or([R::ZERO; RECORD], of),
            pulls: of(bodies.forces),
            inverse_masses: *bodies.inverse_masses[at..].first_chunk().expect("a record"),
            masses: *bodies.masses[record * LANES..].first_chunk().expect("a record"),
        }
    }

    #[inline(always)]
    fn add(&mut self, bodies: &Bodies<'_, R>, at: usize) {
        let lane = self.count;
        for axis in 0..3 {
            let (to, from) = (axis * LANES + lane, axis * LANES + at);
            self.positions[to] = bodies.positions[from];
            self.velocities[to] = bodies.velocities[from];
            self.pulls[to] = bodies.forces[from];
            self.starts[to] = bodies.substep.starts.map_or(R::ZERO, |column| column[from]);
        }
        self.inverse_masses[lane] = bodies.inverse_masses[at];
        self.masses[lane] = bodies.masses[single(at)];
        self.places[lane] = at;
        self.count += 1;
    }

    /// Puts the particles back into the columns.
    #[inline(always)]
    fn leave(&self, bodies: &mut Bodies<'_, R>) {
        for (lane, &at) in self.places[..self.count].iter().enumerate() {
            for axis in 0..3 {
                bodies.positions[axis * LANES + at] = self.positions[axis * LANES + lane];
                bodies.velocities[axis * LANES + at] = self.velocities[axis * LANES + lane];
            }
        }
    }

    /// Lets them meet all obstacles, one after the other.
    #[inline(always)]
    fn meet(&mut self, obstacles: &Obstacles<R>, substep: &Substep<'_, R>, tally: &mut Tally) {
        let &Substep { h, lag, time, .. } = substep;
        let span = Span { h, shift: lag - h * R::HALF };
        for i in 0..RECORD {
            self.pulls[i] = self.pulls[i] * self.inverse_masses[i % LANES];
        }
        if substep.starts.is_none() {
            for i in 0..RECORD {
                let mean = self.velocities[i] - self.pulls[i] * lag;
                self.starts[i] = self.positions[i] - mean * h;
            }
        }
        for plane in &obstacles.planes {
            self.meet_plane(plane, &span, tally);
        }
        for (_, own) in &obstacles.own {
            self.meet_own(own.of::<R>(), (&span, time), &mut tally.contacts);
        }
    }

    #[inline(always)]
    fn touch(&self, lane: usize, normal: [R; 3], depth: R) -> Touch<R> {
        Touch {
            normal,
            depth,
            position: lane_of(&self.positions, lane),
            velocity: lane_of(&self.velocities, lane),
            start: lane_of(&self.starts, lane),
            pull: lane_of(&self.pulls, lane),
        }
    }

    fn set(&mut self, lane: usize, position: [R; 3], velocity: [R; 3]) {
        for axis in 0..3 {
            self.positions[axis * LANES + lane] = position[axis];
            self.velocities[axis * LANES + lane] = velocity[axis];
        }
    }

    /// Those that the plane keeps at once, the few others one by one.
    #[inline(always)]
    fn meet_plane(&mut self, plane: &PlaneColumn<R>, span: &Span<R>, tally: &mut Tally) {
        let (normal, law) = (plane.normal.components(), plane.law);
        let (mut energies, mut insides) = ([R::ZERO; LANES], [0u32; LANES]);
        let mut bounces = [0u32; LANES];
        let (mut x, mut v) = (self.positions, self.velocities);
        for lane in 0..LANES {
            let depth = depth(plane, &self.positions, lane);
            let inside = (R::ZERO < depth) & (self.inverse_masses[lane] != R::ZERO);
            let touch = self.touch(lane, normal, depth);
            let keeps = law.keeps(&touch, span);
            let held = law.hold(&touch, span);
            let on = inside & keeps;
            energies[lane] = if on { held.taken * self.masses[lane] } else { R::ZERO };
            insides[lane] = u32::from(inside);
            bounces[lane] = u32::from(inside & !keeps);
            for axis in 0..3 {
                let at = axis * LANES + lane;
                x[at] = if on { held.position[axis] } else { x[at] };
                v[at] = if on { held.velocity[axis] } else { v[at] };
            }
        }
        (self.positions, self.velocities) = (x, v);
        for lane in 0..LANES {
            let taken = energies[lane].to_f64();
            tally.counts[lane] += insides[lane];
            tally.taken[lane] += if 0.0 < taken { taken } else { 0.0 };
            tally.added[lane] += if taken < 0.0 { -taken } else { 0.0 };
        }
        if bounces.iter().fold(0, |any, bounce| any | bounce) == 0 {
            return;
        }
        for lane in (0..LANES).filter(|&lane| bounces[lane] != 0) {
            let touch = self.touch(lane, normal, depth(plane, &self.positions, lane));
            let Outcome { position, velocity, taken } = law.bounce(&touch, span);
            self.set(lane, position, velocity);
            let taken = (taken * self.masses[lane]).to_f64();
            tally.contacts += Contacts { count: 0, ..Contacts::one(taken) };
        }
    }

    /// Any obstacle is met one by one.
    fn meet_own(
        &mut self,
        obstacle: &dyn Obstacle<R>,
        (span, time): (&Span<R>, f64),
        contacts: &mut Contacts,
    ) {
        let law = obstacle.law();
        for lane in 0..LANES {
            if self.inverse_masses[lane] == R::ZERO {
                continue;
            }
            let position = R::Vec3::from_components(lane_of(&self.positions, lane));
            let depth = -obstacle.gap(position, time);
            let is_inside = R::ZERO < depth;
            if !is_inside {
                continue;
            }
            let normal = obstacle.normal(position, time).components();
            let surface = obstacle.velocity(position, time).components();
            let mut touch = self.touch(lane, normal, depth);
            for axis in 0..3 {
                touch.velocity[axis] -= surface[axis];
                touch.start[axis] += surface[axis] * span.h;
            }
            let keeps = law.keeps(&touch, span);
            let outcome = if keeps { law.hold(&touch, span) } else { law.bounce(&touch, span) };
            let (before, mass) = (lane_of(&self.velocities, lane), self.masses[lane]);
            let after = core::array::from_fn(|axis| outcome.velocity[axis] + surface[axis]);
            let kick = core::array::from_fn(|axis| after[axis] - before[axis]);
            self.set(lane, outcome.position, after);
            *contacts += Contacts {
                driven: (dot(kick, surface) * mass).to_f64(),
                ..Contacts::one((outcome.taken * mass).to_f64())
            };
        }
    }
}

/// What contacts came to, lane by lane.
#[derive(Default)]
struct Tally {
    counts: [u32; LANES],
    taken: [f64; LANES],
    added: [f64; LANES],
    contacts: Contacts,
}

impl Tally {
    fn contacts(self) -> Contacts {
        let mut contacts = self.contacts;
        contacts.count += u64::from(self.counts.iter().sum::<u32>());
        contacts.taken += self.taken.iter().sum::<f64>();
        contacts.added += self.added.iter().sum::<f64>();
        contacts
    }
}
