//! The positions and velocities of particles that are named one by one, transposed: points become
//! columns, four by four numbers at a time.
#![allow(unsafe_code)]

use super::layout::POINT;
use crate::columns::{LANES, RECORD};
use crate::number::Real;
use fearless_simd::Level;

/// A record of positions and one of velocities.
pub(crate) const GATHERED: usize = 2 * RECORD;

/// Bytes of points that the near caches hold beside what a sweep streams through them.
const NEAR_BYTES: usize = 1 << 19;

/// Rows between what is asked for and what is read: as long as memory takes to answer.
const AHEAD: usize = 16;

/// Writes the positions and velocities of the particles that rows name, record by record.
#[inline(always)]
pub(crate) fn gather_rows<R: Real>(
    level: Level,
    points: &[R],
    others: &[[u32; LANES]],
    rows: core::ops::Range<usize>,
    gathered: &mut [R],
) {
    let is_far = NEAR_BYTES < size_of_val(points);
    for (row, columns) in rows.zip(gathered.as_chunks_mut::<GATHERED>().0) {
        if let (true, Some(later)) = (is_far, others.get(row + AHEAD)) {
            later.iter().for_each(|&other| prefetch(points, other as usize));
        }
        R::gather(level, points, &others[row], columns);
    }
}

/// Asks for what will be read soon.
#[inline(always)]
fn prefetch<R>(points: &[R], at: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = points.as_ptr().wrapping_add(at).cast();
        // SAFETY: every processor of this kind has the instruction, and any address will do.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (points, at);
}

/// Gathers one by one, for any instructions.
#[inline(always)]
fn gather_plain<R: Real>(points: &[R], others: &[u32; LANES], columns: &mut [R; GATHERED]) {
    for (lane, &other) in others.iter().enumerate() {
        let point: &[R; POINT] = points[other as usize..].first_chunk().expect("a point");
        for axis in 0..3 {
            columns[axis * LANES + lane] = point[axis];
            columns[RECORD + axis * LANES + lane] = point[4 + axis];
        }
    }
}

/// Gathers in single precision.
#[inline(always)]
pub(crate) fn gather_single(
    level: Level,
    points: &[f32],
    others: &[u32; LANES],
    columns: &mut [f32; GATHERED],
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = level.as_avx512() {
        x86::sixteen_single(token, points, others, columns);
    } else if let Some(token) = level.as_avx2() {
        for first in (0..LANES).step_by(8) {
            x86::eight_single(token, points, others, first, columns);
        }
    } else if let Some(token) = level.as_sse2() {
        for first in (0..LANES).step_by(4) {
            x86::four_single(token, points, others, first, columns);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = level;
        gather_plain(points, others, columns);
    }
}

/// Gathers in double precision.
#[inline(always)]
pub(crate) fn gather_double(
    level: Level,
    points: &[f64],
    others: &[u32; LANES],
    columns: &mut [f64; GATHERED],
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(token) = level.as_avx512() {
        for first in (0..LANES).step_by(8) {
            x86::eight_double(token, points, others, first, columns);
        }
        return;
    } else if let Some(token) = level.as_avx2() {
        for first in (0..LANES).step_by(4) {
            x86::four_double(token, points, others, first, columns);
        }
        return;
    }
    let _ = level;
    gather_plain(points, others, columns);
}

/// Transposes on x86-64. All loads are of slices that are checked, and all else is in registers.
#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{GATHERED, LANES, POINT, RECORD};
    use core::arch::x86_64::*;
    use fearless_simd::{SimdBase, SimdInto, f32x4, f32x8, f64x4, kernel};

    kernel!(
        #[inline(always)]
        pub(super) fn sixteen_single(
            token: Avx512,
            points: &[f32],
            others: &[u32; LANES],
            columns: &mut [f32; GATHERED],
        ) {
            let point = |lane: usize| -> __m256 {
                let at = others[lane] as usize;
                f32x8::from_slice(token, &points[at..at + POINT]).into()
            };
            // Eight points: blocks of their positions, then of their velocities, by component.
            let eight = |first: usize| -> [__m512; 3] {
                let pair = |lane: usize| {
                    let low = _mm512_castps256_ps512(point(first + lane));
                    _mm512_insertf32x8::<1>(low, point(first + lane + 4))
                };
                let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
                let (xy_ab, xy_cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
                let (z_ab, z_cd) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
                [
                    _mm512_shuffle_ps::<0b01_00_01_00>(xy_ab, xy_cd),
                    _mm512_shuffle_ps::<0b11_10_11_10>(xy_ab, xy_cd),
                    _mm512_shuffle_ps::<0b01_00_01_00>(z_ab, z_cd),
                ]
            };
            let (low, high) = (eight(0), eight(8));
            for axis in 0..3 {
                let positions = _mm512_shuffle_f32x4::<0b10_00_10_00>(low[axis], high[axis]);
                let velocities = _mm512_shuffle_f32x4::<0b11_01_11_01>(low[axis], high[axis]);
                let [positions, velocities]: [fearless_simd::f32x16<_>; 2] =
                    [positions.simd_into(token), velocities.simd_into(token)];
                let at = axis * LANES;
                positions.store_slice(&mut columns[at..at + LANES]);
                velocities.store_slice(&mut columns[RECORD + at..RECORD + at + LANES]);
            }
        }
    );

    kernel!(
        #[inline(always)]
        pub(super) fn eight_single(
            token: Avx2,
            points: &[f32],
            others: &[u32; LANES],
            first: usize,
            columns: &mut [f32; GATHERED],
        ) {
            let point = |lane: usize| -> __m256 {
                let at = others[lane] as usize;
                f32x8::from_slice(token, &points[at..at + POINT]).into()
            };
            let four = |lane: usize| -> [__m256; 3] {
                let (a, b, c, d) = (point(lane), point(lane + 1), point(lane + 2), point(lane + 3));
                let (xy_ab, xy_cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                let (z_ab, z_cd) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(xy_ab, xy_cd),
                    _mm256_shuffle_ps::<0b11_10_11_10>(xy_ab, xy_cd),
                    _mm256_shuffle_ps::<0b01_00_01_00>(z_ab, z_cd),
                ]
            };
            let (low, high) = (four(first), four(first + 4));
            for axis in 0..3 {
                let positions = _mm256_permute2f128_ps::<0x20>(low[axis], high[axis]);
                let velocities = _mm256_permute2f128_ps::<0x31>(low[axis], high[axis]);
                let [positions, velocities]: [f32x8<_>; 2] =
                    [positions.simd_into(token), velocities.simd_into(token)];
                let at = axis * LANES + first;
                positions.store_slice(&mut columns[at..at + 8]);
                velocities.store_slice(&mut columns[RECORD + at..RECORD + at + 8]);
            }
        }
    );

    kernel!(
        #[inline(always)]
        pub(super) fn four_single(
            token: Sse2,
            points: &[f32],
            others: &[u32; LANES],
            first: usize,
            columns: &mut [f32; GATHERED],
        ) {
            for half in 0..2 {
                let row = |lane: usize| -> __m128 {
                    let at = others[first + lane] as usize + 4 * half;
                    f32x4::from_slice(token, &points[at..at + 4]).into()
                };
                let (a, b, c, d) = (row(0), row(1), row(2), row(3));
                let (xy_ab, xy_cd) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
                let (z_ab, z_cd) = (_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
                let rows = [
                    _mm_movelh_ps(xy_ab, xy_cd),
                    _mm_movehl_ps(xy_cd, xy_ab),
                    _mm_movelh_ps(z_ab, z_cd),
                ];
                for (axis, row) in rows.into_iter().enumerate() {
                    let row: f32x4<_> = row.simd_into(token);
                    let at = half * RECORD + axis * LANES + first;
                    row.store_slice(&mut columns[at..at + 4]);
                }
            }
        }
    );

    kernel!(
        #[inline(always)]
        pub(super) fn four_double(
            token: Avx2,
            points: &[f64],
            others: &[u32; LANES],
            first: usize,
            columns: &mut [f64; GATHERED],
        ) {
            for half in 0..2 {
                let row = |lane: usize| -> __m256d {
                    let at = others[first + lane] as usize + 4 * half;
                    f64x4::from_slice(token, &points[at..at + 4]).into()
                };
                let (a, b, c, d) = (row(0), row(1), row(2), row(3));
                let (xz_ab, xz_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
                let (y_ab, y_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
                let rows = [
                    _mm256_permute2f128_pd::<0x20>(xz_ab, xz_cd),
                    _mm256_permute2f128_pd::<0x20>(y_ab, y_cd),
                    _mm256_permute2f128_pd::<0x31>(xz_ab, xz_cd),
                ];
                for (axis, row) in rows.into_iter().enumerate() {
                    let row: f64x4<_> = row.simd_into(token);
                    let at = half * RECORD + axis * LANES + first;
                    row.store_slice(&mut columns[at..at + 4]);
                }
            }
        }
    );

    kernel!(
        #[inline(always)]
        pub(super) fn eight_double(
            token: Avx512,
            points: &[f64],
            others: &[u32; LANES],
            first: usize,
            columns: &mut [f64; GATHERED],
        ) {
            let point = |lane: usize| -> __m512d {
                let at = others[lane] as usize;
                fearless_simd::f64x8::from_slice(token, &points[at..at + POINT]).into()
            };
            // The first blocks of two numbers of each of four, the second, the third, the fourth.
            let in_turn = |a: __m512d, b: __m512d, c: __m512d, d: __m512d| {
                let even_ab = _mm512_shuffle_f64x2::<0b10_00_10_00>(a, b);
                let even_cd = _mm512_shuffle_f64x2::<0b10_00_10_00>(c, d);
                let odd_ab = _mm512_shuffle_f64x2::<0b11_01_11_01>(a, b);
                let odd_cd = _mm512_shuffle_f64x2::<0b11_01_11_01>(c, d);
                [
                    _mm512_shuffle_f64x2::<0b10_00_10_00>(even_ab, even_cd),
                    _mm512_shuffle_f64x2::<0b10_00_10_00>(odd_ab, odd_cd),
                    _mm512_shuffle_f64x2::<0b11_01_11_01>(even_ab, even_cd),
                    _mm512_shuffle_f64x2::<0b11_01_11_01>(odd_ab, odd_cd),
                ]
            };
            let (a, b, c, d) = (point(first), point(first + 1), point(first + 2), point(first + 3));
            let (e, f) = (point(first + 4), point(first + 5));
            let (g, h) = (point(first + 6), point(first + 7));
            let [x, z, vx, vz] = in_turn(
                _mm512_unpacklo_pd(a, b),
                _mm512_unpacklo_pd(c, d),
                _mm512_unpacklo_pd(e, f),
                _mm512_unpacklo_pd(g, h),
            );
            let [y, _, vy, _] = in_turn(
                _mm512_unpackhi_pd(a, b),
                _mm512_unpackhi_pd(c, d),
                _mm512_unpackhi_pd(e, f),
                _mm512_unpackhi_pd(g, h),
            );
            for (column, row) in [x, y, z, vx, vy, vz].into_iter().enumerate() {
                let row: fearless_simd::f64x8<_> = row.simd_into(token);
                let at = column * LANES + first;
                row.store_slice(&mut columns[at..at + 8]);
            }
        }
    );
}
