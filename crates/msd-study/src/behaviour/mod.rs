//! Behaviour of a method on a scene: stiffness and damping delivered, limits of stability, and what
//! each term of the model is worth.

pub mod audit;
pub mod limits;
pub mod terms;
