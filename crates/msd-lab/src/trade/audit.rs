//! What stiffness and damping does a method deliver? A weight is hung up, a string is plucked.

use super::choice::Choice;
use serde::{Deserialize, Serialize};

/// What a spring does under a choice, against what it should.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// The choice.
    pub choice: Choice,
    /// Measured stiffness over that of the springs.
    pub stiffness: f64,
    /// Measured damping ratio over the exact one.
    pub damping: f64,
    /// Measured period over the exact one, less 1.
    pub period: f64,
}
