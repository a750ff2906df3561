//! Existing and requested files: none is lost or overwritten silently.
#![cfg(unix)]

use crate::common::{done, folder, json, msd, names, outcome, parse, quiet, refused, text};
use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::path::Path;
use std::process::Command;

const ROPE: &str = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [3]\n";

/// Returns the contents of a folder, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = folder.read_dir().expect("a folder").flatten();
    let content = |path: &Path| fs::read(path).unwrap_or_default();
    let mut found: Vec<_> = entries
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), content(&entry.path())))
        .collect();
    found.sort();
    found
}

#[test]
fn one_output_that_fails_leaves_the_others_and_each_failure_is_named() {
    let folder = folder();
    let run = ["run", "chain", "--duration", "1", "--json"];
    // A full disk: the short file fails at its end.
    let files = ["--out", "/dev/full", "--save", "s.msd", "--trace", "t.csv"];
    let output = outcome(msd(folder.path(), &[&run[..], &files].concat()));
    assert_eq!(output.status.code(), Some(2));
    let told = "/dev/full: cannot be written: No space left on device (os error 28)";
    assert_eq!(text(&output.stderr), format!("error: {told}\n"));
    let report = parse(&text(&output.stdout));
    assert_eq!((&report["diverged"], &report["warnings"][0]), (&false.into(), &told.into()));
    let trace = fs::read_to_string(folder.path().join("t.csv")).expect("t.csv");
    assert_eq!(trace.lines().count(), 62);
    let saved = json(msd(folder.path(), &["run", "s.msd", "--duration", "0"]));
    assert_eq!(saved["state_hash"], report["state_hash"]);
    // Both failures name their file.
    symlink("/dev/full", folder.path().join("full.csv")).expect("a link");
    let files = ["--out", "/dev/full", "--trace", "full.csv"];
    let output = outcome(msd(folder.path(), &[&run[..], &files].concat()));
    let said = text(&output.stderr);
    assert!(said.contains("error: /dev/full:") && said.contains("error: full.csv:"), "{said}");
}

#[test]
fn a_run_goes_on_without_the_file_whose_disk_fills_and_says_so() {
    let folder = folder();
    let run = ["run", "chain", "--duration", "20"];
    json(msd(folder.path(), &[&run[..], &["--out", "alone.csv"]].concat()));
    let files = ["--trace", "/dev/full", "--out", "s.csv"];
    let output = outcome(msd(folder.path(), &[&run[..], &files].concat()));
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    let told = "/dev/full: cannot be written: No space left on device (os error 28)";
    assert_eq!(said, format!("warning: {told}; the run continues without it\nerror: {told}\n"));
    assert!(text(&output.stdout).contains("20 s simulated"));
    let read = |name: &str| fs::read(folder.path().join(name)).expect(name);
    assert!(read("s.csv") == read("alone.csv"));
}

/// Returns the program with a limit on the size of files, blocks of 512 bytes: a full disk.
fn cramped(folder: &Path, blocks: u32, arguments: &[&str]) -> Command {
    let mut shell = Command::new("sh");
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_msd")]).args(arguments);
    shell.current_dir(folder).env_remove("RUST_LOG");
    shell
}

#[test]
fn on_a_full_disk_old_files_stay_and_a_recording_holds_what_fits() {
    let folder = folder();
    fs::write(folder.path().join("t.csv"), "old").expect("a file");
    let files = ["--trace", "t.csv", "--save", "s.msd", "--record", "r.msdrec"];
    let run = ["run", "chain", "--duration", "120"];
    let output = outcome(cramped(folder.path(), 8, &[&run[..], &files].concat()));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for name in ["t.csv", "r.msdrec"] {
        let told = format!("error: {name}: cannot be written: File too large");
        assert!(said.contains(&told), "{said}");
    }
    assert!(!said.contains(".part"), "{said}");
    assert_eq!(names(folder.path()), ["r.msdrec", "s.msd", "t.csv"]);
    assert_eq!(fs::read(folder.path().join("t.csv")).expect("t.csv"), b"old");
    // It ends with a whole event, so it counts as cut short, not as damaged.
    let replay = outcome(msd(folder.path(), &["run", "--replay", "r.msdrec", "--json"]));
    assert_eq!(replay.status.code(), Some(0), "{}", text(&replay.stderr));
    assert_eq!(parse(&text(&replay.stdout))["replay"]["cut_short"], true);
}

#[test]
fn a_run_that_diverged_and_could_not_be_written_says_both() {
    let folder = folder();
    let fall = format!("{ROPE}[world]\nextent = 2\n");
    fs::write(folder.path().join("fall.toml"), fall).expect("a file");
    let output = outcome(msd(folder.path(), &["run", "fall.toml", "--out", "/dev/full"]));
    // Code 3 would imply that the last valid state is written.
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("error: /dev/full:") && said.contains("error: fall:"), "{said}");
    assert!(!text(&output.stdout).is_empty());
}

#[test]
fn a_file_that_stands_where_another_does_is_refused_before_the_run() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("o.toml"), ROPE).expect("a file");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(path.join("m.obj"), mesh).expect("a file");
    let scene = "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'm.obj'\n";
    fs::write(path.join("m.toml"), scene).expect("a file");
    let sweep = "version = 1\nscene = 'o.toml'\n[grid]\n'solver.substeps' = [4, 8]\n";
    fs::write(path.join("s.csv"), sweep.replace("[grid]", "format = 'csv'\n[grid]")).unwrap();
    let short = ["--duration", "0.1"];
    let files = ["--record", "r.msdrec", "--save", "k.msd", "--out", "k.csv"];
    json(msd(path, &[&["run", "o.toml"], &short[..], &files].concat()));
    fs::create_dir(path.join("sub")).expect("a folder");
    symlink("o.toml", path.join("link.csv")).expect("a link");
    symlink("o.toml", path.join("link.png")).expect("a link");
    symlink("new.csv", path.join("dangling.csv")).expect("a link");
    fs::hard_link(path.join("o.toml"), path.join("hard.csv")).expect("a link");
    fs::hard_link(path.join("m.obj"), path.join("hard.obj")).expect("a link");
    fs::create_dir(path.join("study")).expect("a folder");
    fs::hard_link(path.join("o.toml"), path.join("study/study.csv")).expect("a link");
    let before = contents(path);
    for (arguments, told) in [
        (&["run", "o.toml", "--out", "o.toml"][..], "SCENE and --out name the same file, o.toml"),
        (&["run", "o.toml", "--trace", "sub/../o.toml"], "SCENE and --trace name the same file"),
        (&["run", "o.toml", "--save", "link.csv"], "SCENE and --save name the same file, link.csv"),
        (&["run", "o.toml", "--record", "hard.csv"], "SCENE and --record name the same file"),
        (&["run", "m.toml", "--out", "m.obj"], "SCENE and --out name the same file, m.obj"),
        (&["run", "m.obj", "--out", "hard.obj"], "SCENE and --out name the same file, hard.obj"),
        (&["run", "k.msd", "--out", "k.msd"], "SCENE and --out name the same file, k.msd"),
        (
            &["run", "o.toml", "--from", "k.csv", "--out", "k.csv"],
            "--from and --out name the same file, k.csv",
        ),
        (
            &["run", "o.toml", "--out", "a.csv", "--trace", "sub/../a.csv"],
            "--out and --trace name the same file, sub/../a.csv",
        ),
        (
            &["run", "o.toml", "--out", "dangling.csv", "--trace", "new.csv"],
            "--out and --trace name the same file, new.csv",
        ),
        (
            &["run", "--replay", "r.msdrec", "--save", "r.msdrec"],
            "--replay and --save name the same file, r.msdrec",
        ),
        (
            &["run", "--replay", "r.msdrec", "--precision", "f64", "--distances", "./r.msdrec"],
            "--replay and --distances name the same file",
        ),
        (&["render", "o.toml", "--out", "link.png"], "SCENE and --out name the same file"),
        (&["study", "o.toml", "--out", "study"], "SCENE and --out name the same file, study/"),
        (&["sweep", "s.csv", "--collect", "s.csv"], "SWEEP and --collect name the same file"),
        (&["sweep", "s.csv", "--collect", "hard.csv"], "SWEEP and --collect name the same file"),
        // The table of a sweep is beside its folder, with the same name.
        (&["sweep", "s.csv"], "SWEEP and the table name the same file, s.csv"),
    ] {
        let message = refused(msd(path, arguments), 2);
        assert!(message.contains(told), "{arguments:?}: {message}");
        assert!(contents(path) == before, "{arguments:?}");
    }
    // A saved run may replace itself: the new one continues it.
    json(msd(path, &["run", "k.msd", "--duration", "0.1", "--save", "k.msd"]));
}

#[test]
fn a_cell_of_a_sweep_is_not_collected_over_and_nor_is_the_standard_output() {
    let folder = folder();
    let path = folder.path();
    let sweep = "version = 1\nscene = 'chain'\nformat = 'csv'\nduration = 0.1\n[grid]\n\
                 'solver.substeps' = [8]\n";
    fs::write(path.join("s.toml"), sweep).expect("a file");
    done(msd(path, &["sweep", "s.toml"]));
    let cell = format!("s/{}", names(&path.join("s"))[0]);
    let message = refused(msd(path, &["sweep", "s.toml", "--collect", &cell]), 2);
    assert!(message.contains("a cell and --collect name the same file"), "{message}");
    let mut command = msd(path, &["view", "s.toml"]);
    command.env("MSD_STATUS", "./s.toml");
    fs::write(path.join("s.toml"), ROPE).expect("a file");
    let message = refused(command, 2);
    assert!(message.contains("SCENE and MSD_STATUS name the same file"), "{message}");
    let mut command = msd(path, &["run", "chain", "--duration", "0.1", "--out", "said.csv"]);
    command.stdout(fs::File::create(path.join("said.csv")).expect("a file"));
    let message = refused(command, 2);
    assert!(message.contains("the standard output and --out name the same file"), "{message}");
}

/// Writes the last state of a short run to a file.
fn write(folder: &Path, name: &str) {
    quiet(msd(folder, &["run", "chain", "--duration", "0.1", "--out", name]));
}

#[test]
fn what_is_overwritten_keeps_its_mode_owner_and_links() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let about = |name: &str| fs::metadata(path(name)).expect(name);
    let read = |name: &str| fs::read(path(name)).expect(name);
    write(folder.path(), "new.csv");
    for mode in [0o600, 0o604, 0o666, 0o2770] {
        fs::write(path("old.csv"), "old").expect("a file");
        fs::set_permissions(path("old.csv"), Permissions::from_mode(mode)).expect("its owner");
        // Only a user who may give files away can test this.
        let owned = chown(path("old.csv"), Some(12), Some(34)).is_ok();
        let before = about("old.csv");
        fs::set_permissions(path("old.csv"), Permissions::from_mode(mode)).expect("its owner");
        write(folder.path(), "old.csv");
        let now = about("old.csv");
        assert_eq!(now.mode() & 0o7777, mode, "{mode:o}");
        assert_eq!((now.uid(), now.gid()), (before.uid(), before.gid()));
        assert!(!owned || now.uid() == 12);
        assert!(read("old.csv") == read("new.csv"));
    }
    fs::write(path("one.csv"), "a".repeat(100_000)).expect("a file");
    fs::hard_link(path("one.csv"), path("two.csv")).expect("a link");
    write(folder.path(), "one.csv");
    assert_eq!((about("one.csv").ino(), about("two.csv").nlink()), (about("two.csv").ino(), 2));
    assert!(read("two.csv") == read("new.csv"));
    symlink("old.csv", path("link.csv")).expect("a link");
    symlink("later.csv", path("dangling.csv")).expect("a link");
    for (link, target) in [("link.csv", "old.csv"), ("dangling.csv", "later.csv")] {
        write(folder.path(), link);
        assert_eq!(fs::read_link(path(link)).expect("still a link"), Path::new(target));
        assert!(fs::symlink_metadata(path(target)).expect(target).is_file());
        assert!(read(target) == read("new.csv"));
    }
    let left = names(folder.path());
    assert!(!left.iter().any(|name| name.ends_with(".part")), "{left:?}");
}

#[test]
fn a_state_can_go_down_a_pipe() {
    let folder = folder();
    let run = ["run", "chain", "--duration", "0.1", "--out", "/dev/stdout"];
    let said = quiet(msd(folder.path(), &run));
    assert!(said.starts_with("particle,x,y,z,vx,vy,vz\n0,"), "{said}");
    assert!(said.contains("state hash"), "{said}");
}

#[test]
fn a_name_with_control_characters_is_told_in_one_harmless_line() {
    let folder = folder();
    let odd = "a\x1b[31m\n\rb";
    fs::write(folder.path().join(format!("{odd}.toml")), "version = 2\n").expect("a file");
    fs::create_dir(folder.path().join(odd)).expect("a folder");
    let scene = format!("{odd}.toml");
    let no = format!("no/{odd}.csv");
    let bad = format!("bad{odd}");
    for arguments in [
        &["run", &scene][..],
        &["run", &bad],
        &[&bad],
        &["run", "chain", "--out", &no],
        &["run", "chain", "--out", odd],
        &["run", "chain", "--from", &no],
        &["run", "--replay", &scene],
        &["run", "chain", "--integrator", odd],
        &["run", "chain", &bad],
        &["render", "chain", "--out", &no],
        &["study", "chain", "--out", &scene],
        &["sweep", &scene],
        &["tune", &bad, "--max-error", "1", "--write"],
        &["bench", "cloth", "2", "--positions", &no],
    ] {
        let message = refused(msd(folder.path(), arguments), 2);
        let told = message.trim_end_matches('\n');
        assert!(!told.contains(char::is_control), "{arguments:?}: {told:?}");
    }
    let out = format!("{odd}.png");
    let command = msd(folder.path(), &["render", "chain", "--size", "8x8", "--out", &out]);
    let output = outcome(command);
    // Without a graphics driver there is no picture, and the message must be equally safe.
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(!said.replace('\n', "").contains(char::is_control), "{said:?}");
}

#[test]
fn names_that_are_no_text_work_everywhere() {
    let folder = folder();
    let odd = |name: &[u8]| OsStr::from_bytes(&[b"\xff", name].concat()).to_owned();
    let run = |arguments: &[&OsStr]| {
        let mut command = msd(folder.path(), &["run"]);
        command.args(arguments);
        quiet(command)
    };
    let word = OsStr::new;
    let [scene, state, saved, taped] = [b".toml", b"a.csv", b"a.msd", b"a.rec"].map(|n| odd(n));
    fs::write(folder.path().join(&scene), ROPE).expect("a file");
    let short = [word("--duration"), word("0.1")];
    let trace = odd(b"t.csv");
    let files = [
        [word("--out"), &state],
        [word("--save"), &saved],
        [word("--record"), &taped],
        [word("--trace"), &trace],
    ];
    run(&[&[&*scene], &short[..], &files.concat()].concat());
    for file in [&state, &saved, &taped, &trace] {
        assert!(folder.path().join(file).is_file(), "{}", file.display());
    }
    run(&[&[&*scene], &short[..], &[word("--from"), &state]].concat());
    run(&[&[&*saved], &short[..], &[word("--save"), &saved]].concat());
    let apart = odd(b"d.csv");
    let compared = [word("--precision"), word("f64"), word("--distances"), &apart];
    run(&[&[word("--replay"), &*taped], &compared[..]].concat());
    assert!(folder.path().join(&apart).is_file());
    let mesh = odd(b".obj");
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.path().join(&mesh), tetrahedron).expect("a file");
    run(&[&[&*mesh], &short[..]].concat());
    // The other commands.
    let sweep = odd(b"s.toml");
    let grid = "version = 1\nscene = 'chain'\nduration = 0.1\n[grid]\n'solver.substeps' = [8]\n";
    fs::write(folder.path().join(&sweep), grid).expect("a file");
    let study = [&*scene, word("--terms"), word("--duration"), word("0.1")];
    let wish = [&*scene, word("--max-error"), word("1"), word("--duration"), word("0.1")];
    for (command, arguments) in [
        ("sweep", &[&*sweep][..]),
        ("study", &study),
        ("tune", &[&wish[..], &[word("--write")]].concat()),
        ("bench", &[word("cloth"), word("2"), word("--positions"), &odd(b".bin")]),
    ] {
        let mut command = msd(folder.path(), &[command]);
        command.args(arguments).env("MSD_CACHE", folder.path().join("cache"));
        done(command);
    }
    assert!(folder.path().join(odd(b"s.csv")).is_file());
    assert!(folder.path().join(odd(b".bin")).is_file());
}
