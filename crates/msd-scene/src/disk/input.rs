//! Regular files to be read, checked before they are opened: a pipe or a device never ends.

use crate::error::FileError;
use crate::shown::shown_path;
use std::fs::File;
use std::io::{Read, Take};
use std::path::Path;

/// Opens a file of which at most `limit` bytes will be read.
///
/// # Errors
/// [`FileError::Unreadable`] for what is not there and what is not a regular file.
pub(crate) fn open_regular(path: &Path, limit: u64) -> Result<Take<File>, FileError> {
    let refused = |reason: String| FileError::Unreadable { file: shown_path(path), reason };
    let about = std::fs::metadata(path).map_err(|error| refused(error.to_string()))?;
    if about.is_dir() {
        return Err(refused("it is a folder".into()));
    }
    if !about.is_file() {
        return Err(refused("it is not a regular file".into()));
    }
    let file = File::open(path).map_err(|error| refused(error.to_string()))?;
    Ok(file.take(limit))
}
