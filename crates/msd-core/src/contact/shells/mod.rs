//! Contact between shells: rows without stiffness, solved by one sweep.
//!
//! A contact is a row: up to four particles with weights, a normal, a gap, and the impulse that it
//! has given. There is a row for each pair of features that are closest to each other: vertices,
//! edges and faces of shells (`features.rs`). Rows are found anew in every substep from the
//! positions alone (`find.rs`). The sweep of a substep starts from the impulses of the previous one
//! (`sweep.rs`). A body at rest is at rest from the first row on, and friction holds it in place.
//! Implicit methods find the impulses in their solve instead of a sweep (`solve.rs`).
//!
//! Features that may be near each other are listed for each pair of clusters, a few vertices that
//! move alike (`clusters.rs`). A list holds until the two may have approached each other by its
//! margin (`lists.rs`). A row depends on positions and features alone, rows are sorted, and one
//! without an impulse does nothing. So the bits do not depend on when lists were made. Methods ask
//! `rows.rs`.
//!
//! Sources: Moreau, 1988, and Jean, 1999 (nonsmooth contact dynamics); Catto, 2005 (accumulated
//! impulses).

mod features;
mod clusters;
mod row;
mod distance;
mod passage;
mod margins;
mod lists;
mod patch;
mod find;
mod sweep;
mod overlaps;
mod rows;
mod solve;

pub(crate) use features::{At, Shells};
pub use passage::ShellPassage;
pub use row::RowImpulse;
pub(crate) use rows::ShellRows;
