//! The sides of the view: the run, and the twin beside it if the user wants to see both.

use super::{Viewer, Viewport};
use egui::{Pos2, Rect, pos2};
use msd_run::Runner;

/// One of two runs in the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// The run.
    #[default]
    Run,
    /// Its twin.
    Twin,
}

impl Viewer {
    /// Returns the visible sides, from left to right.
    pub fn sides(&self) -> &'static [Side] {
        match self.layout.side_by_side && self.session.twin().is_some() {
            true => &[Side::Run, Side::Twin],
            false => &[Side::Run],
        }
    }

    /// Shows the twin beside the run, or as a ghost over it.
    pub(crate) fn set_side_by_side(&mut self, on: bool) {
        self.let_go();
        self.layout.side_by_side = on;
        self.frame_all();
    }

    /// Returns the run of a side.
    pub fn runner_of(&self, side: Side) -> &Runner {
        match (side, self.session.twin()) {
            (Side::Twin, Some(twin)) => twin.runner(),
            _ => self.session.runner(),
        }
    }

    /// Returns the viewport of a side; both have the same camera.
    pub fn viewport_of(&self, side: Side) -> Viewport {
        let (whole, middle) = (self.layout.rect, self.layout.rect.center().x);
        let rect = match (self.sides(), side) {
            ([_], _) => whole,
            (_, Side::Run) => Rect::from_min_max(whole.min, pos2(middle, whole.bottom())),
            (_, Side::Twin) => Rect::from_min_max(pos2(middle, whole.top()), whole.max),
        };
        Viewport { camera: self.camera, rect }
    }

    /// Returns the viewport of the run.
    pub fn viewport(&self) -> Viewport {
        self.viewport_of(Side::Run)
    }

    /// Returns the side under a point of the window.
    pub(crate) fn side_at(&self, at: Pos2) -> Side {
        match self.sides() {
            [_, _] if self.layout.rect.center().x <= at.x => Side::Twin,
            _ => Side::Run,
        }
    }
}
