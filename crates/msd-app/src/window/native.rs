//! How is the window opened, and what is said where it cannot be?

use crate::viewer::{Catalogue, Entry, Viewer};
#[cfg(not(target_arch = "wasm32"))]
use crate::window::{Arrival, Shell, Trouble};
use msd_lab::Loaded;
use msd_render::RenderError;
#[cfg(not(target_arch = "wasm32"))]
use std::path::PathBuf;

/// Why no window was shown. Its text has two lines: what is missing, and what works without.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n{}", headless(scene))]
pub struct ViewError {
    /// The scene that was to be shown, as the person named it: a name or a file.
    pub scene: String,
    /// What is missing.
    pub what: Missing,
}

/// What a window needs and did not find.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Missing {
    /// A display to open the window on, or a library to talk to it.
    #[error(
        "no display: {0}; the window needs X11 or Wayland, and on Debian/Ubuntu: \
         apt install libx11-xcb1 libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0 \
         mesa-vulkan-drivers"
    )]
    Display(String),
    /// A graphics adapter.
    #[error("{error}{hint}", error = .0, hint = driver(.0))]
    Graphics(Box<RenderError>),
    /// The window itself.
    #[error("no window: {0}")]
    Window(String),
    /// A scene that can run.
    #[error("the scene cannot run: {0}")]
    Scene(#[from] msd_core::Error),
    /// A place for the status file.
    #[error("the status file cannot be written: {0}")]
    Status(std::io::Error),
}

/// What to install, where the error does not say so itself: a surface that no driver wants.
fn driver(error: &RenderError) -> &'static str {
    match error {
        RenderError::NoSurface(_) => {
            "; is there a driver? On Debian/Ubuntu: apt install mesa-vulkan-drivers"
        }
        _ => "",
    }
}

fn headless(scene: &str) -> String {
    // To be copied into a shell as it stands.
    let scene = if scene.contains(char::is_whitespace) { &format!("\"{scene}\"") } else { scene };
    format!(
        "without a window: msd render {scene} --out picture.png, or msd run {scene} \
         (from the sources: cargo run --release -- render {scene} --out picture.png)"
    )
}

/// How a window is opened.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ViewOptions {
    /// A file that gets a line of JSON per frame: a debugging aid, and how tests see what the
    /// window did. See [`crate::report`] for its keys. Default none.
    pub status: Option<PathBuf>,
}

/// Shows a scene in a window until it is closed.
///
/// # Errors
/// See [`view_as`].
#[cfg(not(target_arch = "wasm32"))]
pub fn view(loaded: Loaded) -> Result<(), ViewError> {
    let called = loaded.name.clone();
    view_as(loaded, &called)
}

/// Shows a scene in a window until it is closed; `called` is how the person named it, for errors.
///
/// The environment variable `MSD_STATUS` names a file for [`ViewOptions::status`].
///
/// # Errors
/// A display, a graphics adapter or a library is missing, or the scene is out of its domain.
#[cfg(not(target_arch = "wasm32"))]
pub fn view_as(loaded: Loaded, called: &str) -> Result<(), ViewError> {
    let status = std::env::var_os("MSD_STATUS").map(PathBuf::from);
    view_with(loaded, called, &ViewOptions { status })
}

/// Shows a scene in a window until it is closed, with options.
///
/// # Errors
/// See [`view`].
#[cfg(not(target_arch = "wasm32"))]
pub fn view_with(loaded: Loaded, called: &str, options: &ViewOptions) -> Result<(), ViewError> {
    show(loaded, options).map_err(|what| ViewError { scene: called.to_owned(), what })
}

#[cfg(not(target_arch = "wasm32"))]
fn show(loaded: Loaded, options: &ViewOptions) -> Result<(), Missing> {
    let viewer = Viewer::new(loaded, catalogue())?;
    let watcher = match &options.status {
        Some(path) => Some(crate::report::watcher(path).map_err(Missing::Status)?),
        None => None,
    };
    let event_loop = event_loop()?;
    let mut shell = Shell::new(viewer, event_loop.create_proxy(), watcher);
    let ended = event_loop.run_app(&mut shell);
    match shell.trouble.take() {
        Some(Trouble::Graphics(error)) => Err(Missing::Graphics(Box::new(error))),
        Some(Trouble::Window(text)) => Err(Missing::Window(text)),
        None => ended.map_err(|error| Missing::Window(error.to_string())),
    }
}

/// Connects to the display. winit panics where a library of X11 is missing that it loads late;
/// that is told like any other reason.
#[cfg(not(target_arch = "wasm32"))]
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

/// Whether a name of a Wayland display is left over while an X display may be there: winit would
/// take the name for the display and give up.
#[cfg(target_os = "linux")]
fn is_wayland_gone() -> bool {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let Some(wayland) = variable("WAYLAND_DISPLAY") else { return false };
    if variable("DISPLAY").is_none() || variable("WAYLAND_SOCKET").is_some() {
        return false;
    }
    // An absolute name takes the place of the folder.
    let folder = PathBuf::from(variable("XDG_RUNTIME_DIR").unwrap_or_default());
    std::os::unix::net::UnixStream::connect(folder.join(wayland)).is_err()
}

#[cfg(not(target_arch = "wasm32"))]
fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    plain(text.unwrap_or("a library of the window system is missing"))
}

/// One line without the place in winit's source, which tells a person nothing.
#[cfg(not(target_arch = "wasm32"))]
fn plain(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let told = line.rsplit_once("rs:").and_then(|(_, rest)| rest.split_once(": "));
    told.map_or(line, |(_, rest)| rest).trim_end_matches('.').to_owned()
}

/// Shows a scene in a canvas at the end of the page.
///
/// # Errors
/// The scene is out of its domain, or the browser has no event loop.
#[cfg(target_arch = "wasm32")]
pub fn start_web(loaded: Loaded) -> Result<(), ViewError> {
    use winit::platform::web::EventLoopExtWebSys;
    let scene = loaded.name.clone();
    let fail = |what| ViewError { scene, what };
    let viewer = match Viewer::new(loaded, catalogue()) {
        Ok(viewer) => viewer,
        Err(error) => return Err(fail(Missing::Scene(error))),
    };
    let built = winit::event_loop::EventLoop::with_user_event().build();
    let event_loop = match built {
        Ok(event_loop) => event_loop,
        Err(error) => return Err(fail(Missing::Display(error.to_string()))),
    };
    let shell = crate::window::Shell::new(viewer, event_loop.create_proxy(), None);
    event_loop.spawn_app(shell);
    Ok(())
}

/// The built-in scenes.
pub fn catalogue() -> Catalogue {
    let entry = |scene: &msd_lab::Builtin| Entry { name: scene.name, title: scene.title };
    Catalogue {
        entries: msd_lab::scenes::BUILTINS.iter().map(entry).collect(),
        open: |name| msd_lab::open(name).map_err(|error| error.to_string()),
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_what_is_missing_and_what_works_in_two_lines() {
        let what = Missing::Display("DISPLAY is not set".to_owned());
        let text = ViewError { scene: "jelly".to_owned(), what }.to_string();
        assert_eq!(text.lines().count(), 2);
        assert!(text.contains("apt install") && text.contains("msd render jelly --out"));
    }

    #[test]
    fn the_hint_names_a_file_as_the_person_did() {
        for (scene, told) in [
            ("scenes/rope.toml", "msd render scenes/rope.toml --out"),
            ("my scenes/rope.toml", "msd run \"my scenes/rope.toml\" "),
        ] {
            let what = Missing::Display("DISPLAY is not set".to_owned());
            let text = ViewError { scene: scene.to_owned(), what }.to_string();
            assert!(text.contains(told), "{text}");
        }
    }

    #[test]
    fn the_place_in_the_source_is_left_out() {
        let text = "os error at /home/u/winit/src/linux/mod.rs:765: neither A nor B is set.";
        assert_eq!(plain(text), "neither A nor B is set");
        assert_eq!(
            plain("Library libx.so could not be loaded."),
            "Library libx.so could not be loaded"
        );
    }
}
