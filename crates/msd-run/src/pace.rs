//! The pace of steps on the workloads, where no benchmark runs: in a page of a browser.

use msd_core::{Error, Instructions, Simulation};
use msd_scene::{FileError, workloads};

/// Steps of a batch, from the start of the work: a second.
const BATCH: u64 = 60;

/// Reasons why the pace is unknown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaceError {
    /// No work is called so.
    #[error("no work is called `{0}`; there are cloth/SIDE and block/SIDE")]
    Unknown(String),
    /// The work cannot be made.
    #[error(transparent)]
    Work(#[from] FileError),
    /// The work cannot be stepped.
    #[error(transparent)]
    Step(#[from] Error),
}

/// Steps a work (`cloth/31`, `block/20`) in f32 by symplectic Euler for some seconds. Returns the
/// spring updates per second of its best batch; `clock` gives seconds.
///
/// # Errors
/// See [`PaceError`].
pub fn best_pace(
    work: &str,
    instructions: Instructions,
    seconds: f64,
    clock: &impl Fn() -> f64,
) -> Result<f64, PaceError> {
    let unknown = || PaceError::Unknown(work.to_owned());
    let (kind, side) = work.split_once('/').ok_or_else(unknown)?;
    let side: usize = side.parse().map_err(|_| unknown())?;
    let scene = match kind {
        "cloth" => workloads::cloth(side)?,
        "block" => workloads::block(side)?,
        _ => return Err(unknown()),
    };
    let settings = workloads::settings();
    let mut start = Simulation::<f32>::new(&scene, settings)?;
    start.set_instructions(instructions);
    let updates = (BATCH * u64::from(settings.substeps)) as f64 * scene.springs.len() as f64;
    let (began, mut best) = (clock(), 0.0_f64);
    while best == 0.0 || clock() - began < seconds {
        let mut simulation = start.clone();
        let before = clock();
        for _ in 0..BATCH {
            simulation.step()?;
        }
        // A clock may be as coarse as a batch of a tiny work.
        best = best.max(updates / (clock() - before).max(1e-4));
    }
    Ok(best)
}
