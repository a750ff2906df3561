//! A session and its view: camera, style, the list of scenes, commands.

mod catalogue;
mod viewport;
mod sides;
mod gesture;
mod shown;
mod command;
mod preferences;
mod guide;
mod gallery;
mod scene_text;
mod files;
mod look;
#[cfg(not(target_arch = "wasm32"))]
mod filming;

pub use catalogue::{Catalogue, Entry, Lessons, catalogue};
pub use command::Command;
#[cfg(not(target_arch = "wasm32"))]
pub use filming::{FilmFormat, Filming};
pub use gallery::{Gallery, Picture};
pub(crate) use gesture::{Action, Gesture};
pub use gesture::{PointerState, Tool};
pub use guide::{Guide, GuideStep};
pub use look::Aim;
pub use preferences::{Outlook, Preferences};
pub use sides::Side;
pub use viewport::{Sharpness, Viewport};

use crate::link::{Changes, Link, LinkError, Look, OwnScene};
use crate::session::{ErrorNow, ErrorReading, Session};
use egui::Rect;
use files::{FilesRead, SceneSource};
use glam::Vec3;
use msd_core::Settings;
use msd_film::usual_colours;
use msd_render::{Camera, Quality, Quantity, Scale, Style};
use msd_run::on;
use msd_run::rescue::Offer;
use msd_scene::Loaded;
use msd_scene::schema::OrAuto;
use shown::{show_bits, shown_bits};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The session and its view. Drawn by [`crate::panel::show`].
#[derive(Debug)]
pub struct Viewer {
    /// The running scene.
    pub session: Session,
    /// Its source.
    source: SceneSource,
    /// The camera.
    pub camera: Camera,
    /// Target of the camera.
    pub aim: Aim,
    /// Visible parts and colours.
    pub style: Style,
    /// Quality of the graphics, limited by the adapter.
    pub quality: Quality,
    /// Whether the view has half the resolution.
    pub sharpness: Sharpness,
    /// The scenes of the list.
    pub catalogue: Catalogue,
    /// State of the panels and overlays.
    pub layout: Layout,
    /// State of the pointer over the view.
    pub hand: PointerState,
    /// Settings that persist between sessions.
    pub preferences: Preferences,
    /// The film in progress.
    #[cfg(not(target_arch = "wasm32"))]
    pub filming: Option<Filming>,
    /// Requests to the system.
    pub wishes: Wishes,
    /// Last message for the user.
    pub note: Option<String>,
    /// Folder of recordings: the one in which the program was started.
    pub folder: PathBuf,
}

/// State of the panels and overlays.
#[derive(Debug)]
pub struct Layout {
    /// Whether a twin is beside the run, not a ghost over it.
    pub side_by_side: bool,
    /// Whether the panels are shown.
    pub panels: bool,
    /// The panel on a small screen, an index into the list of [`crate::panel`].
    pub(crate) sheet: usize,
    /// Whether the input is by touch.
    pub by_touch: bool,
    /// Whether the page around the window has buttons, which the window then omits.
    pub in_page: bool,
    /// Whether the panels are light.
    pub light: bool,
    /// Whether the controls of looks are open.
    pub looks: bool,
    /// Whether the help is open.
    pub help: bool,
    /// Whether the hint for new users is visible: until the first grab.
    pub hint: bool,
    /// The tour, if it is open.
    pub guide: Option<Guide>,
    /// The gallery, if it is open.
    pub gallery: Option<Gallery>,
    /// The lessons, if they are open.
    pub lessons: Option<Lessons>,
    /// Whether the scene fills the window, without panels.
    pub bare: bool,
    /// Whether the right panel is longer than the window.
    pub(crate) is_folded: bool,
    /// The area of the 3D view, points.
    pub rect: Rect,
    /// Areas of widgets, points, for tests that control the window from outside.
    pub landmarks: BTreeMap<&'static str, Rect>,
}

impl Default for Layout {
    fn default() -> Self {
        Layout {
            side_by_side: false,
            panels: true,
            sheet: 0,
            by_touch: false,
            in_page: false,
            light: false,
            looks: false,
            help: false,
            hint: true,
            guide: None,
            gallery: None,
            lessons: None,
            bare: false,
            is_folded: false,
            rect: Rect::ZERO,
            landmarks: BTreeMap::new(),
        }
    }
}

/// Requests to the system.
#[derive(Debug, Default)]
pub struct Wishes {
    /// A text for the clipboard.
    pub clipboard: Option<String>,
    /// Whether the window is in full screen.
    pub full_screen: bool,
    /// Whether the user has requested to close the window.
    pub quit: bool,
}

/// Angle by which a key turns the camera, radians, and exponent by which it zooms.
const TURN: f32 = 0.1;

impl Viewer {
    /// Creates a viewer of a scene.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn new(loaded: Loaded, catalogue: Catalogue) -> Result<Self, msd_core::Error> {
        // By title too: a file may have the name of a built-in scene.
        let is_built_in = loaded.files.is_empty();
        let is_loaded = |entry: &Entry| {
            is_built_in && (entry.name, entry.title) == (&*loaded.name, &*loaded.title)
        };
        // A saved run of a built-in scene counts as another scene, to which the user can return.
        let listed = catalogue.entries.iter().position(is_loaded);
        let current = listed.filter(|_| loaded.progress.is_none());
        let colour_by = usual_colours(&loaded.name);
        let lessons = Lessons::of(&loaded);
        Ok(Viewer {
            source: SceneSource {
                opened: current.is_none().then(|| loaded.clone()),
                own: None,
                current,
                watch: FilesRead::of(&loaded.files),
            },
            session: Session::new(loaded)?,
            camera: Camera::default(),
            aim: Aim::default(),
            style: Style { legend: false, colour_by, ..Style::default() },
            quality: Quality::Full,
            sharpness: Sharpness::default(),
            catalogue,
            layout: Layout { lessons, ..Layout::default() },
            hand: PointerState::default(),
            preferences: Preferences::default(),
            #[cfg(not(target_arch = "wasm32"))]
            filming: None,
            wishes: Wishes::default(),
            note: None,
            folder: PathBuf::new(),
        })
    }

    /// Returns egui's id of the 3D view.
    pub(crate) fn view_id() -> egui::Id {
        egui::Id::unique("view")
    }

    /// Returns whether a control takes the keys: the gallery blocks the shortcuts of the scene.
    pub fn takes_keys(&self, context: &egui::Context) -> bool {
        context.egui_wants_keyboard_input() || self.layout.gallery.is_some()
    }

    /// Performs the command of a key or a button.
    pub fn command(&mut self, command: Command) {
        let session = &mut self.session;
        match command {
            Command::TogglePause => session.toggle_pause(),
            Command::StepForward => session.step_forward(),
            Command::StepBack => {
                session.step_back();
            }
            Command::Undo => {
                self.let_go();
                self.session.undo();
            }
            Command::Redo => {
                self.let_go();
                self.session.redo();
            }
            Command::Restart => match self.is_edited() {
                true => self.reload(),
                false => self.restart(),
            },
            Command::Reload => self.reload(),
            Command::Freeze => session.freeze(),
            Command::Record => self.record(),
            #[cfg(not(target_arch = "wasm32"))]
            Command::Picture => self.film(FilmFormat::Picture),
            #[cfg(target_arch = "wasm32")]
            Command::Picture => {}
            Command::Pin => self.pin(),
            Command::Wireframe => self.style.wireframe = !self.style.wireframe,
            Command::FrameAll => self.frame_all(),
            Command::Turn(right, up) => {
                let [right, up] = [right, up].map(|steps| f32::from(steps) * TURN);
                self.camera.orbit(-right, up);
            }
            Command::Closer(steps) => self.camera.zoom((-f32::from(steps) * TURN).exp()),
            Command::Scene(index) => _ = self.open_entry(index),
            Command::Tool(tool) => {
                self.hand.tool = if self.hand.tool == tool { Tool::Grab } else { tool };
            }
            Command::Escape => self.escape(),
            Command::Open => {
                let entries = &self.catalogue.entries;
                self.layout.gallery = match self.layout.gallery.take() {
                    Some(_) => None,
                    None => Some(Gallery::open(entries, &self.folder)),
                };
            }
            Command::SaveRun | Command::SaveScene | Command::CopyCommand => {
                self.file_command(command);
            }
            Command::Lessons => self.toggle_lessons(),
            // The tour refers to controls in the panels.
            Command::Guide => {
                (self.layout.guide, self.layout.panels) = (Some(Guide::default()), true)
            }
            Command::FullScreen => self.wishes.full_screen = !self.wishes.full_screen,
            Command::Panels => self.layout.panels = !self.layout.panels,
            Command::Help => self.layout.help = !self.layout.help,
            Command::Quit => self.wishes.quit = true,
        }
    }

    fn restart(&mut self) {
        self.let_go();
        self.style.full_scale = None;
        self.session.restart();
    }

    /// Shows the state `back` steps before the latest one.
    pub fn look_back(&mut self, back: usize) {
        self.let_go();
        self.session.look_back(back);
    }

    /// Applies a recovery option after a divergence.
    pub fn take(&mut self, offer: Offer) {
        self.let_go();
        self.session.take(offer);
        self.style.full_scale = None;
    }

    /// Colours by a quantity, or by body. The error switches on its estimate.
    pub fn colour_by(&mut self, quantity: Option<Quantity>) {
        (self.style.colour_by, self.style.full_scale) = (quantity, None);
        if quantity == Some(Quantity::Error) {
            self.session.set_estimating(true);
        }
    }

    /// Returns the colour scale; `None` for the colours of bodies, as until an error is known.
    pub fn scale(&self) -> Option<Scale> {
        let quantity = self.style.colour_by?;
        if quantity == Quantity::Error {
            self.seen_error()?;
        }
        let full = self.style.full_scale.unwrap_or_else(|| quantity.full_scale(0.0));
        Some(Scale { quantity, full })
    }

    /// Sets the end of the scale for the next frame. Within a run it only grows: colours that
    /// flicker between two scales would not be readable.
    pub(crate) fn choose_scale(&mut self) {
        let Some(quantity) = self.style.colour_by else { return };
        let largest = match quantity {
            Quantity::Error => self.seen_error().map_or(0.0, |last| last.worst.1),
            _ => on!(self.session.runner(), simulation => quantity.largest(&simulation.snapshot())),
        };
        if self.style.full_scale.is_none_or(|full| f64::from(full) < largest) && 0.0 < largest {
            self.style.full_scale = Some(quantity.full_scale(largest));
        }
    }

    /// Returns the error of each particle, metres, if it is known and visible.
    pub fn errors(&self) -> Option<impl Iterator<Item = f32>> {
        let last = self.seen_error()?;
        Some(last.error.particles.iter().map(|&error| error as f32))
    }

    /// Returns the coloured error, if it is known and larger than rounding.
    fn seen_error(&self) -> Option<&ErrorReading> {
        let Some(ErrorNow::Known(last)) = self.session.error() else { return None };
        let worst = last.worst.1;
        let is_seen = self.style.colour_by == Some(Quantity::Error)
            && worst.is_finite()
            && last.error.rounding < worst;
        is_seen.then_some(last)
    }

    /// Returns the title of the window.
    pub fn title(&self) -> String {
        format!("msd: {}", self.session.loaded().name)
    }

    /// Returns whether the scene has solids that can be dragged.
    pub(crate) fn has_solids(&self) -> bool {
        let solids = &self.session.loaded().scene.solids;
        solids.iter().any(|solid| solid.shape.reach().is_finite())
    }

    /// Ends a gesture, as its target may no longer exist.
    pub(crate) fn let_go(&mut self) {
        self.hand.gesture = None;
        self.hand.stroke.clear();
        (self.hand.hovered, self.hand.hovered_solid) = (None, None);
    }

    fn pin(&mut self) {
        let session = &mut self.session;
        let particle = session.held().or(self.hand.hovered).or(session.selected());
        if let Some(particle) = particle {
            session.pin_toggle(particle);
        }
        if !session.is_holding() {
            self.hand.gesture = None;
        }
    }

    fn escape(&mut self) {
        self.let_go();
        self.session.deselect();
        self.hand.tool = Tool::Grab;
        (self.note, self.layout.gallery) = (None, None);
        self.layout.help = false;
    }

    /// Opens a scene of the list; returns whether that succeeded.
    pub fn open_entry(&mut self, index: usize) -> bool {
        let entry = self.catalogue.entries.get(index);
        let result = entry.and_then(|entry| (self.catalogue.open)(entry.name));
        result.is_some_and(|result| self.open(result, Some(index)))
    }

    /// Opens a scene of the list, or a file of this name; returns whether that succeeded.
    pub fn open_named(&mut self, name: &str) -> bool {
        match self.catalogue.entries.iter().position(|entry| entry.name == name) {
            Some(index) => self.open_entry(index),
            None => self.open_path(Path::new(name)),
        }
    }

    /// Shows a scene outside the catalogue, and keeps it accessible; returns whether that
    /// succeeded. `own` is its source, if that is not a file on this machine.
    fn show_opened(&mut self, loaded: Loaded, own: Option<Result<OwnScene, String>>) -> bool {
        let kept = loaded.clone();
        let is_shown = self.open(Ok(loaded), None);
        if is_shown {
            (self.source.opened, self.source.own) = (Some(kept), own);
        }
        is_shown
    }

    /// Returns the opened scene outside the catalogue.
    pub fn opened(&self) -> Option<&Loaded> {
        self.source.opened.as_ref()
    }

    /// Returns the running entry of the catalogue; `None` for the opened scene.
    pub fn current(&self) -> Option<usize> {
        self.source.current
    }

    /// Returns to the opened scene.
    pub fn reopen(&mut self) {
        if let Some(loaded) = self.source.opened.clone() {
            self.open(Ok(loaded), None);
        }
    }

    /// Replaces the running scene, unless there is an error; returns whether that succeeded.
    fn open(&mut self, loaded: Result<Loaded, String>, index: Option<usize>) -> bool {
        let before = usual_colours(&self.session.loaded().name);
        self.keep_camera();
        let result =
            loaded.and_then(|loaded| self.session.open(loaded).map_err(|error| error.to_string()));
        match result {
            Ok(()) => {
                self.source.current = index;
                self.source.watch = files::FilesRead::of(&self.session.loaded().files);
                self.note = None;
                self.layout.lessons = Lessons::of(self.session.loaded());
                let usual = usual_colours(&self.session.loaded().name);
                // The user's choice stays between scenes of the same kind.
                let colours = if usual == before { self.style.colour_by } else { usual };
                self.colour_by(colours);
                self.let_go();
                self.aim.unframed = true;
                self.frame_once();
                true
            }
            Err(error) => {
                self.session.refuse(Err(error));
                false
            }
        }
    }

    /// Returns the link to this scene with its current settings and camera, but not its state. The
    /// link contains a scene outside the catalogue.
    ///
    /// # Errors
    /// A line on why a link cannot hold it.
    pub fn link(&self) -> Result<Link, String> {
        let (session, camera) = (&self.session, self.camera);
        let name = &session.loaded().name;
        let target = if self.aim.follow { self.aim.beside } else { camera.target };
        let look = Look {
            target: target.to_array(),
            distance: camera.distance,
            yaw: camera.yaw,
            pitch: camera.pitch,
            follow: self.aim.follow,
            shown: shown_bits(self.style),
        };
        let mut set = session.material().set().clone();
        let mut solver = session.runner().solver().row();
        // Built-in scenes have this length of a step, so the link omits it.
        if self.source.current.is_some() && solver.step == OrAuto::Given(Settings::default().step) {
            solver.step = OrAuto::Auto;
        }
        let method = session.runner().integrator();
        solver.tolerance = solver.tolerance.filter(|_| method.is_adaptive());
        solver.newton = solver.newton.filter(|_| method.is_implicit());
        solver.assignments().for_each(|edit| set.set(edit));
        let changes = Changes { speed: session.speed(), look, set, former: None };
        if self.source.current.is_some() {
            return Link { scene: name.clone(), own: None, changes: Some(changes) }.checked();
        }
        Link::to_own(OwnScene::of(session.loaded(), self.source.own.as_ref())?, changes)
    }

    /// Opens the scene of a link with its settings and camera.
    pub fn open_link(&mut self, link: &Link) {
        match link.load() {
            Err(error) => self.session.refuse(Err(error)),
            Ok(loaded) => self.show_link(link, loaded),
        }
    }

    /// Shows the loaded scene of a link with its settings and camera.
    pub(crate) fn show_link(&mut self, link: &Link, loaded: Loaded) {
        let is_shown = match &link.own {
            Some(own) => self.show_opened(loaded, Some(Ok(own.clone()))),
            None => {
                let mut entries = self.catalogue.entries.iter();
                let Some(index) = entries.position(|entry| entry.name == link.scene) else {
                    let unknown = LinkError::UnknownScene(link.scene.clone());
                    return self.session.refuse(Err(unknown));
                };
                self.open(Ok(loaded), Some(index))
            }
        };
        if is_shown {
            self.set_up(link);
        }
    }

    /// Creates a viewer of the scene of a link.
    ///
    /// # Errors
    /// One line on why the scene cannot be opened, or cannot run.
    pub fn of_link(link: &Link, catalogue: Catalogue) -> Result<Self, String> {
        let loaded = link.load().map_err(|error| error.to_string())?;
        Viewer::of_loaded(link, loaded, catalogue)
    }

    /// Creates a viewer of the loaded scene of a link.
    ///
    /// # Errors
    /// One line on why the scene cannot run.
    pub(crate) fn of_loaded(
        link: &Link,
        loaded: Loaded,
        catalogue: Catalogue,
    ) -> Result<Self, String> {
        let opened = link.own.is_some().then(|| loaded.clone());
        let mut viewer = Viewer::new(loaded, catalogue).map_err(|error| error.to_string())?;
        if opened.is_some() {
            // It may have the name of a built-in scene.
            (viewer.source.current, viewer.source.opened) = (None, opened);
            viewer.source.own = link.own.clone().map(Ok);
        }
        viewer.set_up(link);
        Ok(viewer)
    }

    /// Applies the changes of a link to its loaded scene: all but the solver, which it already has.
    fn set_up(&mut self, link: &Link) {
        let Some(changes) = &link.changes else { return };
        let session = &mut self.session;
        let set = changes.set_of(session.loaded());
        session.edit_again(set);
        session.set_speed(changes.speed);
        let Look { target, distance, yaw, pitch, follow, shown } = changes.look;
        show_bits(&mut self.style, shown);
        self.colour_by(self.style.colour_by);
        self.aim.follow = follow;
        let middle = self.subject().map_or(Vec3::ZERO, |(low, high)| (low + high) * 0.5);
        let target = Vec3::from(target);
        self.aim.beside = if follow { target } else { Vec3::ZERO };
        self.aim.aimed = if follow { middle + target } else { target };
        let fov_deg = Camera::default().fov_deg;
        self.camera = Camera { target: self.aim.aimed, distance, yaw, pitch, fov_deg };
        self.aim.unframed = false;
    }

    /// Opens a scene file, a mesh or a saved run from the bytes of a file called `name`.
    pub fn open_bytes(&mut self, name: &str, bytes: &[u8]) {
        match msd_scene::open_bytes(name, bytes) {
            Ok(loaded) => self.show_bytes(name, bytes, loaded),
            Err(error) => self.session.refuse(Err(error)),
        }
    }

    /// Shows a scene that was loaded from the bytes of a file called `name`.
    pub(crate) fn show_bytes(&mut self, name: &str, bytes: &[u8], loaded: Loaded) {
        self.show_opened(loaded, Some(OwnScene::new(name, bytes)));
    }

    /// Ends the tour, which does not open by itself again.
    pub(crate) fn end_guide(&mut self) {
        self.layout.guide = None;
        self.preferences.is_guided = true;
    }

    /// Applies stored preferences.
    pub fn set_preferences(&mut self, preferences: Preferences) {
        (self.layout.light, self.layout.panels) = (preferences.light, preferences.panels);
        self.layout.guide = (!preferences.is_guided).then(Guide::default);
        self.preferences = preferences;
    }

    /// Returns the current preferences; `size` is of the window and `scale` of the panels.
    pub fn remember(&mut self, size: [f32; 2], scale: f32) -> &Preferences {
        self.keep_camera();
        let file = self.session.loaded().files.first();
        let file = file.and_then(|file| std::path::absolute(file).ok());
        let scene = file
            .map_or(self.session.loaded().name.clone(), |file| file.to_string_lossy().into_owned());
        let preferences = &mut self.preferences;
        (preferences.light, preferences.panels) = (self.layout.light, self.layout.panels);
        (preferences.scale, preferences.scene) = (scale, Some(scene));
        if !self.wishes.full_screen {
            preferences.size = Some(size);
        }
        preferences
    }
}
