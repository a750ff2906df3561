//! A desktop as the host of a window.

use super::super::Shell;
use super::super::host::Host;
use super::super::surface::WindowSurface;
use super::{preferences_file, scale};
use crate::panel;
use crate::viewer::{Preferences, Viewer};
use msd_film::quietly;
use msd_render::Gpu;
use std::convert::Infallible;
use std::time::Duration;
use winit::dpi::LogicalSize;
use winit::event::InnerSizeWriter;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Window, WindowAttributes};

/// Interval between progress updates of a film in an idle window.
const FILMED_EVERY: Duration = Duration::from_millis(100);

/// A desktop.
pub(crate) struct Desktop {
    /// Last pixels per point of the window system, and their ratio to those of winit.
    pub(super) scale: f64,
    pub(super) stretch: f32,
    is_guided: bool,
    /// The loss to simulate once the run is paused, for tests.
    pub(super) to_lose: Option<Loss>,
}

/// A loss that tests simulate.
#[derive(Clone, Copy, Debug)]
pub(super) enum Loss {
    /// The surface, which is created again.
    Surface,
    /// The graphics device, without which the window closes.
    Device,
}

impl Host for Desktop {
    /// None: winit handles all of them.
    type Event = Infallible;
    const ENDS_UNNOTICED: bool = false;

    fn new(viewer: &Viewer) -> Self {
        let is_guided = viewer.preferences.is_guided;
        Desktop { scale: 1.0, stretch: 1.0, is_guided, to_lose: None }
    }

    fn attributes(
        viewer: &Viewer,
        event_loop: &ActiveEventLoop,
        attributes: WindowAttributes,
    ) -> WindowAttributes {
        attributes
            .with_inner_size(scale::size(viewer, event_loop))
            .with_min_inner_size(LogicalSize::new(panel::LEAST.x, panel::LEAST.y))
    }

    fn wait(arrive: impl Future<Output = ()> + 'static) {
        quietly(|| pollster::block_on(arrive));
    }

    fn take_window(&mut self, window: &Window) {
        self.scale = window.scale_factor();
    }

    fn points(&self, _: &Window) -> (f64, f32) {
        (self.scale, self.stretch)
    }

    fn rescale(&mut self, window: &Window, scale: f64, writer: InnerSizeWriter) {
        let factor = scale / std::mem::replace(&mut self.scale, scale);
        scale::bound(window, factor, writer);
    }

    fn keep(preferences: &Preferences) {
        preferences_file::write(preferences);
    }

    fn follow_film(viewer: &mut Viewer, context: &egui::Context) {
        if viewer.follow_film() {
            context.request_repaint_after(FILMED_EVERY);
        }
    }

    fn draw_beside(viewer: &mut Viewer, gpu: &Gpu, context: &egui::Context) {
        if let Some(gallery) = &mut viewer.layout.gallery {
            gallery.draw_next(gpu, context);
        }
    }

    fn precede_frame(shell: &mut Shell) -> bool {
        shell.follow_scale();
        false
    }

    /// Stores the end of the tour, and simulates a loss for tests.
    fn follow_frame(shell: &mut Shell) {
        if shell.host.is_guided != shell.viewer.preferences.is_guided {
            shell.host.is_guided = shell.viewer.preferences.is_guided;
            shell.remember();
        }
        let (Some(window), Some(surface)) = (&shell.window, &mut shell.surface) else { return };
        if let Some(what) = shell.host.to_lose.take_if(|_| shell.viewer.session.is_paused()) {
            surface.lose(what);
            window.request_redraw();
        }
    }

    fn hear(_: &mut Shell, _: &ActiveEventLoop, event: Infallible) {
        match event {}
    }
}

impl WindowSurface {
    /// Simulates the loss of the surface or the device.
    fn lose(&mut self, what: Loss) {
        match what {
            Loss::Surface => self.is_lost = true,
            Loss::Device => {
                let device = &self.gpu().device;
                device.destroy();
                // The queue reports the loss once it is empty.
                device.poll(wgpu::PollType::Poll).ok();
            }
        }
    }
}
