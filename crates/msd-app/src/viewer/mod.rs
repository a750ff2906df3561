//! A session and how it is looked at: camera, view settings, the list of scenes, commands.

mod catalogue;
mod command;
mod gesture;
mod viewport;

pub use catalogue::{Catalogue, Entry, catalogue};
pub use command::Command;
pub(crate) use gesture::{Action, Gesture};
pub use viewport::Viewport;

use crate::session::{ErrorNow, Session};
use egui::Rect;
use glam::Vec3;
use msd_core::{Real, Vector};
use msd_render::{Camera, Style};
use msd_run::on;
use msd_run::recording::ENDING;
use msd_run::rescue::Offer;
use msd_scene::Loaded;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The session and how it is looked at. Drawn by [`crate::panel::show`].
#[derive(Debug)]
pub struct Viewer {
    /// What runs.
    pub session: Session,
    /// From where it is seen.
    pub camera: Camera,
    /// What of it is shown.
    pub style: Style,
    /// The scenes of the list.
    pub catalogue: Catalogue,
    /// Whether the camera keeps everything in the middle of the picture.
    pub follow: bool,
    /// Whether bodies are coloured by the estimated error of their particles.
    pub by_error: bool,
    /// Whether the help is open.
    pub help: bool,
    /// Whether the hint for new users is shown: until something was grabbed.
    pub hint: bool,
    /// Whether the user asked to close the window.
    pub quit: bool,
    /// Where recordings go: the folder that the program was started in.
    pub folder: PathBuf,
    /// The part of the window that shows the scene, points.
    pub rect: Rect,
    /// Where widgets are, points: for tests that drive the window from outside.
    pub landmarks: BTreeMap<&'static str, Rect>,
    /// What the mouse does between press and release.
    pub(crate) gesture: Option<Gesture>,
    /// The particle under the pointer.
    pub(crate) hovered: Option<usize>,
    /// Whether the scene is to be brought into view once the size of the window is known.
    unframed: bool,
    /// The scene that is not in the catalogue: of a file or a mesh.
    opened: Option<Loaded>,
    /// The entry of the catalogue that runs; `None` for the opened one.
    current: Option<usize>,
    /// Where the camera was left looking, and how far beside everything the user moved it.
    aimed: Vec3,
    beside: Vec3,
}

/// Whether a scene is shown with its springs, coloured by strain, unless the user says otherwise:
/// in the flat squares the springs are what there is to see.
pub fn shows_springs(name: &str) -> bool {
    matches!(name, "square" | "square4")
}

/// How soon the camera follows, seconds.
const FOLLOW_TIME: f64 = 0.2;

/// A scene that is so many times as large as at its start has blown up.
const DEBRIS: f64 = 10.0;

impl Viewer {
    /// Looks at a scene.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn new(loaded: Loaded, catalogue: Catalogue) -> Result<Self, msd_core::Error> {
        // By the title too: a file may have the name of a built-in scene.
        let is_loaded =
            |entry: &Entry| (entry.name, entry.title) == (&*loaded.name, &*loaded.title);
        // A saved run of a built-in scene is another scene: one may return to it.
        let listed = catalogue.entries.iter().position(is_loaded);
        let current = listed.filter(|_| loaded.progress.is_none());
        let springs = shows_springs(&loaded.name);
        Ok(Viewer {
            opened: current.is_none().then(|| loaded.clone()),
            current,
            session: Session::new(loaded)?,
            camera: Camera::default(),
            style: Style { legend: false, springs, ..Style::default() },
            catalogue,
            follow: true,
            by_error: false,
            help: false,
            hint: true,
            quit: false,
            folder: PathBuf::new(),
            rect: Rect::ZERO,
            landmarks: BTreeMap::new(),
            gesture: None,
            hovered: None,
            unframed: true,
            aimed: Vec3::ZERO,
            beside: Vec3::ZERO,
        })
    }

    /// The camera and where its picture is.
    pub fn viewport(&self) -> Viewport {
        Viewport { camera: self.camera, rect: self.rect }
    }

    /// The name of the 3D view among egui's widgets.
    pub(crate) fn view_id() -> egui::Id {
        egui::Id::unique("view")
    }

    /// Does what a key or a button asks for.
    pub fn command(&mut self, command: Command) {
        let session = &mut self.session;
        match command {
            Command::TogglePause => session.toggle_pause(),
            Command::StepForward => session.step_forward(),
            Command::StepBack => {
                session.step_back();
            }
            Command::Restart => self.restart(),
            Command::Freeze => session.freeze(),
            Command::Record => self.record(),
            Command::Pin => self.pin(),
            Command::Wireframe => self.style.wireframe = !self.style.wireframe,
            Command::FrameAll => self.frame_all(),
            Command::Scene(index) => self.open_entry(index),
            Command::Escape => self.escape(),
            Command::Help => self.help = !self.help,
            Command::Quit => self.quit = true,
        }
    }

    /// Begins or ends a recording, in a file of a name that is free.
    fn record(&mut self) {
        if self.session.recording().is_some() {
            return self.session.stop_recording();
        }
        let name = &self.session.loaded().name;
        let path = |number: u32| self.folder.join(format!("{name}-{number}.{ENDING}"));
        let free = (1..=u32::MAX).map(path).find(|path| !path.exists());
        if let Some(path) = free {
            self.session.start_recording(&path);
        }
    }

    fn restart(&mut self) {
        self.let_go();
        self.session.restart();
    }

    /// Takes a way out of a run that stopped by itself.
    pub fn take(&mut self, offer: Offer) {
        self.let_go();
        self.session.take(offer);
    }

    /// The error of each particle as a share of the full scale, as far as it is known and to be
    /// shown.
    pub fn shades(&self) -> Option<Vec<f32>> {
        let full = self.error_scale()?;
        let Some(ErrorNow::Known(last)) = self.session.error() else { return None };
        Some(last.error.particles.iter().map(|error| (error / full) as f32).collect())
    }

    /// The error that is shown in full red, metres: that of the particle most wrong, rounded up to
    /// 1, 2 or 5 times a power of ten; `None` while none is shown.
    pub fn error_scale(&self) -> Option<f64> {
        let Some(ErrorNow::Known(last)) = self.session.error() else { return None };
        let worst = last.worst.1;
        let is_shown = self.by_error && worst.is_finite() && last.error.rounding < worst;
        if !is_shown {
            return None;
        }
        let power = 10f64.powf(worst.log10().floor());
        [1.0, 2.0, 5.0, 10.0].map(|part| part * power).into_iter().find(|full| worst <= *full)
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        format!("msd: {}", self.session.loaded().name)
    }

    /// Ends a gesture: what it held may be gone.
    pub(crate) fn let_go(&mut self) {
        self.gesture = None;
        self.hovered = None;
    }

    fn pin(&mut self) {
        let session = &mut self.session;
        let particle = session.held().or(self.hovered).or(session.selected());
        if let Some(particle) = particle {
            session.pin_toggle(particle);
        }
        if session.held().is_none() {
            self.gesture = None;
        }
    }

    fn escape(&mut self) {
        self.let_go();
        self.session.deselect();
        self.help = false;
    }

    /// Opens a scene of the list.
    pub fn open_entry(&mut self, index: usize) {
        let Some(entry) = self.catalogue.entries.get(index) else { return };
        let result = (self.catalogue.open)(entry.name);
        self.open(result, Some(index));
    }

    /// The scene that is not in the catalogue, if one was opened.
    pub fn opened(&self) -> Option<&Loaded> {
        self.opened.as_ref()
    }

    /// The entry of the catalogue that runs; `None` for the opened scene.
    pub fn current(&self) -> Option<usize> {
        self.current
    }

    /// Returns to the scene that is not in the catalogue.
    pub fn reopen(&mut self) {
        if let Some(loaded) = self.opened.clone() {
            self.open(Ok(loaded), None);
        }
    }

    fn open(&mut self, loaded: Result<Loaded, String>, index: Option<usize>) {
        let before = shows_springs(&self.session.loaded().name);
        let result =
            loaded.and_then(|loaded| self.session.open(loaded).map_err(|error| error.to_string()));
        match result {
            Ok(()) => {
                self.current = index;
                let springs = shows_springs(&self.session.loaded().name);
                // What the user chose stays between scenes of the same kind.
                if springs != before {
                    self.style.springs = springs;
                }
                self.let_go();
                self.unframed = true;
                self.frame_once();
            }
            Err(error) => self.session.refuse(Err(error)),
        }
    }

    /// Brings every particle and the ground below into view.
    pub fn frame_all(&mut self) {
        let Some(subject) = self.subject() else { return };
        let aspect = if self.rect.is_positive() { self.rect.aspect_ratio() } else { 1.5 };
        self.camera.frame(subject, aspect);
        // Room for what it is about to do.
        self.camera.zoom(1.35);
        (self.aimed, self.beside) = (self.camera.target, Vec3::ZERO);
    }

    /// The box around every particle and the ground below: low and high corner, metres.
    fn subject(&self) -> Option<(Vec3, Vec3)> {
        let runner = self.session.runner();
        let (mut low, high) =
            on!(runner, simulation => msd_render::bounds(&simulation.snapshot()))?;
        let room = (high - low).max_element().max(1.0);
        if let Some(ground) = self.ground() {
            // Ground far below is left out: the scene would be a dot.
            low.y = low.y.min(ground.max(low.y - room));
        }
        Some((low, high))
    }

    /// The height of the highest level plane, metres.
    fn ground(&self) -> Option<f32> {
        on!(self.session.runner(), simulation => {
            let planes = simulation.model().planes().iter();
            let level = planes.filter(|plane| 0.9 < plane.normal.to_f32().y);
            level.map(|plane| plane.offset.to_f64() as f32).reduce(f32::max)
        })
    }

    /// Brings a new scene into view once the size of the window is known.
    pub(crate) fn frame_once(&mut self) {
        if self.unframed && self.rect.is_positive() {
            self.unframed = false;
            self.camera = Camera::default();
            self.frame_all();
        }
    }

    /// Lets the camera keep up, once per frame, after the steps; `real` is the wall-clock time of
    /// the frame in seconds.
    ///
    /// It turns to the middle of everything, not only as far as that moved: what was dragged
    /// away comes back into the picture. A camera that the user moved aside stays aside.
    pub fn look(&mut self, real: f64) {
        self.beside += self.camera.target - self.aimed;
        self.aimed = self.camera.target;
        if !self.follow {
            self.beside = Vec3::ZERO;
            return;
        }
        // While something is held the picture stays still.
        if self.session.held().is_some() {
            return;
        }
        let Some((low, high)) = self.subject() else { return };
        // Debris is not followed: what is left is where the rest was.
        let size = on!(self.session.runner(), simulation => simulation.model().size());
        if DEBRIS * size < f64::from((high - low).max_element()) {
            return;
        }
        let way = (low + high) * 0.5 + self.beside - self.camera.target;
        let part = way * (1.0 - (-real / FOLLOW_TIME).exp()) as f32;
        if part.is_finite() {
            self.camera.target += part;
            self.aimed = self.camera.target;
        }
    }
}
