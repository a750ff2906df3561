//! `msd export`, and states in other formats: contents, and refusals.

use crate::common::{done, folder, json, msd, names, quiet, refused};
use std::fs;
use std::path::Path;

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

#[test]
fn a_run_is_written_moment_by_moment() {
    let folder = folder();
    let path = folder.path();
    let export = |to: &str| {
        let run = ["export", "chain", "--duration", "1", "--every", "1/10", "--to", to];
        json(msd(path, &run))
    };
    let report = export("c.pc2");
    assert_eq!((&report["moments"], &report["time"]), (&11.into(), &1.0.into()));
    assert_eq!(report["files"], serde_json::json!(["c.pc2", "c.obj"]));
    let cache = fs::read(path.join("c.pc2")).expect("c.pc2");
    // Five particles in a chain; a header of 32 bytes before their eleven moments.
    assert_eq!((&cache[..12], word(&cache, 16), word(&cache, 28)), (&b"POINTCACHE2\0"[..], 5, 11));
    assert_eq!(cache.len(), 32 + 11 * 5 * 12);
    let mesh = fs::read_to_string(path.join("c.obj")).expect("c.obj");
    assert_eq!(mesh.lines().filter(|line| line.starts_with("v ")).count(), 5);
    assert_eq!(mesh.lines().filter(|line| line.starts_with("l ")).count(), 4);
    export("c.mdd");
    let mdd = fs::read(path.join("c.mdd")).expect("c.mdd");
    assert_eq!(mdd[..8], [0, 0, 0, 11, 0, 0, 0, 5]);
    assert_eq!(mdd.len(), 8 + 11 * 4 + 11 * 5 * 12);
    // The same numbers in the opposite byte order.
    let turned: Vec<u8> = mdd[52..].chunks(4).flat_map(|four| four.iter().rev().copied()).collect();
    assert!(turned == cache[32..]);
    export("c.glb");
    let glb = fs::read(path.join("c.glb")).expect("c.glb");
    assert_eq!((&glb[..4], word(&glb, 8) as usize), (&b"glTF"[..], glb.len()));
    export("c.pvd");
    assert_eq!(names(path).iter().filter(|name| name.ends_with(".vtu")).count(), 11);
}

/// Reads the JSON of a GLB file, and its vectors of three by accessor.
fn glb(bytes: &[u8]) -> (serde_json::Value, impl Fn(&serde_json::Value) -> Vec<[f32; 3]> + '_) {
    let length = word(bytes, 12) as usize;
    let document: serde_json::Value =
        serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    let binary = &bytes[28 + length..];
    let known = document.clone();
    let vectors = move |accessor: &serde_json::Value| {
        let accessor = &known["accessors"][accessor.as_u64().expect("a number") as usize];
        let view = &known["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
        let number = |key: &str| view[key].as_u64().expect("a number") as usize;
        let bytes = &binary[number("byteOffset")..][..number("byteLength")];
        let (threes, _) = bytes.as_chunks::<12>();
        let float = |three: &[u8; 12], axis: usize| {
            f32::from_le_bytes(*three[4 * axis..].first_chunk().expect("four bytes"))
        };
        threes.iter().map(|three| [0, 1, 2].map(|axis| float(three, axis))).collect()
    };
    (document, vectors)
}

#[test]
fn normals_of_a_glb_follow_the_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("spin.toml");
    // The undeformed cloth rotates by a quarter: its normal turns from z to x.
    let text = "version = 1\n[world]\ngravity = [0, 0, 0]\n[[bodies]]\nkind = 'cloth'\n\
                size = [3, 3]\nspin = [0, 1.5707963, 0]\nstiffness = 1e4\nmass = 0.01\n\
                damping = 1\n[solver]\nsubsteps = 400\n";
    fs::write(path, text).expect("a file");
    let export = ["export", "spin.toml", "--to", "s.glb", "--duration", "1", "--every", "0.5"];
    done(msd(folder.path(), &export));
    let bytes = fs::read(folder.path().join("s.glb")).expect("s.glb");
    let (document, vectors) = glb(&bytes);
    let primitive = &document["meshes"][0]["primitives"][0];
    let start = vectors(&primitive["attributes"]["NORMAL"]);
    assert_eq!(start.len(), 9);
    let side = start[0][2];
    assert!(side.abs() == 1.0 && start.iter().all(|normal| *normal == [0.0, 0.0, side]));
    let targets = primitive["targets"].as_array().expect("targets");
    let turned = vectors(&targets[1]["NORMAL"]);
    for (start, turn) in start.iter().zip(turned) {
        let normal = [0, 1, 2].map(|axis| start[axis] + turn[axis]);
        let expected = [side, 0.0, 0.0];
        let apart = (0..3).map(|axis| (normal[axis] - expected[axis]).abs());
        assert!(apart.fold(0.0, f32::max) < 1e-3, "{normal:?}");
    }
}

#[test]
fn a_moment_is_that_of_the_end() {
    let folder = folder();
    let path = folder.path();
    quiet(msd(path, &["run", "chain", "--duration", "1", "--out", "s.csv", "-q"]));
    let exported = ["export", "chain", "--duration", "1", "--to"];
    for to in ["t.csv", "t.obj", "t.ply", "t.vtu"] {
        let report = json(msd(path, &[&exported[..], &[to]].concat()));
        assert_eq!((&report["moments"], &report["every"]), (&1.into(), &serde_json::Value::Null));
    }
    let read = |name: &str| fs::read(path.join(name)).expect(name);
    assert!(read("s.csv") == read("t.csv"));
    for ending in ["obj", "ply", "vtu"] {
        let state = format!("s.{ending}");
        quiet(msd(path, &["run", "chain", "--duration", "1", "-q", "--out", &state]));
        assert!(read(&state) == read(&format!("t.{ending}")), "{ending}");
    }
}

#[test]
fn equal_runs_give_equal_files_and_a_state_without_an_ending_is_csv() {
    let folder = folder();
    let path = folder.path();
    for to in ["a.npz", "b.npz"] {
        done(msd(path, &["export", "chain", "--duration", "0.5", "--to", to]));
    }
    let read = |name: &str| fs::read(path.join(name)).expect(name);
    assert!(read("a.npz") == read("b.npz"));
    quiet(msd(path, &["run", "chain", "--duration", "0", "-q", "--out", "state"]));
    assert!(read("state").starts_with(b"particle,x,y,z"));
}

#[test]
fn what_no_file_can_be_written_as_is_refused_before_the_run() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a mesh");
    let refuse = |arguments: &[&str], told: &str| {
        let said = refused(msd(path, arguments), 2);
        assert!(said.contains(told), "{said}");
        assert_eq!(names(path), ["m.obj"], "{arguments:?}");
    };
    let long = ["--duration", "1e6"];
    let run = |out| [&["run", "chain", "--out", out], &long[..]].concat();
    let endings = "use .csv, .npz, .obj, .ply or .vtu";
    refuse(&run("a.txt"), &format!("a.txt: cannot write a state as .txt; {endings}"));
    refuse(&run("a.pc2"), "a.pc2: a .pc2 file holds a run over time, which msd export writes");
    let export = |to, duration| ["export", "chain", "--to", to, "--duration", duration];
    refuse(&export("a.blend", "1e6"), "a.blend: unknown extension; use .csv");
    refuse(&export("nowhere/a.npz", "1e4"), "nowhere/a.npz: cannot be written");
    refuse(&export("a.glb", "1e4"), "at most 1000 moments, not 300001; lengthen --every");
    let fast = [&export("a.npz", "1")[..], &["--every", "1e-3"]].concat();
    refuse(&fast, "--every: 1 ms is less than a step of the run, 16.67 ms");
    let wrong = [&export("a.npz", "1")[..], &["--every", "1/0"]].concat();
    refuse(&wrong, "must be a number or a fraction such as 1/30");
    // The mesh of a cache is written beside it.
    let own = ["export", "m.obj", "--to", "m.pc2"];
    refuse(&own, "SCENE and the mesh of --to name the same file, m.obj");
    if cfg!(not(feature = "parquet")) {
        refuse(&export("a.parquet", "1"), "this msd was built without Parquet");
    }
}

#[test]
fn a_run_that_diverges_is_written_up_to_then() {
    let folder = folder();
    let blows_up = ["--integrator", "explicit-euler", "--substeps", "4", "--every", "1/60"];
    let export = [&["export", "jelly", "--to", "j.npz", "--json"], &blows_up[..]].concat();
    let output = crate::common::outcome(msd(folder.path(), &export));
    assert_eq!(output.status.code(), Some(3), "{}", crate::common::text(&output.stderr));
    let report = crate::common::parse(&crate::common::text(&output.stdout));
    assert_eq!((&report["diverged"], &report["interrupted"]), (&true.into(), &false.into()));
    let moments = report["moments"].as_u64().expect("a number");
    assert!((1..300).contains(&moments), "{moments}");
    assert!(folder.path().join("j.npz").exists());
}

#[test]
fn moments_between_steps_are_those_nearest_and_it_is_said() {
    let folder = folder();
    let export = ["export", "chain", "--duration", "1", "--every", "1/24", "--to", "c.npz"];
    let output = crate::common::outcome(msd(folder.path(), &export));
    let told = "warning: --every: not all moments are at the end of a step of 16.67 ms; the \
                nearest are taken\n";
    assert_eq!((output.status.code(), crate::common::text(&output.stderr)), (Some(0), told.into()));
    // `-q` hides the warning.
    quiet(msd(folder.path(), &[&export[..], &["-q"]].concat()));
}

#[cfg(unix)]
mod interrupted {
    use super::*;
    use std::process::{Child, Command, Output, Stdio};

    /// Sends Ctrl-C to a command once it writes, and waits for its end.
    fn interrupt(folder: &Path, arguments: &[&str]) -> Output {
        send("-INT", folder, arguments)
    }

    /// Sends a signal to a command once it writes, and waits for its end.
    fn send(signal: &str, folder: &Path, arguments: &[&str]) -> Output {
        let mut command = msd(folder, arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child: Child = command.spawn().expect("msd starts");
        let begun = || names(folder).iter().any(|name| name.ends_with(".part"));
        while !begun() {
            std::thread::yield_now();
        }
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.expect("kill starts").success());
        child.wait_with_output().expect("msd ends")
    }

    #[test]
    fn ctrl_c_ends_a_run_with_whole_files_and_leaves_no_part() {
        let folder = folder();
        let run = ["run", "chain", "--duration", "1e6", "--json"];
        let files = ["--out", "s.csv", "--trace", "t.csv", "--save", "r.msd"];
        let output = interrupt(folder.path(), &[&run[..], &files].concat());
        let said = crate::common::text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.starts_with("error: interrupted at t = "), "{said}");
        let report = crate::common::parse(&crate::common::text(&output.stdout));
        assert_eq!((&report["interrupted"], &report["diverged"]), (&true.into(), &false.into()));
        assert_eq!(names(folder.path()), ["r.msd", "s.csv", "t.csv"]);
        let steps = report["time"].as_f64().expect("a time") * 60.0;
        let trace = fs::read_to_string(folder.path().join("t.csv")).expect("t.csv");
        assert_eq!(trace.lines().count(), 2 + steps.round() as usize);
        let resumed = json(msd(folder.path(), &["run", "r.msd", "--duration", "0"]));
        assert_eq!(resumed["state_hash"], report["state_hash"]);
    }

    #[test]
    fn a_polite_kill_ends_a_run_as_ctrl_c_does() {
        let folder = folder();
        let run = ["run", "chain", "--duration", "1e6", "--out", "s.csv", "--trace", "t.csv"];
        let output = send("-TERM", folder.path(), &run);
        let said = crate::common::text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.starts_with("error: interrupted at t = "), "{said}");
        assert_eq!(names(folder.path()), ["s.csv", "t.csv"]);
    }

    #[test]
    fn ctrl_c_ends_a_replay_with_whole_files_and_compares_nothing() {
        let folder = folder();
        let run = ["run", "chain", "--duration", "2e3", "--record", "r.msdrec"];
        assert!(msd(folder.path(), &run).output().expect("it runs").status.success());
        let replay = ["run", "--replay", "r.msdrec", "--json", "--trace", "t.csv"];
        let output = interrupt(folder.path(), &replay);
        let said = crate::common::text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.starts_with("error: interrupted at t = "), "{said}");
        let report = crate::common::parse(&crate::common::text(&output.stdout));
        assert_eq!(report["interrupted"], true);
        assert_eq!(report["replay"]["same_bits"], serde_json::Value::Null);
        assert_eq!(names(folder.path()), ["r.msdrec", "t.csv"]);
    }

    #[test]
    fn ctrl_c_ends_an_export_with_the_moments_that_there_are() {
        let folder = folder();
        let export = ["export", "chain", "--duration", "1e4", "--to", "c.pc2", "--json"];
        let output = interrupt(folder.path(), &export);
        assert_eq!(output.status.code(), Some(130), "{}", crate::common::text(&output.stderr));
        let report = crate::common::parse(&crate::common::text(&output.stdout));
        assert_eq!(names(folder.path()), ["c.obj", "c.pc2"]);
        let cache = fs::read(folder.path().join("c.pc2")).expect("c.pc2");
        assert_eq!(u64::from(word(&cache, 28)), report["moments"].as_u64().expect("a number"));
    }
}

#[cfg(feature = "window")]
#[test]
fn bodies_have_the_same_colours_in_glb_files_as_in_pictures() {
    assert_eq!(msd_run::export::PALETTE, msd_render::colour::PALETTE);
}
