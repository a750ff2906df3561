//! Shells that were seen to go through each other.

use super::features::{At, Shells};
use super::row::ContactRow;
use crate::number::{Real, Vector};
use alloc::vec::Vec;

/// Two shells of which features were seen to go through each other, or one that went through
/// itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShellPassage {
    /// The first particle of each of the two shells, in the order of the shells; the same twice for
    /// one that went through itself.
    pub particles: [usize; 2],
    /// When that was first seen, to a substep, simulated seconds.
    pub time: f64,
}

impl ShellPassage {
    /// That of both sides of a row; none of a row of an obstacle.
    fn of<R: Real>(row: &ContactRow<R>, shells: &Shells, time: f64) -> Option<Self> {
        if row.is_of_obstacle() {
            return None;
        }
        let [a, b] = [row.vertices[0], row.vertices[3]].map(|vertex| shells.shell_of(vertex));
        let particles = [a.min(b), a.max(b)].map(|shell| shells.first_particle(shell));
        Some(ShellPassage { particles, time })
    }

    /// Adds it to a list that has none of the same shells yet, and not too many.
    pub(crate) fn add_to(self, passages: &mut Vec<ShellPassage>) {
        let is_known = |known: &ShellPassage| known.particles == self.particles;
        if passages.len() < MOST && !passages.iter().any(is_known) {
            passages.push(self);
        }
    }
}

/// The rows whose sides were seen to go through each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Through {
    /// Their number.
    pub(super) count: u64,
    /// Of which shells.
    pub(super) passages: Vec<ShellPassage>,
}

impl Through {
    /// Looks at a row whose normal was another one before.
    pub(super) fn look<R: Real>(&mut self, row: &ContactRow<R>, before: R::Vec3, at: &At<'_, R>) {
        if row.normal.dot(before) < R::of(TURNED_ABOUT) {
            self.count += 1;
            if let Some(passage) = ShellPassage::of(row, at.shells, at.time) {
                passage.add_to(&mut self.passages);
            }
        }
    }
}

/// The most passages of a list: where all goes through all, more say nothing new.
const MOST: usize = 16;
/// The cosine of the angle from which on a normal is turned about: more than the turn in a substep
/// of a feature that slides round a corner.
const TURNED_ABOUT: f64 = -0.5;
