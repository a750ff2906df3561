//! Which instructions does this machine have? The same sweep, compiled once for each of them.

use super::pack::Plain;
use super::sweep::{Job, Tally, sweep};
#[cfg(target_arch = "x86_64")]
use super::x86::{F32x8, F32x16, F64x4, F64x8};
use crate::real::Real;
#[cfg(target_arch = "x86_64")]
use core::any::TypeId;
use core::ops::Range;

/// Sets of instructions, from what every target has to what few have. All of them give the same
/// bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instructions {
    /// What the target of the build always has: SSE2, NEON, simd128 of WebAssembly, or none.
    Plain,
    /// AVX2: 256 bits.
    Avx2,
    /// AVX-512 F, VL, DQ and BW: 512 bits.
    Avx512,
}

impl Instructions {
    /// Every set, the plainest first.
    pub const ALL: [Instructions; 3] =
        [Instructions::Plain, Instructions::Avx2, Instructions::Avx512];

    /// The best set that this machine has.
    ///
    /// Without the standard library nobody can be asked: what the build was made for.
    pub fn best() -> Self {
        #[cfg(all(target_arch = "x86_64", feature = "std"))]
        {
            let avx512 = std::is_x86_feature_detected!("avx512f")
                && std::is_x86_feature_detected!("avx512vl")
                && std::is_x86_feature_detected!("avx512dq")
                && std::is_x86_feature_detected!("avx512bw");
            if avx512 {
                return Instructions::Avx512;
            }
            if std::is_x86_feature_detected!("avx2") {
                return Instructions::Avx2;
            }
        }
        Instructions::Plain
    }

    /// The name a user reads.
    pub fn name(self) -> &'static str {
        match self {
            Instructions::Plain => "plain",
            Instructions::Avx2 => "avx2",
            Instructions::Avx512 => "avx512",
        }
    }

    /// This set, or the best that this machine has if that is less.
    pub(super) fn within_reach(self) -> Self {
        self.min(Instructions::best())
    }
}

/// Slices whose sums are taken together: enough that a part is worth a thread.
const PART: usize = 64;

/// The number of parts of so many slices.
pub(super) fn parts(slices: usize) -> usize {
    slices.div_ceil(PART)
}

/// Runs a job, part by part, and sums what they came to in their order.
///
/// The instructions must be within reach, and the job the only user of its columns.
pub(super) fn run<R: Real>(
    instructions: Instructions,
    job: &Job<'_, R>,
    tallies: &mut [Tally],
) -> Tally {
    let slices = job.plan.slices();
    for (part, tally) in tallies.iter_mut().enumerate() {
        let range = part * PART..(part * PART + PART).min(slices);
        // SAFETY: the caller's promises.
        *tally = unsafe { run_part(instructions, job, range) };
    }
    let mut sum = Tally::default();
    tallies.iter().for_each(|&tally| sum += tally);
    sum
}

/// # Safety
/// See [`sweep`]: the processor has the instructions.
unsafe fn run_part<R: Real>(
    instructions: Instructions,
    job: &Job<'_, R>,
    slices: Range<usize>,
) -> Tally {
    // SAFETY: the caller's promise; a job of one scalar is cast to itself.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        let single = TypeId::of::<R>() == TypeId::of::<f32>();
        match (instructions, single) {
            (Instructions::Plain, _) => {}
            (Instructions::Avx2, true) => return avx2_f32(&*core::ptr::from_ref(job).cast(), slices),
            (Instructions::Avx2, false) => return avx2_f64(&*core::ptr::from_ref(job).cast(), slices),
            (Instructions::Avx512, true) => return avx512_f32(&*core::ptr::from_ref(job).cast(), slices),
            (Instructions::Avx512, false) => return avx512_f64(&*core::ptr::from_ref(job).cast(), slices),
        }
    }
    let _ = instructions;
    // SAFETY: the caller's promise.
    unsafe { either::<R, Plain<R>>(job, slices) }
}

/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn either<R: Real, P: super::pack::Pack<R>>(
    job: &Job<'_, R>,
    slices: Range<usize>,
) -> Tally {
    // SAFETY: the caller's promise.
    unsafe {
        if job.plan.damped {
            sweep::<R, P, true>(job, slices)
        } else {
            sweep::<R, P, false>(job, slices)
        }
    }
}

#[cfg(target_arch = "x86_64")]
macro_rules! compiled_for {
    ($name:ident, $features:literal, $scalar:ident, $pack:ident) => {
        /// # Safety
        /// See [`sweep`].
        #[target_feature(enable = $features)]
        unsafe fn $name(job: &Job<'_, $scalar>, slices: Range<usize>) -> Tally {
            // SAFETY: the caller's promise.
            unsafe { either::<$scalar, $pack>(job, slices) }
        }
    };
}

#[cfg(target_arch = "x86_64")]
compiled_for!(avx2_f32, "avx2", f32, F32x8);
#[cfg(target_arch = "x86_64")]
compiled_for!(avx2_f64, "avx2", f64, F64x4);
#[cfg(target_arch = "x86_64")]
compiled_for!(avx512_f32, "avx512f,avx512vl,avx512dq,avx512bw", f32, F32x16);
#[cfg(target_arch = "x86_64")]
compiled_for!(avx512_f64, "avx512f,avx512vl,avx512dq,avx512bw", f64, F64x8);
