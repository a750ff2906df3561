//! The lessons: a list, or the question of the scene and the user's answer.

use super::Viewer;
use msd_scene::{Builtin, Loaded};
use msd_study::lesson::{Grade, Question, read_number};

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
    /// Checks the answer in the text field, and keeps that a built-in lesson is done.
    pub(crate) fn check_answer(&mut self, lessons: &mut Lessons) {
        let loaded = self.session.loaded();
        let Some(lesson) = loaded.lesson.as_deref() else { return };
        let grade = read_number(&lessons.answer, lesson.answer.unit()).and_then(|given| {
            let scene =
                self.session.current_scene().ok_or("restart the scene: it is incomplete")?;
            let settings = self.session.runner().settings();
            Question { lesson, scene: &scene, settings }.check(given)
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
