//! The gallery: built-in scenes and the files of a folder, with a small picture of each.

use std::path::Path;

/// Width and height of a small picture, pixels.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) const PICTURE: [u32; 2] = [192, 120];
/// The most files of a folder that are listed.
const MOST_FILES: usize = 60;
/// Endings of files that can be opened.
const ENDINGS: [&str; 8] = ["toml", "json", "obj", "stl", "ply", "gltf", "glb", "msd"];

/// A scene that the gallery offers.
pub struct Picture {
    /// What it is opened by.
    pub name: String,
    /// One line on what is seen; nothing of a file before it was opened.
    pub title: String,
    /// Its picture, once there is one.
    pub texture: Option<egui::TextureHandle>,
}

impl std::fmt::Debug for Picture {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Picture of {}", self.name)
    }
}

/// The gallery while it is open.
#[derive(Debug)]
pub struct Gallery {
    /// The scenes: built-in ones, then those of the folder.
    pub pictures: Vec<Picture>,
    /// The path that is being typed.
    pub path: String,
    /// Whether it was just opened: the keyboard goes to the path.
    pub(crate) is_new: bool,
    #[cfg(not(target_arch = "wasm32"))]
    painter: painter::Painter,
}

impl Gallery {
    /// Lists the built-in scenes and the scenes, meshes and saved runs of a folder, and begins to
    /// open them for their pictures.
    pub(super) fn open(builtin: &[super::Entry], folder: &Path) -> Self {
        let builtin = builtin.iter().map(|entry| (entry.name.to_owned(), entry.title.to_owned()));
        let files = files(folder).into_iter().map(|file| (file, String::new()));
        let picture = |(name, title)| Picture { name, title, texture: None };
        let pictures: Vec<_> = builtin.chain(files).map(picture).collect();
        Gallery {
            #[cfg(not(target_arch = "wasm32"))]
            painter: painter::Painter::start(pictures.iter().map(|row| row.name.clone()).collect()),
            pictures,
            path: String::new(),
            is_new: true,
        }
    }

    /// Whether pictures are to come; a browser draws none.
    pub(crate) fn is_busy(&self) -> bool {
        #[cfg(not(target_arch = "wasm32"))]
        let is_busy = self.painter.is_busy();
        #[cfg(target_arch = "wasm32")]
        let is_busy = false;
        is_busy
    }

    /// Draws the next picture by the device of the window.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn draw_next(&mut self, gpu: &msd_render::Gpu, ctx: &egui::Context) {
        if let Some((row, image)) = self.painter.draw_next(gpu)
            && let Some(picture) = self.pictures.get_mut(row)
        {
            let name = format!("picture of {}", picture.name);
            picture.texture = Some(ctx.load_texture(name, image, Default::default()));
        }
    }
}

/// The files of a folder that may be scenes, in the order of their names.
fn files(folder: &Path) -> Vec<String> {
    // The folder that the program was started in has no name.
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(here).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| {
        let path = folder.join(entry.file_name());
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        let is_file = ENDINGS.contains(&ending.as_str()) && path.is_file();
        // Other programs have files in these formats too.
        let is_ours = !matches!(ending.as_str(), "toml" | "json") || is_scene(&path);
        (is_file && is_ours).then(|| path.to_string_lossy().into_owned())
    });
    let mut names: Vec<String> = names.collect();
    names.sort();
    names.truncate(MOST_FILES);
    names
}

/// Whether a text looks like a scene: it says a version and has bodies.
fn is_scene(path: &Path) -> bool {
    const LARGEST: u64 = 1 << 20;
    let is_small = path.metadata().is_ok_and(|data| data.len() <= LARGEST);
    is_small
        && std::fs::read_to_string(path)
            .is_ok_and(|text| text.contains("version") && text.contains("bodies"))
}

#[cfg(not(target_arch = "wasm32"))]
mod painter {
    //! Small pictures: a thread opens the scenes, and the window draws them by its own device.

    use super::PICTURE;
    use egui::ColorImage;
    use msd_film::{go_to, turn_to, usual_colours};
    use msd_render::{Gpu, Offscreen, Style, View, bounds_with_solids};
    use msd_run::{Runner, on};
    use msd_scene::Viewpoint;
    use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

    /// A scene at its start, by its row, and how it is drawn.
    #[derive(Debug)]
    struct Opened {
        row: usize,
        runner: Runner,
        style: Style,
        viewpoint: Viewpoint,
    }

    /// Draws the starts of scenes, one a frame. Only opened by the thread: a driver (Mesa's) that
    /// is at work in a thread while the process ends takes the process down with it.
    #[derive(Debug)]
    pub(super) struct Painter {
        /// The scenes with their rows, as they are opened; nothing once all were.
        opened: Option<Receiver<Opened>>,
        screen: Option<Offscreen>,
    }

    impl Painter {
        /// Begins to open scenes.
        pub(super) fn start(names: Vec<String>) -> Self {
            // The next one is opened while one waits to be drawn: they may be large.
            let (sender, receiver) = sync_channel(1);
            let work = move || {
                for (row, name) in names.iter().enumerate() {
                    if let Some(scene) = open(row, name)
                        && sender.send(scene).is_err()
                    {
                        return;
                    }
                }
            };
            let thread = std::thread::Builder::new().name("gallery".into()).spawn(work);
            Painter { opened: thread.is_ok().then_some(receiver), screen: None }
        }

        /// Whether more is to come.
        pub(super) fn is_busy(&self) -> bool {
            self.opened.is_some()
        }

        /// Draws the next scene, if one was opened: its row and its picture.
        pub(super) fn draw_next(&mut self, gpu: &Gpu) -> Option<(usize, ColorImage)> {
            match self.opened.as_ref()?.try_recv() {
                Ok(opened) => Some((opened.row, self.draw(gpu, &opened)?)),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => {
                    (self.opened, self.screen) = (None, None);
                    None
                }
            }
        }

        fn draw(&mut self, gpu: &Gpu, opened: &Opened) -> Option<ColorImage> {
            let [width, height] = PICTURE;
            let screen = match &mut self.screen {
                Some(screen) => screen,
                None => self.screen.insert(Offscreen::new(gpu, width, height).ok()?),
            };
            let mut view = View { style: opened.style, ..View::default() };
            turn_to(&mut view.camera, opened.viewpoint);
            let image = on!(&opened.runner, simulation => {
                let snapshot = simulation.snapshot();
                let bounds = bounds_with_solids(&snapshot)?;
                view.camera.frame(bounds, width as f32 / height as f32);
                go_to(&mut view.camera, opened.viewpoint);
                screen.render(&snapshot, &view).ok()?
            });
            let size = [image.width as usize, image.height as usize];
            Some(ColorImage::from_rgba_unmultiplied(size, &image.rgba))
        }
    }

    /// Opens a scene; nothing where that cannot be done: a click says why.
    fn open(row: usize, name: &str) -> Option<Opened> {
        let loaded = msd_scene::open(name).ok()?;
        let colour_by = usual_colours(&loaded.name);
        let style = Style { legend: false, colour_by, ..Style::default() };
        Some(Opened { row, runner: Runner::open(&loaded).ok()?, style, viewpoint: loaded.camera })
    }
}
