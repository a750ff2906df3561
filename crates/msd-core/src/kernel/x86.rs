//! The packs of x86-64: registers of 256 bits (AVX2) and of 512 bits (AVX-512).

use super::RECORD;
use super::pack::Pack;
use super::records::{
    columns_256, columns_512, columns_of_4, columns_of_8, half_rows, quarter_rows, record_rows,
    rows_256, rows_512, two_record_rows,
};
use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Sub};

/// Eight single numbers.
#[derive(Clone, Copy)]
pub(super) struct F32x8(__m256);
/// Four double numbers.
#[derive(Clone, Copy)]
pub(super) struct F64x4(__m256d);
/// Sixteen single numbers.
#[derive(Clone, Copy)]
pub(super) struct F32x16(__m512);
/// Eight double numbers.
#[derive(Clone, Copy)]
pub(super) struct F64x8(__m512d);

macro_rules! operators {
    ($pack:ident, $($trait:ident $name:ident $instruction:ident),*) => {$(
        impl $trait for $pack {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a pack exists, so the processor has its instructions.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}

operators!(F32x8, Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps,
    Div div _mm256_div_ps);
operators!(F64x4, Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd,
    Div div _mm256_div_pd);
operators!(F32x16, Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps,
    Div div _mm512_div_ps);
operators!(F64x8, Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd,
    Div div _mm512_div_pd);

/// What all packs say alike but for the names of the instructions.
macro_rules! common {
    ($scalar:ident, $splat:ident, $load:ident, $store:ident, $sqrt:ident) => {
        #[inline(always)]
        unsafe fn splat(value: $scalar) -> Self {
            // SAFETY: the caller's promise.
            Self(unsafe { $splat(value) })
        }
        #[inline(always)]
        unsafe fn load(from: *const $scalar) -> Self {
            // SAFETY: the caller's promise.
            Self(unsafe { $load(from) })
        }
        #[inline(always)]
        unsafe fn store(self, to: *mut $scalar) {
            // SAFETY: the caller's promise.
            unsafe { $store(to, self.0) };
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: a pack exists, so the processor has its instructions.
            Self(unsafe { $sqrt(self.0) })
        }
    };
}

/// A pack of AVX2: masks are registers, all bits of a lane set or none.
macro_rules! avx2 {
    ($pack:ident, $scalar:ident, $count:literal, $register:ident, $integer:ident,
     $common:tt, $bits:tt, $masks:tt, $add:ident, $more:tt) => {
        impl Pack<$scalar> for $pack {
            const COUNT: usize = $count;
            type Mask = $register;
            avx2!(@common $scalar $common);
            avx2!(@bits $register $bits);
            avx2!(@masks $pack $scalar $register $add $masks);
            avx2!(@more $more);
        }
    };
    (@common $scalar:ident ($($name:ident),*)) => { common!($scalar, $($name),*); };
    (@more { $($more:item)* }) => { $($more)* };
    (@bits $register:ident ($weights:expr, $splat:ident as $integer:ident, $and:ident, $equal:ident,
        $cast:ident)) => {
        #[inline(always)]
        unsafe fn mask(bits: u16) -> $register {
            // SAFETY: the caller's promise.
            unsafe {
                let weights = $weights;
                $cast($equal($and($splat(bits as $integer), weights), weights))
            }
        }
    };
    (@masks $pack:ident $scalar:ident $register:ident $add:ident
        ($blend:ident, $and:ident, $compare:ident, $movemask:ident, $splat:ident)) => {
        #[inline(always)]
        fn select(self, mask: $register, other: Self) -> Self {
            // SAFETY: a pack exists, so the processor has its instructions.
            Self(unsafe { $blend(other.0, self.0, mask) })
        }
        #[inline(always)]
        fn add_where(self, mask: $register, other: Self) -> Self {
            // To add minus zero changes nothing, not even the sign of a zero.
            // SAFETY: a pack exists, so the processor has its instructions.
            Self(unsafe { $add(self.0, $blend($splat(-0.0), other.0, mask)) })
        }
        #[inline(always)]
        fn less(self, other: Self, within: $register) -> $register {
            // SAFETY: a pack exists, so the processor has its instructions.
            unsafe { $and(within, $compare::<_CMP_LT_OQ>(self.0, other.0)) }
        }
        #[inline(always)]
        fn not_less(self, other: Self, within: $register) -> $register {
            // SAFETY: a pack exists, so the processor has its instructions.
            unsafe { $and(within, $compare::<_CMP_NLT_UQ>(self.0, other.0)) }
        }
        #[inline(always)]
        fn bits(mask: $register) -> u16 {
            // SAFETY: a mask exists, so the processor has its instructions.
            unsafe { $movemask(mask) as u16 }
        }
    };
}

avx2!(
    F32x8,
    f32,
    8,
    __m256,
    i32,
    (_mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_sqrt_ps),
    (
        _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1),
        _mm256_set1_epi32 as i32,
        _mm256_and_si256,
        _mm256_cmpeq_epi32,
        _mm256_castsi256_ps
    ),
    (_mm256_blendv_ps, _mm256_and_ps, _mm256_cmp_ps, _mm256_movemask_ps, _mm256_set1_ps),
    _mm256_add_ps,
    {
        #[inline(always)]
        unsafe fn gather(records: *const f32, at: *const u32, both: bool) -> [[Self; 3]; 2] {
            // SAFETY: the caller's promise.
            unsafe {
                if !both {
                    let rows = [
                        half_rows(records, at, 0),
                        half_rows(records, at, 1),
                        half_rows(records, at, 2),
                        half_rows(records, at, 3),
                    ];
                    let [x, y, z] = columns_256(rows);
                    return [[Self(x), Self(y), Self(z)]; 2];
                }
                let [x, y, z] = columns_256(record_rows(records, at));
                let [x_4, y_4, z_4] = columns_256(record_rows(records, at.add(4)));
                [
                    [
                        Self(_mm256_permute2f128_ps::<0x20>(x, x_4)),
                        Self(_mm256_permute2f128_ps::<0x20>(y, y_4)),
                        Self(_mm256_permute2f128_ps::<0x20>(z, z_4)),
                    ],
                    [
                        Self(_mm256_permute2f128_ps::<0x31>(x, x_4)),
                        Self(_mm256_permute2f128_ps::<0x31>(y, y_4)),
                        Self(_mm256_permute2f128_ps::<0x31>(z, z_4)),
                    ],
                ]
            }
        }
        #[inline(always)]
        unsafe fn scatter(records: *mut f32, [[x, y, z], [vx, vy, vz]]: [[Self; 3]; 2]) {
            // SAFETY: the caller's promise.
            unsafe {
                let low = rows_256([
                    _mm256_permute2f128_ps::<0x20>(x.0, vx.0),
                    _mm256_permute2f128_ps::<0x20>(y.0, vy.0),
                    _mm256_permute2f128_ps::<0x20>(z.0, vz.0),
                ]);
                let high = rows_256([
                    _mm256_permute2f128_ps::<0x31>(x.0, vx.0),
                    _mm256_permute2f128_ps::<0x31>(y.0, vy.0),
                    _mm256_permute2f128_ps::<0x31>(z.0, vz.0),
                ]);
                for (lane, row) in low.into_iter().chain(high).enumerate() {
                    _mm256_storeu_ps(records.add(lane * RECORD), row);
                }
            }
        }
    }
);
avx2!(
    F64x4,
    f64,
    4,
    __m256d,
    i64,
    (_mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_sqrt_pd),
    (
        _mm256_set_epi64x(8, 4, 2, 1),
        _mm256_set1_epi64x as i64,
        _mm256_and_si256,
        _mm256_cmpeq_epi64,
        _mm256_castsi256_pd
    ),
    (_mm256_blendv_pd, _mm256_and_pd, _mm256_cmp_pd, _mm256_movemask_pd, _mm256_set1_pd),
    _mm256_add_pd,
    {
        #[inline(always)]
        unsafe fn gather(records: *const f64, at: *const u32, both: bool) -> [[Self; 3]; 2] {
            // SAFETY: the caller's promise.
            unsafe {
                let first = columns_of_4(records, at, 0);
                let second = if both { columns_of_4(records, at, RECORD / 2) } else { first };
                let [[x, y, z], [vx, vy, vz]] = [first, second];
                [[Self(x), Self(y), Self(z)], [Self(vx), Self(vy), Self(vz)]]
            }
        }
    }
);

/// A pack of AVX-512: masks are bits.
macro_rules! avx512 {
    ($pack:ident, $scalar:ident, $count:literal, $mask:ident, $common:tt,
     ($blend:ident, $add:ident, $compare:ident), $more:tt) => {
        impl Pack<$scalar> for $pack {
            const COUNT: usize = $count;
            type Mask = $mask;
            avx2!(@common $scalar $common);
            avx2!(@more $more);
            #[inline(always)]
            unsafe fn mask(bits: u16) -> $mask {
                bits as $mask
            }
            #[inline(always)]
            fn select(self, mask: $mask, other: Self) -> Self {
                // SAFETY: a pack exists, so the processor has its instructions.
                Self(unsafe { $blend(mask, other.0, self.0) })
            }
            #[inline(always)]
            fn add_where(self, mask: $mask, other: Self) -> Self {
                // SAFETY: a pack exists, so the processor has its instructions.
                Self(unsafe { $add(self.0, mask, self.0, other.0) })
            }
            #[inline(always)]
            fn less(self, other: Self, within: $mask) -> $mask {
                // SAFETY: a pack exists, so the processor has its instructions.
                unsafe { $compare::<_CMP_LT_OQ>(within, self.0, other.0) }
            }
            #[inline(always)]
            fn not_less(self, other: Self, within: $mask) -> $mask {
                // SAFETY: a pack exists, so the processor has its instructions.
                unsafe { $compare::<_CMP_NLT_UQ>(within, self.0, other.0) }
            }
            #[inline(always)]
            fn bits(mask: $mask) -> u16 {
                u16::from(mask)
            }
        }
    };
}

avx512!(
    F32x16,
    f32,
    16,
    __mmask16,
    (_mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_sqrt_ps),
    (_mm512_mask_blend_ps, _mm512_mask_add_ps, _mm512_mask_cmp_ps_mask),
    {
        #[inline(always)]
        unsafe fn gather(records: *const f32, at: *const u32, both: bool) -> [[Self; 3]; 2] {
            // SAFETY: the caller's promise.
            unsafe {
                if !both {
                    let rows = [
                        quarter_rows(records, at, 0),
                        quarter_rows(records, at, 1),
                        quarter_rows(records, at, 2),
                        quarter_rows(records, at, 3),
                    ];
                    let [x, y, z] = columns_512(rows);
                    return [[Self(x), Self(y), Self(z)]; 2];
                }
                let [x, y, z] = columns_512(two_record_rows(records, at));
                let [x_8, y_8, z_8] = columns_512(two_record_rows(records, at.add(8)));
                [
                    [
                        Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(x, x_8)),
                        Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(y, y_8)),
                        Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(z, z_8)),
                    ],
                    [
                        Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(x, x_8)),
                        Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(y, y_8)),
                        Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(z, z_8)),
                    ],
                ]
            }
        }
        #[inline(always)]
        unsafe fn scatter(records: *mut f32, [[x, y, z], [vx, vy, vz]]: [[Self; 3]; 2]) {
            // SAFETY: the caller's promise.
            unsafe {
                // Blocks of four lanes: those of positions, then those of velocities.
                let rows = rows_512([x.0, y.0, z.0]);
                let velocity_rows = rows_512([vx.0, vy.0, vz.0]);
                for (lane, (row, velocity_row)) in rows.into_iter().zip(velocity_rows).enumerate() {
                    let record = records.add(lane * RECORD);
                    _mm_storeu_ps(record, _mm512_castps512_ps128(row));
                    _mm_storeu_ps(record.add(4), _mm512_castps512_ps128(velocity_row));
                    let record = records.add((lane + 4) * RECORD);
                    _mm_storeu_ps(record, _mm512_extractf32x4_ps::<1>(row));
                    _mm_storeu_ps(record.add(4), _mm512_extractf32x4_ps::<1>(velocity_row));
                    let record = records.add((lane + 8) * RECORD);
                    _mm_storeu_ps(record, _mm512_extractf32x4_ps::<2>(row));
                    _mm_storeu_ps(record.add(4), _mm512_extractf32x4_ps::<2>(velocity_row));
                    let record = records.add((lane + 12) * RECORD);
                    _mm_storeu_ps(record, _mm512_extractf32x4_ps::<3>(row));
                    _mm_storeu_ps(record.add(4), _mm512_extractf32x4_ps::<3>(velocity_row));
                }
            }
        }
    }
);
avx512!(
    F64x8,
    f64,
    8,
    __mmask8,
    (_mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_sqrt_pd),
    (_mm512_mask_blend_pd, _mm512_mask_add_pd, _mm512_mask_cmp_pd_mask),
    {
        #[inline(always)]
        unsafe fn gather(records: *const f64, at: *const u32, _: bool) -> [[Self; 3]; 2] {
            // SAFETY: the caller's promise.
            let [[x, y, z], [vx, vy, vz]] = unsafe { columns_of_8(records, at) };
            [[Self(x), Self(y), Self(z)], [Self(vx), Self(vy), Self(vz)]]
        }
    }
);
