//! A film of the last seconds: the states of the history, rendered and written by a thread while
//! the run continues.

use super::Viewer;
use super::files::{free, shown};
use crate::background::lower_priority;
use glam::Vec3;
use msd_film::{About, Kind, begin, open_gpu};
use msd_render::{Offscreen, Style, View, bounds};
use msd_run::{Moment, Runner, on};
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;

/// Time between two frames of a film, seconds, unless steps are longer.
const EVERY: f64 = 1.0 / 30.0;
/// Largest side of a film, pixels.
const LONGEST: f32 = 1920.0;

/// Format of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// An animated WebP.
    WebP,
    /// A PNG per frame, in a folder, lossless.
    Png,
    /// A film encoded by ffmpeg.
    Mp4,
    /// A PNG of the current view.
    Picture,
}

/// A film in progress.
#[derive(Debug)]
pub struct Filming {
    name: String,
    frames: usize,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<Result<(), String>>>,
}

#[derive(Debug, Default)]
struct Progress {
    done: AtomicUsize,
    is_cancelled: AtomicBool,
}

impl Filming {
    /// Returns the number of written frames, and of all.
    pub fn progress(&self) -> [usize; 2] {
        [self.progress.done.load(Ordering::Relaxed), self.frames]
    }

    /// Cancels the film at the next frame.
    pub fn cancel(&self) {
        self.progress.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns the result in a line for the user; `None` while the film is in progress.
    fn end(&mut self) -> Option<String> {
        let done = self.thread.take_if(|thread| thread.is_finished())?.join();
        let [frames, _] = self.progress();
        let is_cancelled = self.progress.is_cancelled.load(Ordering::Relaxed);
        Some(match done {
            Ok(Ok(())) if is_cancelled => "the film was cancelled".to_owned(),
            Ok(Ok(())) if frames == 1 => format!("saved {}", self.name),
            Ok(Ok(())) => format!("saved {}, {frames} frames", self.name),
            Ok(Err(why)) => why,
            Err(_) => format!("{}: the film could not be written", self.name),
        })
    }
}

impl Drop for Filming {
    /// A cancelled film leaves no partial file.
    fn drop(&mut self) {
        self.cancel();
        self.thread.take().map(JoinHandle::join);
    }
}

/// Content and format of a film.
struct Reel {
    runner: Runner,
    moments: Vec<Moment>,
    view: View,
    /// Offset of the target from the centre of the bodies, if the camera follows them.
    beside: Option<Vec3>,
    about: About,
    path: PathBuf,
    kind: Kind,
}

impl Reel {
    /// Renders and writes frame by frame.
    fn shoot(mut self, progress: &Progress) -> Result<(), String> {
        let told = |error: &dyn Display| error.to_string();
        let [width, height] = self.about.size;
        let mut film = begin(&self.path, &self.kind, self.about)?;
        let gpu = open_gpu().map_err(|error| told(&error))?;
        let mut screen = Offscreen::new(&gpu, width, height).map_err(|error| told(&error))?;
        for moment in std::mem::take(&mut self.moments) {
            if progress.is_cancelled.load(Ordering::Relaxed) {
                return Ok(());
            }
            self.runner.go_back(&moment).map_err(|error| told(&error))?;
            let image = on!(&self.runner, simulation => {
                let snapshot = simulation.snapshot();
                if let Some((beside, (low, high))) = self.beside.zip(bounds(&snapshot)) {
                    self.view.camera.target = (low + high) * 0.5 + beside;
                }
                screen.render(&snapshot, &self.view)
            });
            film.add(image.map_err(|error| told(&error))?)?;
            progress.done.fetch_add(1, Ordering::Relaxed);
        }
        film.finish()
    }
}

impl Viewer {
    /// Begins a film of the states of the history with the current view, in a file with a free
    /// name.
    pub fn film(&mut self, format: FilmFormat) {
        if self.filming.is_none() {
            match self.begin_film(format) {
                Ok(filming) => self.filming = Some(filming),
                Err(why) => self.note = Some(why),
            }
        }
    }

    fn begin_film(&self, format: FilmFormat) -> Result<Filming, String> {
        let name = &self.session.loaded().name;
        let path = match format {
            FilmFormat::WebP => free(&self.folder, name, "webp"),
            FilmFormat::Mp4 => free(&self.folder, name, "mp4"),
            FilmFormat::Picture => free(&self.folder, name, "png"),
            FilmFormat::Png => {
                let folder = free(&self.folder, name, "frames");
                let made = std::fs::create_dir(&folder);
                made.map_err(|error| format!("{}: cannot be created: {error}", shown(&folder)))?;
                folder.join("%04d.png")
            }
        };
        let is_film = format != FilmFormat::Picture;
        let kind = Kind::of(&path, is_film)?;
        let step = self.session.runner().settings().step;
        let stride = (EVERY / step).round().max(1.0) as usize;
        let size = self.viewport().rect.size();
        let size = size * (LONGEST / size.max_elem()).min(1.0);
        let about = About {
            size: [size.x, size.y].map(|side| side.round().max(2.0) as u32),
            every: stride as f64 * step,
            is_open: false,
        };
        let reel = Reel {
            runner: self.session.runner().clone(),
            moments: match is_film {
                true => self.session.states(stride),
                false => vec![self.session.runner().moment()],
            },
            // The film has no panels, so the legend is part of the picture.
            view: View { camera: self.camera, style: Style { legend: true, ..self.style } },
            beside: self.aim.follow.then(|| self.beside_middle()),
            about,
            path: path.clone(),
            kind,
        };
        let (frames, progress) = (reel.moments.len(), Arc::new(Progress::default()));
        let shared = progress.clone();
        let thread = std::thread::Builder::new().name("film".into()).spawn(move || {
            lower_priority();
            reel.shoot(&shared)
        });
        let thread = thread.map_err(|error| format!("cannot create a film thread: {error}"))?;
        Ok(Filming { name: shown(&path), frames, progress, thread: Some(thread) })
    }

    /// Shows the result of a finished film; returns whether one is in progress.
    pub fn follow_film(&mut self) -> bool {
        if let Some(told) = self.filming.as_mut().and_then(Filming::end) {
            (self.note, self.filming) = (Some(told), None);
        }
        self.filming.is_some()
    }
}
