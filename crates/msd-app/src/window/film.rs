//! The window without a screen: frames of a given duration, as pictures in memory.

use super::canvas::{Canvas, Painting};
use super::lay_out;
use crate::panel;
use crate::viewer::Viewer;
use egui::{Event, Pos2, RawInput, Rect, vec2};
use msd_render::{Gpu, Image, RenderError, Sheet};

/// A window that is filmed: time passes as it is told, whatever the machine takes, so that the same
/// events give the same pictures.
pub struct Film {
    viewer: Viewer,
    context: egui::Context,
    canvas: Canvas,
    sheet: Sheet,
    /// Since the first frame, seconds.
    time: f64,
}

impl Film {
    /// A window of this size, pixels, each of which is a point.
    ///
    /// # Errors
    /// See [`Sheet::new`].
    pub fn new(viewer: Viewer, gpu: Gpu, [width, height]: [u32; 2]) -> Result<Self, RenderError> {
        let context = egui::Context::default();
        panel::theme::apply(&context);
        let sheet = Sheet::new(&gpu, width, height)?;
        let canvas = Canvas::new(gpu, Sheet::FORMAT);
        Ok(Film { viewer, context, canvas, sheet, time: 0.0 })
    }

    /// What it shows.
    pub fn viewer(&self) -> &Viewer {
        &self.viewer
    }

    /// Lets so many seconds pass in which the user did this, and draws the frame.
    ///
    /// # Errors
    /// See [`Sheet::read`].
    pub fn frame(&mut self, duration: f64, events: Vec<Event>) -> Result<Image, RenderError> {
        self.time += duration;
        let [width, height] = self.sheet.size().map(|side| side as f32);
        let raw = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height))),
            time: Some(self.time),
            predicted_dt: duration as f32,
            events,
            focused: true,
            ..RawInput::default()
        };
        let (output, _) = lay_out(&self.context, raw, &mut self.viewer, duration, &|| 0.0);
        let mut painting = Painting::of(&self.context, output);
        self.canvas.take_textures(&mut painting);
        self.canvas.draw(&self.sheet.target(), self.sheet.size(), &self.viewer, &painting);
        self.canvas.free_textures(&mut painting);
        self.sheet.read(&self.canvas.gpu)
    }
}
