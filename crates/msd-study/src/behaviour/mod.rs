//! Behaviour of a method on a scene: effective stiffness and damping, limits of stability, the cost
//! and effect of each model term, and the effective material of a body.

pub mod audit;
mod pulled;
pub mod inspection;
pub mod limits;
pub mod terms;
