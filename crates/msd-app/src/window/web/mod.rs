//! The window on a page of a browser: a canvas, and what page and window tell each other.

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

/// The `id` of the canvas that the window is.
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

/// What the user did, in points of the page, and with all fingers on one screen.
fn adapted(mut raw: egui::RawInput, context: &egui::Context) -> egui::RawInput {
    join_fingers(&mut raw);
    fit_points(&mut raw, context);
    raw
}

/// Makes points those of the page, whatever pixels the canvas has: where a browser pretends to
/// another screen, the canvas keeps the pixels of the true one, and letters would be too large.
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

/// Makes all fingers those of one screen: winit gives each a device of its own, and fingers of
/// several devices make no gesture.
fn join_fingers(raw: &mut egui::RawInput) {
    for event in &mut raw.events {
        if let egui::Event::Touch { device_id, .. } = event {
            *device_id = egui::TouchDeviceId(0);
        }
    }
}

/// The canvas of the page; without one winit makes its own, which nobody sees.
fn canvas() -> Option<HtmlCanvasElement> {
    web_sys::window()?.document()?.get_element_by_id(CANVAS)?.dyn_into().ok()
}
