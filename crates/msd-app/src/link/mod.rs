//! Links: a scene, its changes and the camera, in the fragment of a web address.
//!
//! `#scene=cloth` is the scene alone. `&with=` and a text in base 64 add the changes: the number of
//! the format, the changes, and a checksum. `#scene=own&file=` and such a text hold a scene of the
//! user's own (`own_scene.rs`).

mod error;
mod seal;
mod own_scene;
mod former;

pub use error::LinkError;
pub use former::Former;
pub use own_scene::OwnScene;

use msd_run::Runner;
use msd_run::live::set_all;
use msd_scene::keys::Live;
use msd_scene::schema::Solver;
use msd_scene::{Builtin, Edits, Loaded, Precision};
use seal::{seal, unseal};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Version of the encoding; raised with each change of it.
const FORMAT: u8 = 5;
/// The first format that can still be read.
const FORMER: u8 = 3;
/// Parameters of the page, beside those of a link.
const PAGE: [&str; 2] = ["embed", "verify"];
/// Longest link, characters; browsers accept more, but people do not send longer ones.
const LONGEST: usize = 64_000;
/// Name of a scene that the link itself holds.
const OWN: &str = "own";

/// A scene and the user's changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The name of a built-in scene, or of the user's own.
    pub scene: String,
    /// The scene itself, unless it is built in.
    pub own: Option<OwnScene>,
    /// The user's changes; `None` for the scene as written.
    pub changes: Option<Changes>,
}

/// Changes of a scene, and the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Changes {
    /// Simulated seconds per second.
    pub speed: f64,
    /// The view.
    pub look: Look,
    /// Keys of the scene that were set, those of its solver included.
    pub set: Edits,
    /// Changes in a link of an earlier format that are not keys.
    #[serde(skip)]
    pub former: Option<Former>,
}

/// View of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// Target of the camera, metres; relative to the middle of the scene if the camera follows it.
    pub target: [f32; 3],
    /// Distance from the target, metres.
    pub distance: f32,
    /// Angle about the y axis, radians.
    pub yaw: f32,
    /// Angle above the horizon, radians.
    pub pitch: f32,
    /// Whether the camera follows the scene.
    pub follow: bool,
    /// Visible parts, a bit for each one that the window can show or hide.
    pub shown: u16,
}

impl Link {
    /// Returns whether a text that names a scene is a link: it is not a path, and no file of that
    /// name exists.
    pub fn is_meant(text: &str) -> bool {
        let is_path = ["./", "../", "/"].iter().any(|start| text.starts_with(start));
        text.contains("#scene=") && !is_path && !std::path::Path::new(text).exists()
    }

    /// Returns the link to a built-in scene as its author made it.
    pub fn to(scene: &str) -> Self {
        Link { scene: scene.to_owned(), own: None, changes: None }
    }

    /// Returns the link to a scene of the user's own, with the changes.
    ///
    /// # Errors
    /// A line that names the file that is too large, or says that there are too many changes.
    pub fn to_own(own: OwnScene, changes: Changes) -> Result<Self, String> {
        let link = Link { scene: OWN.into(), own: None, changes: Some(changes) }.checked()?;
        own.encode(LONGEST.saturating_sub(link.to_string().len() + "&file=".len()))?;
        Ok(Link { scene: own.name(), own: Some(own), ..link })
    }

    /// Returns the link, unless its changes make it too long.
    ///
    /// # Errors
    /// A line that says so.
    pub fn checked(self) -> Result<Self, String> {
        if LONGEST < self.to_string().len() {
            return Err("too many changes for a link: save the run instead".into());
        }
        Ok(self)
    }

    /// Reads a link, or its fragment alone, and ignores the parameters of the page.
    ///
    /// # Errors
    /// See [`LinkError`]. [`Link::edit`] checks later whether the changes fit the scene.
    pub fn parse(text: &str) -> Result<Link, LinkError> {
        let fragment = text.split_once('#').map_or(text, |(_, fragment)| fragment);
        if LONGEST < fragment.len() {
            return Err(LinkError::TooLarge);
        }
        let value = |key: &str| fragment.split('&').find_map(|part| part.strip_prefix(key));
        let scene = value("scene=").filter(|name| !name.is_empty()).ok_or(LinkError::NoScene)?;
        let is_known = |part: &str| {
            ["scene=", "file=", "with="].iter().any(|key| part.starts_with(key))
                || PAGE.contains(&part)
        };
        if !fragment.split('&').all(is_known) {
            return Err(LinkError::Damaged);
        }
        let changes = || value("with=").map(Changes::decode).transpose();
        if let (OWN, Some(file)) = (scene, value("file=")) {
            let own = OwnScene::decode(file)?;
            return Ok(Link { scene: own.name(), own: Some(own), changes: changes()? });
        }
        // The file was cut off, or stands beside a built-in scene.
        if scene == OWN || value("file=").is_some() {
            return Err(LinkError::Damaged);
        }
        if Builtin::find(scene).is_none() {
            let name: String = scene.chars().filter(|c| !c.is_control()).take(40).collect();
            return Err(LinkError::UnknownScene(name));
        }
        Ok(Link { scene: scene.to_owned(), own: None, changes: changes()? })
    }

    /// Opens the scene with the solver of the link; [`Link::edit`] makes the other edits.
    ///
    /// # Errors
    /// See [`msd_scene::open()`].
    pub fn load(&self) -> Result<Loaded, msd_scene::FileError> {
        let built_in = || msd_scene::open(&self.scene);
        let mut loaded = self.own.as_ref().map_or_else(built_in, OwnScene::load)?;
        if let Some(changes) = &self.changes {
            // `Changes::is_usable` has checked the keys of the solver.
            let row = changes.set.solver().unwrap_or_default();
            loaded.set_solver(loaded.solver().with(&row));
        }
        Ok(loaded)
    }

    /// Opens the scene with its edits made, for a study.
    ///
    /// # Errors
    /// One line: see [`Link::load`] and [`Link::edit`].
    pub fn open(&self) -> Result<Loaded, String> {
        let loaded = self.load().map_err(|error| error.to_string())?;
        let refused = |error: msd_core::Error| format!("{}: {error}", loaded.name);
        // In double precision no number of the scene is rounded.
        let precise = Solver { precision: Precision::F64, automatic: false, ..loaded.solver() };
        let mut runner = Runner::open_with(&loaded, precise).map_err(refused)?;
        self.edit(&loaded, &mut runner)?;
        let (scene, _) = runner.progress();
        Ok(Loaded { scene, ..loaded })
    }

    /// Makes the edits in a run of the scene that was loaded.
    ///
    /// # Errors
    /// A line on an edit that does not fit the scene.
    pub fn edit(&self, loaded: &Loaded, runner: &mut Runner) -> Result<(), String> {
        let Some(changes) = &self.changes else { return Ok(()) };
        set_all(runner, loaded, &changes.set_of(loaded)).map(drop)
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.own {
            None => write!(f, "#scene={}", self.scene)?,
            Some(own) => {
                // `to_own` limits the length; a link from elsewhere is printed at any length.
                let file = own.encode(usize::MAX).map_err(|_| fmt::Error)?;
                write!(f, "#scene={OWN}&file={file}")?;
            }
        }
        self.changes.as_ref().map_or(Ok(()), |changes| write!(f, "&with={}", changes.encode()))
    }
}

impl Changes {
    /// Returns the keys of the scene that were set, those of its solver included.
    pub(crate) fn set_of(&self, loaded: &Loaded) -> Edits {
        let mut set = self.former.as_ref().map(|former| former.keys(loaded)).unwrap_or_default();
        self.set.iter().for_each(|edit| set.set(edit.clone()));
        set
    }

    fn encode(&self) -> String {
        seal(FORMAT, &postcard::to_stdvec(self).unwrap_or_default())
    }

    fn decode(text: &str) -> Result<Self, LinkError> {
        let (format, content) = unseal(FORMER..=FORMAT, text)?;
        let changes = match format {
            FORMAT => postcard::from_bytes(&content).ok(),
            _ => former::changes(format, content),
        };
        changes.filter(Changes::is_usable).ok_or(LinkError::Damaged)
    }

    /// Returns whether a link may hold this: keys that can change in a run, and a finite camera.
    fn is_usable(&self) -> bool {
        let Look { target: [x, y, z], distance, yaw, pitch, .. } = self.look;
        self.set.iter().all(|edit| edit.live() != Live::Restart)
            && self.set.solver().is_ok()
            && self.former.as_ref().is_none_or(Former::is_usable)
            && [x, y, z, distance, yaw, pitch].iter().all(|number| number.is_finite())
            && (self.speed == f64::INFINITY || (1e-3..=100.0).contains(&self.speed))
    }
}
