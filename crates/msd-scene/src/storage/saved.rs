//! Saved runs, which go on from where they were to the last bit.
//!
//! A file ending in `.msd` holds everything that a step reads: see `docs/reference/files.md`.

use crate::disk::Output;
use crate::error::FileError;
use crate::loaded::Loaded;
use crate::shown::shown_path;
use crate::storage::envelope::{FileKind, Found, frame};
use std::io::Write;
use std::path::Path;

/// The file extension of a saved run.
pub(crate) const ENDING: &str = "msd";

/// Raised whenever the written form changes.
const KIND: FileKind = FileKind { what: "saved run", format: 17, oldest: 16 };

/// Writes a run into a file that appears whole, or stays the old one, whatever
/// happens meanwhile.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn write_saved(loaded: &Loaded, mut output: Output) -> Result<(), FileError> {
    KIND.begin(&mut output, loaded)?;
    if let Some(wind) = &loaded.wind {
        let written = frame(wind).and_then(|frame| output.write_all(&frame));
        written.map_err(|error| output.refused(&error))?;
    }
    output.finish_safely()
}

/// The bytes of a saved run, where there is no disk to write them to.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn saved_bytes(loaded: &Loaded) -> Result<Vec<u8>, FileError> {
    let mut bytes = KIND.bytes(loaded)?;
    if let Some(wind) = &loaded.wind {
        let refused = |error: std::io::Error| FileError::Unwritable {
            file: KIND.what.into(),
            reason: error.to_string(),
        };
        bytes.extend(frame(wind).map_err(refused)?);
    }
    Ok(bytes)
}

/// Reads a saved run from a file.
///
/// # Errors
/// A file that cannot be read; everything that [`read_saved`] refuses.
pub fn load_saved(path: &Path) -> Result<Loaded, FileError> {
    read_saved(&KIND.load(path)?, &shown_path(path))
}

/// Reads a saved run from the bytes of a file called `name`. Its content is checked where it
/// becomes a run, as with any scene.
///
/// # Errors
/// [`FileError::Format`] for a file of another format; [`FileError::Malformed`] for bytes that are
/// not a saved run, are cut short or do not fit their checksum.
pub fn read_saved(bytes: &[u8], name: &str) -> Result<Loaded, FileError> {
    let mut frames = KIND.frames(bytes, name)?;
    let mut loaded: Loaded = frames.expect()?;
    let mut rest = frames.next_frame();
    if let Found::Whole(content) = rest {
        loaded.wind = Some(postcard::from_bytes(content).map_err(|_| frames.damaged())?);
        rest = frames.next_frame();
    }
    match rest {
        Found::End if loaded.is_saved() && loaded.wind().is_usable() => Ok(loaded),
        _ => Err(frames.damaged()),
    }
}
