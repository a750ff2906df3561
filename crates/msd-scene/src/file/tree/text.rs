//! Text files of scenes: their two formats, and how they are read.

use crate::disk::open_regular;
use crate::error::FileError;
use std::path::Path;

/// The largest scene file, bytes: the tree of a text takes many times its length.
const MAX_TEXT: u64 = 32 << 20;

/// The language of a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFormat {
    /// TOML, `.toml`.
    Toml,
    /// JSON, `.json`.
    Json,
}

/// The format that the ending of a file stands for, TOML unless it says JSON.
pub fn format_of(path: &Path) -> SceneFormat {
    match ending(path).as_str() {
        "json" => SceneFormat::Json,
        _ => SceneFormat::Toml,
    }
}

/// Reads a text file that messages call `name`.
///
/// # Errors
/// [`FileError::Unreadable`], also for bytes that are not UTF-8 text and for more than 32 MiB.
pub fn read_text(path: &Path, name: &str) -> Result<String, FileError> {
    use std::io::Read;
    let refused = |reason: String| FileError::Unreadable { file: name.into(), reason };
    // One byte more than allowed shows that a file is too long, whatever its metadata says.
    let mut file = open_regular(path, MAX_TEXT + 1)?;
    let mut text = String::new();
    let read = file.read_to_string(&mut text);
    let length = read.map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => refused("it is not UTF-8 text".into()),
        _ => refused(error.to_string()),
    })?;
    if MAX_TEXT < length as u64 {
        return Err(refused(format!("it is longer than {} MiB", MAX_TEXT >> 20)));
    }
    Ok(text)
}

/// The ending of a file name in lower case, empty where there is none.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}
