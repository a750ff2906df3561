//! Help, and mistakes on the command line explained in a line.

use super::Arguments;
use crate::cli::failure::{Failure, say};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};
use msd_lab::domain::DOMAINS;
use msd_lab::{nearest, tame};

/// Prints the help that was asked for, or says in one line what is wrong with the arguments.
pub fn explain(error: &clap::Error) -> Result<(), Failure> {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return say(error.to_string().trim_end());
    }
    let program = Arguments::command();
    // `args` panics on what is no Unicode; a file may have any name.
    let first = std::env::args_os().nth(1).unwrap_or_default();
    let first = first.to_string_lossy();
    let command = program.get_subcommands().find(|command| command.get_name() == first);
    // A misspelt command is taken for the scene of the window, and what follows it for too much.
    let too_much = matches!(error.kind(), ErrorKind::UnknownArgument | ErrorKind::ArgumentConflict);
    let message = if too_much && command.is_none() && !first.starts_with('-') {
        unknown_command(&first, &program)
    } else {
        let unknown = unknown_option(error, command.unwrap_or(&program));
        unknown.unwrap_or_else(|| in_one_line(error))
    };
    Err(Failure::input(format!("{}; see msd --help", tame(&message))))
}

fn unknown_command(written: &str, program: &Command) -> String {
    let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
    match nearest(written, names.iter().copied()) {
        Some(near) => format!("there is no command `{written}`; did you mean `{near}`?"),
        None => format!("there is no command `{written}`; there are {}", names.join(", ")),
    }
}

/// What to write instead of an option that there is not; `None` for another mistake.
fn unknown_option(error: &clap::Error, command: &Command) -> Option<String> {
    let Some(ContextValue::String(written)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let name = written.strip_prefix("--").filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let key = name.replace('-', "_");
    let keys = DOMAINS.iter().filter_map(|(path, _)| path.rsplit_once('.'));
    // Of keys of one name the one nearest to the top of the file.
    let known = keys.filter(|(_, last)| *last == key).min_by_key(|(table, _)| table.len());
    if let Some((table, key)) = known {
        return Some(format!(
            "there is no option {written}; `{key}` is a key of {table} in the scene file"
        ));
    }
    let options = command.get_arguments().filter_map(|argument| argument.get_long());
    Some(match nearest(name, options) {
        Some(near) => format!("there is no option {written}; did you mean --{near}?"),
        None => format!("there is no option {written}"),
    })
}

/// The message of the argument parser without usage and advice.
fn in_one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines = text.lines().take_while(|line| !line.starts_with("Usage:")).map(str::trim);
    let is_news = |line: &&str| !line.is_empty() && !line.starts_with("For more information");
    let message = lines.filter(is_news).collect::<Vec<_>>().join("; ").replace(":; ", ": ");
    message.strip_prefix("error: ").unwrap_or(&message).to_owned()
}
