//! The envelope of files of msd: their kind, their format, and a hash of each frame.
//!
//! A file starts with a line of text, `msd KIND, format N`. Frames follow: the length of their
//! content (8 bytes, the lowest first), the content, and its BLAKE3 hash (O'Connor and others,
//! 2020; 32 bytes).

use crate::disk::{Output, open_regular};
use crate::error::{FileError, Place, one_line};
use crate::shown::shown_path;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{Read, Write};
use std::path::Path;

/// A kind of file, and the format of it that this msd writes and reads.
#[derive(Clone, Copy, Debug)]
pub struct FileKind {
    /// Its kind, as a message says it.
    pub what: &'static str,
    /// The number of its format.
    pub format: u32,
    /// The oldest format that this msd reads.
    pub oldest: u32,
}

/// Longer than any first line, bytes.
const LONGEST_LINE: usize = 64;
/// The largest file, bytes: a system of the most particles and springs takes less.
const LARGEST: u64 = 8 << 30;
/// Bytes of the length and of the hash of a frame.
const LENGTH: usize = 8;
const HASH: usize = 32;

impl FileKind {
    /// The first line of a file of this kind.
    fn line(&self) -> String {
        let FileKind { what, format, .. } = self;
        format!("msd {what}, format {format}\n")
    }

    /// Writes the first line of a file of this kind and its first frame.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn begin(&self, output: &mut Output, content: &impl Serialize) -> Result<(), FileError> {
        let written = frame(content).and_then(|frame| {
            output.write_all(self.line().as_bytes())?;
            output.write_all(&frame)
        });
        written.map_err(|error| output.refused(&error))
    }

    /// The bytes of a file of this kind with one frame.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn bytes(&self, content: &impl Serialize) -> Result<Vec<u8>, FileError> {
        let refused = |error: std::io::Error| {
            let reason = error.to_string();
            FileError::Unwritable { file: self.what.into(), reason }
        };
        frame_after(self.line().as_bytes(), content).map_err(refused)
    }

    /// Reads a file into memory once its first line is that of this kind.
    ///
    /// # Errors
    /// A file that cannot be read, and the errors of [`FileKind::frames`].
    pub fn load(&self, path: &Path) -> Result<Vec<u8>, FileError> {
        let file = shown_path(path);
        let refused = |reason: String| FileError::Unreadable { file: file.clone(), reason };
        let mut source = open_regular(path, LARGEST + 1)?;
        let mut bytes = Vec::new();
        let mut read = |limit: u64, bytes: &mut Vec<u8>| {
            source.by_ref().take(limit).read_to_end(bytes).map_err(|e| refused(e.to_string()))
        };
        read(LONGEST_LINE as u64, &mut bytes)?;
        self.frames(&bytes, &file)?;
        read(LARGEST, &mut bytes)?;
        if LARGEST < bytes.len() as u64 {
            return Err(refused(format!("it is longer than {} GiB", LARGEST >> 30)));
        }
        Ok(bytes)
    }

    /// The frames of a file called `name`, after its first line is found to be that of this kind.
    ///
    /// # Errors
    /// [`FileError::Malformed`] for another kind of file, [`FileError::Format`] for another format.
    pub fn frames<'a>(&self, bytes: &'a [u8], name: &'a str) -> Result<Frames<'a>, FileError> {
        let FileKind { what, format: known, oldest } = *self;
        let wrong = |reason: String| malformed(name, reason);
        let start = &bytes[..bytes.len().min(LONGEST_LINE)];
        let end = start.iter().position(|&byte| byte == b'\n');
        let line = end.and_then(|end| std::str::from_utf8(&start[..end]).ok());
        let told = line.and_then(|line| line.strip_prefix("msd ")?.split_once(", format "));
        let told = told.and_then(|(kind, format)| Some((kind, format.parse().ok()?)));
        let Some((kind, found)) = told.filter(|(kind, _)| is_plain(kind)) else {
            return Err(wrong(format!("is not a {what} of msd")));
        };
        if kind != what {
            return Err(wrong(format!("is a {kind}, not a {what}")));
        }
        if !(oldest..=known).contains(&found) {
            return Err(FileError::Format { file: name.into(), what, found, known });
        }
        let at = end.map_or(0, |end| end + 1);
        Ok(Frames { bytes, at, name })
    }
}

/// The frames of a file, one after the other.
#[derive(Debug)]
pub struct Frames<'a> {
    bytes: &'a [u8],
    /// Where the next frame starts.
    at: usize,
    name: &'a str,
}

/// The result of looking for a frame.
#[derive(Debug)]
pub enum Found<'a> {
    /// A whole frame with this content.
    Whole(&'a [u8]),
    /// Nothing: the file ends here.
    End,
    /// A part of a frame at the end of the file.
    Torn,
    /// A frame whose content differs from what was written.
    Damaged,
}

impl<'a> Frames<'a> {
    /// Looks for the next frame; after one that is not whole there is none.
    pub fn next_frame(&mut self) -> Found<'a> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        self.at = self.bytes.len();
        let Some((length, rest)) = rest.split_first_chunk::<LENGTH>() else {
            return if rest.is_empty() { Found::End } else { Found::Torn };
        };
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let Some((content, rest)) = rest.split_at_checked(length) else { return Found::Torn };
        let Some((hash, rest)) = rest.split_first_chunk::<HASH>() else { return Found::Torn };
        if blake3::hash(content).as_bytes() != hash {
            return Found::Damaged;
        }
        self.at = self.bytes.len() - rest.len();
        Found::Whole(content)
    }

    /// Bytes from the next frame on.
    pub fn rest(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Takes the next frame apart, which must be there.
    ///
    /// # Errors
    /// [`FileError::Malformed`].
    pub fn expect<T: DeserializeOwned>(&mut self) -> Result<T, FileError> {
        match self.next_frame() {
            Found::Whole(content) => self.decode(content),
            Found::End | Found::Torn => Err(malformed(self.name, "is cut short".into())),
            Found::Damaged => Err(self.damaged()),
        }
    }

    /// Takes a content apart.
    ///
    /// # Errors
    /// [`FileError::Malformed`].
    pub fn decode<T: DeserializeOwned>(&self, content: &[u8]) -> Result<T, FileError> {
        let wrong = |reason: String| malformed(self.name, reason);
        // Its hash fits, so another program made it. The length of the content bounds the
        // allocation.
        match postcard::take_from_bytes(content) {
            Ok((value, [])) => Ok(value),
            Ok((_, rest)) => Err(wrong(format!("has {} bytes too many in a part", rest.len()))),
            Err(error) => Err(wrong(format!("cannot be understood: {}", one_line(error)))),
        }
    }

    /// The error of a frame whose content differs from what was written.
    pub fn damaged(&self) -> FileError {
        self.malformed("is damaged: its checksum does not fit")
    }

    /// The error of a file that is not as it should be.
    pub fn malformed(&self, reason: &str) -> FileError {
        malformed(self.name, reason.into())
    }
}

/// Whether a word from outside may stand in a message.
fn is_plain(word: &str) -> bool {
    word.chars().all(|letter| letter.is_ascii_lowercase() || letter == ' ')
}

fn malformed(name: &str, reason: String) -> FileError {
    FileError::Malformed { place: Place { file: name.into(), position: None }, reason }
}

/// Puts a content into a frame.
///
/// # Errors
/// A content that postcard cannot write.
pub fn frame(content: &impl Serialize) -> std::io::Result<Vec<u8>> {
    frame_after(&[], content)
}

/// The bytes of a frame after those of `head`.
fn frame_after(head: &[u8], content: &impl Serialize) -> std::io::Result<Vec<u8>> {
    // Not `to_extend`, which takes twice as long.
    let content = postcard::to_stdvec(content).map_err(std::io::Error::other)?;
    let length = (content.len() as u64).to_le_bytes();
    let hash = blake3::hash(&content);
    Ok([head, &length, &content, hash.as_bytes()].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: FileKind = FileKind { what: "test", format: 2, oldest: 2 };

    fn file() -> Vec<u8> {
        let mut bytes = KIND.line().into_bytes();
        bytes.extend(frame(&"first").expect("a frame"));
        bytes.extend(frame(&7u32).expect("a frame"));
        bytes
    }

    #[test]
    fn frames_come_back_in_order() {
        let bytes = file();
        let mut frames = KIND.frames(&bytes, "f").expect("a test file");
        assert_eq!(frames.expect::<String>().expect("a text"), "first");
        assert_eq!(frames.expect::<u32>().expect("a number"), 7);
        assert!(matches!(frames.next_frame(), Found::End));
    }

    #[test]
    fn a_cut_anywhere_in_a_frame_is_torn_and_a_changed_byte_is_damage() {
        let bytes = file();
        let first = KIND.line().len();
        let frame = first..first + LENGTH + 6 + HASH;
        for end in frame.start + 1..frame.end {
            let mut frames = KIND.frames(&bytes[..end], "f").expect("a first line");
            assert!(matches!(frames.next_frame(), Found::Torn), "{end}");
            assert!(matches!(frames.next_frame(), Found::End), "{end}");
        }
        for at in frame.start + LENGTH..frame.end {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            let mut frames = KIND.frames(&changed, "f").expect("a first line");
            assert!(matches!(frames.next_frame(), Found::Damaged), "{at}");
        }
    }

    #[test]
    fn a_length_that_lies_allocates_nothing() {
        let mut bytes = KIND.line().into_bytes();
        bytes.extend(u64::MAX.to_le_bytes());
        let mut frames = KIND.frames(&bytes, "f").expect("a first line");
        assert!(matches!(frames.next_frame(), Found::Torn));
    }

    #[test]
    fn another_kind_format_or_no_file_of_msd_is_refused_by_name() {
        let told = |bytes: &[u8]| KIND.frames(bytes, "f").expect_err("a refusal").to_string();
        assert_eq!(
            told(b"msd test, format 3\n"),
            "f: is a test of format 3; this msd reads format 2"
        );
        assert_eq!(told(b"msd song, format 2\n"), "f: is a song, not a test");
        let others = [&b""[..], b"msd", b"msd test, format 2", b"\xff\n", &[b'a'; 1000]];
        for bytes in
            others.into_iter().chain([&b"msd test, format x\n"[..], b"msd \x1b, format 2\n"])
        {
            assert_eq!(told(bytes), "f: is not a test of msd");
        }
    }
}
