//! The command line: commands, their arguments, and what they print.

mod failure;
mod arguments;
mod places;
mod progress;
mod run;
mod render;
mod study;
mod tune;
mod tune_mesh;
mod sweep;
mod bench;
mod inspect;

pub use arguments::{Arguments, explain};
pub use failure::exit_code;

use arguments::{CliCommand, SolverArguments, Step, ViewArguments};
use failure::{Failure, say};
use msd_scene::shown_path;
use places::Places;
use std::path::PathBuf;

/// Runs the command that was asked for.
pub fn run_command(arguments: Arguments) -> Result<(), Failure> {
    // These measure what a setting costs, or run many things at once: each on one thread.
    use CliCommand::{Study, Sweep, Tune};
    if let Some(Study(_) | Tune(_) | Sweep(_)) = arguments.command {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
        alone.map_err(|error| Failure::input(format!("no thread to run on: {error}")))?;
    }
    match arguments.command {
        Some(CliCommand::View(arguments)) => view(arguments),
        None => view(arguments.view),
        Some(CliCommand::Scenes) => list_scenes(),
        Some(CliCommand::Run(arguments)) => match &arguments.replay {
            Some(recording) => run::replay(&arguments, recording),
            None => run::run(&arguments),
        },
        Some(CliCommand::Render(arguments)) => render::render(&arguments),
        Some(CliCommand::Inspect(arguments)) => inspect::run_inspect(&arguments),
        Some(CliCommand::Study(arguments)) => study::run_study(&arguments),
        Some(CliCommand::Tune(arguments)) => match arguments.max_error.filter(|_| arguments.mesh) {
            Some(max_error) => tune_mesh::run_tune_mesh(&arguments, max_error),
            None => tune::run_tune(&arguments),
        },
        Some(CliCommand::Sweep(arguments)) => sweep::run_sweep(&arguments),
        Some(CliCommand::Bench(arguments)) => bench::run_bench(&arguments),
    }
}

fn view(ViewArguments { scene, solver }: ViewArguments) -> Result<(), Failure> {
    let scene = scene.unwrap_or_else(|| {
        // The file may be gone by now.
        let last = msd_app::last_scene().filter(|last| msd_scene::open(last).is_ok());
        last.unwrap_or(msd_scene::BUILTINS[0].name.into()).into()
    });
    if let Some(link) = run::link(&scene)?
        && solver == SolverArguments::default()
    {
        return msd_app::view_link(&link).map_err(Failure::window);
    }
    let loaded = if solver == SolverArguments::default() {
        msd_scene::open(&scene).map_err(Failure::input)?
    } else {
        let frame = if solver.step == Some(Step::Auto) { run::FRAME } else { 0.0 };
        run::prepare(&scene, &solver, ("--step", frame))?.into_loaded()
    };
    let mut places = Places::default();
    loaded.files.iter().for_each(|file| places.read("SCENE", file));
    solver.from.iter().for_each(|state| places.read("--from", state));
    let status = std::env::var_os("MSD_STATUS").map(PathBuf::from);
    status.iter().try_for_each(|status| places.write("MSD_STATUS", status))?;
    msd_app::view_as(loaded, &shown_path(&scene)).map_err(Failure::window)
}

fn list_scenes() -> Result<(), Failure> {
    let line = |builtin: &msd_scene::Builtin| format!("{:<9} {}", builtin.name, builtin.title);
    let lines: Vec<String> = msd_scene::BUILTINS.iter().map(line).collect();
    say(&lines.join("\n"))
}
