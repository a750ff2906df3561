//! How do records become columns, and columns records, on x86-64? By transposing blocks of four by
//! four numbers.

use core::arch::x86_64::*;

/// Transposes of blocks of four by four numbers, and rows to feed them with.
///
/// # Safety
/// The processor has AVX2, or AVX-512 where that is in the name; what is named can be read.
macro_rules! block_transposes {
    ($columns:ident, $rows:ident, $register:ident, $low:ident, $high:ident, $shuffle:ident,
     $zero:ident) => {
        /// # Safety
        /// See above.
        #[inline(always)]
        pub(super) unsafe fn $columns([a, b, c, d]: [$register; 4]) -> [$register; 3] {
            // SAFETY: the caller's promise.
            unsafe {
                let (xy_ab, xy_cd) = ($low(a, b), $low(c, d));
                let (z_ab, z_cd) = ($high(a, b), $high(c, d));
                [
                    $shuffle::<0b01_00_01_00>(xy_ab, xy_cd),
                    $shuffle::<0b11_10_11_10>(xy_ab, xy_cd),
                    $shuffle::<0b01_00_01_00>(z_ab, z_cd),
                ]
            }
        }
        /// # Safety
        /// See above.
        #[inline(always)]
        pub(super) unsafe fn $rows([x, y, z]: [$register; 3]) -> [$register; 4] {
            // SAFETY: the caller's promise.
            unsafe {
                let zero = $zero();
                let (xy_01, xy_23) = ($low(x, y), $high(x, y));
                let (z_01, z_23) = ($low(z, zero), $high(z, zero));
                [
                    $shuffle::<0b01_00_01_00>(xy_01, z_01),
                    $shuffle::<0b11_10_11_10>(xy_01, z_01),
                    $shuffle::<0b01_00_01_00>(xy_23, z_23),
                    $shuffle::<0b11_10_11_10>(xy_23, z_23),
                ]
            }
        }
    };
}

block_transposes!(
    columns_256,
    rows_256,
    __m256,
    _mm256_unpacklo_ps,
    _mm256_unpackhi_ps,
    _mm256_shuffle_ps,
    _mm256_setzero_ps
);
block_transposes!(
    columns_512,
    rows_512,
    __m512,
    _mm512_unpacklo_ps,
    _mm512_unpackhi_ps,
    _mm512_shuffle_ps,
    _mm512_setzero_ps
);

/// The first halves of records `lane` and four on.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn half_rows(records: *const f32, at: *const u32, lane: usize) -> __m256 {
    // SAFETY: the caller's promise.
    unsafe {
        let low = _mm_loadu_ps(records.add(*at.add(lane) as usize));
        let high = _mm_loadu_ps(records.add(*at.add(lane + 4) as usize));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
    }
}

/// The first halves of records `lane`, and four, eight and twelve on.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn quarter_rows(records: *const f32, at: *const u32, lane: usize) -> __m512 {
    // SAFETY: the caller's promise.
    unsafe {
        let low = _mm512_castps256_ps512(half_rows(records, at, lane));
        _mm512_insertf32x8::<1>(low, half_rows(records, at, lane + 8))
    }
}

/// Four records.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn record_rows(records: *const f32, at: *const u32) -> [__m256; 4] {
    // SAFETY: the caller's promise.
    unsafe {
        [
            _mm256_loadu_ps(records.add(*at as usize)),
            _mm256_loadu_ps(records.add(*at.add(1) as usize)),
            _mm256_loadu_ps(records.add(*at.add(2) as usize)),
            _mm256_loadu_ps(records.add(*at.add(3) as usize)),
        ]
    }
}

/// Eight records, each beside that four on.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn two_record_rows(records: *const f32, at: *const u32) -> [__m512; 4] {
    // SAFETY: the caller's promise.
    unsafe {
        let ([a, b, c, d], [e, f, g, h]) =
            (record_rows(records, at), record_rows(records, at.add(4)));
        [
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(a), e),
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(b), f),
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(c), g),
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(d), h),
        ]
    }
}

/// The halves of four records of doubles that begin at `half`, by component.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn columns_of_4(
    records: *const f64,
    at: *const u32,
    half: usize,
) -> [__m256d; 3] {
    // SAFETY: the caller's promise.
    unsafe {
        let a = _mm256_loadu_pd(records.add(*at as usize + half));
        let b = _mm256_loadu_pd(records.add(*at.add(1) as usize + half));
        let c = _mm256_loadu_pd(records.add(*at.add(2) as usize + half));
        let d = _mm256_loadu_pd(records.add(*at.add(3) as usize + half));
        let (xz_ab, xz_cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
        let (y_ab, y_cd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(xz_ab, xz_cd),
            _mm256_permute2f128_pd::<0x20>(y_ab, y_cd),
            _mm256_permute2f128_pd::<0x31>(xz_ab, xz_cd),
        ]
    }
}

/// Eight records of doubles, by component.
///
/// # Safety
/// See [`Pack::gather`].
#[inline(always)]
pub(super) unsafe fn columns_of_8(records: *const f64, at: *const u32) -> [[__m512d; 3]; 2] {
    // SAFETY: the caller's promise.
    unsafe {
        let a = _mm512_loadu_pd(records.add(*at as usize));
        let b = _mm512_loadu_pd(records.add(*at.add(1) as usize));
        let c = _mm512_loadu_pd(records.add(*at.add(2) as usize));
        let d = _mm512_loadu_pd(records.add(*at.add(3) as usize));
        let e = _mm512_loadu_pd(records.add(*at.add(4) as usize));
        let f = _mm512_loadu_pd(records.add(*at.add(5) as usize));
        let g = _mm512_loadu_pd(records.add(*at.add(6) as usize));
        let h = _mm512_loadu_pd(records.add(*at.add(7) as usize));
        let [x, z, vx, vz] = blocks_in_turn([
            _mm512_unpacklo_pd(a, b),
            _mm512_unpacklo_pd(c, d),
            _mm512_unpacklo_pd(e, f),
            _mm512_unpacklo_pd(g, h),
        ]);
        let [y, _, vy, _] = blocks_in_turn([
            _mm512_unpackhi_pd(a, b),
            _mm512_unpackhi_pd(c, d),
            _mm512_unpackhi_pd(e, f),
            _mm512_unpackhi_pd(g, h),
        ]);
        [[x, y, z], [vx, vy, vz]]
    }
}

/// The first blocks of two numbers of each of four, the second, the third and the fourth ones.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn blocks_in_turn([a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    // SAFETY: the caller's promise.
    unsafe {
        let (even_ab, even_cd) = (
            _mm512_shuffle_f64x2::<0b10_00_10_00>(a, b),
            _mm512_shuffle_f64x2::<0b10_00_10_00>(c, d),
        );
        let (odd_ab, odd_cd) = (
            _mm512_shuffle_f64x2::<0b11_01_11_01>(a, b),
            _mm512_shuffle_f64x2::<0b11_01_11_01>(c, d),
        );
        [
            _mm512_shuffle_f64x2::<0b10_00_10_00>(even_ab, even_cd),
            _mm512_shuffle_f64x2::<0b10_00_10_00>(odd_ab, odd_cd),
            _mm512_shuffle_f64x2::<0b11_01_11_01>(even_ab, even_cd),
            _mm512_shuffle_f64x2::<0b11_01_11_01>(odd_ab, odd_cd),
        ]
    }
}
