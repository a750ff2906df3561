//! The window on a page of a browser: a canvas, and the messages between page and window.

mod opening;
mod page;
mod clipboard;
mod fault;
mod graphics;
mod replay;
mod study;
mod verify;
mod speed;
mod host;

pub(super) use clipboard::PageClipboard;
pub use fault::report_panics;
pub(crate) use host::Page;
pub use page::start;

use super::{Missing, Shell};
use crate::viewer::Viewer;
use web_sys::HtmlCanvasElement;
use web_sys::wasm_bindgen::JsCast;

/// The `id` of the canvas of the window.
const CANVAS: &str = "canvas";

/// Shows a viewer in the canvas of the page.
fn show(viewer: Viewer) -> Result<(), Missing> {
    use winit::platform::web::EventLoopExtWebSys;
    let built = winit::event_loop::EventLoop::with_user_event().build();
    let event_loop = built.map_err(|error| Missing::Display(error.to_string()))?;
    page::listen(event_loop.create_proxy());
    let shell = Shell::new(viewer, event_loop.create_proxy(), Some(page::watcher()));
    event_loop.spawn_app(shell);
    Ok(())
}

/// Adapts the user input: points of the page, and all fingers on one device.
fn adapted(mut raw: egui::RawInput, context: &egui::Context) -> egui::RawInput {
    join_fingers(&mut raw);
    fit_points(&mut raw, context);
    raw
}

/// Uses the points of the page, independently of the pixels of the canvas. If a browser emulates
/// another screen, the canvas keeps the true pixels, and text would be too large.
fn fit_points(raw: &mut egui::RawInput, context: &egui::Context) {
    let Some(canvas) = canvas() else { return };
    let [width, height] = [canvas.client_width(), canvas.client_height()].map(|side| side as f32);
    if 0.0 < width {
        let size = egui::vec2(width, height) / context.zoom_factor();
        raw.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
        let root = raw.viewports.entry(egui::ViewportId::ROOT).or_default();
        root.native_pixels_per_point = Some(canvas.width() as f32 / width);
    }
}

/// Assigns all fingers to one device: winit gives each its own, and egui recognizes no gesture
/// across devices.
fn join_fingers(raw: &mut egui::RawInput) {
    for event in &mut raw.events {
        if let egui::Event::Touch { device_id, .. } = event {
            *device_id = egui::TouchDeviceId(0);
        }
    }
}

/// Returns the canvas of the page; without one, winit creates its own, which is not attached.
fn canvas() -> Option<HtmlCanvasElement> {
    web_sys::window()?.document()?.get_element_by_id(CANVAS)?.dyn_into().ok()
}
