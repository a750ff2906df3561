//! Does `msd extremes` do what the README says, and is energy that an integrator adds told?

mod common;

use common::{folder, msd, outcome, parse, refused, text};
use serde_json::Value;

#[test]
fn a_quick_look_at_the_extremes_finds_no_failure_and_fills_a_page() {
    let folder = folder();
    let marks = ["cells", "hardships", "distances"]
        .map(|name| format!("<!-- begin {name} -->\nold\n<!-- end {name} -->\n"));
    let page = folder.path().join("page.md");
    std::fs::write(&page, format!("# Mine\n{}", marks.concat())).unwrap();
    let arguments = ["extremes", "--quick", "--json", "--jobs", "2", "--page", "page.md"];
    let output = outcome(msd(folder.path(), &arguments));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let told = parse(&text(&output.stdout));
    assert_eq!(told["failures"].as_array().map(Vec::len), Some(0));
    assert_eq!(told["cells"].as_object().map(|methods| methods.len()), Some(8));
    assert!(5000 < told["runs"].as_u64().unwrap());
    let file = |name: &str| std::fs::read_to_string(folder.path().join("extremes").join(name));
    assert!(file("rk4.svg").unwrap().starts_with("<svg"));
    assert!(file("maps.csv").unwrap().lines().count() > 5000);
    assert!(file("tables.md").unwrap().contains("| scattered |"));
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.starts_with("# Mine\n") && page.contains("| scattered |"), "{page}");
    assert!(!page.contains("\nold\n"));
}

#[test]
fn a_page_without_marks_is_refused_before_anything_runs() {
    let folder = folder();
    std::fs::write(folder.path().join("page.md"), "# Mine\n").unwrap();
    let told = refused(msd(folder.path(), &["extremes", "--page", "page.md"]), 2);
    assert!(told.contains("page.md") && told.contains("begin cells"), "{told}");
}

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
