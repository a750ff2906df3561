//! How is a run kept in a file, to go on from there to the last bit?
//!
//! A file ending in `.msd` holds everything that a step reads: see `docs/files.md`.

use crate::envelope::{Found, Kind};
use crate::error::{LabError, shown_path};
use crate::loaded::{Loaded, has_plain_name};
use crate::output::Output;
use std::path::Path;

/// How the name of a saved run ends.
pub const ENDING: &str = "msd";

/// Raised whenever what is written changes its form.
const KIND: Kind = Kind { what: "saved run", format: 3 };

/// Writes a run, see [`Loaded::of`], into a file that appears whole, or stays the old one, whatever
/// happens meanwhile.
///
/// # Errors
/// [`LabError::Unwritable`].
pub fn write_saved(loaded: &Loaded, mut output: Output) -> Result<(), LabError> {
    KIND.begin(&mut output, loaded)?;
    output.finish_safely()
}

/// Reads a saved run from a file.
///
/// # Errors
/// A file that cannot be read; everything that [`read_saved`] refuses.
pub fn load_saved(path: &Path) -> Result<Loaded, LabError> {
    read_saved(&KIND.load(path)?, &shown_path(path))
}

/// Reads a saved run from the bytes of a file called `name`. What it tells is checked by
/// [`Loaded::runner`], as with any scene.
///
/// # Errors
/// [`LabError::Format`] for a file of another format; [`LabError::Malformed`] for bytes that are no
/// saved run, are cut short or do not fit their checksum.
pub fn read_saved(bytes: &[u8], name: &str) -> Result<Loaded, LabError> {
    let mut frames = KIND.frames(bytes, name)?;
    let loaded: Loaded = frames.expect()?;
    match frames.next() {
        Found::End if is_saved(&loaded) => Ok(loaded),
        _ => Err(frames.damaged()),
    }
}

/// Whether a run from a file is one that was saved, called by a plain name.
pub(crate) fn is_saved(loaded: &Loaded) -> bool {
    loaded.progress.is_some() && has_plain_name(loaded)
}
