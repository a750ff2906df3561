//! Contacts at a time: which particles are at which obstacles, found once for all that hold them.

use super::Radii;
use super::law::{is_inside, is_near, rounding};
use crate::columns::threads::{Split, merge_shares};
use crate::columns::{LANES, RECORD};
use crate::number::{Real, Vector, at_level};
use crate::obstacles::solid::{Ball, Sampled, lane_of};
use crate::obstacles::{Obstacles, Placed, PlaneColumn};
use crate::pack::dot;
use core::ops::Range;
use fearless_simd::Level;

/// The particles of a record at an obstacle that something moves, a bit for each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Contact {
    /// On its surface or inside.
    pub(crate) near: u16,
    /// Inside; for a method that holds particles on a surface, by more than rounding.
    pub(crate) inside: u16,
}

impl Contact {
    /// On the surface, for a method that holds particles there.
    fn on(self) -> u32 {
        u32::from(self.near & !self.inside)
    }
}

/// The contacts of some records: one with each obstacle, record by record.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found<'a> {
    pub(crate) contacts: &'a [Contact],
    /// The number of obstacles.
    pub(crate) count: usize,
}

impl<'a> Found<'a> {
    /// The contacts of a record.
    #[inline(always)]
    pub(crate) fn of(&self, record: usize) -> &'a [Contact] {
        &self.contacts[record * self.count..][..self.count]
    }

    /// The particles of a record on the obstacle of a number.
    #[inline(always)]
    pub(crate) fn on(&self, record: usize, index: usize) -> u32 {
        self.contacts[record * self.count + index].on()
    }

    /// The particles of a record on the obstacle of a number and on no other.
    #[inline(always)]
    pub(crate) fn alone_on(&self, record: usize, index: usize) -> u32 {
        let on = self.on(record, index);
        if on == 0 { 0 } else { on & !self.on_several(record) }
    }

    /// The particles of a record on several obstacles.
    #[inline(always)]
    pub(crate) fn on_several(&self, record: usize) -> u32 {
        twice(self.of(record).iter().map(|contact| contact.on()))
    }

    pub(crate) fn split(self, numbers: usize) -> (Self, Self) {
        let (low, high) = self.contacts.split_at(numbers / RECORD * self.count);
        (Found { contacts: low, ..self }, Found { contacts: high, ..self })
    }
}

/// The bits that are set in several of some masks.
#[inline(always)]
pub(crate) fn twice(masks: impl Iterator<Item = u32>) -> u32 {
    masks.fold((0, 0), |(once, twice), mask| (once | mask, twice | once & mask)).1
}

/// Where particles are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places<'a, R> {
    pub(crate) positions: &'a [R],
    /// The reciprocals of their masses, three for each slot.
    pub(crate) inverse_masses: &'a [R],
    pub(crate) radii: Radii<'a, R>,
}

impl<'a, R: Real> Places<'a, R> {
    pub(crate) fn records(&self) -> &'a [[R; RECORD]] {
        self.positions.as_chunks::<RECORD>().0
    }

    pub(crate) fn split(self, numbers: usize) -> (Self, Self) {
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

    /// The particles of a record that something moves, a bit for each.
    #[inline(always)]
    fn moving_of(&self, record: usize) -> u32 {
        let bit = |lane| u32::from(self.inverse_masses[record * RECORD + lane] != R::ZERO) << lane;
        (0..LANES).fold(0, |bits, lane| bits | bit(lane))
    }
}

/// Particles and the contacts to be found of them.
#[derive(Debug)]
pub(crate) struct ContactSearch<'a, R> {
    pub(crate) places: Places<'a, R>,
    /// As of [`Found`].
    pub(crate) contacts: &'a mut [Contact],
    pub(crate) count: usize,
    pub(crate) when: When,
    /// Bound of every coordinate, metres.
    pub(crate) extent: R,
}

/// When contacts are found, and for whom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct When {
    /// Simulated time, seconds.
    pub(crate) time: f64,
    /// Whether the method holds particles on an obstacle by [`super::after_kick`].
    pub(crate) settles: bool,
}

impl<R: Real> Split for ContactSearch<'_, R> {
    fn numbers(&self) -> usize {
        self.places.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_places, places) = self.places.split(numbers);
        let (low_contacts, contacts) = self.contacts.split_at_mut(numbers / RECORD * self.count);
        let low = ContactSearch { places: low_places, contacts: low_contacts, ..self };
        (low, ContactSearch { places, contacts, ..self })
    }
}

/// Finds all contacts of particles that something moves; whether any lies on an obstacle, and
/// whether there is a contact.
pub(crate) fn find<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    search: ContactSearch<'_, R>,
) -> [bool; 2] {
    let find =
        |search: ContactSearch<'_, R>| at_level!(level, _simd => find_records(obstacles, search));
    merge_shares(search, &find, &|[a, b], [c, d]| [a | c, b | d])
}

/// Records that are compared with a solid at once.
pub(crate) const TOGETHER: usize = 32;

#[inline(always)]
fn find_records<R: Real>(obstacles: &Obstacles<R>, search: ContactSearch<'_, R>) -> [bool; 2] {
    let ContactSearch { places, contacts, count, when, extent } = search;
    let (records, time) = (places.records(), when.time);
    contacts.fill(Contact::default());
    let (mut lie, mut any) = (0, 0);
    let mut note = |record: usize, index: usize, contact: Contact| {
        contacts[record * count + index] = contact;
        lie |= contact.on();
        any |= contact.near;
    };
    for (index, plane) in obstacles.planes.iter().enumerate() {
        // No gap has larger terms.
        let largest = places.radii.largest;
        let far = largest + rounding(plane.terms_of([extent; 3]), largest);
        for first in (0..records.len()).step_by(AT_ONCE) {
            let some = first..records.len().min(first + AT_ONCE);
            let at = (plane, &places, some.clone());
            if !is_any(at.clone(), |(gap, _), _| gap <= far) || !is_any(at, is_near) {
                continue;
            }
            for record in some {
                let contact = contact(
                    &places,
                    (record, u32::MAX),
                    plane_gap(plane, &places, record),
                    when.settles,
                );
                if contact.near != 0 {
                    note(record, index, contact);
                }
            }
        }
    }
    let mut index = obstacles.planes.len();
    for solid in &obstacles.solids {
        let ball = Ball::<R>::new(solid, time, places.radii.largest);
        let placed = Placed::new(solid, time);
        for (block, some) in records.chunks(TOGETHER).enumerate() {
            if !ball.may_hold_any(some) {
                continue;
            }
            for (record, x) in (block * TOGETHER..).zip(some) {
                let near = ball.inside(x);
                if near != 0 {
                    note(record, index, sampled_contact(&placed, &places, (record, near), when));
                }
            }
        }
        index += 1;
    }
    for (_, own) in &obstacles.own {
        for record in 0..records.len() {
            let moving = places.moving_of(record);
            let contact = sampled_contact(own.of::<R>(), &places, (record, moving), when);
            note(record, index, contact);
        }
        index += 1;
    }
    [lie != 0, any != 0]
}

/// Records that are compared with a plane before anything is decided.
const AT_ONCE: usize = 4;

/// The gap of a plane in each lane of a record, and its terms.
#[inline(always)]
fn plane_gap<'a, R: Real>(
    plane: &'a PlaneColumn<R>,
    places: &Places<'_, R>,
    record: usize,
) -> impl Fn(usize) -> (R, R) + use<'a, R> {
    let (normal, x) = (plane.normal.components(), places.records()[record]);
    move |lane| {
        let point = lane_of(&x, lane);
        (dot(normal, point) - plane.offset, plane.terms_of(point))
    }
}

/// Whether a place of some records meets a condition on its gap of a plane and the terms of that,
/// and on its radius.
#[inline(always)]
fn is_any<R: Real>(
    (plane, places, records): (&PlaneColumn<R>, &Places<'_, R>, Range<usize>),
    meets: impl Fn((R, R), R) -> bool,
) -> bool {
    let mut any = [0; LANES];
    for record in records {
        let (gap, radii) = (plane_gap(plane, places, record), places.radii.of_record(record));
        for (lane, any) in any.iter_mut().enumerate() {
            *any |= u32::from(meets(gap(lane), radii[lane]));
        }
    }
    any.iter().fold(0, |all, any| all | any) != 0
}

/// The contact of a record with an obstacle that is not a plane; the bits say which particles may
/// have one.
#[inline(always)]
fn sampled_contact<R: Real, O: Sampled<R> + ?Sized>(
    obstacle: &O,
    places: &Places<'_, R>,
    (record, which): (usize, u32),
    When { time, settles }: When,
) -> Contact {
    let x = &places.records()[record];
    let gaps = obstacle.gaps((x, which), time);
    let terms = |lane| obstacle.terms(R::Vec3::from_components(lane_of(x, lane)), time);
    contact(places, (record, which), |lane| (gaps[lane], terms(lane)), settles)
}

/// The contact of a record with an obstacle, by the gap in each lane and its terms; the bits say
/// who may have one.
#[inline(always)]
fn contact<R: Real>(
    places: &Places<'_, R>,
    (record, which): (usize, u32),
    gap: impl Fn(usize) -> (R, R),
    settles: bool,
) -> Contact {
    let radii = places.radii.of_record(record);
    let mut near = [0; LANES];
    for (lane, near) in near.iter_mut().enumerate() {
        *near = u32::from(is_near(gap(lane), radii[lane])) << lane;
    }
    let any = |bits: [u32; LANES]| bits.iter().fold(0, |all, bit| all | bit) & which;
    let near = any(near);
    if near == 0 {
        return Contact::default();
    }
    // Most records are at no obstacle.
    let mut inside = [0; LANES];
    for (lane, inside) in inside.iter_mut().enumerate() {
        *inside = u32::from(is_inside(gap(lane), radii[lane], settles)) << lane;
    }
    let moving = places.moving_of(record);
    Contact { near: (near & moving) as u16, inside: (any(inside) & moving) as u16 }
}
