//! The past of a session: earlier states with marks, and undo.

mod timeline;
mod undo;
mod acts;

pub use timeline::{Mark, MarkKind, Timeline};
pub use undo::{Before, Deed, Undo};
