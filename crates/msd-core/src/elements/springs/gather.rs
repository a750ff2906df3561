//! Transposes between points, the numbers of a particle side by side, and the columns of a record.
//!
//! The springs of unstructured blocks name their other ends one by one. These are gathered from
//! points, and the forces on them are summed in points.
#![allow(unsafe_code)]

use crate::number::{GATHERED, LANES, POINT, QUAD, RECORD, Transpose};
use fearless_simd::{Simd, SimdBase, SimdInterleaved, f32x4, f64x2};

/// Bytes of points that the near caches hold beside the data that a sweep streams through them.
pub(crate) const NEAR_BYTES: usize = 1 << 19;

/// Distance of the prefetch, rows times bytes of a number: enough to cover the latency of memory,
/// and no more than the nearest cache holds.
#[cfg(target_arch = "x86_64")]
const AHEAD: usize = 64;

macro_rules! impl_transpose {
    ($scalar:ident, $block:ident, $lanes:literal, $gather_x86:path) => {
        impl Transpose for $scalar {
            #[inline(always)]
            fn gather<S: Simd>(
                simd: S,
                points: &[[Self; POINT]],
                others: &[u32],
                columns: &mut [Self; GATHERED],
            ) {
                #[cfg(target_arch = "x86_64")]
                if $gather_x86(simd.level(), points, others, columns) {
                    return;
                }
                for (block, others) in others.as_chunks::<$lanes>().0.iter().enumerate() {
                    for half in 0..2 {
                        let mut quads = [0.0; QUAD * $lanes];
                        for (quad, &other) in quads.as_chunks_mut().0.iter_mut().zip(others) {
                            let point: &[[Self; QUAD]] = points[other as usize].as_chunks().0;
                            *quad = point[half];
                        }
                        let [x, y, z, _] = $block::<S>::load_four_interleaved(simd, &quads);
                        for (axis, column) in [x, y, z].into_iter().enumerate() {
                            let at = half * RECORD + axis * LANES + block * $lanes;
                            column.store_slice(&mut columns[at..at + $lanes]);
                        }
                    }
                }
            }
            #[inline(always)]
            fn to_quads<S: Simd>(simd: S, columns: &[Self; RECORD]) -> [[Self; QUAD]; LANES] {
                let mut quads = [[0.0; QUAD]; LANES];
                for (block, quads) in quads.as_chunks_mut::<$lanes>().0.iter_mut().enumerate() {
                    let column = |axis| {
                        let at = axis * LANES + block * $lanes;
                        $block::<S>::from_slice(simd, &columns[at..at + $lanes])
                    };
                    let vectors = [column(0), column(1), column(2), $block::splat(simd, 0.0)];
                    $block::store_four_interleaved(vectors, quads.as_flattened_mut());
                }
                quads
            }
            #[inline(always)]
            fn to_columns<S: Simd>(simd: S, quads: &[[Self; QUAD]; LANES]) -> [Self; RECORD] {
                let mut columns = [0.0; RECORD];
                for (block, quads) in quads.as_chunks::<$lanes>().0.iter().enumerate() {
                    let [x, y, z, _] =
                        $block::<S>::load_four_interleaved(simd, quads.as_flattened());
                    for (axis, column) in [x, y, z].into_iter().enumerate() {
                        let at = axis * LANES + block * $lanes;
                        column.store_slice(&mut columns[at..at + $lanes]);
                    }
                }
                columns
            }
        }
    };
}

impl_transpose!(f32, f32x4, 4, x86::gather_single);
impl_transpose!(f64, f64x2, 2, x86::gather_double);

/// Prefetches the particles of a later row, where the near caches do not hold all.
#[inline(always)]
pub(crate) fn prefetch<R>(
    is_far: bool,
    tables: (&[[R; POINT]], &[[R; QUAD]]),
    others: &[[u32; LANES]],
    row: usize,
) {
    #[cfg(target_arch = "x86_64")]
    if let (true, Some(later)) = (is_far, others.get(row + AHEAD / size_of::<R>())) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        for &other in later {
            // As seen from this row, near enough.
            let point = tables.0.as_ptr().wrapping_add(other as usize).cast();
            let quad = tables.1.as_ptr().wrapping_add(other as usize).cast();
            for address in [point, quad] {
                // SAFETY: every x86-64 processor has this instruction, and any address will do.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(address) };
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (is_far, tables, others, row);
}

/// Prefetches all of some numbers that start on a cache line.
#[inline(always)]
pub(crate) fn prefetch_all<R>(numbers: &[R]) {
    #[cfg(target_arch = "x86_64")]
    for line in (0..size_of_val(numbers)).step_by(64) {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 processor has this instruction, and any address will do.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(numbers.as_ptr().cast::<i8>().wrapping_add(line)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = numbers;
}

/// Transposes of whole registers on x86-64. All loads are from checked slices, and everything else
/// is in registers. The kernels are so short that the compiler puts them where they are called.
#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{GATHERED, LANES, POINT, RECORD};
    use core::arch::x86_64::*;
    use fearless_simd::{Avx2, Avx512, Level, SimdBase, SimdCombine, SimdInto};
    use fearless_simd::{f32x8, f32x16, f64x4, f64x8, kernel};

    /// Gathers in single precision, if there are registers for eight or more.
    #[inline(always)]
    pub(super) fn gather_single(
        level: Level,
        points: &[[f32; POINT]],
        others: &[u32],
        columns: &mut [f32; GATHERED],
    ) -> bool {
        if let Some(token) = level.as_avx512() {
            let point = |lane: usize| f32x8::from_slice(token, &points[others[lane] as usize]);
            let pair = |lane: usize| point(lane).combine(point(lane + 4)).into();
            let low = blocks_512(token, pair(0), pair(1), pair(2), pair(3));
            let high = blocks_512(token, pair(8), pair(9), pair(10), pair(11));
            for axis in 0..3 {
                let [positions, velocities] = halves_512(token, low[axis], high[axis]);
                let at = axis * LANES;
                positions.store_slice(&mut columns[at..at + 16]);
                velocities.store_slice(&mut columns[RECORD + at..RECORD + at + 16]);
            }
        } else if let Some(token) = level.as_avx2() {
            let point =
                |lane: usize| f32x8::from_slice(token, &points[others[lane] as usize]).into();
            let low = blocks_256(token, point(0), point(1), point(2), point(3));
            let high = blocks_256(token, point(4), point(5), point(6), point(7));
            for axis in 0..3 {
                let [positions, velocities] = halves_256(token, low[axis], high[axis]);
                let at = axis * LANES;
                positions.store_slice(&mut columns[at..at + 8]);
                velocities.store_slice(&mut columns[RECORD + at..RECORD + at + 8]);
            }
        } else {
            return false;
        }
        true
    }

    /// Gathers in double precision, if there are registers for four or more.
    #[inline(always)]
    pub(super) fn gather_double(
        level: Level,
        points: &[[f64; POINT]],
        others: &[u32],
        columns: &mut [f64; GATHERED],
    ) -> bool {
        if let Some(token) = level.as_avx512() {
            let point =
                |lane: usize| f64x8::from_slice(token, &points[others[lane] as usize]).into();
            let low = pairs_512(token, point(0), point(1), point(2), point(3));
            let high = pairs_512(token, point(4), point(5), point(6), point(7));
            for axis in 0..3 {
                let [positions, velocities] = double_halves_512(token, low[axis], high[axis]);
                let at = axis * LANES;
                positions.store_slice(&mut columns[at..at + 8]);
                velocities.store_slice(&mut columns[RECORD + at..RECORD + at + 8]);
            }
        } else if let Some(token) = level.as_avx2() {
            for half in 0..2 {
                let quad = |lane: usize| {
                    let point = &points[others[lane] as usize];
                    f64x4::from_slice(token, &point[4 * half..4 * half + 4]).into()
                };
                let rows = columns_256(token, quad(0), quad(1), quad(2), quad(3));
                for (axis, row) in rows.into_iter().enumerate() {
                    let at = half * RECORD + axis * LANES;
                    row.store_slice(&mut columns[at..at + 4]);
                }
            }
        } else {
            return false;
        }
        true
    }

    kernel!(
        /// Blocks of x, y and z of four points in each: positions and velocities in turn.
        #[inline(always)]
        fn blocks_512(token: Avx512, a: __m512, b: __m512, c: __m512, d: __m512) -> [__m512; 3] {
            let (xy_ab, xy_cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
            let (z_ab, z_cd) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
            [
                _mm512_shuffle_ps::<0b01_00_01_00>(xy_ab, xy_cd),
                _mm512_shuffle_ps::<0b11_10_11_10>(xy_ab, xy_cd),
                _mm512_shuffle_ps::<0b01_00_01_00>(z_ab, z_cd),
            ]
        }
    );
    kernel!(
        /// The even blocks of two registers, and the odd ones.
        #[inline(always)]
        fn halves_512(token: Avx512, low: __m512, high: __m512) -> [f32x16<Avx512>; 2] {
            [
                _mm512_shuffle_f32x4::<0b10_00_10_00>(low, high).simd_into(token),
                _mm512_shuffle_f32x4::<0b11_01_11_01>(low, high).simd_into(token),
            ]
        }
    );
    kernel!(
        /// Blocks of x, y and z of four points: positions, then velocities.
        #[inline(always)]
        fn blocks_256(token: Avx2, a: __m256, b: __m256, c: __m256, d: __m256) -> [__m256; 3] {
            let (xy_ab, xy_cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let (z_ab, z_cd) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(xy_ab, xy_cd),
                _mm256_shuffle_ps::<0b11_10_11_10>(xy_ab, xy_cd),
                _mm256_shuffle_ps::<0b01_00_01_00>(z_ab, z_cd),
            ]
        }
    );
    kernel!(
        /// The low halves of two registers, and the high ones.
        #[inline(always)]
        fn halves_256(token: Avx2, low: __m256, high: __m256) -> [f32x8<Avx2>; 2] {
            [
                _mm256_permute2f128_ps::<0x20>(low, high).simd_into(token),
                _mm256_permute2f128_ps::<0x31>(low, high).simd_into(token),
            ]
        }
    );
    kernel!(
        /// Columns of x, y and z of four vectors.
        #[inline(always)]
        fn columns_256(
            token: Avx2,
            a: __m256d,
            b: __m256d,
            c: __m256d,
            d: __m256d,
        ) -> [f64x4<Avx2>; 3] {
            let (x_z_ab, x_z_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
            let (y_ab, y_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
            [
                _mm256_permute2f128_pd::<0x20>(x_z_ab, x_z_cd).simd_into(token),
                _mm256_permute2f128_pd::<0x20>(y_ab, y_cd).simd_into(token),
                _mm256_permute2f128_pd::<0x31>(x_z_ab, x_z_cd).simd_into(token),
            ]
        }
    );
    kernel!(
        /// Pairs of x, y and z of four points: positions and velocities in turn.
        #[inline(always)]
        fn pairs_512(
            token: Avx512,
            a: __m512d,
            b: __m512d,
            c: __m512d,
            d: __m512d,
        ) -> [__m512d; 3] {
            let (x_z_ab, x_z_cd) = (_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
            let (y_ab, y_cd) = (_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
            [
                _mm512_shuffle_f64x2::<0b10_00_10_00>(x_z_ab, x_z_cd),
                _mm512_shuffle_f64x2::<0b10_00_10_00>(y_ab, y_cd),
                _mm512_shuffle_f64x2::<0b11_01_11_01>(x_z_ab, x_z_cd),
            ]
        }
    );
    kernel!(
        /// The even pairs of two registers, and the odd ones.
        #[inline(always)]
        fn double_halves_512(token: Avx512, low: __m512d, high: __m512d) -> [f64x8<Avx512>; 2] {
            [
                _mm512_shuffle_f64x2::<0b10_00_10_00>(low, high).simd_into(token),
                _mm512_shuffle_f64x2::<0b11_01_11_01>(low, high).simd_into(token),
            ]
        }
    );
}
