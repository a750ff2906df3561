//! Mouse gestures over the 3D view, from press to release, and the tool that decides which.

use super::Side;
use egui::{PointerButton, Pos2};
use glam::Vec3;

/// What a drag with the left button does over the 3D view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Takes the particle or the solid under the pointer; beside them it turns the camera.
    #[default]
    Grab,
    /// Draws a box: the particles in it are taken together from then on.
    Select,
    /// Cuts every spring that it crosses in the picture.
    Cut,
}

/// What the pointer does in the picture.
#[derive(Debug, Default)]
pub struct PointerState {
    /// What a left drag does.
    pub tool: Tool,
    /// What the mouse does between press and release.
    pub(crate) gesture: Option<Gesture>,
    /// Where a cut went so far, points of the window.
    pub(crate) stroke: Vec<Pos2>,
    /// The particle under the pointer.
    pub(crate) hovered: Option<usize>,
    /// The solid under the pointer, if no particle is.
    pub(crate) hovered_solid: Option<usize>,
}

/// What a pressed button does until it is released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gesture {
    pub(crate) button: PointerButton,
    /// Where the pointer was when the last motion was applied.
    ///
    /// egui's own delta holds, in the frame of the press, the motion before the press too.
    pub(crate) last: Pos2,
    /// Where it began: it goes on by the picture of that side.
    pub(crate) side: Side,
    pub(crate) action: Action,
}

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// Turns the camera.
    Orbit,
    /// Moves the camera sideways.
    Pan,
    /// Draws a box from here.
    Select {
        /// The corner where it began, points of the window.
        from: Pos2,
    },
    /// Cuts springs.
    Cut,
    /// Drags a particle or a solid in the plane through `through` that faces the camera; its target
    /// stays `offset` away from the pointer, as it was when it was taken.
    Grab {
        /// Where it was taken, metres.
        through: Vec3,
        /// From the pointer to the target, metres.
        offset: Vec3,
    },
}
