//! The list of scenes in the window.

use msd_scene::{BUILTINS, Builtin, LESSONS, Loaded};

/// A scene in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Name that opens it.
    pub name: &'static str,
    /// Description in one line.
    pub title: &'static str,
    /// Whether it is a lesson, which has a list of its own.
    pub is_lesson: bool,
}

/// The scenes of the list, with a function that opens one.
#[derive(Clone, Debug)]
pub struct Catalogue {
    /// The scenes, in the order of the list, then the lessons.
    pub entries: Vec<Entry>,
    /// Opens a scene by name; the error is a line for the user. `None` if a worker opens it and
    /// `Viewer::show_link` gets it later.
    pub open: fn(&str) -> Option<Result<Loaded, String>>,
}

/// Returns the built-in scenes and lessons.
pub fn catalogue() -> Catalogue {
    let entry =
        |is_lesson| move |&Builtin { name, title, .. }: &Builtin| Entry { name, title, is_lesson };
    let lessons = LESSONS.iter().map(entry(true));
    Catalogue {
        entries: BUILTINS.iter().map(entry(false)).chain(lessons).collect(),
        open: |name| Some(msd_scene::open(name).map_err(|error| error.to_string())),
    }
}
