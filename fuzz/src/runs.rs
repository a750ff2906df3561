//! Saved runs and recordings of any bytes, with their checksums set right.
//!
//! Another program would write them so, and a wrong checksum would hide everything behind it.

use super::promise::{check_message, check_simulation};
use msd_core::{Integrator, Settings};
use msd_run::Runner;
use msd_run::recording::{read_recording, salvage_recording};
use msd_run::replay::Replay;
use msd_scene::read_saved;
use msd_scene::schema::SolverRow;

/// Bytes of the length of a frame and of the hash behind it.
const LENGTH: usize = 8;
const HASH: usize = 32;
/// Steps of a replay at most.
const STEPS: usize = 20;
/// Rows times substeps of a step at most.
const WORK: usize = 100_000;

/// Reads bytes as a saved run and as a recording, and goes on from what is read.
pub fn check(bytes: &[u8]) {
    let bytes = mend(bytes);
    match read_saved(&bytes, "run") {
        Ok(loaded) => match Runner::open(&loaded) {
            Ok(mut runner) => step(&mut runner),
            Err(error) => check_message(&error),
        },
        Err(error) => check_message(&error),
    }
    if let Err(error) = read_recording(&bytes, "recording") {
        check_message(&error);
    }
    match salvage_recording(&bytes, "recording") {
        Ok(recording) => match Replay::new(&recording, SolverRow::default()) {
            Ok(replay) => follow(replay),
            Err(error) => check_message(&error),
        },
        Err(error) => check_message(&error),
    }
}

/// The same file with the hash of each frame set right, and a length that is too large shortened.
fn mend(bytes: &[u8]) -> Vec<u8> {
    let start = bytes.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| end + 1);
    let (line, mut rest) = bytes.split_at(start);
    let mut mended = line.to_vec();
    while let Some((length, frame)) = rest.split_first_chunk::<LENGTH>() {
        let wanted = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let (content, behind) = frame.split_at(wanted.min(frame.len().saturating_sub(HASH)));
        mended.extend((content.len() as u64).to_le_bytes());
        mended.extend(content);
        mended.extend(blake3::hash(content).as_bytes());
        rest = behind.get(HASH..).unwrap_or_default();
    }
    mended.extend(rest);
    mended
}

/// Whether a step is short enough to be tried often.
fn is_short(runner: &Runner) -> bool {
    let Settings { integrator, substeps, newton, .. } = runner.settings();
    let rows = 1 + runner.particle_count() + runner.spring_count();
    let work = rows.saturating_mul(substeps as usize).saturating_mul(newton as usize);
    work <= WORK && integrator != Integrator::DormandPrince
}

fn step(runner: &mut Runner) {
    check_runner(runner);
    if is_short(runner) {
        if let Err(error) = runner.step() {
            check_message(&error);
        }
        check_runner(runner);
    }
}

fn follow(mut replay: Replay<'_>) {
    for _ in 0..STEPS {
        if !is_short(replay.runner()) {
            return;
        }
        match replay.advance() {
            Ok(true) => check_runner(replay.runner()),
            Ok(false) => return,
            Err(error) => return check_message(&error),
        }
    }
}

fn check_runner(runner: &Runner) {
    match runner {
        Runner::F32(simulation, _) => check_simulation(simulation),
        Runner::F64(simulation, _) => check_simulation(simulation),
    }
}
