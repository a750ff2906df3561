//! The size of the window, and pixels of a point, which may change while it is open.

use super::super::Shell;
use crate::viewer::Viewer;
use winit::event::InnerSizeWriter;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// The size of the window before a user chose one, points.
pub(super) const SIZE: [f32; 2] = [1280.0, 800.0];
/// The part of the height of a small screen that its bars leave.
const BARS: f32 = 0.94;

/// The size of the window, points: as it was left, and no larger than the screen.
pub(super) fn size(viewer: &Viewer, event_loop: &ActiveEventLoop) -> winit::dpi::LogicalSize<f32> {
    let [width, height] = viewer.preferences.size.unwrap_or(SIZE);
    let monitor = event_loop.primary_monitor();
    let monitor = monitor.or_else(|| event_loop.available_monitors().next());
    let screen = monitor.map(|screen| screen.size().to_logical::<f32>(screen.scale_factor()));
    let screen = screen.filter(|screen| 0.0 < screen.width && 0.0 < screen.height);
    screen.map_or(winit::dpi::LogicalSize::new(width, height), |screen| {
        // Room for the bars of the desktop where the window would fill the height.
        let most = if screen.height < height { BARS * screen.height } else { screen.height };
        winit::dpi::LogicalSize::new(width.min(screen.width), height.min(most))
    })
}

impl Shell {
    /// Draws points as large as the window system said last. On X11 winit tells of that, and goes
    /// by the old size itself until the window is moved or resized.
    pub(super) fn follow_scale(&mut self) {
        let Some(window) = &self.window else { return };
        let stretch = (self.host.scale / window.scale_factor()) as f32;
        if stretch != self.host.stretch {
            let was = std::mem::replace(&mut self.host.stretch, stretch);
            self.context.set_zoom_factor(self.context.zoom_factor() * stretch / was);
        }
    }
}

/// Makes a window so many times as large as its points have become, and no larger than its screen.
pub(super) fn bound(window: &Window, factor: f64, mut writer: InnerSizeWriter) {
    let Some(screen) = window.current_monitor().map(|monitor| monitor.size()) else { return };
    let size = window.inner_size();
    let [width, height] = [size.width, size.height].map(|side| (f64::from(side) * factor).round());
    let bounded = [screen.width.min(width as u32), screen.height.min(height as u32)];
    // Refused where the window system has its own way.
    writer.request_inner_size(bounded.into()).ok();
}
