//! Passages: where a particle that moves far in a substep goes into a solid.
//!
//! A particle inside came through the surface next to it only as long as it is not beyond the
//! middle. Through a plate thinner than two ways of a substep it would be let out on the other
//! side, or be there already (tunnelling). So the way of such a particle, as seen from the solid,
//! is followed from its previous place, from gap to gap (sphere tracing: Hart, 1996).

use crate::columns::{LANES, RECORD};
use crate::number::{Real, Vector, at_level};
use crate::obstacles::Placed;
use crate::obstacles::motion::longest_way;
use crate::obstacles::solid::lane_of;
use crate::pack::dot;
use fearless_simd::Level;

/// A solid at the end of a substep, and when it started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage<'a, 's> {
    /// Simulated time, seconds.
    start: f64,
    end: &'a Placed<'s>,
    /// A way, metres, that ends before the middle; negative where the solid goes beyond that.
    short: f64,
}

/// The largest speed of particles, metres per second.
pub(crate) fn fastest<R: Real>(level: Level, velocities: &[R]) -> R {
    at_level!(level, _simd => largest_square(velocities)).sqrt()
}

#[inline(always)]
fn largest_square<R: Real>(velocities: &[R]) -> R {
    let mut largest = [R::ZERO; LANES];
    for row in velocities.as_chunks::<RECORD>().0 {
        for (lane, largest) in largest.iter_mut().enumerate() {
            let v = lane_of(row, lane);
            *largest = largest.max(dot(v, v));
        }
    }
    largest.into_iter().fold(R::ZERO, R::max)
}

/// Where a particle went in, as a plane there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entrance<R> {
    /// The direction out.
    pub(crate) normal: [R; 3],
    /// Depth of the particle below it, metres.
    pub(crate) depth: R,
}

/// Gaps that are followed at most: along a surface they get ever shorter.
const GAPS: usize = 256;

impl<'a, 's> Passage<'a, 's> {
    /// The passage of a solid in a substep of h seconds that ends at a time, seconds.
    pub(crate) fn new(end: &'a Placed<'s>, (time, h): (f64, f64)) -> Self {
        let short = end.solid.shape.thickness() * 0.5 - longest_way(end.solid, (time, h));
        Passage { start: time - h, end, short }
    }

    /// Whether the solid itself moves by more than half of its thickness in the substep.
    pub(crate) fn is_fast(&self) -> bool {
        self.short < 0.0
    }

    /// Whether a way may go beyond the middle.
    #[inline(always)]
    pub(crate) fn is_long<R: Real>(&self, way: [R; 3]) -> bool {
        let short = R::of(self.short);
        (short < R::ZERO) | (short * short < dot(way, way))
    }

    /// The particles of a record with such ways, a bit for each.
    #[inline(always)]
    pub(crate) fn long_ways<R: Real>(&self, from: &[R; RECORD], to: &[R; RECORD]) -> u32 {
        let mut bits = [0; LANES];
        for (lane, bit) in bits.iter_mut().enumerate() {
            let (from, to) = (lane_of(from, lane), lane_of(to, lane));
            let way = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
            *bit = u32::from(self.is_long(way)) << lane;
        }
        bits.iter().fold(0, |all, bit| all | bit)
    }

    /// Where a particle of some radius went in. A particle that lay on the surface and is on the
    /// same side of it did not go in: it goes along.
    pub(crate) fn entrance<R: Real>(
        &self,
        (from, to): ([R; 3], [R; 3]),
        radius: R,
    ) -> Option<Entrance<R>> {
        let shape = &self.end.solid.shape;
        let start = Placed::new(self.end.solid, self.start);
        let from = start.own::<R>(R::Vec3::from_components(from));
        let to = self.end.own::<R>(R::Vec3::from_components(to));
        let (way, radius) = (to - from, radius.to_f64());
        let length = Real::sqrt(way.dot(way));
        let gap = |part: f64| shape.gap(from + way * part) - radius;
        // In single precision a particle that lies is off by the rounding of its place.
        let noise = f64::from(f32::EPSILON) * 8.0 * from.abs().max(to.abs()).max_element();
        let lay = gap(0.0) <= noise;
        let part = if lay { 0.0 } else { first(gap, (length, noise))? };
        let normal = shape.normal(from + way * part);
        let depth = -normal.dot(way * (1.0 - part));
        let goes_along = lay && 0.0 < normal.dot(shape.normal(to));
        let is_in = !goes_along && 0.0 < depth;
        let normal = R::Vec3::of(self.end.axes * normal).components();
        is_in.then(|| Entrance { normal, depth: R::of(depth) })
    }
}

/// The part of a way of this length at which the gap falls below the noise.
fn first(gap: impl Fn(f64) -> f64, (length, noise): (f64, f64)) -> Option<f64> {
    let mut part = 0.0;
    for _ in 0..GAPS {
        let left = gap(part);
        if left <= noise {
            return Some(part);
        }
        part += left / length;
        if 1.0 < part {
            return None;
        }
    }
    None
}
