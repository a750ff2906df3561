//! Opening by name: a built-in scene, a scene file, a mesh or a saved run.

use crate::builtin::{BUILTINS, Builtin, carried};
use crate::disk::reason;
use crate::error::{FileError, nearest};
use crate::file::schema::SceneFile;
use crate::file::tree::{Assignment, Source};
use crate::file::{
    MeshReader, SceneFormat, Understood, decode, ending, format_of, read_text, refine, refusals,
    understand,
};
use crate::loaded::Loaded;
use crate::mesh::{self, Mesh, MeshError};
use crate::precision::Precision;
use crate::shown::shown_path;
use crate::storage::{self, load_saved, read_saved};
use msd_core::{Scene, Simulation};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Endings of mesh files.
const MESH_ENDINGS: [&str; 5] = ["obj", "stl", "ply", "gltf", "glb"];

/// Opens a scene by the user's input: a built-in name, a `.toml` or `.json` scene file, a mesh, a
/// saved run (`.msd`).
///
/// A mesh becomes a body 2 m long that drops on the ground. The name of a built-in scene means that
/// scene even beside a file or folder of the same name, which `./` reaches. `bunny.obj` and
/// `teapot.obj` mean a file where there is one, else the mesh that the crate carries.
///
/// # Errors
/// A name that stands for nothing, with the nearest one; everything that [`load`] refuses.
pub fn open(name: impl AsRef<Path>) -> Result<Loaded, FileError> {
    open_set(name, &[])
}

/// Opens a scene as [`open`] does, with values for keys of the scene in place of its own, one after
/// the other. Notes and title of the scene name them.
///
/// # Errors
/// The errors of [`open`]; a value that does not fit, at its place on the command line; any value
/// of a saved run, which has no keys.
pub fn open_set(name: impl AsRef<Path>, assignments: &[Assignment]) -> Result<Loaded, FileError> {
    let name = name.as_ref();
    if ending(name) == storage::ENDING && assignments.is_empty() {
        let loaded = load_saved(name)?;
        return Ok(Loaded { files: vec![name.into()], ..loaded });
    }
    let mut draft = Draft::open(name, Path::new(""))?;
    draft.set(assignments);
    draft.load(&draft.source()?)
}

/// Opens a scene file, a mesh or a saved run from the bytes of a file called `name`. It touches no
/// other, so a scene can only name meshes that the crate carries.
///
/// # Errors
/// An ending of no known format; everything that [`load`] refuses.
pub fn open_bytes(name: &str, bytes: &[u8]) -> Result<Loaded, FileError> {
    open_bytes_with(name, bytes, &BTreeMap::new())
}

/// Opens a scene as [`open_bytes`] does. It can also name the meshes that are given here, as the
/// bytes of their files by the names that it has for them.
///
/// # Errors
/// An ending of no known format; everything that [`load`] refuses.
pub fn open_bytes_with(
    name: &str,
    bytes: &[u8],
    meshes: &BTreeMap<String, Vec<u8>>,
) -> Result<Loaded, FileError> {
    let path = Path::new(name);
    let name = shown_path(path);
    let ending = ending(path);
    if ending == storage::ENDING {
        return read_saved(bytes, &name);
    }
    if let Some(format) = mesh::Format::from_extension(&ending) {
        let mesh = mesh::parse(bytes, format, &name).map_err(FileError::from)?;
        let draft = Draft::new(name, MESH_SCENE, SceneFormat::Toml, Origin::Mesh);
        draft.keep(MESH_FILE, Ok(mesh));
        return draft.load(&draft.source()?);
    }
    if !matches!(ending.as_str(), "toml" | "json") {
        return Err(FileError::Unreadable { file: name, reason: no_format() });
    }
    let text = std::str::from_utf8(bytes).map_err(|_| {
        let reason = "is not text in UTF-8".into();
        FileError::Unreadable { file: name.clone(), reason }
    })?;
    parse_with(text, format_of(path), &name, &|file| match meshes.get(file) {
        Some(bytes) => given_mesh(bytes, file),
        None => carried(file).unwrap_or_else(|| no_mesh(file)),
    })
}

/// Loads a scene file, TOML or JSON by its ending.
///
/// # Errors
/// A file that cannot be read; everything that [`parse`] refuses.
pub fn load(path: &Path) -> Result<Loaded, FileError> {
    let draft = Draft::read(path)?;
    draft.load(&draft.source()?)
}

/// Parses the text of a scene file; touches no file, so meshes can only be those that the crate
/// carries.
///
/// # Errors
/// Text that does not follow its format, an unknown key, a value outside its domain: each names the
/// line where it is known, and the key.
pub fn parse(text: &str, format: SceneFormat, name: &str) -> Result<Loaded, FileError> {
    parse_with(text, format, name, &|file| carried(file).unwrap_or_else(|| no_mesh(file)))
}

/// Reads the rows of a scene file as they were written, to be changed and written again.
///
/// # Errors
/// Text that does not follow its format, or an unknown key; values are not checked.
pub fn read(text: &str, format: SceneFormat, name: &str) -> Result<SceneFile, FileError> {
    decode(&Source::parse(text, format, name)?)
}

/// The text of a scene file, to be changed and written again.
///
/// # Errors
/// [`FileError::Unwritable`] for a number that the format cannot hold.
pub fn write(file: &SceneFile, format: SceneFormat) -> Result<String, FileError> {
    let refused = |reason: String| FileError::Unwritable { file: "scene".into(), reason };
    match format {
        SceneFormat::Toml => toml::to_string(file).map_err(|e| refused(e.to_string())),
        SceneFormat::Json => serde_json::to_string_pretty(file).map_err(|e| refused(e.to_string())),
    }
}

/// A scene that has been read and whose values may still be replaced before it is understood.
pub struct Draft {
    /// The user's name of the scene, with the folder it was found in.
    pub name: String,
    text: Cow<'static, str>,
    format: SceneFormat,
    origin: Origin,
    /// The file that was read, if one was.
    files: Vec<PathBuf>,
    /// Values in place of those of the text.
    assignments: Vec<Assignment>,
    /// Meshes read so far, by the name that the scene gives.
    meshes: Mutex<BTreeMap<String, Result<Mesh, MeshError>>>,
}

/// A scene at a part of its spacing: the same bodies, of the same material and size.
///
/// Bodies of alike springs keep their density and the moduli that their springs give inside; a
/// shell keeps the stiffness of its springs.
#[derive(Clone, Debug, PartialEq)]
pub struct Finer {
    /// The scene, ready to run; its settings are those of the original scene.
    pub loaded: Loaded,
    /// Its rows.
    pub rows: SceneFile,
    /// Pairs of particles that stand at one place in the original scene and in this one: all of a
    /// lattice, those on the surface of a mesh.
    pub common: Vec<[usize; 2]>,
}

/// Where a scene comes from, and so where its meshes are.
enum Origin {
    Builtin,
    /// A scene file in this folder.
    File(PathBuf),
    /// A bare mesh.
    Mesh,
}

impl Draft {
    /// Reads a scene that [`open`] would open, files relative to a folder.
    pub fn open(name: &Path, folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(name);
        let shown = shown_path(&path);
        let ending = ending(&path);
        if matches!(ending.as_str(), "toml" | "json") {
            return Draft::read(&path);
        }
        if MESH_ENDINGS.contains(&ending.as_str()) {
            // Read first: an error should name this file, not the scene around it.
            let mesh = read_mesh(&path, &name.to_string_lossy())?;
            let mut draft = Draft::new(shown, MESH_SCENE, SceneFormat::Toml, Origin::Mesh);
            draft.files.push(path);
            draft.keep(MESH_FILE, Ok(mesh));
            return Ok(draft);
        }
        if let Some(builtin) = name.to_str().and_then(Builtin::find) {
            return Ok(Draft::new(builtin.name, builtin.text, SceneFormat::Toml, Origin::Builtin));
        }
        Err(unknown_scene(&shown_path(name), &path))
    }

    /// Reads a scene file, TOML or JSON by its ending.
    fn read(path: &Path) -> Result<Self, FileError> {
        let name = shown_path(path);
        let format = format_of(path);
        let text = read_text(path, &name)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut draft = Draft::new(name, text, format, Origin::File(folder));
        draft.files.push(path.into());
        Ok(draft)
    }

    /// Takes the text of a scene file called `name`, and the bytes of the mesh files that it names.
    /// It touches no file, so other meshes can only be those that the crate carries.
    pub fn of_text(
        name: &str,
        (text, format): (String, SceneFormat),
        meshes: &BTreeMap<String, Vec<u8>>,
    ) -> Self {
        let draft = Draft::new(name, text, format, Origin::Builtin);
        for (file, bytes) in meshes {
            draft.keep(file, given_mesh(bytes, file));
        }
        draft
    }

    fn new(
        name: impl Into<String>,
        text: impl Into<Cow<'static, str>>,
        format: SceneFormat,
        origin: Origin,
    ) -> Self {
        let (name, text, files, assignments) = (name.into(), text.into(), Vec::new(), Vec::new());
        Draft { name, text, format, origin, files, assignments, meshes: Mutex::default() }
    }

    /// Gives keys of the scene values in place of its own, one after the other.
    pub fn set(&mut self, assignments: &[Assignment]) {
        self.assignments.extend_from_slice(assignments);
    }

    /// The tree of the scene file, with the values that were set.
    ///
    /// # Errors
    /// Text that does not follow its format; a key that was set and has no place in the tree.
    pub fn source(&self) -> Result<Source<'_>, FileError> {
        let mut source = Source::parse(&self.text, self.format, &self.name)?;
        source.drop = matches!(self.origin, Origin::Mesh).then_some(DROP);
        self.assignments.iter().try_for_each(|assignment| assignment.apply(&mut source))?;
        Ok(source)
    }

    /// Understands the tree, changed or not.
    pub fn load(&self, source: &Source<'_>) -> Result<Loaded, FileError> {
        let understood = understand(source, &|file| self.mesh(file));
        let refused = |error| self.explain(refusals(source, error));
        self.finish(source, understood.map_err(refused)?)
    }

    /// The error of a value at the place where it was set, if it was.
    fn explain(&self, error: FileError) -> FileError {
        let place = |key: &str| self.assignments.iter().rev().find_map(|set| set.place_of(key));
        error.placed(&place).unwrap_or_else(|error| error)
    }

    /// Understands the tree with every body at its spacing halved so many times: see [`Finer`].
    /// `coarse` is the scene of the unrefined tree.
    ///
    /// # Errors
    /// A body that has no spacing, with its name; a finer scene that does not fit the memory; the
    /// errors of [`Draft::load`].
    pub fn finer(
        &self,
        source: &Source<'_>,
        coarse: &Scene,
        halvings: u32,
    ) -> Result<Finer, FileError> {
        let refined = refine(source, coarse, halvings, &|file| self.mesh(file))?;
        let loaded = self.finish(source, refined.understood)?;
        Ok(Finer { loaded, rows: refined.rows, common: refined.common })
    }

    fn finish(&self, source: &Source<'_>, understood: Understood) -> Result<Loaded, FileError> {
        let mut loaded = finish(source, understood);
        if matches!(self.origin, Origin::Mesh) {
            drop_mesh(&mut loaded, source)?;
        }
        loaded.notes.extend(self.assignments.iter().map(|set| format!("set {set}")));
        let others = self.assignments.iter().filter(|set| set.key() != "title");
        let others: Vec<String> = others.map(Assignment::to_string).collect();
        if !others.is_empty() {
            loaded.title.push_str(&format!(", with {}", others.join(", ")));
        }
        loaded.files = self.files();
        Ok(loaded)
    }

    /// A mesh that the scene names; each is read once.
    pub fn mesh(&self, file: &str) -> Result<Mesh, MeshError> {
        let known = self.meshes.lock().unwrap_or_else(PoisonError::into_inner).get(file).cloned();
        known.unwrap_or_else(|| {
            let mesh = match &self.origin {
                Origin::File(folder) => read_mesh(&folder.join(file), file),
                Origin::Builtin | Origin::Mesh => carried(file).unwrap_or_else(|| no_mesh(file)),
            };
            self.keep(file, mesh.clone());
            mesh
        })
    }

    /// The files that were read so far; a mesh that the crate carries is not among them.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = self.files.clone();
        if let Origin::File(folder) = &self.origin {
            let meshes = self.meshes.lock().unwrap_or_else(PoisonError::into_inner);
            files.extend(meshes.keys().map(|file| folder.join(file)).filter(|file| file.exists()));
        }
        files
    }

    fn keep(&self, file: &str, mesh: Result<Mesh, MeshError>) {
        let mut meshes = self.meshes.lock().unwrap_or_else(PoisonError::into_inner);
        meshes.insert(file.into(), mesh);
    }
}

/// Why nothing is opened by this name.
fn unknown_scene(name: &str, path: &Path) -> FileError {
    if path.is_dir() {
        let reason = "it is a folder; a scene is a file".into();
        return FileError::Unreadable { file: name.into(), reason };
    }
    let known = match ending(path).as_str() {
        storage::ENDING => Some("a saved run has no keys that could be set"),
        "msdrec" => Some("it is a recording, which msd run --replay takes"),
        _ => None,
    };
    if let Some(reason) = known {
        return FileError::Unreadable { file: name.into(), reason: reason.into() };
    }
    if path.is_file() {
        return FileError::Unreadable { file: name.into(), reason: no_format() };
    }
    let names = BUILTINS.map(|builtin| builtin.name);
    // The name of a file without its ending is meant before that of a scene which is like it.
    let meant = beside(path).or_else(|| nearest(name, names).map(str::to_owned));
    let hint = match meant {
        Some(near) => format!("did you mean `{near}`?"),
        None => {
            format!("no file has that name; the built-in scenes are {}", names.join(", "))
        }
    };
    FileError::UnknownScene { name: name.into(), hint }
}

/// The file that a path lacks only the ending of.
fn beside(path: &Path) -> Option<String> {
    let endings = ["toml", "json", storage::ENDING].into_iter().chain(MESH_ENDINGS);
    let mut files = endings.map(|ending| {
        let mut file = path.as_os_str().to_owned();
        file.push(".");
        file.push(ending);
        PathBuf::from(file)
    });
    files.find(|file| file.is_file()).map(|file| shown_path(&file))
}

fn no_format() -> String {
    format!(
        "unknown extension; a scene file ends in .toml or .json, a saved run in .msd, a \
         mesh in .{}",
        MESH_ENDINGS.join(", .")
    )
}

fn parse_with(
    text: &str,
    format: SceneFormat,
    name: &str,
    read_mesh: &MeshReader<'_>,
) -> Result<Loaded, FileError> {
    let source = Source::parse(text, format, name)?;
    let understood = understand(&source, read_mesh);
    Ok(finish(&source, understood.map_err(|error| refusals(&source, error))?))
}

fn finish(source: &Source<'_>, understood: Understood) -> Loaded {
    // In messages and in saved runs both are a part of a line.
    let line = |text: &str| text.replace(char::is_control, " ");
    let name = line(&Path::new(source.name).file_stem().unwrap_or_default().to_string_lossy());
    let title = understood.title.map_or_else(|| name.clone(), |title| line(&title));
    Loaded {
        title,
        automatic: understood.automatic,
        precision: understood.precision,
        camera: understood.camera,
        notes: understood.notes,
        made: understood.made,
        rest_scales: understood.rest_scales,
        held: understood.held,
        wind: understood.wind,
        lesson: understood.lesson,
        ..Loaded::new(name, understood.scene, understood.settings)
    }
}

/// The scene that a bare mesh drops into.
const MESH_SCENE: &str = include_str!("../scenes/mesh.toml");
/// Its name of the mesh.
const MESH_FILE: &str = "the mesh that was named";
/// Height above the ground at which a bare mesh starts, metres.
const DROP: f64 = 0.3;
/// The most substeps that a bare mesh is given: beyond it another stiffness is the better answer.
const MAX_SUBSTEPS: f64 = 1000.0;

/// Names a mesh that nobody made a scene for, and gives it as many substeps as it needs unless the
/// `source` says how many.
fn drop_mesh(loaded: &mut Loaded, source: &Source<'_>) -> Result<(), FileError> {
    loaded.title = format!("{} dropped on the ground", loaded.name);
    for body in &mut loaded.scene.bodies {
        body.name.clone_from(&loaded.name);
    }
    if source.holds("solver.substeps") {
        return Ok(());
    }
    loaded.automatic = false;
    let core = |error| FileError::Core { file: source.name.into(), source: Box::new(error) };
    let stable = stable_substep(loaded).map_err(core)?;
    // A squashed body is stiffer than one at rest: the margin covers that.
    let substeps = (loaded.settings.step / (0.6 * stable)).ceil().clamp(1.0, MAX_SUBSTEPS);
    loaded.settings.substeps = substeps as u32;
    Ok(())
}

/// The largest stable substep at the start, seconds.
fn stable_substep(loaded: &Loaded) -> Result<f64, msd_core::Error> {
    let Loaded { scene, settings, precision, .. } = loaded;
    Ok(match precision {
        Precision::F32 => Simulation::<f32>::new(scene, *settings)?.stable_substep(),
        Precision::F64 => Simulation::<f64>::new(scene, *settings)?.stable_substep(),
    })
}

/// Reads a mesh file; if there is none, one that the crate carries may stand in by its bare name.
fn read_mesh(path: &Path, file: &str) -> Result<Mesh, MeshError> {
    match carried(file) {
        Some(mesh) if !path.exists() => mesh,
        _ => mesh::read(path).map_err(|error| match (error, std::fs::metadata(path)) {
            (MeshError::Unreadable { file, .. }, Err(missing)) => {
                MeshError::Unreadable { file, reason: reason(path, &missing) }
            }
            (error, _) => error,
        }),
    }
}

/// Reads a mesh from the bytes of its file.
fn given_mesh(bytes: &[u8], file: &str) -> Result<Mesh, MeshError> {
    match mesh::Format::from_extension(&ending(Path::new(file))) {
        Some(format) => mesh::parse(bytes, format, file),
        None => Err(MeshError::Unreadable { file: file.into(), reason: no_format() }),
    }
}

fn no_mesh(file: &str) -> Result<Mesh, MeshError> {
    let reason = "only a scene that is loaded from a file can name mesh files".into();
    Err(MeshError::Unreadable { file: file.into(), reason })
}
