//! Meshes: OBJ, STL, PLY and glTF in; particles and springs out.
//!
//! [`read`] or [`parse`] gives a [`Mesh`]: duplicate vertices welded, degenerate faces dropped,
//! faces turned outward, and a [`MeshReport`] that counts them. [`body`] turns the mesh into a
//! [`Part`](msd_core::Part): a solid with an interior lattice if it is closed, else a shell.
//! [`distances`] turns it into the shape of an obstacle.
//!
//! ```
//! use msd_scene::mesh::{self, Format, MeshOptions};
//!
//! let tetrahedron = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
//! let mesh = mesh::parse(tetrahedron, Format::Obj, "tetrahedron.obj")?;
//! assert!(mesh.is_closed());
//! let (part, report) = mesh::body(&mesh, &MeshOptions::default())?;
//! assert_eq!(part.particles.len(), report.surface_particles + report.interior_particles);
//! # Ok::<(), mesh::MeshError>(())
//! ```

mod error;
mod polygon;
mod raw;
mod clean;
mod read;
mod foreign;
mod import;
mod subdivide;
mod fill;
mod distances;

pub(crate) use clean::inside::Inside;
pub use distances::distances;
pub use error::{MeshError, Row};
pub use fill::{BodyReport, Filling, MeshOptions, body};
pub(crate) use fill::{estimate, is_solid, own_spacing};
pub use import::{Format, Mesh, MeshReport, parse, read};
pub use raw::Group;
pub(crate) use subdivide::{edge_ends, subdivided};
