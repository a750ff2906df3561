//! Pictures, by an adapter where there is one.

mod scenes;
mod camera;
mod gallery;
mod hidden;
mod pictures;
mod shade;
mod shaders;
