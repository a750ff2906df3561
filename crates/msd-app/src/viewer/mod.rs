//! A session and how it is looked at: camera, view settings, the list of scenes, commands.

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

pub use catalogue::{Catalogue, Entry, catalogue};
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

/// The session and how it is looked at. Drawn by [`crate::panel::show`].
#[derive(Debug)]
pub struct Viewer {
    /// What runs.
    pub session: Session,
    /// What it was made from.
    source: SceneSource,
    /// From where it is seen.
    pub camera: Camera,
    /// What the camera follows.
    pub aim: Aim,
    /// What of it is shown.
    pub style: Style,
    /// How much a picture may cost, by what draws it.
    pub quality: Quality,
    /// Whether it has half of the resolution.
    pub sharpness: Sharpness,
    /// The scenes of the list.
    pub catalogue: Catalogue,
    /// What is around the picture.
    pub layout: Layout,
    /// What the pointer does in the picture.
    pub hand: PointerState,
    /// What is remembered from one start to the next.
    pub preferences: Preferences,
    /// The film that is being written.
    #[cfg(not(target_arch = "wasm32"))]
    pub filming: Option<Filming>,
    /// What the system is to do.
    pub wishes: Wishes,
    /// What was done last, for the user.
    pub note: Option<String>,
    /// Where recordings go: the folder that the program was started in.
    pub folder: PathBuf,
}

/// What is around the picture.
#[derive(Debug)]
pub struct Layout {
    /// Whether a twin is shown beside the run, not as points over it.
    pub side_by_side: bool,
    /// Whether the panels are shown.
    pub panels: bool,
    /// The panel that a small screen shows, a row of the list of [`crate::panel`].
    pub(crate) sheet: usize,
    /// Whether fingers press what there is, not a mouse.
    pub by_touch: bool,
    /// Whether the page around the window has buttons of its own, which need not be here twice.
    pub in_page: bool,
    /// Whether the panels are light.
    pub light: bool,
    /// Whether how bodies look can be set: the controls of it take room.
    pub looks: bool,
    /// Whether the help is open.
    pub help: bool,
    /// Whether the hint for new users is shown: until something was grabbed.
    pub hint: bool,
    /// The guide, while it is offered.
    pub guide: Option<Guide>,
    /// The gallery, while it is open.
    pub gallery: Option<Gallery>,
    /// Whether the scene fills the window, without panels.
    pub bare: bool,
    /// Whether the panel of numbers is longer than the window.
    pub(crate) is_folded: bool,
    /// The part of the window that shows the scene, points.
    pub rect: Rect,
    /// Where widgets are, points: for tests that drive the window from outside.
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
            bare: false,
            is_folded: false,
            rect: Rect::ZERO,
            landmarks: BTreeMap::new(),
        }
    }
}

/// What the system is to do for the user.
#[derive(Debug, Default)]
pub struct Wishes {
    /// A text that is to be put on the clipboard.
    pub clipboard: Option<String>,
    /// Whether the window is to fill the screen.
    pub full_screen: bool,
    /// Whether the user asked to close the window.
    pub quit: bool,
}

/// The angle that a key turns the camera by, radians, and the exponent that it zooms by.
const TURN: f32 = 0.1;

impl Viewer {
    /// Looks at a scene.
    ///
    /// # Errors
    /// See [`Session::new`].
    pub fn new(loaded: Loaded, catalogue: Catalogue) -> Result<Self, msd_core::Error> {
        // By the title too: a file may have the name of a built-in scene.
        let is_built_in = loaded.files.is_empty();
        let is_loaded = |entry: &Entry| {
            is_built_in && (entry.name, entry.title) == (&*loaded.name, &*loaded.title)
        };
        // A saved run of a built-in scene is another scene: one may return to it.
        let listed = catalogue.entries.iter().position(is_loaded);
        let current = listed.filter(|_| loaded.progress.is_none());
        let colour_by = usual_colours(&loaded.name);
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
            layout: Layout::default(),
            hand: PointerState::default(),
            preferences: Preferences::default(),
            #[cfg(not(target_arch = "wasm32"))]
            filming: None,
            wishes: Wishes::default(),
            note: None,
            folder: PathBuf::new(),
        })
    }

    /// The name of the 3D view among egui's widgets.
    pub(crate) fn view_id() -> egui::Id {
        egui::Id::unique("view")
    }

    /// Whether keys are for a control: nothing typed over the gallery is for the scene behind it.
    pub fn takes_keys(&self, context: &egui::Context) -> bool {
        context.egui_wants_keyboard_input() || self.layout.gallery.is_some()
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
            // It names controls of the panels.
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

    /// Shows the state so many steps before the latest one.
    pub fn look_back(&mut self, back: usize) {
        self.let_go();
        self.session.look_back(back);
    }

    /// Takes a way out of a run that stopped by itself.
    pub fn take(&mut self, offer: Offer) {
        self.let_go();
        self.session.take(offer);
        self.style.full_scale = None;
    }

    /// Lets colours stand for a quantity, or bodies have their own. An error is estimated then.
    pub fn colour_by(&mut self, quantity: Option<Quantity>) {
        (self.style.colour_by, self.style.full_scale) = (quantity, None);
        if quantity == Some(Quantity::Error) {
            self.session.set_estimating(true);
        }
    }

    /// The scale of the colours; none where bodies have their own, as while an error is not known.
    pub fn scale(&self) -> Option<Scale> {
        let quantity = self.style.colour_by?;
        if quantity == Quantity::Error {
            self.seen_error()?;
        }
        let full = self.style.full_scale.unwrap_or_else(|| quantity.full_scale(0.0));
        Some(Scale { quantity, full })
    }

    /// Chooses the end of the scale for what is about to be drawn. It only grows, until the scene
    /// is started anew: colours that flicker between two scales show nothing.
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

    /// The error of each particle, metres, as far as it is known and to be shown.
    pub fn errors(&self) -> Option<impl Iterator<Item = f32>> {
        let last = self.seen_error()?;
        Some(last.error.particles.iter().map(|&error| error as f32))
    }

    /// The error that colours stand for, if it is known and more than rounding.
    fn seen_error(&self) -> Option<&ErrorReading> {
        let Some(ErrorNow::Known(last)) = self.session.error() else { return None };
        let worst = last.worst.1;
        let is_seen = self.style.colour_by == Some(Quantity::Error)
            && worst.is_finite()
            && last.error.rounding < worst;
        is_seen.then_some(last)
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        format!("msd: {}", self.session.loaded().name)
    }

    /// Whether the scene has solids that could be dragged.
    pub(crate) fn has_solids(&self) -> bool {
        let solids = &self.session.loaded().scene.solids;
        solids.iter().any(|solid| solid.shape.reach().is_finite())
    }

    /// Ends a gesture: what it held may be gone.
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

    /// Opens a scene of the list; returns whether it did.
    pub fn open_entry(&mut self, index: usize) -> bool {
        let entry = self.catalogue.entries.get(index);
        let result = entry.and_then(|entry| (self.catalogue.open)(entry.name));
        result.is_some_and(|result| self.open(result, Some(index)))
    }

    /// Opens a scene of the list, or what else can be opened by this name; returns whether it did.
    pub fn open_named(&mut self, name: &str) -> bool {
        match self.catalogue.entries.iter().position(|entry| entry.name == name) {
            Some(index) => self.open_entry(index),
            None => self.open_path(Path::new(name)),
        }
    }

    /// Shows a scene that is not in the catalogue, and keeps it within reach; returns whether it
    /// did. `own` is what it was read from, where that is not a file on this machine.
    fn show_opened(&mut self, loaded: Loaded, own: Option<Result<OwnScene, String>>) -> bool {
        let kept = loaded.clone();
        let is_shown = self.open(Ok(loaded), None);
        if is_shown {
            (self.source.opened, self.source.own) = (Some(kept), own);
        }
        is_shown
    }

    /// The scene that is not in the catalogue, if one was opened.
    pub fn opened(&self) -> Option<&Loaded> {
        self.source.opened.as_ref()
    }

    /// The entry of the catalogue that runs; `None` for the opened scene.
    pub fn current(&self) -> Option<usize> {
        self.source.current
    }

    /// Returns to the scene that is not in the catalogue.
    pub fn reopen(&mut self) {
        if let Some(loaded) = self.source.opened.clone() {
            self.open(Ok(loaded), None);
        }
    }

    /// Takes the place of what runs, unless there is an error; returns whether it did.
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
                let usual = usual_colours(&self.session.loaded().name);
                // What the user chose stays between scenes of the same kind.
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

    /// The link to this scene as it is set up and looked at now, without what happened to it. One
    /// that is not in the catalogue is held by the link.
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
        // The length of a step that built-in scenes have.
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

    /// Opens the scene of a link, set up and looked at as it says.
    pub fn open_link(&mut self, link: &Link) {
        match link.load() {
            Err(error) => self.session.refuse(Err(error)),
            Ok(loaded) => self.show_link(link, loaded),
        }
    }

    /// Shows the scene of a link, which was loaded before, set up and looked at as it says.
    pub fn show_link(&mut self, link: &Link, loaded: Loaded) {
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

    /// Looks at the scene of a link, set up as it says.
    ///
    /// # Errors
    /// Why it cannot be opened, or cannot run: one line.
    pub fn of_link(link: &Link, catalogue: Catalogue) -> Result<Self, String> {
        let loaded = link.load().map_err(|error| error.to_string())?;
        Viewer::of_loaded(link, loaded, catalogue)
    }

    /// The same of a link whose scene was loaded before.
    ///
    /// # Errors
    /// Why it cannot run: one line.
    pub fn of_loaded(link: &Link, loaded: Loaded, catalogue: Catalogue) -> Result<Self, String> {
        let opened = link.own.is_some().then(|| loaded.clone());
        let mut viewer = Viewer::new(loaded, catalogue).map_err(|error| error.to_string())?;
        if opened.is_some() {
            // It may be called as a built-in scene is.
            (viewer.source.current, viewer.source.opened) = (None, opened);
            viewer.source.own = link.own.clone().map(Ok);
        }
        viewer.set_up(link);
        Ok(viewer)
    }

    /// Sets up a scene that was just loaded from a link: all but the solver, which it has.
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

    /// Shows what was loaded before from the bytes of a file called `name`.
    pub fn show_bytes(&mut self, name: &str, bytes: &[u8], loaded: Loaded) {
        self.show_opened(loaded, Some(OwnScene::new(name, bytes)));
    }

    /// Ends the guide, which is not offered again by itself.
    pub fn end_guide(&mut self) {
        self.layout.guide = None;
        self.preferences.is_guided = true;
    }

    /// Takes over what was remembered.
    pub fn set_preferences(&mut self, preferences: Preferences) {
        (self.layout.light, self.layout.panels) = (preferences.light, preferences.panels);
        self.layout.guide = (!preferences.is_guided).then(Guide::default);
        self.preferences = preferences;
    }

    /// What is to be remembered now; `size` is that of the window and `scale` that of the panels.
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
