//! Bad input on the command line: refused in one clear line, with exit code 2 and no output file.
//! `bad_files.rs` of `msd-scene` tests errors inside files.

use crate::common::{msd, refused};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Creates a folder with broken files.
fn folder() -> TempDir {
    let folder = crate::common::folder();
    for (name, text) in FILES {
        std::fs::write(folder.path().join(name), text).expect(name);
    }
    std::fs::create_dir(folder.path().join("folder.toml")).expect("a folder");
    std::fs::create_dir(folder.path().join("folder.obj")).expect("a folder");
    std::fs::write(folder.path().join("binary.toml"), b"\xff\xfe\x00").expect("a file");
    folder
}

const FILES: [(&str, &str); 6] = [
    ("good.toml", "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n"),
    ("tiny.toml", "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\nmass = 1e-60\n"),
    ("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
    ("cut.csv", "particle,x,y,z,vx,vy,vz\n0,0,0,0,0,0,0\n1,0,0"),
    ("nan.csv", "particle,x,y,z,vx,vy,vz\n0,0,0,0,0,0,0\n1,0,0,0,0,NaN,0\n2,0,0,0,0,0,0\n"),
    ("far.csv", "particle,x,y,z,vx,vy,vz\n0,0,0,0,0,0,0\n1,0,1e30,0,0,0,0\n2,0,0,0,0,0,0\n"),
];

fn names(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().expect("a folder");
    let mut names: Vec<PathBuf> = entries.map(|entry| entry.expect("a file").path()).collect();
    names.sort();
    names
}

/// Runs msd, which must print these words in one line and leave no file.
fn refuse(folder: &Path, arguments: &[&str], told: &[&str]) {
    let before = names(folder);
    let said = refused(msd(folder, arguments), 2);
    assert!(said.starts_with("error: "), "{arguments:?}: {said}");
    for part in told {
        assert!(said.contains(part), "{arguments:?}: {said}: {part}");
    }
    assert_eq!(names(folder), before, "{arguments:?}");
}

/// Runs a scene with output files, none of which may appear.
fn refuse_scene(folder: &Path, scene: &str, told: &[&str]) {
    refuse(folder, &["run", scene, "--out", "s.csv", "--trace", "t.csv"], told);
    refuse(folder, &["render", scene, "--out", "s.png"], told);
}

#[test]
fn a_scene_that_is_none_is_refused() {
    let folder = folder();
    for (scene, told) in [
        ("jely", &["no scene `jely`", "did you mean `jelly`?"][..]),
        ("missing.toml", &["missing.toml: cannot be read: No such file"]),
        ("missing.obj", &["missing.obj"]),
        ("folder.toml", &["folder.toml: cannot be read"]),
        ("folder.obj", &["folder.obj"]),
        (".", &["it is a folder"]),
        ("cut.csv", &["unknown extension"]),
        ("binary.toml", &["binary.toml: cannot be read: it is not UTF-8 text"]),
        (
            "tiny.toml",
            &["tiny.toml:5:8: bodies[0].mass is 1e-60; it must be positive and finite, from"],
        ),
        ("range.obj", &["range.obj: line 4: a vertex index is 9; it must be from 1 to 3"]),
    ] {
        refuse_scene(folder.path(), scene, told);
    }
}

#[test]
fn an_option_that_the_method_does_not_use_is_refused_with_the_methods_that_do() {
    let folder = folder();
    for (arguments, told) in [
        (
            &["--tolerance", "1e-6"][..],
            "velocity-verlet does not use --tolerance; only dormand-prince does",
        ),
        (
            &["--newton", "2", "--integrator", "rk4"],
            "rk4 does not use --newton; only backward-euler and implicit-midpoint do",
        ),
        (
            &["--newton", "2", "--integrator", "dormand-prince"],
            "dormand-prince does not use --newton; only",
        ),
    ] {
        let run = ["run", "chain", "--duration", "0.1"];
        refuse(folder.path(), &[&run[..], arguments].concat(), &[told]);
    }
}

#[test]
fn arguments_outside_their_domain_are_refused() {
    let folder = folder();
    for (arguments, told) in [
        (&["--integrator", "rk5"][..], "must be one of explicit-euler, symplectic-euler"),
        (&["--precision", "f16"], "must be f32 or f64"),
        (&["--step", "0"], "must be `auto` or a number, positive and finite"),
        (&["--step", "-1"], "must be `auto` or a number, positive and finite"),
        (&["--step", "nan"], "must be `auto` or a number, positive and finite"),
        (&["--step", "inf"], "must be `auto` or a number, positive and finite"),
        (&["--step", "1e-300"], "step"),
        (&["--step", "1e300"], "at most 1e6 s"),
        (&["--substeps", "0"], "must be `auto` or a whole number from 1 to 4294967295"),
        (&["--substeps", "-3"], "must be `auto` or a whole number from 1 to 4294967295"),
        (&["--substeps", "99999999999"], "must be `auto` or a whole number from 1 to 4294967295"),
        (&["--step", "0.1", "--substeps", "2"], "cannot be used with"),
        (&["--newton", "2000"], "must be a whole number from 1 to 1000"),
        (&["--duration", "-1"], "must be a number, finite and not negative"),
        (&["--duration", "nan"], "must be a number, finite and not negative"),
        (&["--duration", "inf"], "must be a number, finite and not negative"),
        (&["--duration", "1e300"], "would take more than 1e10 steps"),
        (&["--watch", "0"], "--trace"),
        (&["--watch", "3", "--trace", "u.csv"], "--watch names particle 3; it must be from 0 to 2"),
        (&["--trace", "./s.csv"], "--out and --trace name the same file, ./s.csv"),
        (&["--from", "missing.csv"], "missing.csv: cannot be read"),
        (&["--from", "folder.toml"], "folder.toml: cannot be read: it is a folder"),
        (&["--from", "cut.csv"], "cut.csv: row 2: the number of values is 3; it must be 7"),
        (&["--from", "nan.csv"], "nan.csv: row 2: vy is \"NaN\""),
        (&["--from", "far.csv"], "far.csv: position of particle 1"),
        (&["--from", "good.toml"], "good.toml: the header is"),
        (
            &["--durration", "1"],
            "there is no option --durration of msd run; did you mean --duration?",
        ),
        (
            &["--gravity", "0"],
            "; gravity is set in the scene file, as world.gravity, or by --set world.gravity=VALUE",
        ),
        (&["--zebra", "red"], "there is no option --zebra of msd run; see msd --help"),
        (&["--mass", "1"], "as bodies.mass, or by --set bodies.0.mass=VALUE"),
        (&["--colour", "red"], "as bodies.look.colour, or by --set bodies.0.look.colour=VALUE"),
    ] {
        let run = ["run", "good.toml", "--out", "s.csv"];
        refuse(folder.path(), &[&run, arguments].concat(), &[told]);
    }
}

#[test]
fn a_command_that_is_none_is_refused_with_the_nearest() {
    let folder = folder();
    refuse(folder.path(), &["rnu", "jelly"], &["there is no command `rnu`; did you mean `run`?"]);
    refuse(folder.path(), &["run"], &["required arguments were not provided: <SCENE>"]);
    refuse(folder.path(), &["jely"], &["did you mean `jelly`?"]);
    let told = "there is no option --duration; it belongs to msd run, msd export, msd study";
    refuse(folder.path(), &["jelly", "--duration", "1"], &[told]);
    // The window checks the options of the solver before it opens.
    let told = "velocity-verlet does not use --tolerance; only dormand-prince does";
    refuse(folder.path(), &["view", "jelly", "--tolerance", "1e-3"], &[told]);
    refuse(folder.path(), &["jelly", "--tolerance", "1e-3"], &[told]);
}

#[test]
fn an_output_without_a_place_is_refused_before_the_run() {
    let folder = folder();
    // These runs would take hours.
    let run = ["run", "good.toml", "--duration", "1e7"];
    for (arguments, told) in [
        (["--out", "nowhere/s.csv"], "nowhere/s.csv: cannot be written: there is no folder"),
        (["--trace", "nowhere/t.csv"], "nowhere/t.csv: cannot be written: there is no folder"),
        (["--save", "folder.toml"], "folder.toml: cannot be written: it is a folder"),
        (["--out", "/proc/s.csv"], "/proc/s.csv: cannot be written"),
    ] {
        refuse(folder.path(), &[&run[..], &arguments].concat(), &[told]);
    }
    let render = ["render", "good.toml", "--time", "1e7", "--out"];
    for (name, told) in [
        ("nowhere/p.png", "nowhere/p.png: cannot be written: there is no folder"),
        ("p.jpg", "use .png"),
    ] {
        refuse(folder.path(), &[&render[..], &[name]].concat(), &[told]);
    }
}

#[test]
fn a_picture_of_no_size_is_refused() {
    let folder = folder();
    for size in ["0x10", "10x0", "10", "axb", "-1x5", "99999x10", "10x10x10"] {
        let told = ["must be WIDTHxHEIGHT"];
        refuse(folder.path(), &["render", "good.toml", "--size", size], &told);
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = msd(Path::new("."), &["run", "chain", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("msd starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("msd ends");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

#[cfg(unix)]
#[test]
fn an_argument_that_is_no_text_is_refused() {
    use std::os::unix::ffi::OsStrExt;
    let odd = std::ffi::OsStr::from_bytes(b"\xff.toml");
    let mut command = msd(Path::new("."), &[]);
    command.arg(odd);
    let said = refused(command, 2);
    assert!(said.starts_with("error: "), "{said}");
}
