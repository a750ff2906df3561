//! Opening of scenes in a worker, which fills the bodies and returns rows to the page.

use super::super::canvas::Painting;
use super::super::{lay_out, panel_context};
use crate::link::{Link, LinkError};
use crate::viewer::{Viewer, catalogue};
use egui::{Pos2, RawInput, Rect, vec2};
use msd_scene::Loaded;
use wasm_bindgen::prelude::wasm_bindgen;

/// Parses the link of a fragment; without a scene, it is that to the first scene.
pub(super) fn link_of(fragment: &str) -> Result<Link, String> {
    match Link::parse(fragment) {
        Err(LinkError::NoScene) => Ok(Link::to(msd_scene::BUILTINS[0].name)),
        link => link.map_err(|error| error.to_string()),
    }
}

/// Opens the scene that a link's fragment names, and returns its rows for the page.
///
/// # Errors
/// One line on why the link cannot be followed.
#[wasm_bindgen]
pub fn opened(fragment: &str) -> Result<Vec<u8>, String> {
    packed(&link_of(fragment)?.load().map_err(|error| error.to_string())?)
}

/// Does the same before the window exists, and lays out a hidden frame. A browser compiles code at
/// its first run, and the page shares code that ran in a worker.
///
/// # Errors
/// One line on why the link cannot be followed.
#[wasm_bindgen]
pub fn opened_first(fragment: &str) -> Result<Vec<u8>, String> {
    let rows = opened(fragment)?;
    rehearse();
    Ok(rows)
}

/// Lays out a frame of the first scene, in a size with space for all panels.
fn rehearse() {
    let link = Link::to(msd_scene::BUILTINS[0].name);
    let Ok(mut viewer) = Viewer::of_link(&link, catalogue()) else { return };
    let context = panel_context(1.0);
    let size = Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 1000.0));
    let raw = RawInput { screen_rect: Some(size), ..Default::default() };
    let (output, _) = lay_out(&context, raw, &mut viewer, 1.0 / 60.0, &|| 0.0);
    Painting::of(&context, output);
}

/// Opens a scene file, a mesh or a saved run from the bytes of a file called `name`, and returns
/// its rows for the page.
///
/// # Errors
/// One line on why the file is refused.
#[wasm_bindgen]
pub fn opened_file(name: &str, bytes: &[u8]) -> Result<Vec<u8>, String> {
    packed(&msd_scene::open_bytes(name, bytes).map_err(|error| error.to_string())?)
}

/// Encodes a scene and its lesson, which [`Loaded`] does not keep.
fn packed(loaded: &Loaded) -> Result<Vec<u8>, String> {
    let lesson = serde_json::to_string(&loaded.lesson).map_err(|error| error.to_string())?;
    postcard::to_stdvec(&(loaded, lesson)).map_err(|error| error.to_string())
}

/// Decodes the scene that a worker has opened.
pub(super) fn unpacked(rows: &[u8]) -> Result<Loaded, String> {
    const OTHER: &str = "the page and its worker have different versions";
    let (loaded, lesson): (Loaded, String) = postcard::from_bytes(rows).map_err(|_| OTHER)?;
    Ok(Loaded { lesson: serde_json::from_str(&lesson).map_err(|_| OTHER)?, ..loaded })
}
