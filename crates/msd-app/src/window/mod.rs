//! The window: winit's events become frames, and a frame reads input, steps and draws.

mod canvas;
#[cfg(not(target_arch = "wasm32"))]
mod clipboard;
mod surface;
mod error;
#[cfg(not(target_arch = "wasm32"))]
mod film;
#[cfg(not(target_arch = "wasm32"))]
mod scale;
#[cfg(not(target_arch = "wasm32"))]
mod preferences_file;
mod status_file;
#[cfg(feature = "accessibility")]
mod accessibility;
#[cfg(not(target_arch = "wasm32"))]
mod lost_display;
#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

pub use error::{Missing, ViewError};
#[cfg(not(target_arch = "wasm32"))]
pub use film::Film;
#[cfg(not(target_arch = "wasm32"))]
pub use native::{last_scene, view, view_as, view_link};
#[cfg(target_arch = "wasm32")]
pub use web::{report_panics, start};

#[cfg(not(target_arch = "wasm32"))]
use crate::drivers;
use crate::input::{read_pointer, take_commands, take_drops};
use crate::panel;
use crate::viewer::Viewer;
use canvas::Painting;
#[cfg(not(target_arch = "wasm32"))]
use clipboard::Clipboard;
use msd_render::{Gpu, RenderError};
use std::sync::Arc;
use std::time::Duration;
#[cfg(not(target_arch = "wasm32"))]
use surface::Loss;
use surface::WindowSurface;
#[cfg(target_arch = "wasm32")]
use web::PageClipboard as Clipboard;
use web_time::Instant;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// How often a window that rests says how far its film is.
#[cfg(not(target_arch = "wasm32"))]
const FILMED_EVERY: Duration = Duration::from_millis(100);

/// How often a window of X11 that rests looks for events. winit sleeps until its connection has
/// something to read, but the thread with which a driver presents pictures reads it too: an event
/// that came before the picture was shown is then in the queue of the connection already, and a key
/// would act when the next event comes, which may be never (winit#1985).
#[cfg(target_os = "linux")]
const LOOK: Duration = Duration::from_millis(100);

/// How often a window that rests looks whether the file of its scene was edited.
const EDITED_EVERY: Duration = Duration::from_millis(500);

/// How often what is remembered is kept where the program may end without notice.
#[cfg(target_arch = "wasm32")]
const KEPT_EVERY: Duration = Duration::from_secs(1);

/// What arrives from outside the window system.
pub(crate) enum Arrival {
    /// The graphics device, which a browser gives later, and the surface of the window.
    Graphics(Box<Result<(Gpu, wgpu::Surface<'static>), RenderError>>),
    /// What a screen reader asks for.
    #[cfg(feature = "accessibility")]
    Accessibility(egui_winit::accesskit_winit::WindowEvent),
    /// The graphics device is lost; a browser takes it away when it likes.
    #[cfg(target_arch = "wasm32")]
    Lost,
    /// There is a graphics device to be had again.
    #[cfg(target_arch = "wasm32")]
    Restored,
    /// What the page of a browser does between two frames.
    #[cfg(target_arch = "wasm32")]
    Ask(Box<dyn FnOnce(&mut Viewer)>),
}

/// Is shown every frame, for tests.
pub(crate) type Watcher = Box<dyn FnMut(&Viewer, f32, bool)>;

/// The window and what it shows.
pub(crate) struct Shell {
    viewer: Viewer,
    proxy: EventLoopProxy<Arrival>,
    context: egui::Context,
    window: Option<Arc<Window>>,
    input: Option<egui_winit::State>,
    clipboard: Option<Clipboard>,
    surface: Option<WindowSurface>,
    last_frame: Instant,
    /// When the next frame is due that no event asks for.
    next_frame: Option<Instant>,
    #[cfg(target_arch = "wasm32")]
    last_kept: Instant,
    #[cfg(target_arch = "wasm32")]
    is_lost: bool,
    /// The piece of the panels that is to be laid out next before the first frame.
    #[cfg(target_arch = "wasm32")]
    rehearsed: Option<usize>,
    title: String,
    hidden: bool,
    is_full: bool,
    /// Pixels of a point of the window system, when it said that last, and how many times as many
    /// as winit goes by.
    #[cfg(not(target_arch = "wasm32"))]
    scale: f64,
    #[cfg(not(target_arch = "wasm32"))]
    stretch: f32,
    #[cfg(not(target_arch = "wasm32"))]
    is_guided: bool,
    watcher: Option<Watcher>,
    /// What is to be lost once the run is paused, for tests.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) to_lose: Option<Loss>,
    /// Why the window could not be shown; a browser finds it in the log.
    pub(crate) missing: Option<Missing>,
}

impl Shell {
    pub(crate) fn new(
        viewer: Viewer,
        proxy: EventLoopProxy<Arrival>,
        watcher: Option<Watcher>,
    ) -> Self {
        #[cfg(not(target_arch = "wasm32"))]
        let is_guided = viewer.preferences.is_guided;
        let context = panel_context(viewer.preferences.scale);
        Shell {
            viewer,
            proxy,
            context,
            window: None,
            input: None,
            clipboard: None,
            surface: None,
            last_frame: Instant::now(),
            next_frame: None,
            #[cfg(target_arch = "wasm32")]
            last_kept: Instant::now(),
            #[cfg(target_arch = "wasm32")]
            is_lost: false,
            #[cfg(target_arch = "wasm32")]
            rehearsed: Some(0),
            title: String::new(),
            hidden: false,
            is_full: false,
            #[cfg(not(target_arch = "wasm32"))]
            scale: 1.0,
            #[cfg(not(target_arch = "wasm32"))]
            stretch: 1.0,
            #[cfg(not(target_arch = "wasm32"))]
            is_guided,
            watcher,
            #[cfg(not(target_arch = "wasm32"))]
            to_lose: None,
            missing: None,
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), winit::error::OsError> {
        self.title = self.viewer.title();
        let attributes = Window::default_attributes().with_title(&self.title);
        // In a browser the page chooses the size.
        #[cfg(not(target_arch = "wasm32"))]
        let attributes = attributes
            .with_inner_size(self.size(event_loop))
            .with_min_inner_size(winit::dpi::LogicalSize::new(panel::LEAST.x, panel::LEAST.y));
        #[cfg(target_arch = "wasm32")]
        let attributes =
            winit::platform::web::WindowAttributesExtWebSys::with_canvas(attributes, web::canvas());
        // Who reads it aloud must know it before it is shown.
        #[cfg(feature = "accessibility")]
        let attributes = attributes.with_visible(false);
        let window = Arc::new(event_loop.create_window(attributes)?);
        self.input = Some(panel_input(&self.context, &window));
        #[cfg(feature = "accessibility")]
        self.make_accessible(event_loop, &window);
        self.clipboard = Some(Clipboard::of(event_loop));
        #[cfg(not(target_arch = "wasm32"))]
        {
            self.scale = window.scale_factor();
        }
        self.window = Some(window.clone());
        self.ask_for_graphics(event_loop, window);
        Ok(())
    }

    /// Asks for a graphics device, which arrives later.
    fn ask_for_graphics(&self, event_loop: &ActiveEventLoop, window: Arc<Window>) {
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
    }

    /// Lets go of a graphics device that is lost; what runs, and what the panels show, stays.
    #[cfg(target_arch = "wasm32")]
    fn lose_graphics(&mut self) {
        let Some(window) = &self.window else { return };
        if self.surface.take().is_none() {
            return;
        }
        (self.is_lost, self.rehearsed) = (true, Some(0));
        web::tell("line", "The graphics device was lost; the scene waits for another.");
        // The textures of the panels are lost too, and a context hands them out only once.
        let context = panel_context(self.context.zoom_factor());
        let memory = self.context.memory(Clone::clone);
        context.memory_mut(|new| *new = memory);
        self.input = Some(panel_input(&context, window));
        self.context = context;
    }

    /// Remembers how the window is left.
    fn remember(&mut self) {
        let Some(window) = &self.window else { return };
        #[cfg(not(target_arch = "wasm32"))]
        let (points, stretch) = (self.scale, self.stretch);
        #[cfg(target_arch = "wasm32")]
        let (points, stretch) = (window.scale_factor(), 1.0);
        let size = window.inner_size().to_logical::<f32>(points);
        let scale = self.context.zoom_factor() / stretch;
        let preferences = self.viewer.remember([size.width, size.height], scale);
        #[cfg(not(target_arch = "wasm32"))]
        preferences_file::write(preferences);
        #[cfg(target_arch = "wasm32")]
        web::keep(preferences);
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
        #[cfg(target_arch = "wasm32")]
        web::watch_device(surface.device());
        self.viewer.quality = surface.quality();
        self.surface = Some(surface);
        #[cfg(target_arch = "wasm32")]
        if std::mem::take(&mut self.is_lost) {
            let text = "The graphics device was lost; the scene is drawn again, from where it was.";
            web::tell("line", text);
        }
        self.last_frame = Instant::now();
        window.request_redraw();
    }

    /// Lays out a piece of the panels before the first frame, and then all of them; whether it did.
    /// What the first time takes would keep the page from answering, were it one frame.
    #[cfg(target_arch = "wasm32")]
    fn rehearse(&mut self) -> bool {
        let (Some(window), Some(input), Some(surface), Some(piece)) =
            (&self.window, &mut self.input, &mut self.surface, self.rehearsed)
        else {
            return false;
        };
        let viewer = &mut self.viewer;
        self.rehearsed = None;
        panel::theme::choose(&self.context, viewer.layout.light);
        let raw = web::adapted(input.take_egui_input(window), &self.context);
        let output = self.context.run_ui(raw, |ui| {
            if !viewer.layout.bare && panel::rehearse(ui, viewer, piece) {
                self.rehearsed = Some(piece + 1);
            } else {
                panel::show(ui, viewer);
            }
        });
        surface.take_textures(&mut Painting::of(&self.context, output));
        window.request_redraw();
        true
    }

    /// One frame: reads input, steps, draws.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        #[cfg(not(target_arch = "wasm32"))]
        self.follow_scale();
        #[cfg(target_arch = "wasm32")]
        if self.rehearse() {
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
        let raw = input.take_egui_input(window);
        #[cfg(target_arch = "wasm32")]
        let raw = web::adapted(raw, &self.context);
        let stopwatch = || start.elapsed().as_secs_f64();
        let (mut output, stepped) = lay_out(&self.context, raw, viewer, real, &stopwatch);
        dress(window, viewer, (&mut self.title, &mut self.is_full));
        if let Some(clipboard) = &mut self.clipboard
            && let Err(why) = clipboard.copy(&output.platform_output.commands)
        {
            // It said that it was copied.
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
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(gallery) = &mut viewer.layout.gallery {
            gallery.draw_next(surface.gpu(), &self.context);
        }
        let parts = [stepped, laid_out - stepped, stopwatch() - laid_out];
        log::trace!("input and steps, panels, painting took {parts:.4?} s");
        if let Some(watch) = &mut self.watcher {
            let focus = self.context.memory(|memory| memory.focused().is_some());
            watch(viewer, pixels_per_point, focus);
        }
        self.keep();
        if self.viewer.wishes.quit {
            return event_loop.exit();
        }
        #[cfg(not(target_arch = "wasm32"))]
        self.lose();
        self.schedule(event_loop, wait);
    }

    /// Keeps what the user would miss: that the guide is over.
    #[cfg(not(target_arch = "wasm32"))]
    fn keep(&mut self) {
        if self.is_guided != self.viewer.preferences.is_guided {
            self.is_guided = self.viewer.preferences.is_guided;
            self.remember();
        }
    }

    /// Keeps what the user would miss: a recording that has ended, and now and then the
    /// preferences, as a page is left without notice.
    #[cfg(target_arch = "wasm32")]
    fn keep(&mut self) {
        if let Some((name, bytes)) = self.viewer.session.take_recording() {
            web::give(&name, &bytes);
        }
        if KEPT_EVERY <= self.last_kept.elapsed() {
            self.last_kept = Instant::now();
            self.remember();
        }
    }

    /// Loses what a test wants to be lost.
    #[cfg(not(target_arch = "wasm32"))]
    fn lose(&mut self) {
        let (Some(window), Some(surface)) = (&self.window, &mut self.surface) else { return };
        if let Some(what) = self.to_lose.take_if(|_| self.viewer.session.is_paused()) {
            surface.lose(what);
            window.request_redraw();
        }
    }

    /// Asks for the next frame: at once while something moves, else when egui or an event wants it.
    fn schedule(&mut self, event_loop: &ActiveEventLoop, wait: Duration) {
        let Some(window) = &self.window else { return };
        let session = &self.viewer.session;
        // A camera that stopped with the run would jump at the next event.
        let moving = !session.is_paused() || session.is_working() || self.viewer.is_gliding();
        let is_next = moving || wait.is_zero();
        if is_next && !self.hidden {
            window.request_redraw();
        }
        let rests = !is_next && !self.hidden;
        self.next_frame = Instant::now().checked_add(wait).filter(|_| rests);
        self.rest(event_loop);
    }

    /// Lets the loop sleep until something happens or a frame is due.
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
        #[cfg(target_arch = "wasm32")]
        self.remember();
        // Being hidden is not the simulation's to catch up with.
        self.viewer.session.resume();
        if let Some(window) = &self.window {
            window.request_redraw();
        }
    }
}

/// What the panels are laid out in.
fn panel_context(scale: f32) -> egui::Context {
    let context = egui::Context::default();
    panel::theme::apply(&context);
    context.set_zoom_factor(scale);
    context
}

/// What turns the events of a window into input of the panels.
fn panel_input(context: &egui::Context, window: &Window) -> egui_winit::State {
    let scale = Some(window.scale_factor() as f32);
    let id = egui::ViewportId::ROOT;
    egui_winit::State::new(context.clone(), id, window, scale, window.theme(), None)
}

/// Lays out a frame: reads what the user did, lets `real` seconds pass, and lays out the panels.
/// Returns what egui wants, and what `stopwatch` said before the panels, seconds.
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
        // egui may lay out a frame twice: the pointer acts and time passes once.
        if stepped.is_none() {
            read_pointer(ui.ctx(), viewer);
            viewer.session.advance(real, stopwatch);
            viewer.look(real);
            stepped = Some(stopwatch());
        }
        #[cfg(not(target_arch = "wasm32"))]
        if viewer.follow_film() {
            ui.ctx().request_repaint_after(FILMED_EVERY);
        }
        panel::show(ui, viewer);
        let root = egui::accesskit_root_id();
        ui.ctx().accesskit_node_builder(root, |window| window.set_label(viewer.title()));
    });
    if viewer.layout.light {
        output.shapes.iter_mut().for_each(|shape| panel::theme::lighten(&mut shape.shape));
    }
    (output, stepped.unwrap_or_default())
}

/// That the graphics device was lost, and what became of the run, which needs none.
fn lost(viewer: &Viewer, reason: &str) -> String {
    format!("the graphics device was lost ({reason}); {}", kept(viewer))
}

/// Saves the run; says how to go on, or why it cannot be saved.
fn kept(viewer: &Viewer) -> String {
    viewer.keep_run().unwrap_or_else(|why| format!("the run cannot be saved: {why}"))
}

/// Gives the window the title and the screen that the viewer asks for, where they have changed.
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
            #[cfg(feature = "accessibility")]
            Arrival::Accessibility(wish) => self.serve(wish),
            #[cfg(target_arch = "wasm32")]
            Arrival::Lost => self.lose_graphics(),
            #[cfg(target_arch = "wasm32")]
            Arrival::Restored => {
                if let (Some(window), None) = (self.window.clone(), &self.surface) {
                    self.ask_for_graphics(event_loop, window);
                }
            }
            #[cfg(target_arch = "wasm32")]
            Arrival::Ask(question) => {
                question(&mut self.viewer);
                // A frame would step, and a hidden page is paused.
                let shown = self.window.as_ref().filter(|_| !self.hidden);
                shown.inspect(|window| window.request_redraw());
            }
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
                #[cfg(not(target_arch = "wasm32"))]
                if let WindowEvent::ScaleFactorChanged { scale_factor, inner_size_writer } = event {
                    let factor = scale_factor / std::mem::replace(&mut self.scale, scale_factor);
                    scale::bound(window, factor, inner_size_writer);
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

    #[cfg(not(target_arch = "wasm32"))]
    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.remember();
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
