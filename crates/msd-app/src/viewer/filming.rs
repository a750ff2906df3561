//! A film of the last seconds: the states that one can look back to, drawn and written on a thread
//! of its own, while the run goes on.

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

/// From one frame of a film to the next, seconds, unless steps are longer.
const EVERY: f64 = 1.0 / 30.0;
/// The longest side of a film, pixels.
const LONGEST: f32 = 1920.0;

/// What a film is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// An animated WebP.
    WebP,
    /// A PNG per frame, in a folder, without loss.
    Png,
    /// What ffmpeg makes of them.
    Mp4,
    /// A PNG of what is seen now.
    Picture,
}

/// A film that is being written.
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
    /// Frames that are written, and all of them.
    pub fn progress(&self) -> [usize; 2] {
        [self.progress.done.load(Ordering::Relaxed), self.frames]
    }

    /// Ends it at the next frame.
    pub fn cancel(&self) {
        self.progress.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// What came of it, in a line for the user; nothing while it is being written.
    fn end(&mut self) -> Option<String> {
        let done = self.thread.take_if(|thread| thread.is_finished())?.join();
        let [frames, _] = self.progress();
        let is_cancelled = self.progress.is_cancelled.load(Ordering::Relaxed);
        Some(match done {
            Ok(Ok(())) if is_cancelled => "the film was cancelled".to_owned(),
            Ok(Ok(())) if frames == 1 => format!("picture: {}", self.name),
            Ok(Ok(())) => format!("filmed: {}, {frames} frames", self.name),
            Ok(Err(why)) => why,
            Err(_) => format!("{}: the film came to a bad end", self.name),
        })
    }
}

impl Drop for Filming {
    /// No part of a file is left behind.
    fn drop(&mut self) {
        self.cancel();
        self.thread.take().map(JoinHandle::join);
    }
}

/// What is to be filmed, and how.
struct Reel {
    runner: Runner,
    moments: Vec<Moment>,
    view: View,
    /// How far beside the middle of everything the camera looks, where it follows that.
    beside: Option<Vec3>,
    about: About,
    path: PathBuf,
    kind: Kind,
}

impl Reel {
    /// Draws and writes frame by frame.
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
    /// Begins a film of the states that one can look back to, as they are looked at now, in a file
    /// of a name that is free.
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
                made.map_err(|error| format!("{}: cannot be made: {error}", shown(&folder)))?;
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
            // The legend is in the pictures, as they have no panels.
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
        let thread = thread.map_err(|error| format!("no thread for a film: {error}"))?;
        Ok(Filming { name: shown(&path), frames, progress, thread: Some(thread) })
    }

    /// Tells of a film that has ended; whether one is still being written.
    pub fn follow_film(&mut self) -> bool {
        if let Some(told) = self.filming.as_mut().and_then(Filming::end) {
            (self.note, self.filming) = (Some(told), None);
        }
        self.filming.is_some()
    }
}
