//! Any bytes at every boundary of msd: the targets of `fuzz/` on their corpora, on mutations of
//! these and on random bytes. They run without libFuzzer, on the same inputs on every machine, and
//! within a fixed memory.
//!
//! `MSD_MUTATIONS=3000` runs as many of either per target instead of the default of 500.

#[path = "../../../fuzz/src/lib.rs"]
mod targets;

use arbitrary::Unstructured;
use cap::Cap;
use msd_core::glam::DVec3;
use msd_core::{Interaction, Settings, Simulation};
use msd_run::Runner;
use msd_run::recording::{Event, Recorder};
use msd_scene::{BUILTINS, Output, Precision};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::alloc::System;
use std::fs;
use std::path::{Path, PathBuf};
use targets::{TARGETS, world};

/// No input of some kilobytes may ask for more, bytes; a header that promises a gigabyte of rows
/// would. The tests run side by side.
const MEMORY: usize = 400 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MEMORY);

/// The longest input, bytes.
const LONGEST: usize = 4096;

/// Pieces that turn up where mistakes are made.
const PIECES: &str = "nan inf -inf 1e999 -1 0 4294967296 18446744073709551616 1e-39 3.5e38 , [ ] { \
                      } \" = \0\0\0\0 \n \u{7f} \u{1b}";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

fn corpus_folder(target: &str) -> PathBuf {
    folder().join("corpus").join(target)
}

/// The seeds of a target in the order of their names, so that every machine makes the same inputs,
/// and the built-in scenes.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let entries = fs::read_dir(corpus_folder(target)).expect("a corpus");
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut seeds: Vec<_> = paths.iter().map(|path| fs::read(path).expect("a seed")).collect();
    if target == "scenes" {
        seeds.extend(BUILTINS.map(|builtin| builtin.text.into()));
    }
    seeds
}

/// A number below `limit`, which is not 0.
fn below(lot: &mut Pcg32, limit: usize) -> usize {
    lot.next_u32() as usize % limit
}

/// Changes some bytes of one seed, a few times over; inserts pieces or parts of another.
fn mutate(lot: &mut Pcg32, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[below(lot, seeds.len())].clone();
    let pieces: Vec<&str> = PIECES.split(' ').collect();
    for _ in 0..=below(lot, 4) {
        let from = below(lot, bytes.len() + 1);
        let to = (from + below(lot, 9)).min(bytes.len());
        match below(lot, 5) {
            0 if from < bytes.len() => bytes[from] ^= 1 << below(lot, 8),
            1 if from < bytes.len() => bytes[from] = lot.next_u32() as u8,
            2 => drop(bytes.splice(from..to, pieces[below(lot, pieces.len())].bytes())),
            3 => drop(bytes.drain(from..to)),
            _ => {
                let other = &seeds[below(lot, seeds.len())];
                let start = below(lot, other.len() + 1);
                let end = (start + below(lot, 65)).min(other.len());
                drop(bytes.splice(from..to, other[start..end].iter().copied()));
            }
        }
    }
    bytes.truncate(LONGEST);
    bytes
}

/// Random bytes behind the start of a seed, which may be empty.
fn random(lot: &mut Pcg32, seeds: &[Vec<u8>]) -> Vec<u8> {
    let seed = &seeds[below(lot, seeds.len())];
    let kept = if below(lot, 2) == 0 { 0 } else { below(lot, seed.len().min(LONGEST) + 1) };
    let mut tail = vec![0; below(lot, 512)];
    lot.fill_bytes(&mut tail);
    [&seed[..kept], &tail].concat()
}

/// Runs a target on its corpus, on mutations of it and on random bytes.
fn rehearse(target: &str) {
    let (_, check) = TARGETS.into_iter().find(|(name, _)| *name == target).expect("a target");
    let seeds = corpus(target);
    assert!(!seeds.is_empty(), "the corpus of {target} is empty");
    seeds.iter().for_each(|bytes| check(bytes));
    // Any seed would do; a fixed one fails alike everywhere.
    let mut lot = Pcg32::new(2014, 0xa02b_dbf7_bb3c_0a7a);
    let mutations = std::env::var("MSD_MUTATIONS").ok().and_then(|count| count.parse().ok());
    for _ in 0..mutations.unwrap_or(500) {
        for bytes in [mutate(&mut lot, &seeds), random(&mut lot, &seeds)] {
            // Shown only where the check panics.
            println!("{target}: b\"{}\"", bytes.escape_ascii());
            check(&bytes);
        }
    }
}

#[test]
fn scenes_are_refused_or_run() {
    rehearse("scenes");
}

#[test]
fn states_are_refused_or_go_on() {
    rehearse("states");
}

#[test]
fn meshes_are_refused_or_made_bodies() {
    rehearse("meshes");
}

#[test]
fn interactions_are_refused_or_leave_a_state_in_the_world() {
    rehearse("interactions");
}

#[test]
fn a_fair_share_of_the_scenes_made_of_random_bytes_is_valid() {
    let mut lot = Pcg32::new(2014, 0xa02b_dbf7_bb3c_0a7a);
    let mut is_valid = |_: &usize| {
        let mut bytes = [0; 512];
        lot.fill_bytes(&mut bytes);
        let scene = world::scene(&mut Unstructured::new(&bytes)).expect("enough bytes");
        Simulation::<f32>::new(&scene, Settings::default()).is_ok()
    };
    let valid = (0..400).filter(|row| is_valid(row)).count();
    // A test of refusals alone would pass whatever a step does, one of valid scenes alone whatever
    // the checks let in. Of the mutations of seeds more are valid.
    assert!((40..320).contains(&valid), "{valid} of 400");
}

#[test]
fn runs_with_right_checksums_are_refused_or_go_on() {
    // A seed of another format would be refused at its first line, and try nothing.
    let seeds = corpus("runs");
    let is_read = |bytes: &Vec<u8>| {
        msd_scene::read_saved(bytes, "").is_ok()
            || msd_run::recording::read_recording(bytes, "").is_ok()
    };
    let hint = "where a format has changed: cargo test --test rehearsal -- --ignored seeds_of_runs";
    assert!(seeds.iter().all(is_read), "{hint}");
    rehearse("runs");
}

/// A little of all that a scene may have.
const SEED: &str = r#"
version = 1
[solver]
substeps = 4
[[world.planes]]
friction = 0.5
[[world.solids]]
kind = "mesh"
file = "ball.obj"
length = 0.6
cell = 0.25
position = [0, 0.3, 0]
[[world.solids]]
kind = "capsule"
radius = 0.1
length = 0.3
springs = true
position = [0.5, 0.2, 0]
spin = [0, 1, 0]
[[world.solids]]
kind = "box"
size = [0.3, 0.2, 0.3]
position = [-0.5, 0.1, 0]
key_frames = [{ time = 1, position = [-0.5, 0.4, 0] }, { time = 2, position = [-0.4, 0.4, 0] }]
[[bodies]]
kind = "block"
size = [2, 2, 2]
spacing = 0.2
young = 1000
poisson = 0.3
density = 100
relaxation_time = 0.01
position = [0, 0.8, 0]
touch = { obstacles = true, thickness = 0.05 }
[[bodies]]
name = "rope"
kind = "rope"
size = [3]
spacing = 0.2
diameter = 0.02
young = 100000
density = 1000
position = [0.2, 1.2, 0.1]
touch = { ignore = ["block"] }
[[pins]]
body = "rope"
particle = 0
"#;

const TETRAHEDRON: &str = "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\n\
                           f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
#[ignore = "makes the seeds of fuzz/corpus/runs anew, for another format"]
fn the_seeds_of_runs_are_made_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("seed.toml");
    fs::write(&scene, SEED).expect("a file");
    fs::write(folder.path().join("ball.obj"), TETRAHEDRON).expect("a file");
    let mut loaded = msd_scene::open(&scene).expect("a scene");
    for precision in [Precision::F32, Precision::F64] {
        loaded.precision = precision;
        let mut runner = Runner::open(&loaded).expect("a run");
        let seed = |name: &str| corpus_folder("runs").join(format!("{name}-{precision}"));
        let recording = seed("recording");
        let start = runner.to_loaded("test", "a test");
        let mut recorder = Recorder::begin(&recording, &start).expect("a file");
        for second in 0..6 {
            let target = DVec3::new(0.1, 1.0, 0.1 * f64::from(second));
            let grab = Interaction::Grab {
                particle: 9,
                target,
                frequency: 2.0,
                damping_ratio: 1.0,
                max_force: 10.0,
            };
            runner.queue(grab).expect("a valid interaction");
            runner.apply_queued().expect("a valid interaction");
            recorder.add(&Event::Act(grab)).expect("room on the disk");
            runner.step().expect("a step");
            recorder.step().expect("room on the disk");
        }
        recorder.finish(&runner).expect("room on the disk");
        let output = Output::create(&seed("saved")).expect("a file");
        msd_scene::write_saved(&runner.to_loaded("test", "a test"), output).expect("room");
    }
}

#[test]
fn every_target_has_a_corpus_and_a_program() {
    let manifest = fs::read_to_string(folder().join("Cargo.toml")).expect("a manifest");
    for (name, _) in TARGETS {
        assert!(folder().join("corpus").join(name).is_dir(), "{name}");
        let program = format!("fuzz_targets/{name}.rs");
        assert!(folder().join(&program).exists() && manifest.contains(&program), "{name}");
    }
}
