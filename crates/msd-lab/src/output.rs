//! How does a file appear whole or not at all? Written beside its place, then moved there.

use crate::error::LabError;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that comes into being when [`Output::finish`] is called; dropped before, nothing is left.
#[derive(Debug)]
pub struct Output {
    writer: BufWriter<NamedTempFile>,
    path: PathBuf,
    name: String,
}

impl Output {
    /// Opens a file beside `path`, so that a folder that cannot be written to is found before a
    /// long run and not after it.
    ///
    /// # Errors
    /// [`LabError::Unwritable`] for a folder that does not exist or may not be written to, and for
    /// a path that is a folder or a device.
    pub fn create(path: &Path) -> Result<Self, LabError> {
        let name = path.display().to_string();
        let refused = |reason: String| LabError::Unwritable { file: name.clone(), reason };
        // A link is followed: moving a file onto it would cut it.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if target.is_dir() || path.file_name().is_none() || name.ends_with(std::path::is_separator)
        {
            return Err(refused("it is a folder".into()));
        }
        if target.exists() && !target.is_file() {
            return Err(refused("it exists and is no ordinary file".into()));
        }
        let folder = match target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(refused(format!("there is no folder {}", folder.display())));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".msd-").suffix(".part");
        // Like any new file, and not for its owner alone; the umask applies.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(folder).map_err(|error| refused(reason(&error)))?;
        Ok(Output { writer: BufWriter::new(file), path: target, name })
    }

    /// The path as the user wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`LabError::Unwritable`]; nothing is left then.
    pub fn finish(self) -> Result<(), LabError> {
        self.open_ended().map(drop)
    }

    /// Puts the file in its place once it is safe on the disk: a power cut leaves the old file or
    /// the new one, never an empty one.
    ///
    /// # Errors
    /// [`LabError::Unwritable`]; nothing is left then.
    pub fn finish_safely(mut self) -> Result<(), LabError> {
        let safe = self.writer.flush().and_then(|()| self.writer.get_ref().as_file().sync_all());
        safe.map_err(|error| self.refused(&error))?;
        self.finish()
    }

    /// Puts the file in its place as it is now, to go on writing there.
    ///
    /// # Errors
    /// [`LabError::Unwritable`]; nothing is left then.
    pub fn open_ended(self) -> Result<File, LabError> {
        let refused = |reason| LabError::Unwritable { file: self.name.clone(), reason };
        let file = self.writer.into_inner().map_err(|error| refused(reason(error.error())))?;
        file.persist(&self.path).map_err(|error| refused(reason(&error.error)))
    }

    /// The error of a write that failed.
    pub(crate) fn refused(&self, error: &io::Error) -> LabError {
        LabError::Unwritable { file: self.name.clone(), reason: reason(error) }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// The words of the operating system, without the name of the file beside the real one.
fn reason(error: &io::Error) -> String {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code).to_string(),
        None => error.to_string(),
    }
}
