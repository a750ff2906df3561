//! simd128 of WebAssembly, for builds that ask for it.

use crate::kernel::RECORD;
use crate::kernel::pack::Pack;
use core::arch::wasm32::v128;

pack!(Single, f32, 4, single, v128, v128);
pack!(Double, f64, 2, double, v128, v128);

mod single {
    use core::arch::wasm32::*;
    pub(super) use core::arch::wasm32::{
        f32x4_add as add, f32x4_div as div, f32x4_lt as less, f32x4_mul as mul,
        f32x4_splat as splat, f32x4_sqrt as sqrt, f32x4_sub as sub, v128_and as both,
        v128_load as load, v128_store as store,
    };

    #[inline(always)]
    pub(super) fn not_less(a: v128, b: v128) -> v128 {
        v128_not(f32x4_lt(a, b))
    }

    #[inline(always)]
    pub(super) fn choose(mask: v128, a: v128, b: v128) -> v128 {
        v128_bitselect(a, b, mask)
    }

    #[inline(always)]
    pub(super) fn mask(bits: u16) -> v128 {
        let weights = i32x4(1, 2, 4, 8);
        i32x4_eq(v128_and(i32x4_splat(i32::from(bits)), weights), weights)
    }

    #[inline(always)]
    pub(super) fn bits(mask: v128) -> u16 {
        u16::from(i32x4_bitmask(mask))
    }

    #[inline(always)]
    pub(super) fn low(a: v128, b: v128) -> v128 {
        i32x4_shuffle::<0, 4, 1, 5>(a, b)
    }

    #[inline(always)]
    pub(super) fn high(a: v128, b: v128) -> v128 {
        i32x4_shuffle::<2, 6, 3, 7>(a, b)
    }
}

mod double {
    use core::arch::wasm32::*;
    pub(super) use core::arch::wasm32::{
        f64x2_add as add, f64x2_div as div, f64x2_lt as less, f64x2_mul as mul,
        f64x2_splat as splat, f64x2_sqrt as sqrt, f64x2_sub as sub, v128_and as both,
        v128_load as load, v128_store as store,
    };

    #[inline(always)]
    pub(super) fn not_less(a: v128, b: v128) -> v128 {
        v128_not(f64x2_lt(a, b))
    }

    #[inline(always)]
    pub(super) fn choose(mask: v128, a: v128, b: v128) -> v128 {
        v128_bitselect(a, b, mask)
    }

    #[inline(always)]
    pub(super) fn mask(bits: u16) -> v128 {
        let weights = i64x2(1, 2);
        i64x2_eq(v128_and(i64x2_splat(i64::from(bits)), weights), weights)
    }

    #[inline(always)]
    pub(super) fn bits(mask: v128) -> u16 {
        u16::from(i64x2_bitmask(mask))
    }

    #[inline(always)]
    pub(super) fn low(a: v128, b: v128) -> v128 {
        i64x2_shuffle::<0, 2>(a, b)
    }

    #[inline(always)]
    pub(super) fn high(a: v128, b: v128) -> v128 {
        i64x2_shuffle::<1, 3>(a, b)
    }
}
