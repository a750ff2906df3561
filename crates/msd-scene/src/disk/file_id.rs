//! The identity of the file that a path names, however it is spelled.

use std::ffi::OsString;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};

/// The links of a chain that are followed: as many as Linux does.
const LINKS: usize = 40;

/// The identity of a regular file, there or yet to come. Two paths whose identities are equal name
/// the same file, by whatever detour, symbolic or hard link.
///
/// On other systems than Unix a file is known by its canonical path: hard links are two files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileId {
    /// A file that is there: its device and its number on it.
    Numbered {
        /// The device.
        device: u64,
        /// The number.
        inode: u64,
    },
    /// A file that is there, on a system without such numbers: its canonical path.
    At(PathBuf),
    /// A file that is not there yet: its folder and its name.
    New {
        /// The folder.
        folder: Box<FileId>,
        /// The name.
        name: OsString,
    },
}

impl FileId {
    /// The identity of the file at a path; none for a device or pipe, which many may share, and for
    /// a file in a missing folder.
    pub fn of(path: &Path) -> Option<Self> {
        match std::fs::metadata(path) {
            Ok(about) if about.is_file() => FileId::there(&about, path),
            Ok(_) => None,
            Err(_) => {
                let path = follow(path);
                let folder = folder_of(&path);
                let folder = FileId::there(&std::fs::metadata(folder).ok()?, folder)?;
                Some(FileId::New { folder: folder.into(), name: path.file_name()?.into() })
            }
        }
    }

    /// The identity of the regular file that the standard output goes to, if it does.
    #[cfg(unix)]
    pub fn of_standard_output() -> Option<Self> {
        use std::os::fd::AsFd;
        let own = std::io::stdout().as_fd().try_clone_to_owned().ok()?;
        let about = std::fs::File::from(own).metadata().ok()?;
        about.is_file().then(|| FileId::there(&about, Path::new("")))?
    }

    /// The identity of the regular file that the standard output goes to: not known here.
    #[cfg(not(unix))]
    pub fn of_standard_output() -> Option<Self> {
        None
    }

    #[cfg(unix)]
    fn there(about: &Metadata, _: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        Some(FileId::Numbered { device: about.dev(), inode: about.ino() })
    }

    #[cfg(not(unix))]
    fn there(_: &Metadata, path: &Path) -> Option<Self> {
        path.canonicalize().ok().map(FileId::At)
    }
}

/// The folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Where a file is, or will be made: at the end of a chain of links, even if nothing is there.
pub(crate) fn follow(path: &Path) -> PathBuf {
    if let Ok(found) = path.canonicalize() {
        return found;
    }
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        let Ok(target) = std::fs::read_link(&path) else { break };
        path = folder_of(&path).join(target);
    }
    path
}

/// Returns whether an open file is the one at a path, and not one that was moved away from there.
pub(crate) fn is_at(file: &std::fs::File, path: &Path) -> io::Result<bool> {
    let (open, there) = (file.metadata()?, std::fs::symlink_metadata(path)?);
    Ok(there.is_file() && FileId::there(&open, path) == FileId::there(&there, path))
}
