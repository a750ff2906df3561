//! A cache of costly results, in the cache folder of the user, by the hash of its content.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::PathBuf;

/// The folder of the cache: `MSD_CACHE` where that is set, else the cache folder of the user; none
/// on a machine without one. An empty `MSD_CACHE` means no cache.
pub fn folder() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("MSD_CACHE") {
        return Some(PathBuf::from(folder)).filter(|folder| !folder.as_os_str().is_empty());
    }
    #[cfg(not(target_arch = "wasm32"))]
    return directories::ProjectDirs::from("", "", "msd").map(|dirs| dirs.cache_dir().to_owned());
    #[cfg(target_arch = "wasm32")]
    return None;
}

/// Raised whenever a change of msd makes earlier entries wrong.
const REVISION: u32 = 2;

/// The hash of anything that can be written down, 32 hexadecimal digits: BLAKE3 (O'Connor and
/// others, 2020) of its postcard bytes, of the version of msd and of the revision of the
/// cache.
pub fn content_hash(content: &impl Serialize) -> String {
    let bytes = postcard::to_allocvec(content).unwrap_or_default();
    let mut hasher = blake3::Hasher::new();
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    hasher.update(&REVISION.to_le_bytes()).update(&bytes);
    hasher.finalize().to_hex()[..32].to_owned()
}

/// Reads the entry of an earlier run; returns none for a file that cannot be read or understood.
pub fn get<T: DeserializeOwned>(kind: &str, hash: &str) -> Option<T> {
    let bytes = std::fs::read(folder()?.join(format!("{kind}-{hash}"))).ok()?;
    let (sum, content) = bytes.split_at_checked(32)?;
    // A disk may have run full, or another program may have written: a wrong sum is not used.
    (blake3::hash(content).as_bytes()[..] == *sum).then_some(())?;
    postcard::from_bytes(content).ok()
}

/// Removes an entry.
pub fn remove(kind: &str, hash: &str) {
    if let Some(folder) = folder() {
        let _ = std::fs::remove_file(folder.join(format!("{kind}-{hash}")));
    }
}

/// Keeps something for a later run. A failure is not an error: the later run takes longer.
pub fn put(kind: &str, hash: &str, value: &impl Serialize) {
    let write = || -> Option<()> {
        let folder = folder()?;
        std::fs::create_dir_all(&folder).ok()?;
        let content = postcard::to_allocvec(value).ok()?;
        let sum = blake3::hash(&content);
        let path = folder.join(format!("{kind}-{hash}"));
        let mut file = tempfile::NamedTempFile::new_in(&folder).ok()?;
        std::io::Write::write_all(&mut file, sum.as_bytes()).ok()?;
        std::io::Write::write_all(&mut file, &content).ok()?;
        file.persist(path).ok()?;
        Some(())
    };
    let _ = write();
}
