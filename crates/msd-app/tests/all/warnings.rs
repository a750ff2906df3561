//! Warnings and results of `msd run`: energy added by an integrator, and residuals of solves. Each
//! kind of finding, which the window reports in the same words.

use crate::common::{folder, msd, outcome, parse, text};
use msd_app::session::Session;
use msd_run::Finding;
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
        include_str!("../../../msd-run/tests/scenes/pressed.toml"),
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
    // 4.1 kJ of 72: see docs/explanation/accuracy.md, "Bounces of stiff bodies".
    let change = told["imbalance"].as_f64().expect("a number");
    assert!((3e3..5e3).contains(&change), "{change}");
    assert!(!text(&output.stderr).contains("total energy"), "less than a tenth");
    // Near the limit of stability, the bounces add more than a tenth.
    let run = ["run", "dice", "--substeps", "10", "--duration", "3", "--json"];
    let output = outcome(msd(folder.path(), &run));
    let told = parse(&text(&output.stdout));
    assert_eq!(told["energy_gain"], Value::Null);
    let warning = told["warnings"][0].as_str().expect("a warning");
    assert!(warning.starts_with("the total energy has risen by 27.49 kJ, "), "{warning}");
    assert!(text(&output.stderr).contains(warning));
}

#[test]
fn the_work_of_a_moving_pin_is_a_part_of_the_balance() {
    let folder = folder();
    let scene = format!("{SPRING}\n[[pins]]\nbody = 0\nparticle = 0\nvelocity = [0, 1, 0]\n");
    std::fs::write(folder.path().join("driven.toml"), scene).unwrap();
    let arguments = ["run", "driven.toml", "--json", "--duration", "0.1", "--precision", "f64"];
    let told = parse(&text(&outcome(msd(folder.path(), &arguments)).stdout));
    let [imbalance, supplied] =
        [&told["imbalance"], &told["energy"]["supplied"]].map(|value| value.as_f64().unwrap());
    // The error of velocity Verlet is of order (h w)², with w² = 50 / 1 and h = 1/60.
    assert!(0.0 < supplied && imbalance.abs() < 50.0 / 3600.0 * supplied, "{told}");
}

/// Returns a horizontal rope that hangs from one end, of this stiffness.
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

#[test]
fn each_key_of_the_report_is_documented() {
    let told = parse(&text(&outcome(msd(folder().path(), &["run", "cube", "--json"])).stdout));
    let page = include_str!("../../../../docs/reference/command-line.md");
    let table = page.split("## The JSON report").nth(1).expect("a table");
    for key in told.as_object().expect("an object").keys() {
        let is_named = |row: &str| row.split(" | ").next().unwrap().contains(&format!("`{key}`"));
        assert!(table.lines().any(is_named), "{key}");
    }
}

const FLOOR: &str = "[[world.planes]]\nnormal = [0, 1, 0]\noffset = 0\n";
const STILL: &str = "[world]\ngravity = [0, 0, 0]\n";
const ROPE: &str = "[[bodies]]\nkind = \"rope\"\ndamping = 0\n";
const HUNG: &str = "[[pins]]\nbody = 0\nparticle = 0\n";

/// Returns a scene for each kind of finding, in which `msd run` and the window find it, with the
/// number of steps until then.
fn cases() -> Vec<(&'static str, u32, String)> {
    let solver = |keys: &str| format!("version = 1\n[solver]\n{keys}\n");
    let sheet = "[[bodies]]\nkind = \"cloth\"\nsize = [3, 3]\ntouch = {}\n";
    let across = "position = [0.3, 0, 0.2]\nrotation = { axis = [1, 0, 0], angle_deg = 90 }\n";
    let held = "[[pins]]\nbody = 0\nset = \"all\"\n[[pins]]\nbody = 1\nset = \"all\"\n";
    let bounce = "restitution = 0.8\n[[bodies]]\nkind = \"cloth\"\nsize = [10, 10]\n\
                  spacing = 0.1\nmass = 0.01\nposition = [0, 1, 0]\nvelocity = [1, -5, 0]\n\
                  spin = [3, 0, 2]\nstiffness = 100\ndamping = 0\n";
    let press = "[[world.solids]]\nkind = \"box\"\nsize = [4, 1, 4]\nposition = [0, 1, 0]\n\
                 velocity = [0, -1, 0]\n[[bodies]]\nkind = \"block\"\nsize = [3, 3, 3]\n\
                 spacing = 0.1\nstiffness = 100\nposition = [0, 0.2, 0]\n";
    let shot = "[[world.solids]]\nkind = \"sphere\"\nradius = 0.1\nposition = [0, 0, -1]\n\
                velocity = [0, 0, 30]\n[[bodies]]\nkind = \"cloth\"\nsize = [21, 21]\n\
                spacing = 0.05\nmass = 0.002\nstiffness = 60\ndamping = 0.02\n[[pins]]\n\
                set = \"top\"\n";
    let far = "[[bodies]]\nkind = \"block\"\nsize = [3, 3, 3]\nspacing = 0.5\n\
               stiffness = 1000\nposition = [1e5, 0, 0]\n";
    let pressed = include_str!("../../../msd-run/tests/scenes/pressed.toml");
    let by = |method: &str| solver(&format!("integrator = \"{method}\"\nsubsteps = 1"));
    vec![
        (
            "stability-limit",
            3,
            by("velocity-verlet") + STILL + ROPE + "size = [2]\nstiffness = 1e6\n",
        ),
        (
            "energy-added",
            180,
            by("explicit-euler") + STILL + ROPE + "size = [2]\nstiffness = 50\nspin = [0, 0, 1]\n",
        ),
        (
            "energy-risen",
            90,
            by("explicit-euler") + STILL + ROPE + "size = [2]\nstiffness = 50\nspin = [0, 0, 1]\n",
        ),
        ("energy-lost", 180, "version = 1\n".to_owned() + FLOOR + bounce),
        (
            "damped",
            60,
            by("backward-euler")
                + STILL
                + ROPE
                + "size = [12]\nspin = [0, 0, 20]\nstiffness = 1e4\n",
        ),
        ("too-soft", 60, by("xpbd") + ROPE + "size = [12]\nstiffness = 1e5\n" + HUNG),
        ("squeezed", 90, "version = 1\n".to_owned() + FLOOR + press),
        ("inside-out", 90, "version = 1\n".to_owned() + FLOOR + press),
        (
            "poor-solves",
            30,
            by("implicit-midpoint") + ROPE + "size = [60]\nstiffness = 1e12\n" + HUNG,
        ),
        ("went-through", 30, pressed.to_owned()),
        ("possible-crossings", 30, pressed.to_owned()),
        ("crossing-triangles", 30, format!("version = 1\n{STILL}{sheet}{sheet}{across}{held}")),
        ("pierced", 18, solver("substeps = 128") + shot),
        ("lost-digits", 6, solver("precision = \"f32\"") + far),
    ]
}

#[test]
fn a_finding_of_each_kind_has_the_same_sentence_in_msd_run_and_in_the_window() {
    for (kind, steps, scene) in cases() {
        let folder = folder();
        let path = folder.path().join("case.toml");
        std::fs::write(&path, scene).expect("a file");
        let duration = f64::from(steps) / 60.0;
        let run = ["run", "case.toml", "--json", "--duration", &duration.to_string()];
        let output = outcome(msd(folder.path(), &run));
        let told = parse(&text(&output.stdout));
        let named = told["findings"].as_array().expect("a list").iter();
        let named = named.filter(|found| found["kind"] == kind);
        let by_run: Vec<&str> = named.map(|found| found["sentence"].as_str().unwrap()).collect();
        assert!(!by_run.is_empty(), "{kind}: {told}");
        for sentence in &by_run {
            assert!(text(&output.stderr).contains(sentence), "{kind}: {sentence}");
        }
        let loaded = msd_scene::open(&path).expect("a scene");
        let mut session = Session::new(loaded).expect("a valid scene");
        session.advance(0.0, &|| 0.0);
        while session.runner().steps() < u64::from(steps) {
            session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        }
        // Cells are counted twice a second.
        session.toggle_pause();
        session.advance(0.5, &|| 0.0);
        let found = session.findings();
        let is_named = |found: &&Finding| serde_json::to_value(found).unwrap()["kind"] == kind;
        let in_window: Vec<String> = found.iter().filter(is_named).map(Finding::sentence).collect();
        assert_eq!(in_window, by_run, "{kind}");
    }
}
