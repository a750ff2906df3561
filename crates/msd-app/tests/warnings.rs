//! Warnings and results of `msd run`: energy that an integrator adds, and what a solve leaves.

mod common;

use common::{folder, msd, outcome, parse, text};
use serde_json::Value;

const SPRING: &str = "version = 1\n[world]\ngravity = [0, 0, 0]\n[[bodies]]\nkind = \"rope\"\n\
                      size = [2]\nstiffness = 50\ndamping = 0\nspin = [0, 0, 1]\n";

#[test]
fn energy_that_the_integrator_adds_is_a_warning_and_a_field() {
    let folder = folder();
    std::fs::write(folder.path().join("spring.toml"), SPRING).unwrap();
    let run = |integrator: &str| {
        let arguments = ["run", "spring.toml", "--json", "--integrator", integrator];
        let output = outcome(msd(folder.path(), &[&arguments[..], &["--step", "0.02"]].concat()));
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let told = parse(&text(&output.stdout));
        (told, text(&output.stderr))
    };
    let (told, warned) = run("explicit-euler");
    assert!(0.0 < told["energy_gain"]["joules"].as_f64().unwrap(), "{told}");
    assert!(0.0 < told["energy_gain"]["since"].as_f64().unwrap());
    assert!(warned.contains("explicit-euler is adding energy"), "{warned}");
    let (told, warned) = run("velocity-verlet");
    assert_eq!(told["energy_gain"], Value::Null);
    assert!(!warned.contains("adding energy"), "{warned}");
}

#[test]
fn a_body_that_goes_through_another_is_named_with_the_time() {
    let folder = folder();
    std::fs::write(
        folder.path().join("pressed.toml"),
        include_str!("../../msd-run/tests/scenes/pressed.toml"),
    )
    .unwrap();
    let output = outcome(msd(folder.path(), &["run", "pressed.toml", "--json", "--duration", "1"]));
    let (told, warned) = (parse(&text(&output.stdout)), text(&output.stderr));
    assert!(warned.contains("ball went through bed at t = 40"), "{warned}");
    let went = &told["touched"]["went_through"];
    assert_eq!((&went[0]["body"], &went[0]["through"]), (&"ball".into(), &"bed".into()), "{told}");
    // The box arrives in the plane of the bed after 0.40074 s, and a substep is 2 ms long.
    assert!((went[0]["time"].as_f64().unwrap() - 0.40074).abs() < 5e-3, "{went}");
    assert_eq!(went[1], Value::Null);
}

#[test]
fn energy_of_bounces_that_dampers_dissipate_is_a_field() {
    let folder = folder();
    let run = ["run", "dice", "--substeps", "16", "--duration", "5", "--json"];
    let output = outcome(msd(folder.path(), &run));
    let told = parse(&text(&output.stdout));
    // 4.1 kJ of 72: see docs/trade.md, "Bounces of stiff bodies".
    let change = told["imbalance"].as_f64().expect("a number");
    assert!((3e3..5e3).contains(&change), "{change}");
    assert!(!text(&output.stderr).contains("total energy"), "less than a tenth");
    // Near the limit of stability they add more than a tenth.
    let run = ["run", "dice", "--substeps", "10", "--duration", "3", "--json"];
    let output = outcome(msd(folder.path(), &run));
    let told = parse(&text(&output.stdout));
    assert_eq!(told["energy_gain"], Value::Null);
    let warning = told["warnings"][0].as_str().expect("a warning");
    assert!(warning.starts_with("the total energy has risen by 27.49 kJ, "), "{warning}");
    assert!(text(&output.stderr).contains(warning));
}

#[test]
fn where_a_moving_pin_does_work_nothing_is_said_of_the_balance() {
    let folder = folder();
    let scene = format!("{SPRING}\n[[pins]]\nbody = 0\nparticle = 0\nvelocity = [0, 1, 0]\n");
    std::fs::write(folder.path().join("driven.toml"), scene).unwrap();
    let arguments = ["run", "driven.toml", "--json", "--duration", "0.1"];
    let told = parse(&text(&outcome(msd(folder.path(), &arguments)).stdout));
    assert_eq!(told["imbalance"], Value::Null);
}

/// A rope that hangs level from one end, of this stiffness.
fn rope(stiffness: &str) -> String {
    format!(
        "version = 1\n[[bodies]]\nkind = \"rope\"\nsize = [5]\nstiffness = {stiffness}\n\
         damping = 0\n[[pins]]\nbody = 0\nparticle = 0\n"
    )
}

#[test]
fn an_implicit_run_tells_how_far_its_solves_got_and_one_that_cannot_be_solved_fails() {
    let folder = folder();
    std::fs::write(folder.path().join("soft.toml"), rope("100")).unwrap();
    std::fs::write(folder.path().join("stiff.toml"), rope("1e37")).unwrap();
    let run = |scene: &str, method: &str| {
        let arguments = ["run", scene, "--integrator", method, "--duration", "0.1", "--json"];
        outcome(msd(folder.path(), &arguments))
    };
    for (method, tolerance) in [("backward-euler", 1e-3), ("implicit-midpoint", 1e-6)] {
        let told = parse(&text(&run("soft.toml", method).stdout));
        assert!(0 < told["solved"]["iterations"].as_u64().unwrap(), "{told}");
        assert!(told["solved"]["residual"].as_f64().unwrap() <= tolerance, "{told}");
        let output = run("stiff.toml", method);
        assert_eq!(output.status.code(), Some(3), "{method}");
        assert!(text(&output.stderr).contains("is not solved"), "{}", text(&output.stderr));
    }
    let told = parse(&text(&run("soft.toml", "velocity-verlet").stdout));
    assert_eq!(told["solved"], Value::Null);
}

#[test]
fn a_scene_far_away_runs_in_f64_unless_told_otherwise_and_then_warns_of_lost_digits() {
    let folder = folder();
    let scene = |x: &str| {
        format!(
            "version = 1\n[[bodies]]\nkind = \"block\"\nsize = [3, 3, 3]\nspacing = 0.5\n\
             stiffness = 1000\nposition = [{x}, 0, 0]\n"
        )
    };
    std::fs::write(folder.path().join("far.toml"), scene("1e5")).unwrap();
    std::fs::write(folder.path().join("near.toml"), scene("1")).unwrap();
    let ran = |arguments: &[&str]| {
        let arguments = [&["run"], arguments, &["--duration", "0.1", "--json"]].concat();
        let output = outcome(msd(folder.path(), &arguments));
        let warned = "single precision rounds positions to 12 mm";
        let told = parse(&text(&output.stdout));
        let precision = told["precision"].as_str().expect("a name").to_owned();
        (precision, text(&output.stderr).contains(warned), told["notes"].to_string())
    };
    let (precision, warned, notes) = ran(&["far.toml"]);
    assert_eq!((&*precision, warned), ("f64", false));
    assert!(notes.contains("100000 m from the origin f32 rounds positions to 1.2e-2 m"), "{notes}");
    let (precision, warned, _) = ran(&["far.toml", "--precision", "f32"]);
    assert_eq!((&*precision, warned), ("f32", true));
    let (precision, warned, _) = ran(&["far.toml", "--set", "solver.precision=f32"]);
    assert_eq!((&*precision, warned), ("f32", true));
    let (precision, warned, notes) = ran(&["near.toml"]);
    assert_eq!((&*precision, warned, &*notes), ("f32", false, "[]"));
}
