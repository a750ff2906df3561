//! Shared by the tests of the command line: the real program, run as a person would.
#![allow(dead_code)] // each test binary uses its own part of this file

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// The program in a folder, which logs nothing. Without a folder of the session graphics drivers
/// have something to complain about on the standard error.
pub fn msd(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msd"));
    command.current_dir(folder).args(arguments);
    command.env_remove("RUST_LOG").env_remove("XDG_RUNTIME_DIR");
    // What the user of this machine prefers is nothing to a test.
    command.env("MSD_PREFERENCES", "");
    command
}

/// Runs the program to its end.
pub fn outcome(mut command: Command) -> Output {
    command.output().expect("msd starts")
}

/// What a run says that must succeed, with whatever notes on the standard error.
pub fn done(command: Command) -> String {
    let what = format!("{command:?}");
    let output = outcome(command);
    assert_eq!(output.status.code(), Some(0), "{what}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// What a run says that must succeed without a word on the standard error.
pub fn quiet(command: Command) -> String {
    let what = format!("{command:?}");
    let output = outcome(command);
    assert_eq!(text(&output.stderr), "", "{what}");
    assert_eq!(output.status.code(), Some(0), "{what}");
    text(&output.stdout)
}

/// What a run reports as JSON that must succeed without a word on the standard error.
pub fn json(mut command: Command) -> Value {
    command.arg("--json");
    parse(&quiet(command))
}

/// The one line in which a run is refused, which must end with this exit code and say no more.
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

/// The names of what is in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = folder.read_dir().expect("a folder").flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
