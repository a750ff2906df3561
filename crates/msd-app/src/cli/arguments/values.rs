//! Parsers of the values of options, with short messages.

use crate::cli::steps::Moments;
use msd_core::{Instructions, Integrator};
use msd_scene::schema::MOST_NEWTON;
use msd_scene::{Precision, nearest};

/// The length of an integration step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// 0.9 of the longest step that is predicted to be stable.
    Auto,
    /// Seconds.
    Seconds(f64),
}

/// Substeps of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// Chosen from the predicted limit of stability, and renewed during the run.
    Auto,
    /// A fixed number.
    Count(u32),
}

/// A choice of who takes the steps of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The processor.
    Processor,
    /// The first graphics adapter.
    Gpu,
    /// The faster of the two, if the adapter computes the same bits.
    Auto,
    /// The first adapter whose name contains this text.
    Named(String),
}

/// Parses a choice of a device.
pub fn device(text: &str) -> Result<DeviceChoice, String> {
    match text.trim() {
        "" => Err("must be cpu, gpu, auto or a part of a name that `msd devices` lists".into()),
        "cpu" => Ok(DeviceChoice::Processor),
        "gpu" => Ok(DeviceChoice::Gpu),
        "auto" => Ok(DeviceChoice::Auto),
        name => Ok(DeviceChoice::Named(name.into())),
    }
}

/// A choice of particles in the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// Every particle.
    All,
    /// The particle with this index.
    One(usize),
}

/// Parses the index of a particle, or `all`.
pub fn watched(text: &str) -> Result<Watched, String> {
    if text == "all" {
        return Ok(Watched::All);
    }
    let number = text.parse().map(Watched::One);
    number.map_err(|_| "must be `all` or numbers of particles, as in 0,4".into())
}

/// Parses a range of cells of a sweep, `A-B`.
pub fn tasks(text: &str) -> Result<(usize, usize), String> {
    let ends = text.split_once('-').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    let ends = ends.filter(|(a, b)| a <= b);
    ends.ok_or_else(|| "must be A-B, two whole numbers in ascending order, as in 0-99".into())
}

/// Largest number of threads: far more than the cores of any machine.
const MAX_CORES: usize = 4096;

/// Largest number of particles along a side; memory ends long before.
const MAX_SIDE: usize = 1_000_000;

/// Largest number of threads for one system.
const MAX_THREADS: usize = 1024;

/// Parses a number of cores.
pub fn cores(text: &str) -> Result<usize, String> {
    let cores = text.parse().ok().filter(|cores| (1..=MAX_CORES).contains(cores));
    cores.ok_or_else(|| format!("must be a whole number from 1 to {MAX_CORES}"))
}

/// Parses the name of a method.
pub fn integrator(text: &str) -> Result<Integrator, String> {
    text.parse().map_err(|_| {
        let names = Integrator::ALL.map(Integrator::name);
        match nearest(text, names) {
            Some(near) => format!("must be one of {}; did you mean `{near}`?", names.join(", ")),
            None => format!("must be one of {}", names.join(", ")),
        }
    })
}

/// Parses the name of a precision.
pub fn precision(text: &str) -> Result<Precision, String> {
    let known = [Precision::F32, Precision::F64].into_iter().find(|known| known.name() == text);
    known.ok_or_else(|| "must be f32 or f64".into())
}

/// Parses the name of an instruction set of this processor.
pub fn instructions(text: &str) -> Result<Instructions, String> {
    let known = || Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best());
    let found = known().find(|set| set.name() == text);
    found.ok_or_else(|| {
        let names: Vec<_> = known().map(Instructions::name).collect();
        format!("must be one that this processor has: {}", names.join(", "))
    })
}

fn number(text: &str, ok: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&number: &f64| number.is_finite() && ok(number));
    number.ok_or_else(|| format!("must be {expected}"))
}

/// Parses a positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text, |number| 0.0 < number, "a number, positive and finite")
}

/// Parses a positive number, or a fraction such as 1/30.
pub fn interval(text: &str) -> Result<f64, String> {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    let parts = positive(above).and_then(|above| Ok(above / positive(below)?));
    let interval = parts.ok().filter(|&interval| 0.0 < interval && interval.is_finite());
    interval
        .ok_or_else(|| "must be a number or a fraction such as 1/30, positive and finite".into())
}

/// Parses the frames of a film, `FROM:TO:EVERY`.
pub fn frames(text: &str) -> Result<Moments, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let read = || {
        let &[from, to, every] = &parts[..] else { return None };
        let (from, to) = (not_negative(from).ok()?, not_negative(to).ok()?);
        let every = interval(every).ok()?;
        (from <= to).then_some(Moments { from, to, every })
    };
    read().ok_or_else(|| {
        "must be FROM:TO:EVERY, seconds in ascending order and a positive interval, as in \
         0:10:1/30"
            .into()
    })
}

/// Parses the length of a step: `auto` or seconds.
pub fn step(text: &str) -> Result<Step, String> {
    let seconds = || positive(text).map(Step::Seconds);
    if text == "auto" { Ok(Step::Auto) } else { seconds() }
        .map_err(|_| "must be `auto` or a number, positive and finite".into())
}

/// Parses a duration, seconds.
pub fn duration(text: &str) -> Result<f64, String> {
    number(text, |number| 0.0 < number && number <= 1e5, "a number, positive and at most 1e5")
}

/// Parses a local error, as a fraction.
pub fn tolerance(text: &str) -> Result<f64, String> {
    number(text, |number| 0.0 < number && number <= 1.0, "a number, positive and at most 1")
}

/// Parses a non-negative number.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |number| 0.0 <= number, "a number, finite and not negative")
}

/// Parses a finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    number(text, |_| true, "a finite number")
}

/// Parses a positive whole number.
pub fn substeps(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|&number| 0 < number);
    number.ok_or_else(|| format!("must be a whole number from 1 to {}", u32::MAX))
}

/// Parses the substeps of a frame: `auto` or a number.
pub fn automatic_substeps(text: &str) -> Result<Substeps, String> {
    if text == "auto" {
        return Ok(Substeps::Auto);
    }
    let count = substeps(text).map(Substeps::Count);
    count.map_err(|_| format!("must be `auto` or a whole number from 1 to {}", u32::MAX))
}

/// Parses a number of Newton iterations.
pub fn newton(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (1..=MOST_NEWTON).contains(number));
    number.ok_or_else(|| format!("must be a whole number from 1 to {MOST_NEWTON}"))
}

/// Parses the number of particles along a side of a workload.
pub fn side(text: &str) -> Result<usize, String> {
    let side = text.parse().ok().filter(|side| (2..=MAX_SIDE).contains(side));
    side.ok_or_else(|| format!("must be a whole number from 2 to {MAX_SIDE}"))
}

/// Parses the number of threads of a workload.
pub fn threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    threads.ok_or_else(|| format!("must be a whole number from 1 to {MAX_THREADS}"))
}

/// Parses the size of a picture, `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        Some([width.parse::<u32>().ok()?, height.parse::<u32>().ok()?])
    });
    let sides = sides.filter(|sides| sides.iter().all(|side| (1..=16384).contains(side)));
    sides.ok_or_else(|| "must be WIDTHxHEIGHT, each from 1 to 16384 pixels, as in 1280x720".into())
}
