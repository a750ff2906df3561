//! Candidates: what may be chosen for a scene, and which choices are worth trying.

pub mod choice;
pub mod ladder;
