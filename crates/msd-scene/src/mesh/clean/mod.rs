//! Cleaning of raw triangles: welded vertices, shared edges, faces turned outward.

pub(crate) mod inside;
pub(crate) mod topology;
pub(crate) mod winding;
pub(crate) mod interior;
pub(crate) mod parts;
pub(crate) mod overlap;
pub(crate) mod weld;
