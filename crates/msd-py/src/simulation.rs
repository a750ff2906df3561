//! Methods of runs.

use crate::arrays;
use crate::errors::{core_error, file_error, refused};
use crate::options::{Count, Of, Triple, solver};
use crate::pictures::{self, Picture};
use crate::run::Simulation;
use crate::run::force::{Callable, Force, is_own};
use crate::run::lock::{Shared, Threads};
use crate::run::readings::{numbers, vectors_of};
use crate::run::stepping::steps_in;
use crate::scene::{Scene, settings_dict};
use crate::values::{from_serde, to_json};
use msd_core::glam::DVec3;
use msd_core::{Friction, Interaction, Look, MaterialNumber, Plane, State};
use msd_run::quantity::counted;
use msd_run::{EnergyReport, Runner};
use msd_scene::{AnyState, Output, read_saved, saved_bytes, state_hash, write_saved};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scene, **solver))]
    #[pyo3(text_signature = "(scene, *, integrator=None, step=None, substeps=None, \
                             tolerance=None, newton=None, precision=None, threads=1)")]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, Scene>,
        solver: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let loaded = &scene.get().loaded;
        let (solver, threads) = self::solver(loaded, solver)?;
        let runner = py.detach(|| Runner::open_with(loaded, solver));
        let runner = runner.map_err(|error| core_error(py, error))?;
        Ok(Simulation::of(loaded, runner, threads))
    }

    /// Take `n` steps. A step that fails raises StepError and keeps the state before it. Ctrl-C
    /// keeps the steps taken.
    #[pyo3(signature = (n=Count::Of(1)), text_signature = "($self, n=1)")]
    fn step(&self, py: Python<'_>, n: Count) -> PyResult<()> {
        match n.get(py, "n")? {
            1 => self.try_work(py, Runner::step),
            n => self.advance(py, n),
        }
    }

    /// Take the number of steps nearest to so many simulated seconds: none for 0, else at least
    /// one. Ctrl-C keeps the steps taken.
    fn run(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        let step = self.work(py, |runner| runner.settings().step)?;
        let steps = steps_in(seconds, step).map_err(|reason| refused(py, reason))?;
        self.advance(py, steps)
    }

    /// Positions now and after each of `frames` times `every` steps, metres: a new array of
    /// (frames + 1, n, 3), or of (frames + 1, k, 3) of the particles `points`.
    ///
    /// Ctrl-C keeps the steps taken, but loses the frames.
    ///
    /// >>> import msd
    /// >>> run = msd.Simulation(msd.open("chain"))
    /// >>> run.trajectory(10, every=2, points=[0, 4]).shape
    /// (11, 2, 3)
    #[pyo3(signature = (frames, every=Count::Of(1), points=None),
        text_signature = "($self, frames, every=1, points=None)")]
    fn trajectory<'py>(
        &self,
        py: Python<'py>,
        frames: Count,
        every: Count,
        points: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let counts = (frames.get(py, "frames")?, every.get(py, "every")?);
        let count = self.work(py, |runner| runner.particle_count())?;
        let points = points.map(|points| arrays::particles("points", points, count)).transpose()?;
        crate::run::readings::trajectory(py, counts, points.as_deref(), &self.shared)
    }

    /// Simulated time, seconds.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.work(py, |runner| runner.time())
    }

    /// Steps taken.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.work(py, |runner| runner.steps())
    }

    /// Its settings: `integrator`, `step`, seconds, `substeps` per step, `automatic` (whether msd
    /// chooses them), `tolerance`, `newton`, `precision` and `threads`.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let now =
            |runner: &mut Runner| (runner.settings(), (runner.is_automatic(), runner.precision()));
        let (settings, others) = self.work(py, now)?;
        let dict = settings_dict(py, settings, others)?;
        dict.set_item("threads", self.shared.threads())?;
        Ok(dict)
    }

    /// Positions, metres: a new array of (n, 3) in the precision of the run.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.work(py, |runner| numbers!(runner, positions))?.array(py)
    }

    /// Velocities, metres per second: a new array of (n, 3) in the precision of the run.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.work(py, |runner| numbers!(runner, velocities))?.array(py)
    }

    /// Forces on all particles at the current state, newtons: a new array of (n, 3) in the
    /// precision of the run. Contact, and what holds pins, are not among them.
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.work(py, |runner| vectors_of(runner))?.array(py)
    }

    /// Write the positions into `out`, a contiguous array of (n, 3) of float32 or float64.
    fn copy_positions(&self, py: Python<'_>, out: &Bound<'_, PyAny>) -> PyResult<()> {
        crate::run::readings::copy_positions(py, &self.shared, out)
    }

    /// Replace positions, metres, and velocities, metres per second: arrays of (n, 3). The time
    /// goes on.
    fn set_state(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        velocities: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let count = self.work(py, |runner| runner.particle_count())?;
        let column = |what, value| -> PyResult<Vec<DVec3>> {
            let rows = arrays::rows::<3>(what, value, Some(count))?;
            Ok(rows.into_iter().map(DVec3::from_array).collect())
        };
        let positions = column("positions", positions)?;
        let velocities = column("velocities", velocities)?;
        let state = AnyState::F64(State { positions, velocities });
        self.try_work(py, |runner| runner.set_state(&state, runner.steps()))
    }

    /// Energy, joules: a dict of `kinetic`, `elastic`, `gravitational`, `dissipated`, `supplied`
    /// and `total`.
    ///
    /// `total` is kinetic + elastic + gravitational + dissipated - supplied. Exact motion conserves
    /// it, unless you push, grab or change the run. `dissipated` and `supplied` count from the
    /// start of the run.
    ///
    /// >>> import msd
    /// >>> run = msd.Simulation(msd.open("chain"), precision="f64")
    /// >>> before = run.energy()["total"]
    /// >>> run.run(0.5)
    /// >>> abs(run.energy()["total"] - before) < 1e-3
    /// True
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let energy = self.work(py, |runner| runner.energy())?;
        from_serde(py, &EnergyReport::from(energy))
    }

    /// Momentum: a dict of `linear`, newton seconds, and `angular` about the origin, newton metre
    /// seconds; each an array of three.
    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let momentum = self.work(py, |runner| runner.momentum())?;
        from_serde(py, &momentum)
    }

    /// The longest substep predicted stable at the current state, seconds: 0 if none is, infinite
    /// if all are. Takes some dozens of evaluations of the forces.
    fn stable_substep(&self, py: Python<'_>) -> PyResult<f64> {
        self.work(py, |runner| runner.stable_substep())
    }

    /// A hash of positions and velocities, the `state_hash` of `msd run --json`.
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        self.work(py, |runner| format!("{:016x}", state_hash(&runner.state())))
    }

    /// The force with which pins hold some particles, newtons: an array of three.
    ///
    /// `of` is a body by its name, a particle, a range or an array of particles; the particles that
    /// are not pinned among them do not count. The force is that of a pin which moves steadily:
    /// minus the forces on its particle.
    #[pyo3(signature = (of=None))]
    fn pin_force<'py>(
        &self,
        py: Python<'py>,
        of: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        crate::run::readings::pin_force(py, &self.shared, of)
    }

    /// Add a force that `callable(time, positions, velocities)` returns as an array of (n, 3),
    /// newtons.
    ///
    /// It is slow: msd calls it in each evaluation of the forces. An exception in it ends the step,
    /// keeps the state, and is what you see. A force that is not finite raises SceneError. The same
    /// arguments must give the same forces. `copy` keeps the force; `save`, `to_bytes` and pickle
    /// refuse a run that has one.
    ///
    /// >>> import msd
    /// >>> run = msd.Simulation(msd.open("chain"))
    /// >>> run.add_force(lambda time, positions, velocities: -0.01 * velocities)
    /// >>> run.step()
    fn add_force(&self, py: Python<'_>, callable: Py<PyAny>) -> PyResult<()> {
        if !callable.bind(py).is_callable() {
            let kind = callable.bind(py).get_type().name()?;
            return Err(refused(py, format!("a force is a callable; this is of type {kind}")));
        }
        let callable = Arc::new(Mutex::new(Some(callable)));
        self.work(py, |runner| runner.add_element(Force(callable.clone())))?;
        self.callables().push(callable);
        Ok(())
    }

    /// Pull a particle to a point by a spring; another grab of it moves the point.
    ///
    /// `frequency`, hertz, is that of the particle alone on the spring, `damping_ratio` 1 is
    /// critical, and `max_force` bounds the force, newtons.
    #[pyo3(signature = (particle, target, frequency=3.0, damping_ratio=1.0, max_force=1e9))]
    fn grab(
        &self,
        py: Python<'_>,
        particle: Count,
        target: Triple,
        frequency: f64,
        damping_ratio: f64,
        max_force: f64,
    ) -> PyResult<()> {
        let (particle, target) = (particle.index(py, "particle")?, target.0);
        let grab = Interaction::Grab { particle, target, frequency, damping_ratio, max_force };
        self.queue(py, grab)
    }

    /// Let go of a grabbed particle.
    fn release(&self, py: Python<'_>, particle: Count) -> PyResult<()> {
        self.queue(py, Interaction::Release { particle: particle.index(py, "particle")? })
    }

    /// Pin a particle, which then keeps this velocity, metres per second.
    #[pyo3(signature = (particle, velocity=Triple(DVec3::ZERO)),
        text_signature = "($self, particle, velocity=(0, 0, 0))")]
    fn pin(&self, py: Python<'_>, particle: Count, velocity: Triple) -> PyResult<()> {
        let (particle, velocity) = (particle.index(py, "particle")?, velocity.0);
        self.queue(py, Interaction::Pin { particle, velocity })
    }

    /// Free a pinned particle.
    fn unpin(&self, py: Python<'_>, particle: Count) -> PyResult<()> {
        self.queue(py, Interaction::Unpin { particle: particle.index(py, "particle")? })
    }

    /// Push a particle with a force, newtons, during the next step.
    fn push(&self, py: Python<'_>, particle: Count, force: Triple) -> PyResult<()> {
        self.queue(
            py,
            Interaction::Push { particle: particle.index(py, "particle")?, force: force.0 },
        )
    }

    /// Remove a spring for good.
    fn cut(&self, py: Python<'_>, spring: Count) -> PyResult<()> {
        self.queue(py, Interaction::Cut { spring: spring.index(py, "spring")? })
    }

    /// Set the stiffness, N/m, of springs: all, or those of a body by its name, one, or a range.
    /// Other methods take `of` alike, for springs or particles.
    #[pyo3(signature = (value, of=Of::All), text_signature = "($self, value, of=None)")]
    fn set_stiffness(&self, py: Python<'_>, value: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |springs| Interaction::SetStiffness { springs, value })
    }

    /// Set the damping, N s/m, of springs.
    #[pyo3(signature = (value, of=Of::All), text_signature = "($self, value, of=None)")]
    fn set_damping(&self, py: Python<'_>, value: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |springs| Interaction::SetDamping { springs, value })
    }

    /// Set the mass, kilograms, of each of some particles.
    #[pyo3(signature = (value, of=Of::All), text_signature = "($self, value, of=None)")]
    fn set_mass(&self, py: Python<'_>, value: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |particles| Interaction::SetMass { particles, value })
    }

    /// Set the rest length, metres, of springs.
    #[pyo3(signature = (value, of=Of::All), text_signature = "($self, value, of=None)")]
    fn set_rest_length(&self, py: Python<'_>, value: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |springs| Interaction::SetRestLength { springs, value })
    }

    /// Multiply the rest lengths of springs.
    #[pyo3(signature = (factor, of=Of::All), text_signature = "($self, factor, of=None)")]
    fn scale_rest_length(&self, py: Python<'_>, factor: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |springs| Interaction::ScaleRestLength { springs, factor })
    }

    /// Make the current lengths of springs their rest lengths.
    #[pyo3(signature = (of=Of::All), text_signature = "($self, of=None)")]
    fn freeze(&self, py: Python<'_>, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |springs| Interaction::Freeze { springs })
    }

    /// Add an impulse, newton seconds, shared among particles in proportion to mass.
    #[pyo3(signature = (impulse, of=Of::All), text_signature = "($self, impulse, of=None)")]
    fn impulse(&self, py: Python<'_>, impulse: Triple, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |particles| Interaction::Impulse { particles, impulse: impulse.0 })
    }

    /// Add a turn of particles about their centre of mass, radians per second.
    #[pyo3(signature = (velocity, of=Of::All), text_signature = "($self, velocity, of=None)")]
    fn spin(&self, py: Python<'_>, velocity: Triple, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |particles| Interaction::Spin { particles, velocity: velocity.0 })
    }

    /// Set gravity, metres per second squared.
    fn set_gravity(&self, py: Python<'_>, value: Triple) -> PyResult<()> {
        self.queue(py, Interaction::SetGravity { value: value.0 })
    }

    /// Set the uniform force on every particle, newtons.
    fn set_force(&self, py: Python<'_>, value: Triple) -> PyResult<()> {
        self.queue(py, Interaction::SetForce { value: value.0 })
    }

    /// Set the drag of the air on each particle, N s/m.
    fn set_drag(&self, py: Python<'_>, value: f64) -> PyResult<()> {
        self.queue(py, Interaction::SetDrag { value })
    }

    /// Set the restitution, 0 to 1, and Coulomb's friction of a plane.
    fn set_plane(
        &self,
        py: Python<'_>,
        plane: Count,
        restitution: f64,
        friction: f64,
    ) -> PyResult<()> {
        let (plane, friction) = (plane.index(py, "plane")?, Friction::Coulomb(friction));
        self.queue(py, Interaction::SetPlane { plane, restitution, friction })
    }

    /// Add a plane: particles stay where normal·x is at least `offset`, metres.
    #[pyo3(signature = (normal=Triple(DVec3::Y), offset=0.0, restitution=0.0, friction=0.0),
        text_signature = "($self, normal=(0, 1, 0), offset=0.0, restitution=0.0, friction=0.0)")]
    fn add_plane(
        &self,
        py: Python<'_>,
        normal: Triple,
        offset: f64,
        restitution: f64,
        friction: f64,
    ) -> PyResult<()> {
        let (normal, friction) = (normal.0, Friction::Coulomb(friction));
        let plane = Plane { normal, offset, restitution, friction };
        self.queue(py, Interaction::AddPlane { plane })
    }

    /// Remove all planes.
    fn remove_planes(&self, py: Python<'_>) -> PyResult<()> {
        self.queue(py, Interaction::RemovePlanes)
    }

    /// Multiply the Young's modulus ("young"), "thickness" or "density" of all bodies or of one.
    #[pyo3(signature = (number, factor, of=Of::All),
        text_signature = "($self, number, factor, of=None)")]
    fn scale_material(&self, py: Python<'_>, number: &str, factor: f64, of: Of) -> PyResult<()> {
        let number = match number {
            "young" => MaterialNumber::Young,
            "thickness" => MaterialNumber::Thickness,
            "density" => MaterialNumber::Density,
            other => {
                let must = "it must be young, thickness or density";
                return Err(refused(py, format!("number is {other}; {must}")));
            }
        };
        self.queue_of(py, &of, |bodies| Interaction::ScaleMaterial { bodies, number, factor })
    }

    /// Damp springs, bends and volumes by their stiffness times so many seconds, of all bodies or
    /// of one.
    #[pyo3(signature = (value, of=Of::All), text_signature = "($self, value, of=None)")]
    fn set_relaxation_time(&self, py: Python<'_>, value: f64, of: Of) -> PyResult<()> {
        self.queue_of(py, &of, |bodies| Interaction::SetRelaxationTime { bodies, value })
    }

    /// Put a solid at a position, metres, from where it moves steadily.
    #[pyo3(signature = (solid, position, velocity=Triple(DVec3::ZERO), spin=Triple(DVec3::ZERO)),
        text_signature = "($self, solid, position, velocity=(0, 0, 0), spin=(0, 0, 0))")]
    fn move_solid(
        &self,
        py: Python<'_>,
        solid: Count,
        position: Triple,
        velocity: Triple,
        spin: Triple,
    ) -> PyResult<()> {
        let (solid, position) = (solid.index(py, "solid")?, position.0);
        let (velocity, spin) = (velocity.0, spin.0);
        self.queue(py, Interaction::MoveSolid { solid, position, velocity, spin })
    }

    /// Set how a body looks: `colour` and `back` as three numbers from 0 to 1, `roughness`,
    /// `metal`, `translucency`, `pattern` and `pattern_size`.
    #[pyo3(signature = (body, **look))]
    fn set_look(
        &self,
        py: Python<'_>,
        body: Count,
        look: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let mut keys = serde_json::to_value(Look::default()).unwrap_or_default();
        for (key, value) in look.into_iter().flatten() {
            let key: String = key.extract()?;
            let unknown = || refused(py, format!("unknown keyword `{key}` of a look"));
            *keys.get_mut(&key).ok_or_else(unknown)? = to_json(&value)?;
        }
        let look = serde_json::from_value(keys).map_err(|error| refused(py, error))?;
        self.queue(py, Interaction::SetLook { body: body.index(py, "body")?, look })
    }

    /// Draw the current state: a new array of (height, width, 4) with red, green, blue and opacity
    /// from 0 to 255.
    ///
    /// `camera` is "front", "back", "left", "right" or "top", or (yaw, pitch), degrees; without it
    /// the picture is that of `msd render`. Colours stand for `colour`: "strain", "force", "energy"
    /// or "speed". Without `background` sky, ground and walls are transparent. A build without
    /// pictures, or a machine without a graphics driver, raises Error.
    #[pyo3(signature = (width=Count::Of(640), height=Count::Of(480), camera=None, colour=None,
        background=true), text_signature = "($self, width=640, height=480, camera=None, \
                                            colour=None, background=True)")]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        width: Count,
        height: Count,
        camera: Option<&Bound<'py, PyAny>>,
        colour: Option<&str>,
        background: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let size = [width.get(py, "width")?, height.get(py, "height")?];
        let look = Picture { size, camera, colour, background };
        pictures::picture(py, self, look)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        pictures::png(py, &self.shared, (&self.name, self.camera))
    }

    /// Write the run into a file, which `msd run`, `msd view`, `msd.open` and `load` take. A run
    /// with a force of your own is refused.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let loaded = self.saved(py)?;
        let written = py.detach(|| write_saved(&loaded, Output::create(&path)?));
        written.map_err(|error| file_error(py, error))
    }

    /// Read a run that was saved; it goes on with the same bits.
    #[staticmethod]
    #[pyo3(signature = (path, threads=1))]
    fn load(py: Python<'_>, path: PathBuf, threads: usize) -> PyResult<Self> {
        let loaded = py.detach(|| msd_scene::load_saved(&path));
        Simulation::opened(py, &loaded.map_err(|error| file_error(py, error))?, threads)
    }

    /// The bytes that `save` would write.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let loaded = self.saved(py)?;
        let bytes = py.detach(|| saved_bytes(&loaded)).map_err(|error| file_error(py, error))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Make a run of the bytes of `to_bytes`.
    #[staticmethod]
    #[pyo3(signature = (bytes, threads=1))]
    fn from_bytes(py: Python<'_>, bytes: &[u8], threads: usize) -> PyResult<Self> {
        let loaded = read_saved(bytes, "the bytes").map_err(|error| file_error(py, error))?;
        Simulation::opened(py, &loaded, threads)
    }

    /// A copy that goes on by itself, with the same bits and the same forces of your own.
    pub fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let runner = self.work(py, |runner| runner.clone())?;
        let forces = Mutex::new(self.callables().clone());
        let shared = Shared::new(runner, Threads::new(self.shared.threads()));
        let (name, title) = (self.name.clone(), self.title.clone());
        Ok(Simulation { shared, name, title, camera: self.camera, forces })
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.copy(py)
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, run) = (slf.py(), slf.get());
        let read = py.get_type::<Simulation>().getattr("from_bytes")?;
        Ok((read, (run.to_bytes(py)?, run.shared.threads()).into_pyobject(py)?))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        let Ok(forces) = self.forces.try_lock() else { return Ok(()) };
        for force in forces.iter().filter(|force| is_own(force)) {
            let callable = force.try_lock();
            callable.map_or(Ok(()), |callable| visit.call(callable.as_ref()))?;
        }
        Ok(())
    }

    fn __clear__(&self) {
        let take = |force: &Callable| force.lock().unwrap_or_else(PoisonError::into_inner).take();
        let taken: Vec<_> = self.callables().iter().filter(|it| is_own(it)).map(take).collect();
        // Objects that they refer to may use this run as they end: it is not locked any more.
        drop(taken);
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let title = msd_scene::tame(&self.name);
        self.work(py, |runner| {
            let settings = runner.settings();
            let (method, precision) = (settings.integrator, runner.precision());
            let (step, substeps) = (settings.step, counted(settings.substeps.into(), "substep"));
            let time = runner.time();
            format!(
                "<msd.Simulation {title}: t = {time:.6} s, {method}, {substeps} of a step of \
                 {step:.6} s, {precision}>"
            )
        })
    }
}
