//! `msd bench`: its workloads, and the positions that it writes.

use crate::common::{folder, json, outcome, quiet};
use msd_run::Runner;
use msd_scene::{Precision, workloads};
use msd_study::trial::state;
use std::path::Path;
use std::process::Command;

fn msd(folder: &Path, arguments: &[&str]) -> Command {
    crate::common::msd(folder, &[&["bench"], arguments].concat())
}

/// Returns the error of `msd bench`, which must be one line and leave no file.
fn refused(arguments: &[&str], code: i32) -> String {
    let folder = folder();
    let told = crate::common::refused(msd(folder.path(), arguments), code);
    assert_eq!(folder.path().read_dir().unwrap().count(), 0, "{arguments:?}");
    told
}

/// Reads the positions of a file: x, y, z of each particle.
fn read(path: &Path) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(path).expect("positions");
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("8 bytes"));
    assert_eq!(bytes.len() % 24, 0);
    bytes.chunks(24).map(|row| [0, 8, 16].map(|at| number(&row[at..at + 8]))).collect()
}

#[test]
fn a_measured_cloth_tells_the_documented_keys_and_counts() {
    let folder = folder();
    let told = json(msd(folder.path(), &["cloth", "8"]));
    let keys = "scene size particles springs integrator step substeps precision instructions \
        threads updates_per_second ms_per_frame batches frames_per_batch device on_device \
        peak_memory_bytes";
    let found: Vec<&str> = told.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(found.join(" "), keys.split_whitespace().collect::<Vec<_>>().join(" "));
    assert_eq!(told["scene"], "cloth 8");
    assert_eq!((&told["particles"], &told["springs"]), (&64.into(), &210.into()));
    assert_eq!(
        (&told["integrator"], &told["precision"]),
        (&"symplectic-euler".into(), &"f32".into())
    );
    assert_eq!((&told["substeps"], &told["threads"]), (&12.into(), &1.into()));
    assert!((told["step"].as_f64().unwrap() - 1.0 / 720.0).abs() < 1e-15);
    assert!(20 <= told["batches"].as_u64().unwrap());
    // The median appears in both units; each update of a frame is one spring in one substep.
    let wall = told["ms_per_frame"]["wall"].as_f64().unwrap();
    let median = told["updates_per_second"]["median"].as_f64().unwrap();
    assert!((1e-3 * wall * median / (12.0 * 210.0) - 1.0).abs() < 1e-9);
    assert!(median <= told["updates_per_second"]["best"].as_f64().unwrap());
    assert!(0.0 < told["ms_per_frame"]["cpu"].as_f64().unwrap());
    // The rows of the scene alone exceed this, if the system reports the memory.
    assert!(told["peak_memory_bytes"].as_u64().is_none_or(|bytes| 10_000 < bytes));
}

#[test]
fn every_evaluation_of_the_forces_counts() {
    let folder = folder();
    for (integrator, evaluations) in
        [("velocity-verlet", Some(6.0)), ("rk4", Some(20.0)), ("backward-euler", None)]
    {
        let arguments = ["block", "3", "--substeps", "5", "--precision", "f64"];
        let arguments = [&arguments[..], &["--threads", "2", "--integrator", integrator]].concat();
        let told = json(msd(folder.path(), &arguments));
        assert_eq!((&told["integrator"], &told["threads"]), (&integrator.into(), &2.into()));
        let springs = told["springs"].as_f64().unwrap();
        assert_eq!(springs, 158.0);
        let seconds = 1e-3 * told["ms_per_frame"]["wall"].as_f64().unwrap();
        let updates = told["updates_per_second"]["median"].as_f64();
        let counted = updates.map(|updates| (updates * seconds / springs).round());
        assert_eq!(counted, evaluations, "{integrator}");
    }
}

#[test]
fn positions_are_those_of_a_run_through_the_library_to_the_bit() {
    let folder = folder();
    let path = folder.path().join("p.bin");
    for (work, size, scene) in [
        ("cloth", "8", workloads::cloth(8).unwrap()),
        ("block", "4", workloads::block(4).unwrap()),
        ("irregular", "300", workloads::irregular(300).unwrap()),
        ("drape", "5", workloads::drape(5).unwrap()),
    ] {
        for precision in [Precision::F32, Precision::F64] {
            let name = precision.name();
            // The library uses the best instructions, which give the same bits as the plain ones.
            let arguments = [work, size, "--precision", name, "--positions", "p.bin"];
            let arguments = [&arguments[..], &["--instructions", "plain"]].concat();
            let told = quiet(msd(folder.path(), &arguments));
            assert!(told.lines().any(|line| line == "positions at t = 1 s in p.bin"), "{told}");
            let mut runner = Runner::new(&scene, workloads::settings(), precision).unwrap();
            (0..60).for_each(|_| runner.step().unwrap());
            let right = state(&runner).positions;
            let right: Vec<[f64; 3]> = right.iter().map(|position| position.to_array()).collect();
            let found = read(&path);
            assert!(found == right, "{work} {name}");
            assert!(found.iter().any(|[_, y, _]| *y < 0.5), "{work} has fallen");
            let (first, last) = (found[0], found[found.len() - 1]);
            if work == "cloth" {
                assert_eq!((first, found[7 * 8]), ([0.0; 3], [7.0, 0.0, 0.0]));
                assert!(last[1] < -0.5, "{last:?}");
            }
        }
    }
}

#[test]
fn a_file_that_is_there_is_replaced_or_left_alone() {
    let folder = folder();
    let path = folder.path().join("p.bin");
    std::fs::write(&path, "mine").unwrap();
    let diverging = ["cloth", "8", "--substeps", "1", "--positions", "p.bin"];
    let output = outcome(msd(folder.path(), &diverging));
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
    quiet(msd(folder.path(), &["cloth", "2", "--positions", "p.bin"]));
    assert_eq!(read(&path).len(), 4);
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}

#[test]
fn what_diverges_ends_with_the_error_of_a_run_and_writes_nothing() {
    let told = refused(&["cloth", "8", "--substeps", "1", "--positions", "p.bin", "--json"], 3);
    assert!(told.starts_with("error: cloth 8: diverged: particle"), "{told}");
    assert!(told.contains("use more substeps") && !told.contains("--step auto"), "{told}");
}

#[test]
fn bad_input_is_refused_in_one_line() {
    for (arguments, parts) in [
        (&["cloth"][..], &["<N>"][..]),
        (&["rope", "8"], &["rope", "cloth, block"]),
        (&["cloth", "1"], &["'1'", "<N>", "from 2 to 1000000"]),
        (&["cloth", "-3"], &["from 2 to 1000000"]),
        (&["block", "many"], &["from 2 to 1000000"]),
        (
            &["cloth", "100000", "--memory", "4"],
            &["cloth: its size asks for 10000000000 particles", "4.0 GB fit; --memory allows more"],
        ),
        (&["block", "1000"], &["block: its size asks for 1000000000 particles"]),
        (&["cloth", "8", "--instructions", "mmx"], &["--instructions", "has: plain"]),
        (&["cloth", "8", "--pin", "5000"], &["--pin 5000: "]),
        (&["drape", "1"], &["'1'", "<N>", "from 2 to 1000000"]),
        (&["cloth", "8", "--threads", "0"], &["--threads", "from 1 to 1024"]),
        (&["cloth", "8", "--threads", "1025"], &["--threads", "from 1 to 1024"]),
        (&["cloth", "8", "--threads", "-1"], &["--threads", "from 1 to 1024"]),
        (&["cloth", "8", "--substeps", "0"], &["--substeps", "from 1 to"]),
        (&["cloth", "8", "--substeps", "4000000000"], &["--substeps 4000000000", "weeks"]),
        (&["cloth", "8", "--integrator", "rk5"], &["did you mean `rk4`?"]),
        (&["cloth", "8", "--precision", "f16"], &["must be f32 or f64"]),
        (&["cloth", "8", "--positions", "no/p.bin"], &["no/p.bin", "there is no folder"]),
        (&["cloth", "8", "--positions", "."], &["it is a folder"]),
    ] {
        let told = refused(arguments, 2);
        for part in parts {
            assert!(told.contains(part), "{arguments:?}: {told}: {part}");
        }
    }
}
