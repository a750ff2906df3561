//! The window on a page of a browser.

use super::{Missing, Shell, ViewError};
use crate::viewer::{Viewer, catalogue};
use msd_scene::Loaded;

/// Shows a scene in a canvas at the end of the page.
///
/// # Errors
/// The scene is out of its domain, or the browser has no event loop.
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
    let shell = Shell::new(viewer, event_loop.create_proxy(), None);
    event_loop.spawn_app(shell);
    Ok(())
}
