//! The window: turns winit's events into frames, each of which reads input, steps and renders.

mod canvas;
mod surface;
mod error;
mod host;
mod status_file;
#[cfg(feature = "accessibility")]
mod accessibility;
#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

pub use error::{Missing, ViewError};
#[cfg(not(target_arch = "wasm32"))]
pub use native::{Film, last_scene, view, view_as, view_link};
#[cfg(target_arch = "wasm32")]
pub use web::{report_panics, start};

use crate::input::{read_pointer, take_commands, take_drops};
use crate::panel;
use crate::viewer::Viewer;
use canvas::Painting;
use host::Host;
use msd_render::{Gpu, RenderError};
#[cfg(not(target_arch = "wasm32"))]
use native::{Clipboard, Desktop as Here};
use std::sync::Arc;
use std::time::Duration;
use surface::WindowSurface;
#[cfg(target_arch = "wasm32")]
use web::{Page as Here, PageClipboard as Clipboard};
use web_time::Instant;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Interval between checks for events of an idle X11 window. winit sleeps until its connection is
/// readable, but the thread with which a driver presents frames may read it first. An earlier event
/// is then in the queue already, and a key would act only at the next event, possibly never
/// (winit#1985).
#[cfg(target_os = "linux")]
const LOOK: Duration = Duration::from_millis(100);

/// Interval between checks of an idle window for an edited scene file.
const EDITED_EVERY: Duration = Duration::from_millis(500);

/// An event from outside the window system.
pub(crate) enum Arrival {
    /// The graphics device, which a browser delivers later, and the surface of the window.
    Graphics(Box<Result<(Gpu, wgpu::Surface<'static>), RenderError>>),
    /// A request of a screen reader.
    #[cfg(feature = "accessibility")]
    Accessibility(egui_winit::accesskit_winit::WindowEvent),
    /// An event of the desktop or the page of a browser.
    #[allow(dead_code, reason = "a desktop tells nothing that winit does not")]
    Host(<Here as Host>::Event),
}

/// A callback for every frame, for tests.
pub(crate) type Watcher = Box<dyn FnMut(&Viewer, f32, bool)>;

/// The window and its contents.
pub(crate) struct Shell {
    viewer: Viewer,
    proxy: EventLoopProxy<Arrival>,
    context: egui::Context,
    window: Option<Arc<Window>>,
    input: Option<egui_winit::State>,
    clipboard: Option<Clipboard>,
    surface: Option<WindowSurface>,
    last_frame: Instant,
    /// Time of the next frame that no event requests.
    next_frame: Option<Instant>,
    title: String,
    hidden: bool,
    is_full: bool,
    watcher: Option<Watcher>,
    host: Here,
    /// Reason why the window could not be shown; a browser logs it.
    pub(crate) missing: Option<Missing>,
}

impl Shell {
    pub(crate) fn new(
        viewer: Viewer,
        proxy: EventLoopProxy<Arrival>,
        watcher: Option<Watcher>,
    ) -> Self {
        let context = panel_context(viewer.preferences.scale);
        Shell {
            host: Here::new(&viewer),
            viewer,
            proxy,
            context,
            window: None,
            input: None,
            clipboard: None,
            surface: None,
            last_frame: Instant::now(),
            next_frame: None,
            title: String::new(),
            hidden: false,
            is_full: false,
            watcher,
            missing: None,
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), winit::error::OsError> {
        self.title = self.viewer.title();
        let attributes = Window::default_attributes().with_title(&self.title);
        let attributes = Here::attributes(&self.viewer, event_loop, attributes);
        // Screen readers must know the window before it is visible.
        #[cfg(feature = "accessibility")]
        let attributes = attributes.with_visible(false);
        let window = Arc::new(event_loop.create_window(attributes)?);
        self.input = Some(panel_input(&self.context, &window));
        #[cfg(feature = "accessibility")]
        self.make_accessible(event_loop, &window);
        self.clipboard = Some(Clipboard::of(event_loop));
        self.host.take_window(&window);
        self.window = Some(window.clone());
        self.ask_for_graphics(event_loop, window);
        Ok(())
    }

    /// Requests a graphics device, which arrives later.
    fn ask_for_graphics(&self, event_loop: &ActiveEventLoop, window: Arc<Window>) {
        let display = Box::new(event_loop.owned_display_handle());
        let proxy = self.proxy.clone();
        let arrive = async move {
            let arrival = Arrival::Graphics(Box::new(Gpu::for_surface(display, window).await));
            // The loop outlives the window.
            proxy.send_event(arrival).ok();
        };
        Here::wait(arrive);
    }

    /// Stores the preferences of the window.
    fn remember(&mut self) {
        let Some(window) = &self.window else { return };
        let (points, stretch) = self.host.points(window);
        let size = window.inner_size().to_logical::<f32>(points);
        let scale = self.context.zoom_factor() / stretch;
        let preferences = self.viewer.remember([size.width, size.height], scale);
        Here::keep(preferences);
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, what: Missing) {
        Here::tell_missing(&what);
        log::error!("{what}");
        self.missing = Some(what);
        event_loop.exit();
    }

    /// Renders to the window from now on, on the device that has arrived.
    fn take_graphics(
        &mut self,
        event_loop: &ActiveEventLoop,
        graphics: Result<(Gpu, wgpu::Surface<'static>), RenderError>,
    ) {
        let (Some(window), Some(input)) = (self.window.clone(), &mut self.input) else { return };
        let (gpu, surface) = match graphics {
            Ok(pair) => pair,
            Err(error) => return self.fail(event_loop, Missing::Graphics(Box::new(error))),
        };
        let Some(surface) = WindowSurface::new(window.clone(), gpu, surface) else {
            let text = "the graphics adapter does not support this window".to_owned();
            return self.fail(event_loop, Missing::Window(text));
        };
        input.set_max_texture_side(surface.longest_side());
        log::info!("drawing with {}", surface.adapter());
        self.viewer.quality = surface.quality();
        self.host.take_device(&surface.gpu().device);
        self.surface = Some(surface);
        self.last_frame = Instant::now();
        window.request_redraw();
    }

    /// Runs a frame: reads input, steps, renders.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        if Here::precede_frame(self) {
            return;
        }
        let (Some(window), Some(input), Some(surface)) =
            (&self.window, &mut self.input, &mut self.surface)
        else {
            return;
        };
        let start = Instant::now();
        let real = start.duration_since(self.last_frame).as_secs_f64();
        self.last_frame = start;
        if !surface.is_visible() {
            return;
        }
        if let Some(reason) = surface.loss() {
            let text = lost(&self.viewer, reason);
            return self.fail(event_loop, Missing::Device(text));
        }
        let viewer = &mut self.viewer;
        let raw = Here::adapted(input.take_egui_input(window), &self.context);
        let stopwatch = || start.elapsed().as_secs_f64();
        let (mut output, stepped) = lay_out(&self.context, raw, viewer, real, &stopwatch);
        dress(window, viewer, (&mut self.title, &mut self.is_full));
        if let Some(clipboard) = &mut self.clipboard
            && let Err(why) = clipboard.copy(&output.platform_output.commands)
        {
            // The viewer has already noted a successful copy.
            viewer.note = Some(why);
            window.request_redraw();
        }
        input.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        let wait = root.map_or(Duration::MAX, |root| root.repaint_delay);
        let painting = Painting::of(&self.context, output);
        let pixels_per_point = painting.pixels_per_point;
        let laid_out = stopwatch();
        surface.paint(viewer, painting);
        Here::draw_beside(viewer, surface.gpu(), &self.context);
        let parts = [stepped, laid_out - stepped, stopwatch() - laid_out];
        log::trace!("input and steps, panels, painting took {parts:.4?} s");
        if let Some(watch) = &mut self.watcher {
            let focus = self.context.memory(|memory| memory.focused().is_some());
            watch(viewer, pixels_per_point, focus);
        }
        Here::follow_frame(self);
        if self.viewer.wishes.quit {
            return event_loop.exit();
        }
        self.schedule(event_loop, wait);
    }

    /// Schedules the next frame: at once during motion, otherwise when egui or an event needs one.
    fn schedule(&mut self, event_loop: &ActiveEventLoop, wait: Duration) {
        let Some(window) = &self.window else { return };
        let session = &self.viewer.session;
        // If the camera stopped with the run, it would jump at the next event.
        let moving = !session.is_paused() || session.is_working() || self.viewer.is_gliding();
        let is_next = moving || wait.is_zero();
        if is_next && !self.hidden {
            window.request_redraw();
        }
        let rests = !is_next && !self.hidden;
        self.next_frame = Instant::now().checked_add(wait).filter(|_| rests);
        self.rest(event_loop);
    }

    /// Lets the loop sleep until an event or the next frame.
    fn rest(&self, event_loop: &ActiveEventLoop) {
        #[cfg(target_os = "linux")]
        let look = winit::platform::x11::ActiveEventLoopExtX11::is_x11(event_loop)
            .then(|| Instant::now() + LOOK);
        #[cfg(not(target_os = "linux"))]
        let look = None;
        let file = self.viewer.session.loaded().files.first();
        let edit = file.map(|_| Instant::now() + EDITED_EVERY);
        let until = self.next_frame.into_iter().chain(look).chain(edit).min();
        event_loop.set_control_flow(until.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn set_hidden(&mut self, hidden: bool) {
        self.hidden = hidden;
        if Here::ENDS_UNNOTICED {
            self.remember();
        }
        // The simulation does not catch up with the time while it was hidden.
        self.viewer.session.resume();
        if let Some(window) = &self.window {
            window.request_redraw();
        }
    }
}

/// Creates the context of the panels.
fn panel_context(scale: f32) -> egui::Context {
    let context = egui::Context::default();
    panel::theme::apply(&context);
    context.set_zoom_factor(scale);
    context
}

/// Creates the translation from window events to input of the panels.
fn panel_input(context: &egui::Context, window: &Window) -> egui_winit::State {
    let scale = Some(window.scale_factor() as f32);
    let id = egui::ViewportId::ROOT;
    egui_winit::State::new(context.clone(), id, window, scale, window.theme(), None)
}

/// Lays out a frame: reads the input, advances by `real` seconds, and lays out the panels. Returns
/// egui's output, and the time of `stopwatch` before the panels, seconds.
fn lay_out(
    context: &egui::Context,
    mut raw: egui::RawInput,
    viewer: &mut Viewer,
    real: f64,
    stopwatch: &impl Fn() -> f64,
) -> (egui::FullOutput, f64) {
    for command in take_commands(&mut raw, viewer.takes_keys(context)) {
        viewer.command(command);
    }
    take_drops(&raw, viewer);
    viewer.follow_files(real);
    let mut stepped = None;
    panel::theme::choose(context, viewer.layout.light);
    let mut output = context.run_ui(raw, |ui| {
        // egui may lay out a frame twice: the pointer acts and time passes only once.
        if stepped.is_none() {
            read_pointer(ui.ctx(), viewer);
            viewer.session.advance(real, stopwatch);
            viewer.look(real);
            stepped = Some(stopwatch());
        }
        Here::follow_film(viewer, ui.ctx());
        panel::show(ui, viewer);
        let root = egui::accesskit_root_id();
        ui.ctx().accesskit_node_builder(root, |window| window.set_label(viewer.title()));
    });
    if viewer.layout.light {
        output.shapes.iter_mut().for_each(|shape| panel::theme::lighten(&mut shape.shape));
    }
    (output, stepped.unwrap_or_default())
}

/// Returns the message after a loss of the graphics device, with the state of the run.
fn lost(viewer: &Viewer, reason: &str) -> String {
    format!("the graphics device was lost ({reason}); {}", kept(viewer))
}

/// Saves the run; explains how to resume it, or why it cannot be saved.
fn kept(viewer: &Viewer) -> String {
    viewer.keep_run().unwrap_or_else(|why| format!("the run cannot be saved: {why}"))
}

/// Updates title and full screen of the window, if they have changed.
fn dress(window: &Window, viewer: &Viewer, (title, is_full): (&mut String, &mut bool)) {
    if *is_full != viewer.wishes.full_screen {
        *is_full = viewer.wishes.full_screen;
        let full = is_full.then_some(winit::window::Fullscreen::Borderless(None));
        window.set_fullscreen(full);
    }
    if *title != viewer.title() {
        *title = viewer.title();
        window.set_title(title);
    }
}

impl ApplicationHandler<Arrival> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        // winit may call this several times.
        if self.window.is_some() {
            return;
        }
        if let Err(error) = self.open(event_loop) {
            self.fail(event_loop, Missing::Window(error.to_string()));
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, arrival: Arrival) {
        match arrival {
            Arrival::Graphics(graphics) => self.take_graphics(event_loop, *graphics),
            #[cfg(feature = "accessibility")]
            Arrival::Accessibility(wish) => self.serve(wish),
            Arrival::Host(event) => Here::hear(self, event_loop, event),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let (Some(window), Some(input)) = (&self.window, &mut self.input) else { return };
        if let Some(clipboard) = &mut self.clipboard {
            clipboard.offer(&event, input);
        }
        let response = input.on_window_event(window, &event);
        if response.repaint && !matches!(event, WindowEvent::RedrawRequested) {
            window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                if let WindowEvent::ScaleFactorChanged { scale_factor, inner_size_writer } = event {
                    self.host.rescale(window, scale_factor, inner_size_writer);
                }
                if let Some(surface) = &mut self.surface {
                    surface.resize();
                }
                window.request_redraw();
            }
            WindowEvent::Occluded(hidden) => self.set_hidden(hidden),
            WindowEvent::RedrawRequested => self.frame(event_loop),
            _ => {}
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if !Here::ENDS_UNNOTICED {
            self.remember();
        }
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: winit::event::StartCause) {
        if !matches!(cause, winit::event::StartCause::ResumeTimeReached { .. }) {
            return;
        }
        let is_due = self.next_frame.take_if(|due| *due <= Instant::now()).is_some()
            || self.viewer.is_edited();
        if let Some(window) = self.window.as_ref().filter(|_| is_due) {
            window.request_redraw();
        }
        self.rest(event_loop);
    }
}
