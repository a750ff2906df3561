//! Contact at rest: particles that lie on an obstacle, held there by their velocities alone.
//!
//! A method that moves particles before it evaluates forces lets one that lies on an obstacle fall
//! by g h²/2 in each substep. Forces that are evaluated down there, and dampers at the speed of the
//! fall, are off by a part (h w)² of themselves, and with them the push of the surface and the
//! friction that it allows: at long steps a block slides below the critical slope. So such a method
//! lets every kick be followed by this law: a particle on a surface that the kick presses it to
//! loses its speed into it, and of its slip what Coulomb's law allows. What lies does not sink, and
//! forces are evaluated where it lies. (RATTLE projects velocities for the same reason: Andersen,
//! 1983.)

mod corner;
mod curved;

use super::Radii;
use super::arrive::{AT_ONCE, TOGETHER};
use super::law::{Contacts, rounding, rub};
use crate::columns::threads::{Split, merge_shares, split_singles};
use crate::columns::{LANES, RECORD};
use crate::number::{Real, Vector, at_level};
use crate::obstacles::solid::{Ball, Sampled, lane_of};
use crate::obstacles::{ContactLaw, Obstacles, OwnObstacle, Placed, PlaneColumn};
use crate::pack::dot;
use crate::scene::Solid;
use core::ops::{Add, Range};
use corner::{is_on_obstacle, settle_in_corner};
use curved::{on_curved, settle_on_curved};
use fearless_simd::Level;

/// A state that has just been kicked: v' = v + a t.
#[derive(Debug)]
pub(crate) struct Kicked<'a, R> {
    /// Masses, a number for each slot.
    pub(crate) masses: &'a [R],
    pub(crate) places: Places<'a, R>,
    /// The velocities v'.
    pub(crate) velocities: &'a mut [R],
    /// The accelerations a.
    pub(crate) accelerations: &'a [R],
    pub(crate) kick: Kick<R>,
}

/// A kick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kick<R> {
    /// How long it lasts, seconds.
    pub(crate) length: R,
    /// The substep that it is a part of, seconds.
    pub(crate) substep: R,
    /// Simulated time, seconds.
    pub(crate) time: f64,
    /// Whether it takes the tangential loss of a surface, which comes once in a substep.
    pub(crate) loses: bool,
    pub(crate) drift: Drift,
}

/// The drift of all particles by their velocities for a substep, as seen from a kick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drift {
    /// It follows.
    Ahead,
    /// It is over: what is on a surface now was on it before.
    Behind,
    /// There is none.
    Absent,
}

impl<R: Real> Split for Kicked<'_, R> {
    fn numbers(&self) -> usize {
        self.places.numbers()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_masses, masses) = split_singles(self.masses, numbers);
        let (low_places, places) = self.places.split(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let (low_accelerations, accelerations) = self.accelerations.split_at(numbers);
        let low = Kicked {
            masses: low_masses,
            places: low_places,
            velocities: low_velocities,
            accelerations: low_accelerations,
            kick: self.kick,
        };
        (low, Kicked { masses, places, velocities, accelerations, ..self })
    }
}

/// Where particles are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places<'a, R> {
    pub(crate) positions: &'a [R],
    /// The reciprocals of their masses, three for each slot.
    pub(crate) inverse_masses: &'a [R],
    pub(crate) radii: Radii<'a, R>,
}

impl<R: Real> Split for Places<'_, R> {
    fn numbers(&self) -> usize {
        self.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_positions, positions) = self.positions.split_at(numbers);
        let (low_inverse_masses, inverse_masses) = self.inverse_masses.split_at(numbers);
        let (low_radii, radii) = self.radii.split(numbers);
        let low = Places {
            positions: low_positions,
            inverse_masses: low_inverse_masses,
            radii: low_radii,
        };
        (low, Places { positions, inverse_masses, radii })
    }
}

impl<'a, R: Real> Places<'a, R> {
    fn records(&self) -> &'a [[R; RECORD]] {
        self.positions.as_chunks::<RECORD>().0
    }

    /// Whether something moves the particle in a lane of a record.
    #[inline(always)]
    fn is_moving(&self, record: usize, lane: usize) -> bool {
        self.inverse_masses[record * RECORD + lane] != R::ZERO
    }

    /// The particles of a record that something moves, a bit for each.
    #[inline(always)]
    fn moving_of(&self, record: usize) -> u32 {
        let bit = |lane| u32::from(self.is_moving(record, lane)) << lane;
        (0..LANES).fold(0, |bits, lane| bits | bit(lane))
    }

    /// The particles of some records that something moves, each with its radius.
    fn moving(self, records: Range<usize>) -> impl Iterator<Item = ([R; 3], R)> + 'a {
        let rows = self.records();
        records.flat_map(move |record| {
            (0..LANES).filter(move |&lane| self.is_moving(record, lane)).map(move |lane| {
                (lane_of(&rows[record], lane), self.radii.at(record * RECORD + lane))
            })
        })
    }
}

/// Whether a particle that something moves is on an obstacle at a time, seconds. `are_far`: it is
/// known that none is near a solid.
pub(crate) fn is_any_on<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    places: Places<'_, R>,
    (time, are_far): (f64, bool),
) -> bool {
    let is_flat = are_far && obstacles.own.is_empty();
    if obstacles.is_empty() || is_flat && obstacles.planes.is_empty() {
        return false;
    }
    let is_any = |places: Places<'_, R>| {
        at_level!(level, _simd => {
            is_any_on_planes(obstacles, &places)
                || !is_flat && is_one_on_curved(obstacles, &places, time)
        })
    };
    merge_shares(places, &is_any, &|low, high| low | high)
}

#[inline(always)]
fn is_any_on_planes<R: Real>(obstacles: &Obstacles<R>, places: &Places<'_, R>) -> bool {
    let count = places.records().len();
    (0..count).step_by(AT_ONCE).map(|first| first..count.min(first + AT_ONCE)).any(|records| {
        let are_on = if places.radii.column.is_empty() {
            are_on_planes(obstacles, places, records.clone(), |_| [R::ZERO; LANES])
        } else {
            are_on_planes(obstacles, places, records.clone(), |record| {
                places.radii.of_record(record)
            })
        };
        let is_on_one = |(x, radius)| obstacles.planes.iter().any(|plane| is_on(plane, x, radius));
        are_on && places.moving(records).any(is_on_one)
    })
}

/// Whether a place in these records is on a plane, with or without a particle that can move.
#[inline(always)]
fn are_on_planes<R: Real>(
    obstacles: &Obstacles<R>,
    places: &Places<'_, R>,
    records: Range<usize>,
    radii: impl Fn(usize) -> [R; LANES],
) -> bool {
    let (rows, mut any) = (places.records(), [0; LANES]);
    for plane in &obstacles.planes {
        for record in records.clone() {
            let radii = radii(record);
            for (lane, any) in any.iter_mut().enumerate() {
                *any |= u32::from(is_on(plane, lane_of(&rows[record], lane), radii[lane]));
            }
        }
    }
    any.iter().fold(0, |all, any| all | any) != 0
}

#[inline(always)]
fn is_one_on_curved<R: Real>(obstacles: &Obstacles<R>, places: &Places<'_, R>, time: f64) -> bool {
    for solid in &obstacles.solids {
        if is_one_on_solid(solid, places, time) {
            return true;
        }
    }
    let is_one_on = |own: &OwnObstacle| {
        let obstacle = own.of::<R>();
        (0..places.records().len())
            .any(|record| is_one_of_record_on(&obstacle, places, record, (ALL, time)))
    };
    obstacles.own.iter().any(|(_, obstacle)| is_one_on(obstacle))
}

/// Whether a particle of a record that something moves is on an obstacle; the bits say which may.
#[inline(always)]
fn is_one_of_record_on<R: Real>(
    obstacle: &impl Sampled<R>,
    places: &Places<'_, R>,
    record: usize,
    (which, time): (u32, f64),
) -> bool {
    let which = which & places.moving_of(record);
    let (x, radii) = (&places.records()[record], places.radii.of_record(record));
    which != 0 && on_curved(obstacle, (x, &radii, which), time).0 != 0
}

#[inline(always)]
fn is_one_on_solid<R: Real>(solid: &Solid, places: &Places<'_, R>, time: f64) -> bool {
    let ball = Ball::<R>::new(solid, time, places.radii.largest);
    let placed = Placed::new(solid, time);
    for (block, some) in places.records().chunks(TOGETHER).enumerate() {
        if !ball.may_hold_any(some) {
            continue;
        }
        for (record, x) in (block * TOGETHER..).zip(some) {
            let near = (ball.inside(x), time);
            if is_one_of_record_on(&placed, places, record, near) {
                return true;
            }
        }
    }
    false
}

/// Whether the gap of a particle of this radius counts as zero: it is below its rounding.
#[inline(always)]
fn is_on<R: Real>(plane: &PlaneColumn<R>, x: [R; 3], radius: R) -> bool {
    let normal = plane.normal.components();
    (dot(normal, x) - plane.offset - radius).abs() <= rounding(plane.terms_of(x), radius)
}

/// Holds the particles that lie on an obstacle after a kick.
pub(crate) fn settle<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    kicked: Kicked<'_, R>,
) -> Contacts {
    let settle =
        |kicked: Kicked<'_, R>| at_level!(level, _simd => settle_records(obstacles, kicked));
    merge_shares(kicked, &settle, &Contacts::add)
}

#[inline(always)]
fn settle_records<R: Real>(obstacles: &Obstacles<R>, mut kicked: Kicked<'_, R>) -> Contacts {
    let mut contacts = Contacts::default();
    let records = kicked.places.records();
    let (time, radius) = (kicked.kick.time, kicked.places.radii.largest);
    for (block, some) in records.chunks(TOGETHER).enumerate() {
        if obstacles.planes.is_empty() {
            break;
        }
        let mut is_near = None;
        for (record, x) in (block * TOGETHER..).zip(some) {
            let mut is_near = || {
                *is_near.get_or_insert_with(|| is_any_near_curved(obstacles, time, radius, some))
            };
            settle_on_planes(obstacles, &mut kicked, (record, x, &mut is_near), &mut contacts);
        }
    }
    let mut index = obstacles.planes.len();
    for solid in &obstacles.solids {
        let ball = Ball::<R>::new(solid, time, radius);
        let placed = Placed::new(solid, time);
        let moved = match kicked.kick.drift {
            Drift::Ahead => Placed::new(solid, time + kicked.kick.substep.to_f64()),
            Drift::Behind | Drift::Absent => placed,
        };
        for (block, some) in records.chunks(TOGETHER).enumerate() {
            if !ball.may_hold_any(some) {
                continue;
            }
            for (record, x) in (block * TOGETHER..).zip(some) {
                let near = ball.inside(x);
                if near != 0 {
                    let which = (record, x, near);
                    let curved = (obstacles, index, &placed, &moved);
                    settle_on_curved(curved, &mut kicked, which, &mut contacts);
                }
            }
        }
        index += 1;
    }
    for (_, own) in &obstacles.own {
        let own = own.of::<R>();
        for (record, x) in records.iter().enumerate() {
            let curved = (obstacles, index, &own, &own);
            settle_on_curved(curved, &mut kicked, (record, x, ALL), &mut contacts);
        }
        index += 1;
    }
    contacts
}

/// Whether one of these places may be on a curved obstacle.
#[inline(always)]
fn is_any_near_curved<R: Real>(
    obstacles: &Obstacles<R>,
    time: f64,
    radius: R,
    records: &[[R; RECORD]],
) -> bool {
    let is_near = |solid: &Solid| {
        let ball = Ball::<R>::new(solid, time, radius);
        ball.may_hold_any(records) && records.iter().any(|x| ball.inside(x) != 0)
    };
    !obstacles.own.is_empty() || obstacles.solids.iter().any(is_near)
}

/// Holds the particles of a record that lie on planes. `is_near`: one may lie on something else
/// too.
#[inline(always)]
fn settle_on_planes<R: Real>(
    obstacles: &Obstacles<R>,
    kicked: &mut Kicked<'_, R>,
    (record, x, is_near): (usize, &[R; RECORD], &mut dyn FnMut() -> bool),
    contacts: &mut Contacts,
) {
    let radii = kicked.places.radii.of_record(record);
    let (mut counts, mut lain_on) = ([0; LANES], 0u64);
    for (number, plane) in obstacles.planes.iter().enumerate() {
        let mut on = [0; LANES];
        for (lane, on) in on.iter_mut().enumerate() {
            *on = u32::from(is_on(plane, lane_of(x, lane), radii[lane]));
            counts[lane] += *on;
        }
        let is_any = on.iter().fold(0, |any, on| any | on) != 0;
        // Planes beyond the last bit share it.
        lain_on |= u64::from(is_any) << number.min(63);
    }
    if lain_on == 0 {
        return;
    }
    if is_near() {
        let curved = obstacles.planes.len()..obstacles.count();
        for (lane, count) in counts.iter_mut().enumerate().filter(|(_, count)| **count == 1) {
            let place = (R::Vec3::from_components(lane_of(x, lane)), radii[lane]);
            let is_on = |index| is_on_obstacle(obstacles, index, place, kicked.kick.time);
            *count += u32::from(curved.clone().any(is_on));
        }
    }
    for (number, plane) in obstacles.planes.iter().enumerate() {
        if lain_on >> number.min(63) & 1 != 0 {
            settle_on_plane(plane, kicked, (record, x, &counts), contacts);
        }
    }
    for lane in (0..LANES).filter(|&lane| 1 < counts[lane]) {
        settle_in_corner(obstacles, kicked, (record, lane), contacts);
    }
}

/// Holds the particles of a record that lie on this plane and on no other.
#[inline(always)]
fn settle_on_plane<R: Real>(
    plane: &PlaneColumn<R>,
    kicked: &mut Kicked<'_, R>,
    (record, x, counts): (usize, &[R; RECORD], &[u32; LANES]),
    contacts: &mut Contacts,
) {
    // A plane does not bend away from a drift.
    let (at, kick) = (record * RECORD, Kick { drift: Drift::Absent, ..kicked.kick });
    let (normal, law) = (plane.normal.components(), kick.law(plane.law));
    let of = |column: &[R]| -> [R; RECORD] { *column[at..].first_chunk().expect("a record") };
    let (mut v, a, w) =
        (of(kicked.velocities), of(kicked.accelerations), of(kicked.places.inverse_masses));
    let (mut lie, mut taken) = ([false; LANES], [R::ZERO; LANES]);
    let radii = kicked.places.radii.of_record(record);
    for lane in 0..LANES {
        let is_on = is_on(plane, lane_of(x, lane), radii[lane]);
        let on = is_on & (counts[lane] == 1) & (w[lane] != R::ZERO);
        let kicked = (lane_of(&v, lane), lane_of(&a, lane));
        let settled = kick.settle(&law, normal, kicked, R::ZERO);
        lie[lane] = on & settled.lies;
        taken[lane] = settled.taken;
        for axis in 0..3 {
            let number = &mut v[axis * LANES + lane];
            *number = if lie[lane] { settled.velocity[axis] } else { *number };
        }
    }
    kicked.velocities[at..at + RECORD].copy_from_slice(&v);
    for lane in (0..LANES).filter(|&lane| lie[lane]) {
        *contacts += Contacts::one((taken[lane] * kicked.masses[record * LANES + lane]).to_f64());
    }
}

/// Speed away from a surface below which a particle has not left, as a part of what the pull makes
/// up within two substeps: without it ever shorter hops would not end.
const HOP: f64 = 0.01;

/// Whether a particle on a surface lay there, by its velocity and the part of it along the normal:
/// it did not leave, and came so slowly that a bounce would be over within two substeps, as in
/// [`super::law::keeps`]. The limit is that of such a speed, negative.
#[inline(always)]
fn lay<R: Real>(law: &ContactLaw<R>, speed: R, limit: R, velocity: [R; 3]) -> bool {
    let rounding = R::EPSILON * R::of(8.0) * Real::sqrt(dot(velocity, velocity));
    (speed <= rounding - limit * R::of(HOP)) & ((law.restitution == R::ZERO) | (limit < speed))
}

/// The velocity along a surface that friction leaves at a push, and the reciprocal of the slip, 0
/// where it holds.
#[inline(always)]
fn slowed<R: Real>(law: &ContactLaw<R>, n: [R; 3], v: [R; 3], push: R) -> ([R; 3], R) {
    let speed = dot(n, v);
    let along: [R; 3] = core::array::from_fn(|axis| v[axis] - n[axis] * speed);
    let (kept, per_slip) = rub(law, dot(along, along).sqrt(), push);
    (along.map(|number| number * kept), per_slip)
}

/// All lanes of a record, a bit for each.
const ALL: u32 = (1 << LANES) - 1;

/// A velocity after the law.
struct Settled<R> {
    /// Whether the particle lies, if it is on the surface: the law is for no other.
    lies: bool,
    /// Along the surface.
    velocity: [R; 3],
    /// Energy dissipated per mass, joules per kilogram.
    taken: R,
}

impl<R: Real> Kick<R> {
    fn law(&self, law: ContactLaw<R>) -> ContactLaw<R> {
        if self.loses { law } else { ContactLaw { loss: R::ZERO, ..law } }
    }

    /// Holds a particle on a surface with this normal, at a velocity after the kick and with the
    /// acceleration of the kick, as seen from the surface.
    ///
    /// It lies where the kick presses it to the surface and it lay there before, see
    /// [`lay`]. A surface that holds it takes the energy of its motion before the kick,
    /// one that it slides on the work of friction: force times mean velocity.
    ///
    /// It goes on at the speed `bend` along the normal, 0 on a plane: see [`bend`].
    #[inline(always)]
    fn settle(
        &self,
        law: &ContactLaw<R>,
        n: [R; 3],
        (v, a): ([R; 3], [R; 3]),
        bend: R,
    ) -> Settled<R> {
        let (speed, pull) = (dot(n, v), dot(n, a));
        let before = speed - pull * self.length;
        let limit = (self.substep + self.substep) * pull;
        let was = core::array::from_fn(|axis| v[axis] - a[axis] * self.length);
        let lay = (self.drift == Drift::Behind) | lay(law, before, limit, was);
        let lies = (speed < bend) & (pull < R::ZERO) & lay;
        let (velocity, per_slip) = slowed(law, n, v, bend - speed);
        let sum = |term: [R; 3]| term[0] + term[1] + term[2];
        let lost = sum(core::array::from_fn(|axis| {
            let along = v[axis] - n[axis] * speed;
            let slipped = along - (a[axis] - n[axis] * pull) * self.length;
            let held = per_slip == R::ZERO;
            // A loss comes with the first of two kicks alone: the kick's work on the way that it
            // saves is in no second one.
            let saved = if law.loss == R::ZERO { R::ZERO } else { along - slipped };
            if held {
                slipped * slipped
            } else {
                (along - velocity[axis]) * (slipped + velocity[axis] - saved)
            }
        }));
        // How the surface bends in a drift is the same motion before it and after it.
        let stopped = if self.drift == Drift::Behind { R::ZERO } else { before * before };
        let taken = (stopped + lost) * R::HALF;
        Settled { lies, velocity, taken }
    }
}
