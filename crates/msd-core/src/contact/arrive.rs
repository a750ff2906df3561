//! Contact at the end of a substep: the particles inside an obstacle, and the law for sixteen at a
//! time.

use super::ending::{Bodies, Substep};
use super::found::{TOGETHER, twice};
use super::held::{Limit, MOST};
use super::landing::{Arrival, is_squeezed, meet_surface, onto};
use super::law::{Contacts, Outcome, Span, TURN, Touch, bounce, depth, hold, keeps, rounding};
use super::passage::Passage;
use crate::columns::threads::merge_shares;
use crate::columns::{LANES, RECORD, load, single, single_of, singles_of, store};
use crate::number::{Real, Vector, at_level};
use crate::obstacles::solid::{Ball, Sampled, lane_of, lanes};
use crate::obstacles::{Obstacle, Obstacles, Placed, PlaneColumn};
use crate::pack::{Number, Pack, dot_terms, splat, zip};
use core::ops::{Add, Range};
use fearless_simd::{Level, Simd, SimdMask};

/// Lets every particle that has come into an obstacle meet it.
pub(crate) fn resolve<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    bodies: Bodies<'_, R>,
) -> Contacts {
    let resolve =
        |bodies: Bodies<'_, R>| at_level!(level, simd => resolve_records(simd, obstacles, bodies));
    merge_shares(bodies, &resolve, &Contacts::add)
}

#[inline(always)]
fn resolve_records<S: Simd, R: Real>(
    simd: S,
    obstacles: &Obstacles<R>,
    mut bodies: Bodies<'_, R>,
) -> Contacts {
    let mut tally = Tally::default();
    let mut few = Batch::default();
    let records = bodies.positions.len() / RECORD;
    for first in (0..records).step_by(TOGETHER) {
        let some = first..records.min(first + TOGETHER);
        let far = gone_far(obstacles, &bodies, some.clone());
        for (record, far) in some.zip(far) {
            let found = bodies.found.of(record).iter();
            let inside = found.fold(0, |all, contact| all | u32::from(contact.inside));
            if inside | far != 0 {
                let met = (record, inside, far);
                meet_record(simd, obstacles, (&mut bodies, &mut few), met, &mut tally);
            }
        }
    }
    if 0 < few.count {
        few.meet(simd, obstacles, &bodies.substep, &mut tally);
        few.leave(&mut bodies);
    }
    tally.contacts()
}

/// Lets the particles of a record that are inside an obstacle or have gone far meet it, or gathers
/// them with the few of other records.
#[inline(always)]
fn meet_record<S: Simd, R: Real>(
    simd: S,
    obstacles: &Obstacles<R>,
    (bodies, few): (&mut Bodies<'_, R>, &mut Batch<R>),
    (record, inside, far): (usize, u32, u32),
    tally: &mut Tally,
) {
    let near = bodies.found.of(record).iter().map(|contact| u32::from(contact.near));
    let several = inside & twice(near);
    let left = inside | far;
    if MANY <= left.count_ones() {
        let mut batch = Batch::of_record(bodies, record, several);
        batch.meet(simd, obstacles, &bodies.substep, tally);
        batch.leave(bodies);
        return;
    }
    for lane in lanes(left) {
        few.add(bodies, (record, lane), several >> lane & 1);
        if few.count == LANES {
            few.meet(simd, obstacles, &bodies.substep, tally);
            few.leave(bodies);
            *few = Batch::default();
        }
    }
}

/// The particles of some records that may have gone through a solid, or beyond its middle, a bit
/// for each.
#[inline(always)]
fn gone_far<R: Real>(
    obstacles: &Obstacles<R>,
    bodies: &Bodies<'_, R>,
    records: Range<usize>,
) -> [u32; TOGETHER] {
    let mut all = [0; TOGETHER];
    let rows = &bodies.positions.as_chunks::<RECORD>().0[records.clone()];
    let Substep { h, time, reach, .. } = bodies.substep;
    for solid in &obstacles.solids {
        let ball = Ball::<R>::behind(solid, (time, h), bodies.radii.largest + reach);
        if !ball.may_hold_any(rows) {
            continue;
        }
        let placed = Placed::new(solid, time);
        let passage = Passage::new(&placed, (time, h.to_f64()));
        for ((row, record), far) in rows.iter().zip(records.clone()).zip(&mut all) {
            let near = ball.inside(row);
            if near != 0 {
                *far |= near & passage.long_ways(&bodies.starts_of(record), row);
            }
        }
    }
    all
}

/// The number of particles inside from which on the whole record is computed.
const MANY: u32 = 8;

/// Sixteen particles at most that may be inside an obstacle.
struct Batch<R> {
    count: usize,
    /// Their places in the columns.
    places: [usize; LANES],
    /// Those that are inside an obstacle and in or on another, a bit for each.
    several: u32,
    positions: [R; RECORD],
    velocities: [R; RECORD],
    /// Where they were at the start of the substep.
    starts: [R; RECORD],
    /// Accelerations; forces at first.
    pulls: [R; RECORD],
    /// Accelerations at the start of the substep; as `pulls` where they are not known.
    before: [R; RECORD],
    inverse_masses: [R; LANES],
    masses: [R; LANES],
    stiffnesses: [R; LANES],
    radii: [R; LANES],
}

impl<R: Real> Default for Batch<R> {
    fn default() -> Self {
        Batch {
            count: 0,
            places: [0; LANES],
            several: 0,
            positions: [R::ZERO; RECORD],
            velocities: [R::ZERO; RECORD],
            starts: [R::ZERO; RECORD],
            pulls: [R::ZERO; RECORD],
            before: [R::ZERO; RECORD],
            inverse_masses: [R::ZERO; LANES],
            masses: [R::ZERO; LANES],
            stiffnesses: [R::ZERO; LANES],
            radii: [R::ZERO; LANES],
        }
    }
}

impl<R: Real> Batch<R> {
    #[inline(always)]
    fn of_record(bodies: &Bodies<'_, R>, record: usize, several: u32) -> Self {
        let at = record * RECORD;
        let of = |column: &[R]| *column[at..].first_chunk().expect("a record");
        Batch {
            count: LANES,
            places: core::array::from_fn(|lane| at + lane),
            several,
            positions: of(bodies.positions),
            velocities: of(bodies.velocities),
            starts: bodies.substep.starts.map_or([R::ZERO; RECORD], of),
            pulls: of(bodies.forces),
            before: bodies.substep.before.map_or([R::ZERO; RECORD], of),
            inverse_masses: *bodies.inverse_masses[at..].first_chunk().expect("a record"),
            masses: singles_of(bodies.masses, record),
            stiffnesses: singles_of(bodies.stiffnesses, record),
            radii: bodies.radii.of_record(record),
        }
    }

    #[inline(always)]
    fn add(&mut self, bodies: &Bodies<'_, R>, (record, from): (usize, usize), is_in_several: u32) {
        let (lane, at) = (self.count, record * RECORD + from);
        let put = |to: &mut [R; RECORD], column: &[R]| {
            let row: &[R; RECORD] = column[record * RECORD..].first_chunk().expect("a record");
            for axis in 0..3 {
                to[axis * LANES + lane] = row[axis * LANES + from];
            }
        };
        put(&mut self.positions, bodies.positions);
        put(&mut self.velocities, bodies.velocities);
        put(&mut self.pulls, bodies.forces);
        let Substep { starts, before, .. } = bodies.substep;
        starts.inspect(|column| put(&mut self.starts, column));
        before.inspect(|column| put(&mut self.before, column));
        self.inverse_masses[lane] = bodies.inverse_masses[at];
        self.masses[lane] = bodies.masses[single(at)];
        self.stiffnesses[lane] = single_of(bodies.stiffnesses, at);
        self.radii[lane] = bodies.radii.at(at);
        self.places[lane] = at;
        self.several |= is_in_several << lane;
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
    fn meet<S: Simd>(
        &mut self,
        simd: S,
        obstacles: &Obstacles<R>,
        substep: &Substep<'_, R>,
        tally: &mut Tally,
    ) {
        let &Substep { h, lag, time, reach, evaluated, .. } = substep;
        let flat = Span { h, shift: lag - h * R::HALF, evaluated, turn: R::of(f64::INFINITY) };
        for i in 0..RECORD {
            self.pulls[i] *= self.inverse_masses[i % LANES];
        }
        if substep.before.is_none() {
            self.before = self.pulls;
        }
        if substep.starts.is_none() {
            self.starts = substep.start(self.positions, &self.velocities, &self.pulls);
        }
        let several = self.several;
        // Where the start is known the displacement needs no lag.
        let lag = if substep.starts.is_some() { R::ZERO } else { lag };
        for lane in lanes(several) {
            tally.contacts.squeezed |= is_squeezed(obstacles, self.at(lane), time);
            tally.contacts += self.meet_several(obstacles, (&flat, time, lag), lane);
        }
        let (mut met, mut again) = (0, 0);
        let mut note = |now: u32| (met, again) = (met | now, again | met & now);
        for plane in &obstacles.planes {
            note(self.meet_plane(simd, plane, (&flat, !several), tally));
        }
        for solid in &obstacles.solids {
            let largest = self.radii.iter().copied().fold(R::ZERO, R::max);
            let ball = Ball::behind(solid, (time, h), largest + reach);
            let near = ball.inside(&self.positions) & !several;
            if near != 0 {
                let placed = Placed::new(solid, time);
                let span = Span { turn: R::of(TURN * solid.shape.bend()), ..flat };
                let swept = self.meet_swept(&placed, (&span, time, near), &mut tally.contacts);
                let near = near & !swept;
                note(swept | self.meet_curved(&placed, (&span, time, near), &mut tally.contacts));
            }
        }
        for (_, own) in &obstacles.own {
            let moving = self.moving() & !several;
            note(self.meet_curved(own.of::<R>(), (&flat, time, moving), &mut tally.contacts));
        }
        // Both surfaces hold a particle that one of them has put into the other.
        for lane in lanes(again) {
            tally.contacts.squeezed |= is_squeezed(obstacles, self.at(lane), time);
            self.pulls_nothing(lane);
            let held = self.meet_several(obstacles, (&flat, time, R::ZERO), lane);
            // Each surface has been counted.
            tally.contacts += Contacts { count: 0, ..held };
        }
    }

    /// Lets a particle meet all obstacles that it is in or on at once.
    #[cold]
    fn meet_several(
        &mut self,
        obstacles: &Obstacles<R>,
        (span, time, lag): (&Span<R>, f64, R),
        lane: usize,
    ) -> Contacts {
        let (place, radius) = self.at(lane);
        let mut indices = [0; MOST];
        let mut arrival = Arrival::new(self.touch(lane, ([R::ZERO; 3], R::ZERO, R::ZERO)));
        for index in 0..obstacles.count() {
            let obstacle = obstacles.get(index);
            let depth = radius - obstacle.gap(place, time);
            let noise = rounding(obstacle.terms(place, time), radius);
            if -noise <= depth && arrival.count() < MOST {
                indices[arrival.count()] = index;
                let normal = obstacle.normal(place, time);
                let surface = obstacle.velocity(place, time);
                let row = Limit { normal, surface, least: R::ZERO, law: obstacle.law() };
                arrival.add(row, (depth, noise));
            }
        }
        if arrival.count() == 0 {
            return Contacts::default();
        }
        let depth = |row: usize, at| radius - obstacles.get(indices[row]).gap(at, time);
        let landed = arrival.land((span, lag), self.masses[lane], depth);
        self.set(lane, landed.position, landed.velocity);
        landed.contacts
    }

    /// Forgets how a particle moved in the substep, once that has been booked.
    fn pulls_nothing(&mut self, lane: usize) {
        for axis in 0..3 {
            let at = axis * LANES + lane;
            self.starts[at] = self.positions[at];
            self.pulls[at] = R::ZERO;
        }
    }

    /// Where a particle is, and its radius.
    fn at(&self, lane: usize) -> (R::Vec3, R) {
        (R::Vec3::from_components(lane_of(&self.positions, lane)), self.radii[lane])
    }

    /// The particles that something moves, a bit for each.
    #[inline(always)]
    fn moving(&self) -> u32 {
        let bit = |lane: usize| u32::from(self.inverse_masses[lane] != R::ZERO) << lane;
        (0..LANES).fold(0, |bits, lane| bits | bit(lane))
    }

    #[inline(always)]
    fn touch(&self, lane: usize, (normal, depth, terms): ([R; 3], R, R)) -> Touch<R> {
        Touch {
            normal,
            depth,
            position: lane_of(&self.positions, lane),
            radius: self.radii[lane],
            noise: rounding(terms, self.radii[lane]),
            velocity: lane_of(&self.velocities, lane),
            start: lane_of(&self.starts, lane),
            pull: lane_of(&self.pulls, lane),
            before: lane_of(&self.before, lane),
            stiffness: self.stiffnesses[lane] * self.inverse_masses[lane],
        }
    }

    fn set(&mut self, lane: usize, position: [R; 3], velocity: [R; 3]) {
        for axis in 0..3 {
            self.positions[axis * LANES + lane] = position[axis];
            self.velocities[axis * LANES + lane] = velocity[axis];
        }
    }

    /// Some particles as a plane sees them.
    #[inline(always)]
    fn touches<S: Simd>(&self, simd: S, plane: &PlaneColumn<R>, part: usize) -> Touch<Pack<S, R>> {
        let (position, radius) = (load(simd, &self.positions, part), some(simd, &self.radii, part));
        let inverse_mass = some(simd, &self.inverse_masses, part);
        let normal = splat(simd, plane.normal.components());
        Touch {
            normal,
            depth: depth(normal, Pack::new(simd, plane.offset), position) + radius,
            position,
            radius,
            noise: rounding(dot_terms(normal, position), radius),
            velocity: load(simd, &self.velocities, part),
            start: load(simd, &self.starts, part),
            pull: load(simd, &self.pulls, part),
            before: load(simd, &self.before, part),
            stiffness: some(simd, &self.stiffnesses, part) * inverse_mass,
        }
    }

    /// Meets a plane: those that it keeps all at once, the few others one by one. Returns those
    /// that were inside.
    #[inline(always)]
    fn meet_plane<S: Simd>(
        &mut self,
        simd: S,
        plane: &PlaneColumn<R>,
        (span, which): (&Span<R>, u32),
        tally: &mut Tally,
    ) -> u32 {
        let (normal, law) = (plane.normal.components(), plane.law);
        let (mut taken, mut met, mut kept) = ([R::ZERO; LANES], 0, 0);
        for part in (0..LANES).step_by(Pack::<S, R>::LEN) {
            let touch = self.touches(simd, plane, part);
            let (law, span) = (law.splat(simd), span.splat(simd));
            let mass = some(simd, &self.masses, part);
            let inverse_mass = some(simd, &self.inverse_masses, part);
            let may = Pack::<S, R>::mask(simd, u64::from(which >> part));
            let is_moved = inverse_mass.zero().is_less(inverse_mass);
            let inside = touch.is_inside(&span) & may & is_moved;
            let on = inside & keeps(&law, &touch, &span);
            let held = hold(&law, &touch, &span);
            let choose = |yes, no| Pack::select(on, yes, no);
            store(zip(held.position, touch.position, choose), &mut self.positions, part);
            store(zip(held.velocity, touch.velocity, choose), &mut self.velocities, part);
            let loss = Pack::select(on, held.taken * mass, mass.zero());
            loss.store_slice(&mut taken[part..][..Pack::<S, R>::LEN]);
            met |= (inside.to_bitmask() as u32) << part;
            kept |= (on.to_bitmask() as u32) << part;
        }
        for (lane, taken) in taken.into_iter().enumerate() {
            let taken = taken.to_f64();
            tally.counts[lane] += met >> lane & 1;
            tally.taken[lane] += if 0.0 < taken { taken } else { 0.0 };
            tally.added[lane] += if taken < 0.0 { -taken } else { 0.0 };
        }
        for lane in lanes(met & !kept) {
            let (place, radius) = (lane_of(&self.positions, lane), self.radii[lane]);
            let depth = depth(normal, plane.offset, place) + radius;
            let touch = self.touch(lane, (normal, depth, plane.terms_of(place)));
            let Outcome { position, velocity, taken } = bounce(&law, &touch, span);
            self.set(lane, position, velocity);
            let taken = (taken * self.masses[lane]).to_f64();
            tally.contacts += Contacts { count: 0, bounced: true, ..Contacts::one(taken) };
        }
        met
    }

    /// Lets particles that went into a solid elsewhere than at the surface next to them meet it
    /// there; which these are, of those that the bits say.
    #[inline(always)]
    fn meet_swept(
        &mut self,
        solid: &Placed<'_>,
        (span, time, near): (&Span<R>, f64, u32),
        contacts: &mut Contacts,
    ) -> u32 {
        let passage = Passage::new(solid, (time, span.h.to_f64()));
        let long = near & self.moving() & passage.long_ways(&self.starts, &self.positions);
        lanes(long).fold(0, |met, lane| {
            let way = (lane_of(&self.starts, lane), lane_of(&self.positions, lane));
            let Some(entrance) = passage.entrance(way, self.radii[lane]) else { return met };
            let terms = solid.terms(R::Vec3::from_components(way.1), time);
            let touch = self.touch(lane, (entrance.normal, entrance.depth, terms));
            let landed = meet_surface(solid, touch, (span, time), self.masses[lane]);
            self.set(lane, landed.position, landed.velocity);
            *contacts += landed.contacts;
            contacts.turned |= passage.is_fast();
            met | 1 << lane
        })
    }

    /// Meets an obstacle that is not a plane. The bits given say which particles may be inside, the
    /// bits returned which were.
    #[inline(always)]
    fn meet_curved(
        &mut self,
        obstacle: &(impl Sampled<R> + ?Sized),
        (span, time, near): (&Span<R>, f64, u32),
        contacts: &mut Contacts,
    ) -> u32 {
        let gaps = obstacle.gaps((&self.positions, near), time);
        let mut bits = [0; LANES];
        for lane in 0..LANES {
            let is_inside =
                (gaps[lane] < self.radii[lane]) & (self.inverse_masses[lane] != R::ZERO);
            bits[lane] = u32::from(is_inside) << lane;
        }
        let (inside, mut met) = (near & bits.iter().fold(0, |all, bit| all | bit), 0);
        if inside == 0 {
            return 0;
        }
        let normals = obstacle.normals((&self.positions, inside), time);
        for lane in lanes(inside) {
            let position = R::Vec3::from_components(lane_of(&self.positions, lane));
            let terms = obstacle.terms(position, time);
            let touch =
                self.touch(lane, (lane_of(&normals, lane), self.radii[lane] - gaps[lane], terms));
            if touch.is_inside(span) {
                let mut landed = meet_surface(obstacle, touch, (span, time), self.masses[lane]);
                if span.settles() {
                    onto(obstacle, &touch, &mut landed, time);
                }
                self.set(lane, landed.position, landed.velocity);
                *contacts += landed.contacts;
                met |= 1 << lane;
            }
        }
        met
    }
}

/// Some of the numbers of a record.
#[inline(always)]
fn some<S: Simd, R: Real>(simd: S, numbers: &[R; LANES], part: usize) -> Pack<S, R> {
    Pack::from_slice(simd, &numbers[part..][..Pack::<S, R>::LEN])
}

/// The tally of contacts, lane by lane.
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
