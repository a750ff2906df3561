//! `msd bench`: the speed of the workloads on which engines are compared.

use super::arguments::{BenchArguments, DeviceChoice, Work};
use super::device::Gpu;
use super::failure::{Failure, say, say_json};
use super::places::Places;
use super::run::{evaluations, explain_divergence, is_endless};
use super::steps::SlowNotice;
use cpu_time::ProcessTime;
use msd_core::{Error, Instructions, Integrator, Scene, Settings};
use msd_run::{Runner, on};
use msd_scene::{FileError, Output, Precision, shown_path, workloads};
use msd_study::quantity::{counted, number, quantity};
use msd_study::trial::state;
use rayon::ThreadPoolBuilder;
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use web_time::Instant;

/// Frames until t = 1 s, the time of the written positions.
const FRAMES: u64 = 60;
/// Warm-up for caches and processor clock, not measured, seconds.
const WARM_UP: f64 = 0.25;
/// Length of a batch unless a frame takes longer, seconds: a hundred times that of an interrupt.
const BATCH: f64 = 0.02;
/// Least number of batches, and least time for all of them, seconds.
const BATCHES: usize = 20;
const MEASURED: f64 = 1.0;

/// Result of a measurement; the keys of `--json`, as in `msd run` if they have the same meaning.
#[derive(Debug, Serialize)]
struct BenchReport {
    scene: String,
    /// Particles along each side; of `irregular`, all.
    size: usize,
    particles: usize,
    springs: usize,
    integrator: Integrator,
    /// Length of an integration step, seconds.
    step: f64,
    /// Integration steps per frame.
    substeps: u32,
    precision: Precision,
    /// Vector instructions.
    instructions: &'static str,
    threads: usize,
    #[serde(flatten)]
    speed: Speed,
    /// `processor`, or the graphics adapter that was measured beside it.
    device: String,
    /// Its speed; null without one.
    on_device: Option<Speed>,
    /// Peak memory of the process; null if the system does not report it.
    peak_memory_bytes: Option<u64>,
}

/// Speed of the processor or of a graphics device.
#[derive(Debug, Serialize)]
struct Speed {
    /// Springs times force evaluations per second of the wall clock; null for methods that choose
    /// their own number of evaluations.
    updates_per_second: Option<Updates>,
    /// Medians of the batches.
    ms_per_frame: FrameTime,
    batches: usize,
    frames_per_batch: u64,
}

/// Spring updates per second.
#[derive(Debug, Serialize)]
struct Updates {
    best: f64,
    median: f64,
}

/// Time of a frame, milliseconds.
#[derive(Debug, Serialize)]
struct FrameTime {
    /// Wall-clock time.
    wall: f64,
    /// CPU time of all threads together.
    cpu: f64,
}

/// Wall-clock and CPU times of the batches, per frame, seconds.
struct Times {
    walls: Vec<f64>,
    cpus: Vec<f64>,
    frames_per_batch: u64,
}

/// Measures, writes positions if requested, and prints the result.
pub fn run_bench(arguments: &BenchArguments) -> Result<(), Failure> {
    let BenchArguments { integrator, substeps, threads, .. } = *arguments;
    if is_endless(FRAMES as f64 * f64::from(substeps)) {
        return Err(Failure::input(format!("--substeps {substeps} would take weeks")));
    }
    let settings = Settings { integrator, substeps, ..workloads::settings() };
    arguments.pin.map_or(Ok(()), pin)?;
    // Opened first, so that a missing folder is reported before the work.
    let places = |path: &PathBuf| Places::default().write("--positions", path);
    arguments.positions.iter().try_for_each(places)?;
    let output = arguments.positions.as_deref().map(Output::create).transpose();
    let output = output.map_err(Failure::input)?;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::input(format!("--threads {threads}: {error}")))?;
    let (report, notes, written) = pool.install(|| {
        let (report, notes) = measure(arguments, settings)?;
        let write = |output| write_positions(arguments, settings, output);
        Ok((report, notes, output.map_or(Ok(()), write)))
    })?;
    let said = if arguments.json {
        say_json(&report)
    } else {
        say(&summary(&report, arguments, (&notes, written.is_ok())))
    };
    Failure::all(written.err().into_iter().chain(said.err()))
}

fn scene(arguments: &BenchArguments) -> Result<Scene, FileError> {
    match arguments.work {
        Work::Cloth => workloads::cloth(arguments.size),
        Work::Block => workloads::block(arguments.size),
        Work::Irregular => workloads::irregular(arguments.size),
        Work::Drape => workloads::drape(arguments.size),
    }
}

fn name(arguments: &BenchArguments) -> String {
    let kind = match arguments.work {
        Work::Cloth => "cloth",
        Work::Block => "block",
        Work::Irregular => "irregular",
        Work::Drape => "drape",
    };
    format!("{kind} {}", arguments.size)
}

/// Creates the run of a workload; the scene is freed as its columns are made.
fn start(arguments: &BenchArguments, settings: Settings) -> Result<Runner, Failure> {
    let _notice = SlowNotice::new(format!("preparing {}", name(arguments)));
    let scene = scene(arguments).map_err(Failure::input)?;
    let runner = Runner::from_scene(scene, settings, arguments.precision);
    let mut runner = runner.map_err(|error| explain(arguments, error))?;
    on!(&mut runner, simulation => simulation.set_instructions(instructions(arguments)));
    Ok(runner)
}

fn instructions(arguments: &BenchArguments) -> Instructions {
    arguments.instructions.unwrap_or(Instructions::best())
}

/// Binds this thread, and the threads that it starts, to a processor.
#[cfg(target_os = "linux")]
fn pin(processor: usize) -> Result<(), Failure> {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let refused = |reason| Failure::input(format!("--pin {processor}: {reason}"));
    let allowed = sched_getaffinity(None).map_err(|error| refused(error.to_string()))?;
    let mut processors = (0..CpuSet::MAX_CPU).filter(|&number| allowed.is_set(number));
    if !processors.any(|number| number == processor) {
        let count = allowed.count();
        return Err(refused(format!("not one of the {count} processors of this process")));
    }
    let mut one = CpuSet::new();
    one.set(processor);
    sched_setaffinity(None, &one).map_err(|error| refused(error.to_string()))
}

#[cfg(not(target_os = "linux"))]
fn pin(_: usize) -> Result<(), Failure> {
    Err(Failure::input("--pin: only Linux lets a process choose its processor"))
}

/// Explains an error without advice: `msd run` has options that `msd bench` lacks.
fn explain(arguments: &BenchArguments, error: Error) -> Failure {
    explain_divergence(&name(arguments), error, None)
}

/// Measures the processor, and the device if one is asked for; returns notes on it.
fn measure(
    arguments: &BenchArguments,
    settings: Settings,
) -> Result<(BenchReport, Option<String>), Failure> {
    let mut runner = start(arguments, settings)?;
    let (mut gpu, note) = open_device(arguments, &runner)?;
    let springs = runner.spring_count();
    let updates = evaluations_per_frame(settings).map(|count| count as f64 * springs as f64);
    let on_device = gpu.as_mut().map(|gpu| {
        gpu.upload(&runner)?;
        let times = time(|frames| gpu.compute(frames))?;
        gpu.check_computed()?;
        Ok(Speed::new(times, updates))
    });
    let on_device = on_device.transpose()?;
    let times = time(|frames| (0..frames).try_for_each(|_| runner.step()));
    let times = times.map_err(|error| explain(arguments, error))?;
    let Settings { integrator, substeps, step, .. } = settings;
    let substeps = if integrator.is_adaptive() { 1 } else { substeps };
    let report = BenchReport {
        scene: name(arguments),
        size: arguments.size,
        particles: runner.particle_count(),
        springs,
        integrator,
        step: step / f64::from(substeps),
        substeps,
        precision: arguments.precision,
        instructions: instructions(arguments).name(),
        threads: arguments.threads,
        speed: Speed::new(times, updates),
        device: gpu.map_or("processor".to_owned(), |gpu| gpu.name()),
        on_device,
        peak_memory_bytes: peak_memory(),
    };
    Ok((report, note))
}

/// Opens the device that is to be measured too, and returns a note on it.
fn open_device(
    arguments: &BenchArguments,
    runner: &Runner,
) -> Result<(Option<Gpu>, Option<String>), Failure> {
    if arguments.device == DeviceChoice::Processor {
        return Ok((None, None));
    }
    match Gpu::open(&arguments.device, runner) {
        Ok(gpu) => {
            let note = format!("device: {}, {}", gpu.name(), gpu.verdict());
            Ok((Some(gpu), Some(note)))
        }
        Err(refusal) if arguments.device == DeviceChoice::Auto => {
            Ok((None, Some(format!("device: none, as {}", refusal.why))))
        }
        Err(refusal) => Err(refusal.failure(&name(arguments))),
    }
}

impl Speed {
    /// The speed by the times of batches; `updates` are those of springs per frame.
    fn new(times: Times, updates: Option<f64>) -> Self {
        let Times { walls, cpus, frames_per_batch } = times;
        let best = walls.iter().copied().fold(f64::INFINITY, f64::min);
        let (batches, wall) = (walls.len(), median(walls));
        Speed {
            updates_per_second: updates
                .map(|updates| Updates { best: updates / best, median: updates / wall }),
            ms_per_frame: FrameTime { wall: 1e3 * wall, cpu: 1e3 * median(cpus) },
            batches,
            frames_per_batch,
        }
    }

    /// Formats it as lines of the summary.
    fn lines(&self, by: &str) -> Vec<String> {
        let Speed { ms_per_frame, batches, frames_per_batch, .. } = self;
        let updates = self.updates_per_second.as_ref().map(|Updates { best, median }| {
            let [best, median] = [best, median].map(|updates| number(1e-9 * updates));
            format!("{by}{median} G spring updates/s (median), {best} G (best)")
        });
        let [wall, cpu] = [ms_per_frame.wall, ms_per_frame.cpu].map(|ms| quantity(1e-3 * ms, "s"));
        let frames = counted(*frames_per_batch, "frame");
        let time = format!("{wall} per frame, {cpu} of CPU time ({batches} batches of {frames})");
        updates.into_iter().chain([time]).collect()
    }
}

/// Returns the number of evaluations of each spring per frame; `None` if it depends on the motion.
fn evaluations_per_frame(settings: Settings) -> Option<u64> {
    let Settings { integrator, substeps, .. } = settings;
    let first = u64::from(integrator == Integrator::VelocityVerlet);
    evaluations(integrator).map(|each| each * u64::from(substeps) + first)
}

/// Times batches of frames.
fn time<E>(mut step: impl FnMut(u64) -> Result<(), E>) -> Result<Times, E> {
    let frames_per_batch = warm_up(&mut step)?;
    let per_frame = |seconds: f64| seconds / frames_per_batch as f64;
    let (mut walls, mut cpus) = (Vec::new(), Vec::new());
    let start = Instant::now();
    while walls.len() < BATCHES || start.elapsed().as_secs_f64() < MEASURED {
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        step(frames_per_batch)?;
        walls.push(per_frame(wall.elapsed().as_secs_f64()));
        cpus.push(per_frame(cpu.elapsed().as_secs_f64()));
    }
    Ok(Times { walls, cpus, frames_per_batch })
}

/// Steps for a while and returns the number of frames per batch, at least one.
fn warm_up<E>(step: &mut impl FnMut(u64) -> Result<(), E>) -> Result<u64, E> {
    let start = Instant::now();
    // The last frame is typical, not the fastest: falling bodies may collide later.
    let mut last = BATCH;
    while start.elapsed().as_secs_f64() < WARM_UP {
        let frame = Instant::now();
        step(1)?;
        last = frame.elapsed().as_secs_f64();
    }
    // No frame takes less than a nanosecond, but a coarse clock may report less.
    Ok(((BATCH / last.max(1e-9)) as u64).max(1))
}

/// Returns the median, of an even count the larger of the middle two.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Returns the peak memory of this process, bytes; available on Linux only.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Runs from the start to t = 1 s and writes the positions of the particles.
fn write_positions(
    arguments: &BenchArguments,
    settings: Settings,
    mut output: Output,
) -> Result<(), Failure> {
    let mut runner = start(arguments, settings)?;
    for _ in 0..FRAMES {
        runner.step().map_err(|error| explain(arguments, error))?;
    }
    for number in state(&runner).positions.iter().flat_map(|position| position.to_array()) {
        let written = output.write_all(&number.to_le_bytes());
        written.map_err(|error| Failure::input(output.refused(&error)))?;
    }
    output.finish().map_err(Failure::input)
}

fn summary(
    report: &BenchReport,
    arguments: &BenchArguments,
    (note, written): (&Option<String>, bool),
) -> String {
    let BenchReport { scene, particles, springs, integrator, precision, instructions, .. } = report;
    let BenchReport { substeps, threads, speed, .. } = report;
    let substeps = counted((*substeps).into(), "substep");
    let threads = counted(*threads as u64, "thread");
    let springs = counted(*springs as u64, "spring");
    let mut lines = Vec::from_iter(note.clone());
    lines.push(format!(
        "{scene}: {particles} particles, {springs}, {integrator} in {precision}, \
         {substeps} per frame, {threads}, {instructions}"
    ));
    lines.extend(speed.lines(""));
    lines.extend(report.on_device.iter().flat_map(|speed| speed.lines("device: ")));
    lines.extend(
        report
            .peak_memory_bytes
            .map(|bytes| format!("{} MB of memory at most", number(1e-6 * bytes as f64))),
    );
    lines.extend(arguments.positions.as_ref().filter(|_| written).map(|path| {
        let path = shown_path(path);
        format!("positions at t = 1 s in {path}")
    }));
    lines.join("\n")
}
