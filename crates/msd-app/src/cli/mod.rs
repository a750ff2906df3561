//! What does the command line do? Reads the arguments, calls a command, tells what went wrong.

mod failure;
mod values;
mod arguments;
mod places;
mod progress;
mod prepare;
mod report;
mod watch;
mod files;
mod run;
mod replay;
mod render;
mod study;
mod tune;
mod sweep;
mod bench;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::{Failure, say};
use msd_scene::shown_path;
use places::Places;
use std::path::PathBuf;
use std::process::ExitCode;

/// The scene of the window that nobody chose.
const DEFAULT_SCENE: &str = "jelly";

/// Runs the program and returns its exit code: 0 done, 2 bad input or usage or a file that could
/// not be written, 3 diverged. The window ends with 1 where its display goes away: the library of
/// X11 says so and ends the program.
pub fn run_program() -> ExitCode {
    // Silent unless asked: one clear line is the whole message of an error.
    let environment = env_logger::Env::default().default_filter_or("off");
    env_logger::Builder::from_env(environment).init();
    let done = match Arguments::try_parse() {
        Ok(arguments) => run_command(arguments),
        Err(error) => {
            // `args` panics on what is no Unicode; a file may have any name.
            let first = std::env::args_os().nth(1);
            let first = first.map(|first| first.to_string_lossy().into_owned());
            arguments::explain(&error, first)
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.tell();
            ExitCode::from(failure.code)
        }
    }
}

fn run_command(arguments: Arguments) -> Result<(), Failure> {
    // These tell what a setting costs, or run many things at once: each on one thread.
    use Command::{Study, Sweep, Tune};
    if let Some(Study(_) | Tune(_) | Sweep(_)) = arguments.command {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
        alone.map_err(|error| Failure::input(format!("no thread to run on: {error}")))?;
    }
    match arguments.command {
        Some(Command::View { scene }) => view(scene),
        None => view(arguments.scene),
        Some(Command::Scenes) => list_scenes(),
        Some(Command::Run(arguments)) => match &arguments.replay {
            Some(recording) => replay::replay(&arguments, recording),
            None => run::run(&arguments),
        },
        Some(Command::Render(arguments)) => render::render(&arguments),
        Some(Command::Study(arguments)) => study::run_study(&arguments),
        Some(Command::Tune(arguments)) => tune::run_tune(&arguments),
        Some(Command::Sweep(arguments)) => sweep::run_sweep(&arguments),
        Some(Command::Bench(arguments)) => bench::run_bench(&arguments),
    }
}

fn view(scene: Option<PathBuf>) -> Result<(), Failure> {
    let scene = scene.unwrap_or_else(|| DEFAULT_SCENE.into());
    let loaded = prepare::open(&scene)?;
    let mut places = Places::default();
    loaded.files.iter().for_each(|file| places.read("SCENE", file));
    let status = std::env::var_os("MSD_STATUS").map(PathBuf::from);
    status.iter().try_for_each(|status| places.write("MSD_STATUS", status))?;
    msd_app::view_as(loaded, &shown_path(&scene)).map_err(Failure::input)
}

fn list_scenes() -> Result<(), Failure> {
    let line = |builtin: &msd_scene::Builtin| format!("{:<9} {}", builtin.name, builtin.title);
    let lines: Vec<String> = msd_scene::BUILTINS.iter().map(line).collect();
    say(&lines.join("\n"))
}
