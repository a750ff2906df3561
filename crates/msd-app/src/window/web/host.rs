//! The page of a browser as the host of a window.

use super::super::canvas::Painting;
use super::super::error::Missing;
use super::super::host::Host;
use super::super::surface::WindowSurface;
use super::super::{Shell, panel_context, panel_input};
use super::graphics::watch_device;
use super::page::{PageEvent, give, keep, tell};
use super::{adapted, canvas};
use crate::panel;
use crate::viewer::{Preferences, Viewer};
use std::time::Duration;
use web_time::Instant;
use winit::event_loop::ActiveEventLoop;
use winit::platform::web::WindowAttributesExtWebSys;
use winit::window::WindowAttributes;

/// Interval between writes of the preferences.
const KEPT_EVERY: Duration = Duration::from_secs(1);

/// The page of a browser.
pub(crate) struct Page {
    last_kept: Instant,
    is_lost: bool,
    /// Next piece of the panels for the hidden layout before the first frame.
    rehearsed: Option<usize>,
}

impl Host for Page {
    type Event = PageEvent;
    const ENDS_UNNOTICED: bool = true;

    fn new(_: &Viewer) -> Self {
        Page { last_kept: Instant::now(), is_lost: false, rehearsed: Some(0) }
    }

    /// The page sets the size.
    fn attributes(
        _: &Viewer,
        _: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> WindowAttributes {
        attributes.with_canvas(canvas())
    }

    fn wait(arrive: impl Future<Output = ()> + 'static) {
        wasm_bindgen_futures::spawn_local(arrive);
    }

    fn take_device(&mut self, device: &wgpu::Device) {
        watch_device(device);
        if std::mem::take(&mut self.is_lost) {
            let text = "The graphics device was lost; rendering resumed, the run is unchanged.";
            tell("line", text);
        }
    }

    fn keep(preferences: &Preferences) {
        keep(preferences);
    }

    fn tell_missing(what: &Missing) {
        tell("missing", &what.to_string());
    }

    fn adapted(raw: egui::RawInput, context: &egui::Context) -> egui::RawInput {
        adapted(raw, context)
    }

    fn precede_frame(shell: &mut Shell) -> bool {
        shell.rehearse()
    }

    /// Downloads a finished recording, and stores the preferences at intervals.
    fn follow_frame(shell: &mut Shell) {
        if let Some((name, bytes)) = shell.viewer.session.take_recording() {
            give(&name, &bytes);
        }
        if KEPT_EVERY <= shell.host.last_kept.elapsed() {
            shell.host.last_kept = Instant::now();
            shell.remember();
        }
    }

    fn hear(shell: &mut Shell, event_loop: &ActiveEventLoop, event: PageEvent) {
        match event {
            PageEvent::Lost => shell.lose_graphics(),
            PageEvent::Restored => {
                if let (Some(window), None) = (shell.window.clone(), &shell.surface) {
                    shell.ask_for_graphics(event_loop, window);
                }
            }
            PageEvent::Ask(question) => {
                question(&mut shell.viewer);
                // A frame would step, but a hidden page is paused.
                let shown = shell.window.as_ref().filter(|_| !shell.hidden);
                shown.inspect(|window| window.request_redraw());
            }
        }
    }
}

impl Shell {
    /// Releases a lost graphics device; the run and the state of the panels stay.
    fn lose_graphics(&mut self) {
        let Some(window) = &self.window else { return };
        if self.surface.take().is_none() {
            return;
        }
        (self.host.is_lost, self.host.rehearsed) = (true, Some(0));
        tell("line", "The graphics device was lost; waiting for another.");
        // The textures of the panels are lost too, and a context uploads them only once.
        let context = panel_context(self.context.zoom_factor());
        let memory = self.context.memory(Clone::clone);
        context.memory_mut(|new| *new = memory);
        self.input = Some(panel_input(&context, window));
        self.context = context;
    }

    /// Lays out a piece of the panels before the first frame, and finally all of them; returns
    /// whether it did. In a single frame the first layout would block the page.
    fn rehearse(&mut self) -> bool {
        let (Some(window), Some(input), Some(surface), Some(piece)) =
            (&self.window, &mut self.input, &mut self.surface, self.host.rehearsed)
        else {
            return false;
        };
        let viewer = &mut self.viewer;
        self.host.rehearsed = None;
        panel::theme::choose(&self.context, viewer.layout.light);
        let raw = adapted(input.take_egui_input(window), &self.context);
        let output = self.context.run_ui(raw, |ui| {
            if !viewer.layout.bare && panel::rehearse(ui, viewer, piece) {
                self.host.rehearsed = Some(piece + 1);
            } else {
                panel::show(ui, viewer);
            }
        });
        surface.take_textures(&mut Painting::of(&self.context, output));
        window.request_redraw();
        true
    }
}

impl WindowSurface {
    /// Updates egui's textures of a layout that is not drawn.
    fn take_textures(&mut self, painting: &mut Painting) {
        self.canvas.take_textures(painting);
        self.canvas.free_textures(painting);
    }
}
