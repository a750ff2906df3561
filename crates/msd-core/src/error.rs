//! Errors and their messages.

use alloc::string::String;

/// Every error that msd-core reports.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A number outside its domain.
    #[error("{quantity} of {item} {row} is {}; it must be {expected}", Digits(*value))]
    OutOfDomain {
        /// The quantity that the number measures.
        quantity: &'static str,
        /// The kind of row that holds it: particle, spring, plane, pin, body, setting.
        item: &'static str,
        /// The row, from 0.
        row: usize,
        /// The number.
        value: f64,
        /// The domain, in words.
        expected: &'static str,
    },
    /// An index out of range.
    #[error("{item} {row} names {target} {index}, but there are only {count}, counted from 0")]
    OutOfRange {
        /// The kind of row that holds the index.
        item: &'static str,
        /// The row, from 0.
        row: usize,
        /// The kind of row that the index should name.
        target: &'static str,
        /// The index.
        index: usize,
        /// The number of such rows.
        count: usize,
    },
    /// A spring that joins a particle to itself.
    #[error("spring {row} joins particle {particle} to itself; its two ends must differ")]
    Loop {
        /// The spring, from 0.
        row: usize,
        /// The particle at both ends.
        particle: usize,
    },
    /// A scene without particles.
    #[error("the scene has no particles; give it at least one body")]
    Empty,
    /// More rows than fit.
    #[error("{what} would be {count}; at most {limit} fit")]
    TooLarge {
        /// The kind of rows counted.
        what: &'static str,
        /// The number requested, saturated.
        count: u128,
        /// The number that fits.
        limit: usize,
    },
    /// A method that does not let the shells of a scene meet.
    #[error(
        "the method {method} cannot step a scene in which bodies touch: impacts would exceed its \
         tolerance; take one of {able}, or let no bodies touch"
    )]
    Unable {
        /// The method.
        method: &'static str,
        /// Those that do.
        able: String,
    },
    /// A name that is not in the list.
    #[error("unknown {what} '{name}'; it must be one of {expected}")]
    UnknownName {
        /// The kind of thing that the name should name.
        what: &'static str,
        /// The name given.
        name: String,
        /// The names allowed.
        expected: String,
    },
    /// Columns of different length.
    #[error("{what} has {count} rows, but the system has {expected}")]
    WrongLength {
        /// The column.
        what: &'static str,
        /// Its rows.
        count: usize,
        /// The rows needed.
        expected: usize,
    },
    /// An adaptive method cannot keep its tolerance; the state is the last good one.
    #[error(
        "tolerance {} is out of reach in step {step} (t = {time:.6} s), first for particle \
         {particle}; the last good state is kept. Use a larger tolerance or f64, or look for a \
         stiffness, force or speed too large",
        Digits(*tolerance)
    )]
    Unreachable {
        /// The tolerance asked for.
        tolerance: f64,
        /// The particle with the largest error, from 0.
        particle: usize,
        /// The step that failed, counted from 1; the state kept is the one before it.
        step: u64,
        /// Simulated time at the start of that step, seconds.
        time: f64,
    },
    /// A step of an adaptive method takes more evaluations than it may; the state is the last good
    /// one.
    #[error(
        "step {step} (t = {time:.6} s) takes more than the {most} evaluations of the forces that a \
         step may take here, at tolerance {}: {:.1} % of it was done; the last good state is kept. \
         Use another method or a larger tolerance, or look for a stiffness, force or speed too \
         large",
        Digits(*tolerance), 100.0 * done
    )]
    TooManyEvaluations {
        /// The most that a step may take.
        most: u64,
        /// The tolerance asked for.
        tolerance: f64,
        /// The part of the step that they sufficed for, 0 to 1.
        done: f64,
        /// The step that failed, counted from 1; the state kept is the one before it.
        step: u64,
        /// Simulated time at the start of that step, seconds.
        time: f64,
    },
    /// An implicit method cannot solve for a step; the state is the last good one.
    #[error(
        "step {step} (t = {time:.6} s) is not solved: {residual:.1e} of what had to be cancelled \
         was left after {iterations} iterations; the last good state is kept. Use f64, more \
         substeps, or look for a mass too small or a stiffness too large"
    )]
    Unsolved {
        /// The residual at the end of the solve, as a fraction of that at its start.
        residual: f64,
        /// Iterations of that solve.
        iterations: u64,
        /// The step that failed, counted from 1; the state kept is the one before it.
        step: u64,
        /// Simulated time at the start of that step, seconds.
        time: f64,
    },
    /// The simulation left the world; the state is the last good one.
    #[error(transparent)]
    Diverged(#[from] Divergence),
}

impl Error {
    /// Whether a step failed, rather than its arguments: the state is the last good one.
    pub fn is_of_step(&self) -> bool {
        matches!(
            self,
            Error::Diverged(_)
                | Error::Unreachable { .. }
                | Error::TooManyEvaluations { .. }
                | Error::Unsolved { .. }
        )
    }
}

/// A number as a message prints it, never in three hundred digits.
struct Digits(f64);

impl core::fmt::Display for Digits {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Digits(value) = self;
        if *value == 0.0 || !value.is_finite() || (1e-6..1e15).contains(&value.abs()) {
            write!(f, "{value}")
        } else {
            write!(f, "{value:e}")
        }
    }
}

/// The step and the particle with which a simulation left the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divergence {
    /// The first particle outside the world, from 0.
    pub particle: usize,
    /// The step that failed, counted from 1; the state kept is the one before it.
    pub step: u64,
    /// Simulated time at the start of that step, seconds.
    pub time: f64,
    /// The substep in use, seconds.
    pub substep: f64,
    /// The largest stable substep predicted on the state kept, seconds; `None` if there is none.
    pub stable_substep: Option<f64>,
}

/// Where a millionth of a substep would be stable, the kept state has flown apart, and a prediction
/// about it is not advice.
const FAR_GONE: f64 = 1e-6;

impl core::error::Error for Divergence {}

impl core::fmt::Display for Divergence {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Divergence { particle, step, time, substep, stable_substep } = self;
        write!(
            f,
            "diverged: particle {particle} left the world in step {step} (t = {time:.6} s); "
        )?;
        write!(f, "the last good state is kept. The substep is {substep:.3e} s; ")?;
        match stable_substep {
            Some(stable) if *stable < FAR_GONE * substep => write!(
                f,
                "in the state kept none is: start again with more substeps or another integrator"
            ),
            Some(stable) if stable < substep => {
                write!(f, "at most {stable:.3e} s is predicted stable: use more substeps")
            }
            Some(f64::INFINITY) => write!(
                f,
                "any is predicted stable, so look for a force or a speed too large, a plane that \
                 is missing or a world that is too small"
            ),
            Some(stable) => write!(
                f,
                "{stable:.3e} s is predicted stable, so look for a force or a speed too large"
            ),
            None => {
                write!(f, "this integrator is unstable here at any step: use another integrator")
            }
        }
    }
}
