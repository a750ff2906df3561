//! The content of a picture: triangles, lines, points, planes and the legend, in columns as the
//! device takes them.

pub mod colour;
mod sizes;
pub(crate) mod geometry;
mod surfaces;
mod section;
mod solids;
mod marks;
pub(crate) mod ground;
pub(crate) mod compose;
mod text;
pub(crate) mod legend;
