//! What may be written on the command line?

use super::failure::{Failure, say};
use super::values::{
    Step, cores, duration, finite, integrator, newton, not_negative, positive, precision, side,
    size, step, substeps, tasks, threads, tolerance,
};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use msd_core::Integrator;
use msd_lab::{Precision, nearest, tame};
use std::path::PathBuf;

/// Elastic things as particles joined by springs and dampers: see them, grab them, run them.
///
/// SCENE is the name of a built-in scene (see `msd scenes`), a scene file (.toml or .json), a mesh
/// (.obj, .stl, .ply, .gltf or .glb) or a saved run (.msd), which goes on where it was saved.
#[derive(Debug, Parser)]
#[command(name = "msd", version, args_conflicts_with_subcommands = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 the display of the window went away, 2 bad input or \
                        usage, or a file that could not be written, 3 diverged."
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The scene to show in the window [default: jelly]
    pub scene: Option<PathBuf>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Shows a scene in the window; this is also what `msd SCENE` does
    View {
        /// The scene [default: jelly]
        scene: Option<PathBuf>,
    },
    /// Lists the built-in scenes
    Scenes,
    /// Runs a scene without a window and tells what came of it
    Run(RunArguments),
    /// Draws a scene to a PNG picture; needs no display
    Render(RenderArguments),
    /// Measures what a scene costs at every accuracy, and writes a report
    Study(StudyArguments),
    /// Finds the cheapest setting within an error, or the most accurate within a budget
    Tune(TuneArguments),
    /// Runs a scene over a grid of its keys, one file per cell; resumes what was interrupted
    Sweep(SweepArguments),
    /// Takes every method to the extremes: maps of what is accurate, bounded or blows up
    Extremes(ExtremesArguments),
    /// Measures how fast the work is done on which engines are compared
    Bench(BenchArguments),
}

/// How a scene is stepped; what is left out is as the scene says.
#[derive(Debug, Default, Args)]
pub struct SolverArguments {
    /// Method: explicit-euler, symplectic-euler, velocity-verlet, rk4, dormand-prince,
    /// backward-euler, implicit-midpoint or xpbd
    #[arg(long, value_name = "NAME", value_parser = integrator)]
    pub integrator: Option<Integrator>,
    /// Length of an integration step, seconds; `auto` takes 0.9 of the longest stable one
    #[arg(long, value_name = "SECONDS|auto", value_parser = step, allow_hyphen_values = true)]
    #[arg(conflicts_with = "substeps")]
    pub step: Option<Step>,
    /// Integration steps per 1/60 s, instead of --step
    #[arg(long, value_name = "N", value_parser = substeps, allow_hyphen_values = true)]
    pub substeps: Option<u32>,
    /// Local error that dormand-prince allows, as a fraction of the size of the scene
    #[arg(long, value_name = "FRACTION", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Newton iterations of backward-euler and implicit-midpoint per step
    #[arg(long, value_name = "N", value_parser = newton, allow_hyphen_values = true)]
    pub newton: Option<u32>,
    /// Precision: f32 or f64
    #[arg(long, value_name = "NAME", value_parser = precision)]
    pub precision: Option<Precision>,
    /// Start from this state file instead of the start of the scene
    #[arg(long, value_name = "STATE.csv")]
    pub from: Option<PathBuf>,
}

/// Arguments of `msd run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// A built-in scene, a scene file, a mesh or a saved run
    #[arg(required_unless_present = "replay")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// Time to simulate, seconds
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    #[arg(default_value = "10")]
    pub duration: f64,
    /// Write the last state to this file
    #[arg(long, value_name = "STATE.csv")]
    pub out: Option<PathBuf>,
    /// Save the run at its end to this file, which a later run takes for its SCENE
    #[arg(long, value_name = "FILE.msd")]
    pub save: Option<PathBuf>,
    /// Save it also whenever so much simulated time has passed, seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(requires = "save")]
    pub save_every: Option<f64>,
    /// Record the run to this file, to be replayed
    #[arg(long, value_name = "FILE.msdrec", conflicts_with = "replay")]
    pub record: Option<PathBuf>,
    /// Replay this recording, made by --record or in the window, instead of a scene; with another
    /// solver beside it, tell how far the two drift apart
    #[arg(long, value_name = "FILE.msdrec")]
    #[arg(conflicts_with_all = ["scene", "duration", "step", "from", "save_every"])]
    pub replay: Option<PathBuf>,
    /// Replay what is whole of a recording that is damaged, and tell how much is lost
    #[arg(long, requires = "replay")]
    pub salvage: bool,
    /// Write how far the replay is from the recorded run after each step to this file
    #[arg(long, value_name = "DISTANCES.csv", requires = "replay")]
    pub distances: Option<PathBuf>,
    /// Write energy and momentum after each step to this file
    #[arg(long, value_name = "TRACE.csv")]
    pub trace: Option<PathBuf>,
    /// Particles whose positions the trace tells too, such as 0,4
    #[arg(long, value_name = "PARTICLES", value_delimiter = ',', requires = "trace")]
    pub watch: Vec<usize>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `msd render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// A built-in scene, a scene file or a mesh
    pub scene: PathBuf,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// Time to simulate before the picture is taken, seconds
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub time: f64,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    #[arg(default_value = "1280x720")]
    pub size: [u32; 2],
    /// The picture [default: SCENE.png]
    #[arg(long, value_name = "FILE.png")]
    pub out: Option<PathBuf>,
    /// Turn of the camera about the vertical, degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    pub yaw_deg: Option<f64>,
    /// Height of the camera above the horizon, degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    pub pitch_deg: Option<f64>,
    /// Draw the edges of the surface
    #[arg(long)]
    pub wireframe: bool,
    /// Draw the springs, green at rest to red with strain
    #[arg(long)]
    pub springs: bool,
    /// Draw the particles
    #[arg(long)]
    pub particles: bool,
    /// Draw no surfaces
    #[arg(long)]
    pub no_surfaces: bool,
}

/// Arguments of `msd study`.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// A built-in scene, a scene file or a mesh
    pub scene: PathBuf,
    /// Time to simulate, seconds; brought to whole frames of 1/60 s
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub duration: f64,
    /// The error that the advice is about, metres [default: a thousandth of the size]
    #[arg(long, value_name = "METRES", value_parser = positive, allow_hyphen_values = true)]
    pub max_error: Option<f64>,
    /// Processor time to spend on trials, seconds; the reference comes on top
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(default_value = "60")]
    pub time: f64,
    /// The folder of the report [default: SCENE-study]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Tell instead what each part of the model is worth: what it costs, what it changes
    #[arg(long, conflicts_with_all = ["stability_table", "max_error", "time", "out", "fresh"])]
    pub terms: bool,
    /// Tell instead how stiff the scene may be under Euler and Runge-Kutta, beside the report of
    /// 2014
    #[arg(long, conflicts_with_all = ["duration", "max_error", "time", "out", "fresh"])]
    pub stability_table: bool,
    /// Start anew instead of going on with an interrupted study
    #[arg(long)]
    pub fresh: bool,
    /// Print the study as one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `msd tune`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("goal").required(true)))]
pub struct TuneArguments {
    /// A built-in scene, a scene file or a mesh
    pub scene: PathBuf,
    /// The largest error, metres: root mean square distance of the particles from the reference
    #[arg(long, value_name = "METRES", value_parser = positive, allow_hyphen_values = true)]
    #[arg(group = "goal")]
    pub max_error: Option<f64>,
    /// Processor time per frame of 1/60 s, milliseconds
    #[arg(long, value_name = "MS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(group = "goal")]
    pub budget: Option<f64>,
    /// Time over which errors are measured, seconds; brought to whole frames of 1/60 s
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub duration: f64,
    /// Write the choice into the solver section of the scene file
    #[arg(long)]
    pub write: bool,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `msd sweep`; without a choice of cells all of them are run.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// The sweep file: a scene, a duration and the values that keys of the scene take
    #[arg(value_name = "SWEEP.toml")]
    pub sweep: PathBuf,
    /// List the cells: number, hash, whether it is done, values
    #[arg(long, group = "what")]
    pub list: bool,
    /// Run this cell only
    #[arg(long, value_name = "N", group = "what", allow_hyphen_values = true)]
    pub task: Option<usize>,
    /// Run the cells from A to B, both included
    #[arg(long, value_name = "A-B", group = "what", value_parser = tasks)]
    #[arg(allow_hyphen_values = true)]
    pub tasks: Option<(usize, usize)>,
    /// Run nothing; write the cells that are done to this table
    #[arg(long, value_name = "FILE.parquet|FILE.csv", group = "what")]
    pub collect: Option<PathBuf>,
    /// Cells run at once
    #[arg(short, long, value_name = "CORES", default_value = "1", value_parser = cores)]
    #[arg(allow_hyphen_values = true)]
    pub jobs: usize,
    /// Folder of the files [default: as the sweep file says, else its name without ending]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Arguments of `msd extremes`.
#[derive(Debug, Args)]
pub struct ExtremesArguments {
    /// The folder of the maps and tables
    #[arg(long, value_name = "FOLDER", default_value = "extremes")]
    pub out: PathBuf,
    /// Put the tables between the marks of this page as well, as in docs/extremes.md
    #[arg(long, value_name = "PAGE.md")]
    pub page: Option<PathBuf>,
    /// A coarse look: some seconds instead of some minutes
    #[arg(long)]
    pub quick: bool,
    /// Runs at once [default: as many as there are cores]
    #[arg(short, long, value_name = "CORES", value_parser = cores)]
    #[arg(allow_hyphen_values = true)]
    pub jobs: Option<usize>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// What `msd bench` steps.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Work {
    /// A cloth of N x N particles that swings from two corners
    Cloth,
    /// A block of N x N x N particles that drops on a plane
    Block,
}

/// Arguments of `msd bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// The work
    #[arg(value_name = "cloth|block")]
    pub work: Work,
    /// Particles along each side
    #[arg(value_name = "N", value_parser = side, allow_negative_numbers = true)]
    pub size: usize,
    /// Method, as for `msd run`
    #[arg(long, value_name = "NAME", value_parser = integrator)]
    #[arg(default_value = "symplectic-euler")]
    pub integrator: Integrator,
    /// Precision: f32 or f64
    #[arg(long, value_name = "NAME", value_parser = precision, default_value = "f32")]
    pub precision: Precision,
    /// Integration steps per frame of 1/60 s
    #[arg(long, value_name = "N", value_parser = substeps, allow_hyphen_values = true)]
    #[arg(default_value = "12")]
    pub substeps: u32,
    /// Threads that share the work
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub threads: usize,
    /// Write the positions at t = 1 s to this file: x, y, z of each particle, little-endian f64
    #[arg(long, value_name = "FILE")]
    pub positions: Option<PathBuf>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

/// Answers a call for help, or tells in one line what is wrong with the arguments.
pub fn explain(error: &clap::Error, first: Option<String>) -> Result<(), Failure> {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return say(error.to_string().trim_end());
    }
    let text = error.to_string();
    let told = text.lines().take_while(|line| !line.starts_with("Usage:"));
    let told: Vec<&str> = told.map(str::trim).filter(|line| !line.is_empty()).collect();
    let told = told.into_iter().filter(|line| !line.starts_with("For more information"));
    let mut message = tame(&told.collect::<Vec<_>>().join("; ").replace(":; ", ": "));
    if let Some(rest) = message.strip_prefix("error: ") {
        message = rest.into();
    }
    let commands = Arguments::command();
    let names: Vec<&str> = commands.get_subcommands().map(clap::Command::get_name).collect();
    let first = first.unwrap_or_default();
    // A misspelt command is taken for the scene of the window, and what follows it for too much.
    let too_much = matches!(error.kind(), ErrorKind::UnknownArgument | ErrorKind::ArgumentConflict);
    if too_much && !first.starts_with('-') && !names.contains(&first.as_str()) {
        message = match nearest(&first, names.iter().copied()) {
            Some(near) => format!("there is no command `{first}`; did you mean `{near}`?"),
            None => format!("there is no command `{first}`; there are {}", names.join(", ")),
        };
    }
    Err(Failure::input(format!("{message}; see msd --help")))
}
