//! SSE2, which every x86-64 has but for builds that forbid it.

use crate::kernel::RECORD;
use crate::kernel::pack::Pack;
use core::arch::x86_64::{__m128, __m128d};

pack!(Single, f32, 4, single, __m128, __m128);
pack!(Double, f64, 2, double, __m128d, __m128d);

mod single {
    use core::arch::x86_64::*;
    pub(super) use core::arch::x86_64::{
        _mm_add_ps as add, _mm_and_ps as both, _mm_cmplt_ps as less, _mm_cmpnlt_ps as not_less,
        _mm_div_ps as div, _mm_loadu_ps as load, _mm_mul_ps as mul, _mm_set1_ps as splat,
        _mm_sqrt_ps as sqrt, _mm_storeu_ps as store, _mm_sub_ps as sub, _mm_unpackhi_ps as high,
        _mm_unpacklo_ps as low,
    };

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn choose(mask: __m128, a: __m128, b: __m128) -> __m128 {
        _mm_or_ps(_mm_and_ps(mask, a), _mm_andnot_ps(mask, b))
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn mask(bits: u16) -> __m128 {
        let weights = _mm_set_epi32(8, 4, 2, 1);
        let set = _mm_and_si128(_mm_set1_epi32(i32::from(bits)), weights);
        _mm_castsi128_ps(_mm_cmpeq_epi32(set, weights))
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn bits(mask: __m128) -> u16 {
        _mm_movemask_ps(mask) as u16
    }
}

mod double {
    use core::arch::x86_64::*;
    pub(super) use core::arch::x86_64::{
        _mm_add_pd as add, _mm_and_pd as both, _mm_cmplt_pd as less, _mm_cmpnlt_pd as not_less,
        _mm_div_pd as div, _mm_loadu_pd as load, _mm_mul_pd as mul, _mm_set1_pd as splat,
        _mm_sqrt_pd as sqrt, _mm_storeu_pd as store, _mm_sub_pd as sub, _mm_unpackhi_pd as high,
        _mm_unpacklo_pd as low,
    };

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn choose(mask: __m128d, a: __m128d, b: __m128d) -> __m128d {
        _mm_or_pd(_mm_and_pd(mask, a), _mm_andnot_pd(mask, b))
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn mask(bits: u16) -> __m128d {
        let weights = _mm_set_epi32(2, 2, 1, 1);
        let set = _mm_and_si128(_mm_set1_epi32(i32::from(bits)), weights);
        _mm_castsi128_pd(_mm_cmpeq_epi32(set, weights))
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    pub(super) fn bits(mask: __m128d) -> u16 {
        _mm_movemask_pd(mask) as u16
    }
}
