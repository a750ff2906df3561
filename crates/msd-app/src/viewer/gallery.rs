//! The gallery: built-in scenes and the files of a folder, with a thumbnail of each.

use std::path::Path;

/// Width and height of a thumbnail, pixels.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) const PICTURE: [u32; 2] = [192, 120];
/// Largest number of listed files.
const MOST_FILES: usize = 60;
/// Extensions of files that can be opened.
const ENDINGS: [&str; 8] = ["toml", "json", "obj", "stl", "ply", "gltf", "glb", "msd"];

/// A scene of the gallery.
pub struct Picture {
    /// Name that opens it.
    pub name: String,
    /// Description in one line; empty for a file that has not been opened.
    pub title: String,
    /// The thumbnail, once it is rendered.
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
    /// The path in the text field.
    pub path: String,
    /// Whether it was just opened: the path gets the focus.
    pub(crate) is_new: bool,
    #[cfg(not(target_arch = "wasm32"))]
    painter: painter::Painter,
}

impl Gallery {
    /// Lists the built-in scenes and the scenes, meshes and saved runs of a folder, and begins to
    /// open them for their thumbnails.
    pub(super) fn open(builtin: &[super::Entry], folder: &Path) -> Self {
        let scenes = builtin.iter().filter(|entry| !entry.is_lesson);
        let builtin = scenes.map(|entry| (entry.name.to_owned(), entry.title.to_owned()));
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

    /// Returns whether thumbnails are pending; a browser renders none.
    pub(crate) fn is_busy(&self) -> bool {
        #[cfg(not(target_arch = "wasm32"))]
        let is_busy = self.painter.is_busy();
        #[cfg(target_arch = "wasm32")]
        let is_busy = false;
        is_busy
    }

    /// Renders the next thumbnail on the device of the window.
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

/// Returns the files of a folder that may be scenes, sorted by name.
fn files(folder: &Path) -> Vec<String> {
    // The path of the current folder is empty.
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(here).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| {
        let path = folder.join(entry.file_name());
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        let is_file = ENDINGS.contains(&ending.as_str()) && path.is_file();
        // Other programs use these formats too.
        let is_ours = !matches!(ending.as_str(), "toml" | "json") || is_scene(&path);
        (is_file && is_ours).then(|| path.to_string_lossy().into_owned())
    });
    let mut names: Vec<String> = names.collect();
    names.sort();
    names.truncate(MOST_FILES);
    names
}

/// Returns whether a text looks like a scene: it has a version and bodies.
fn is_scene(path: &Path) -> bool {
    const LARGEST: u64 = 1 << 20;
    let is_small = path.metadata().is_ok_and(|data| data.len() <= LARGEST);
    is_small
        && std::fs::read_to_string(path)
            .is_ok_and(|text| text.contains("version") && text.contains("bodies"))
}

#[cfg(not(target_arch = "wasm32"))]
mod painter {
    //! Thumbnails: a thread opens the scenes, and the window renders them on its own device.

    use super::PICTURE;
    use egui::ColorImage;
    use msd_film::{go_to, turn_to, usual_colours};
    use msd_render::{Gpu, Offscreen, Style, View, bounds_with_solids};
    use msd_run::{Runner, on};
    use msd_scene::Viewpoint;
    use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

    /// A scene in its initial state, with its row and its style.
    #[derive(Debug)]
    struct Opened {
        row: usize,
        runner: Runner,
        style: Style,
        viewpoint: Viewpoint,
    }

    /// Renders the initial states of scenes, one per frame. The thread only opens them: a driver
    /// (Mesa's) that works in a thread at the end of the process crashes the process.
    #[derive(Debug)]
    pub(super) struct Painter {
        /// The opened scenes; `None` after the last one.
        opened: Option<Receiver<Opened>>,
        screen: Option<Offscreen>,
    }

    impl Painter {
        /// Begins to open scenes.
        pub(super) fn start(names: Vec<String>) -> Self {
            // One scene ahead of the rendering: they may be large.
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

        /// Returns whether more scenes are pending.
        pub(super) fn is_busy(&self) -> bool {
            self.opened.is_some()
        }

        /// Renders the next opened scene; returns its row and its thumbnail.
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

    /// Opens a scene; `None` after an error, which a click on the scene reports.
    fn open(row: usize, name: &str) -> Option<Opened> {
        let loaded = msd_scene::open(name).ok()?;
        let colour_by = usual_colours(&loaded.name);
        let style = Style { legend: false, colour_by, ..Style::default() };
        Some(Opened { row, runner: Runner::open(&loaded).ok()?, style, viewpoint: loaded.camera })
    }
}
