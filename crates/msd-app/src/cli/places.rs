//! A check that no command overwrites its input, nor one output with another.

use super::failure::Failure;
use msd_scene::{FileId, shown_path};
use std::path::{Path, PathBuf};

/// The files of a command, with their names on the command line.
pub struct Places(Vec<(String, FileId)>);

impl Default for Places {
    /// Contains only the file of the standard output, if it is one.
    fn default() -> Self {
        let own = FileId::of_standard_output();
        Places(own.map(|id| ("the standard output".into(), id)).into_iter().collect())
    }
}

impl Places {
    /// Contains the files of a scene and the saved run that it continues from, too.
    pub fn of(scene: &[PathBuf], from: Option<&Path>) -> Self {
        let mut places = Places::default();
        scene.iter().for_each(|file| places.read("SCENE", file));
        from.iter().for_each(|state| places.read("--from", state));
        places
    }

    /// Adds a file that is read.
    pub fn read(&mut self, option: &str, path: &Path) {
        self.0.extend(FileId::of(path).map(|id| (option.into(), id)));
    }

    /// Adds a file that will be written.
    ///
    /// # Errors
    /// Another of the files is the same, by any path or link.
    pub fn write(&mut self, option: &str, path: &Path) -> Result<(), Failure> {
        // A missing folder is reported when the file is opened.
        let Some(id) = FileId::of(path) else { return Ok(()) };
        if let Some((other, _)) = self.0.iter().find(|(_, other)| *other == id) {
            let path = shown_path(path);
            return Err(Failure::input(format!("{other} and {option} name the same file, {path}")));
        }
        self.0.push((option.into(), id));
        Ok(())
    }
}

/// Makes a folder for later files, so that a failure is reported before the work.
pub fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::input(format!("{}: {error}", shown_path(folder))))
}
