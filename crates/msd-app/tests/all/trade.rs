//! `msd study` and `msd tune` as in the README: the real binary, in separate folders.

use crate::common::{done, folder, outcome, parse, refused, text};
use std::path::Path;
use std::process::Command;

fn msd(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = crate::common::msd(folder, arguments);
    command.env("MSD_CACHE", folder.join("cache"));
    command
}

const ROPE: &str = "version = 1\n[solver]\n# many\nsubsteps = 16 # sixteen\n[[bodies]]\n\
                    kind = \"rope\"\nsize = [5]\nstiffness = 100\n[[pins]]\nparticle = 0\n";

#[test]
fn a_study_writes_a_report_a_table_and_figures() {
    let folder = folder();
    let told = done(msd(folder.path(), &["study", "chain", "--duration", "0.2", "--time", "1"]));
    assert!(told.contains("per frame") && told.contains("report.html"), "{told}");
    let file = |name: &str| std::fs::read(folder.path().join("chain-study").join(name)).unwrap();
    let page = text(&file("report.html"));
    assert!(page.contains("velocity-verlet") && page.contains("</html>"));
    assert!(!page.contains("src=\"http") && !page.contains("<link"), "one file, no network");
    let table = text(&file("study.csv"));
    assert!(10 < table.lines().count());
    assert!(text(&file("work-precision.svg")).contains("<title>"));
    assert!(file("work-precision.png").starts_with(b"\x89PNG"));
    let study = parse(&text(&file("study.json")));
    assert_eq!(study["trials"].as_array().unwrap().len() + 1, table.lines().count());
}

#[test]
fn an_interrupted_study_goes_on_where_it_stopped() {
    let folder = folder();
    let arguments = ["study", "cloth", "--duration", "0.5", "--time", "20"];
    let mut child = msd(folder.path(), &arguments).spawn().expect("msd starts");
    let journal = || {
        let files = std::fs::read_dir(folder.path().join("cache"));
        files.is_ok_and(|files| {
            files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("study-"))
        })
    };
    while !journal() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(child.try_wait().unwrap().is_none(), "it ended before it could be stopped");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(journal(), "what was tried is kept");
    done(msd(folder.path(), &["study", "cloth", "--duration", "0.5", "--time", "1"]));
    assert!(!journal(), "and forgotten at the end");
}

/// Sends Ctrl-C to a command once `begun` holds, waits for its end, and returns its output.
#[cfg(unix)]
fn interrupt(folder: &Path, arguments: &[&str], begun: &dyn Fn() -> bool) -> [String; 2] {
    use std::process::Stdio;
    let mut command = msd(folder, arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("msd starts");
    while !begun() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill").args(["-INT", &id]).status();
    assert!(sent.expect("kill starts").success());
    let output = child.wait_with_output().expect("msd ends");
    let said = [output.stdout, output.stderr].map(|bytes| text(&bytes));
    assert_eq!(output.status.code(), Some(130), "{said:?}");
    said
}

/// Returns whether the cache has a file with this prefix.
#[cfg(unix)]
fn cached(folder: &Path, start: &str) -> bool {
    let files = std::fs::read_dir(folder.join("cache")).into_iter().flatten().flatten();
    files.into_iter().any(|file| file.file_name().to_string_lossy().starts_with(start))
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_study_with_a_report_of_what_was_tried() {
    let folder = folder();
    let arguments = ["study", "cloth", "--duration", "0.5", "--time", "600"];
    let [said, told] = interrupt(folder.path(), &arguments, &|| cached(folder.path(), "study-"));
    assert!(told.starts_with("error: interrupted after ") && said.contains("trials"), "{told}");
    let report = folder.path().join("cloth-study");
    let mut names: Vec<String> = std::fs::read_dir(&report)
        .expect("a report")
        .flatten()
        .map(|file| file.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let whole =
        ["report.html", "study.csv", "study.json", "work-precision.png", "work-precision.svg"];
    assert_eq!(names, whole, "whole files, and no part");
    let study = parse(&std::fs::read_to_string(report.join("study.json")).expect("a file"));
    assert!(!study["trials"].as_array().expect("trials").is_empty());
    assert!(cached(folder.path(), "study-"), "the same command resumes");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_search_with_the_best_so_far_which_is_not_written() {
    let folder = folder();
    let scene = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [9, 9, 9]\n";
    std::fs::write(folder.path().join("block.toml"), scene).expect("a file");
    let arguments = ["tune", "block.toml", "--duration", "2", "--max-error", "1e-7", "--write"];
    let [said, told] = interrupt(folder.path(), &arguments, &|| cached(folder.path(), "reference"));
    assert!(told.starts_with("error: "), "{told}");
    assert!(told.contains("interrupted"), "{told}");
    // If settings were tried by then, the report includes them.
    let is_told = said.contains("settings tried") && said.contains("not written");
    assert!(is_told || told.contains("before anything was tried"), "{said} {told}");
    let kept = std::fs::read_to_string(folder.path().join("block.toml")).expect("the scene");
    assert_eq!(kept, scene);
    let files = std::fs::read_dir(folder.path()).expect("a folder").flatten();
    assert!(files.into_iter().all(|file| !file.file_name().to_string_lossy().contains(".part")));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_search_for_a_spacing_at_once_and_leaves_no_part() {
    let folder = folder();
    let scene = "version = 1\n[[bodies]]\nkind = 'block'\nsize = [5, 5, 5]\n";
    std::fs::write(folder.path().join("block.toml"), scene).expect("a file");
    let arguments = ["tune", "block.toml", "--mesh", "--max-error", "1e-3", "--write"];
    // Finer spacings are run after the reference.
    let [said, _] = interrupt(folder.path(), &arguments, &|| cached(folder.path(), "reference"));
    assert_eq!(said, "");
    let kept = std::fs::read_to_string(folder.path().join("block.toml")).expect("the scene");
    assert_eq!(kept, scene);
    let files = std::fs::read_dir(folder.path()).expect("a folder").flatten();
    assert!(files.into_iter().all(|file| !file.file_name().to_string_lossy().contains(".part")));
}

#[test]
fn tune_prints_the_documented_keys_and_keeps_the_wish() {
    let folder = folder();
    let arguments = ["tune", "chain", "--max-error", "0.001", "--duration", "0.5", "--json"];
    let report = parse(&done(msd(folder.path(), &arguments)));
    assert_eq!(report["met"], true);
    assert!(report["verified_error"].as_f64().unwrap() <= 1e-3);
    assert!(0.0 < report["ms_per_frame"].as_f64().unwrap());
    for key in ["integrator", "precision", "predicted_error", "runner_up", "chaotic_after"] {
        assert!(report.get(key).is_some(), "{key}");
    }
    assert!(report["step"].is_number() != report["tolerance"].is_number());
    let arguments = ["tune", "chain", "--budget", "1", "--duration", "0.2", "--json"];
    let report = parse(&done(msd(folder.path(), &arguments)));
    assert!(report["ms_per_frame"].as_f64().unwrap() <= 1.0);
    // No error is below the uncertainty of its reference.
    let number = |key: &str| report[key].as_f64().unwrap();
    assert!(number("reference_uncertainty") <= number("verified_error"), "{report}");
}

#[test]
fn write_changes_the_solver_section_and_only_for_a_choice_that_meets_the_wish() {
    let folder = folder();
    let path = folder.path().join("rope.toml");
    // A file with Windows line endings, and with a second name.
    let rope = ROPE.replace('\n', "\r\n");
    std::fs::write(&path, &rope).unwrap();
    std::fs::hard_link(&path, folder.path().join("second.toml")).unwrap();
    let wish = |error: &'static str| {
        ["tune", "rope.toml", "--max-error", error, "--duration", "0.2", "--write"]
    };
    let told = done(msd(folder.path(), &wish("1e-30")));
    assert!(told.contains("not written"), "{told}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), rope);
    done(msd(folder.path(), &wish("0.01")));
    let written = std::fs::read_to_string(&path).unwrap();
    assert!(written.contains("integrator =") && written.contains("# many"), "{written}");
    assert_eq!(written.matches('\n').count(), written.matches("\r\n").count());
    let second = std::fs::read_to_string(folder.path().join("second.toml")).unwrap();
    assert!(!cfg!(unix) || second == written);
    let report = done(msd(folder.path(), &["run", "rope.toml", "--duration", "0.1", "--json"]));
    let report = parse(&report);
    assert!(written.contains(report["integrator"].as_str().unwrap()));
    let refused = outcome(msd(folder.path(), &["tune", "chain", "--max-error", "1", "--write"]));
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("scene file"));
}

#[test]
fn a_wish_is_asked_for_and_out_of_domain_refused() {
    let folder = folder();
    let wrong: [&[&str]; 5] = [
        &["tune", "chain"],
        &["tune", "chain", "--max-error", "1", "--budget", "1"],
        &["tune", "chain", "--max-error", "-1"],
        &["study", "chain", "--duration", "1e9"],
        &["run", "chain", "--tolerance", "2"],
    ];
    for arguments in wrong {
        refused(msd(folder.path(), arguments), 2);
    }
}

#[test]
fn a_scene_that_leaves_the_world_has_no_reference_and_that_is_said() {
    let folder = folder();
    let text_of = "version = 1\n[world]\nextent = 2\n[[bodies]]\nkind = \"rope\"\nsize = [3]\n";
    std::fs::write(folder.path().join("fall.toml"), text_of).unwrap();
    let refused = outcome(msd(folder.path(), &["tune", "fall.toml", "--max-error", "0.1"]));
    assert_eq!(refused.status.code(), Some(3));
    assert!(text(&refused.stderr).contains("world"), "{}", text(&refused.stderr));
}

#[test]
fn terms_are_reported() {
    let folder = folder();
    let told = done(msd(folder.path(), &["study", "square", "--terms", "--duration", "0.2"]));
    assert!(told.contains("damping") && told.contains('%'), "{told}");
}

#[test]
fn every_method_runs_every_small_scene() {
    let folder = folder();
    for integrator in msd_core::Integrator::ALL {
        for scene in ["chain", "square"] {
            let name = integrator.name();
            let arguments = ["run", scene, "--integrator", name, "--duration", "0.5", "--json"];
            let report = parse(&done(msd(folder.path(), &arguments)));
            assert_eq!(report["integrator"], name);
            assert_eq!(report["diverged"], false);
        }
    }
}

/// A bar of ten cells along x, under load from the start.
const BAR: &str = "version = 1\n[world]\ngravity = [9.82, 0, 0]\n[[bodies]]\nkind = \"rope\"\n\
                   size = [11]\nspacing = 0.1\nyoung = 1e5\ndensity = 1000\ndiameter = 0.01\n\
                   relaxation_time = 4e-3\nposition = [0.5, 0, 0]\n[[pins]]\nat = [0, 0, 0]\n";

#[test]
fn a_study_says_what_the_spacing_costs_and_a_later_one_remembers() {
    let folder = folder();
    std::fs::write(folder.path().join("bar.toml"), BAR).unwrap();
    let study = ["study", "bar.toml", "--duration", "0.5", "--time", "2"];
    let told = done(msd(folder.path(), &study));
    assert!(told.contains("the error of space is not included: --mesh measures it"), "{told}");
    let mesh: Vec<&str> = study.into_iter().chain(["--mesh"]).collect();
    let told = done(msd(folder.path(), &mesh));
    // The closed form of this bar has 230 µm.
    assert!(told.contains("refine the mesh") && told.contains("space costs you 23"), "{told}");
    assert!(told.contains("of order 2 as observed"), "{told}");
    let page = std::fs::read(folder.path().join("bar-study").join("report.html")).unwrap();
    assert!(text(&page).contains("Space, time and precision"));
    let told = done(msd(folder.path(), &study));
    assert!(told.contains("is not included; when last measured, over 500 ms, "), "{told}");
    assert!(told.contains("the error of space is 23"), "{told}");
    let json: Vec<&str> = mesh.into_iter().chain(["--json"]).collect();
    let object = parse(&done(msd(folder.path(), &json)));
    assert!(object["space"]["verdict"]["known"]["is_seen"].as_bool().unwrap());
    assert!(object["balance"]["time"]["error"].as_f64().unwrap() > 0.0);
}

#[test]
fn tuning_the_mesh_says_what_to_write_and_a_scene_without_spacing_is_refused() {
    let folder = folder();
    std::fs::write(folder.path().join("bar.toml"), BAR).unwrap();
    let tune = ["tune", "bar.toml", "--duration", "0.5", "--mesh", "--max-error"];
    let with = |error| tune.into_iter().chain([error]).collect::<Vec<&str>>();
    let told = done(msd(folder.path(), &with("1e-4")));
    assert!(told.contains("use 1/2 of the spacing"), "{told}");
    assert!(told.contains("bodies[0]: size = [21], spacing = 0.05"), "{told}");
    let told = done(msd(folder.path(), &with("1e-9")));
    assert!(told.contains("no spacing tried is certain to meet it"), "{told}");
    let write: Vec<&str> = with("1e-3").into_iter().chain(["--write", "--json"]).collect();
    let object = parse(&done(msd(folder.path(), &write)));
    assert_eq!((object["parts"].as_u64(), object["met"].as_bool()), (Some(1), Some(true)));
    assert!(object["total_error"].as_f64().unwrap() <= 1e-3);
    let written = std::fs::read_to_string(folder.path().join("bar.toml")).unwrap();
    assert!(written.contains("integrator") && written.contains("size = [11]"), "{written}");
    let budget = ["tune", "bar.toml", "--budget", "1", "--mesh"];
    let told = outcome(msd(folder.path(), &budget));
    assert_eq!(told.status.code(), Some(2));
    assert!(text(&told.stderr).contains("--mesh"), "{told:?}");
    let told = refused(msd(folder.path(), &["study", "chain", "--mesh"]), 2);
    assert!(told.contains("bodies[0] is a body `chain` of particles and springs"), "{told}");
}
