//! The commands of the program, and how one fails.

pub mod extremes;
pub mod frames;

use msd_core::Instructions;
use msd_run::pace::best_pace;
use msd_scene::{shown_path, write_file};
use msd_study::live_error::Calibration;
use std::fmt::Display;
use std::path::Path;
use std::time::Instant;
use xtask::beam_table::{self, beam_table};
use xtask::calibration::{BAND, Window, windows};
use xtask::marks::put;
use xtask::stability_table::{euler_steps, stability_table};

/// Why a command ended early.
#[derive(Debug)]
pub struct Failure {
    /// The mistake.
    pub message: String,
    /// The exit code.
    pub code: u8,
}

impl Failure {
    /// Bad input or usage, or a file that could not be written.
    pub fn input(message: impl Display) -> Self {
        Failure { message: message.to_string(), code: 2 }
    }

    /// A run that broke a promise.
    pub fn broken(message: impl Display) -> Self {
        Failure { message: message.to_string(), code: 3 }
    }
}

/// Prints the live estimate beside the truth, and how often it is right.
pub fn run_live_error(generated: u64, only: &str) {
    let mut tell = |window: &Window| {
        let Calibration { start, estimated, true_error, .. } = window.calibration;
        let ratio = window.ratio();
        let missed = if window.is_right() { "" } else { "  <- missed" };
        println!(
            "{:<14} from {start} s: {estimated:.1e} m of {true_error:.1e} m, {ratio:.2}{missed}",
            window.scene
        );
    };
    let found = windows(generated, only, &mut tell);
    let right = found.iter().filter(|window| window.is_right()).count();
    let percent = 100.0 * right as f64 / found.len().max(1) as f64;
    println!("{right} of {} windows within a factor of {BAND}: {percent:.0} %", found.len());
}

/// Prints the stability table of a scene.
pub fn run_stability_table(scene: &Path, json: bool) -> Result<(), Failure> {
    let loaded = msd_scene::open(scene).map_err(Failure::input)?;
    let table = euler_steps(&loaded.scene).and_then(|steps| stability_table(&loaded.scene, steps));
    let table = table.map_err(|error| Failure::input(format!("{}: {error}", loaded.name)))?;
    match json {
        true => println!("{}", serde_json::to_string_pretty(&table).map_err(Failure::input)?),
        false => print!("{}", table.text()),
    }
    Ok(())
}

/// Prints the table of beams, and puts it on a page and into a figure.
pub fn run_beam_table(
    page: Option<&Path>,
    figure: Option<&Path>,
    json: bool,
) -> Result<(), Failure> {
    let read = |path: &Path| {
        let refused = |error: &dyn Display| {
            let expected = "it must be a page with <!-- begin beam --> and <!-- end beam -->";
            Failure::input(format!("{}: {error}; {expected}", shown_path(path)))
        };
        let text = std::fs::read_to_string(path).map_err(|error| refused(&error))?;
        put(&text, "beam", "").ok_or_else(|| refused(&"has no marks"))
    };
    let text = page.map(read).transpose()?;
    let rows = beam_table().map_err(Failure::input)?;
    let table = beam_table::text(&rows);
    if let (Some(path), Some(text)) = (page, text) {
        let filled = put(&text, "beam", &table).unwrap_or(text);
        write_file(path, filled.as_bytes()).map_err(Failure::input)?;
    }
    if let Some(path) = figure {
        write_file(path, beam_table::svg(&rows).as_bytes()).map_err(Failure::input)?;
    }
    match json {
        true => println!("{}", serde_json::to_string_pretty(&rows).map_err(Failure::input)?),
        false => print!("{table}"),
    }
    Ok(())
}

/// Prints the pace of a work by the plainest instructions, which a page is compared with.
pub fn run_pace(work: &str, seconds: f64) -> Result<(), Failure> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let pace = best_pace(work, Instructions::Plain, seconds, &clock).map_err(Failure::input)?;
    println!("{pace}");
    Ok(())
}
