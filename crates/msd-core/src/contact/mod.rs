//! Contact of particles with obstacles.
//!
//! A particle that has met an obstacle, or lies on some, is put where their surfaces leave it, and
//! gets the velocity that they leave it. That is one law (`law.rs`, of a single surface; `held.rs`,
//! of several at a time). Methods ask for it at moments of their own: at the end of a substep
//! (`arrive.rs`), after each kick (`after_kick/`), inside the solve (`methods/implicit`), at the
//! time of an impact (`methods/dormand_prince`). The first two share the contacts found at the
//! positions of a moment (`found.rs`). The gap of a particle is that of its middle, less its radius
//! where that counts (`radii.rs`).

mod radii;
pub(crate) mod law;
pub(crate) mod found;
pub(crate) mod held;
pub(crate) mod passage;
pub(crate) mod ending;
mod landing;
pub(crate) mod arrive;
pub(crate) mod after_kick;
pub(crate) mod points;
pub(crate) mod shells;

pub use law::Contacts;
pub(crate) use law::Evaluated;
pub(crate) use radii::Radii;
