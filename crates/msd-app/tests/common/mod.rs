//! Helpers of the tests of the command line: the real program, run as a user would.
#![allow(dead_code)] // each test binary uses its own part of this file

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// Returns the program in a folder, without a log. It lacks `XDG_RUNTIME_DIR`, about which graphics
/// drivers complain on standard error.
pub fn msd(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msd"));
    command.current_dir(folder).args(arguments);
    command.env_remove("RUST_LOG").env_remove("XDG_RUNTIME_DIR");
    // A test must not depend on the preferences of the user.
    command.env("MSD_PREFERENCES", "");
    command
}

/// Runs the program to its end.
pub fn outcome(mut command: Command) -> Output {
    command.output().expect("msd starts")
}

/// Returns the output of a run that must succeed, with any messages on standard error.
pub fn done(command: Command) -> String {
    let what = format!("{command:?}");
    let output = outcome(command);
    assert_eq!(output.status.code(), Some(0), "{what}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Returns the output of a run that must succeed with empty standard error.
pub fn quiet(command: Command) -> String {
    let what = format!("{command:?}");
    let output = outcome(command);
    assert_eq!(text(&output.stderr), "", "{what}");
    assert_eq!(output.status.code(), Some(0), "{what}");
    text(&output.stdout)
}

/// Returns the JSON report of a run that must succeed with empty standard error.
pub fn json(mut command: Command) -> Value {
    command.arg("--json");
    parse(&quiet(command))
}

/// Returns the only line of a refused run, which must end with this exit code.
pub fn refused(command: Command, code: i32) -> String {
    let what = format!("{command:?}");
    let output = outcome(command);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{what}: {told}");
    assert_eq!((text(&output.stdout).as_str(), told.lines().count()), ("", 1), "{what}: {told}");
    told
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

pub fn parse(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Returns the sorted names of the files in a folder.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = folder.read_dir().expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
