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
    #[cfg(not(target_arch = "wasm32"))]
    painter: painter::Painter,
}

impl Gallery {
    /// Lists the built-in scenes and the scenes, meshes and saved runs of a folder, and begins to
    /// draw them.
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
        }
    }

    /// Takes over pictures that were drawn meanwhile; whether more are to come.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn receive(&mut self, ctx: &egui::Context) -> bool {
        self.painter.receive(|row, image| {
            if let Some(picture) = self.pictures.get_mut(row) {
                let name = format!("picture of {}", picture.name);
                picture.texture = Some(ctx.load_texture(name, image, Default::default()));
            }
        })
    }

    /// A browser draws none.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn receive(&mut self, _: &egui::Context) -> bool {
        false
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
    //! Small pictures, drawn beside the window.

    use super::super::shows_springs;
    use super::PICTURE;
    use crate::drivers::quietly;
    use egui::ColorImage;
    use msd_render::{Gpu, Offscreen, RenderError, Style, View, bounds};
    use msd_run::{Runner, on};
    use std::sync::mpsc::{Receiver, TryRecvError, channel};
    use std::thread::JoinHandle;

    /// Draws scenes one after the other. Dropped, it waits for the one that is being drawn: a
    /// driver at work in a thread while the process ends takes the process down with it (Mesa's).
    #[derive(Debug)]
    pub(super) struct Painter {
        drawn: Option<Receiver<(usize, ColorImage)>>,
        thread: Option<JoinHandle<()>>,
    }

    impl Drop for Painter {
        fn drop(&mut self) {
            self.drawn = None;
            // A painter that panicked has drawn less.
            let _ = self.thread.take().map(JoinHandle::join);
        }
    }

    impl Painter {
        /// Begins to draw the starts of scenes. Where there is no driver none is drawn.
        pub(super) fn start(names: Vec<String>) -> Self {
            let (sender, receiver) = channel();
            let work = move || {
                let opened = quietly(|| pollster::block_on(Gpu::headless()));
                let Ok(gpu) = opened else { return };
                let Ok(mut screen) = Offscreen::new(&gpu, PICTURE[0], PICTURE[1]) else { return };
                for (row, name) in names.iter().enumerate() {
                    if let Some(image) = draw(&mut screen, name)
                        && sender.send((row, image)).is_err()
                    {
                        return;
                    }
                }
            };
            let thread = std::thread::Builder::new().name("gallery".into()).spawn(work).ok();
            let drawn = thread.is_some().then_some(receiver);
            Painter { drawn, thread }
        }

        /// Hands over what was drawn since the last call; whether more is to come.
        pub(super) fn receive(&mut self, mut take: impl FnMut(usize, ColorImage)) -> bool {
            let Some(drawn) = &self.drawn else { return false };
            loop {
                match drawn.try_recv() {
                    Ok((row, image)) => take(row, image),
                    Err(TryRecvError::Empty) => return true,
                    Err(TryRecvError::Disconnected) => break,
                }
            }
            self.drawn = None;
            false
        }
    }

    /// The start of a scene, or nothing where it cannot be opened: a click says why.
    fn draw(screen: &mut Offscreen, name: &str) -> Option<ColorImage> {
        let loaded = msd_scene::open(name).ok()?;
        let runner = Runner::open(&loaded).ok()?;
        let springs = shows_springs(&loaded.name);
        let style = Style { legend: false, springs, ..Style::default() };
        let mut view = View { style, ..View::default() };
        let image = on!(&runner, simulation => {
            let snapshot = simulation.snapshot();
            let [width, height] = PICTURE;
            view.camera.frame(bounds(&snapshot)?, width as f32 / height as f32);
            let image: Result<_, RenderError> = screen.render(&snapshot, &view);
            image.ok()?
        });
        let size = [image.width as usize, image.height as usize];
        Some(ColorImage::from_rgba_unmultiplied(size, &image.rgba))
    }
}
