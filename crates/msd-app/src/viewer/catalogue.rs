//! The list of scenes in the window, and the lessons: a list, or the user's answer to a question.

use super::Viewer;
use msd_scene::{BUILTINS, Builtin, LESSONS, Loaded};
use msd_study::lesson::{Grade, Question, read_number};

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

/// The lessons while they are open.
#[derive(Clone, Debug, Default)]
pub struct Lessons {
    /// Whether the list is shown even though the scene has a lesson.
    pub(crate) is_list: bool,
    /// The answer in the text field.
    pub(crate) answer: String,
    /// The grade on the last answer.
    pub(crate) grade: Option<Grade>,
}

impl Lessons {
    /// Opens the lesson of a scene, if it has one.
    pub(super) fn of(loaded: &Loaded) -> Option<Lessons> {
        loaded.lesson.is_some().then(Lessons::default)
    }
}

impl Viewer {
    /// Opens or closes the lessons.
    pub(super) fn toggle_lessons(&mut self) {
        let is_open = self.layout.lessons.is_some();
        self.layout.lessons = (!is_open).then(Lessons::default);
    }

    /// Checks the answer in the text field, and keeps that a built-in lesson is done.
    pub(crate) fn check_answer(&mut self, lessons: &mut Lessons) {
        let loaded = self.session.loaded();
        let Some(lesson) = loaded.lesson.as_deref() else { return };
        let grade = read_number(&lessons.answer, lesson.answer.unit()).and_then(|given| {
            let scene =
                self.session.current_scene().ok_or("restart the scene: it is incomplete")?;
            let settings = self.session.runner().settings();
            let current = Question { lesson, scene: &scene, settings }.check(given)?;
            let settings = if loaded.automatic { settings } else { loaded.settings };
            let written = Question { lesson, scene: &loaded.scene, settings }.check(given)?;
            // The last steps of a lesson may have changed the scene.
            Ok(match (current, written) {
                (Grade::Wrong(_), Grade::Right(right)) => {
                    Grade::Right(format!("{right} for the scene as written"))
                }
                (current, _) => current,
            })
        });
        if matches!(grade, Ok(Grade::Right(_))) && Builtin::find(&loaded.name).is_some() {
            self.preferences.lessons.insert(loaded.name.clone());
        }
        lessons.grade = Some(grade.unwrap_or_else(Grade::Wrong));
    }

    /// Returns the lessons by their places in the catalogue, and whether each is done.
    pub(crate) fn lessons(&self) -> Vec<(usize, bool)> {
        let entries = self.catalogue.entries.iter().enumerate();
        let lessons = entries.filter(|(_, entry)| entry.is_lesson);
        lessons.map(|(at, entry)| (at, self.preferences.lessons.contains(entry.name))).collect()
    }
}
