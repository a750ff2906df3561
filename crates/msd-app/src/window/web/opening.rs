//! The opening of scenes in a worker: bodies are filled there, and the page gets rows.

use crate::link::{Link, LinkError};
use msd_scene::Loaded;
use wasm_bindgen::prelude::wasm_bindgen;

/// The link of a fragment; of one that names no scene, that to the first scene.
pub(super) fn link_of(fragment: &str) -> Result<Link, String> {
    match Link::parse(fragment) {
        Err(LinkError::NoScene) => Ok(Link::to(msd_scene::BUILTINS[0].name)),
        link => link.map_err(|error| error.to_string()),
    }
}

/// Opens the scene that a link's fragment names, and returns its rows for the page.
///
/// # Errors
/// Why the link is not followed, one line.
#[wasm_bindgen]
pub fn opened(fragment: &str) -> Result<Vec<u8>, String> {
    packed(&link_of(fragment)?.load().map_err(|error| error.to_string())?)
}

/// Opens a scene file, a mesh or a saved run from the bytes of a file called `name`, and returns
/// its rows for the page.
///
/// # Errors
/// Why it is refused, one line.
#[wasm_bindgen]
pub fn opened_file(name: &str, bytes: &[u8]) -> Result<Vec<u8>, String> {
    packed(&msd_scene::open_bytes(name, bytes).map_err(|error| error.to_string())?)
}

fn packed(loaded: &Loaded) -> Result<Vec<u8>, String> {
    postcard::to_stdvec(loaded).map_err(|error| error.to_string())
}

/// The scene that a worker has opened.
pub(super) fn unpacked(rows: &[u8]) -> Result<Loaded, String> {
    postcard::from_bytes(rows).map_err(|_| "the page and its worker are of two versions".into())
}
