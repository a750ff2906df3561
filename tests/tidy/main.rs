//! Rules of the house for every source file: rooms, reading order, names and lengths.

mod names;
mod order;
mod pages;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Every folder that has source files.
const FOLDERS: [&str; 9] =
    ["bare", "crates", "src", "tests", "benches", "examples", "fuzz", "web", "xtask"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of the project").flatten() {
        let path = entry.path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The crates downwards: each may name those above it.
const CRATES: [&str; 10] = [
    "crates/msd-core",
    "crates/msd-scene",
    "crates/msd-run",
    "crates/msd-study",
    "crates/msd-report",
    "crates/msd-render",
    "crates/msd-gpu",
    "crates/msd-film",
    "crates/msd-app",
    "xtask",
];

#[test]
fn a_crate_names_only_crates_above_it() {
    let name = |krate: &str| krate.rsplit('/').next().unwrap_or(krate).replace('-', "_");
    for (place, krate) in CRATES.into_iter().enumerate() {
        for file in sources(&root().join(krate).join("src")) {
            let text = fs::read_to_string(&file).expect("a source file");
            for below in CRATES.into_iter().skip(place + 1).map(name) {
                let named = text.lines().any(|line| {
                    let code = line.split("//").next().unwrap_or("");
                    code.contains(&format!("{below}::"))
                });
                // The program of a package names its own library.
                assert!(!named || below == name(krate), "{} names {below}", file.display());
            }
        }
    }
}

#[test]
fn the_core_knows_no_clock_window_gpu_file_or_thread() {
    for file in sources(&root().join("crates/msd-core/src")) {
        let text = fs::read_to_string(&file).expect("a source file");
        let words =
            ["Instant", "wgpu", "winit", "egui", "rand", "mul_add(", "std::", "std::thread"];
        for word in words {
            let named = text.lines().any(|line| {
                let code = line.split("//").next().unwrap_or("");
                code.contains(word)
            });
            assert!(!named, "{} names {word}", file.display());
        }
    }
}

#[test]
fn one_module_alone_allows_unsafe_code() {
    // For one instruction, a prefetch.
    let gather = root().join("crates/msd-core/src/elements/springs/gather.rs");
    for folder in ["crates", "src", "tests", "benches", "examples", "fuzz", "xtask"] {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).expect("a source file");
            let allows = text.lines().any(|line| {
                line.trim_start().starts_with("#")
                    && line.contains("(unsafe_code)")
                    && !line.contains("deny(")
                    && !line.contains("forbid(")
            });
            assert!(!allows || file == gather, "{} allows unsafe code", file.display());
        }
    }
}

/// Functions whose last bit differs from platform to platform; `libm` has the same everywhere.
const INEXACT: &str = "sin cos tan sin_cos asin acos atan atan2 sinh cosh tanh exp exp2 exp_m1 ln \
    ln_1p log log2 log10 powf powi cbrt hypot mul_add angle_between from_axis_angle";

#[test]
fn the_way_from_a_scene_file_to_a_state_takes_no_function_of_the_platform() {
    let crates =
        ["msd-core", "msd-scene", "msd-run"].map(|krate| root().join("crates").join(krate));
    for file in crates.iter().flat_map(|krate| sources(&krate.join("src"))) {
        let text = fs::read_to_string(&file).expect("a source file");
        let code = text.split("#[cfg(test)]").next().unwrap_or("");
        for (row, line) in code.lines().enumerate() {
            let line = line.split("//").next().unwrap_or("");
            let named = INEXACT.split(' ').find(|name| {
                [".", "f32::", "f64::"].iter().any(|of| line.contains(&format!("{of}{name}(")))
            });
            assert_eq!(named, None, "{}:{}", file.display(), row + 1);
        }
    }
}

#[test]
fn only_the_app_names_a_window_and_the_renderer_never_names_a_system() {
    let libraries = CRATES.iter().filter(|krate| !krate.ends_with("msd-app"));
    for krate in libraries {
        for file in sources(&root().join(krate).join("src")) {
            let text = fs::read_to_string(&file).expect("a source file");
            for word in ["winit", "egui"] {
                assert!(!text.contains(&format!("{word}::")), "{} uses {word}", file.display());
            }
            let system = ["Simulation", "Model", "State", "msd_core::system"].iter().any(|word| {
                text.lines().any(|line| line.starts_with("use") && line.contains(word))
            });
            assert!(
                !krate.ends_with("msd-render") || !system,
                "{} sees the system",
                file.display()
            );
        }
    }
}

/// How many packages a package is made of, with itself, on Linux.
fn packages(options: &str) -> usize {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let tree = "tree --locked -e normal,build --prefix none \
                --target x86_64-unknown-linux-gnu";
    let arguments = tree.split_whitespace().chain(options.split_whitespace());
    let output = Command::new(cargo).args(arguments).current_dir(root()).output();
    let output = output.expect("cargo is there");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names");
    let first_two = |line: &str| line.split(' ').take(2).map(str::to_owned).collect::<Vec<_>>();
    text.lines().map(first_two).collect::<BTreeSet<_>>().len()
}

#[test]
fn the_pages_say_how_many_packages_there_are() {
    let [core, facade, render, line, window, heard] = [
        "-p msd-core",
        "-p msd-springs",
        "-p msd-springs --features render",
        "-p msd-app --no-default-features",
        "-p msd-app",
        "-p msd-app --features accessibility",
    ]
    .map(packages);
    for (page, sentences) in [
        (
            "README.md",
            [
                format!("has {core} packages, itself included"),
                format!("studies ({facade} packages)"),
                format!("`msd::render` ({render} packages in total)"),
            ],
        ),
        (
            "ARCHITECTURE.md",
            [
                format!("({facade} packages without it, {render} with it)"),
                format!("--no-default-features` builds {line} packages instead of {window}"),
                format!("It adds {} packages on Linux", heard - window),
            ],
        ),
    ] {
        let text = fs::read_to_string(root().join(page)).expect("a page");
        for sentence in sentences {
            assert!(text.contains(&sentence), "{page} should say: {sentence}");
        }
    }
}

#[test]
fn cargo_run_runs_one_program() {
    let manifests = CRATES.iter().map(|krate| root().join(krate).join("Cargo.toml"));
    let runs = |manifest: std::path::PathBuf| {
        let text = fs::read_to_string(manifest).expect("a manifest");
        text.lines().filter(|line| line.starts_with("default-run")).map(str::to_owned).collect()
    };
    let runs: Vec<Vec<String>> = manifests.map(runs).collect();
    // With none, or with two, `cargo run` asks which of the programs is meant.
    assert_eq!(runs.concat(), ["default-run = \"msd\""]);
}

#[test]
fn files_and_lines_are_short() {
    for folder in FOLDERS {
        for file in sources(&root().join(folder)) {
            let text = fs::read_to_string(&file).expect("a source file");
            let count = text.lines().count();
            let limit = if folder == "examples" { 60 } else { 600 };
            // Tests are lists of facts and may be longer than code.
            let limit =
                if file.components().any(|part| part.as_os_str() == "tests") { 600 } else { limit };
            assert!(count <= limit, "{} has {count} lines of {limit}", file.display());
            for (row, line) in text.lines().enumerate() {
                let width = line.chars().count();
                assert!(width <= 100, "{}:{} is {width} wide", file.display(), row + 1);
            }
        }
    }
}
