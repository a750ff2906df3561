//! `msd render`: a picture or a film of a scene, without a display.

use crate::cli::arguments::{ColourBy, RenderArguments};
use crate::cli::failure::{Failure, hush, say, say_json};
use crate::cli::places::{Places, make_folder};
use crate::cli::run::follow;
use crate::cli::run::prepare::{Prepared, prepare};
use crate::cli::steps::{Interrupt, Moments, Steps};
use msd_film::{About, Kind, Seen, Shot, Sighting, begin, open_gpu, seen, usual_colours};
use msd_render::{Offscreen, Quantity, Style};
use msd_run::on;
use msd_scene::{SetKeys, set_keys, shown_path};
use msd_study::quantity::quantity;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Result of a rendering; the keys of `--json`.
#[derive(Debug, Serialize)]
struct RenderReport {
    scene: String,
    set: SetKeys,
    /// The file, or that of the first frame.
    file: String,
    frames: usize,
    size: [u32; 2],
    /// Time from one frame to the next, seconds; null for a picture.
    every: Option<f64>,
    /// Time of the last frame from the start of the scene, seconds.
    time: f64,
    diverged: bool,
    interrupted: bool,
    notes: Vec<String>,
    warnings: Vec<String>,
}

/// Runs a scene and renders one picture at its end, or the frames of a film.
pub fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let RenderArguments { scene, set, solver, time, size, .. } = arguments;
    hush(arguments.quiet);
    let film = arguments.frames;
    let moments = film.unwrap_or(Moments { from: *time, to: *time, every: 1.0 });
    let option = if film.is_some() { "--frames" } else { "--time" };
    let mut prepared = prepare((scene, set), solver, (option, moments.to))?;
    let interrupt = Interrupt::catch();
    let steps = steps(film, &mut prepared)?;
    let ending = if film.is_some() { "webp" } else { "png" };
    let path = arguments.out.clone();
    let path = path.unwrap_or_else(|| PathBuf::from(format!("{}.{ending}", prepared.name)));
    let kind = Kind::of(&path, film.is_some()).map_err(Failure::input)?;
    check_places(arguments, &prepared, (&path, &kind, steps.len()))?;
    let about =
        About { size: *size, every: moments.every, is_open: arguments.background.is_some() };
    let mut output = begin(&path, &kind, about).map_err(Failure::input)?;
    // Requested before the run: without a driver, or for a picture beyond its limits, the steps
    // would be in vain.
    let gpu = open_gpu().map_err(Failure::input)?;
    let [width, height] = *size;
    let mut screen = Offscreen::new(&gpu, width, height).map_err(Failure::input)?;
    let shot = shot(arguments, &prepared.name, steps.len());
    let mut look = Sighting::new(&shot, &prepared.runner, prepared.camera);
    if film.is_some() {
        look.frame_film(look_ahead(&prepared, shot.style.colour_by, (&steps, &interrupt)));
    }
    let last = steps.len();
    let (frames, ended) = follow(&mut prepared, (&steps, &interrupt), |runner, frame| {
        if film.is_none() {
            look.frame(runner);
        }
        let view = look.view(frame as f64 / last as f64);
        let image = on!(runner, simulation => screen.render(&simulation.snapshot(), &view));
        output.add(image.map_err(Failure::input)?).map_err(Failure::input)
    })?;
    output.finish().map_err(Failure::input)?;
    let interrupted = ended.as_ref().is_some_and(Failure::is_interruption);
    let report = RenderReport {
        scene: prepared.name,
        set: set_keys(&set.set),
        file: shown_path(&kind.path(&path, 0)),
        frames,
        size: *size,
        every: film.map(|film| film.every),
        time: prepared.runner.time(),
        diverged: ended.is_some() && !interrupted,
        interrupted,
        notes: prepared.notes,
        warnings: prepared.warnings,
    };
    let said = match (arguments.json, arguments.quiet) {
        (true, _) => say_json(&report),
        (false, true) => Ok(()),
        (false, false) if frames == 0 => Ok(()),
        (false, false) => say(&line(&report, &path)),
    };
    Failure::all(said.err().into_iter().chain(ended))
}

/// The picture or the film that the command line asks for.
fn shot(arguments: &RenderArguments, name: &str, frames: usize) -> Shot {
    let is_open = arguments.background.is_some();
    let quantity = |colour_by| match colour_by {
        ColourBy::Strain => Quantity::Strain,
        ColourBy::Force => Quantity::Force,
        ColourBy::Energy => Quantity::Energy,
        ColourBy::Speed => Quantity::Speed,
    };
    let style = Style {
        surfaces: !arguments.no_surfaces,
        wireframe: arguments.wireframe,
        colour_by: arguments.colour_by.map(quantity).or(usual_colours(name)),
        full_scale: arguments.full_scale.map(|full| full as f32),
        legend: !arguments.no_legend,
        particles: arguments.particles,
        sky: !is_open,
        planes: !is_open,
        ..Style::default()
    };
    let RenderArguments { size, camera, yaw_deg, pitch_deg, .. } = *arguments;
    let lasting = arguments.frames.map_or(0.0, |film| frames as f64 * film.every);
    Shot { size, camera, yaw_deg, pitch_deg, style, lasting }
}

/// Runs ahead and returns the extent and the largest colour value of a film.
fn look_ahead(
    prepared: &Prepared,
    colour_by: Option<Quantity>,
    (steps, interrupt): (&[u64], &Interrupt),
) -> Seen {
    let mut progress = Steps::new(steps.last().copied().unwrap_or(0), "computing the view");
    seen(prepared.runner.clone(), (steps, colour_by), |taken| {
        progress.tell(taken);
        !interrupt.is_asked()
    })
}

/// Returns the step number of each frame. Warns if frames fall between steps.
fn steps(film: Option<Moments>, prepared: &mut Prepared) -> Result<Vec<u64>, Failure> {
    let Some(film) = film else { return Ok(vec![prepared.steps]) };
    let settings = prepared.runner.settings();
    let (steps, is_between) = film.steps(settings, "--frames")?;
    if is_between {
        prepared.add_warning(Moments::warning(settings, "--frames"));
    }
    Ok(steps)
}

fn line(report: &RenderReport, path: &Path) -> String {
    let RenderReport { scene, frames, size: [width, height], every, time, .. } = report;
    let (path, time) = (shown_path(path), quantity(*time, "s"));
    match every {
        None => format!("{path}: {scene} after {time}, {width}x{height} pixels"),
        Some(every) => {
            let every = quantity(*every, "s");
            let film = format!("{frames} frames of {scene}, {every} apart, to {time}");
            format!("{path}: {film}, {width}x{height} pixels")
        }
    }
}

fn check_places(
    arguments: &RenderArguments,
    prepared: &Prepared,
    (path, kind, frames): (&Path, &Kind, usize),
) -> Result<(), Failure> {
    let mut places = Places::of(&prepared.files, arguments.solver.from.as_deref());
    if !matches!(kind, Kind::Numbered(..)) {
        return places.write("--out", path);
    }
    let frame = |frame| kind.path(path, frame);
    if let Some(folder) = frame(0).parent().filter(|folder| *folder != Path::new("")) {
        make_folder(folder)?;
    }
    (0..frames).try_for_each(|number| places.write("--out", &frame(number)))
}
