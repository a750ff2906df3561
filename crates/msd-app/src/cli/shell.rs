//! `msd completions` and `msd manual`: the command line for shells and for `man`.

use super::arguments::{Arguments, CompletionsArguments, ManualArguments};
use super::failure::{Failure, say};
use super::places::make_folder;
use clap::{Command, CommandFactory};
use msd_scene::{shown_path, write_file};

/// Prints the completions for a shell.
pub fn print_completions(arguments: &CompletionsArguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "msd", &mut script);
    say(String::from_utf8_lossy(&script).trim_end())
}

/// Writes a page for the program and one for each command.
pub fn write_manual(arguments: &ManualArguments) -> Result<(), Failure> {
    let ManualArguments { folder } = arguments;
    make_folder(folder)?;
    let mut program = Arguments::command().disable_help_subcommand(true);
    // Builds names such as `msd-run`, by which `man` finds the pages.
    program.build();
    let commands: Vec<Command> = program.get_subcommands().cloned().collect();
    let mut count = 0;
    for command in [program].into_iter().chain(commands) {
        let manual = clap_mangen::Man::new(command);
        let mut page = Vec::new();
        manual.render(&mut page).map_err(Failure::input)?;
        write_file(&folder.join(manual.get_filename()), &page).map_err(Failure::input)?;
        count += 1;
    }
    say(&format!("{count} pages in {}", shown_path(folder)))
}
