//! Scenes of the user's own in links: a file and its meshes, compressed.

use super::error::LinkError;
use super::seal::{seal, unseal};
use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::{TINFLStatus, decompress_to_vec_with_limit};
use msd_scene::{FileError, Loaded};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Version of the encoding; raised with each change of it.
const FORMAT: u8 = 1;
/// Limit on the size of a scene in a link, bytes: a short text may decompress to any size.
const LARGEST: usize = 1_000_000;
/// Level of compression, of 10: the next one takes twice the time and saves little.
const EFFORT: u8 = 8;

/// A scene of the user's own, as the bytes of its file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OwnScene {
    /// Name of the file, with its extension.
    pub file: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Contents of its mesh files, by their names in the scene.
    pub meshes: BTreeMap<String, Vec<u8>>,
}

impl OwnScene {
    /// Returns a scene without meshes.
    ///
    /// # Errors
    /// A line that says that the file is too large for a link.
    pub fn new(file: &str, bytes: &[u8]) -> Result<Self, String> {
        if LARGEST <= bytes.len() {
            return Err(too_large(file, bytes.len()));
        }
        let (file, bytes, meshes) = (file.to_owned(), bytes.to_vec(), BTreeMap::new());
        Ok(OwnScene { file, bytes, meshes })
    }

    /// Returns the source of a loaded scene: `own` if given, else the current content of its files.
    ///
    /// # Errors
    /// A line on why a link cannot hold it.
    pub fn of(loaded: &Loaded, own: Option<&Result<Self, String>>) -> Result<Self, String> {
        let own = own.cloned().unwrap_or_else(|| OwnScene::read(&loaded.files))?;
        let read = own.load().map_err(|error| error.to_string())?;
        if read.scene == loaded.scene {
            return Ok(own);
        }
        // The file has changed since, or the command line changes the scene: a link would be wrong.
        Err(format!("{} differs from the opened scene: open it again for a link", own.file))
    }

    /// Reads the files of a scene again: its own, then those of its meshes.
    ///
    /// # Errors
    /// A line on why a file cannot be read, or that it is too large for a link.
    fn read(files: &[PathBuf]) -> Result<Self, String> {
        let [scene, meshes @ ..] = files else { return Err("it is not from a file".into()) };
        let folder = scene.parent().unwrap_or(Path::new("")).join("");
        let read = |path: &Path| {
            // The name as the scene has it: stripping folders by path would lose a leading dot.
            let name = path.to_string_lossy();
            let name = name.strip_prefix(&*folder.to_string_lossy()).unwrap_or(&name).to_owned();
            let why = |error| format!("{name}: {error}");
            let size = path.metadata().map_err(why)?.len();
            if LARGEST as u64 <= size {
                return Err(too_large(&name, size as usize));
            }
            Ok((name.clone(), std::fs::read(path).map_err(why)?))
        };
        let (file, bytes) = read(scene)?;
        let meshes = meshes.iter().map(|mesh| read(mesh)).collect::<Result<_, _>>()?;
        Ok(OwnScene { file, bytes, meshes })
    }

    /// Opens the scene.
    ///
    /// # Errors
    /// See [`msd_scene::open_bytes_with`].
    pub(super) fn load(&self) -> Result<Loaded, FileError> {
        msd_scene::open_bytes_with(&self.file, &self.bytes, &self.meshes)
    }

    /// Returns the name of the scene.
    pub(super) fn name(&self) -> String {
        let stem = Path::new(&self.file).file_stem().unwrap_or_default().to_string_lossy();
        stem.chars().filter(|letter| !letter.is_control()).collect()
    }

    /// Returns the name of the largest of its files and its size, bytes.
    fn largest(&self) -> (&str, usize) {
        let own = (&*self.file, self.bytes.len());
        let meshes = self.meshes.iter().map(|(name, bytes)| (&**name, bytes.len()));
        meshes.chain([own]).max_by_key(|(_, size)| *size).unwrap_or(own)
    }

    /// Encodes the scene for a link.
    ///
    /// # Errors
    /// A line that names the largest file if the text is longer than `longest` characters.
    pub(super) fn encode(&self, longest: usize) -> Result<String, String> {
        let (name, size) = self.largest();
        let content = postcard::to_stdvec(self).map_err(|error| error.to_string())?;
        if LARGEST < content.len() {
            return Err(too_large(name, size));
        }
        let text = seal(FORMAT, &compress_to_vec(&content, EFFORT));
        if longest < text.len() { Err(too_large(name, size)) } else { Ok(text) }
    }

    /// Decodes the scene of a link.
    ///
    /// # Errors
    /// See [`LinkError`]. [`OwnScene::load`] checks whether the content is a scene.
    pub(super) fn decode(text: &str) -> Result<Self, LinkError> {
        let (_, content) = unseal(FORMAT..=FORMAT, text)?;
        let content = decompress_to_vec_with_limit(&content, LARGEST).map_err(|error| {
            let is_more = error.status == TINFLStatus::HasMoreOutput;
            if is_more { LinkError::TooLarge } else { LinkError::Damaged }
        })?;
        postcard::from_bytes(&content).map_err(|_| LinkError::Damaged)
    }
}

fn too_large(name: &str, size: usize) -> String {
    let kilobytes = size.div_ceil(1000);
    format!("{name} is too large for a link, {kilobytes} kB: send the file instead")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(format: u8, content: &[u8]) -> String {
        seal(format, &compress_to_vec(content, EFFORT))
    }

    #[test]
    fn a_text_that_unfolds_to_more_than_the_limit_is_refused() {
        let bomb = text(FORMAT, &vec![0; 200 * LARGEST]);
        assert!(bomb.len() < LARGEST, "{}", bomb.len());
        assert_eq!(OwnScene::decode(&bomb), Err(LinkError::TooLarge));
    }

    #[test]
    fn what_is_whole_and_no_scene_or_of_another_format_is_refused() {
        assert_eq!(OwnScene::decode(&text(FORMAT, b"\xff")), Err(LinkError::Damaged));
        assert_eq!(OwnScene::decode(&text(FORMAT + 1, b"")), Err(LinkError::Format(FORMAT + 1)));
        assert_eq!(OwnScene::decode(""), Err(LinkError::Damaged));
    }
}
