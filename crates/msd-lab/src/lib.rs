//! Scene files, built-in scenes, meshes and state files.
