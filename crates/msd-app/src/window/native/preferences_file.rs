//! The file of the preferences, in the folder that the system has for such files.

use crate::viewer::Preferences;
use msd_scene::{shown_path, write_file};
use std::path::PathBuf;

/// The file: `MSD_PREFERENCES` where that is set, else one in the folder of the user; none on a
/// machine without one. An empty `MSD_PREFERENCES` means that nothing is remembered.
pub(crate) fn place() -> Option<PathBuf> {
    if let Some(file) = std::env::var_os("MSD_PREFERENCES") {
        return Some(PathBuf::from(file)).filter(|file| !file.as_os_str().is_empty());
    }
    let folders = directories::ProjectDirs::from("", "", "msd")?;
    Some(folders.config_dir().join("preferences.json"))
}

/// Reads the preferences: the defaults before a first start, and where the file is damaged, with a
/// line that says so.
pub(crate) fn read() -> (Preferences, Option<String>) {
    let Some(place) = place() else {
        // Nothing would be remembered of the guide: it would come back at every start.
        return (Preferences { is_guided: true, ..Preferences::default() }, None);
    };
    let text = match std::fs::read_to_string(&place) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Default::default(),
        Err(error) => return ignored(&place, &error),
    };
    match Preferences::parse(&text) {
        Ok(preferences) => (preferences, None),
        Err(error) => ignored(&place, &error),
    }
}

fn ignored(place: &std::path::Path, why: &dyn std::fmt::Display) -> (Preferences, Option<String>) {
    let text = format!("the preferences in {} are ignored: {why}", shown_path(place));
    (Preferences { is_guided: true, ..Preferences::default() }, Some(text))
}

/// Writes the preferences, whole or not at all. That they cannot be written is no reason to stop.
pub(crate) fn write(preferences: &Preferences) {
    let Some(place) = place() else { return };
    if let Some(folder) = place.parent() {
        std::fs::create_dir_all(folder).ok();
    }
    if let Err(error) = write_file(&place, preferences.to_text().as_bytes()) {
        log::warn!("{error}");
    }
}
