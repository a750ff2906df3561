//! An offscreen window: frames of a given duration, as images in memory.

use super::super::canvas::{Canvas, Painting};
use super::super::lay_out;
use crate::panel;
use crate::viewer::Viewer;
use egui::accesskit::{Node, NodeId, Role};
use egui::{Event, Pos2, RawInput, Rect, pos2, vec2};
use msd_render::{Gpu, Image, Quality, RenderError, Sheet};

/// A window with simulated time, independent of the speed of the machine, so that the same events
/// give the same images.
pub struct Film {
    viewer: Viewer,
    context: egui::Context,
    canvas: Canvas,
    sheet: Sheet,
    /// Time since the first frame, seconds.
    time: f64,
    /// The controls of the last frame.
    controls: Vec<(NodeId, Node)>,
}

impl Film {
    /// Creates a window of this size, pixels, with one pixel per point.
    ///
    /// # Errors
    /// See [`Sheet::new`].
    pub fn new(viewer: Viewer, gpu: Gpu, [width, height]: [u32; 2]) -> Result<Self, RenderError> {
        let context = egui::Context::default();
        panel::theme::apply(&context);
        context.enable_accesskit();
        let sheet = Sheet::new(&gpu, width, height)?;
        let canvas = Canvas::new(gpu, (Sheet::FORMAT, Quality::Full));
        Ok(Film { viewer, context, canvas, sheet, time: 0.0, controls: Vec::new() })
    }

    /// Returns its viewer.
    pub fn viewer(&self) -> &Viewer {
        &self.viewer
    }

    /// Returns the area of a control in the last frame, by role and start of its name or label.
    pub fn place(&self, role: Role, name: &str) -> Option<Rect> {
        let begins = |text: Option<&str>| text.is_some_and(|text| text.starts_with(name));
        let is_named = |node: &Node| begins(node.label()) || begins(node.value());
        let names = |id: &NodeId| self.controls.iter().any(|(at, node)| at == id && is_named(node));
        let is_meant = |node: &Node| {
            node.role() == role && (is_named(node) || node.labelled_by().iter().any(names))
        };
        let (_, node) = self.controls.iter().find(|(_, node)| is_meant(node))?;
        let bounds = node.bounds()?;
        let corner = |x: f64, y: f64| pos2(x as f32, y as f32);
        Some(Rect::from_min_max(corner(bounds.x0, bounds.y0), corner(bounds.x1, bounds.y1)))
    }

    /// Advances by a duration, seconds, with these events, and renders the frame.
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
        let (mut output, _) = lay_out(&self.context, raw, &mut self.viewer, duration, &|| 0.0);
        let update = output.platform_output.accesskit_update.take();
        self.controls = update.map(|update| update.nodes).unwrap_or_default();
        let mut painting = Painting::of(&self.context, output);
        self.canvas.take_textures(&mut painting);
        self.canvas.draw(&self.sheet.target(), self.sheet.size(), &self.viewer, &painting);
        self.canvas.free_textures(&mut painting);
        if let Some(gallery) = &mut self.viewer.layout.gallery {
            gallery.draw_next(&self.canvas.gpu, &self.context);
        }
        self.sheet.read(&self.canvas.gpu)
    }
}
