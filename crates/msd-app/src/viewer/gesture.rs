//! A mouse gesture over the 3D view, from press to release.

use egui::{PointerButton, Pos2};
use glam::Vec3;

/// What a pressed button does until it is released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gesture {
    pub(crate) button: PointerButton,
    /// Where the pointer was when the last motion was applied.
    ///
    /// egui's own delta holds, in the frame of the press, the motion before the press too.
    pub(crate) last: Pos2,
    pub(crate) action: Action,
}

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// Turns the camera.
    Orbit,
    /// Moves the camera sideways.
    Pan,
    /// Drags a particle in the plane through `through` that faces the camera; its target stays
    /// `offset` away from the pointer, as it was when the particle was taken.
    Grab {
        /// Where the particle was when it was taken, metres.
        through: Vec3,
        /// From the pointer to the target, metres.
        offset: Vec3,
    },
}
