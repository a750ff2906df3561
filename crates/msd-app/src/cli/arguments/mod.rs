//! The arguments of every command.

mod values;
mod mistakes;

pub use mistakes::explain;
pub use values::{DeviceChoice, Step, Substeps, Watched};

use super::steps::Moments;
use clap::ArgAction::Append;
use clap::{Args, Parser, Subcommand, ValueEnum};
use msd_core::{Instructions, Integrator};
use msd_scene::{Assignment, Precision, Sight};
use std::path::PathBuf;
use std::str::FromStr;
use values::{
    automatic_substeps, cores, device, duration, finite, frames, instructions, integrator,
    interval, newton, not_negative, positive, precision, side, size, step, substeps, tasks,
    threads, tolerance, watched,
};

/// Simulate elastic bodies as particles joined by springs and dampers
///
/// SCENE is the name of a built-in scene (see `msd scenes`), a scene file (.toml or .json), a mesh
/// (.obj, .stl, .ply, .gltf or .glb), or a saved run (.msd), which continues where it was saved.
#[derive(Debug, Parser)]
#[command(name = "msd", version, args_conflicts_with_subcommands = true)]
#[command(
    after_help = "Exit codes: 0 success, 1 the display of the window went away, 2 bad input or \
                        usage, or a file that could not be written, 3 the simulation diverged, \
                        130 interrupted by Ctrl-C."
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<CliCommand>,
    /// Memory that a scene may take, GB [default: nine tenths of what is free]
    #[arg(long, value_name = "GB", value_parser = positive, allow_hyphen_values = true)]
    #[arg(global = true)]
    pub memory: Option<f64>,
    #[command(flatten)]
    pub view: ViewArguments,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum CliCommand {
    /// Show a scene in the window; `msd SCENE` does the same
    View(ViewArguments),
    /// List the built-in scenes
    Scenes(ListArguments),
    /// List the lessons, or write the teacher's sheet of one
    Lessons(LessonsArguments),
    /// List the methods and their purposes
    Methods(ListArguments),
    /// List the graphics adapters, and whether each computes the bits of the processor
    Devices(ListArguments),
    /// Print the JSON Schema of scene files, for editors and other programs
    Schema,
    /// Run a scene without a window and report the result
    Run(RunArguments),
    /// Render a scene to a PNG picture; needs no display
    Render(RenderArguments),
    /// Run a scene into a file of another program: Blender, ParaView, numpy, glTF
    Export(ExportArguments),
    /// Print properties of the bodies of a scene: mass, moduli by direction, stable step
    Inspect(InspectArguments),
    /// Measure error against cost on a scene, and write a report
    Study(StudyArguments),
    /// Find the fastest setting within an error, or the most accurate within a time budget
    Tune(TuneArguments),
    /// Run a scene over a grid of its keys, one file per cell; resumes where it was interrupted
    Sweep(SweepArguments),
    /// Measure the speed of the workloads on which engines are compared
    Bench(BenchArguments),
    /// Print the completion script for a shell
    Completions(CompletionsArguments),
    /// Write the manual pages, one per command
    Manual(ManualArguments),
}

/// Arguments of lists.
#[derive(Debug, Args)]
pub struct ListArguments {
    /// Print one JSON list instead of lines
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `msd lessons`.
#[derive(Debug, Args)]
pub struct LessonsArguments {
    /// A lesson: a name of the list, or a scene file with [lesson]; `msd view` opens it
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub set: SetArguments,
    /// Write the teacher's sheet to this file, to be printed by a browser [default: SCENE.html]
    #[arg(long, value_name = "FILE.html", requires = "scene", help_heading = OUTPUT)]
    pub out: Option<PathBuf>,
}

/// Arguments of `msd completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Arguments of `msd manual`.
#[derive(Debug, Args)]
pub struct ManualArguments {
    /// Folder for the pages, such as ~/.local/share/man/man1
    pub folder: PathBuf,
}

/// Headings of `--help`.
const SOLVER: &str = "Solver";
const OUTPUT: &str = "Output";
const REPLAY: &str = "Recording and replay";
const CAMERA: &str = "Camera";
const DRAWN: &str = "What is drawn";
const CELLS: &str = "Cells (default: all)";

/// Arguments of `msd view`, and of `msd` without a command.
#[derive(Debug, Args)]
pub struct ViewArguments {
    /// Scene to show in the window [default: the last one, or cube]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub set: SetArguments,
    #[command(flatten)]
    pub solver: SolverArguments,
}

/// Values that replace those of keys of a scene.
#[derive(Debug, Default, Args)]
pub struct SetArguments {
    /// Set a key of the scene as its file would, such as world.gravity=[0,-1.62,0] or
    /// bodies.0.stiffness=300; may be repeated
    #[arg(long, value_name = "KEY=VALUE", value_parser = Assignment::parse, action = Append)]
    #[arg(allow_hyphen_values = true, help_heading = None)]
    pub set: Vec<Assignment>,
}

/// Solver options, which replace those of the scene.
#[derive(Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Solver (default: as in the scene)")]
pub struct SolverArguments {
    /// Integration method: explicit-euler, symplectic-euler, velocity-verlet, rk4, dormand-prince,
    /// backward-euler, implicit-midpoint or xpbd
    #[arg(long, value_name = "NAME", value_parser = integrator)]
    pub integrator: Option<Integrator>,
    /// Length of an integration step, seconds; `auto` is that of automatic substeps at the start
    #[arg(long, value_name = "SECONDS|auto", value_parser = step, allow_hyphen_values = true)]
    #[arg(conflicts_with = "substeps")]
    pub step: Option<Step>,
    /// Integration steps per frame of 1/60 s, instead of --step; `auto` chooses them from the
    /// longest stable step, and renews them during the run, and where particles would tunnel or go
    /// far round a solid
    #[arg(long, value_name = "N|auto", value_parser = automatic_substeps)]
    #[arg(allow_hyphen_values = true)]
    pub substeps: Option<Substeps>,
    /// Local error of dormand-prince, as a fraction of the size of the scene
    #[arg(long, value_name = "FRACTION", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Newton iterations per step of backward-euler and implicit-midpoint
    #[arg(long, value_name = "N", value_parser = newton, allow_hyphen_values = true)]
    pub newton: Option<u32>,
    /// Floating-point precision: f32 or f64
    #[arg(long, value_name = "NAME", value_parser = precision)]
    pub precision: Option<Precision>,
    /// Start from this state file
    #[arg(long, value_name = "STATE.csv", help_heading = None)]
    pub from: Option<PathBuf>,
}

/// Arguments of `msd run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    #[arg(required_unless_present = "replay")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub set: SetArguments,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// Time to simulate, seconds
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    #[arg(default_value = "10", help_heading = None)]
    pub duration: f64,
    /// Take the steps on the processor (cpu), the first graphics adapter (gpu), the faster of the
    /// two (auto) or an adapter by a part of its name; the bits are the same
    #[arg(long, value_name = "cpu|gpu|auto|NAME", value_parser = device, default_value = "cpu")]
    #[arg(help_heading = None)]
    pub device: DeviceChoice,
    /// Write the final state to this file: .csv (for --from), .npz, .obj, .ply or .vtu
    #[arg(long, value_name = "STATE.csv", help_heading = OUTPUT)]
    pub out: Option<PathBuf>,
    /// Save the run at its end to this file, which can be given as SCENE to continue
    #[arg(long, value_name = "FILE.msd", help_heading = OUTPUT)]
    pub save: Option<PathBuf>,
    /// Simulated time between further saves during the run, seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(requires = "save", help_heading = OUTPUT)]
    pub save_every: Option<f64>,
    /// Record the run to this file, to be replayed
    #[arg(long, value_name = "FILE.msdrec", conflicts_with = "replay", help_heading = REPLAY)]
    pub record: Option<PathBuf>,
    /// Replay this recording (made by --record or in the window) instead of running a scene; with
    /// another solver, report how far the two drift apart
    #[arg(long, value_name = "FILE.msdrec", help_heading = REPLAY)]
    #[arg(conflicts_with_all = ["scene", "set", "duration", "device", "step", "from"])]
    #[arg(conflicts_with = "save_every")]
    pub replay: Option<PathBuf>,
    /// Replay the intact part of a damaged recording, and report how much is lost
    #[arg(long, requires = "replay", help_heading = REPLAY)]
    pub salvage: bool,
    /// Write the distance between replay and recorded run after each step to this file
    #[arg(long, value_name = "DISTANCES.csv", requires = "replay", help_heading = REPLAY)]
    pub distances: Option<PathBuf>,
    /// Write energy and momentum after each step to this file
    #[arg(long, value_name = "TRACE.csv", help_heading = OUTPUT)]
    pub trace: Option<PathBuf>,
    /// Add the positions of these particles to the trace, such as 0,4, or of all
    #[arg(long, value_name = "PARTICLES|all", value_delimiter = ',', requires = "trace")]
    #[arg(value_parser = watched, help_heading = OUTPUT)]
    pub watch: Vec<Watched>,
    /// Print one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
    /// Print errors only: no progress, no warnings, no summary
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}

/// Arguments of `msd export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    pub scene: PathBuf,
    #[command(flatten)]
    pub set: SetArguments,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// Time to simulate, seconds
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    #[arg(default_value = "10", help_heading = None)]
    pub duration: f64,
    /// Write the run to this file. Over time: .pc2 or .mdd (with the mesh as .obj), .pvd (with a
    /// .vtu per moment), .glb, .npz or .parquet; its end: .obj, .ply, .vtu or .csv
    #[arg(long, value_name = "FILE", required = true, help_heading = OUTPUT)]
    pub to: PathBuf,
    /// Time between two moments in the file, seconds; may be a fraction
    #[arg(long, value_name = "SECONDS", value_parser = interval, allow_hyphen_values = true)]
    #[arg(default_value = "1/30", help_heading = OUTPUT)]
    pub every: f64,
    /// Print one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
    /// Print errors only: no progress, no warnings, no summary
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}

/// Arguments of `msd render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    pub scene: PathBuf,
    #[command(flatten)]
    pub set: SetArguments,
    #[command(flatten)]
    pub solver: SolverArguments,
    /// Time to simulate before the picture is taken, seconds
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    #[arg(default_value = "1", help_heading = None)]
    pub time: f64,
    /// Take a film instead: pictures from one time to another, both included, at equal intervals,
    /// seconds; such as 0:10:1/30
    #[arg(long, value_name = "FROM:TO:EVERY", value_parser = frames, allow_hyphen_values = true)]
    #[arg(conflicts_with = "time", help_heading = None)]
    pub frames: Option<Moments>,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    #[arg(default_value = "1280x720", help_heading = OUTPUT)]
    pub size: [u32; 2],
    /// Write the picture to this file [default: SCENE.png]. A film: .webp or .gif, a .png per frame
    /// with its number, such as film/%04d.png, or .mp4, .webm, .mov or .mkv by ffmpeg [default:
    /// SCENE.webp]
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub out: Option<PathBuf>,
    /// Print one JSON object instead of a line
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
    /// Print errors only: no progress, no warnings, no line at the end
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
    /// Look from a side: front, back, left, right or top; or turn about the scene during a film:
    /// orbit, once, or orbit:DEGREES per second
    #[arg(long, value_name = "VIEW", value_parser = Sight::from_str, allow_hyphen_values = true)]
    #[arg(help_heading = CAMERA)]
    pub camera: Option<Sight>,
    /// Azimuth of the camera about the vertical, degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    #[arg(help_heading = CAMERA)]
    pub yaw_deg: Option<f64>,
    /// Elevation of the camera above the horizon, degrees
    #[arg(long, value_name = "DEGREES", value_parser = finite, allow_hyphen_values = true)]
    #[arg(help_heading = CAMERA)]
    pub pitch_deg: Option<f64>,
    /// Draw the edges of the surface
    #[arg(long, help_heading = DRAWN)]
    pub wireframe: bool,
    /// Colour by a quantity of springs, which are then drawn, or of particles
    #[arg(long, value_name = "QUANTITY", value_enum, help_heading = DRAWN)]
    pub colour_by: Option<ColourBy>,
    /// End of the scale of the colours, in the unit of the quantity; of a strain 0.2 is 20 %
    /// [default: the maximum over all pictures, rounded up; 0.2 of a strain]
    #[arg(long, value_name = "NUMBER", value_parser = positive, allow_hyphen_values = true)]
    #[arg(help_heading = DRAWN)]
    pub full_scale: Option<f64>,
    /// Leave out the legend of the colours
    #[arg(long, help_heading = DRAWN)]
    pub no_legend: bool,
    /// Draw the particles
    #[arg(long, help_heading = DRAWN)]
    pub particles: bool,
    /// Leave out the surfaces
    #[arg(long, help_heading = DRAWN)]
    pub no_surfaces: bool,
    /// Leave out sky, ground and walls: the background is transparent
    #[arg(long, value_name = "none", value_parser = ["none"], help_heading = DRAWN)]
    pub background: Option<String>,
}

/// Quantity that colours represent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColourBy {
    /// Strain of springs, %: compressed blue, stretched red
    Strain,
    /// Force of springs with their dampers, N: pushes blue, pulls red
    Force,
    /// Elastic energy of springs, J: dark to light
    Energy,
    /// Speed of particles, m/s: dark to light
    Speed,
}

/// Arguments of `msd inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    pub scene: PathBuf,
    #[command(flatten)]
    pub set: SetArguments,
    /// Print one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `msd study`.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    pub scene: PathBuf,
    #[command(flatten)]
    pub set: SetArguments,
    /// Time to simulate, seconds; rounded to whole frames of 1/60 s
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub duration: f64,
    /// Error for the advice, metres [default: a thousandth of the size of the scene]
    #[arg(long, value_name = "METRES", value_parser = positive, allow_hyphen_values = true)]
    pub max_error: Option<f64>,
    /// Processor time to spend on trials, seconds, not counting the reference
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(default_value = "60")]
    pub time: f64,
    /// Time the settings on a graphics adapter too: the first one (gpu), one by a part of its name,
    /// or the first one if it computes the same bits (auto)
    #[arg(long, value_name = "cpu|gpu|auto|NAME", value_parser = device, default_value = "cpu")]
    pub device: DeviceChoice,
    /// Write the report to this folder [default: SCENE-study]
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT)]
    pub out: Option<PathBuf>,
    /// Also measure the error of the spacing of the particles, on finer meshes, which take another
    /// --time
    #[arg(long)]
    pub mesh: bool,
    /// Report the cost and the effect of each model term instead
    #[arg(long, conflicts_with_all = ["max_error", "time", "device", "out", "fresh", "mesh"])]
    pub terms: bool,
    /// Start afresh instead of resuming an interrupted study
    #[arg(long)]
    pub fresh: bool,
    /// Print the study as one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `msd tune`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("goal").required(true)))]
pub struct TuneArguments {
    /// Built-in scene, scene file, mesh, saved run or link (in quotes)
    pub scene: PathBuf,
    #[command(flatten)]
    pub set: SetArguments,
    /// Largest error, metres: root mean square distance of the particles from the reference
    #[arg(long, value_name = "METRES", value_parser = positive, allow_hyphen_values = true)]
    #[arg(group = "goal")]
    pub max_error: Option<f64>,
    /// Processor time per frame of 1/60 s, milliseconds
    #[arg(long, value_name = "MS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(group = "goal")]
    pub budget: Option<f64>,
    /// Time over which errors are measured, seconds; rounded to whole frames of 1/60 s
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_hyphen_values = true)]
    #[arg(default_value = "1")]
    pub duration: f64,
    /// Choose the spacing of the particles too: errors count from the limit of ever finer meshes
    #[arg(long, conflicts_with_all = ["budget", "device"])]
    pub mesh: bool,
    /// Processor time to spend on finer meshes, seconds [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    #[arg(requires = "mesh")]
    pub time: Option<f64>,
    /// Tune for the processor (cpu), by the time of the first graphics adapter (gpu) or of one by a
    /// part of its name, or for the cheaper of the two (auto)
    #[arg(long, value_name = "cpu|gpu|auto|NAME", value_parser = device, default_value = "cpu")]
    pub device: DeviceChoice,
    /// Write the result into the solver section of the scene file
    #[arg(long, conflicts_with = "set", help_heading = OUTPUT)]
    pub write: bool,
    /// Print one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `msd sweep`; by default it runs all cells.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// Sweep file: a scene, a duration and the values that keys of the scene take
    #[arg(value_name = "SWEEP.toml")]
    pub sweep: PathBuf,
    /// List the cells: number, hash, whether it is done, values
    #[arg(long, group = "what", help_heading = CELLS)]
    pub list: bool,
    /// Run this cell only
    #[arg(long, value_name = "N", group = "what", allow_hyphen_values = true)]
    #[arg(help_heading = CELLS)]
    pub task: Option<usize>,
    /// Run the cells from A to B, both included
    #[arg(long, value_name = "A-B", group = "what", value_parser = tasks)]
    #[arg(allow_hyphen_values = true, help_heading = CELLS)]
    pub tasks: Option<(usize, usize)>,
    /// Run nothing; write the cells that are done to this table
    #[arg(long, value_name = "FILE.csv|FILE.parquet", group = "what", help_heading = CELLS)]
    pub collect: Option<PathBuf>,
    /// Cells to run at once
    #[arg(short, long, value_name = "CORES", default_value = "1", value_parser = cores)]
    #[arg(allow_hyphen_values = true)]
    pub jobs: usize,
    /// Take the steps on the processor (cpu), the first graphics adapter (gpu), the faster of the
    /// two (auto) or an adapter by a part of its name: many cells at once, with the same bits
    #[arg(long, value_name = "cpu|gpu|auto|NAME", value_parser = device, default_value = "cpu")]
    pub device: DeviceChoice,
    /// Write the files to this folder [default: as in the sweep file, else its name without ending]
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print the list or the summary as JSON
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Workloads of `msd bench`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Work {
    /// A cloth of N x N particles that swings from two corners
    Cloth,
    /// A block of N x N x N particles that drops on a plane
    Block,
    /// An unstructured block of N particles that drops on a plane
    Irregular,
    /// Three cloths of N x N particles that fall on a ball and touch
    Drape,
}

/// Arguments of `msd bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// Workload
    #[arg(value_name = "cloth|block|irregular|drape")]
    pub work: Work,
    /// Particles along each side; of `irregular`, all particles
    #[arg(value_name = "N", value_parser = side, allow_negative_numbers = true)]
    pub size: usize,
    /// Integration method, as for `msd run`
    #[arg(long, value_name = "NAME", value_parser = integrator)]
    #[arg(default_value = "symplectic-euler", help_heading = SOLVER)]
    pub integrator: Integrator,
    /// Floating-point precision: f32 or f64
    #[arg(long, value_name = "NAME", value_parser = precision, default_value = "f32")]
    #[arg(help_heading = SOLVER)]
    pub precision: Precision,
    /// Integration steps per frame of 1/60 s
    #[arg(long, value_name = "N", value_parser = substeps, allow_hyphen_values = true)]
    #[arg(default_value = "12", help_heading = SOLVER)]
    pub substeps: u32,
    /// Threads that share the work
    #[arg(long, value_name = "N", value_parser = threads, allow_hyphen_values = true)]
    #[arg(default_value = "1", help_heading = SOLVER)]
    pub threads: usize,
    /// Vector instructions: avx512, avx2 or plain (SSE2, NEON or of WebAssembly); by default the
    /// best that this processor has
    #[arg(long, value_name = "NAME", value_parser = instructions, help_heading = SOLVER)]
    pub instructions: Option<Instructions>,
    /// Measure a graphics adapter too: the first one (gpu), one by a part of its name, or the first
    /// one if it computes the same bits (auto)
    #[arg(long, value_name = "cpu|gpu|auto|NAME", value_parser = device, default_value = "cpu")]
    #[arg(help_heading = SOLVER)]
    pub device: DeviceChoice,
    /// Stay on this processor, counted from 0; Linux alone
    #[arg(long, value_name = "CPU", help_heading = SOLVER)]
    pub pin: Option<usize>,
    /// Write the positions at t = 1 s to this file: x, y, z of each particle, little-endian f64
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub positions: Option<PathBuf>,
    /// Print one JSON object instead of a summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}
