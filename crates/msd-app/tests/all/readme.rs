//! The commands of README.md and docs/reference/command-line.md, pasted in their order, each page
//! in a folder of its own. What would take minutes is given less to do.

use crate::common::{folder, msd, outcome, text};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The lines of the blocks of a page that are for a shell, without their comments, and without the
/// path that it is told.
fn commands(page: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join(page)).expect(page);
    let blocks = text.split("\n```sh\n").skip(1).filter_map(|rest| rest.split("\n```").next());
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" #").next().unwrap_or(""));
    let lines = lines.map(|line| line.trim().to_owned());
    lines.filter(|line| !line.is_empty() && !line.starts_with("export ")).collect()
}

/// The words of a line; none here has quotes.
fn words(line: &str) -> Vec<&str> {
    assert!(!line.contains(['"', '\'']), "{line}: a word in quotes");
    line.split_whitespace().collect()
}

/// What a command is given besides, so that it ends soon.
fn shorter(arguments: &[&str]) -> &'static [&'static str] {
    match arguments {
        ["study", .., "--terms"] => &["--duration", "0.05"],
        ["study", ..] => &["--duration", "0.05", "--time", "1"],
        ["tune", .., "--mesh"] => &["--duration", "0.05", "--time", "1"],
        ["tune", ..] => &["--duration", "0.05"],
        ["sweep", ..] => &["--list"],
        _ => &[],
    }
}

/// Runs the commands of a page; returns how many of msd there were.
fn paste(page: &str) -> usize {
    let folder = folder();
    let mut count = 0;
    for line in commands(page) {
        let arguments = match &words(&line)[..] {
            ["msd", arguments @ ..] => arguments.to_vec(),
            ["cargo", "run", "--release", "--", arguments @ ..] => arguments.to_vec(),
            ["cp", from, to] => {
                let to = folder.path().join(to);
                let to = if to.is_dir() {
                    to.join(Path::new(from).file_name().expect(from))
                } else {
                    to
                };
                fs::copy(root().join(from), to).expect(from);
                continue;
            }
            // Builds, tests, and what checks msd itself.
            ["cargo", "build" | "test", ..] | ["cargo", "run", ..] => continue,
            _ => panic!("{page}: {line}: a test of this page knows no such command"),
        };
        count += 1;
        let all = [&arguments[..], shorter(&arguments)].concat();
        let mut command = msd(folder.path(), &all);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env("MSD_CACHE", "");
        let output = outcome(command);
        let said = text(&output.stderr);
        if arguments[0] == "view" {
            // Without a display it can only be understood.
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
