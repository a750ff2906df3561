//! Saving, resuming, recording and replaying, to the last bit, even if the program is killed.

use crate::common::{folder, json, msd, outcome, parse, refused, text};
use msd_app::session::Session;
use msd_core::glam::DVec3;
use msd_run::Runner;
use msd_run::recording::Recorder;
use msd_scene::{Loaded, load_saved, open, state_hash};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use serde_json::Value;
use std::process::Stdio;
use std::time::Duration;

#[test]
fn a_saved_run_goes_on_to_the_bits_of_one_that_never_stopped() {
    let folder = folder();
    for precision in ["f32", "f64"] {
        let run = |scene: &str, more: &[&str]| {
            json(msd(folder.path(), &[&["run", scene, "--precision", precision], more].concat()))
        };
        let whole = run("dice", &["--duration", "1.5"]);
        run("dice", &["--duration", "1", "--save", "s.msd"]);
        let rest = run("s.msd", &["--duration", "0.5"]);
        assert_eq!(rest["state_hash"], whole["state_hash"]);
        assert_eq!(rest["energy"], whole["energy"]);
        assert_eq!(rest["time"], whole["time"]);
        assert_eq!((rest["duration"].as_f64(), rest["steps"].as_u64()), (Some(0.5), Some(720)));
        assert_eq!(rest["scene"], "dice");
    }
    // The command line overrides the saved run.
    let other =
        json(msd(folder.path(), &["run", "s.msd", "--duration", "0", "--integrator", "rk4"]));
    assert_eq!((&other["integrator"], &other["precision"]), (&"rk4".into(), &"f64".into()));
}

#[test]
fn a_run_is_recorded_and_replayed_to_the_bit() {
    let folder = folder();
    let path = folder.path();
    let run = json(msd(path, &["run", "dice", "--duration", "0.5", "--record", "r.msdrec"]));
    let replay = json(msd(path, &["run", "--replay", "r.msdrec", "--trace", "t.csv"]));
    for key in ["state_hash", "energy", "duration", "steps", "integrator", "scene"] {
        assert_eq!(replay[key], run[key], "{key}");
    }
    assert_eq!(replay["replay"]["recorded_hash"], run["state_hash"]);
    assert_eq!(replay["replay"]["same_bits"], true);
    assert_eq!(replay["replay"]["apart"], Value::Null);
    let trace = std::fs::read_to_string(path.join("t.csv")).expect("t.csv");
    assert_eq!(trace.lines().count(), 32);
    assert!(run.get("replay").is_none());
}

#[test]
fn a_recording_of_the_window_is_replayed_by_the_command_line() {
    let folder = folder();
    let mut session = Session::new(open("jelly").expect("a scene")).expect("a valid scene");
    session.start_recording(&folder.path().join("r.msdrec"));
    session.advance(0.0, &|| 0.0);
    for frame in 0..20 {
        if frame == 5 {
            session.grab(500, DVec3::new(1.0, 9.0, 1.0));
        }
        session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
    }
    session.stop_recording();
    let hash = format!("{:016x}", state_hash(&session.runner().state()));
    let replay = json(msd(folder.path(), &["run", "--replay", "r.msdrec"]));
    assert_eq!(replay["state_hash"], hash);
}

#[test]
fn a_twin_tells_the_distance_over_time() {
    let folder = folder();
    let path = folder.path();
    json(msd(path, &["run", "square", "--duration", "1", "--record", "r.msdrec"]));
    let changed = ["--integrator", "backward-euler", "--substeps", "1"];
    let files = ["--distances", "d.csv"];
    let twin = json(msd(path, &[&["run", "--replay", "r.msdrec"], &changed[..], &files].concat()));
    assert_eq!((&twin["integrator"], &twin["substeps"]), (&"backward-euler".into(), &1.into()));
    let apart = &twin["replay"]["apart"];
    assert_eq!(apart["recorded_integrator"], "velocity-verlet");
    let number = |value: &Value| value.as_f64().expect("a number");
    let rows = std::fs::read_to_string(path.join("d.csv")).expect("d.csv");
    let mut lines = rows.lines();
    assert_eq!(lines.next(), Some("step,time,rms,max,particle"));
    let rows: Vec<Vec<f64>> =
        lines.map(|row| row.split(',').map(|n| n.parse().expect("a number")).collect()).collect();
    assert_eq!(rows.len(), 60);
    assert_eq!(rows[59][2..4], [number(&apart["rms"]), number(&apart["max"])]);
    let first = rows.iter().find(|row| 0.01 * number(&apart["size"]) < row[2]);
    assert_eq!(apart["noticeable_at"].as_f64(), first.map(|row| row[1]));
    let said = outcome(msd(path, &["run", "--replay", "r.msdrec", "--precision", "f64"]));
    let said = text(&said.stdout);
    assert!(said.contains("from the recorded run (velocity-verlet)"), "{said}");
}

#[test]
fn a_recording_without_its_end_is_replayed_with_a_warning_and_a_damaged_one_if_asked() {
    let folder = folder();
    let path = folder.path().join("r.msdrec");
    json(msd(folder.path(), &["run", "square", "--duration", "2", "--record", "r.msdrec"]));
    let bytes = std::fs::read(&path).expect("the recording");
    // Events: 60 steps, 60 steps, the end. A length takes 8 bytes, a hash 32, the steps 2; the size
    // of the end varies, as small numbers take fewer bytes.
    let end = (0..bytes.len()).rev().find(|&at| {
        let length = bytes[at..].first_chunk().map(|bytes| u64::from_le_bytes(*bytes));
        length.is_some_and(|length| at as u64 + 8 + length + 32 == bytes.len() as u64)
    });
    let end = end.expect("a frame that ends with the file");
    let (second, first) = (end - 42, end - 84);
    let replay = |bytes: &[u8], more: &[&str]| {
        std::fs::write(&path, bytes).expect("a file");
        let arguments = ["run", "--replay", "r.msdrec", "--json"];
        outcome(msd(folder.path(), &[&arguments, more].concat()))
    };
    let output = replay(&bytes[..second], &[]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).starts_with("warning: the end of the recording is missing"));
    let report = parse(&text(&output.stdout));
    assert_eq!((&report["duration"], &report["replay"]["cut_short"]), (&1.0.into(), &true.into()));
    // A flipped bit in a length or in a content, a cut within an event, bytes after the end.
    let flipped = |at: usize| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 64;
        bytes
    };
    let longer = [&bytes[..], b"x"].concat();
    for (bytes, what, duration, lost) in [
        (
            &flipped(first + 2)[..],
            "is cut short or damaged within an event, after step 0",
            0.0,
            first,
        ),
        (&flipped(second + 2), "is cut short or damaged within an event, after", 1.0, second),
        (&flipped(second + 9), "is damaged: its checksum does not fit, after", 1.0, second),
        (&bytes[..end - 1], "is cut short or damaged within an event, after", 1.0, second),
        (&longer, "goes on after its end, after step 120; its last 1 bytes", 2.0, bytes.len()),
    ] {
        let output = replay(bytes, &[]);
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{what}");
        assert!(said.contains(what) && said.contains("; --salvage replays"), "{what}: {said}");
        let output = replay(bytes, &["--salvage"]);
        let report = parse(&text(&output.stdout));
        let lost = bytes.len() - lost;
        assert_eq!(output.status.code(), Some(0), "{what}");
        assert_eq!(report["duration"], duration, "{what}");
        assert_eq!(report["replay"]["lost_bytes"], lost, "{what}");
        let told = format!("its last {lost} bytes are lost");
        assert!(text(&output.stderr).contains(&told), "{}", text(&output.stderr));
    }
}

#[test]
fn a_replay_that_ends_elsewhere_says_so() {
    let folder = folder();
    // Its end belongs to another run, as another version of msd might have computed it.
    let mut runner = Runner::open(&open("square").expect("a scene")).expect("a run");
    let start = runner.to_loaded("square", "");
    let path = folder.path().join("r.msdrec");
    let recorder = Recorder::begin(&path, &start).expect("a file");
    runner.step().expect("a step");
    recorder.finish(&runner).expect("room on the disk");
    let output = outcome(msd(folder.path(), &["run", "--replay", "r.msdrec"]));
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stdout).ends_with("replayed to a different state\n"));
    assert!(text(&output.stderr).contains("ended in a different state than the recording"));
}

#[test]
fn what_cannot_be_saved_recorded_or_replayed_is_refused_in_one_line() {
    let folder = folder();
    let path = folder.path();
    let short = ["--duration", "0.1"];
    let files = ["--save", "s.msd", "--record", "r.msdrec"];
    json(msd(path, &[&["run", "square"], &short[..], &files].concat()));
    std::fs::write(path.join("new.msd"), "msd saved run, format 18\nxyz").expect("a file");
    let saved = std::fs::read(path.join("s.msd")).expect("the saved run");
    std::fs::write(path.join("cut.msd"), &saved[..saved.len() / 2]).expect("a file");
    let mut changed = saved.clone();
    changed[saved.len() / 2] ^= 1;
    std::fs::write(path.join("changed.msd"), changed).expect("a file");
    for (arguments, told) in [
        (&["run", "r.msdrec"][..], "it is a recording, which msd run --replay takes"),
        (&["run", "new.msd"], "new.msd: is a saved run of format 18; this msd reads format 17"),
        (&["run", "cut.msd"], "cut.msd: is cut short"),
        (&["run", "changed.msd"], "changed.msd: is damaged: its checksum does not fit"),
        (&["run", "none.msd"], "none.msd: cannot be read"),
        (&["run", "--replay", "s.msd"], "s.msd: is a saved run, not a recording"),
        (&["run", "--replay", "none.msdrec"], "none.msdrec: cannot be read"),
        (&["run", "square", "--replay", "r.msdrec"], "cannot be used with"),
        (&["run", "--replay", "r.msdrec", "--step", "0.01"], "cannot be used with"),
        (&["run", "--replay", "r.msdrec", "--record", "b.msdrec"], "cannot be used with"),
        (&["run", "--replay", "r.msdrec", "--distances", "d.csv"], "--distances needs another"),
        (&["run", "square", "--save-every", "1"], "--save"),
        (&["run", "square", "--save", "no/s.msd"], "there is no folder"),
        (&["run", "square", "--save", "a", "--record", "a"], "--save and --record name the same"),
        (&["run"], "SCENE"),
    ] {
        let message = refused(msd(path, arguments), 2);
        assert!(message.contains(told), "{arguments:?}: {message}");
    }
    assert!(!path.join("d.csv").exists());
}

/// Number of kills of the program.
const KILLS: usize = 200;

#[test]
fn a_kill_at_any_moment_leaves_a_saved_run_that_goes_on_to_the_bit() {
    let folder = folder();
    let file = folder.path().join("s.msd");
    json(msd(folder.path(), &["run", "chain", "--duration", "0", "--save", "s.msd"]));
    let mut lot = Pcg32::new(1, 1);
    let mut steps = 0;
    for kill in 0..KILLS {
        let before = std::fs::read(&file).expect("a saved run");
        let arguments =
            ["run", "s.msd", "--duration", "1e5", "--save", "s.msd", "--save-every", "0.01"];
        let mut command = msd(folder.path(), &arguments);
        let mut child = command.stdout(Stdio::null()).spawn().expect("msd starts");
        // It saves after every step. After the first save, it is killed during one of the next.
        while std::fs::read(&file).expect("a saved run") == before {
            assert_eq!(child.try_wait().expect("a child"), None, "it runs for hours");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(u64::from(lot.next_u32() % 8000)));
        child.kill().expect("a child");
        child.wait().expect("a child");
        let loaded = load_saved(&file).unwrap_or_else(|error| panic!("kill {kill}: {error}"));
        let now = loaded.progress.expect("a saved run").steps;
        assert!(steps < now, "kill {kill}: step {now} after {steps}");
        steps = now;
    }
    // The bits of an uninterrupted run.
    let mut runner = Runner::open(&open("chain").expect("a scene")).expect("a run");
    (0..steps).for_each(|_| runner.step().expect("a step"));
    assert!(load_saved(&file).expect("a saved run") == of(&runner));
    // The next write of the same file removes the leftover of a kill.
    let part = folder.path().join(".msd-0123456789abcdef-0.part");
    std::fs::write(&part, "of another file").expect("a file");
    json(msd(folder.path(), &["run", "s.msd", "--duration", "0", "--save", "s.msd"]));
    let entries = folder.path().read_dir().expect("a folder").flatten();
    let mut names: Vec<_> = entries.map(|entry| entry.path()).collect();
    names.sort();
    assert_eq!(names, [part, file]);
}

/// Returns a run of the chain as the program saves it.
fn of(runner: &msd_run::Runner) -> Loaded {
    runner.to_loaded("chain", &open("chain").expect("a scene").title)
}
