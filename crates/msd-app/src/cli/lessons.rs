//! `msd lessons`: the lessons, and the teacher's sheet of one.

use super::arguments::LessonsArguments;
use super::failure::{Failure, aligned, say};
use super::places::Places;
use super::run::open_scene;
use msd_report::lesson_sheet;
use msd_run::Runner;
use msd_scene::{LESSONS, shown_path, write_file};
use std::path::PathBuf;

/// Lists the lessons, or writes the sheet of one.
pub fn run_lessons(arguments: &LessonsArguments) -> Result<(), Failure> {
    let Some(scene) = &arguments.scene else {
        let rows = LESSONS.map(|lesson| [lesson.name, lesson.title].map(str::to_owned));
        return say(&aligned(&rows, &[]).join("\n"));
    };
    let loaded = open_scene(scene, &arguments.set.set)?;
    let refused = |why: String| Failure::input(format!("{}: {why}", shown_path(scene)));
    let settings = Runner::open(&loaded).map_err(|error| refused(error.to_string()))?.settings();
    let sheet = lesson_sheet(&loaded, settings).map_err(refused)?;
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{}.html", loaded.name)));
    let mut places = Places::default();
    loaded.files.iter().for_each(|file| places.read("SCENE", file));
    places.write("--out", &out)?;
    write_file(&out, sheet.as_bytes()).map_err(Failure::input)?;
    say(&format!("wrote {}, the teacher's sheet", shown_path(&out)))
}
