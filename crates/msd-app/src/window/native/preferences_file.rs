//! The file of the preferences, in the system's folder for such files.

use crate::viewer::Preferences;
use msd_scene::{shown_path, write_file};
use std::path::PathBuf;

/// Returns the file: `MSD_PREFERENCES` if set, else one in the user's folder; `None` on a machine
/// without one. An empty `MSD_PREFERENCES` switches the preferences off.
pub(crate) fn place() -> Option<PathBuf> {
    if let Some(file) = std::env::var_os("MSD_PREFERENCES") {
        return Some(PathBuf::from(file)).filter(|file| !file.as_os_str().is_empty());
    }
    let folders = directories::ProjectDirs::from("", "", "msd")?;
    Some(folders.config_dir().join("preferences.json"))
}

/// Reads the preferences: the defaults before the first start, or, with a message, if the file is
/// damaged.
pub(crate) fn read() -> (Preferences, Option<String>) {
    let Some(place) = place() else {
        // Without preferences, the tour would open at every start.
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

/// Writes the preferences atomically. A failure to write them is not fatal.
pub(crate) fn write(preferences: &Preferences) {
    let Some(place) = place() else { return };
    if let Some(folder) = place.parent() {
        std::fs::create_dir_all(folder).ok();
    }
    if let Err(error) = write_file(&place, preferences.to_text().as_bytes()) {
        log::warn!("{error}");
    }
}
