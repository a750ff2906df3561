//! Requests from the page around the canvas to the window, and messages of the window to it.
//!
//! The page calls these functions by name. It gives [`start`] a callback, which gets the kind and
//! the text of each message of the window: see [`tell`].

use super::super::{Arrival, Watcher, status_file};
use super::opening::{link_of, unpacked};
use super::show;
use crate::link::Link;
use crate::viewer::{Catalogue, Command, Preferences, Viewer, catalogue};
use js_sys::{Function, Promise, Uint8Array};
use std::cell::{Cell, RefCell};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;
use winit::event_loop::EventLoopProxy;

/// An event from the page to the window.
pub(crate) enum PageEvent {
    /// The graphics device was lost.
    Lost,
    /// A graphics device is available again.
    Restored,
    /// A function to run between two frames.
    Ask(Box<dyn FnOnce(&mut Viewer)>),
}

thread_local! {
    static TOLD: RefCell<Option<Function>> = const { RefCell::new(None) };
    static WINDOW: RefCell<Option<EventLoopProxy<Arrival>>> = const { RefCell::new(None) };
    static KEPT: RefCell<String> = const { RefCell::new(String::new()) };
    static FRAMES: Cell<u64> = const { Cell::new(0) };
}

/// Starts the window in the canvas of the page. `fragment` is that of a link, and `rows` its scene,
/// from a worker. The page has stored `preferences`; `by_touch` is whether the input is by touch.
///
/// # Errors
/// One line on why there is no window.
#[wasm_bindgen]
pub fn start(
    fragment: &str,
    rows: &[u8],
    preferences: Option<String>,
    by_touch: bool,
    told: Function,
) -> Result<(), String> {
    console_log::init_with_level(log::Level::Warn).ok();
    TOLD.set(Some(told));
    // A worker also opens the scenes of the list.
    let open = |name: &str| {
        tell("open", &Link::to(name).to_string());
        None
    };
    let catalogue = Catalogue { open, ..catalogue() };
    let mut viewer = Viewer::of_loaded(&link_of(fragment)?, unpacked(rows)?, catalogue)?;
    (viewer.layout.in_page, viewer.layout.by_touch) = (true, by_touch);
    // The page itself introduces the controls, so the tour does not open by itself.
    let kept = preferences.and_then(|text| Preferences::parse(&text).ok()).unwrap_or_default();
    viewer.set_preferences(Preferences { is_guided: true, ..kept });
    show(viewer).map_err(|what| what.to_string())
}

/// Performs a command: `pause`, `restart`, `step`, `back`, `frame`, `pin`, `record`, `panels`,
/// `lessons`, `guide`, `help`.
#[wasm_bindgen]
pub fn command(name: &str) -> Promise {
    let command = match name {
        "pause" => Some(Command::TogglePause),
        "restart" => Some(Command::Restart),
        "step" => Some(Command::StepForward),
        "back" => Some(Command::StepBack),
        "frame" => Some(Command::FrameAll),
        "pin" => Some(Command::Pin),
        "record" => Some(Command::Record),
        "panels" => Some(Command::Panels),
        "lessons" => Some(Command::Lessons),
        "guide" => Some(Command::Guide),
        "help" => Some(Command::Help),
        _ => None,
    };
    let name = name.to_owned();
    ask(move |viewer| {
        viewer.command(command.ok_or_else(|| format!("there is no command `{name}`"))?);
        Ok(String::new())
    })
}

/// Shows the scene of a link's fragment with its settings; a worker has opened its `rows`.
#[wasm_bindgen]
pub fn show_link(fragment: &str, rows: &[u8]) -> Promise {
    let scene = link_of(fragment).and_then(|link| Ok((link, unpacked(rows)?)));
    ask(move |viewer| {
        let (link, loaded) = scene?;
        viewer.show_link(&link, loaded);
        refusal(viewer)
    })
}

/// Returns the fragment of a link to the scene with its current settings and camera.
#[wasm_bindgen]
pub fn link() -> Promise {
    ask(|viewer| viewer.link().map(|link| link.to_string()))
}

/// Returns the scenes of the list, a line for each: name, space, title.
#[wasm_bindgen]
pub fn scenes() -> String {
    let line = |scene: &msd_scene::Builtin| format!("{} {}", scene.name, scene.title);
    msd_scene::BUILTINS.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Shows a scene file, a mesh or a saved run from the bytes of a file called `name`, whose `rows` a
/// worker has opened.
#[wasm_bindgen]
pub fn show_file(name: String, bytes: Vec<u8>, rows: &[u8]) -> Promise {
    let loaded = unpacked(rows);
    ask(move |viewer| {
        viewer.show_bytes(&name, &bytes, loaded?);
        refusal(viewer)
    })
}

/// Returns the last refusal as an error.
fn refusal(viewer: &Viewer) -> Result<String, String> {
    viewer.session.refusal().map_or(Ok(String::new()), |reason| Err(reason.to_owned()))
}

/// Returns the bytes of a saved run for download.
#[wasm_bindgen]
pub fn saved() -> Promise {
    ask_for(|viewer| {
        let bytes =
            msd_scene::saved_bytes(&viewer.to_saved()).map_err(|error| error.to_string())?;
        Ok(Uint8Array::from(&bytes[..]).into())
    })
}

/// Shows the scene without or with panels.
#[wasm_bindgen]
pub fn set_bare(bare: bool) -> Promise {
    ask(move |viewer| {
        viewer.layout.bare = bare;
        Ok(String::new())
    })
}

/// Returns the state of the window as JSON: see [`status_file`]. Positions are in CSS pixels.
#[wasm_bindgen]
pub fn status() -> Promise {
    ask(|viewer| Ok(status_file::report(viewer, 1.0, FRAMES.get()).to_string()))
}

/// Returns the position of a particle, metres, three numbers: for tests.
#[wasm_bindgen]
pub fn position(particle: usize) -> Promise {
    ask(move |viewer| {
        let [x, y, z] = viewer.session.position(particle).to_array();
        Ok(format!("{x} {y} {z}"))
    })
}

/// Destroys the graphics device that takes the steps, for tests.
#[wasm_bindgen]
pub fn lose_gpu() -> Promise {
    ask(|viewer| {
        viewer.session.device().ok_or("no graphics device takes the steps")?.lose();
        Ok(String::new())
    })
}

/// Runs a function on the viewer between two frames; the promise has its answer, or an error of one
/// line.
fn ask(question: impl FnOnce(&mut Viewer) -> Result<String, String> + 'static) -> Promise {
    ask_for(|viewer| question(viewer).map(JsValue::from))
}

fn ask_for(question: impl FnOnce(&mut Viewer) -> Result<JsValue, String> + 'static) -> Promise {
    let mut question = Some(question);
    Promise::new(&mut |resolve, reject| {
        let Some(question) = question.take() else { return };
        let answer = move |viewer: &mut Viewer| {
            let (settle, answer) = match question(viewer) {
                Ok(answer) => (resolve, answer),
                Err(text) => (reject, text.into()),
            };
            // Settling a promise does not throw.
            settle.call1(&JsValue::NULL, &answer).ok();
        };
        send(PageEvent::Ask(Box::new(answer)));
    })
}

/// Sends an event to the window, if it exists.
pub(super) fn send(event: PageEvent) {
    let arrival = Arrival::Host(event);
    WINDOW.with_borrow(|window| window.as_ref().map(|window| window.send_event(arrival).ok()));
}

/// Registers the window that receives the events of the page.
pub(super) fn listen(window: EventLoopProxy<Arrival>) {
    WINDOW.set(Some(window));
}

/// Counts frames, and notifies the page of each frame, scene and pause.
pub(super) fn watcher() -> Watcher {
    let (mut scene, mut is_paused) = (String::new(), false);
    Box::new(move |viewer, _, _| {
        FRAMES.set(FRAMES.get() + 1);
        // At each frame: the drawing buffer can be copied until this returns.
        tell("frame", "");
        let name = &viewer.session.loaded().name;
        if *name != scene {
            scene.clone_from(name);
            tell("scene", name);
        }
        if viewer.session.is_paused() != is_paused {
            is_paused = !is_paused;
            tell("paused", if is_paused { "yes" } else { "" });
        }
    })
}

/// Sends a message to the page. The kinds: `frame`, a frame was drawn; `scene`, the name of the new
/// scene; `paused`, `yes` or empty; `open`, a fragment to open; `copy`, a text for the clipboard;
/// `refused`, an error of a link or file; `line`, a message for the user; `preferences`, to be
/// stored; `missing`, why the window has closed.
pub(crate) fn tell(kind: &str, text: &str) {
    let told = TOLD.with_borrow(Clone::clone);
    // If it throws, its own code has failed, and the browser logs the error.
    told.map(|told| told.call2(&JsValue::NULL, &kind.into(), &text.into()).ok());
}

/// Lets the page store preferences until the next start, if they have changed.
pub(crate) fn keep(preferences: &Preferences) {
    let text = preferences.to_text();
    if KEPT.with_borrow(|kept| *kept != text) {
        tell("preferences", &text);
        KEPT.set(text);
    }
}

/// Sends a file to the page for download: the kind `file`, the name and the bytes.
pub(crate) fn give(name: &str, bytes: &[u8]) {
    let told = TOLD.with_borrow(Clone::clone);
    let bytes = Uint8Array::from(bytes);
    told.map(|told| told.call3(&JsValue::NULL, &"file".into(), &name.into(), &bytes).ok());
}
