//! Pictures and films, of builds with the feature `pictures`.

#[cfg(feature = "pictures")]
mod device;
#[cfg(feature = "pictures")]
mod drawing;
#[cfg(not(feature = "pictures"))]
#[path = "missing.rs"]
mod drawing;

pub use drawing::{can_draw, picture, png};

use crate::options::Count;
use crate::run::Simulation;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The look of a picture or a film: the keywords of both.
#[cfg_attr(not(feature = "pictures"), expect(dead_code, reason = "nothing is drawn"))]
pub struct Picture<'a, 'py> {
    /// Width and height, pixels.
    pub size: [u64; 2],
    /// A side by its name, or azimuth and elevation, degrees.
    pub camera: Option<&'a Bound<'py, PyAny>>,
    /// The name of a quantity.
    pub colour: Option<&'a str>,
    /// Draws sky, ground and walls.
    pub background: bool,
}

/// Film a run: pictures now and after each of `frames` times `every` steps, which the run takes.
///
/// The name `path` ends in .webp or .gif, in .mp4, .webm, .mov or .mkv, which take ffmpeg, or is
/// that of a .png per frame with its number, such as film/%04d.png. The other keywords are those of
/// `Simulation.picture`; `camera` may also be "orbit", a turn about the scene, or
/// "orbit:DEGREES" per second. A step that fails raises StepError; the frames before it are kept.
/// Ctrl-C ends the film; the run keeps the steps taken.
#[pyfunction]
#[pyo3(signature = (run, frames, path, *, every=Count::Of(1), width=Count::Of(640),
    height=Count::Of(480), camera=None, colour=None, background=true),
    text_signature = "(run, frames, path, *, every=1, width=640, height=480, camera=None, \
                      colour=None, background=True)")]
pub fn film(
    py: Python<'_>,
    run: &Bound<'_, Simulation>,
    frames: Count,
    path: PathBuf,
    every: Count,
    width: Count,
    height: Count,
    camera: Option<&Bound<'_, PyAny>>,
    colour: Option<&str>,
    background: bool,
) -> PyResult<()> {
    let size = [width.get(py, "width")?, height.get(py, "height")?];
    let look = Picture { size, camera, colour, background };
    let counts = (frames.get(py, "frames")?, every.get(py, "every")?);
    drawing::film(py, run.get(), counts, &path, look)
}
