//! Runs whose bits are kept, and a check of them that takes a little time now and then.
//!
//! Every built-in scene unchanged, and some small ones under every method in both precisions. The
//! tests of this crate compute them here; a page of a browser does so there.

use crate::runner::Runner;
use msd_core::glam::DVec3;
use msd_core::{Error, Friction, Integrator, Pin, Scene};
use msd_scene::{AnyState, BUILTINS, FileError, Loaded, Precision, open, state_hash};

/// Steps of each run: ten seconds.
pub const KEPT_STEPS: u64 = 600;

/// A line for each run: scene, method, precision, and the hash of its last state.
pub const KEPT_HASHES: &str = include_str!("../tests/hashes.txt");

/// The scenes that run under every method; the program in `bare/` carries them.
pub const SMALL: [&str; 3] = ["chain", "square", "rough"];

/// A run whose bits are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeptRun {
    /// The name of its scene.
    pub scene: &'static str,
    /// The method and the precision, where they are not the scene's own.
    pub solver: Option<(Integrator, Precision)>,
}

impl KeptRun {
    /// The built-in scenes, in the order of the list.
    pub fn builtins() -> Vec<KeptRun> {
        BUILTINS.iter().map(|builtin| KeptRun { scene: builtin.name, solver: None }).collect()
    }

    /// The small scenes under every method in both precisions.
    pub fn small() -> Vec<KeptRun> {
        let mut runs = Vec::new();
        for scene in SMALL {
            for integrator in Integrator::ALL {
                for precision in [Precision::F32, Precision::F64] {
                    runs.push(KeptRun { scene, solver: Some((integrator, precision)) });
                }
            }
        }
        runs
    }

    /// All of them, in the order of [`KEPT_HASHES`].
    pub fn all() -> Vec<KeptRun> {
        [KeptRun::builtins(), KeptRun::small()].concat()
    }

    /// The scene, with its solver.
    ///
    /// # Errors
    /// See [`msd_scene::open()`].
    pub fn load(&self) -> Result<Loaded, FileError> {
        let mut loaded = match self.scene {
            "rough" => rough(open("square")?),
            name => open(name)?,
        };
        if let Some((integrator, precision)) = self.solver {
            (loaded.settings.integrator, loaded.precision) = (integrator, precision);
        }
        Ok(loaded)
    }
}

/// The square with features that no small built-in scene has: Coulomb friction, drag, springs that
/// differ and a pin that moves.
fn rough(mut square: Loaded) -> Loaded {
    let Scene { world, springs, planes, pins, .. } = &mut square.scene;
    world.drag = 0.1;
    for (row, spring) in springs.iter_mut().enumerate() {
        spring.stiffness += 10.0 * row as f64;
        spring.damping += 0.1 * row as f64;
    }
    (planes[0].restitution, planes[0].friction) = (0.3, Friction::Coulomb(0.5));
    pins.push(Pin { particle: 0, velocity: DVec3::new(0.3, -0.6, 0.1) });
    Loaded { name: "rough".into(), ..square }
}

/// The line of [`KEPT_HASHES`] for a run that ended in a state.
pub fn kept_line(loaded: &Loaded, state: &AnyState) -> String {
    let Loaded { name, precision, settings, .. } = loaded;
    format!("{name} {} {precision} {:016x}", settings.integrator, state_hash(state))
}

/// A check of kept runs, all of them by default, in slices of time.
#[derive(Debug)]
pub struct Verification {
    runs: Vec<KeptRun>,
    now: Option<(Loaded, Runner)>,
    done: usize,
    wrong: Vec<String>,
}

impl Default for Verification {
    fn default() -> Self {
        Verification::of(KeptRun::all())
    }
}

impl Verification {
    /// A check of these runs.
    pub fn of(runs: Vec<KeptRun>) -> Self {
        Verification { runs, now: None, done: 0, wrong: Vec::new() }
    }

    /// Runs until `is_over`, which is asked after each step, or until all is done. To open a scene
    /// takes a slice of its own.
    pub fn go_on(&mut self, is_over: impl Fn() -> bool) {
        let Some(run) = self.runs.get(self.done) else { return };
        let Some((loaded, runner)) = &mut self.now else {
            match begin(*run) {
                Ok(now) => self.now = Some(now),
                Err(reason) => self.end(Some(format!("{}: {reason}", run.scene))),
            }
            return;
        };
        while runner.steps() < KEPT_STEPS {
            if let Err(error) = runner.step() {
                let reason = format!("{}: {error}", run.scene);
                return self.end(Some(reason));
            }
            if is_over() {
                return;
            }
        }
        let line = kept_line(loaded, &runner.state());
        let is_kept = KEPT_HASHES.lines().any(|kept| kept == line);
        self.end((!is_kept).then_some(line));
    }

    fn end(&mut self, wrong: Option<String>) {
        self.now = None;
        self.done += 1;
        self.wrong.extend(wrong);
    }

    /// Number of runs that are done, and number of all runs.
    pub fn progress(&self) -> (usize, usize) {
        (self.done, self.runs.len())
    }

    /// Whether all are done.
    pub fn is_done(&self) -> bool {
        self.done == self.runs.len()
    }

    /// The runs that ended otherwise than kept, a line for each.
    pub fn wrong(&self) -> &[String] {
        &self.wrong
    }
}

fn begin(run: KeptRun) -> Result<(Loaded, Runner), String> {
    let loaded = run.load().map_err(|error| error.to_string())?;
    let runner = Runner::open(&loaded).map_err(|error: Error| error.to_string())?;
    Ok((loaded, runner))
}
