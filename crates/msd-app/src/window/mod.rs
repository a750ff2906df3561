//! The window: winit's events become frames, and a frame reads input, steps and draws.

mod surface;
mod error;
mod status_file;
#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

pub use error::{Missing, ViewError};
#[cfg(not(target_arch = "wasm32"))]
pub use native::{view, view_as, view_link};
#[cfg(target_arch = "wasm32")]
pub use web::start;

#[cfg(not(target_arch = "wasm32"))]
use crate::drivers;
use crate::input::{read_pointer, take_commands};
use crate::panel;
use crate::viewer::Viewer;
use msd_render::{Gpu, RenderError};
use std::sync::Arc;
use std::time::Duration;
use surface::{Painting, WindowSurface};
use web_time::Instant;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// What arrives from outside the window system.
pub(crate) enum Arrival {
    /// The graphics device, which a browser gives later, and the surface of the window.
    Graphics(Box<Result<(Gpu, wgpu::Surface<'static>), RenderError>>),
    /// What the page of a browser does between two frames.
    #[cfg(target_arch = "wasm32")]
    Ask(Box<dyn FnOnce(&mut Viewer)>),
}

/// Is shown every frame, for tests.
pub(crate) type Watcher = Box<dyn FnMut(&Viewer, f32)>;

/// The window and what it shows.
pub(crate) struct Shell {
    viewer: Viewer,
    proxy: EventLoopProxy<Arrival>,
    context: egui::Context,
    window: Option<Arc<Window>>,
    input: Option<egui_winit::State>,
    surface: Option<WindowSurface>,
    last_frame: Instant,
    title: String,
    hidden: bool,
    watcher: Option<Watcher>,
    /// Why the window could not be shown; a browser finds it in the log.
    pub(crate) missing: Option<Missing>,
}

impl Shell {
    pub(crate) fn new(
        viewer: Viewer,
        proxy: EventLoopProxy<Arrival>,
        watcher: Option<Watcher>,
    ) -> Self {
        let context = egui::Context::default();
        panel::theme::apply(&context);
        Shell {
            viewer,
            proxy,
            context,
            window: None,
            input: None,
            surface: None,
            last_frame: Instant::now(),
            title: String::new(),
            hidden: false,
            watcher,
            missing: None,
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), winit::error::OsError> {
        self.title = self.viewer.title();
        let attributes = Window::default_attributes().with_title(&self.title);
        // In a browser the page chooses the size.
        #[cfg(not(target_arch = "wasm32"))]
        let attributes = attributes
            .with_inner_size(winit::dpi::LogicalSize::new(1280.0, 800.0))
            .with_min_inner_size(winit::dpi::LogicalSize::new(640.0, 400.0));
        #[cfg(target_arch = "wasm32")]
        let attributes =
            winit::platform::web::WindowAttributesExtWebSys::with_canvas(attributes, web::canvas());
        let window = Arc::new(event_loop.create_window(attributes)?);
        self.input = Some(egui_winit::State::new(
            self.context.clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            None,
        ));
        self.window = Some(window.clone());
        let display = Box::new(event_loop.owned_display_handle());
        let proxy = self.proxy.clone();
        let arrive = async move {
            let arrival = Arrival::Graphics(Box::new(Gpu::for_surface(display, window).await));
            // The loop is only gone when the window is.
            proxy.send_event(arrival).ok();
        };
        #[cfg(not(target_arch = "wasm32"))]
        drivers::quietly(|| pollster::block_on(arrive));
        #[cfg(target_arch = "wasm32")]
        wasm_bindgen_futures::spawn_local(arrive);
        Ok(())
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, what: Missing) {
        #[cfg(target_arch = "wasm32")]
        web::tell("missing", &what.to_string());
        log::error!("{what}");
        self.missing = Some(what);
        event_loop.exit();
    }

    /// Draws on the window from now on, by the device that has arrived.
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
            let text = "the graphics adapter cannot draw on this window".to_owned();
            return self.fail(event_loop, Missing::Window(text));
        };
        input.set_max_texture_side(surface.longest_side());
        log::info!("drawing with {}", surface.adapter());
        self.surface = Some(surface);
        self.last_frame = Instant::now();
        window.request_redraw();
    }

    /// One frame: reads input, steps, draws.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
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
        let viewer = &mut self.viewer;
        let mut raw = input.take_egui_input(window);
        for command in take_commands(&mut raw, self.context.egui_wants_keyboard_input()) {
            viewer.command(command);
        }
        let mut stepped = None;
        let output = self.context.run_ui(raw, |ui| {
            // egui may lay out a frame twice: the pointer acts and time passes once.
            if stepped.is_none() {
                read_pointer(ui.ctx(), viewer);
                viewer.session.advance(real, &|| start.elapsed().as_secs_f64());
                viewer.look(real);
                stepped = Some(start.elapsed());
            }
            panel::show(ui, viewer);
        });
        if self.title != viewer.title() {
            self.title = viewer.title();
            window.set_title(&self.title);
        }
        #[cfg(target_arch = "wasm32")]
        for command in &output.platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                web::tell("copy", text);
            }
        }
        input.handle_platform_output(window, output.platform_output);
        let pixels_per_point = output.pixels_per_point;
        let primitives = self.context.tessellate(output.shapes, pixels_per_point);
        let textures = output.textures_delta;
        let laid_out = start.elapsed();
        surface.paint(viewer, Painting { primitives, textures, pixels_per_point });
        let stepped = stepped.unwrap_or_default();
        let parts = [stepped, laid_out - stepped, start.elapsed() - laid_out];
        log::trace!("input and steps, panels, painting took {parts:.1?}");
        if let Some(watch) = &mut self.watcher {
            watch(viewer, pixels_per_point);
        }
        #[cfg(target_arch = "wasm32")]
        if let Some((name, bytes)) = viewer.session.take_recording() {
            web::give(&name, &bytes);
        }
        if viewer.quit {
            return event_loop.exit();
        }
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        let wait = root.map_or(Duration::MAX, |root| root.repaint_delay);
        self.schedule(event_loop, wait);
    }

    /// Asks for the next frame: at once while something moves, else when egui or an event wants it.
    fn schedule(&self, event_loop: &ActiveEventLoop, wait: Duration) {
        let Some(window) = &self.window else { return };
        let session = &self.viewer.session;
        let moving = !session.is_paused() || session.is_working();
        event_loop.set_control_flow(ControlFlow::Wait);
        if self.hidden {
            return;
        }
        if moving || wait.is_zero() {
            window.request_redraw();
        } else if let Some(at) = Instant::now().checked_add(wait) {
            event_loop.set_control_flow(ControlFlow::WaitUntil(at));
        }
    }

    fn set_hidden(&mut self, hidden: bool) {
        self.hidden = hidden;
        // Being hidden is not the simulation's to catch up with.
        self.viewer.session.resume();
        if let Some(window) = &self.window {
            window.request_redraw();
        }
    }
}

impl ApplicationHandler<Arrival> for Shell {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        // It can come again.
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
            #[cfg(target_arch = "wasm32")]
            Arrival::Ask(question) => {
                question(&mut self.viewer);
                self.window.as_ref().inspect(|window| window.request_redraw());
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let (Some(window), Some(input)) = (&self.window, &mut self.input) else { return };
        let response = input.on_window_event(window, &event);
        if response.repaint && !matches!(event, WindowEvent::RedrawRequested) {
            window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
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

    fn new_events(&mut self, _: &ActiveEventLoop, cause: winit::event::StartCause) {
        if let (winit::event::StartCause::ResumeTimeReached { .. }, Some(window)) =
            (cause, &self.window)
        {
            window.request_redraw();
        }
    }
}
