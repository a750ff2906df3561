//! The commands of the help: the real binary, run as a user would.

use crate::common::{done, folder, json, outcome, parse, quiet, refused, text};
use msd_core::Settings;
use msd_run::{Runner, on};
use msd_scene::open;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Returns the program without a display.
fn msd(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = crate::common::msd(folder, arguments);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("{key} of {report}"))
}

#[test]
fn scenes_lists_every_built_in_scene_with_a_line() {
    let listed = quiet(msd(folder().path(), &["scenes"]));
    for builtin in msd_scene::BUILTINS {
        assert!(listed.lines().any(|line| line.starts_with(builtin.name)), "{}", builtin.name);
    }
    assert_eq!(listed.lines().count(), msd_scene::BUILTINS.len());
    // Names and titles form two columns in all lines.
    for listed in [listed, quiet(msd(folder().path(), &["methods"]))] {
        let longest = listed.lines().map(|line| line.find("  ").unwrap_or(line.len())).max();
        let start = longest.expect("a line") + 2;
        for line in listed.lines() {
            let (name, title) = line.split_at(start);
            assert!(name.ends_with("  ") && !title.starts_with(' '), "{line}");
        }
    }
}

#[test]
fn schema_prints_the_json_schema_of_scene_files() {
    let printed = quiet(msd(folder().path(), &["schema"]));
    assert_eq!(serde_json::from_str::<Value>(&printed).ok(), Some(msd_scene::json_schema()));
}

#[test]
fn auto_takes_nine_tenths_of_the_longest_stable_step_and_ends_on_time() {
    let folder = folder();
    let report = json(msd(folder.path(), &["run", "cube", "--step", "auto", "--duration", "1"]));
    let cube = Runner::open(&open("cube").expect("a built-in scene")).expect("a valid scene");
    // The limit depends slightly on the number of substeps: that of the default ones counts.
    let substeps = Settings::default().substeps;
    let stable = on!(&cube, cube => cube.stable_substep_of(cube.settings().integrator, substeps));
    // The fewest steps of at most nine tenths of the limit that end on time.
    let steps = number(&report, "steps");
    assert_eq!(steps, (1.0 / (0.9 * stable)).ceil());
    assert_eq!(report["automatic"], serde_json::json!({ "least": 1, "most": 1 }));
    assert!((steps * number(&report, "step") - 1.0).abs() < 1e-12);
    let output =
        outcome(msd(folder.path(), &["run", "cloth", "--step", "auto", "--integrator", "xpbd"]));
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("xpbd is stable here at any step"), "{said}");
}

#[test]
fn run_prints_the_documented_keys() {
    let report = json(msd(folder().path(), &["run", "cloth", "--duration", "1"]));
    assert_eq!(report["scene"], "cloth");
    assert_eq!(report["integrator"], "velocity-verlet");
    assert_eq!(report["precision"], "f32");
    assert_eq!((&report["particles"], &report["springs"]), (&961.into(), &3660.into()));
    assert!((number(&report, "duration") - 1.0).abs() < 1e-12);
    let time = number(&report, "steps") * number(&report, "step");
    assert!((time - 1.0).abs() < 1e-12);
    let updates = number(&report, "steps") * 3660.0 / number(&report, "wall_seconds");
    assert!((number(&report, "spring_updates_per_second") / updates - 1.0).abs() < 1e-9);
    let factor = number(&report, "duration") / number(&report, "wall_seconds");
    assert!((number(&report, "real_time_factor") / factor - 1.0).abs() < 1e-9);
    assert!(number(&report, "step") < number(&report, "stable_step"));
    let energy = &report["energy"];
    let parts = ["kinetic", "elastic", "gravitational", "dissipated"];
    let sum: f64 = parts.iter().map(|part| number(energy, part)).sum();
    assert!((number(energy, "total") - sum).abs() < 1e-9 * sum.abs());
    assert_eq!(report["state_hash"].as_str().map(str::len), Some(16));
}

#[test]
fn the_solver_of_the_command_line_goes_before_that_of_the_scene() {
    let folder = folder();
    let run = |arguments: &[&str]| {
        json(msd(folder.path(), &[&["run", "chain", "--duration", "1"], arguments].concat()))
    };
    let report = run(&["--integrator", "rk4", "--substeps", "3", "--precision", "f64"]);
    assert_eq!(report["integrator"], "rk4");
    assert_eq!(report["precision"], "f64");
    assert!((number(&report, "step") - 1.0 / 180.0).abs() < 1e-15);
    assert_eq!(report["steps"], 180);
    let report = run(&["--step", "0.01"]);
    assert_eq!((&report["step"], &report["steps"]), (&0.01.into(), &100.into()));
}

#[test]
fn the_same_run_has_the_same_hash_and_another_has_another() {
    let folder = folder();
    let hash = |arguments: &[&str]| json(msd(folder.path(), arguments))["state_hash"].clone();
    let once = hash(&["run", "dice", "--duration", "0.5"]);
    assert_eq!(once, hash(&["run", "dice", "--duration", "0.5"]));
    assert_ne!(once, hash(&["run", "dice", "--duration", "0.6"]));
}

#[test]
fn a_run_in_two_halves_ends_with_the_same_bits_as_one() {
    let folder = folder();
    let path = folder.path();
    for precision in ["f32", "f64"] {
        let solver = ["--precision", precision];
        let run = |arguments: &[&str]| {
            quiet(msd(path, &[&["run", "jelly"], arguments, &solver].concat()))
        };
        run(&["--duration", "2", "--out", "whole.csv"]);
        run(&["--duration", "1", "--out", "half.csv"]);
        run(&["--duration", "1", "--from", "half.csv", "--out", "halves.csv"]);
        let read = |name: &str| std::fs::read(path.join(name)).expect(name);
        assert!(read("whole.csv") == read("halves.csv"), "{precision}");
        assert!(read("whole.csv") != read("half.csv"), "{precision}");
    }
}

#[test]
fn a_state_without_a_time_is_noted_where_solids_or_pins_move() {
    let folder = folder();
    let notes = |scene: &str| {
        let run = |arguments: &[&str]| {
            let all = [&["run", scene, "--duration", "0.05"], arguments].concat();
            json(msd(folder.path(), &all))["notes"].clone()
        };
        assert_eq!(run(&["--out", "s.csv"]), serde_json::json!([]));
        run(&["--from", "s.csv"])
    };
    let told = "s.csv holds no time: 1 solid that moves begins anew; use `--save RUN.msd` to \
                continue a run exactly";
    assert_eq!(notes("curtain"), serde_json::json!([told]));
    let pins = "s.csv holds no time: pins with `key_frames`, `follow` or `until` begin anew; use \
                `--save RUN.msd` to continue a run exactly";
    assert_eq!(notes("gripper"), serde_json::json!([pins]));
    // Its ball does not move.
    assert_eq!(notes("drape"), serde_json::json!([]));
}

#[test]
fn a_mesh_runs_and_its_state_has_a_row_per_particle() {
    let folder = folder();
    // No such file exists here: the built-in mesh replaces it.
    let said =
        quiet(msd(folder.path(), &["run", "bunny.obj", "--duration", "0.1", "--out", "s.csv"]));
    assert!(said.contains("1839 vertices") && said.contains("closed"), "{said}");
    let state = std::fs::read_to_string(folder.path().join("s.csv")).expect("s.csv");
    let mut lines = state.lines();
    assert_eq!(lines.next(), Some("particle,x,y,z,vx,vy,vz"));
    let rows: Vec<&str> = lines.collect();
    assert!(1839 < rows.len());
    assert!(rows.iter().enumerate().all(|(row, line)| line.starts_with(&format!("{row},"))));
}

#[test]
fn a_trace_has_the_start_and_a_row_per_step_and_conserves_energy() {
    let folder = folder();
    let arguments = ["run", "chain", "--duration", "2", "--trace", "t.csv", "--watch", "0,4"];
    quiet(msd(folder.path(), &arguments));
    let trace = std::fs::read_to_string(folder.path().join("t.csv")).expect("t.csv");
    let rows: Vec<Vec<&str>> = trace.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].join(","), HEADER);
    assert_eq!(rows.len(), 2 + 120);
    assert_eq!(rows[1][..2], ["0", "0.0"]);
    assert_eq!(rows[121][..2], ["120", "2.0"]);
    let total = |row: &Vec<&str>| row[7].parse::<f64>().expect("a number");
    // Half of k x² for x = 1.4 m, k = 10 N/m; the error of Verlet is of order (h w)², here 6e-4.
    assert!((total(&rows[1]) - 9.8).abs() < 1e-5);
    assert!(rows[1..].iter().all(|row| (total(row) - 9.8).abs() < 9.8 * 1e-3));
    assert_eq!(rows[1][16..], ["0.0", "0.0", "0.0", "5.4", "0.0", "0.0"]);
}

const HEADER: &str = "step,time,kinetic,elastic,gravitational,dissipated,supplied,total,\
                      contact_taken,contact_added,px,py,pz,lx,ly,lz,x0,y0,z0,x4,y4,z4";

#[test]
fn all_particles_can_be_watched() {
    let folder = folder();
    let traces = ["all", "0,1,2,3,4"].map(|watch| {
        let run = ["run", "chain", "--duration", "0.1", "--trace", "t.csv", "--watch", watch];
        quiet(msd(folder.path(), &run));
        std::fs::read_to_string(folder.path().join("t.csv")).expect("t.csv")
    });
    assert!(traces[0].lines().next().is_some_and(|head| head.ends_with(",x4,y4,z4")));
    assert_eq!(traces[0], traces[1]);
}

#[test]
fn a_trace_has_the_force_that_holds_each_set_of_pins() {
    let folder = folder();
    let scene = "version = 1\nbodies = [{ kind = 'rope', size = [3], spacing = 1, mass = 2, \
                 stiffness = 1000, damping = 40, \
                 rotation = { axis = [0, 0, 1], angle_deg = 90 } }]\n\
                 pins = [{ particle = 0 }, { set = 'right' }]\n\
                 solver = { precision = 'f64', substeps = 20 }\n";
    std::fs::write(folder.path().join("s.toml"), scene).expect("a folder");
    quiet(msd(folder.path(), &["run", "s.toml", "--duration", "5", "--trace", "t.csv"]));
    let trace = std::fs::read_to_string(folder.path().join("t.csv")).expect("t.csv");
    let mut lines = trace.lines();
    assert!(lines.next().is_some_and(|head| head.ends_with(",lz,fx.right,fy.right,fz.right")));
    let force = |line: &str| -> Vec<f64> {
        line.rsplit(',').take(3).map(|number| number.parse().expect("a number")).collect()
    };
    // At the start no spring pulls: the pin carries its own particle only.
    assert_eq!(force(lines.next().expect("a start")), [0.0, 2.0 * 9.82, 0.0]);
    // At rest each of the two pins carries half of the particle between them, whose motion has
    // decayed by exp(−t b / m) = exp(−100).
    let [z, y, x] = force(lines.last().expect("an end"))[..] else { panic!("three numbers") };
    assert!((x.abs(), (y - 3.0 * 9.82).abs(), z.abs()) < (1e-9, 1e-9, 1e-9), "{x} {y} {z}");
}

#[test]
fn a_run_of_no_duration_writes_the_start() {
    let folder = folder();
    let report = json(msd(folder.path(), &["run", "chain", "--duration", "0", "--out", "s.csv"]));
    assert_eq!(report["steps"], 0);
    assert_eq!(report["real_time_factor"], Value::Null);
    let state = std::fs::read_to_string(folder.path().join("s.csv")).expect("s.csv");
    assert_eq!(state.lines().nth(5), Some("4,5.4,0.0,0.0,0.0,0.0,0.0"));
}

#[test]
fn a_step_that_is_too_long_is_warned_of_with_the_longest_that_is_not() {
    let folder = folder();
    let output =
        outcome(msd(folder.path(), &["run", "square", "--step", "0.025", "--duration", "0.025"]));
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    let output =
        outcome(msd(folder.path(), &["run", "square", "--step", "0.05", "--duration", "0.05"]));
    let said = text(&output.stderr);
    assert!(said.starts_with("warning: the step of 50 ms is longer than 3"), "{said}");
    assert!(said.contains("try --substeps "), "{said}");
}

#[test]
fn a_run_that_diverges_says_where_and_keeps_the_last_good_state() {
    let folder = folder();
    let arguments = ["run", "cloth", "--substeps", "1", "--json", "--out", "s.csv"];
    let output = outcome(msd(folder.path(), &arguments));
    assert_eq!(output.status.code(), Some(3));
    let said = text(&output.stderr);
    let last = said.lines().last().expect("a line");
    for part in ["error: cloth: diverged: particle ", " in step "] {
        assert!(last.contains(part), "{said}");
    }
    // The advice appears once, and gives one limit.
    assert_eq!(said.matches("try --").count(), 1, "{said}");
    assert_eq!(said.matches("predicted").count(), 1, "{said}");
    let report = parse(&text(&output.stdout));
    assert_eq!(report["diverged"], true);
    let state = std::fs::read_to_string(folder.path().join("s.csv")).expect("s.csv");
    assert_eq!(state.lines().count(), 962);
    assert!(!state.contains("NaN") && !state.contains("inf"));
}

#[test]
fn the_advice_names_another_method_and_leads_to_a_run_that_lasts() {
    let folder = folder();
    let run = |more: &[&str]| {
        let arguments = ["run", "jelly", "--substeps", "4", "--duration", "2"];
        outcome(msd(folder.path(), &[&arguments[..], more].concat()))
    };
    let said = text(&run(&["--integrator", "explicit-euler"]).stderr);
    assert!(said.contains("--integrator velocity-verlet"), "{said}");
    // After a divergence, a stiffer material is not useful advice.
    assert!(!said.contains("inside out"), "{said}");
    let followed = run(&["--integrator", "velocity-verlet"]);
    assert_eq!((followed.status.code(), text(&followed.stderr).as_str()), (Some(0), ""));
}

#[test]
fn a_window_without_a_display_says_so_in_two_lines_and_names_what_works() {
    let output = outcome(msd(folder().path(), &["view", "cloth"]));
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 2, "{said}");
    assert!(said.contains("msd render cloth --out picture.png"), "{said}");
}

#[test]
fn a_picture_is_drawn_in_silence_where_there_is_an_adapter_and_a_line_names_what_is_missing() {
    let folder = folder();
    let output =
        outcome(msd(folder.path(), &["render", "chain", "--time", "0.1", "--size", "64x48"]));
    let said = text(&output.stderr);
    if output.status.code() == Some(0) {
        assert_eq!(said, "", "notes of a driver");
        let picture = image::open(folder.path().join("chain.png")).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (64, 48));
    } else {
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("no graphics adapter") && said.contains("apt install"), "{said}");
    }
}

#[test]
fn help_and_version_are_no_errors() {
    let folder = folder();
    assert!(quiet(msd(folder.path(), &["--help"])).contains("Usage: msd"));
    assert!(quiet(msd(folder.path(), &["run", "--help"])).contains("--substeps"));
    assert!(quiet(msd(folder.path(), &["--version"])).starts_with("msd "));
}

#[test]
fn a_file_that_leaves_out_its_substeps_says_which_it_took() {
    let folder = folder();
    let scene = "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [4, 4]\nstiffness = 1e7\n";
    std::fs::write(folder.path().join("c.toml"), scene).expect("a file");
    let report = json(msd(folder.path(), &["run", "c.toml", "--duration", "1"]));
    let (least, most) =
        (number(&report["automatic"], "least"), number(&report["automatic"], "most"));
    assert!(1.0 < least && least <= most, "{least} to {most}");
    assert!(number(&report, "step") <= 0.9 * number(&report, "stable_step"));
    assert!((60.0 * least..=60.0 * most).contains(&number(&report, "steps")));
    let told = quiet(msd(folder.path(), &["run", "c.toml", "--duration", "0.1"]));
    assert!(told.contains("substeps chosen: ") && told.contains("in each 16.67 ms"), "{told}");
    // A number replaces them, and the command line can select them.
    let fixed = json(msd(folder.path(), &["run", "c.toml", "--duration", "0", "--substeps", "99"]));
    assert_eq!((&fixed["automatic"], &fixed["substeps"]), (&Value::Null, &99.into()));
    let asked = ["run", "cube", "--duration", "0.1", "--substeps", "auto"];
    assert!(number(&json(msd(folder.path(), &asked))["automatic"], "most") < 12.0);
}

#[test]
fn a_recording_of_automatic_substeps_is_replayed_to_the_bit() {
    let folder = folder();
    let record = ["run", "foam", "--substeps", "auto", "--duration", "8", "--record", "c.msdrec"];
    // It warns of the flat cells at the sticky wall.
    let report = |arguments: &[&str]| -> Value {
        let said = done(msd(folder.path(), &[arguments, &["--json"]].concat()));
        serde_json::from_str(&said).expect("JSON")
    };
    let recorded = report(&record);
    let chosen = &recorded["automatic"];
    assert!(number(chosen, "least") < number(chosen, "most"), "{chosen}");
    let replayed = report(&["run", "--replay", "c.msdrec"]);
    assert_eq!(replayed["state_hash"], recorded["state_hash"]);
    let refused = ["run", "--replay", "c.msdrec", "--substeps", "auto"];
    assert!(
        text(&outcome(msd(folder.path(), &refused)).stderr)
            .contains("--substeps auto cannot be used")
    );
}

#[test]
fn inspect_prints_frequencies_in_one_unit() {
    let folder = folder();
    let path = folder.path();
    let oscillator = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [2]\nmass = 2\n\
                      stiffness = 50\ndamping = 1\n[[pins]]\nset = 'first'\n";
    std::fs::write(path.join("oscillator.toml"), oscillator).expect("a file");
    let slow = quiet(msd(path, &["inspect", "oscillator.toml"]));
    // w = sqrt(50 / 2) = 5 rad/s, and 1 / (2 x 2 x 5) of critical damping.
    assert!(slow.contains("fastest mode 0.7958 Hz\n"), "{slow}");
    assert!(slow.contains("slowest mode 0.796 Hz, with a damping ratio of 0.05\n"), "{slow}");
    assert!(slow.contains("Young's modulus times cross-section 50 N in 2 directions"), "{slow}");
}

#[test]
fn inspect_prints_what_a_body_amounts_to_and_refuses_what_is_no_scene() {
    let folder = folder();
    let path = folder.path();
    let block = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [3, 3, 3]\nspacing = 0.01\n\
                 material = 'gelatine-5%'\n";
    std::fs::write(path.join("gel.toml"), block).expect("a file");
    let report = json(msd(path, &["inspect", "gel.toml"]));
    let body = &report["bodies"][0];
    let is_near = |value: &serde_json::Value, expected: f64| {
        let value = value.as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 1e-9, "{value} is not {expected}");
    };
    is_near(&body["mass"], 998.0 * 8e-6);
    assert_eq!(body["moduli"]["young"].as_array().expect("a list").len(), 13);
    is_near(&body["moduli"]["young"][9][1], 3.0 * 4180.0);
    is_near(&body["moduli"]["anisotropy"], 1.0);
    is_near(&body["moduli"]["poisson"][0], 0.25);
    assert!(0.0 < report["stable_step"].as_f64().expect("a limit"));
    let text = quiet(msd(path, &["inspect", "gel.toml"]));
    assert!(text.contains("Young's modulus 12540 Pa in 26 directions\n"), "{text}");
    assert!(text.contains("gelatine-5%: Poisson's ratio is 1/4, that of springs"), "{text}");
    // It may take longer than a second and then print a notice.
    let bunny = outcome(msd(path, &["inspect", "bunny"])).stdout;
    let bunny = String::from_utf8_lossy(&bunny);
    assert!(bunny.contains("volume") && bunny.contains("bunny.obj: "), "{bunny}");
    assert!(refused(msd(path, &["inspect", "gel.tml"]), 2).contains("gel.tml"));
    assert!(body["touch"].is_null() && !text.contains("thickness"), "{text}");
    let touching = "version = 1\n[[bodies]]\nkind = 'cloth'\nsize = [3, 3]\nspacing = 0.1\n\
                    stiffness = 80\ntouch = { restitution = 0.25 }\n";
    std::fs::write(path.join("touch.toml"), touching).expect("a file");
    let told = quiet(msd(path, &["inspect", "touch.toml"]));
    let line = "collides with itself and others: thickness 0.01 m, friction 0.5, restitution 0.25";
    assert!(told.contains(line), "{told}");
    is_near(&json(msd(path, &["inspect", "touch.toml"]))["bodies"][0]["touch"]["thickness"], 0.01);
    let rope = |name: &str, touch: &str| {
        format!("[[bodies]]\nname = '{name}'\nkind = 'rope'\nsize = [3]\ntouch = {{ {touch} }}\n")
    };
    let three = [
        rope("a", "obstacles = true"),
        rope("b", "ignore = ['a']"),
        rope("c", "with = [{ body = 'a', friction = 0.75, restitution = 0.5 }]"),
    ];
    std::fs::write(path.join("three.toml"), format!("version = 1\n{}", three.concat())).unwrap();
    let told = quiet(msd(path, &["inspect", "three.toml"]));
    for line in [
        "  collides with itself and others: thickness 0.1 m, friction 0.5, restitution 0\n",
        "  collides with obstacles at its thickness\n",
        "  collides with c: friction 0.75, restitution 0.5\n  passes through b\n",
    ] {
        assert!(told.contains(line), "{told}");
    }
    let first = &json(msd(path, &["inspect", "three.toml"]))["bodies"][0]["touch"];
    assert_eq!((&first["obstacles"], &first["ignore"][0]), (&true.into(), &"b".into()));
    assert_eq!(
        (&first["with"][0]["body"], &first["with"][0]["friction"]),
        (&"c".into(), &0.75.into())
    );
}
