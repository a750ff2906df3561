//! Which instructions does this machine have? The same sweep, compiled once for each of them.

use super::baseline::{Double, Single};
use super::pack::Pack;
use super::solve::{self, Matrix, Task};
use super::sweep::{Job, Tally, sweep};
use super::update::{self, Update};
#[cfg(target_arch = "x86_64")]
use super::x86::{F32x8, F32x16, F64x4, F64x8};
use crate::real::Real;
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

/// Runs a job, part by part, and sums what they came to in their order: the same bits on any number
/// of threads.
///
/// # Safety
/// The processor has the instructions, and the job is the only user of its columns.
pub(super) unsafe fn run<R: Real>(
    instructions: Instructions,
    job: &Job<'_, R>,
    update: Update<R>,
    tallies: &mut [Tally],
) -> Tally {
    let slices = job.plan.slices();
    let run = |(part, tally): (usize, &mut Tally)| {
        let range = part * PART..(part * PART + PART).min(slices);
        // SAFETY: the caller's promises; no two parts have a slice in common.
        *tally = unsafe { run_part(instructions, job, update, range) };
    };
    #[cfg(feature = "parallel")]
    let alone = job.plan.rows.len() < ROWS_WORTH_THREADS || rayon::current_num_threads() == 1;
    #[cfg(not(feature = "parallel"))]
    let alone = true;
    if alone {
        tallies.iter_mut().enumerate().for_each(run);
    }
    #[cfg(feature = "parallel")]
    if !alone {
        use rayon::prelude::*;
        let each = tallies.len() / rayon::current_num_threads();
        tallies.par_iter_mut().enumerate().with_min_len(each).for_each(run);
    }
    let mut sum = Tally::default();
    tallies.iter().for_each(|&tally| sum += tally);
    sum
}

/// Rows of a plan from which threads are worth waking: about 15 microseconds of work.
#[cfg(feature = "parallel")]
const ROWS_WORTH_THREADS: usize = 3000;

/// Does one task of a solve; returns what it sums up.
///
/// # Safety
/// The processor has the instructions, and the matrix is the only user of its columns.
pub(super) unsafe fn run_task<R: Real>(
    instructions: Instructions,
    matrix: &Matrix<'_, R>,
    task: Task<R>,
) -> f64 {
    let slices = matrix.job.plan.slices();
    let part = |part: usize| {
        let range = part * PART..(part * PART + PART).min(slices);
        // SAFETY: the caller's promises.
        unsafe { run_task_part(instructions, matrix, task, range) }
    };
    (0..parts(slices)).map(part).sum()
}

/// Calls the sweep that was compiled for an update and for what a plan has.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn specialised<R: Real, P: Pack<R>>(
    job: &Job<'_, R>,
    update: Update<R>,
    slices: Range<usize>,
) -> Tally {
    macro_rules! sweep_with {
        ($update:expr) => {
            // SAFETY: the caller's promise.
            unsafe {
                match (job.plan.damped, job.plan.others.is_empty()) {
                    (true, true) => sweep::<R, P, true, false>(job, $update, slices),
                    (true, false) => sweep::<R, P, true, true>(job, $update, slices),
                    (false, true) => sweep::<R, P, false, false>(job, $update, slices),
                    (false, false) => sweep::<R, P, false, true>(job, $update, slices),
                }
            }
        };
    }
    match update {
        Update::Forces => sweep_with!(update::Forces),
        Update::ExplicitEuler { h } => sweep_with!(update::ExplicitEuler(h)),
        Update::SymplecticEuler { h } => sweep_with!(update::SymplecticEuler(h)),
        Update::VelocityVerlet { h, phase, damped } => {
            sweep_with!(update::VelocityVerlet { h, phase, damped })
        }
        Update::Rk4Stage { first, weight, reach } => {
            sweep_with!(update::Rk4Stage { first, weight, reach })
        }
        Update::Rk4Last { h } => sweep_with!(update::Rk4Last(h)),
    }
}

/// Calls the code that was compiled for a task and for what a plan has.
///
/// # Safety
/// See [`sweep`].
#[inline(always)]
unsafe fn specialised_task<R: Real, P: Pack<R>>(
    matrix: &Matrix<'_, R>,
    task: Task<R>,
    slices: Range<usize>,
) -> f64 {
    // SAFETY: the caller's promise.
    unsafe {
        if matrix.job.plan.others.is_empty() {
            solve::run::<R, P, false>(matrix, task, slices)
        } else {
            solve::run::<R, P, true>(matrix, task, slices)
        }
    }
}

/// Only code for one scalar is compiled here; that for any would be compiled by every user.
macro_rules! cast_to {
    ($compiled:ident, $job:ident, $with:ident $(, $slices:ident)?) => {
        // SAFETY: the caller's promise; the scalar is this one.
        unsafe { $compiled(&*$job.cast(), *$with.cast() $(, $slices)?) }
    };
}

macro_rules! compiled_for {
    ($name:ident, $($features:literal,)? $scalar:ident, $pack:ty,
     $body:ident($job:ident, $with:ident $(, $slices:ident: $range:ty)?) -> $sum:ty) => {
        /// # Safety
        /// See [`sweep`].
        $(#[target_feature(enable = $features)])?
        unsafe fn $name(
            job: &$job<'_, $scalar>,
            with: $with<$scalar>,
            $($slices: $range,)?
        ) -> $sum {
            // SAFETY: the caller's promise.
            unsafe { $body::<$scalar, $pack>(job, with $(, $slices)?) }
        }
    };
}

/// A function that calls the code compiled for an instruction set and a scalar.
macro_rules! dispatched {
    ($(#[$doc:meta])* $visible:vis $name:ident,
     $body:ident($job:ident, $with:ident $(, $slices:ident: $range:ty)?) -> $sum:ty) => {
        $(#[$doc])*
        ///
        /// # Safety
        /// The processor has the instructions; what the body asks for besides.
        $visible unsafe fn $name<R: Real>(
            instructions: Instructions,
            job: &$job<'_, R>,
            with: $with<R>,
            $($slices: $range,)?
        ) -> $sum {
            compiled_for!(plain_f32, f32, Single,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            compiled_for!(plain_f64, f64, Double,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            #[cfg(target_arch = "x86_64")]
            compiled_for!(avx2_f32, "avx2", f32, F32x8,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            #[cfg(target_arch = "x86_64")]
            compiled_for!(avx2_f64, "avx2", f64, F64x4,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            #[cfg(target_arch = "x86_64")]
            compiled_for!(avx512_f32, "avx512f,avx512vl,avx512dq,avx512bw", f32, F32x16,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            #[cfg(target_arch = "x86_64")]
            compiled_for!(avx512_f64, "avx512f,avx512vl,avx512dq,avx512bw", f64, F64x8,
                $body($job, $with $(, $slices: $range)?) -> $sum);
            let (job, with) = (core::ptr::from_ref(job), core::ptr::from_ref(&with));
            let single = TypeId::of::<R>() == TypeId::of::<f32>();
            match (instructions, single) {
                #[cfg(target_arch = "x86_64")]
                (Instructions::Avx2, true) => cast_to!(avx2_f32, job, with $(, $slices)?),
                #[cfg(target_arch = "x86_64")]
                (Instructions::Avx2, false) => cast_to!(avx2_f64, job, with $(, $slices)?),
                #[cfg(target_arch = "x86_64")]
                (Instructions::Avx512, true) => cast_to!(avx512_f32, job, with $(, $slices)?),
                #[cfg(target_arch = "x86_64")]
                (Instructions::Avx512, false) => cast_to!(avx512_f64, job, with $(, $slices)?),
                (_, true) => cast_to!(plain_f32, job, with $(, $slices)?),
                (_, false) => cast_to!(plain_f64, job, with $(, $slices)?),
            }
        }
    };
}

dispatched!(
    /// Does some slices of a sweep.
    run_part,
    specialised(Job, Update, slices: Range<usize>) -> Tally
);
dispatched!(
    /// Does some slices of a task of a solve.
    run_task_part,
    specialised_task(Matrix, Task, slices: Range<usize>) -> f64
);
