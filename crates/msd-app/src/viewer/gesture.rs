//! Mouse gestures over the 3D view, from press to release, and the tool that selects them.

use super::Side;
use egui::{PointerButton, Pos2};
use glam::Vec3;

/// Tool of a drag with the left button over the 3D view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Grabs the particle or the solid under the pointer; on empty space it orbits.
    #[default]
    Grab,
    /// Draws a box and selects the particles in it as a group.
    Select,
    /// Cuts every spring that it crosses on the screen.
    Cut,
}

/// State of the pointer over the 3D view.
#[derive(Debug, Default)]
pub struct PointerState {
    /// Tool of a left drag.
    pub tool: Tool,
    /// Gesture between press and release.
    pub(crate) gesture: Option<Gesture>,
    /// Path of a cut so far, points of the window.
    pub(crate) stroke: Vec<Pos2>,
    /// The hovered particle.
    pub(crate) hovered: Option<usize>,
    /// The hovered solid, if no particle is hovered.
    pub(crate) hovered_solid: Option<usize>,
}

/// A gesture from press to release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gesture {
    pub(crate) button: PointerButton,
    /// Position of the pointer at the last applied motion.
    ///
    /// In the frame of the press, egui's own delta includes the motion before the press.
    pub(crate) last: Pos2,
    /// Side where it began, whose viewport it uses until its end.
    pub(crate) side: Side,
    pub(crate) action: Action,
}

/// Effect of a drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// Orbits the camera.
    Orbit,
    /// Pans the camera.
    Pan,
    /// Draws a box.
    Select {
        /// The first corner, points of the window.
        from: Pos2,
    },
    /// Cuts springs.
    Cut,
    /// Drags a particle or a solid in the plane through `through` that faces the camera; its target
    /// keeps the initial `offset` from the pointer.
    Grab {
        /// Position at the grab, metres.
        through: Vec3,
        /// Offset from the pointer to the target, metres.
        offset: Vec3,
    },
}
