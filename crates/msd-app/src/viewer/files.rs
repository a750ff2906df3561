//! Files of the viewer: scenes opened, runs and scenes saved, the command for what is seen.

use super::scene_text::{says, with_values};
use super::{Command, Viewer};
use msd_core::Settings;
use msd_run::Runner;
use msd_run::recording::ENDING;
use msd_scene::{FileError, Loaded, Output, write_file, write_saved};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

impl Viewer {
    /// Opens a scene file, a mesh or a saved run. One that cannot be opened is told of, and what
    /// runs goes on.
    pub fn open_path(&mut self, path: &Path) {
        match msd_scene::open(path) {
            Ok(loaded) => {
                let note = loaded.notes.first().cloned();
                self.show_opened(loaded, None);
                self.note = note;
            }
            Err(error) => self.note = Some(error.to_string()),
        }
    }

    /// Begins or ends a recording, in a file of a name that is free.
    pub(super) fn record(&mut self) {
        if let Some(name) = self.session.recording().map(str::to_owned) {
            self.session.stop_recording();
            let again = format!("recorded; to see it again: msd run --replay {}", word(&name));
            // A file that could not be finished was told of.
            self.note = self.session.refusal().is_none().then_some(again);
            return;
        }
        let path = self.free_path(ENDING);
        self.session.start_recording(&path);
        let name = self.session.recording();
        self.note = name.map(|name| format!("recording into {name}; F9 ends it"));
    }

    /// Does what a command about files asks for.
    pub(super) fn file_command(&mut self, command: Command) {
        let done = match command {
            Command::SaveRun => self.keep_run(),
            Command::SaveScene => self.save_scene().map(|path| {
                let name = shown(&path);
                let only = "cuts, pins, rest lengths and frozen shapes are in a saved run only";
                format!("saved {name}, the scene with the values of now; {only}")
            }),
            _ => self.command_line().map(|line| {
                let text = format!("copied: {line}");
                self.clipboard = Some(line);
                text
            }),
        };
        self.note = Some(done.unwrap_or_else(|why| why));
    }

    /// Puts the link to what is seen on the clipboard, or says why there is none.
    pub fn copy_link(&mut self) {
        self.note = Some(match self.link() {
            Ok(link) => {
                self.clipboard = Some(link.to_string());
                "link copied".to_owned()
            }
            Err(why) => why,
        });
    }

    /// A file of a name that is free, in the folder of the program.
    fn free_path(&self, ending: &str) -> PathBuf {
        free(&self.folder, &self.session.loaded().name, ending)
    }

    /// Saves the run as it is, and returns a line that says how to go on from there.
    pub(crate) fn keep_run(&self) -> Result<String, String> {
        let name = shown(&self.save_run()?);
        Ok(format!("saved {name}; to go on from here: msd view {}", word(&name)))
    }

    /// Saves the run as it is and is looked at, and returns the file.
    fn save_run(&self) -> Result<PathBuf, String> {
        let loaded = self.session.loaded();
        let path = self.free_path("msd");
        let now = self.session.runner().to_loaded(&loaded.name, &loaded.title);
        let now = Loaded { camera: self.viewpoint(), ..now };
        let save = || -> Result<(), FileError> { write_saved(&now, Output::create(&path)?) };
        save().map_err(|error| error.to_string())?;
        Ok(path)
    }

    /// Saves the scene with the values of solver, material and world, and returns the file.
    fn save_scene(&self) -> Result<PathBuf, String> {
        let (loaded, runner) = (self.session.loaded(), self.session.runner());
        let made = self.session.material().made();
        let refused = |why: &str| format!("the scene cannot be saved: {why}; save the run instead");
        let builtin = msd_scene::BUILTINS.iter().find(|builtin| builtin.name == loaded.name);
        let toml = |file: &&PathBuf| file.extension() == Some(OsStr::new("toml"));
        let (text, folder) = match (self.current(), builtin, loaded.files.first().filter(toml)) {
            (Some(_), Some(builtin), _) => (builtin.text.to_owned(), self.folder.clone()),
            (_, _, Some(file)) => {
                let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
                // Beside the old one, which names its meshes from there.
                (text, file.parent().unwrap_or(Path::new("")).to_owned())
            }
            _ => return Err(refused("it is not from a scene file in TOML")),
        };
        let named = loaded.files.first().filter(|_| self.current().is_none());
        let written = msd_scene::open(named.map_or(Path::new(&loaded.name), PathBuf::as_path));
        let written = written.map_err(|error| refused(&error.to_string()))?;
        let text = with_values(&text, &written, (runner, made)).map_err(|why| refused(&why))?;
        let path = free(&folder, &loaded.name, "toml");
        write_file(&path, text.as_bytes()).map_err(|error| error.to_string())?;
        let read = msd_scene::open(&path);
        if read.is_ok_and(|read| says(&read, runner, made)) {
            return Ok(path);
        }
        // A file that says something else would be a lie.
        std::fs::remove_file(&path).ok();
        Err(refused("its keys cannot say what was set"))
    }

    /// The command that shows what is seen now: the scene and its solver, or where the run has gone
    /// on, or was changed, a saved run.
    fn command_line(&self) -> Result<String, String> {
        let (loaded, runner) = (self.session.loaded(), self.session.runner());
        // What the name opens, which is not always what was opened: the command line may have
        // said more.
        let scene = match self.current() {
            Some(_) => Some(loaded.name.clone()),
            None => loaded.files.first().map(|file| shown(file)),
        };
        let named = scene.and_then(|scene| Some((msd_scene::open(&scene).ok()?, scene)));
        let (settings, precision) = (runner.settings(), runner.precision());
        let is_start = |written: &Loaded| {
            // The command line divides frames, whatever the steps of the scene are.
            let is_sayable = settings.step == written.settings.step
                && (settings.step == Settings::default().step
                    || !options(written, runner).contains("--substeps"));
            let start = Runner::open_with(written, settings, precision, runner.is_automatic());
            is_sayable && start.is_ok_and(|start| start.progress() == runner.progress())
        };
        Ok(match named.filter(|(written, _)| is_start(written)) {
            Some((written, scene)) => {
                let mut line = format!("msd view {}", word(&scene));
                line.push_str(&options(&written, runner));
                if written.precision != runner.precision() {
                    line.push_str(&format!(" --precision {}", runner.precision()));
                }
                line
            }
            None => format!("msd view {}", word(&shown(&self.save_run()?))),
        })
    }
}

/// The options by which a scene is stepped otherwise than its author wants.
fn options(loaded: &Loaded, runner: &Runner) -> String {
    let (was, now) = (loaded.settings, runner.settings());
    let mut line = String::new();
    if was.integrator != now.integrator {
        line.push_str(&format!(" --integrator {}", now.integrator));
    }
    if now.integrator.is_adaptive() {
        if was.tolerance != now.tolerance {
            line.push_str(&format!(" --tolerance {:e}", now.tolerance));
        }
    } else if runner.is_automatic() {
        if !loaded.automatic {
            line.push_str(" --substeps auto");
        }
    } else if loaded.automatic || was.substeps != now.substeps {
        line.push_str(&format!(" --substeps {}", now.substeps));
    }
    if now.integrator.is_implicit() && was.newton != now.newton {
        line.push_str(&format!(" --newton {}", now.newton));
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

/// A word for a shell: in quotes where it would be several.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
    if text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}
