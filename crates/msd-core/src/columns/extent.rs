//! The box around vectors of a column.

use super::{LANES, RECORD, store};
use crate::number::{Real, Vector};
use crate::pack::{Number, Pack, zip};
use alloc::vec::Vec;
use fearless_simd::Simd;

/// Some particles, by the records that they are in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Records(Vec<Lanes>);

/// Where a record starts in a column of vectors, and a bit for each of its particles that counts.
#[derive(Clone, Copy, Debug)]
struct Lanes {
    first: u32,
    bits: u32,
}

/// The bits of all particles of a record.
const ALL: u32 = (1 << LANES) - 1;

impl Records {
    /// The records of particles, by where their numbers are in a column of vectors.
    pub(crate) fn new(at: impl Iterator<Item = u32>) -> Self {
        let mut at: Vec<u32> = at.collect();
        at.sort_unstable();
        let of_one = at.chunk_by(|a, b| a / RECORD as u32 == b / RECORD as u32);
        let lanes = of_one.map(|of_one| {
            let first = of_one[0] / RECORD as u32 * RECORD as u32;
            Lanes { first, bits: of_one.iter().fold(0, |bits, at| bits | 1 << (at - first)) }
        });
        Records(lanes.collect())
    }
}

/// The box around some vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent<R: Real> {
    low: R::Vec3,
    high: R::Vec3,
}

impl<R: Real> Default for Extent<R> {
    fn default() -> Self {
        let [most, least] = [R::LARGEST, -R::LARGEST].map(|x| R::Vec3::from_components([x; 3]));
        Extent { low: most, high: least }
    }
}

impl<R: Real> Extent<R> {
    /// The box around a vector of each of some particles, a part of a record at a time. `of` makes
    /// the vectors from where the record starts and from where in it the part does.
    ///
    /// In registers by name: the compiler makes such bounds of arrays one number at a time.
    #[inline(always)]
    pub(crate) fn of<S: Simd>(
        simd: S,
        records: &Records,
        of: impl Fn(usize, usize) -> [Pack<S, R>; 3],
    ) -> Self {
        let [most, least] = [R::LARGEST, -R::LARGEST].map(|x| Pack::<S, R>::new(simd, x));
        let lanes = Pack::<S, R>::LEN;
        let (mut low, mut high) = ([most; 3], [least; 3]);
        for &Lanes { first, bits } in &records.0 {
            for part in (0..LANES).step_by(lanes) {
                let here = of(first as usize, part);
                if bits == ALL {
                    low = zip(low, here, |a, b| a.min(b));
                    high = zip(high, here, |a, b| a.max(b));
                    continue;
                }
                let counts = Pack::<S, R>::mask(simd, u64::from(bits) >> part & ((1 << lanes) - 1));
                low = zip(low, here, |a, b| Pack::select(counts, a.min(b), a));
                high = zip(high, here, |a, b| Pack::select(counts, a.max(b), a));
            }
        }
        let mut bounds = [[R::ZERO; RECORD]; 2];
        store(low, &mut bounds[0], 0);
        store(high, &mut bounds[1], 0);
        let of_lanes = |side: usize, of: fn(R, R) -> R| {
            let axes = [0, 1, 2].map(|axis| &bounds[side][axis * LANES..][..lanes]);
            R::Vec3::from_components(
                axes.map(|axis| axis[1..].iter().fold(axis[0], |a, &b| of(a, b))),
            )
        };
        Extent { low: of_lanes(0, R::min), high: of_lanes(1, R::max) }
    }

    /// The box around some vectors.
    #[inline(always)]
    pub(crate) fn around(vectors: impl Iterator<Item = R::Vec3>) -> Self {
        let mut around = Extent::default();
        vectors.for_each(|vector| around.add(vector));
        around
    }

    pub(crate) fn low(&self) -> R::Vec3 {
        self.low
    }

    pub(crate) fn high(&self) -> R::Vec3 {
        self.high
    }

    pub(crate) fn middle(&self) -> R::Vec3 {
        (self.low + self.high) * R::HALF
    }

    /// The axis along which it is longest.
    pub(crate) fn longest_axis(&self) -> usize {
        let sides = (self.high - self.low).components();
        (0..3).fold(0, |longest, axis| if sides[longest] < sides[axis] { axis } else { longest })
    }

    /// Whether another box is within some distance of it along every axis.
    #[inline(always)]
    pub(crate) fn is_near(self, other: Self, distance: R) -> bool {
        self.gaps(other).into_iter().all(|gap| gap < distance)
    }

    /// The distance to another box.
    pub(crate) fn distance(self, other: Self) -> R {
        let square = |gap: R| gap.max(R::ZERO) * gap.max(R::ZERO);
        let [x, y, z] = self.gaps(other).map(square);
        (x + y + z).sqrt()
    }

    /// Distance between both along each axis; negative where they overlap.
    #[inline(always)]
    fn gaps(self, other: Self) -> [R; 3] {
        let (above, below) = (other.low - self.high, self.low - other.high);
        zip(above.components(), below.components(), R::max)
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, vector: R::Vec3) {
        *self = self.with(Extent { low: vector, high: vector });
    }

    pub(crate) fn with(self, other: Self) -> Self {
        let (low, high) = (self.low.components(), self.high.components());
        let (lower, higher) = (other.low.components(), other.high.components());
        let pick = |a: [R; 3], b: [R; 3], of: fn(R, R) -> R| {
            R::Vec3::from_components([of(a[0], b[0]), of(a[1], b[1]), of(a[2], b[2])])
        };
        Extent { low: pick(low, lower, R::min), high: pick(high, higher, R::max) }
    }

    /// The box around it and the origin.
    pub(crate) fn with_origin(mut self) -> Self {
        self.add(R::Vec3::ZERO);
        self
    }

    /// The square of its diagonal.
    pub(crate) fn diagonal(self) -> R {
        let sides = self.high - self.low;
        sides.dot(sides)
    }
}
