//! Help, and one-line explanations of mistakes on the command line.

use super::Arguments;
use crate::cli::failure::{Failure, say};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};
use msd_scene::keys::Form;
use msd_scene::schema::{SceneFile, find};
use msd_scene::{nearest, tame};

/// Prints the requested help, or a line on the mistake in the arguments.
pub fn explain(error: &clap::Error) -> Result<(), Failure> {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return say(error.to_string().trim_end());
    }
    let program = Arguments::command();
    // `args` panics on text that is not Unicode; a file may have any name.
    let first = std::env::args_os().nth(1).unwrap_or_default();
    let first = first.to_string_lossy();
    let command = program.get_subcommands().find(|command| command.get_name() == first);
    // clap takes a misspelt command for SCENE, and the next argument for a superfluous one.
    let too_much = matches!(error.kind(), ErrorKind::UnknownArgument | ErrorKind::ArgumentConflict);
    let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
    let mistaken = too_much && command.is_none() && !first.starts_with('-');
    let meant = nearest(&first, names.iter().copied()).filter(|_| mistaken);
    let message = if let Some(near) = meant {
        format!("there is no command `{first}`; did you mean `{near}`?")
    } else if let Some(message) = unknown_option(error, command, &program) {
        message
    } else if mistaken {
        format!("there is no command `{first}`; there are {}", names.join(", "))
    } else {
        in_one_line(error)
    };
    Err(Failure::input(format!("{}; see msd --help", tame(&message))))
}

/// Suggests a replacement for an unknown option of a command or the window; `None` for another
/// mistake.
fn unknown_option(
    error: &clap::Error,
    command: Option<&Command>,
    program: &Command,
) -> Option<String> {
    let Some(ContextValue::String(written)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let name = written.strip_prefix("--").filter(|_| error.kind() == ErrorKind::UnknownArgument)?;
    let key = name.replace('-', "_");
    let paths = SceneFile::TABLE.paths();
    let keys = paths.iter().filter_map(|(path, _)| path.rsplit_once('.'));
    // Of keys of one name, the one nearest to the top of the file is the likeliest.
    let known = keys.filter(|(table, last)| *last == key && table.matches('.').count() < 2);
    let known = known.min_by_key(|(table, _)| table.len());
    let options = |command: &Command| -> Vec<String> {
        command
            .get_arguments()
            .filter_map(|argument| argument.get_long().map(String::from))
            .collect()
    };
    let own = options(command.unwrap_or(program));
    let others = program.get_subcommands().filter(|other| options(other).iter().any(|o| o == name));
    let others: Vec<String> = others.map(|other| format!("msd {}", other.get_name())).collect();
    let advice = if let Some((table, key)) = known {
        let set = own.iter().any(|option| option == "set");
        let path = first_row(&format!("{table}.{key}"));
        let or = if set { format!(", or by --set {path}=VALUE") } else { String::new() };
        format!("; {key} is set in the scene file, as {table}.{key}{or}")
    } else if !others.is_empty() {
        format!("; it belongs to {}", others.join(", "))
    } else if let Some(near) = nearest(name, own.iter().map(String::as_str)) {
        format!("; did you mean --{near}?")
    } else {
        String::new()
    };
    let place = command.map_or(String::new(), |command| format!(" of msd {}", command.get_name()));
    Some(format!("there is no option {written}{place}{advice}"))
}

/// Returns a path with the first row of each list on its way: `bodies.0.mass`.
fn first_row(path: &str) -> String {
    let (mut whole, mut rows) = (String::new(), String::new());
    for name in path.split('.') {
        let dot = if whole.is_empty() { "" } else { "." };
        whole.extend([dot, name]);
        rows.extend([dot, name]);
        if let Some(Form::List(Form::Table(_), _)) = find(&whole).map(|key| key.form) {
            rows.push_str(".0");
        }
    }
    rows
}

/// Returns the message of the argument parser without usage and advice.
fn in_one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines = text.lines().take_while(|line| !line.starts_with("Usage:")).map(str::trim);
    let is_news = |line: &&str| !line.is_empty() && !line.starts_with("For more information");
    let message = lines.filter(is_news).collect::<Vec<_>>().join("; ").replace(":; ", ": ");
    message.strip_prefix("error: ").unwrap_or(&message).to_owned()
}
