//! The commands of the documentation pages, run in order, each page in its own folder. Commands
//! that would take minutes get less work.

use crate::common::{folder, msd, outcome, text};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the code blocks of a page, each with its language.
fn blocks(page: &str) -> Vec<(String, String)> {
    let text = fs::read_to_string(root().join(page)).expect(page);
    let parts = text.split("\n```").skip(1).step_by(2);
    let blocks = parts.filter_map(|part| part.split_once('\n'));
    blocks.map(|(language, code)| (language.to_owned(), format!("{code}\n"))).collect()
}

/// Returns the commands of a block, without comments and without `export` lines.
fn commands(block: &str) -> Vec<&str> {
    let lines = block.lines().map(|line| line.split(" #").next().unwrap_or("").trim());
    lines.filter(|line| !line.is_empty() && !line.starts_with("export ")).collect()
}

/// Splits a line into words; none here has quotes.
fn words(line: &str) -> Vec<&str> {
    assert!(!line.contains(['"', '\'']), "{line}: a word in quotes");
    line.split_whitespace().collect()
}

/// Returns additional arguments of a command, so that it ends soon.
fn shorter(arguments: &[&str]) -> &'static [&'static str] {
    match arguments {
        ["study", .., "--terms"] => &["--duration", "0.05"],
        ["study", ..] => &["--duration", "0.05", "--time", "1"],
        ["tune", .., "--mesh"] => &["--duration", "0.05", "--time", "1"],
        ["tune", ..] => &["--duration", "0.05"],
        ["sweep", .., "--list"] => &[],
        ["sweep", ..] => &["--list"],
        // The pages set no size for films; the picture of the README is cheap.
        ["render", .., "--out", out] if !out.ends_with(".png") || out.contains('%') => {
            &["--size", "64x36"]
        }
        _ => &[],
    }
}

/// Runs the commands of a page, and writes the files shown with their name in the first line;
/// returns the number of msd commands.
fn paste(page: &str) -> usize {
    let folder = folder();
    let mut count = 0;
    for (language, block) in blocks(page) {
        let name = block.lines().next().and_then(|line| line.strip_prefix("# "));
        match (&*language, name) {
            ("sh", _) => count += run_all(page, folder.path(), &commands(&block)),
            ("toml", Some(name)) => fs::write(folder.path().join(name), &block).expect(name),
            _ => {}
        }
    }
    count
}

/// Runs commands in a folder; returns the number of msd commands.
fn run_all(page: &str, folder: &Path, lines: &[&str]) -> usize {
    let mut count = 0;
    for line in lines {
        let arguments = match &words(line)[..] {
            ["msd", arguments @ ..] => arguments.to_vec(),
            ["cargo", "run", "--release", "--", arguments @ ..] => arguments.to_vec(),
            ["cp", from, to] => {
                let to = folder.join(to);
                let to = if to.is_dir() {
                    to.join(Path::new(from).file_name().expect(from))
                } else {
                    to
                };
                fs::copy(root().join(from), to).expect(from);
                continue;
            }
            // Builds, tests, and internal QA tools.
            ["cargo", "build" | "test", ..] | ["cargo", "run", ..] => continue,
            _ => panic!("{page}: {line}: a test of this page knows no such command"),
        };
        count += 1;
        let all = [&arguments[..], shorter(&arguments)].concat();
        let mut command = msd(folder, &all);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env("MSD_CACHE", "");
        let output = outcome(command);
        let said = text(&output.stderr);
        if arguments[0] == "view" {
            // Without a display, only the parsing of the command can be tested.
            assert!(said.contains("display"), "{page}: {line}: {said}");
            continue;
        }
        if !cfg!(feature = "window") && arguments[0] == "render" {
            continue;
        }
        assert_eq!(output.status.code(), Some(0), "{page}: {line}: {said}");
    }
    count
}

#[test]
fn the_commands_of_the_readme_run_in_the_order_in_which_they_stand() {
    assert!(5 < paste("README.md"));
}

#[test]
fn the_commands_of_the_command_line_run_in_the_order_in_which_they_stand() {
    assert!(10 < paste("docs/reference/command-line.md"));
}

#[test]
fn the_commands_of_the_first_tutorial_run() {
    assert!(4 < paste("docs/tutorial/first-scene.md"));
}

#[test]
fn the_commands_of_the_answers_run() {
    let folder = root().join("docs/how-to");
    let pages = fs::read_dir(folder).expect("the answers").map(|entry| entry.expect("a page"));
    let names = pages.map(|page| page.file_name().into_string().expect("a name"));
    assert!(12 < names.map(|name| paste(&format!("docs/how-to/{name}"))).sum::<usize>());
}
