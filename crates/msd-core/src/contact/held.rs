//! A particle that several surfaces hold at a time.
//!
//! Surfaces push and never pull, and Coulomb's law limits the impulse of each along itself by its
//! push. Stopping a particle surface by surface is wrong. Where two meet at an obtuse angle, the
//! second gives the velocity that it takes a part away from the first, and throws a particle in a
//! groove out of it. So pushes are sums that the next surface may lower again. Those without
//! friction are found exactly ([`Facets`]), and friction in sweeps from there (Gauss-Seidel with
//! accumulated impulses: Moreau, 1988; Jean, 1999).

use super::law::coulomb;
use crate::number::{Real, Vector};
use crate::obstacles::ContactLaw;

/// Surfaces that hold one particle at most; three independent ones leave it nowhere to go.
pub(crate) const MOST: usize = 4;

/// A surface that holds a particle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Limit<R: Real> {
    /// Direction out of the obstacle, length one.
    pub(crate) normal: R::Vec3,
    /// Velocity of the surface, metres per second.
    pub(crate) surface: R::Vec3,
    /// The least speed off the surface that it allows, metres per second.
    pub(crate) least: R,
    /// Restitution and friction.
    pub(crate) law: ContactLaw<R>,
}

/// The surfaces that hold a particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits<R: Real> {
    rows: [Limit<R>; MOST],
    count: usize,
}

/// A particle that surfaces hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopped<R: Real> {
    /// Metres per second.
    pub(crate) velocity: R::Vec3,
    /// The push of each surface by mass, metres per second.
    pub(crate) pushes: [R; MOST],
    /// Work of the surfaces that move by mass, joules per kilogram.
    pub(crate) driven: R,
    /// Whether it moves along with all surfaces.
    pub(crate) sticks: bool,
}

/// Sweeps over the surfaces until friction has settled, at most. With one velocity of all surfaces
/// two are exact; a surface that passes by another leaves the square of a coefficient of friction.
const SWEEPS: usize = 64;

/// Roundings of a velocity below which its rest counts as none.
const ROUNDINGS: f64 = 64.0;

impl<R: Real> Default for Limits<R> {
    fn default() -> Self {
        Limits { rows: [Limit::default(); MOST], count: 0 }
    }
}

impl<R: Real> Limits<R> {
    pub(crate) fn rows(&self) -> &[Limit<R>] {
        &self.rows[..self.count]
    }

    pub(crate) fn rows_mut(&mut self) -> &mut [Limit<R>] {
        &mut self.rows[..self.count]
    }

    /// Adds a surface; one beyond the most is left out.
    pub(crate) fn push(&mut self, row: Limit<R>) {
        if self.count < MOST {
            self.rows[self.count] = row;
            self.count += 1;
        }
    }

    /// The velocity that the surfaces leave a particle, metres per second.
    pub(crate) fn hold(&self, velocity: R::Vec3) -> Stopped<R> {
        let (mut v, mut pushes) = self.push_out(velocity);
        let mut rubs = [R::Vec3::ZERO; MOST];
        self.rub(&mut v, &mut pushes, &mut rubs);
        let mut driven = R::ZERO;
        for ((row, push), rub) in self.rows().iter().zip(pushes).zip(&mut rubs) {
            if R::ZERO < push && row.law.loss != R::ZERO {
                let lost = row.slip(v) * row.law.loss;
                (v, *rub) = (v - lost, *rub - lost);
            }
            driven += (row.normal * push + *rub).dot(row.surface);
        }
        let carried = self.rows[0].surface;
        let same = self.rows().iter().all(|row| row.surface == carried && row.least == R::ZERO);
        let (left, before) = (v - carried, velocity - carried);
        let rounding = R::EPSILON * R::of(ROUNDINGS);
        let stops = same && left.dot(left) <= rounding * rounding * before.dot(before);
        Stopped { velocity: if stops { carried } else { v }, pushes, driven, sticks: stops }
    }

    /// The nearest velocity that the surfaces allow without friction, and their pushes.
    ///
    /// It is that of the surfaces which push: of one, two or three, no others would be let in by
    /// it. Where rounding or a wedge without room leaves no such set it is that of the surfaces.
    pub(crate) fn push_out(&self, velocity: R::Vec3) -> (R::Vec3, [R; MOST]) {
        let size = self.rows().iter().fold(velocity.extent(), |size, row| {
            size.max(row.surface.extent()).max(row.least.abs())
        });
        let noise = size * R::EPSILON * R::of(ROUNDINGS);
        let allows = |v: R::Vec3| self.rows().iter().all(|row| -noise <= row.speed(v) - row.least);
        if allows(velocity) {
            return (velocity, [R::ZERO; MOST]);
        }
        for number in 1..=3 {
            for set in (1u32..1 << self.count).filter(|set| set.count_ones() == number) {
                let Some((v, pushes)) = self.push_out_of(set, velocity) else { continue };
                if allows(v) && pushes.iter().all(|&push| -noise <= push) {
                    return (v, pushes.map(|push| push.max(R::ZERO)));
                }
            }
        }
        (self.rows[0].surface, [R::ZERO; MOST])
    }

    /// The velocity at which a particle is at its least speed off each surface of a set, a bit for
    /// each, and their pushes. None where their normals depend on each other.
    fn push_out_of(&self, set: u32, velocity: R::Vec3) -> Option<(R::Vec3, [R; MOST])> {
        let mut corner = Facets::default();
        let mut v = velocity;
        for row in self.of(set) {
            let face = corner.add(row.normal)?;
            v += face.axis * ((row.least - row.speed(v)) / face.slope);
        }
        let (mut pushes, mut given) = ([R::ZERO; MOST], corner.pushes(v - velocity).0.into_iter());
        for (number, push) in pushes.iter_mut().enumerate() {
            if set >> number & 1 != 0 {
                *push = given.next().unwrap_or(R::ZERO);
            }
        }
        Some((v, pushes))
    }

    /// The pushes, or pulls, by which a particle has the least speed off each of the surfaces; none
    /// where their normals depend on each other.
    pub(crate) fn pull_to(&self, velocity: R::Vec3) -> [R; MOST] {
        let all = (1 << self.count) - 1;
        self.push_out_of(all, velocity).map_or([R::ZERO; MOST], |(_, pushes)| pushes)
    }

    fn of(&self, set: u32) -> impl Iterator<Item = &Limit<R>> {
        self.rows()
            .iter()
            .enumerate()
            .filter(move |(row, _)| set >> row & 1 != 0)
            .map(|(_, row)| row)
    }

    /// Lets friction act, from the pushes without it.
    fn rub(&self, v: &mut R::Vec3, pushes: &mut [R; MOST], rubs: &mut [R::Vec3; MOST]) {
        for _ in 0..SWEEPS {
            let mut largest = R::ZERO;
            for ((row, push), rub) in self.rows().iter().zip(&mut *pushes).zip(&mut *rubs) {
                let wanted = *rub - row.slip(*v);
                let most = row.law.friction * *push;
                let (left, _) = coulomb(wanted.dot(wanted).sqrt(), most);
                let after = wanted * (R::ONE - left);
                let pushed = (*push + row.least - row.speed(*v + after - *rub)).max(R::ZERO);
                let change = (after - *rub) + row.normal * (pushed - *push);
                (*v, *rub, *push) = (*v + change, after, pushed);
                largest = largest.max(change.extent());
            }
            if largest <= v.extent() * R::EPSILON {
                break;
            }
        }
    }
}

impl<R: Real> Limit<R> {
    /// The speed off the surface, metres per second.
    fn speed(&self, velocity: R::Vec3) -> R {
        self.normal.dot(velocity - self.surface)
    }

    /// The velocity along the surface, as seen from it, metres per second.
    fn slip(&self, velocity: R::Vec3) -> R::Vec3 {
        velocity - self.surface - self.normal * self.speed(velocity)
    }
}

/// A face of a corner.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facet<R: Real> {
    pub(crate) normal: R::Vec3,
    /// The normal made orthogonal to those of the faces before, of length one.
    pub(crate) axis: R::Vec3,
    /// The part of the normal along it.
    pub(crate) slope: R,
}

/// A face, an edge of two or a corner of three, with axes of their own (Gram and Schmidt): an
/// impulse along the axis of one leaves those before unchanged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets<R: Real> {
    faces: [Facet<R>; 3],
    count: usize,
}

impl<R: Real> Default for Facets<R> {
    fn default() -> Self {
        Facets { faces: [Facet::default(); 3], count: 0 }
    }
}

impl<R: Real> Facets<R> {
    pub(crate) fn faces(&self) -> &[Facet<R>] {
        &self.faces[..self.count]
    }

    /// Adds a face unless there are three or its normal is a combination of those there.
    pub(crate) fn add(&mut self, normal: R::Vec3) -> Option<Facet<R>> {
        let rest = self.remove_axes(normal);
        let slope = rest.dot(rest).sqrt();
        let is_new = self.count < 3 && R::of(1e-3) < slope;
        is_new.then(|| {
            let face = Facet { normal, axis: rest * (R::ONE / slope), slope };
            self.faces[self.count] = face;
            self.count += 1;
            face
        })
    }

    /// The part of a vector along the faces.
    pub(crate) fn free(&self, vector: R::Vec3) -> R::Vec3 {
        if self.count == 3 { R::Vec3::ZERO } else { self.remove_axes(vector) }
    }

    fn remove_axes(&self, vector: R::Vec3) -> R::Vec3 {
        self.faces().iter().fold(vector, |rest, face| rest - face.axis * face.axis.dot(rest))
    }

    /// The pushes of the faces along their normals that make up an impulse, and the rest, along the
    /// faces.
    pub(crate) fn pushes(&self, impulse: R::Vec3) -> ([R; 3], R::Vec3) {
        let (mut pushes, mut rest) = ([R::ZERO; 3], impulse);
        // Backwards: the last axis belongs to the last normal alone.
        for (face, push) in self.faces().iter().zip(&mut pushes).rev() {
            *push = rest.dot(face.axis) / face.slope;
            rest -= face.normal * *push;
        }
        (pushes, rest)
    }
}
