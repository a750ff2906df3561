//! Bytes whose number is only known at the end, kept on the disk until then.

use crate::disk::file_id::folder_of;
use crate::disk::output::Output;
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

/// A file without a name that is copied into an [`Output`] when the content before it is known. It
/// vanishes with the program, however that ends.
#[derive(Debug)]
pub struct Spool {
    writer: BufWriter<File>,
    length: u64,
    check: crc32fast::Hasher,
}

impl Spool {
    /// An empty one beside a file, whose disk has room for it, or else where temporary files go.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn beside(path: &Path) -> io::Result<Self> {
        let file = tempfile::tempfile_in(folder_of(path)).or_else(|_| tempfile::tempfile())?;
        Ok(Spool { writer: BufWriter::new(file), length: 0, check: crc32fast::Hasher::new() })
    }

    /// The number of bytes so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The check sum so far, CRC-32.
    pub fn check(&self) -> &crc32fast::Hasher {
        &self.check
    }

    /// Copies all of it to the end of an output.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn copy_to(self, output: &mut Output) -> io::Result<()> {
        let mut file = self.writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        io::copy(&mut file, output).map(drop)
    }
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(bytes)?;
        self.check.update(&bytes[..written]);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}
