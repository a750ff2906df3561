//! Regular files to be read, checked before they are opened: a pipe or a device never ends.

use crate::error::{FileError, nearest};
use crate::shown::shown_path;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Take};
use std::path::{Path, PathBuf};

/// The most names of a folder that are compared with one that is not there.
const MOST_NAMES: usize = 10_000;

/// Opens a file of which at most `limit` bytes will be read.
///
/// # Errors
/// [`FileError::Unreadable`] for a missing file and for anything but a regular file.
pub(crate) fn open_regular(path: &Path, limit: u64) -> Result<Take<File>, FileError> {
    let refused = |reason: String| FileError::Unreadable { file: shown_path(path), reason };
    let about = std::fs::metadata(path).map_err(|error| refused(reason(path, &error)))?;
    if about.is_dir() {
        return Err(refused("it is a folder".into()));
    }
    if !about.is_file() {
        return Err(refused("it is not a regular file".into()));
    }
    let file = File::open(path).map_err(|error| refused(error.to_string()))?;
    Ok(file.take(limit))
}

/// The reason why a file cannot be opened; where there is none of this name, with the one that may
/// be meant.
pub(crate) fn reason(path: &Path, error: &Error) -> String {
    let meant = (error.kind() == ErrorKind::NotFound).then(|| alike(path)).flatten();
    match meant {
        Some(meant) => format!("{error}; did you mean `{}`?", shown_path(&meant)),
        None => error.to_string(),
    }
}

/// The file of the same ending and in the same folder whose name is most like that of a path.
fn alike(path: &Path) -> Option<PathBuf> {
    let (stem, ending) = (path.file_stem()?.to_str()?, path.extension());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let rows = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names = rows.take(MOST_NAMES).filter_map(|row| Some(PathBuf::from(row.ok()?.file_name())));
    let mut stems: Vec<String> = names
        .filter(|name| name.extension() == ending)
        .filter_map(|name| name.file_stem()?.to_str().map(str::to_owned))
        .collect();
    stems.sort_unstable();
    let near = nearest(stem, stems.iter().map(String::as_str))?;
    let mut name = PathBuf::from(near);
    ending.into_iter().for_each(|ending| {
        name.as_mut_os_string().push(".");
        name.as_mut_os_string().push(ending);
    });
    Some(path.with_file_name(name))
}
