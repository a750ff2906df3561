//! The program of `cargo run --release -p xtask`: internal checks of msd.

mod command;

use clap::{Parser, Subcommand};
use command::Failure;
use std::path::PathBuf;
use std::process::ExitCode;

/// What checks msd itself and is no tool for a scene of your own.
#[derive(Debug, Parser)]
#[command(name = "xtask")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Takes every method to the extremes: maps of what is accurate, bounded or blows up
    Extremes(command::extremes::ExtremesArguments),
    /// Prints the spring updates per second of a work, f32, by the instructions of any x86-64
    Pace {
        /// The work: cloth/SIDE or block/SIDE
        work: String,
        /// How long it is measured, seconds
        #[arg(default_value_t = 2.0)]
        seconds: f64,
    },
    /// Compares the live estimate of the error with the truth, over built-in and generated scenes
    LiveError {
        /// How many scenes to generate
        #[arg(long, default_value_t = 60)]
        generated: u64,
        /// Only the scenes whose name contains this, such as `generated 7`
        #[arg(long, default_value = "")]
        only: String,
    },
    /// Compares clamped beams of a few cells across with theory: what a coarse lattice costs
    BeamTable {
        /// Put the table between the marks of this page as well, as in docs/measured/beams.md
        #[arg(long, value_name = "PAGE.md")]
        page: Option<PathBuf>,
        /// Draw the beams into this file
        #[arg(long, value_name = "FILE.svg")]
        figure: Option<PathBuf>,
        /// Print one JSON object instead of a table
        #[arg(long)]
        json: bool,
    },
    /// Measures what a picture costs, by its quality and by what is shown
    Frames {
        /// Built-in scenes, scene files, meshes or saved runs, each after a second
        #[arg(default_values = ["cloth", "jelly"])]
        scenes: Vec<PathBuf>,
        /// Size of the picture, pixels
        #[arg(long, num_args = 2, default_values = ["1280", "720"])]
        size: Vec<u32>,
    },
    /// Finds how stiff a scene may be under each method, as the report of 2014 did
    StabilityTable {
        /// A built-in scene, a scene file, a mesh or a saved run
        scene: PathBuf,
        /// Print one JSON object instead of a table
        #[arg(long)]
        json: bool,
    },
}

/// Runs a command: 0 done, 2 bad input or usage or a file that could not be written, 3 a run that
/// broke a promise.
fn main() -> ExitCode {
    match run(Arguments::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { message, code }) => {
            eprintln!("error: {message}");
            ExitCode::from(code)
        }
    }
}

fn run(command: Command) -> Result<(), Failure> {
    // Many runs at once, or costs that are compared: each on one thread.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.map_err(|error| Failure::input(format!("cannot create a thread: {error}")))?;
    match command {
        Command::Extremes(arguments) => command::extremes::run_extremes(&arguments),
        Command::Pace { work, seconds } => command::run_pace(&work, seconds),
        Command::LiveError { generated, only } => {
            command::run_live_error(generated, &only);
            Ok(())
        }
        Command::BeamTable { page, figure, json } => {
            command::run_beam_table(page.as_deref(), figure.as_deref(), json)
        }
        Command::Frames { scenes, size } => command::frames::run_frames(&scenes, &size),
        Command::StabilityTable { scene, json } => command::run_stability_table(&scene, json),
    }
}
