//! Does every target hold on its corpus, and on thousands of mutations of it? Without libFuzzer,
//! the same ones on every machine, and within a fixed memory.

use cap::Cap;
use msd_fuzz::TARGETS;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::alloc::System;
use std::fs;
use std::path::Path;

/// No input of some kilobytes may ask for more, bytes; a header that promises a gigabyte of rows
/// would. The tests run side by side.
const MEMORY: usize = 400 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MEMORY);

/// Mutations per target.
const MUTATIONS: u32 = 3000;
/// The longest input, bytes.
const LONGEST: usize = 4096;

/// Pieces that turn up where mistakes are made.
const PIECES: [&[u8]; 24] = [
    b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"4294967296", b"18446744073709551616", b"1e-39",
    b"3.5e38", b"\n", b" ", b",", b"[", b"]", b"{", b"}", b"\"", b"=", b"\0", b"\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff", b"\xff\xff\xff\x7f", b"\x80",
];

/// The seeds of a target in the order of their names, so that every machine makes the same inputs.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    let mut paths: Vec<_> =
        fs::read_dir(folder).expect("a corpus").flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("a seed")).collect()
}

/// A number below `limit`, which is not 0.
fn below(lot: &mut Pcg32, limit: usize) -> usize {
    lot.next_u32() as usize % limit
}

/// Changes some bytes of one seed, a few times over; what is put in is a piece or part of another.
fn mutate(lot: &mut Pcg32, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[below(lot, seeds.len())].clone();
    for _ in 0..=below(lot, 4) {
        let from = below(lot, bytes.len() + 1);
        let to = (from + below(lot, 9)).min(bytes.len());
        match below(lot, 5) {
            0 if from < bytes.len() => bytes[from] ^= 1 << below(lot, 8),
            1 if from < bytes.len() => bytes[from] = lot.next_u32() as u8,
            2 => drop(bytes.splice(from..to, PIECES[below(lot, PIECES.len())].iter().copied())),
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

/// Runs a target on its corpus and on mutations of it.
fn rehearse(target: &str) {
    let (_, check) = TARGETS.into_iter().find(|(name, _)| *name == target).expect("a target");
    let seeds = corpus(target);
    assert!(!seeds.is_empty(), "the corpus of {target} is empty");
    seeds.iter().for_each(|bytes| check(bytes));
    // Any seed would do; a fixed one fails alike everywhere.
    let mut lot = Pcg32::new(2014, 0xa02b_dbf7_bb3c_0a7a);
    for _ in 0..MUTATIONS {
        let bytes = mutate(&mut lot, &seeds);
        // Shown only where the check panics.
        println!("{target}: b\"{}\"", bytes.escape_ascii());
        check(&bytes);
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
fn every_target_has_a_corpus_and_a_program() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (name, _) in TARGETS {
        assert!(root.join("fuzz_targets").join(format!("{name}.rs")).exists(), "{name}");
        assert!(root.join("corpus").join(name).is_dir(), "{name}");
    }
}
