//! Files of the viewer: opening scenes, saving runs and scenes, and the command line for a view.

use super::scene_text::{says, with_values};
use super::{Command, Viewer};
use crate::link::OwnScene;
use msd_core::Settings;
use msd_run::Runner;
use msd_run::recording::ENDING;
use msd_scene::schema::OrAuto;
use msd_scene::{FileError, Loaded, Output, Wind, write_file, write_saved};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Interval between checks for edited files, seconds.
const WATCHED_EVERY: f64 = 0.25;

/// Times and lengths of files when they were read.
#[derive(Debug)]
pub(super) struct FilesRead {
    stamps: Vec<Option<(SystemTime, u64)>>,
    /// Wall-clock time since the last check, seconds.
    since: f64,
}

impl FilesRead {
    /// Reads the current state of files.
    pub(super) fn of(files: &[PathBuf]) -> Self {
        let stamp = |file: &PathBuf| {
            let data = file.metadata().ok()?;
            Some((data.modified().ok()?, data.len()))
        };
        FilesRead { stamps: files.iter().map(stamp).collect(), since: 0.0 }
    }
}

/// Source of the session.
#[derive(Debug)]
pub(super) struct SceneSource {
    /// A scene outside the catalogue, from a file or a mesh.
    pub(super) opened: Option<Loaded>,
    /// Its source if that is not a file on this machine, or the reason why a link cannot hold it.
    pub(super) own: Option<Result<OwnScene, String>>,
    /// The running entry of the catalogue; `None` for the opened scene.
    pub(super) current: Option<usize>,
    /// The files of the scene at the time of reading.
    pub(super) watch: FilesRead,
}

impl Viewer {
    /// Opens a scene file, a mesh or a saved run; returns whether that succeeded. After an error,
    /// which a line explains, the current run continues.
    pub fn open_path(&mut self, path: &Path) -> bool {
        match msd_scene::open(path) {
            Ok(loaded) => {
                let note = loaded.notes.first().cloned();
                let is_shown = self.show_opened(loaded, None);
                self.note = note;
                is_shown
            }
            Err(error) => {
                self.note = Some(error.to_string());
                false
            }
        }
    }

    /// Returns whether an existing file of the scene has changed since it was read.
    pub fn is_edited(&self) -> bool {
        let now = FilesRead::of(&self.session.loaded().files);
        let mut pairs = now.stamps.iter().zip(&self.source.watch.stamps);
        pairs.any(|(now, read)| now.is_some() && now != read)
    }

    /// Reads the scene again after an edit of a file; `real` seconds of wall clock have passed.
    pub fn follow_files(&mut self, real: f64) {
        self.source.watch.since += real;
        if WATCHED_EVERY <= self.source.watch.since {
            self.source.watch.since = 0.0;
            if self.is_edited() {
                self.reload();
            }
        }
    }

    /// Restarts the scene from its current file; camera, pause and selection stay. If the file is
    /// invalid, the current run continues. A scene without a file restarts unchanged.
    pub(super) fn reload(&mut self) {
        let files = self.session.loaded().files.clone();
        let Some(path) = files.first() else { return self.restart() };
        // Before the file is read: a write during the reading counts as another edit.
        self.source.watch = FilesRead::of(&files);
        let loaded = match msd_scene::open(path) {
            Ok(loaded) => loaded,
            Err(error) => {
                self.note = Some(format!("{error}\nthe current run continues"));
                return;
            }
        };
        let selected = self.session.selected();
        let kept =
            (self.camera, self.aim.framed, self.aim.unframed, self.aim.aimed, self.aim.beside);
        if self.show_opened(loaded, None) {
            (self.camera, self.aim.framed, self.aim.unframed, self.aim.aimed, self.aim.beside) =
                kept;
            self.session.select_particle(selected);
            self.note = Some(format!("reloaded: {}", shown(path)));
        }
    }

    /// Begins or ends a recording, in a file with a free name.
    pub(super) fn record(&mut self) {
        if let Some(name) = self.session.recording().map(str::to_owned) {
            self.session.stop_recording();
            let again = format!("recorded; replay it with: msd run --replay {}", word(&name));
            // After a failure to finish the file, the refusal is already visible.
            self.note = self.session.refusal().is_none().then_some(again);
            return;
        }
        let path = self.free_path(ENDING);
        self.session.start_recording(&path);
        let name = self.session.recording();
        self.note = name.map(|name| format!("recording into {name}; F9 ends it"));
    }

    /// Performs a command on files.
    pub(super) fn file_command(&mut self, command: Command) {
        let done = match command {
            Command::SaveRun => self.keep_run(),
            Command::SaveScene => self.save_scene().map(|path| {
                let name = shown(&path);
                let only = "only a saved run keeps cuts, pins and frozen shapes";
                format!("saved {name}, the scene with the current values; {only}")
            }),
            _ => self.command_line().map(|line| {
                let text = format!("copied: {line}");
                self.wishes.clipboard = Some(line);
                text
            }),
        };
        self.note = Some(done.unwrap_or_else(|why| why));
    }

    /// Copies the link to the current view to the clipboard, or notes why there is none.
    pub(crate) fn copy_link(&mut self) {
        self.note = Some(match self.link() {
            Ok(link) => {
                self.wishes.clipboard = Some(link.to_string());
                "link copied".to_owned()
            }
            Err(why) => why,
        });
    }

    /// Returns a file with a free name, in the folder of the program.
    fn free_path(&self, ending: &str) -> PathBuf {
        free(&self.folder, &self.session.loaded().name, ending)
    }

    /// Saves the run, and returns a line that explains how to resume it.
    pub(crate) fn keep_run(&self) -> Result<String, String> {
        let name = shown(&self.save_run()?);
        Ok(format!("saved {name}; resume it with: msd view {}", word(&name)))
    }

    /// Returns the run with its current camera, for saving; a gusty wind continues.
    pub(crate) fn to_saved(&self) -> Loaded {
        let (loaded, wind) = (self.session.loaded(), self.session.wind());
        let mut now = self.session.runner().to_loaded(&loaded.name, &loaded.title);
        let calm = loaded.force_in(Wind::default(), 0.0);
        now.wind = (wind != Wind::default()).then_some((wind, calm));
        if wind.is_gusty() {
            now.scene.world.force = loaded.force_in(wind.mean(), 0.0);
        }
        Loaded { camera: self.viewpoint(), ..now }
    }

    /// Saves the run with its current camera, and returns the file.
    fn save_run(&self) -> Result<PathBuf, String> {
        let path = self.free_path("msd");
        let save = || write_saved(&self.to_saved(), Output::create(&path)?);
        save().map_err(|error: FileError| error.to_string())?;
        Ok(path)
    }

    /// Saves the scene with the current solver, material and world, and returns the file.
    fn save_scene(&self) -> Result<PathBuf, String> {
        let (loaded, runner) = (self.session.loaded(), self.session.runner());
        let (made, set) = (self.session.material().made(), self.session.material().set());
        let refused = |why: &str| format!("the scene cannot be saved: {why}; save the run instead");
        let builtin = msd_scene::Builtin::find(&loaded.name);
        let toml = |file: &&PathBuf| file.extension() == Some(OsStr::new("toml"));
        let (text, folder) = match (self.current(), builtin, loaded.files.first().filter(toml)) {
            (Some(_), Some(builtin), _) => (builtin.text.to_owned(), self.folder.clone()),
            (_, _, Some(file)) => {
                let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
                // In the folder of the old file, which its mesh paths are relative to.
                (text, file.parent().unwrap_or(Path::new("")).to_owned())
            }
            _ => return Err(refused("it is not from a scene file in TOML")),
        };
        let named = loaded.files.first().filter(|_| self.current().is_none());
        let written = msd_scene::open(named.map_or(Path::new(&loaded.name), PathBuf::as_path));
        let written = written.map_err(|error| refused(&error.to_string()))?;
        let text = with_values(&text, &written, (runner, set)).map_err(|why| refused(&why))?;
        let path = free(&folder, &loaded.name, "toml");
        write_file(&path, text.as_bytes()).map_err(|error| error.to_string())?;
        let read = msd_scene::open(&path);
        let wind = self.session.wind();
        let force = loaded.force_in(wind.mean(), 0.0);
        let is_windy = |read: &Loaded| read.wind() == wind && read.scene.world.force == force;
        if read.is_ok_and(|read| is_windy(&read) && says(&read, runner, made)) {
            return Ok(path);
        }
        // A file with other values must not stay.
        std::fs::remove_file(&path).ok();
        Err(refused("a scene file cannot hold all changes"))
    }

    /// Returns the command line for the current view: the scene and its solver or, if the run has
    /// advanced or was edited, a saved run.
    fn command_line(&self) -> Result<String, String> {
        let (loaded, runner) = (self.session.loaded(), self.session.runner());
        // The scene that the name opens: the session may differ from it by options of the command
        // line.
        let scene = match self.current() {
            Some(_) => Some(loaded.name.clone()),
            None => loaded.files.first().map(|file| shown(file)),
        };
        let named = scene.and_then(|scene| Some((msd_scene::open(&scene).ok()?, scene)));
        let settings = runner.settings();
        let is_start = |written: &Loaded| {
            // `--substeps` divides a frame, whatever the step of the scene is.
            let is_sayable = settings.step == written.settings.step
                && (settings.step == Settings::default().step
                    || !options(written, runner).contains("--substeps"));
            let start = Runner::open_with(written, runner.solver());
            is_sayable && start.is_ok_and(|start| start.progress() == runner.progress())
        };
        Ok(match named.filter(|(written, _)| is_start(written)) {
            Some((written, scene)) => {
                format!("msd view {}{}", word(&scene), options(&written, runner))
            }
            None => format!("msd view {}", word(&shown(&self.save_run()?))),
        })
    }
}

/// Returns the options for the solver of a run, where it differs from that of the scene.
fn options(loaded: &Loaded, runner: &Runner) -> String {
    let changed = runner.solver().row().but_for(&loaded.solver().row());
    let method = runner.integrator();
    let mut line = String::new();
    if let Some(integrator) = changed.integrator {
        line.push_str(&format!(" --integrator {integrator}"));
    }
    if let Some(tolerance) = changed.tolerance.filter(|_| method.is_adaptive()) {
        line.push_str(&format!(" --tolerance {tolerance:e}"));
    }
    match changed.substeps.filter(|_| !method.is_adaptive()) {
        Some(OrAuto::Auto) => line.push_str(" --substeps auto"),
        Some(OrAuto::Given(substeps)) => line.push_str(&format!(" --substeps {substeps}")),
        None => {}
    }
    if let Some(newton) = changed.newton.filter(|_| method.is_implicit()) {
        line.push_str(&format!(" --newton {newton}"));
    }
    if let Some(precision) = changed.precision {
        line.push_str(&format!(" --precision {precision}"));
    }
    line
}

pub(super) fn free(folder: &Path, name: &str, ending: &str) -> PathBuf {
    let path = |number: u32| folder.join(format!("{name}-{number}.{ending}"));
    let mut paths = (1..u32::MAX).map(path);
    paths.find(|path| !path.exists()).unwrap_or_else(|| path(u32::MAX))
}

pub(super) fn shown(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Quotes a text for a shell, if it needs quotes.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
    if text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}
