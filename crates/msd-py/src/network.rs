//! Scenes from arrays: networks of springs, and meshes.

use crate::arrays::{check_below, for_each, index_rows, particles, rows};
use crate::errors::refused;
use crate::scene::{Origin, Scene};
use crate::values::to_json;
use msd_core::glam::DVec3;
use msd_core::{Body, Particle, Pin, Spring, Surface};
use msd_scene::{Assignment, Draft, FileError, Loaded, Place, Precision, Rounding, SceneFormat};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A scene file with placeholders for the particles and springs of a network.
const FRAME: &str = r#"{"version": 1, "title": "a network of springs",
    "bodies": [{"name": "network", "kind": "explicit", "particles": [{"position": [0, 0, 0]}]}]}"#;
/// Keys of a scene that also apply to a network.
const KEYS: [&str; 4] = ["solver", "world", "title", "camera"];

/// The rows of a network.
#[derive(Clone, Serialize, Deserialize)]
pub struct Rows {
    particles: Vec<Particle>,
    springs: Vec<Spring>,
    pins: Vec<Pin>,
}

impl Rows {
    /// Loads the scene of these rows; `set` may contain keys outside bodies.
    pub fn load(&self, set: &[Assignment]) -> Result<Loaded, FileError> {
        let top = |set: &Assignment| set.key().split(['.', '[']).next().map(str::to_owned);
        let wrong = set.iter().find(|set| top(set).is_none_or(|top| !KEYS.contains(&&top[..])));
        if let Some(wrong) = wrong {
            let [file, key] = [wrong.key(); 2].map(str::to_owned);
            return Err(FileError::UnknownKey {
                place: Place { file, position: None },
                key,
                table: "a network".into(),
                hint: format!("a network has the keys {}", KEYS.join(", ")),
            });
        }
        let frame = (FRAME.to_owned(), SceneFormat::Json);
        let mut draft = Draft::of_text("network", frame, &BTreeMap::new());
        draft.set(set);
        let mut loaded = draft.load(&draft.source()?)?;
        let Rows { particles, springs, pins } = self.clone();
        loaded.scene.bodies = vec![Body {
            name: "network".into(),
            particles: 0..particles.len(),
            springs: 0..springs.len(),
            surface: Surface::default(),
            look: Default::default(),
        }];
        (loaded.scene.particles, loaded.scene.springs) = (particles, springs);
        (loaded.scene.pins, loaded.made) = (pins, Vec::new());
        // The placeholder lies at the origin, where f32 is fine enough.
        let is_asked = set.iter().any(|set| ["solver", "solver.precision"].contains(&set.key()));
        let loss = Rounding::of(&loaded.scene, Precision::F32);
        if !is_asked && loss.shows() {
            let Rounding { distance, spacing, .. } = loss;
            loaded.precision = Precision::F64;
            loaded.notes.push(format!(
                "the network gives no precision: f64, as {distance:.0} m from the origin f32 \
                 rounds positions to {spacing:.1e} m"
            ));
        }
        Ok(loaded)
    }
}

/// Make a network of springs from arrays.
///
/// `positions` is (n, 3), metres, and `springs` is (m, 2), the particles that each spring joins.
/// `mass`, kilograms, is a number or an array of (n,); `stiffness`, N/m, `damping`, N s/m, and
/// `rest`, metres, are numbers or arrays of (m,). Without `rest` the springs start at rest. `pins`
/// are particles that stand still: indexes, or an array of (n,) of booleans.
///
/// Without keywords each mass is 1 kg, each stiffness 100 N/m and each damping 0. Gravity is 9.82
/// m/s^2 downwards; the solver is velocity Verlet in "f32", or "f64" far from the origin, with
/// automatic substeps of 1/60 s. `with_keys` changes these.
///
/// >>> import msd
/// >>> net = msd.network([[0, 0, 0], [0, -1, 0]], [[0, 1]], stiffness=100, damping=0.1, pins=[0])
/// >>> net
/// <msd.Scene network: 2 particles, 1 spring>
/// >>> msd.network([[0, 0, 0]], [[0, 5]])
/// Traceback (most recent call last):
/// msd.SceneError: springs names particle 5, but there are only 1, counted from 0
#[pyfunction]
#[pyo3(signature = (positions, springs, *, mass=None, stiffness=None, damping=None, rest=None,
    pins=None))]
pub fn network(
    py: Python<'_>,
    positions: &Bound<'_, PyAny>,
    springs: &Bound<'_, PyAny>,
    mass: Option<&Bound<'_, PyAny>>,
    stiffness: Option<&Bound<'_, PyAny>>,
    damping: Option<&Bound<'_, PyAny>>,
    rest: Option<&Bound<'_, PyAny>>,
    pins: Option<&Bound<'_, PyAny>>,
) -> PyResult<Scene> {
    let places = rows::<3>("positions", positions, None)?;
    let ends = index_rows::<2>("springs", springs)?;
    check_below(py, "springs", ends.as_flattened(), places.len())?;
    let column = |what, value: Option<&Bound<'_, PyAny>>, count, usual| match value {
        Some(value) => for_each(what, value, count),
        None => Ok(vec![usual; count]),
    };
    let masses = column("mass", mass, places.len(), 1.0)?;
    let stiffnesses = column("stiffness", stiffness, ends.len(), 100.0)?;
    let dampings = column("damping", damping, ends.len(), 0.0)?;
    let rests = rest.map(|rest| for_each("rest", rest, ends.len())).transpose()?;
    let pinned = pins.map(|pins| particles("pins", pins, places.len())).transpose()?;
    let place = |particle: usize| DVec3::from_array(places[particle]);
    let spring = |row: usize| {
        let [a, b] = ends[row];
        let rest_length = rests.as_ref().map_or_else(|| place(a).distance(place(b)), |it| it[row]);
        Spring { ends: [a, b], rest_length, stiffness: stiffnesses[row], damping: dampings[row] }
    };
    let particle =
        |row: usize| Particle { position: place(row), velocity: DVec3::ZERO, mass: masses[row] };
    let pin = |particle| Pin { particle, velocity: DVec3::ZERO };
    let rows = Rows {
        particles: (0..places.len()).map(particle).collect(),
        springs: (0..ends.len()).map(spring).collect(),
        pins: pinned.unwrap_or_default().into_iter().map(pin).collect(),
    };
    let scene = Scene::of(py, Origin::Rows(Box::new(rows)), Vec::new())?;
    // Invalid values are reported here instead of at the first run.
    let checked = py.detach(|| {
        msd_core::Simulation::<f64>::new(&scene.loaded.scene, scene.loaded.settings).map(drop)
    });
    checked.map_err(|error| crate::errors::core_error(py, error))?;
    Ok(scene)
}

/// Make a scene of one body from a mesh.
///
/// `vertices` is (n, 3), metres, and `faces` is (m, 3) or (m, 4), vertices counted from 0. The
/// keywords are keys of a body that `msd.schema()` describes, such as `filling`, `spacing`, `young`
/// and `density`; `with_keys` sets those of world and solver.
///
/// >>> import msd
/// >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
/// >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
/// >>> msd.mesh(corners, faces, mass=0.1, stiffness=1000, damping=1)
/// <msd.Scene scene: 14 particles, 55 springs>
#[pyfunction]
#[pyo3(signature = (vertices, faces, **keys))]
pub fn mesh(
    py: Python<'_>,
    vertices: &Bound<'_, PyAny>,
    faces: &Bound<'_, PyAny>,
    keys: Option<&Bound<'_, PyDict>>,
) -> PyResult<Scene> {
    let places = rows::<3>("vertices", vertices, None)?;
    if let Some(row) = places.iter().position(|place| !place.iter().all(|x| x.is_finite())) {
        return Err(refused(py, format!("vertices has a number in row {row} that is not finite")));
    }
    let is_quads = faces.getattr("shape").and_then(|shape| shape.get_item(1));
    let is_quads = is_quads.is_ok_and(|width| width.eq(4).unwrap_or(false));
    let corners: Vec<Vec<usize>> = match is_quads {
        true => index_rows::<4>("faces", faces)?.into_iter().map(Vec::from).collect(),
        false => index_rows::<3>("faces", faces)?.into_iter().map(Vec::from).collect(),
    };
    for face in &corners {
        check_below(py, "faces", face, places.len())?;
    }
    let mut obj = String::new();
    let mut write = |line: std::fmt::Arguments<'_>| obj.write_fmt(line).unwrap_or_default();
    places.iter().for_each(|[x, y, z]| write(format_args!("v {x:?} {y:?} {z:?}\n")));
    for face in &corners {
        write(format_args!("f"));
        face.iter().for_each(|corner| write(format_args!(" {}", corner + 1)));
        write(format_args!("\n"));
    }
    let mut body = json!({"kind": "mesh", "file": MESH});
    if let (Some(keys), Value::Object(rows)) = (keys, &mut body) {
        let Value::Object(keys) = to_json(keys.as_any())? else { unreachable!("a dict") };
        rows.extend(keys);
    }
    let text = json!({"version": 1, "title": "a mesh", "bodies": [body]}).to_string();
    let meshes = BTreeMap::from([(MESH.to_owned(), obj.into_bytes())]);
    Scene::of(py, Origin::Text { text, is_json: true, meshes }, Vec::new())
}

/// Name of the mesh file inside the scene.
const MESH: &str = "mesh.obj";
