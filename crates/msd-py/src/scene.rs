//! Scenes: opened, made of texts and dicts, shown, pickled.

use crate::arrays;
use crate::errors::{file_error, refused};
use crate::network::Rows;
use crate::pictures;
use crate::run::lock::{Shared, Threads};
use crate::values::{from_serde, to_json};
use msd_core::glam::DVec3;
use msd_core::{Scene as CoreScene, Settings};
use msd_run::Runner;
use msd_run::quantity::counted;
use msd_scene::envelope::FileKind;
use msd_scene::{
    Assignment, Draft, FileError, Loaded, Precision, SceneFormat, Wind, open_set, tame,
};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyRange, PyTuple};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Header of pickled scenes; the format is raised with each change.
const KIND: FileKind = FileKind { what: "pickled scene", format: 1, oldest: 1 };

/// A scene: particles, springs, and how its author wants them stepped.
///
/// `msd.open`, `msd.scene`, `msd.network` and `msd.mesh` make scenes; `msd.Simulation` runs them.
/// A scene never changes, and it pickles.
///
/// >>> import msd
/// >>> msd.open("cloth")
/// <msd.Scene cloth: 961 particles, 3660 springs>
#[pyclass(frozen, module = "msd")]
pub struct Scene {
    pub loaded: Loaded,
    origin: Origin,
    pub set: Vec<Assignment>,
}

/// Source of a scene, from which it can be opened again with other keys.
#[derive(Clone, Serialize, Deserialize)]
pub enum Origin {
    /// An argument of `msd.open`.
    Named(PathBuf),
    /// The text of a scene file, and the meshes that it names.
    Text { text: String, is_json: bool, meshes: BTreeMap<String, Vec<u8>> },
    /// Rows of a network.
    Rows(Box<Rows>),
}

/// A pickled scene: a [`Loaded`] with the fields that its own serialization omits.
#[derive(Serialize, Deserialize)]
struct Pickled {
    loaded: Loaded,
    notes: Vec<String>,
    files: Vec<PathBuf>,
    wind: Option<(Wind, DVec3)>,
    origin: Origin,
    set: Vec<Assignment>,
}

impl Origin {
    fn open(&self, set: &[Assignment]) -> Result<Loaded, FileError> {
        match self {
            Origin::Named(name) => open_set(name, set),
            Origin::Text { text, is_json, meshes } => {
                let format = if *is_json { SceneFormat::Json } else { SceneFormat::Toml };
                let mut draft = Draft::of_text("scene", (text.clone(), format), meshes);
                draft.set(set);
                draft.load(&draft.source()?)
            }
            Origin::Rows(rows) => rows.load(set),
        }
    }
}

impl Scene {
    /// Opens the scene of an origin without the GIL.
    pub fn of(py: Python<'_>, origin: Origin, set: Vec<Assignment>) -> PyResult<Self> {
        let loaded = py.detach(|| origin.open(&set)).map_err(|error| file_error(py, error))?;
        Ok(Scene { loaded, origin, set })
    }

    fn rows(&self) -> &CoreScene {
        &self.loaded.scene
    }
}

/// Returns the keys that a dict sets, with their values.
pub fn assignments(keys: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Assignment>> {
    let Some(keys) = keys else { return Ok(Vec::new()) };
    let py = keys.py();
    let assign = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let Ok(key) = key.extract::<String>() else {
            return Err(refused(py, format!("the key {} must be a text", key.repr()?)));
        };
        let placed = |error: PyErr| refused(py, format!("{}: {}", tame(&key), error.value(py)));
        let value = to_json(&value).map_err(placed)?;
        if value.is_null() {
            let todo = "to have its default, make the scene without the key";
            return Err(refused(py, format!("{} is None; {todo}", tame(&key))));
        }
        // The message of the command line for text that is not a key.
        if let Err(reason) = Assignment::parse(&format!("{key}=0")) {
            return Err(refused(py, format!("the key `{}` {reason}", tame(&key))));
        }
        let text = serde_json::Value::String(format!("{key}={value}"));
        serde_json::from_value(text).map_err(|error| refused(py, format!("{key}: {error}")))
    };
    keys.iter().map(assign).collect()
}

/// Open a built-in scene, a scene file, a mesh or a saved run.
///
/// `name` is what the command line takes as SCENE, but no link. `keys` sets keys of the scene, as
/// `--set` does: `{"bodies[0].stiffness": 300}`. Others are `bodies[0].damping`, `world.gravity`,
/// `world.drag`, `solver.integrator`, `solver.step` and `solver.substeps`; `msd.schema()` describes
/// all. `msd.scenes` lists the built-in scenes.
///
/// >>> import msd
/// >>> msd.open("cloth", {"world.gravity": [0, -1.62, 0]}).notes
/// ['set world.gravity = [0, -1.62, 0]']
/// >>> msd.open("cloht")
/// Traceback (most recent call last):
/// msd.SceneError: no scene `cloht`: did you mean `cloth`?
#[pyfunction]
#[pyo3(signature = (name, keys=None))]
pub fn open(py: Python<'_>, name: PathBuf, keys: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
    if name.to_string_lossy().contains("#scene=") {
        let todo = "open the link with `msd run LINK --save run.msd` and name that file";
        return Err(refused(py, format!("msd for Python does not open links; {todo}")));
    }
    Scene::of(py, Origin::Named(name), assignments(keys)?)
}

/// Make a scene of the text of a scene file (TOML, or JSON if it begins with `{`), or of a dict
/// with the same keys.
///
/// The usual keys are `bodies`, each with `kind`, `size`, `spacing`, `mass`, `stiffness` and
/// `damping`; `world` with `gravity`, `drag` and `planes`; `solver` with `integrator`, `step`,
/// `substeps` and `precision`. `msd.schema()` describes all.
///
/// >>> import msd
/// >>> rope = dict(kind="rope", size=[3], spacing=0.1, mass=1, stiffness=100, damping=1)
/// >>> msd.scene({"version": 1, "bodies": [rope]})
/// <msd.Scene scene: 3 particles, 2 springs>
#[pyfunction]
#[pyo3(signature = (source, /))]
pub fn scene(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Scene> {
    let (text, is_json) = match source.extract::<String>() {
        Ok(text) => {
            let is_json = text.trim_start().starts_with('{');
            (text, is_json)
        }
        Err(_) if source.is_instance_of::<PyDict>() => (to_json(source)?.to_string(), true),
        Err(_) => {
            let kind = source.get_type().name()?;
            let message = format!("a scene is a text or a dict; this is of type {kind}");
            return Err(refused(py, message));
        }
    };
    Scene::of(py, Origin::Text { text, is_json, meshes: BTreeMap::new() }, Vec::new())
}

/// Describe the keys of scene files, with their units, domains and defaults: a dict, the JSON
/// Schema that `msd schema` prints.
///
/// >>> import msd
/// >>> keys = msd.schema()["properties"]
/// >>> sorted(keys["solver"]["properties"])[:4]
/// ['integrator', 'newton', 'precision', 'step']
/// >>> keys["bodies"]["items"]["properties"]["stiffness"]["description"]
/// 'Stiffness of each spring: force per change of length. Unit: N/m. ...'
#[pyfunction]
pub fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    py.import("json")?.call_method1("loads", (msd_scene::json_schema().to_string(),))
}

#[pymethods]
impl Scene {
    /// The name of the file, without folder and extension.
    #[getter]
    fn name(&self) -> &str {
        &self.loaded.name
    }

    /// Description in one line.
    #[getter]
    fn title(&self) -> &str {
        &self.loaded.title
    }

    /// Changes of the input by msd, and the keys that were set, a line each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.loaded.notes.clone()
    }

    /// Initial positions, metres: a new array of (n, 3).
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let particles = self.rows().particles.iter();
        arrays::vectors(py, particles.flat_map(|particle| particle.position.to_array()).collect())
    }

    /// Masses, kilograms: a new array of (n,).
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.rows().particles.iter().map(|particle| particle.mass))
    }

    /// The two particles of each spring: a new array of (m, 2).
    #[getter]
    fn springs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let ends = self.rows().springs.iter().flat_map(|spring| spring.ends.map(|end| end as i64));
        PyArray1::from_vec(py, ends.collect()).reshape([self.rows().springs.len(), 2])
    }

    /// The particles at the corners of the triangles of all bodies: a new array of (k, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let triangles = self.rows().bodies.iter().flat_map(|body| &body.surface.triangles);
        let corners = triangles.flat_map(|triangle| triangle.map(|corner| corner as i64));
        arrays::vectors(py, corners.collect())
    }

    /// The pinned particles: a new array.
    #[getter]
    fn pins<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.rows().pins.iter().map(|pin| pin.particle as i64))
    }

    /// The particles of each named set of pins, by its name: arrays.
    ///
    /// >>> import msd
    /// >>> gripper = msd.open("gripper")
    /// >>> sorted(gripper.held)
    /// ['left', 'right']
    #[getter]
    fn held<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let held = PyDict::new(py);
        for (name, particles) in &self.loaded.held {
            let particles = particles.iter().map(|&particle| particle as i64);
            held.set_item(name, PyArray1::from_iter(py, particles))?;
        }
        Ok(held)
    }

    /// The bodies: for each its `name`, and its `particles` and `springs` as ranges.
    ///
    /// >>> import msd
    /// >>> msd.open("cloth").bodies[0]["particles"]
    /// range(0, 961)
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let bodies = self.rows().bodies.iter().map(|body| {
            let range = |rows: &core::ops::Range<usize>| {
                PyRange::new(py, rows.start as isize, rows.end as isize)
            };
            let dict = PyDict::new(py);
            dict.set_item("name", &body.name)?;
            dict.set_item("particles", range(&body.particles)?)?;
            dict.set_item("springs", range(&body.springs)?)?;
            Ok(dict)
        });
        PyList::new(py, bodies.collect::<PyResult<Vec<_>>>()?)
    }

    /// The settings of the author: `integrator`, `step`, seconds, `substeps` per step, `automatic`
    /// (whether msd chooses them), `tolerance`, `newton` and `precision`.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Loaded { settings, automatic, precision, .. } = self.loaded;
        settings_dict(py, settings, (automatic, precision))
    }

    /// The same scene with other values of keys, as `msd.open` takes them. None is refused.
    ///
    /// >>> import msd
    /// >>> moon = msd.open("chain").with_keys({"world.gravity": [0, -1.62, 0]})
    /// >>> moon.notes
    /// ['set world.gravity = [0, -1.62, 0]']
    #[pyo3(signature = (keys, /))]
    fn with_keys(&self, py: Python<'_>, keys: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut set = self.set.clone();
        set.extend(assignments(Some(keys))?);
        Scene::of(py, self.origin.clone(), set)
    }

    fn __repr__(&self) -> String {
        let CoreScene { particles, springs, .. } = self.rows();
        let name = tame(&self.loaded.name);
        let count = |rows: usize, what| counted(rows as u64, what);
        let (particles, springs) =
            (count(particles.len(), "particle"), count(springs.len(), "spring"));
        format!("<msd.Scene {name}: {particles}, {springs}>")
    }

    /// Its start as a picture, where one can be drawn.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        let runner = py.detach(|| Runner::open(&self.loaded)).ok()?;
        let shared = Shared::new(runner, Threads::new(1));
        pictures::png(py, &shared, (&self.loaded.name, self.loaded.camera))
    }

    /// A table, unless there is a picture: a notebook would show that below it, or not at all.
    fn _repr_html_(&self, py: Python<'_>) -> Option<String> {
        if pictures::can_draw(py) {
            return None;
        }
        let escape =
            |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let rows = self.rows().bodies.iter().map(|body| {
            let (particles, springs) = (body.particles.len(), body.springs.len());
            format!(
                "<tr><td>{}</td><td>{particles}</td><td>{springs}</td></tr>",
                escape(&body.name)
            )
        });
        let rows: String = rows.collect();
        let CoreScene { particles, springs, .. } = self.rows();
        Some(format!(
            "<table><caption>{}</caption><tr><th>body</th><th>particles</th><th>springs</th></tr>\
             {rows}<tr><th>all</th><td>{}</td><td>{}</td></tr></table>",
            escape(&self.loaded.title),
            particles.len(),
            springs.len()
        ))
    }

    #[staticmethod]
    #[pyo3(name = "_from_bytes")]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let read = || -> Result<Pickled, FileError> { KIND.frames(bytes, "the pickle")?.expect() };
        let Pickled { loaded, notes, files, wind, origin, set } =
            read().map_err(|error| file_error(py, error))?;
        Ok(Scene { loaded: Loaded { notes, files, wind, ..loaded }, origin, set })
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, scene) = (slf.py(), slf.get());
        let Scene { loaded, origin, set } = scene;
        let bytes = KIND.bytes(&Pickled {
            loaded: loaded.clone(),
            notes: loaded.notes.clone(),
            files: loaded.files.clone(),
            wind: loaded.wind,
            origin: origin.clone(),
            set: set.clone(),
        });
        let bytes = bytes.map_err(|error| file_error(py, error))?;
        let read = py.get_type::<Scene>().getattr("_from_bytes")?;
        Ok((read, PyTuple::new(py, [PyBytes::new(py, &bytes)])?))
    }
}

/// Solver settings of a scene or a run.
#[derive(Serialize)]
struct SettingsReport {
    integrator: &'static str,
    step: f64,
    substeps: u32,
    automatic: bool,
    tolerance: f64,
    newton: u32,
    precision: &'static str,
}

/// Returns the solver settings of a scene or a run as a dict.
pub fn settings_dict<'py>(
    py: Python<'py>,
    settings: Settings,
    (automatic, precision): (bool, Precision),
) -> PyResult<Bound<'py, PyAny>> {
    let Settings { integrator, step, substeps, tolerance, newton } = settings;
    let (integrator, precision) = (integrator.name(), precision.name());
    let report =
        SettingsReport { integrator, step, substeps, automatic, tolerance, newton, precision };
    from_serde(py, &report)
}
