//! NEON, which nearly every 64-bit ARM has.

use crate::kernel::RECORD;
use crate::kernel::pack::Pack;
use core::arch::aarch64::{float32x4_t, float64x2_t, uint32x4_t, uint64x2_t};

pack!(Single, f32, 4, single, float32x4_t, uint32x4_t);
pack!(Double, f64, 2, double, float64x2_t, uint64x2_t);

mod single {
    use core::arch::aarch64::*;
    pub(super) use core::arch::aarch64::{
        vaddq_f32 as add, vandq_u32 as both, vbslq_f32 as choose, vcltq_f32 as less,
        vdivq_f32 as div, vdupq_n_f32 as splat, vld1q_f32 as load, vmulq_f32 as mul,
        vsqrtq_f32 as sqrt, vst1q_f32 as store, vsubq_f32 as sub, vzip1q_f32 as low,
        vzip2q_f32 as high,
    };

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn not_less(a: float32x4_t, b: float32x4_t) -> uint32x4_t {
        vmvnq_u32(vcltq_f32(a, b))
    }

    #[inline]
    #[target_feature(enable = "neon")]
    fn weights() -> uint32x4_t {
        // SAFETY: there are four numbers.
        unsafe { vld1q_u32([1, 2, 4, 8].as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn mask(bits: u16) -> uint32x4_t {
        vtstq_u32(vdupq_n_u32(u32::from(bits)), weights())
    }

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn bits(mask: uint32x4_t) -> u16 {
        vaddvq_u32(vandq_u32(mask, weights())) as u16
    }
}

mod double {
    use core::arch::aarch64::*;
    pub(super) use core::arch::aarch64::{
        vaddq_f64 as add, vandq_u64 as both, vbslq_f64 as choose, vcltq_f64 as less,
        vdivq_f64 as div, vdupq_n_f64 as splat, vld1q_f64 as load, vmulq_f64 as mul,
        vsqrtq_f64 as sqrt, vst1q_f64 as store, vsubq_f64 as sub, vzip1q_f64 as low,
        vzip2q_f64 as high,
    };

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn not_less(a: float64x2_t, b: float64x2_t) -> uint64x2_t {
        veorq_u64(vcltq_f64(a, b), vdupq_n_u64(u64::MAX))
    }

    #[inline]
    #[target_feature(enable = "neon")]
    fn weights() -> uint64x2_t {
        // SAFETY: there are two numbers.
        unsafe { vld1q_u64([1, 2].as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn mask(bits: u16) -> uint64x2_t {
        vtstq_u64(vdupq_n_u64(u64::from(bits)), weights())
    }

    #[inline]
    #[target_feature(enable = "neon")]
    pub(super) fn bits(mask: uint64x2_t) -> u16 {
        vaddvq_u64(vandq_u64(mask, weights())) as u16
    }
}
