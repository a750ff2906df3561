//! Files that appear whole or not at all: written beside their place, then moved there.

use crate::disk::file_id::{folder_of, follow, is_at};
use crate::error::FileError;
use crate::shown::shown_path;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// The most programs that write one file at once.
const WRITERS: usize = 16;

/// A file that comes into being when [`Output::finish`] is called; dropped before, nothing is left.
///
/// A symbolic link stays one: its target is written. The previous file gives the new one its mode
/// and owner. A device or pipe is written to at once.
#[derive(Debug)]
pub struct Output {
    writer: BufWriter<File>,
    way: Way,
    name: String,
}

/// The way of the bytes to their place.
#[derive(Debug)]
enum Way {
    /// By a file beside the place, moved there at the end.
    Part { part: TempPath, place: PathBuf },
    /// It goes there at once.
    Stream,
}

/// Writes a file, whole or not at all.
///
/// # Errors
/// See [`Output::create`] and [`Output::finish`].
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut output = Output::create(path)?;
    output.write_all(bytes).map_err(|error| output.refused(&error))?;
    output.finish()
}

impl Output {
    /// Opens a file beside `path`, so that a folder that cannot be written to is found before a
    /// long run and not after it. Removes the part that a killed program left of the same file.
    ///
    /// # Errors
    /// [`FileError::Unwritable`] for a folder that does not exist or may not be written to, for a
    /// file that may not, and for a path that is a folder or a block device.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let name = shown_path(path);
        let refused = |reason: String| FileError::Unwritable { file: name.clone(), reason };
        let unopened = |error: io::Error| refused(reason(&error));
        let old = std::fs::metadata(path);
        let is_folder = old.as_ref().is_ok_and(Metadata::is_dir);
        if is_folder || path.file_name().is_none() || ends_in_separator(path) {
            return Err(refused("it is a folder".into()));
        }
        let old = match old {
            Ok(old) => Some(old),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(unopened(error)),
        };
        if let Some(old) = &old {
            if !old.is_file() && !is_stream(old) {
                return Err(refused("it exists and is not an ordinary file".into()));
            }
            // A file that may not be written to is not to be replaced by another either.
            let file = OpenOptions::new().write(true).open(path).map_err(unopened)?;
            if !old.is_file() {
                return Ok(Output { writer: BufWriter::new(file), way: Way::Stream, name });
            }
        }
        let place = follow(path);
        let folder = folder_of(&place);
        if !folder.is_dir() {
            return Err(refused(format!("there is no folder {}", shown_path(folder))));
        }
        let (file, part) = open_part(&place, old.as_ref()).map_err(unopened)?;
        Ok(Output { writer: BufWriter::new(file), way: Way::Part { part, place }, name })
    }

    /// The path as the user wrote it, fit for a message.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`FileError::Unwritable`]; nothing is left then.
    pub fn finish(self) -> Result<(), FileError> {
        self.open_ended().map(drop)
    }

    /// Puts the file in its place once it is safe on the disk (atomic write). A power cut leaves
    /// the old file or the new one, never an empty one.
    ///
    /// # Errors
    /// [`FileError::Unwritable`]; nothing is left then.
    pub fn finish_safely(mut self) -> Result<(), FileError> {
        let safe = self.writer.flush().and_then(|()| match self.way {
            Way::Part { .. } => self.writer.get_ref().sync_all(),
            // A pipe has no disk.
            Way::Stream => Ok(()),
        });
        safe.map_err(|error| self.refused(&error))?;
        self.finish()
    }

    /// Puts the unfinished file in its place, to go on writing there.
    ///
    /// # Errors
    /// [`FileError::Unwritable`]; nothing is left then.
    pub fn open_ended(self) -> Result<File, FileError> {
        let Output { writer, way, name } = self;
        let refused = |reason| FileError::Unwritable { file: name, reason };
        let mut file = match writer.into_inner() {
            Ok(file) => file,
            Err(error) => return Err(refused(reason(error.error()))),
        };
        let Way::Part { part, place } = way else { return Ok(file) };
        if std::fs::metadata(&place).is_ok_and(|old| !takes_after(&file, &old)) {
            return overwrite(&mut file, &place).map_err(|error| {
                let kept =
                    part.keep().map(|part| format!("; all of it is in {}", shown_path(&part)));
                refused(reason(&error) + &kept.unwrap_or_default())
            });
        }
        part.persist(&place).map_err(|error| refused(reason(&error.error)))?;
        // A writer that goes on here no longer writes to a part; a file system without locks has
        // none to release.
        let _ = file.unlock();
        Ok(file)
    }

    /// The error of a write that failed.
    pub fn refused(&self, error: &io::Error) -> FileError {
        FileError::Unwritable { file: self.name.clone(), reason: reason(error) }
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

fn ends_in_separator(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| std::path::is_separator(byte.into()))
}

/// Returns whether a place takes bytes one after the other and keeps no old ones, as a pipe does.
fn is_stream(about: &Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        about.file_type().is_char_device() || about.file_type().is_fifo()
    }
    #[cfg(not(unix))]
    {
        let _ = about;
        false
    }
}

/// Opens the file beside a place. Its name follows from that of the place, so that a later run
/// finds the part that a killed one left. The writer holds a lock, which goes with the process.
fn open_part(place: &Path, old: Option<&Metadata>) -> io::Result<(File, TempPath)> {
    let name = place.file_name().unwrap_or_default().as_encoded_bytes();
    // Not the name itself: with more around it, it may be too long.
    let hash = blake3::hash(name).to_hex();
    let parts = (0..WRITERS).map(|turn| format!(".msd-{}-{turn}.part", &hash[..16]));
    let parts: Vec<PathBuf> = parts.map(|part| folder_of(place).join(part)).collect();
    parts.iter().for_each(|part| clear(part));
    for part in parts {
        match new_file(&part, old) {
            Ok(file) => {
                // Where files cannot be locked nothing clears them away either.
                let locked = !matches!(file.try_lock(), Err(std::fs::TryLockError::WouldBlock));
                // Another may have cleared it away before it was locked, and put its own there.
                if locked && is_at(&file, &part).unwrap_or(false) {
                    return Ok((file, TempPath::try_from_path(&part)?));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other(format!("{WRITERS} others are writing it")))
}

fn new_file(part: &Path, old: Option<&Metadata>) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
        // Open to no more users than the file that it replaces; for a new file the umask decides.
        options.mode(old.map_or(0o666, |old| old.permissions().mode() & 0o777 | 0o600));
    }
    #[cfg(not(unix))]
    let _ = old;
    options.open(part)
}

/// Removes the part that a killed program left; a part that is still being written is locked.
fn clear(part: &Path) {
    if !std::fs::symlink_metadata(part).is_ok_and(|about| about.is_file()) {
        return;
    }
    let Ok(file) = File::open(part) else { return };
    if file.try_lock().is_ok() && is_at(&file, part).unwrap_or(false) {
        // Where that fails it stays, and another name is taken.
        let _ = std::fs::remove_file(part);
    }
}

/// Gives a new file the owner and mode of the old one, whose place it may take then.
///
/// It may not where that fails, and where the old one has other names, which must not stay behind.
#[cfg(unix)]
fn takes_after(file: &File, old: &Metadata) -> bool {
    use std::os::unix::fs::{MetadataExt, fchown};
    let Ok(new) = file.metadata() else { return false };
    let owned = (new.uid(), new.gid()) == (old.uid(), old.gid())
        || fchown(file, Some(old.uid()), Some(old.gid())).is_ok();
    old.nlink() == 1 && owned && file.set_permissions(old.permissions()).is_ok()
}

#[cfg(not(unix))]
fn takes_after(_: &File, _: &Metadata) -> bool {
    true
}

/// Writes the content of a file over the one at a place, which keeps everything else.
fn overwrite(file: &mut File, place: &Path) -> io::Result<File> {
    let mut target = OpenOptions::new().write(true).open(place)?;
    file.rewind()?;
    let length = io::copy(file, &mut target)?;
    target.set_len(length)?;
    target.sync_all()?;
    Ok(target)
}
