//! Candidates: the possible choices for a scene, and those that are worth a trial.

pub mod choice;
pub mod ladder;
