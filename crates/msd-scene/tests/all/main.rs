//! Scene files, meshes and materials.

mod bad_files;
mod guided_pins;
mod half_spaces;
mod json_schema;
mod links_to_solids;
mod materials;
mod mesh;
mod mesh_body;
mod mesh_material;
mod mesh_solid;
mod other_kinds;
mod reference;
mod refine;
mod refusals;
mod scene_files;
mod set_materials;
mod sets;
mod shell_material;
mod thin;
mod touch;
