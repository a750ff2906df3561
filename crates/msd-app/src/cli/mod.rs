//! The command line: commands, their arguments and their output.

mod failure;
mod steps;
mod arguments;
mod places;
mod device;
mod run;
mod export;
#[cfg(feature = "window")]
mod view;
#[cfg(feature = "window")]
mod render;
mod study;
mod tune;
mod tune_mesh;
mod sweep;
mod bench;
mod inspect;
mod lists;
mod shell;

pub use arguments::{Arguments, explain};
pub use failure::exit_code;

use arguments::CliCommand;
use failure::Failure;
#[cfg(not(feature = "window"))]
use windowless::{render, view};
#[cfg(feature = "window")]
use {render::render, view::view};

/// Errors of `msd view` and `msd render` in a build without the window.
#[cfg(not(feature = "window"))]
mod windowless {
    use super::{Failure, arguments};

    pub fn view(_: arguments::ViewArguments) -> Result<(), Failure> {
        refuse("has no window")
    }

    pub fn render(_: &arguments::RenderArguments) -> Result<(), Failure> {
        refuse("cannot render")
    }

    fn refuse(what: &str) -> Result<(), Failure> {
        Err(Failure::input(format!("this build of msd {what}: build it with the default features")))
    }
}

/// Limits the memory of a scene to `asked`, GB, or to nine tenths of the free memory: pictures,
/// which are not counted, take some too.
fn allow_memory(asked: Option<f64>) {
    let limit = asked.map(|gigabytes| 1e9 * gigabytes).or_else(|| Some(0.9 * free_memory()?));
    if let Some(bytes) = limit {
        msd_scene::limit_memory(bytes as u64);
    }
}

/// Returns the memory available to this process, bytes, if the system reports it.
fn free_memory() -> Option<f64> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    let own = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
    Some(own.min(system.available_memory()) as f64).filter(|&free| 0.0 < free)
}

/// Runs the command in the arguments.
pub fn run_command(arguments: Arguments) -> Result<(), Failure> {
    allow_memory(arguments.memory);
    // These commands measure costs, or run many scenes at once: each on one thread.
    use CliCommand::{Study, Sweep, Tune};
    if let Some(Study(_) | Tune(_) | Sweep(_)) = arguments.command {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
        alone.map_err(|error| Failure::input(format!("cannot create a thread: {error}")))?;
    }
    match arguments.command {
        Some(CliCommand::View(arguments)) => view(arguments),
        None => view(arguments.view),
        Some(CliCommand::Scenes(arguments)) => lists::list_scenes(&arguments),
        Some(CliCommand::Lessons(arguments)) => lists::run_lessons(&arguments),
        Some(CliCommand::Methods(arguments)) => lists::list_methods(&arguments),
        Some(CliCommand::Devices(arguments)) => device::run_devices(&arguments),
        Some(CliCommand::Schema) => lists::print_schema(),
        Some(CliCommand::Run(arguments)) => match &arguments.replay {
            Some(recording) => run::replay(&arguments, recording),
            None => run::run(&arguments),
        },
        Some(CliCommand::Render(arguments)) => render(&arguments),
        Some(CliCommand::Export(arguments)) => export::run_export(&arguments),
        Some(CliCommand::Inspect(arguments)) => inspect::run_inspect(&arguments),
        Some(CliCommand::Study(arguments)) => study::run_study(&arguments),
        Some(CliCommand::Tune(arguments)) => match arguments.max_error.filter(|_| arguments.mesh) {
            Some(max_error) => tune_mesh::run_tune_mesh(&arguments, max_error),
            None => tune::run_tune(&arguments),
        },
        Some(CliCommand::Sweep(arguments)) => sweep::run_sweep(&arguments),
        Some(CliCommand::Bench(arguments)) => bench::run_bench(&arguments),
        Some(CliCommand::Completions(arguments)) => shell::print_completions(&arguments),
        Some(CliCommand::Manual(arguments)) => shell::write_manual(&arguments),
    }
}
