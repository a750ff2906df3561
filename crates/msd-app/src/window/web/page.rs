//! Questions of the page around the canvas to the window, and what the window tells it.
//!
//! The page calls the functions here by their names, and gives [`start`] a function that is called
//! with the kind and the text of whatever the window has to tell: see [`tell`].

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

/// What a page tells the window.
pub(crate) enum PageEvent {
    /// The graphics device is lost; a browser takes it away when it likes.
    Lost,
    /// There is a graphics device to be had again.
    Restored,
    /// What the page does between two frames.
    Ask(Box<dyn FnOnce(&mut Viewer)>),
}

thread_local! {
    static TOLD: RefCell<Option<Function>> = const { RefCell::new(None) };
    static WINDOW: RefCell<Option<EventLoopProxy<Arrival>>> = const { RefCell::new(None) };
    static KEPT: RefCell<String> = const { RefCell::new(String::new()) };
    static FRAMES: Cell<u64> = const { Cell::new(0) };
}

/// Starts the window in the canvas of the page, with the scene that a link's `fragment` names,
/// whose `rows` a worker has opened, and the `preferences` that the page has kept; `by_touch` is
/// whether fingers press what is there.
///
/// # Errors
/// Why there is no window, one line.
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
    // A scene of the list is opened in a worker too.
    let open = |name: &str| {
        tell("open", &Link::to(name).to_string());
        None
    };
    let catalogue = Catalogue { open, ..catalogue() };
    let mut viewer = Viewer::of_loaded(&link_of(fragment)?, unpacked(rows)?, catalogue)?;
    (viewer.layout.in_page, viewer.layout.by_touch) = (true, by_touch);
    // The guide is not offered by itself: the page names what there is to do.
    let kept = preferences.and_then(|text| Preferences::parse(&text).ok()).unwrap_or_default();
    viewer.set_preferences(Preferences { is_guided: true, ..kept });
    show(viewer).map_err(|what| what.to_string())
}

/// Does what a key would: `pause`, `restart`, `step`, `back`, `frame`, `pin`, `record`, `panels`,
/// `guide`, `help`.
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

/// Shows the scene that a link's fragment names, set up as it says; a worker has opened its `rows`.
#[wasm_bindgen]
pub fn show_link(fragment: &str, rows: &[u8]) -> Promise {
    let scene = link_of(fragment).and_then(|link| Ok((link, unpacked(rows)?)));
    ask(move |viewer| {
        let (link, loaded) = scene?;
        viewer.show_link(&link, loaded);
        refusal(viewer)
    })
}

/// The fragment of a link to the scene as it is set up and looked at now.
#[wasm_bindgen]
pub fn link() -> Promise {
    ask(|viewer| viewer.link().map(|link| link.to_string()))
}

/// The scenes of the list, a line for each: its name, a space and its title.
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

/// Nothing, or why the last thing was refused.
fn refusal(viewer: &Viewer) -> Result<String, String> {
    viewer.session.refusal().map_or(Ok(String::new()), |reason| Err(reason.to_owned()))
}

/// The bytes of a saved run of what the window shows, to be downloaded.
#[wasm_bindgen]
pub fn saved() -> Promise {
    ask_for(|viewer| {
        let bytes =
            msd_scene::saved_bytes(&viewer.to_saved()).map_err(|error| error.to_string())?;
        Ok(Uint8Array::from(&bytes[..]).into())
    })
}

/// Shows the scene without panels, or with them.
#[wasm_bindgen]
pub fn set_bare(bare: bool) -> Promise {
    ask(move |viewer| {
        viewer.layout.bare = bare;
        Ok(String::new())
    })
}

/// What the window shows, as JSON: see [`status_file`]. Places are in CSS pixels of the canvas.
#[wasm_bindgen]
pub fn status() -> Promise {
    ask(|viewer| Ok(status_file::report(viewer, 1.0, FRAMES.get()).to_string()))
}

/// Where a particle is, metres, three numbers: for tests.
#[wasm_bindgen]
pub fn position(particle: usize) -> Promise {
    ask(move |viewer| {
        let [x, y, z] = viewer.session.position(particle).to_array();
        Ok(format!("{x} {y} {z}"))
    })
}

/// Asks something of the viewer between two frames; the promise holds the answer, or the line that
/// says why there is none.
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
            // Settling a promise throws nothing.
            settle.call1(&JsValue::NULL, &answer).ok();
        };
        send(PageEvent::Ask(Box::new(answer)));
    })
}

/// Sends something to the window. Without a window nobody answers.
pub(super) fn send(event: PageEvent) {
    let arrival = Arrival::Host(event);
    WINDOW.with_borrow(|window| window.as_ref().map(|window| window.send_event(arrival).ok()));
}

/// Sends questions of the page to this window.
pub(super) fn listen(window: EventLoopProxy<Arrival>) {
    WINDOW.set(Some(window));
}

/// Counts frames, and tells the page of each one, of each scene and of each pause.
pub(super) fn watcher() -> Watcher {
    let (mut scene, mut is_paused) = (String::new(), false);
    Box::new(move |viewer, _, _| {
        FRAMES.set(FRAMES.get() + 1);
        // At each: what was drawn can be copied until this returns.
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

/// Tells the page something. The kinds: `frame`, one was drawn; `scene`, this one is shown;
/// `paused`, whether it is, `yes` or nothing; `open`, this fragment is to be opened; `copy`, this
/// text is for the clipboard; `refused`, why a link or file was not taken; `line`, something that
/// the user should know; `preferences`, to be kept; `missing`, why there is no window any more.
pub(crate) fn tell(kind: &str, text: &str) {
    let told = TOLD.with_borrow(Clone::clone);
    // The page would have to fail in its own code, and says so on the console.
    told.map(|told| told.call2(&JsValue::NULL, &kind.into(), &text.into()).ok());
}

/// Lets the page keep preferences until the next start, where they differ from those kept last.
pub(crate) fn keep(preferences: &Preferences) {
    let text = preferences.to_text();
    if KEPT.with_borrow(|kept| *kept != text) {
        tell("preferences", &text);
        KEPT.set(text);
    }
}

/// Gives the page a file to be downloaded: tells it `file`, the name and the bytes.
pub(crate) fn give(name: &str, bytes: &[u8]) {
    let told = TOLD.with_borrow(Clone::clone);
    let bytes = Uint8Array::from(bytes);
    told.map(|told| told.call3(&JsValue::NULL, &"file".into(), &name.into(), &bytes).ok());
}
