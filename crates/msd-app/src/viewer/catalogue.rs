//! The list of scenes in the window.

use msd_scene::Loaded;

/// A scene in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// What it is opened by.
    pub name: &'static str,
    /// One line on what is seen.
    pub title: &'static str,
}

/// The scenes of the list and how one is opened.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// The scenes, in the order of the list.
    pub entries: Vec<Entry>,
    /// Opens one by its name; the error is a line for the user. `None` where it is opened elsewhere
    /// and arrives later, by [`Viewer::show_link`](super::Viewer::show_link).
    pub open: fn(&str) -> Option<Result<Loaded, String>>,
}

/// The built-in scenes.
pub fn catalogue() -> Catalogue {
    let entry = |scene: &msd_scene::Builtin| Entry { name: scene.name, title: scene.title };
    Catalogue {
        entries: msd_scene::BUILTINS.iter().map(entry).collect(),
        open: |name| Some(msd_scene::open(name).map_err(|error| error.to_string())),
    }
}
