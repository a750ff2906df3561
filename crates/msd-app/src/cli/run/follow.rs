//! A run whose moments are written, as a film or as a file for another program.

use super::prepare::Prepared;
use super::{explain_divergence, late_advice};
use crate::cli::failure::Failure;
use crate::cli::steps::{Interrupt, Steps};
use msd_run::Runner;
use msd_study::quantity::quantity;

/// Steps to each of the moments, ascending step numbers, and calls `write` there with the number
/// of the moment. Returns the number of moments written, and why the run ended before the last.
///
/// # Errors
/// Those of `write`.
pub fn follow(
    prepared: &mut Prepared,
    (moments, interrupt): (&[u64], &Interrupt),
    mut write: impl FnMut(&Runner, usize) -> Result<(), Failure>,
) -> Result<(usize, Option<Failure>), Failure> {
    let mut progress = Steps::new(moments.last().copied().unwrap_or(0), &prepared.name);
    let mut taken = 0;
    for (number, &moment) in moments.iter().enumerate() {
        while taken < moment {
            if interrupt.is_asked() {
                return Ok((number, Some(interrupted(&prepared.runner))));
            }
            if let Err(error) = prepared.runner.step() {
                let advice = late_advice(prepared, Some(&error));
                let failure = explain_divergence(&prepared.name, error, advice.as_deref());
                return Ok((number, Some(failure)));
            }
            taken += 1;
            progress.tell(taken);
        }
        write(&prepared.runner, number)?;
    }
    Ok((moments.len(), None))
}

fn interrupted(runner: &Runner) -> Failure {
    let time = quantity(runner.time(), "s");
    Failure::interrupted(format!("interrupted after {time}; the output so far is written"))
}
