//! Parts of a model that can be switched off, and the wind that acts on it.

pub mod parts;
mod wind;

pub use wind::Wind;
