//! Failures of commands, their messages and exit codes, and output to the terminal.

use serde::Serialize;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of bad input or usage, and of a file that could not be written.
const BAD_INPUT: u8 = 2;
/// Exit code of a run that diverged.
const DIVERGED: u8 = 3;
/// Exit code of a command that the user interrupted: 128 and the number of the signal.
pub(super) const INTERRUPTED: u8 = 130;

/// Whether only errors are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Reason why a command ended early.
#[derive(Debug, PartialEq, Eq)]
pub struct Failure {
    /// Message, one line per problem, but two for a window that cannot open.
    pub message: String,
    /// The exit code.
    pub code: u8,
}

impl Failure {
    /// Returns a failure by bad input or usage, or by a file that could not be written.
    pub fn input(message: impl Display) -> Self {
        Failure { message: message.to_string(), code: BAD_INPUT }
    }

    /// Returns the failure of a run that diverged.
    pub fn diverged(message: impl Display) -> Self {
        Failure { message: message.to_string(), code: DIVERGED }
    }

    /// Returns the failure of a run that the user interrupted.
    pub fn interrupted(message: impl Display) -> Self {
        Failure { message: message.to_string(), code: INTERRUPTED }
    }

    /// Returns whether the user interrupted the command.
    pub fn is_interruption(&self) -> bool {
        self.code == INTERRUPTED
    }

    /// Combines several failures, if there are any. The code of a missing file has precedence over
    /// that of a divergence, which implies that all files exist.
    pub fn all(failures: impl IntoIterator<Item = Failure>) -> Result<(), Failure> {
        let failures: Vec<Failure> = failures.into_iter().collect();
        let Some(code) = failures.iter().map(|failure| failure.code).min() else { return Ok(()) };
        let messages: Vec<String> = failures.into_iter().map(|failure| failure.message).collect();
        Err(Failure { message: messages.join("\nerror: "), code })
    }
}

/// Returns the exit code of a command, and prints the message of a failure on standard error.
pub fn exit_code(done: Result<(), Failure>) -> ExitCode {
    let Err(failure) = done else { return ExitCode::SUCCESS };
    tell(&format!("error: {}", failure.message));
    ExitCode::from(failure.code)
}

/// Prints a line on standard error.
pub fn tell(line: &str) {
    // `eprintln!` would panic if standard error is closed.
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints a line on standard error, such as a warning or an activity, unless `--quiet` hides it.
pub fn note(line: &str) {
    if !QUIET.load(Ordering::Relaxed) {
        tell(line);
    }
}

/// Hides everything but errors, if `quiet`.
pub fn hush(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Returns whether only errors are printed.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a line on standard output; a reader that has exited, as in `| head`, is not an error.
pub fn say(line: &str) -> Result<(), Failure> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("the standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a value as JSON.
pub fn say_json(value: &(impl Serialize + ?Sized)) -> Result<(), Failure> {
    say(&serde_json::to_string_pretty(value).map_err(Failure::input)?)
}

/// Aligns a table: each column is as wide as its longest text, columns in `right` flush right.
pub fn aligned<const N: usize>(rows: &[[String; N]], right: &[usize]) -> Vec<String> {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; N] = std::array::from_fn(|column| width(column).unwrap_or(0));
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).enumerate().map(|(column, (text, width))| {
            if right.contains(&column) {
                format!("{text:>width$}")
            } else {
                format!("{text:<width$}")
            }
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_begin_at_one_place_however_long_a_text_is() {
        let rows =
            [["a", "1 µs", "b"], ["trampoline", "12 ms", ""]].map(|row| row.map(String::from));
        let lines = aligned(&rows, &[1]);
        assert_eq!(lines, ["a            1 µs  b", "trampoline  12 ms"]);
    }
}
