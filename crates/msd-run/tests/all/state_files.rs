//! A run goes on from a state file to the last bit.

use msd_core::glam::DVec3;
use msd_core::{Integrator, Pin, Real, State, Vector};
use msd_run::Runner;
use msd_scene::{AnyState, Loaded, Output, Precision, open, read_state, state_hash, write_state};
use std::io::Write;
use std::path::PathBuf;

fn text_of(state: &AnyState) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state.csv");
    let mut output = Output::create(&path).expect("a file");
    write_state(state, &mut output).expect("room on the disk");
    assert!(!path.exists(), "a file appears when it is whole");
    output.finish().expect("a file");
    std::fs::read_to_string(&path).expect("the file")
}

fn read(text: &str, precision: Precision, count: usize) -> Result<AnyState, String> {
    read_state(text.as_bytes(), precision, ("s.csv", count)).map_err(|error| error.to_string())
}

/// Bits, not values: −0 must come back as −0.
fn assert_same_bits(a: &AnyState, b: &AnyState) {
    assert_eq!(state_hash(a), state_hash(b));
    assert_eq!(a, b);
}

fn resumes_to_the_bit(loaded: &Loaded) {
    let mut whole = Runner::open(loaded).expect("a run");
    for _ in 0..60 {
        whole.step().expect("a step");
    }
    let mut first = Runner::open(loaded).expect("a run");
    for _ in 0..30 {
        first.step().expect("a step");
    }
    let text = text_of(&first.state());
    let state = read(&text, loaded.precision, first.particle_count()).expect("a state file");
    assert_same_bits(&state, &first.state());
    let mut second = Runner::open(loaded).expect("a run");
    second.set_state(&state, 0).expect("a state of this scene");
    for _ in 0..30 {
        second.step().expect("a step");
    }
    assert_same_bits(&second.state(), &whole.state());
}

#[test]
fn thirty_steps_and_thirty_more_are_sixty_for_every_integrator_precision_and_scene() {
    // Contact and damping, pins and damping, several walls, no damping at all.
    for name in ["spinner", "square", "chain", "waffle"] {
        let mut loaded = open(name).expect(name);
        // Explicit Euler needs short steps to stay in the world for a second.
        loaded.settings.substeps = 32;
        for integrator in Integrator::ALL {
            for precision in [Precision::F32, Precision::F64] {
                (loaded.settings.integrator, loaded.precision) = (integrator, precision);
                resumes_to_the_bit(&loaded);
            }
        }
    }
}

#[test]
fn an_undamped_run_with_pins_resumes_to_the_bit() {
    let mut loaded = open("square").expect("a built-in scene");
    loaded.scene.springs.iter_mut().for_each(|spring| spring.damping = 0.0);
    let velocity = DVec3::new(0.1, 0.2, 0.0);
    loaded.scene.pins.push(Pin { particle: 12, velocity });
    resumes_to_the_bit(&loaded);
}

fn state<R: Real>(numbers: &[f64]) -> State<R> {
    let vector = |x: f64, y: f64, z: f64| R::Vec3::of(DVec3::new(x, y, z));
    State {
        positions: numbers.iter().map(|&x| vector(x, -x, 2.0 / 3.0)).collect(),
        velocities: numbers.iter().map(|&x| vector(-x, 0.3, x)).collect(),
    }
}

#[test]
fn every_number_comes_back_to_the_bit() {
    let numbers =
        [0.0f32, -0.0, 1.0, 0.1, -1.5e-45, f32::MIN_POSITIVE, f32::MAX, 16_777_217.0, 1e-7];
    let numbers64 = [0.1f64, -5e-324, f64::MAX, 1.0 / 3.0, 9_007_199_254_740_993.0, -0.0, 2.5];
    let single = AnyState::F32(state(&numbers.map(f64::from)));
    let double = AnyState::F64(state(&numbers64));
    for (state, precision, count) in
        [(single, Precision::F32, numbers.len()), (double, Precision::F64, numbers64.len())]
    {
        let back = read(&text_of(&state), precision, count).expect("a state file");
        assert_same_bits(&back, &state);
    }
}

const HEADER: &str = "particle,x,y,z,vx,vy,vz\n";

#[test]
fn a_state_file_that_does_not_fit_is_refused_by_row_and_column() {
    for (rows, told) in [
        ("0,1,2,3,4,5,6\n", "s.csv: has 1 row, but the scene has 2 particles"),
        ("0,1,2,3,4,5,6\n1,0,0,0,0,0,0\n2,0,0,0,0,0,0\n", "more than 2 rows"),
        ("0,1,2,3,4,5,6\n1,0,0,0,0,x,0\n", "s.csv: row 2: vy is \"x\"; it must be a number"),
        ("0,1,2,3,4,5,6\n1,0,0,0,NaN,0,0\n", "row 2: vx is \"NaN\""),
        ("0,1,2,3,4,5,6\n1,0,0,0,inf,0,0\n", "row 2: vx is \"inf\""),
        (
            "0,1,2,3,4,5,6\n1,1e39,0,0,0,0,0\n",
            "row 2: x is \"1e39\"; it must be a number that is finite in f32",
        ),
        ("1,1,2,3,4,5,6\n0,0,0,0,0,0,0\n", "row 1: particle is \"1\"; it must be 0"),
        ("0,1,2,3,4,5,6\n1,0,0\n", "row 2: the number of values is 3; it must be 7"),
    ] {
        let message = read(&format!("{HEADER}{rows}"), Precision::F32, 2).expect_err(rows);
        assert!(message.contains(told), "{message}");
        assert_eq!(message.lines().count(), 1);
    }
    let message = read("particle,x,y\n0,1,2\n", Precision::F32, 1).expect_err("another header");
    assert!(
        message.contains("the header is \"particle,x,y\"; it must be particle,x,y,z"),
        "{message}"
    );
    assert!(read("", Precision::F32, 1).is_err());
    let bytes: &[u8] = b"particle,x,y,z,vx,vy,vz\n\xff\xfe,1";
    let message = read_state(bytes, Precision::F32, ("s.csv", 1)).expect_err("no text").to_string();
    assert!(message.contains("UTF-8"), "{message}");
}

#[test]
fn a_state_with_columns_of_different_lengths_is_not_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut output = Output::create(&folder.path().join("s.csv")).expect("a file");
    let uneven = State { positions: vec![DVec3::X; 2], velocities: vec![DVec3::X] };
    let refused = write_state(&AnyState::F64(uneven), &mut output).expect_err("a refusal");
    assert!(refused.to_string().ends_with("the state has 2 positions and 1 velocities"));
}

#[test]
fn an_output_that_is_dropped_leaves_nothing_and_an_old_file_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state.csv");
    std::fs::write(&path, "old").expect("a file");
    drop(Output::create(&path).expect("a file"));
    assert_eq!(std::fs::read_to_string(&path).expect("the old file"), "old");
    let names: Vec<PathBuf> =
        folder.path().read_dir().expect("a folder").map(|e| e.expect("a file").path()).collect();
    assert_eq!(names, [path]);
}

#[test]
fn many_write_one_file_at_once_and_none_takes_the_part_of_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state.csv");
    let names = || folder.path().read_dir().expect("a folder").count();
    // Left by a killed program: none holds a lock on it.
    drop(Output::create(&path).expect("a file"));
    let part = |turn: usize| {
        let hash = blake3::hash(b"state.csv").to_hex();
        folder.path().join(format!(".msd-{}-{turn}.part", &hash[..16]))
    };
    for turn in [0, 3] {
        std::fs::write(part(turn), "left").expect("a file");
    }
    let writers: Vec<Output> = (0..4).map(|_| Output::create(&path).expect("a file")).collect();
    assert_eq!(names(), 4);
    for (row, mut output) in writers.into_iter().enumerate() {
        write!(output, "{row}").expect("room on the disk");
        output.finish().expect("room on the disk");
        assert_eq!(std::fs::read_to_string(&path).expect("the file"), row.to_string());
    }
    assert_eq!(names(), 1);
}

#[test]
fn writers_that_come_and_go_clear_away_no_part_that_is_in_use() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state.csv");
    let write = || {
        for _ in 0..300 {
            let mut output = Output::create(&path).expect("a part of its own");
            write!(output, "whole").expect("room on the disk");
            output.finish().expect("its part is still there");
        }
    };
    std::thread::scope(|threads| (0..4).for_each(|_| drop(threads.spawn(write))));
    assert_eq!(std::fs::read_to_string(&path).expect("the file"), "whole");
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 1);
}

#[test]
fn an_output_without_a_place_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (path, told) in [
        (folder.path().to_path_buf(), "it is a folder"),
        (folder.path().join("none").join("s.csv"), "there is no folder"),
        (folder.path().join("s.csv").join(""), "it is a folder"),
    ] {
        let message = Output::create(&path).expect_err("no place").to_string();
        assert!(message.contains(told), "{message}");
    }
}
