//! Pictures of runs as arrays, PNGs and films.

use super::Picture;
use super::device::{self, draw_on};
use crate::errors::{error, refused};
use crate::run::Simulation;
use crate::run::lock::Shared;
use msd_film::{About, Kind, Seen, Shot, Sighting, begin, usual_colours, write_png};
use msd_render::{Image, Offscreen, Quantity, RenderError, Style};
use msd_run::{Runner, on};
use msd_scene::{Sight, Viewpoint};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::Path;

/// The most frames of a film, as on the command line.
const MOST: u64 = 1_000_000;

impl Picture<'_, '_> {
    /// The shot of a scene of this name.
    fn shot(&self, py: Python<'_>, name: &str) -> PyResult<Shot> {
        let (mut camera, mut angles) = (None, None);
        if let Some(given) = self.camera {
            let wrong = |reason: String| refused(py, format!("camera {reason}; or (yaw, pitch)"));
            match given.extract::<String>() {
                Ok(name) => camera = Some(name.parse::<Sight>().map_err(wrong)?),
                Err(_) => {
                    let must = "must be a side or (yaw, pitch), degrees";
                    let wrong = |_| refused(py, format!("camera is {given}; it {must}"));
                    angles = Some(given.extract::<[f64; 2]>().map_err(wrong)?);
                }
            }
        }
        let side = |side| u32::try_from(side).unwrap_or(u32::MAX);
        Ok(Shot {
            size: self.size.map(side),
            camera,
            yaw_deg: angles.map(|[yaw, _]| yaw),
            pitch_deg: angles.map(|[_, pitch]| pitch),
            style: Style {
                colour_by: self.quantity(py)?.or(usual_colours(name)),
                sky: self.background,
                planes: self.background,
                ..Style::default()
            },
            lasting: 0.0,
        })
    }

    /// Returns the quantity of the colours.
    fn quantity(&self, py: Python<'_>) -> PyResult<Option<Quantity>> {
        let Some(name) = self.colour else { return Ok(None) };
        let known = || Quantity::ALL.into_iter().filter(|&quantity| quantity != Quantity::Error);
        let found = known().find(|quantity| quantity.name() == name);
        found.map(Some).ok_or_else(|| {
            let names: Vec<&str> = known().map(Quantity::name).collect();
            refused(py, format!("colour is {name}; it must be one of {}", names.join(", ")))
        })
    }
}

fn render(
    runner: &Runner,
    screen: &mut Offscreen,
    view: &msd_render::View,
) -> Result<Image, RenderError> {
    on!(runner, simulation => screen.render(&simulation.snapshot(), view))
}

fn draw(py: Python<'_>, shared: &Shared, shot: &Shot, author: Viewpoint) -> PyResult<Image> {
    draw_on(py, shot.size, |screen| {
        let drawn = shared.work(py, |runner| {
            let mut sighting = Sighting::new(shot, runner, author);
            sighting.frame(runner);
            render(runner, screen, &sighting.view(0.0))
        })?;
        drawn.map_err(|reason| error(py, reason))
    })
}

/// Returns whether pictures can be drawn.
pub fn can_draw(py: Python<'_>) -> bool {
    device::open(py).is_ok()
}

/// A picture of the current state of a run: an array of (height, width, 4).
pub fn picture<'py>(
    py: Python<'py>,
    run: &Simulation,
    look: Picture<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let shot = look.shot(py, &run.name)?;
    let Image { width, height, rgba } = draw(py, &run.shared, &shot, run.camera)?;
    let shape = [height as usize, width as usize, 4];
    Ok(PyArray1::from_vec(py, rgba).reshape(shape)?.into_any())
}

/// A picture of a run, of a scene of this name and viewpoint, as the bytes of a PNG; nothing where
/// no picture can be drawn.
pub fn png<'py>(
    py: Python<'py>,
    shared: &Shared,
    (name, author): (&str, Viewpoint),
) -> Option<Bound<'py, PyBytes>> {
    let look = Picture { size: [640, 480], camera: None, colour: None, background: true };
    let image = draw(py, shared, &look.shot(py, name).ok()?, author).ok()?;
    let mut bytes = Vec::new();
    write_png(&mut bytes, &image).ok()?;
    Some(PyBytes::new(py, &bytes))
}

/// Runs ahead on a copy and returns what the frames show, up to the first step that fails.
fn look_ahead(
    py: Python<'_>,
    run: &Simulation,
    (frames, every): (u64, u64),
    colour_by: Option<Quantity>,
) -> PyResult<Seen> {
    let (ahead, mut seen) = (run.copy(py)?, Seen::default());
    for frame in 0..=frames {
        if 0 < frame && ahead.try_advance(py, every)?.is_err() {
            break;
        }
        ahead.work(py, |runner| seen.look(runner, colour_by))?;
    }
    Ok(seen)
}

/// Writes a film of a run, which takes its steps.
pub fn film(
    py: Python<'_>,
    run: &Simulation,
    (frames, every): (u64, u64),
    path: &Path,
    look: Picture<'_, '_>,
) -> PyResult<()> {
    let refuse = |reason: String| refused(py, reason);
    if MOST <= frames {
        return Err(refuse(format!("frames is {frames}; it must be below {MOST}")));
    }
    if every == 0 || frames.checked_mul(every).is_none() {
        return Err(refuse(format!("every is {every}; it must be from 1 to 2^64 / frames")));
    }
    let kind = Kind::of(path, true).map_err(refuse)?;
    let interval = run.work(py, |runner| runner.settings().step)? * every as f64;
    let shot = look.shot(py, &run.name)?;
    let shot = Shot { lasting: (frames + 1) as f64 * interval, ..shot };
    draw_on(py, shot.size, |screen| {
        let about = About { size: shot.size, every: interval, is_open: !look.background };
        let mut film = begin(path, &kind, about).map_err(refuse)?;
        let seen = look_ahead(py, run, (frames, every), shot.style.colour_by)?;
        let sighting = run.work(py, |runner| {
            let mut sighting = Sighting::new(&shot, runner, run.camera);
            sighting.frame_film(seen);
            sighting
        })?;
        let mut shoot = || -> PyResult<()> {
            for frame in 0..=frames {
                if 0 < frame {
                    run.advance(py, every)?;
                }
                let view = sighting.view(frame as f64 / (frames + 1) as f64);
                let image = run.work(py, |runner| render(runner, screen, &view))?;
                let image = image.map_err(|reason| error(py, reason))?;
                py.detach(|| film.add(image)).map_err(refuse)?;
            }
            Ok(())
        };
        let shot = shoot();
        py.detach(|| film.finish()).map_err(refuse)?;
        shot
    })
}
