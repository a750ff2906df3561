//! The same bits at the end of a scene: today and tomorrow, debug and release, here and elsewhere.
//!
//! `hashes.txt` keeps the hash of a state after ten seconds for each built-in scene, and for some
//! small ones under every method in both precisions. Where a change of bits is meant, renew it by
//! `MSD_RENEW=1 cargo test -p msd-run --test same_bits` and say why in the change.

use msd_run::Runner;
use msd_run::kept::{KEPT_STEPS, KeptRun, SMALL, Verification, kept_line};
use msd_scene::{AnyState, Loaded, Output, load_state, state_hash, write_state};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

const HEADER: &str = "# scene method precision hash, after 600 steps; see same_bits.rs\n";

const HINT: &str = "a change of bits that is meant is kept by MSD_RENEW=1 cargo test -p msd-run \
    --test same_bits, and its reason told in CHANGELOG.md";

/// A scene under a method in a precision.
#[derive(Clone, Debug)]
struct Run(Loaded);

impl Run {
    fn of(kept: &KeptRun) -> Self {
        Run(kept.load().expect(kept.scene))
    }

    fn start(&self) -> Runner {
        Runner::open(&self.0).expect("a built-in scene runs")
    }

    fn end(&self) -> AnyState {
        let mut runner = self.start();
        advance(&mut runner, KEPT_STEPS);
        runner.state()
    }

    fn line(&self) -> String {
        kept_line(&self.0, &self.end()) + "\n"
    }
}

fn advance(runner: &mut Runner, steps: u64) {
    for _ in 0..steps {
        runner.step().expect("a built-in scene stays in the world");
    }
}

fn small_runs() -> Vec<Run> {
    KeptRun::small().iter().map(Run::of).collect()
}

/// Does something for each run, all at once, each on a thread of its own.
fn at_once<T: Send>(runs: &[Run], what: impl Fn(&Run) -> T + Sync) -> Vec<T> {
    thread::scope(|scope| {
        let what = &what;
        let threads: Vec<_> = runs.iter().map(|run| scope.spawn(move || what(run))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a run that ends")).collect()
    })
}

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// Returns whether the bytes of a kept file are these; makes them so where a renewal is asked for.
fn is_kept(path: &str, bytes: &[u8]) -> bool {
    let path = in_repository(path);
    if std::env::var_os("MSD_RENEW").is_some() {
        fs::write(&path, bytes).expect("a folder of the repository");
    }
    fs::read(&path).is_ok_and(|kept| kept == bytes)
}

#[test]
fn every_run_ends_in_the_bits_that_are_kept() {
    let runs: Vec<Run> = KeptRun::all().iter().map(Run::of).collect();
    let found = HEADER.to_owned() + &at_once(&runs, Run::line).concat();
    let path = "crates/msd-run/tests/hashes.txt";
    let kept = is_kept(path, found.as_bytes());
    let text = fs::read_to_string(in_repository(path)).unwrap_or_default();
    let changed: Vec<&str> =
        found.lines().filter(|line| !text.lines().any(|kept| kept == *line)).collect();
    assert!(kept, "{path} does not say\n{}\n{HINT}", changed.join("\n"));
}

#[test]
fn a_run_ends_in_the_same_bits_again_and_on_any_thread() {
    let runs = small_runs();
    let elsewhere = at_once(&runs, Run::end);
    for (run, elsewhere) in runs.iter().zip(&elsewhere) {
        assert_eq!(state_hash(&run.end()), state_hash(elsewhere), "{}", run.line());
    }
}

#[test]
fn a_run_that_goes_on_from_a_state_file_ends_in_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state.csv");
    for run in small_runs() {
        let mut first = run.start();
        advance(&mut first, KEPT_STEPS / 2);
        let mut output = Output::create(&path).expect("a file");
        write_state(&first.state(), &mut output).expect("room on the disk");
        output.finish().expect("a file");
        let state = load_state(&path, run.0.precision, first.particle_count());
        let mut second = run.start();
        let state = state.expect("a state file");
        second.set_state(&state, KEPT_STEPS / 2).expect("a state of this scene");
        advance(&mut second, KEPT_STEPS / 2);
        assert_eq!(state_hash(&second.state()), state_hash(&run.end()), "{}", run.line());
    }
}

#[test]
fn the_scenes_that_run_without_an_operating_system_are_those_of_today() {
    for name in SMALL {
        let Loaded { scene, settings, .. } = Run::of(&KeptRun { scene: name, solver: None }).0;
        let bytes = postcard::to_stdvec(&(scene, settings)).expect("rows of numbers");
        let path = format!("bare/scenes/{name}.postcard");
        assert!(is_kept(&path, &bytes), "{path} is not the scene of today; {HINT}");
    }
}

#[test]
fn a_verification_in_slices_of_one_step_finds_the_kept_bits() {
    let mut verification = Verification::of(KeptRun::small());
    let (_, all) = verification.progress();
    let mut slices = 0;
    while !verification.is_done() {
        verification.go_on(|| true);
        slices += 1;
    }
    assert_eq!(verification.wrong(), [] as [String; 0]);
    // A slice for each step, and one to open each.
    assert!(all * KEPT_STEPS as usize <= slices, "{slices}");
}
