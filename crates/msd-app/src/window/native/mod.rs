//! The window on a desktop.

mod clipboard;
mod film;
mod scale;
mod preferences_file;
mod lost_display;
mod desktop;

pub(super) use clipboard::Clipboard;
pub(crate) use desktop::Desktop;
pub use film::Film;

use super::{Arrival, Missing, Shell, ViewError, Watcher, status_file};
use crate::link::Link;
use crate::viewer::{Viewer, catalogue};
use desktop::Loss;
use lost_display::{panic_text, plain};
use msd_scene::Loaded;
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, LineWriter, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Shows a scene in a window until it is closed.
///
/// # Errors
/// See [`view_as`].
pub fn view(loaded: Loaded) -> Result<(), ViewError> {
    let called = loaded.name.clone();
    view_as(loaded, &called)
}

/// Shows a scene in a window until it is closed; `called` is the user's name for it, for errors.
///
/// The environment variable `MSD_STATUS` names a file that gets a line of JSON per frame, for
/// debugging and tests. `MSD_LOSE`, `surface` or `device`, simulates a loss when the run is first
/// paused, so that tests can check the reaction of the window.
///
/// # Errors
/// A display, a graphics adapter or a library is missing, or the scene is out of its domain.
pub fn view_as(loaded: Loaded, called: &str) -> Result<(), ViewError> {
    show(|| Ok(Viewer::new(loaded, catalogue())?), called)
}

/// Returns the name or path of the last scene, if the window has stored one.
pub fn last_scene() -> Option<String> {
    preferences_file::read().0.scene
}

/// Shows the scene of a link in a window until it is closed, with its settings and camera.
///
/// # Errors
/// See [`view_as`].
pub fn view_link(link: &Link) -> Result<(), ViewError> {
    show(|| Viewer::of_link(link, catalogue()).map_err(Missing::Link), &link.scene)
}

fn show(open: impl FnOnce() -> Result<Viewer, Missing>, called: &str) -> Result<(), ViewError> {
    let status = std::env::var_os("MSD_STATUS").map(PathBuf::from);
    let run = || run(open()?, status.as_deref());
    run().map_err(|what| ViewError { scene: called.to_owned(), what })
}

fn run(mut viewer: Viewer, status: Option<&Path>) -> Result<(), Missing> {
    let (preferences, damage) = preferences_file::read();
    viewer.set_preferences(preferences);
    viewer.note = damage;
    let watcher = status.map(watcher).transpose().map_err(Missing::Status)?;
    let event_loop = event_loop()?;
    let mut shell = Shell::new(viewer, event_loop.create_proxy(), watcher);
    shell.host.to_lose = to_lose();
    let shell = Rc::new(RefCell::new(shell));
    lost_display::watch(&shell);
    let ended = event_loop.run_app(&mut lost_display::Lent(shell.clone()));
    lost_display::unwatch();
    let mut shell = shell.borrow_mut();
    match (shell.missing.take(), ended) {
        (Some(what), _) => Err(what),
        (None, Ok(())) => Ok(()),
        (None, Err(error)) if shell.window.is_some() => {
            let kept = shell.leave();
            Err(Missing::Device(format!("the display was lost ({error}); {kept}")))
        }
        (None, Err(error)) => Err(Missing::Window(error.to_string())),
    }
}

/// Opens the status file and returns the function that writes it.
fn watcher(path: &Path) -> io::Result<Watcher> {
    let mut file = LineWriter::new(File::create(path)?);
    let mut frame = 0u64;
    Ok(Box::new(move |viewer, pixels_per_point, focus| {
        frame += 1;
        let mut line = status_file::report(viewer, pixels_per_point, frame);
        line["focus"] = focus.into();
        if let Err(error) = writeln!(file, "{line}") {
            log::warn!("the status file cannot be written: {error}");
        }
    }))
}

fn to_lose() -> Option<Loss> {
    match std::env::var("MSD_LOSE").ok()?.as_str() {
        "surface" => Some(Loss::Surface),
        "device" => Some(Loss::Device),
        _ => None,
    }
}

/// Connects to the display. winit panics if an X11 library that it loads late is missing; this is
/// reported like any other error.
fn event_loop() -> Result<winit::event_loop::EventLoop<Arrival>, Missing> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let built = std::panic::catch_unwind(|| {
        let mut builder = winit::event_loop::EventLoop::<Arrival>::with_user_event();
        #[cfg(target_os = "linux")]
        if is_wayland_gone() {
            winit::platform::x11::EventLoopBuilderExtX11::with_x11(&mut builder);
        }
        builder.build()
    });
    std::panic::set_hook(hook);
    match built {
        Ok(built) => built.map_err(|error| Missing::Display(plain(&error.to_string()))),
        Err(panic) => Err(Missing::Display(panic_text(&*panic))),
    }
}

/// Returns whether `WAYLAND_DISPLAY` names a missing display while an X display may exist: winit
/// would try only the Wayland display.
#[cfg(target_os = "linux")]
fn is_wayland_gone() -> bool {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let Some(wayland) = variable("WAYLAND_DISPLAY") else { return false };
    if variable("DISPLAY").is_none() || variable("WAYLAND_SOCKET").is_some() {
        return false;
    }
    // An absolute name replaces the folder.
    let folder = PathBuf::from(variable("XDG_RUNTIME_DIR").unwrap_or_default());
    std::os::unix::net::UnixStream::connect(folder.join(wayland)).is_err()
}
