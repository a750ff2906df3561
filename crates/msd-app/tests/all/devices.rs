//! `--device` and `msd devices`: runs on a graphics adapter, here one in software.
//!
//! Without an adapter each test prints that it skips, unless `MSD_REQUIRE_ADAPTER` is set.

use crate::common::{folder, json, msd, parse, quiet, refused};
use serde_json::{Value, json};
use std::path::Path;

/// Returns the list of `msd devices`, unless it is empty.
pub fn devices(folder: &Path) -> Option<Vec<Value>> {
    let listed = parse(&quiet(msd(folder, &["devices", "--json"])));
    let listed = listed.as_array().expect("a list").clone();
    if listed.is_empty() {
        assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter");
        println!("SKIPPED: no adapter");
    }
    (!listed.is_empty()).then_some(listed)
}

fn run(folder: &Path, arguments: &[&str]) -> Value {
    json(msd(folder, &[&["run"], arguments].concat()))
}

#[test]
fn devices_lists_each_adapter_with_its_verdict() {
    let folder = folder();
    let lines = quiet(msd(folder.path(), &["devices"]));
    let Some(listed) = devices(folder.path()) else {
        return assert!(lines.starts_with("no graphics adapter"), "{lines}");
    };
    assert_eq!(lines.lines().count(), listed.len());
    for (row, line) in listed.iter().zip(lines.lines()) {
        let keys: Vec<&str> = row.as_object().expect("keys").keys().map(String::as_str).collect();
        assert_eq!(keys, ["name", "kind", "backend", "driver", "verdict", "reason"]);
        assert!(["same-bits", "differs", "unusable"].map(Value::from).contains(&row["verdict"]));
        for key in ["name", "kind", "backend", "reason"] {
            assert!(line.contains(row[key].as_str().expect("text")), "{key}: {line}");
        }
    }
}

#[test]
fn a_run_on_a_device_ends_in_the_bits_of_the_processor() {
    let folder = folder();
    let path = folder.path();
    if devices(path).is_none() {
        return;
    }
    for scene in ["jelly", "cloth"] {
        let duration = [scene, "--duration", "1"];
        let [here, there] = ["cpu", "gpu"]
            .map(|device| run(path, &[&duration[..], &["--device", device]].concat()));
        for key in ["state_hash", "steps", "momentum", "findings", "warnings"] {
            assert_eq!(here[key], there[key], "{scene} {key}");
        }
        for key in ["kinetic", "elastic", "gravitational", "supplied"] {
            assert_eq!(here["energy"][key], there["energy"][key], "{scene} {key}");
        }
        assert_eq!((&here["device"], &here["device_steps"]), (&"processor".into(), &0.into()));
        assert_eq!(here["processor_steps"], here["steps"]);
        assert_eq!((&there["device_steps"], &there["processor_steps"]), (&480.into(), &0.into()));
        let name = there["device"].as_str().expect("a name");
        assert!(there["notes"][0].as_str().is_some_and(|note| note.contains(name)), "{there}");
        // A device does not measure what is dissipated.
        for value in [&there["energy"]["dissipated"], &there["energy"]["total"]] {
            assert_eq!(*value, Value::Null);
        }
        for key in ["contacts", "imbalance", "energy_gain", "energy_loss"] {
            assert_eq!(there[key], Value::Null, "{key}");
        }
    }
}

#[test]
fn a_device_can_be_named_and_the_summary_says_what_it_does_not_measure() {
    let folder = folder();
    let Some(listed) = devices(folder.path()) else { return };
    let name = listed[0]["name"].as_str().expect("a name").to_uppercase();
    let told = quiet(msd(folder.path(), &["run", "chain", "--duration", "0.5", "--device", &name]));
    assert!(
        told.starts_with("device: ") && told.contains(", same bits as the processor"),
        "{told}"
    );
    assert!(told.contains("dissipated and total not measured on a GPU\n"), "{told}");
}

#[test]
fn auto_takes_the_faster_one_and_says_why() {
    let folder = folder();
    let path = folder.path();
    let here = run(path, &["chain", "--duration", "0.5"]);
    for (more, reason) in [
        (&["--device", "auto"][..], "device: "),
        (
            &["--device", "auto", "--precision", "f64"],
            "device: processor, as a GPU does not step f64",
        ),
    ] {
        let there = run(path, &[&["chain", "--duration", "0.5"], more].concat());
        let note = there["notes"][0].as_str().expect("a note");
        assert!(note.starts_with(reason), "{note}");
        assert_eq!(there["state_hash"] == here["state_hash"], more.len() == 2);
    }
}

#[test]
fn files_of_a_run_on_a_device_are_those_of_one_on_the_processor() {
    let folder = folder();
    let path = folder.path();
    if devices(path).is_none() {
        return;
    }
    let rows = |device: &str| {
        let files = ["--trace", "t.csv", "--out", "s.csv", "--record", "r.msdrec"];
        let more = ["--save", "r.msd", "--duration", "0.5", "--device", device, "-q"];
        quiet(msd(path, &[&["run", "cloth"], &files[..], &more].concat()));
        let replayed = quiet(msd(path, &["run", "--replay", "r.msdrec"]));
        assert!(replayed.contains("replayed to the same bits"), "{replayed}");
        let resumed = run(path, &["r.msd", "--duration", "0.1"])["state_hash"].clone();
        let [trace, state] = ["t.csv", "s.csv"].map(|name| {
            let text = std::fs::read_to_string(path.join(name)).expect(name);
            let rows = text.lines().map(|line| line.split(',').map(str::to_owned).collect());
            rows.collect::<Vec<Vec<String>>>()
        });
        (trace, state, resumed)
    };
    let (mut here, there) = (rows("cpu"), rows("gpu"));
    let unknown = ["dissipated", "total", "contact_taken", "contact_added"];
    let columns = there.0[0].clone();
    let unknown = columns.iter().enumerate().filter(|(_, name)| unknown.contains(&name.as_str()));
    for (column, _) in unknown {
        // The first row is the start.
        for row in 2..here.0.len() {
            here.0[row][column] = "NaN".to_owned();
        }
    }
    assert_eq!(here, there);
}

#[test]
fn what_a_device_does_not_step_is_refused_with_the_reason_and_what_to_do() {
    let folder = folder();
    let path = folder.path();
    let gusts = "version = 1\n[world.wind]\nstrength = 1\ngusts = 0.5\n[[bodies]]\n\
                 kind = 'rope'\nsize = [3]\n[solver]\nsubsteps = 8\n";
    std::fs::write(path.join("gusts.toml"), gusts).expect("a file");
    for (arguments, told) in [
        (
            &["run", "flag"][..],
            "flag: a GPU does not step air; run the scene on the processor (--device cpu)",
        ),
        (&["run", "gusts.toml"], "gusts: a GPU does not step gusts of wind; run the scene on"),
        (&["run", "jelly", "--integrator", "xpbd"], "a GPU does not step the method xpbd"),
        (
            &["run", "jelly", "--precision", "f64"],
            "jelly: a GPU does not step f64; add --precision f32",
        ),
        (
            &["run", "cloth", "--substeps", "auto"],
            "cloth: a GPU does not step automatic substeps, which depend on the energy of each \
             step; add --substeps 6, the first choice of",
        ),
        (&["bench", "drape", "5"], "drape 5: a GPU does not step bodies that collide"),
        (&["run", "--replay", "r.msdrec"], "'--replay <FILE.msdrec>' cannot be used with"),
        (&["view", "jelly"], "there is no option --device of msd view; it belongs to msd run, msd"),
    ] {
        let said = refused(msd(path, &[arguments, &["--device", "gpu"]].concat()), 2);
        assert!(said.contains(told), "{arguments:?}: {said}");
    }
    for (name, told) in [
        ("", "must be cpu, gpu, auto or a part of a name that `msd devices` lists"),
        ("no such card", "no graphics adapter named \"no such card\"; `msd devices` lists them"),
    ] {
        let said = refused(msd(path, &["run", "jelly", "--device", name]), 2);
        assert!(said.contains(told), "{said}");
    }
}

#[test]
fn a_device_is_measured_beside_the_processor() {
    let folder = folder();
    let path = folder.path();
    if devices(path).is_none() {
        return;
    }
    let measured = json(msd(path, &["bench", "cloth", "8", "--device", "gpu"]));
    assert_ne!(measured["device"], "processor");
    let on_device = &measured["on_device"];
    for speed in [&measured, on_device] {
        // Each frame updates 210 springs in each of 12 substeps.
        let seconds = 1e-3 * speed["ms_per_frame"]["wall"].as_f64().expect("a time");
        let median = speed["updates_per_second"]["median"].as_f64().expect("a speed");
        assert!((seconds * median / (12.0 * 210.0) - 1.0).abs() < 1e-9, "{speed}");
    }
    let told = quiet(msd(path, &["bench", "cloth", "8", "--device", "gpu"]));
    let line = |line: &str| line.starts_with("device: ") && line.contains("G spring updates/s");
    assert!(told.lines().any(line), "{told}");
    let alone = json(msd(path, &["bench", "cloth", "2"]));
    assert_eq!((&alone["device"], &alone["on_device"]), (&json!("processor"), &Value::Null));
}
