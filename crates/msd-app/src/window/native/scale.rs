//! Size and pixels per point of the window, which may change while it is open.

use super::super::Shell;
use crate::viewer::Viewer;
use winit::event::InnerSizeWriter;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// Initial size of the window, points.
pub(super) const SIZE: [f32; 2] = [1280.0, 800.0];
/// Share of the height of a small screen that the desktop's bars leave.
const BARS: f32 = 0.94;

/// Returns the size of the window, points: its last one, limited by the screen.
pub(super) fn size(viewer: &Viewer, event_loop: &ActiveEventLoop) -> winit::dpi::LogicalSize<f32> {
    let [width, height] = viewer.preferences.size.unwrap_or(SIZE);
    let monitor = event_loop.primary_monitor();
    let monitor = monitor.or_else(|| event_loop.available_monitors().next());
    let screen = monitor.map(|screen| screen.size().to_logical::<f32>(screen.scale_factor()));
    let screen = screen.filter(|screen| 0.0 < screen.width && 0.0 < screen.height);
    screen.map_or(winit::dpi::LogicalSize::new(width, height), |screen| {
        // Leaves space for the bars of the desktop if the window would fill the height.
        let most = if screen.height < height { BARS * screen.height } else { screen.height };
        winit::dpi::LogicalSize::new(width.min(screen.width), height.min(most))
    })
}

impl Shell {
    /// Applies the last scale factor of the window system. On X11 winit reports it, but itself uses
    /// the old one until the window is moved or resized.
    pub(super) fn follow_scale(&mut self) {
        let Some(window) = &self.window else { return };
        let stretch = (self.host.scale / window.scale_factor()) as f32;
        if stretch != self.host.stretch {
            let was = std::mem::replace(&mut self.host.stretch, stretch);
            self.context.set_zoom_factor(self.context.zoom_factor() * stretch / was);
        }
    }
}

/// Resizes a window by the change of its scale factor, limited by the screen.
pub(super) fn bound(window: &Window, factor: f64, mut writer: InnerSizeWriter) {
    let Some(screen) = window.current_monitor().map(|monitor| monitor.size()) else { return };
    let size = window.inner_size();
    let [width, height] = [size.width, size.height].map(|side| (f64::from(side) * factor).round());
    let bounded = [screen.width.min(width as u32), screen.height.min(height as u32)];
    // Fails if the window system sets the size.
    writer.request_inner_size(bounded.into()).ok();
}
