//! Behaviour of a method on a scene: stiffness and damping delivered, limits of stability, what
//! each term of the model is worth, and the material that a body amounts to.

pub mod audit;
pub mod inspection;
pub mod limits;
pub mod terms;
