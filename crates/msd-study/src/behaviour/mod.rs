//! Behaviour of a method on a scene: stiffness and damping delivered, limits of stability, the
//! parts of a model and what each is worth, and the material that a body amounts to.

pub mod audit;
mod pulled;
pub mod inspection;
pub mod limits;
pub mod terms;
