//! The past of a session: the states that one looks back to, with marks, and what can be undone.

mod timeline;
mod undo;
mod acts;

pub use timeline::{Mark, MarkKind, Timeline};
pub use undo::{Before, Deed, Undo};
