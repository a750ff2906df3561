//! `--device` of sweeps, studies and tuning, and the verdicts that the cache holds; here on an
//! adapter in software.
//!
//! Without an adapter each test that needs one prints that it skips, unless `MSD_REQUIRE_ADAPTER`
//! is set.

use crate::common::{folder, msd, names, outcome, parse, quiet, refused, text};
use crate::devices::devices;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Columns that a device measures.
const COLUMNS: &str = "columns = ['integrator', 'precision', 'substeps', 'stable_substep', \
    'outcome', 'diverged_time', 'diverged_particle', 'duration', 'steps', 'rms_error', \
    'energy_error', 'penetration', 'samples', 'kinetic', 'elastic', 'gravitational', \
    'state_hash', 'note']\n";

/// A square falls on a plane; with the stiffer springs and one substep it diverges.
const SQUARE: &str = "version = 1\nscene = 'square'\nduration = 1\nerror = true\nCOLUMNS[grid]\n\
    'solver.integrator' = ['explicit-euler', 'symplectic-euler', 'velocity-verlet', 'rk4']\n\
    'solver.substeps' = [1, 16]\n'bodies[0].stiffness' = [50, 200, 1e7]\n\
    'world.planes[0].restitution' = [0, 0.5]\n";

fn sweep(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = msd(folder, &[&["sweep", "s.toml"], arguments].concat());
    command.env("MSD_CACHE", folder.join("cache"));
    command
}

fn write(folder: &Path, text: &str) {
    fs::write(folder.join("s.toml"), text.replace("COLUMNS", COLUMNS)).expect("a file");
}

/// Runs a command that must succeed; returns its output and its lines on standard error.
fn told(command: Command) -> (String, String) {
    let output = outcome(command);
    let [said, noted] = [&output.stdout, &output.stderr].map(|bytes| text(bytes));
    assert_eq!(output.status.code(), Some(0), "{noted}");
    (said, noted)
}

fn files(folder: &Path) -> BTreeMap<String, String> {
    let read = |name: String| {
        let text = fs::read_to_string(folder.join(&name)).expect("a file");
        (name, text)
    };
    names(folder).into_iter().map(read).collect()
}

#[test]
fn a_sweep_on_a_device_writes_the_bytes_of_the_processor() {
    let folder = folder();
    let path = folder.path();
    let Some(listed) = devices(path) else { return };
    write(path, SQUARE);
    let here = told(sweep(path, &["--out", "here", "--json"]));
    let there = told(sweep(path, &["--out", "there", "--json", "--device", "gpu", "-j", "2"]));
    assert_eq!(files(&path.join("here")), files(&path.join("there")));
    let table = |name: &str| fs::read_to_string(path.join(name)).expect("a table");
    assert_eq!(table("here.csv"), table("there.csv"));
    let [here, report] = [&here.0, &there.0].map(|said| parse(said));
    for key in ["run", "skipped", "diverged", "left"] {
        assert_eq!(here[key], report[key], "{key}");
    }
    let diverged = here["diverged"].as_u64().expect("a count");
    assert!((8..48).contains(&diverged), "{diverged}");
    let found = |report: &Value| ["run", "on_device", "device"].map(|key| report[key].clone());
    assert_eq!(found(&here), [json!(48), json!(0), json!("processor")]);
    let name = listed[0]["name"].as_str().expect("a name");
    assert_eq!(found(&report), [json!(48), json!(48), json!(name)]);
    assert!(there.1.starts_with(&format!("device: {name}, same bits as")), "{}", there.1);
    // Nothing is left to do: no device is opened.
    let again = told(sweep(path, &["--out", "there", "--device", "gpu"]));
    assert_eq!(again.1, "");
}

#[test]
fn what_a_device_does_not_do_in_a_sweep_is_refused_with_what_to_change() {
    let folder = folder();
    let path = folder.path();
    let grid = |scene: &str, grid: &str| {
        format!("version = 1\nscene = '{scene}'\nduration = 0.1\nCOLUMNS[grid]\n{grid}\n")
    };
    for (text, refusal) in [
        (
            SQUARE.replace("COLUMNS", ""),
            "s.toml: a GPU does not measure the columns cpu_seconds, cpu_per_second, \
             wall_seconds, spring_updates_per_second, dissipated, supplied, total_energy; name \
             others in the sweep file, such as columns = [\"outcome\", \"diverged_time\", \
             \"kinetic\", \"elastic\", \"state_hash\"]",
        ),
        (
            grid("chain", "solver.substeps = [8]\nsolver.precision = ['f32', 'f64']"),
            "s.toml: cell 1 (solver.substeps = 8, solver.precision = \"f64\"): a GPU does not step \
             f64; set solver.precision = \"f32\" in the grid or the scene",
        ),
        (
            grid("cloth", "solver.substeps = [8, 'auto']"),
            "s.toml: cell 1 (solver.substeps = \"auto\"): a GPU does not step automatic substeps, \
             which depend on the energy of each step; set solver.substeps = 6, the first choice",
        ),
        (
            grid("chain", "solver.integrator = ['rk4', 'xpbd']\nsolver.substeps = [8]"),
            "s.toml: cell 1 (solver.integrator = \"xpbd\", solver.substeps = 8): a GPU does not \
             step the method xpbd; run the sweep on the processor (--device cpu)",
        ),
        (
            grid("flag", "solver.substeps = [8]"),
            "s.toml: cell 0 (solver.substeps = 8): a GPU does not step air; run the sweep on",
        ),
    ] {
        write(path, &text);
        let said = refused(sweep(path, &["--device", "gpu"]), 2);
        assert!(said.contains(refusal), "{said}");
        // The processor runs it instead, and says why.
        let (_, noted) = told(sweep(path, &["--device", "auto", "--task", "0"]));
        let refuses_first = said.contains("cell 0") || !said.contains("cell ");
        let why = refusal.split("; ").next().expect("a reason").trim_start_matches("s.toml: ");
        if refuses_first {
            assert!(noted.starts_with(&format!("device: processor, as {why}")), "{noted}");
        } else {
            assert!(noted.starts_with("device: "), "{noted}");
        }
        fs::remove_dir_all(path.join("s")).expect("a folder");
    }
}

#[test]
fn without_an_adapter_the_processor_runs_a_sweep_on_auto_alone() {
    let folder = folder();
    let path = folder.path();
    write(path, SQUARE);
    let mut none = sweep(path, &["--device", "gpu"]);
    none.env("WGPU_BACKEND", "metal");
    let said = refused(none, 2);
    assert!(said.starts_with("error: s.toml: there is no graphics adapter"), "{said}");
    assert!(!path.join("s").exists());
    let mut none = sweep(path, &["--device", "auto", "--task", "3"]);
    none.env("WGPU_BACKEND", "metal");
    let (said, noted) = told(none);
    assert!(said.starts_with("1 cell: 1 run"), "{said}");
    assert!(noted.starts_with("device: processor, as there is no graphics adapter\n"), "{noted}");
}

#[test]
fn on_auto_a_sweep_prints_the_times_of_both() {
    let folder = folder();
    let path = folder.path();
    if devices(path).is_none() {
        return;
    }
    write(path, SQUARE);
    let (_, noted) = told(sweep(path, &["--device", "auto"]));
    assert!(noted.starts_with("device: ") && noted.contains("a step of "), "{noted}");
    let (_, _) = told(sweep(path, &["--out", "here"]));
    assert_eq!(files(&path.join("s")), files(&path.join("here")));
}

/// The note on the verdict of the adapter of a run.
fn verdict(folder: &Path) -> String {
    let run = ["run", "chain", "--duration", "0.1", "--device", "gpu", "--json"];
    let mut command = msd(folder, &run);
    command.env("MSD_CACHE", folder.join("cache"));
    let report = parse(&quiet(command));
    report["notes"][0].as_str().expect("a note").to_owned()
}

#[test]
fn the_cache_holds_a_verdict_until_msd_devices_renews_it() {
    let folder = folder();
    let path = folder.path();
    if devices(path).is_none() {
        return;
    }
    let cache = path.join("cache");
    let probed = verdict(path);
    let [file] = &names(&cache)[..] else { panic!("{:?}", names(&cache)) };
    assert!(file.starts_with("verdict-"), "{file}");
    let file = cache.join(file);
    let bytes = fs::read(&file).expect("a verdict");
    // Another verdict, whole: it is read.
    let put = |manner: &str| {
        let content = postcard::to_allocvec(manner).expect("bytes");
        let sum = blake3::hash(&content);
        fs::write(&file, [&sum.as_bytes()[..], &content].concat()).expect("a file");
    };
    put("Manner { spelling: Hidden, roots: Whole }");
    assert!(verdict(path).contains("(hidden sums, whole roots)"), "{}", verdict(path));
    let mut list = msd(path, &["devices"]);
    list.env("MSD_CACHE", &cache);
    quiet(list);
    assert_eq!(fs::read(&file).expect("a verdict"), bytes);
    assert_eq!(verdict(path), probed);
    // A manner of a later msd; torn files; those of others.
    put("Manner { spelling: Exact, roots: Square }");
    assert_eq!(verdict(path), probed);
    assert_eq!(fs::read(&file).expect("a verdict"), bytes);
    for broken in [&bytes[..bytes.len() - 1], b"", b"foreign"] {
        fs::write(&file, broken).expect("a file");
        assert_eq!(verdict(path), probed);
        assert_eq!(fs::read(&file).expect("a verdict"), bytes);
    }
    // A verdict of another adapter, driver or msd has another name.
    let other = cache.join(format!("verdict-{}", "0".repeat(32)));
    fs::rename(&file, &other).expect("a file");
    put("Manner { spelling: Hidden, roots: Whole }");
    fs::rename(&file, &other).expect("a file");
    assert_eq!(verdict(path), probed);
    assert_eq!(fs::read(&file).expect("a verdict"), bytes);
}

#[test]
fn a_study_times_the_settings_that_a_device_steps_and_its_errors_are_those_of_the_processor() {
    let folder = folder();
    let path = folder.path();
    let Some(listed) = devices(path) else { return };
    let name = listed[0]["name"].as_str().expect("a name");
    let study = ["study", "chain", "--duration", "0.1", "--time", "3", "--device", "gpu"];
    let (said, noted) = told(msd(path, &[&study[..], &["--json"]].concat()));
    assert!(noted.starts_with(&format!("device: {name}, same bits as")), "{noted}");
    let study = parse(&said);
    let on_device = &study["on_device"];
    assert_eq!((&on_device["name"], &on_device["fault"]), (&Value::from(name), &Value::Null));
    let costs = on_device["costs"].as_array().expect("costs");
    let explicit = ["explicit-euler", "symplectic-euler", "velocity-verlet", "rk4"];
    let steps = |choice: &Value| {
        let method = choice["integrator"].as_str().expect("a method");
        choice["precision"] == "f32" && explicit.contains(&method)
    };
    let trials = study["trials"].as_array().expect("trials").iter();
    let timed = trials.filter(|trial| steps(&trial["choice"]) && !trial["errors"].is_null());
    assert_eq!(costs.len(), timed.count());
    assert!(3 < costs.len());
    for cost in costs {
        assert!(steps(&cost[0]) && cost[1].as_f64().is_some_and(|cost| 0.0 < cost), "{cost}");
    }
    let table = fs::read_to_string(path.join("chain-study/study.csv")).expect("a table");
    let column = table.lines().next().expect("a head").split(',');
    let column = column.into_iter().position(|name| name == "device_ms_per_frame").expect("it");
    let filled = table.lines().skip(1).filter(|line| line.split(',').nth(column) != Some(""));
    assert_eq!(filled.count(), costs.len());
    let words = study["words"].as_str().expect("words");
    assert!(words.contains(&format!("On {name} ")), "{words}");
    let page = fs::read_to_string(path.join("chain-study/report.html")).expect("a page");
    assert!(page.contains("The best trade-offs on a graphics device"));
}

#[test]
fn a_scene_is_tuned_for_a_device_by_its_time_among_the_settings_that_it_steps() {
    let folder = folder();
    let path = folder.path();
    let Some(listed) = devices(path) else { return };
    let tune = |arguments: &[&str]| {
        let tune = ["tune", "chain", "--duration", "0.1", "--max-error", "1e-3"];
        told(msd(path, &[&tune[..], arguments].concat()))
    };
    let report = parse(&tune(&["--device", "gpu", "--json"]).0);
    assert_eq!((&report["device"], &report["met"]), (&listed[0]["name"], &Value::from(true)));
    assert_eq!(report["precision"], "f32");
    assert!(report["substeps"].as_u64().is_some() && report["verified_error"].as_f64().is_some());
    let name = listed[0]["name"].as_str().expect("a name");
    let (said, _) = tune(&["--device", "gpu"]);
    assert!(said.lines().next().expect("a line").ends_with(&format!(", on {name}")), "{said}");
    assert!(said.contains(" with transfers per frame"), "{said}");
    assert_eq!(parse(&tune(&["--json"]).0)["device"], "processor");
    // A device in software is dearer than the processor that it runs on.
    let (said, noted) = tune(&["--device", "auto", "--json"]);
    assert_eq!(parse(&said)["device"], "processor");
    let line = "device: processor, as the best setting on the processor takes ";
    assert!(
        noted.starts_with(line) && noted.contains(&format!(", and that on {name} ")),
        "{noted}"
    );
}

#[test]
fn settings_of_a_scene_that_a_device_does_not_step_are_refused() {
    let folder = folder();
    let path = folder.path();
    let refusal = "flag: a GPU does not step air; run the scene on the processor (--device cpu)";
    for arguments in [&["study", "flag"][..], &["tune", "flag", "--max-error", "1e-3"]] {
        let said = refused(msd(path, &[arguments, &["--device", "gpu"]].concat()), 2);
        assert!(said.contains(refusal), "{said}");
    }
    for arguments in
        [&["study", "chain", "--terms"][..], &["tune", "chain", "--max-error", "1", "--mesh"]]
    {
        let said = refused(msd(path, &[arguments, &["--device", "gpu"]].concat()), 2);
        assert!(said.contains("cannot be used with"), "{said}");
    }
}
