//! The list of scenes in the window.

use msd_scene::Loaded;

/// A scene in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Name that opens it.
    pub name: &'static str,
    /// Description in one line.
    pub title: &'static str,
}

/// The scenes of the list, with a function that opens one.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// The scenes, in the order of the list.
    pub entries: Vec<Entry>,
    /// Opens a scene by name; the error is a line for the user. `None` if a worker opens it and
    /// `Viewer::show_link` gets it later.
    pub open: fn(&str) -> Option<Result<Loaded, String>>,
}

/// Returns the built-in scenes.
pub fn catalogue() -> Catalogue {
    let entry = |scene: &msd_scene::Builtin| Entry { name: scene.name, title: scene.title };
    Catalogue {
        entries: msd_scene::BUILTINS.iter().map(entry).collect(),
        open: |name| Some(msd_scene::open(name).map_err(|error| error.to_string())),
    }
}
