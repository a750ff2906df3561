//! Resting contact: particles that lie on an obstacle, held there by their velocities alone.
//!
//! A method that moves particles before it evaluates forces lets one that lies on an obstacle fall
//! by g h²/2 in each substep. Forces that are evaluated down there, and dampers at the speed of the
//! fall, are off by a part (h w)² of themselves. So are the push of the surface and the friction
//! that it allows: at long steps a block slides below the critical slope. Such a method therefore
//! lets this law follow every kick. A particle on a surface that the kick presses it to loses its
//! speed into it, and of its slip as much as Coulomb's law allows. A particle that lies does not
//! sink, and forces are evaluated where it lies. (RATTLE projects velocities for the same reason:
//! Andersen, 1983.)

mod corner;
mod curved;

use super::found::{Found, Places};
use super::law::{Contacts, rub};
use crate::columns::threads::{Split, merge_shares, split_singles};
use crate::columns::{LANES, RECORD, load, store};
use crate::number::{Real, Vector, at_level};
use crate::obstacles::solid::lanes;
use crate::obstacles::{ContactLaw, Obstacles, Placed, PlaneColumn};
use crate::pack::{Number, Pack, dot, each, splat, zip};
use core::ops::Add;
use corner::settle_in_corner;
use curved::settle_on_curved;
use fearless_simd::{Level, Simd, SimdMask};

/// A state that has just been kicked: v' = v + a t.
#[derive(Debug)]
pub(crate) struct Kicked<'a, R> {
    /// Masses, a number for each slot.
    pub(crate) masses: &'a [R],
    pub(crate) places: Places<'a, R>,
    /// Their contacts at these places.
    pub(crate) found: Found<'a>,
    /// The velocities v'.
    pub(crate) velocities: &'a mut [R],
    /// The accelerations a.
    pub(crate) accelerations: &'a [R],
    pub(crate) kick: Kick<R>,
}

/// A kick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kick<R> {
    /// Duration, seconds.
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
    /// It is over: a particle on a surface now was on it before.
    Behind,
    /// There is none.
    Absent,
}

impl<R: Real> Split for Kicked<'_, R> {
    fn numbers(&self) -> usize {
        self.places.positions.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let (low_masses, masses) = split_singles(self.masses, numbers);
        let (low_places, places) = self.places.split(numbers);
        let (low_found, found) = self.found.split(numbers);
        let (low_velocities, velocities) = self.velocities.split_at_mut(numbers);
        let (low_accelerations, accelerations) = self.accelerations.split_at(numbers);
        let low = Kicked {
            masses: low_masses,
            places: low_places,
            found: low_found,
            velocities: low_velocities,
            accelerations: low_accelerations,
            kick: self.kick,
        };
        (low, Kicked { masses, places, found, velocities, accelerations, ..self })
    }
}

/// Holds the particles that lie on an obstacle after a kick.
pub(crate) fn settle<R: Real>(
    level: Level,
    obstacles: &Obstacles<R>,
    kicked: Kicked<'_, R>,
) -> Contacts {
    let settle =
        |kicked: Kicked<'_, R>| at_level!(level, simd => settle_records(simd, obstacles, kicked));
    merge_shares(kicked, &settle, &Contacts::add)
}

#[inline(always)]
fn settle_records<S: Simd, R: Real>(
    simd: S,
    obstacles: &Obstacles<R>,
    mut kicked: Kicked<'_, R>,
) -> Contacts {
    let mut contacts = Contacts::default();
    let (records, time, found) = (kicked.places.records().len(), kicked.kick.time, kicked.found);
    let alone_on = |index| {
        let with = move |record| (record, found.alone_on(record, index));
        (0..records).map(with).filter(|&(_, on)| on != 0)
    };
    for (index, plane) in obstacles.planes.iter().enumerate() {
        for which in alone_on(index) {
            settle_on_plane(simd, plane, &mut kicked, which, &mut contacts);
        }
    }
    let mut index = obstacles.planes.len();
    for solid in &obstacles.solids {
        let placed = Placed::new(solid, time);
        let moved = match kicked.kick.drift {
            Drift::Ahead => Placed::new(solid, time + kicked.kick.substep.to_f64()),
            Drift::Behind | Drift::Absent => placed,
        };
        for which in alone_on(index) {
            settle_on_curved((&placed, &moved), &mut kicked, which, &mut contacts);
        }
        index += 1;
    }
    for (_, own) in &obstacles.own {
        let own = own.of::<R>();
        for which in alone_on(index) {
            settle_on_curved((own, own), &mut kicked, which, &mut contacts);
        }
        index += 1;
    }
    for record in 0..records {
        for lane in lanes(found.on_several(record)) {
            settle_in_corner(obstacles, &mut kicked, (record, lane), &mut contacts);
        }
    }
    contacts
}

/// Holds the particles of a record that lie on a plane alone, a bit for each.
#[inline(always)]
fn settle_on_plane<S: Simd, R: Real>(
    simd: S,
    plane: &PlaneColumn<R>,
    kicked: &mut Kicked<'_, R>,
    (record, on): (usize, u32),
    contacts: &mut Contacts,
) {
    // A plane does not bend away from a drift.
    let kick = Kick { drift: Drift::Absent, ..kicked.kick.splat(simd) };
    let (law, normal) = (kick.law(plane.law.splat(simd)), splat(simd, plane.normal.components()));
    let (at, mut lie, mut taken) = (record * RECORD, 0, [R::ZERO; LANES]);
    for part in (0..LANES).step_by(Pack::<S, R>::LEN) {
        let v = load(simd, &kicked.velocities[at..], part);
        let a = load(simd, &kicked.accelerations[at..], part);
        let settled = kick.settle(&law, normal, (v, a), kick.length.zero());
        let lies = Pack::<S, R>::mask(simd, u64::from(on >> part)) & settled.lies;
        let v = zip(settled.velocity, v, |settled, v| Pack::select(lies, settled, v));
        store(v, &mut kicked.velocities[at..], part);
        settled.taken.store_slice(&mut taken[part..][..Pack::<S, R>::LEN]);
        lie |= (lies.to_bitmask() as u32) << part;
    }
    for lane in lanes(lie) {
        *contacts += Contacts::one((taken[lane] * kicked.masses[record * LANES + lane]).to_f64());
    }
}

/// Speed away from a surface below which a particle has not left, as a part of the speed that the
/// pull makes up within two substeps. Without it ever shorter hops would not end.
const HOP: f64 = 0.01;

/// Returns whether a particle on a surface lay there, by its velocity and the part of it along the
/// normal. It did not leave, and came so slowly that a bounce would be over within two substeps, as
/// in [`super::law::keeps`]. The limit is that of such a speed, negative.
#[inline(always)]
fn lay<N: Number>(law: &ContactLaw<N>, speed: N, limit: N, velocity: [N; 3]) -> N::Mask {
    let of = |value| speed.splat(value);
    let rounding = of(N::Scalar::EPSILON * N::Scalar::of(8.0)) * dot(velocity, velocity).sqrt();
    let stayed = speed.is_at_most(rounding - limit * of(N::Scalar::of(HOP)));
    stayed & (law.restitution.is_at_most(speed.zero()) | limit.is_less(speed))
}

/// The velocity along a surface that friction leaves at a push, and the reciprocal of the slip, 0
/// where it holds.
#[inline(always)]
fn slowed<N: Number>(law: &ContactLaw<N>, n: [N; 3], v: [N; 3], push: N) -> ([N; 3], N) {
    let speed = dot(n, v);
    let along: [N; 3] = each(|axis| v[axis] - n[axis] * speed);
    let (kept, per_slip) = rub(law, dot(along, along).sqrt(), push);
    (each(|axis| along[axis] * kept), per_slip)
}

/// A velocity after the law.
pub(crate) struct Settled<N: Number> {
    /// Whether the particle lies, if it is on the surface: the law is for no other.
    pub(crate) lies: N::Mask,
    /// Along the surface.
    pub(crate) velocity: [N; 3],
    /// Energy dissipated per mass, joules per kilogram.
    taken: N,
}

impl<R: Real> Kick<R> {
    /// As many as a register holds.
    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S) -> Kick<Pack<S, R>> {
        let Kick { time, loses, drift, .. } = *self;
        let [length, substep] = [Pack::new(simd, self.length), Pack::new(simd, self.substep)];
        Kick { length, substep, time, loses, drift }
    }
}

impl<N: Number> Kick<N> {
    pub(crate) fn law(&self, law: ContactLaw<N>) -> ContactLaw<N> {
        if self.loses { law } else { ContactLaw { loss: law.loss.zero(), ..law } }
    }

    /// Holds a particle on a surface with this normal, at a velocity after the kick and with the
    /// acceleration of the kick, as seen from the surface.
    ///
    /// It lies where the kick presses it to the surface and it lay there before, see [`lay`]. A
    /// surface that holds it takes the energy of its motion before the kick. A surface that it
    /// slides on takes the work of friction: force times mean velocity.
    ///
    /// It goes on at the speed `bend` along the normal, 0 on a plane: see [`bend`].
    #[inline(always)]
    pub(crate) fn settle(
        &self,
        law: &ContactLaw<N>,
        n: [N; 3],
        (v, a): ([N; 3], [N; 3]),
        bend: N,
    ) -> Settled<N> {
        let (speed, pull, zero) = (dot(n, v), dot(n, a), bend.zero());
        let before = speed - pull * self.length;
        let limit = (self.substep + self.substep) * pull;
        let was = each(|axis| v[axis] - a[axis] * self.length);
        let mut lies = speed.is_less(bend) & pull.is_less(zero);
        if self.drift != Drift::Behind {
            lies = lies & lay(law, before, limit, was);
        }
        let (velocity, per_slip) = slowed(law, n, v, bend - speed);
        let held = per_slip.is_at_most(zero);
        let mut lost = [zero; 3];
        // No closure: it would not be compiled for the instructions of the caller.
        for axis in 0..3 {
            let along = v[axis] - n[axis] * speed;
            let slipped = along - (a[axis] - n[axis] * pull) * self.length;
            // A loss comes with the first of two kicks alone: the kick's work on the way that it
            // saves is in no second one.
            let saved = N::select(law.loss.is_at_most(zero), zero, along - slipped);
            let slowed = (along - velocity[axis]) * (slipped + velocity[axis] - saved);
            lost[axis] = N::select(held, slipped * slipped, slowed);
        }
        let lost = lost[0] + lost[1] + lost[2];
        // The bend of the surface in a drift is the same motion before it and after it.
        let stopped = if self.drift == Drift::Behind { zero } else { before * before };
        Settled { lies, velocity, taken: (stopped + lost).half() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::lanes::{Law, check};

    struct Resting;

    impl Law<15, 10> for Resting {
        fn of<N: Number>(numbers: [N; 15]) -> [N; 10] {
            let [n, v, a] = [0, 3, 6].map(|at| [numbers[at], numbers[at + 1], numbers[at + 2]]);
            let [length, substep, restitution, friction, loss] =
                [9, 10, 11, 12, 13].map(|at| numbers[at].abs());
            let law = ContactLaw { restitution, friction, loss };
            let mut all = [length; 10];
            for (drift, all) in
                [Drift::Ahead, Drift::Behind].into_iter().zip(all.as_chunks_mut::<5>().0)
            {
                let kick = Kick { length, substep, time: 0.0, loses: true, drift };
                let settled = kick.settle(&kick.law(law), n, (v, a), numbers[14]);
                all[..3].copy_from_slice(&settled.velocity);
                all[3] = settled.taken;
                all[4] = N::select(settled.lies, length.one(), length.zero());
            }
            all
        }
    }

    #[test]
    fn particles_that_rest_together_have_the_bits_of_each() {
        check::<Resting, 15, 10>();
    }
}
