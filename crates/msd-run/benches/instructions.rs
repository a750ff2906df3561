//! Instruction counts of a step: the same on a busy machine, so that they show a regression where
//! times are too noisy.
//!
//! `cargo bench --bench instructions` counts those of AVX2 by cachegrind and compares them with
//! `benches/instructions.txt`; `-- --write` puts what it counts there. If you change a count on
//! purpose, commit the new one. Set-up does not count: each count is the difference between two
//! runs, the longer of which takes [`STEPS`] more steps.
//!
//! No library for this: gungraun needs a runner of its own version, installed beside cargo.
//!
//! This benchmark alone must be optimised to say anything; it stands here, not beside the others,
//! so that the window need not be compiled for it.

#[path = "../../../benches/measure/compiler.rs"]
mod compiler;
#[path = "../../../benches/baselines/works.rs"]
mod works;

use msd_core::{Instructions, Integrator, Settings, Simulation};
use msd_scene::workloads;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// Each work with its method, and the steps that are taken before those that count: nothing touches
/// in the first three; then a block lies on a plane, and three cloths on a ball and on each other.
/// Laws of contact that are not compiled for the processor's instructions show in the block.
const WORKS: [(&str, Integrator, u32); 5] = [
    ("cloth/31", Integrator::SymplecticEuler, 0),
    ("block/10", Integrator::SymplecticEuler, 0),
    ("irregular/2000", Integrator::SymplecticEuler, 0),
    ("rest/10", Integrator::VelocityVerlet, 0),
    ("drape/9", Integrator::VelocityVerlet, 40),
];
/// Steps counted, each of 12 substeps: the cloth has begun to swing, the block to fall.
const STEPS: u32 = 4;
/// Relative tolerance of a count: the system's copying differs from machine to machine.
const TOLERANCE: f64 = 0.02;
/// The argument that makes this program take steps of a work, and nothing else.
const RUN: &str = "--run";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [run, work, steps] = &arguments[..]
        && run == RUN
    {
        take_steps(work, steps.parse().expect("a number of steps"));
        return ExitCode::SUCCESS;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("instructions: SKIPPED: no valgrind (install it with: apt install valgrind)");
        let required = std::env::var_os("MSD_REQUIRE_VALGRIND").is_some_and(|set| !set.is_empty());
        return if required { ExitCode::FAILURE } else { ExitCode::SUCCESS };
    }
    if Instructions::best() < Instructions::Avx2 {
        println!("instructions: SKIPPED: this processor has no AVX2");
        return ExitCode::SUCCESS;
    }
    let counts = WORKS.map(|(work, _, before)| (work, count(work, before)));
    if arguments.iter().any(|argument| argument == "--write") {
        std::fs::write(page(), text(&counts)).expect("a file to write");
        return ExitCode::SUCCESS;
    }
    compare(&counts)
}

/// Path of the stored counts.
fn page() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../benches/instructions.txt")
}

fn take_steps(work: &str, steps: u32) {
    let (_, integrator, _) = WORKS.into_iter().find(|row| row.0 == work).expect("a work");
    let settings = Settings { integrator, ..workloads::settings() };
    let simulation = Simulation::<f32>::new(&works::scene(work), settings);
    let mut simulation = simulation.expect("a valid scene");
    simulation.set_instructions(Instructions::Avx2);
    (0..steps).for_each(|_| simulation.step().expect("stable"));
}

/// The instructions of a step of a work after so many.
fn count(work: &str, before: u32) -> u64 {
    // The first step compiles the plan.
    let [few, many] = [1, 1 + STEPS].map(|steps| count_run(work, before + steps));
    (many - few) / u64::from(STEPS)
}

/// The instructions of a whole run.
fn count_run(work: &str, steps: u32) -> u64 {
    let program = std::env::current_exe().expect("this program");
    let output = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(program)
        .args([RUN, work, &steps.to_string()])
        // Random numbers and threads of the system have no place in a count.
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("valgrind, which was there");
    let told = String::from_utf8_lossy(&output.stderr);
    let line = told.lines().find_map(|line| line.split_once("I   refs:"));
    let digits = line.map(|(_, number)| number.trim().replace(',', ""));
    let count = digits.and_then(|digits| digits.parse().ok());
    count.unwrap_or_else(|| panic!("no count of {work}: {told}"))
}

fn text(counts: &[(&str, u64)]) -> String {
    let mut text =
        "# Instructions of a step of 12 substeps, f32, AVX2, one thread: symplectic Euler,\n\
                    # velocity Verlet where something touches.\n\
                    # Written by: cargo bench --bench instructions -- --write\n"
            .to_owned();
    let _ = writeln!(text, "compiler {}", compiler::name());
    for (work, count) in counts {
        let _ = writeln!(text, "{work} {count}");
    }
    text
}

fn compare(counts: &[(&str, u64)]) -> ExitCode {
    let kept = std::fs::read_to_string(page()).expect("a file of counts");
    let find =
        |name: &str| kept.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    let (before, now) = (find("compiler").unwrap_or("none"), compiler::name());
    if before != now {
        println!("instructions: SKIPPED: the counts kept are of {before}, here is {now}");
        return ExitCode::SUCCESS;
    }
    let mut code = ExitCode::SUCCESS;
    for &(work, count) in counts {
        let before: f64 = find(work).and_then(|word| word.parse().ok()).expect("a count kept");
        let change = count as f64 / before - 1.0;
        println!("instructions: {work}: {count} a step, {:+.2} %", 100.0 * change);
        if TOLERANCE < change.abs() {
            println!("instructions: {work} is off by more than {} %", 100.0 * TOLERANCE);
            code = ExitCode::FAILURE;
        }
    }
    code
}
