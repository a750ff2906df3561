//! Readers of the mesh formats: bytes in, raw triangles out.

pub(crate) mod obj_file;
pub(crate) mod stl_file;
pub(crate) mod ply_file;
pub(crate) mod gltf_file;
