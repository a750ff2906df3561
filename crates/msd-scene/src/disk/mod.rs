//! Files on a disk: which one a path names, how they are read, and how they appear whole.

mod file_id;
mod input;
mod output;
mod spool;

pub use file_id::FileId;
pub(crate) use input::{open_regular, reason};
pub use output::{Output, write_file};
pub use spool::Spool;
