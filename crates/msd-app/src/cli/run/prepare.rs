//! Preparation of a run: the scene, with the solver and the state of the command line.

use super::advice::{advise, appended};
use crate::cli::arguments::{SetArguments, SolverArguments, Step, Substeps};
use crate::cli::failure::{Failure, note};
use crate::cli::steps::SlowNotice;
use msd_app::link::Link;
use msd_core::glam::DVec3;
use msd_core::{Scene, Settings, Solid};
use msd_run::rescue::LASTING;
use msd_run::{Finding, Kind, Moment, Runner, Watch, on};
use msd_scene::materials::Made;
use msd_scene::schema::{OrAuto, SolverRow};
use msd_scene::{
    Assignment, Draft, Loaded, Viewpoint, load_state, memory_of, open_set, plain, shown_path,
};
use msd_study::quantity::{number, quantity, rounded};
use std::path::{Path, PathBuf};

/// A frame of the command line, seconds: `--substeps` divides it, and so does `--step auto` in the
/// window.
pub const FRAME: f64 = 1.0 / 60.0;

/// Largest number of integration steps of a run: weeks on any machine.
const MAX_STEPS: f64 = 1e10;

/// A run before its start.
pub struct Prepared {
    /// The name of the scene.
    pub name: String,
    /// Description of the scene in one line.
    pub title: String,
    /// Notes on changes of the input.
    pub notes: Vec<String>,
    /// The source files.
    pub files: Vec<PathBuf>,
    /// Materials of the bodies.
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "the window alone shows it"))]
    pub made: Vec<Option<Made>>,
    /// Named sets of particles in rows of pins.
    pub held: Vec<(String, Vec<usize>)>,
    /// Viewpoint set by the author.
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "the window alone shows it"))]
    pub camera: Viewpoint,
    /// Whether it continues a saved run.
    pub is_resumed: bool,
    /// The run.
    pub runner: Runner,
    /// Initial state.
    pub start: Moment,
    /// Longest stable substep predicted for the initial state, seconds.
    pub stable: f64,
    /// The watch, and its findings at the start, which are among the warnings.
    pub watch: Watch,
    pub early: Vec<Finding>,
    /// Steps to take.
    pub steps: u64,
    /// Warnings for the user, one line each.
    pub warnings: Vec<String>,
}

impl Prepared {
    /// Prints a warning and keeps it.
    pub fn add_warning(&mut self, warning: String) {
        note(&format!("warning: {warning}"));
        self.warnings.push(warning);
    }

    /// Returns whether the user was warned about the step, with advice.
    pub fn is_advised(&self) -> bool {
        self.early.iter().any(|finding| matches!(finding.kind, Kind::StabilityLimit { .. }))
    }

    /// Prints the findings since the start, with `advice` on the step if there is any, and adds
    /// them to the warnings.
    pub fn warn(&mut self, advice: Option<&str>) {
        let found = self.watch.findings(&self.runner).into_iter();
        let late = found.filter(|late| self.early.iter().all(|early| !early.is_same(late)));
        let late: Vec<String> = late
            .map(|finding| match finding.kind {
                Kind::StabilityLimit { .. } => finding.sentence() + &appended(advice),
                _ => finding.to_string(),
            })
            .collect();
        late.into_iter().for_each(|warning| self.add_warning(warning));
    }
}

/// Returns the link in the place of a scene, if it is one.
pub fn link(scene: &Path) -> Result<Option<Link>, Failure> {
    let text = scene.to_str().filter(|text| Link::is_meant(text));
    text.map(Link::parse).transpose().map_err(Failure::input)
}

/// Opens a scene, or that of a link, for a study.
pub fn open_scene(scene: &Path, set: &[Assignment]) -> Result<Loaded, Failure> {
    match link(scene)? {
        Some(_) if !set.is_empty() => Err(no_keys()),
        Some(link) => link.open().map_err(Failure::input),
        None => open_set(scene, set).map_err(Failure::input),
    }
}

/// Returns the failure of `--set` with a link.
fn no_keys() -> Failure {
    Failure::input("--set takes a scene by name or file, not by link")
}

/// Opens a scene as its author wrote it, for a run at any spacing.
pub fn open_draft(scene: &Path, set: &[Assignment]) -> Result<Draft, Failure> {
    if link(scene)?.is_some() {
        return Err(Failure::input("--mesh takes a scene by name or file, not by link"));
    }
    let mut draft = Draft::open(scene, Path::new("")).map_err(Failure::input)?;
    draft.set(set);
    Ok(draft)
}

/// Opens a scene, prepares a run of some seconds, and prints warnings.
pub fn prepare(
    (scene, set): (&Path, &SetArguments),
    solver: &SolverArguments,
    (flag, duration): (&str, f64),
) -> Result<Prepared, Failure> {
    let (mut loaded, mut runner) = open(scene, &set.set, solver)?;
    if let Some(path) = &solver.from {
        let count = runner.particle_count();
        let state = load_state(path, runner.precision(), count).map_err(Failure::input)?;
        let refused = |error| Failure::input(format!("{}: {error}", shown_path(path)));
        runner.set_state(&state, 0).map_err(refused)?;
        // Automatic substeps must be chosen for this state.
        let automatic = runner.is_automatic();
        runner.set_automatic(automatic).map_err(refused)?;
        loaded.notes.extend(begun_anew(&runner, &loaded.scene, path));
    }
    if solver.step == Some(Step::Auto) {
        choose_step(&mut runner, duration)?;
    }
    let settings = runner.settings();
    let (steps, short) = count_steps(settings, duration);
    if is_endless(steps as f64 * f64::from(settings.substeps)) {
        return Err(Failure::input(format!(
            "{flag} {} s would take more than {} steps of {}; shorten it or lengthen the step",
            plain(duration),
            number(MAX_STEPS),
            quantity(settings.substep(), "s")
        )));
    }
    let stable = predict(&runner);
    let lasting = duration.min(LASTING);
    let (watch, early, mut warnings) = watch_from((&runner, &loaded.scene), FRAME, stable, lasting);
    warnings.extend(short.then(|| {
        let time = steps as f64 * settings.step;
        let duration = plain(duration);
        // More digits than elsewhere, as the time may be close to a multiple.
        let time = rounded(time, 7);
        format!("{flag} {duration} s is not a multiple of the step; the run takes {time} s")
    }));
    warnings.iter().for_each(|warning| note(&format!("warning: {warning}")));
    let Loaded { name, title, notes, files, made, held, progress, camera, .. } = loaded;
    let (is_resumed, start) = (progress.is_some(), runner.moment());
    Ok(Prepared {
        name,
        title,
        notes,
        files,
        made,
        held,
        camera,
        is_resumed,
        runner,
        start,
        stable,
        watch,
        early,
        steps,
        warnings,
    })
}

/// Returns a note on moving solids and pins: a state has no time, so their motion restarts.
fn begun_anew(runner: &Runner, scene: &Scene, state: &Path) -> Option<String> {
    let still = DVec3::ZERO;
    let moves =
        |solid: &Solid| !solid.keys.is_empty() || solid.velocity != still || solid.spin != still;
    let solids = on!(runner, simulation => simulation.model().solids());
    let count = solids.iter().filter(|solid| moves(solid)).count();
    let pins = "pins with `key_frames`, `follow` or `until`";
    let moving = match (count, scene.guides.is_empty()) {
        (0, true) => return None,
        (0, false) => format!("{pins} begin"),
        (1, true) => "1 solid that moves begins".to_owned(),
        (_, true) => format!("{count} solids that move begin"),
        (1, false) => format!("1 solid that moves and {pins} begin"),
        (_, false) => format!("{count} solids that move and {pins} begin"),
    };
    Some(format!(
        "{} holds no time: {moving} anew; use `--save RUN.msd` to continue a run exactly",
        shown_path(state),
    ))
}

/// Opens a scene, or that of a link, with the solver of the command line.
fn open(
    scene: &Path,
    set: &[Assignment],
    solver: &SolverArguments,
) -> Result<(Loaded, Runner), Failure> {
    let notice = SlowNotice::new(format!("reading {}", shown_path(scene)));
    let link = link(scene)?;
    if link.is_some() && !set.is_empty() {
        return Err(no_keys());
    }
    let opened = link.as_ref().map_or_else(|| open_set(scene, set), Link::load);
    let loaded = opened.map_err(Failure::input)?;
    drop(notice);
    let row = row(solver);
    let chosen = loaded.solver().with(&row);
    row.check_read(chosen.settings.integrator, "--").map_err(Failure::input)?;
    let count = loaded.scene.particles.len();
    let gigabytes = rounded(1e-9 * memory_of(&loaded.scene), 2);
    let notice = SlowNotice::new(format!("preparing {count} particles, about {gigabytes} GB"));
    let runner = Runner::open_with(&loaded, chosen);
    drop(notice);
    let mut runner = runner.map_err(|error| {
        // The file is valid in its own precision.
        let asked = solver.precision.map(|precision| format!(" in {precision}"));
        Failure::input(format!("{}: {error}{}", loaded.name, asked.unwrap_or_default()))
    })?;
    if let Some(link) = &link {
        link.edit(&loaded, &mut runner).map_err(Failure::input)?;
    }
    Ok((loaded, runner))
}

/// Returns the longest stable substep, seconds; slow for a million particles.
fn predict(runner: &Runner) -> f64 {
    let count = runner.particle_count();
    let _notice =
        SlowNotice::new(format!("predicting the longest stable step of {count} particles"));
    runner.stable_substep()
}

/// Returns the longest automatic substep, seconds; equally slow.
fn longest_automatic(runner: &Runner) -> f64 {
    let count = runner.particle_count();
    let _notice = SlowNotice::new(format!("choosing a step of {count} particles"));
    runner.longest_automatic_substep()
}

/// Returns whether this number of integration steps would take weeks.
pub fn is_endless(steps: f64) -> bool {
    MAX_STEPS < steps
}

/// Returns the keys of the solver that the command line sets.
pub fn row(solver: &SolverArguments) -> SolverRow {
    let SolverArguments { integrator, step, substeps, tolerance, newton, precision, .. } = *solver;
    let newton = newton.map(u64::from);
    let row = SolverRow {
        integrator,
        step: match step {
            Some(Step::Seconds(step)) => OrAuto::Given(step),
            Some(Step::Auto) | None => OrAuto::Auto,
        },
        substeps: substeps.map(|substeps| match substeps {
            Substeps::Auto => OrAuto::Auto,
            Substeps::Count(count) => OrAuto::Given(count.into()),
        }),
        tolerance,
        newton,
        precision,
        ..SolverRow::default()
    };
    // Also before the length of an automatic step is known: the limit of Verlet depends on
    // substeps.
    match step {
        Some(Step::Auto) => SolverRow { substeps: Some(OrAuto::Given(1)), ..row },
        _ => row.with_frame(),
    }
}

/// Sets the longest step that does not exceed an automatic substep and divides `duration` seconds.
/// From then on, automatic substeps divide it where needed.
fn choose_step(runner: &mut Runner, duration: f64) -> Result<(), Failure> {
    let (integrator, longest) = (runner.integrator(), longest_automatic(runner));
    if longest == 0.0 {
        let message =
            format!("--step auto: {integrator} is predicted to be unstable here at any step");
        return Err(Failure::input(message));
    }
    if longest == f64::INFINITY {
        return Err(Failure::input(format!(
            "--step auto: {integrator} is stable here at any step; give its length in seconds, or \
             let msd tune find one"
        )));
    }
    let steps = (duration / longest).ceil().max(1.0);
    // A rounding error above the limit would double the substeps.
    let steps = if longest < duration / steps { steps + 1.0 } else { steps };
    let step = if 0.0 < duration { duration / steps } else { longest };
    let settings = Settings { step, substeps: 1, ..runner.settings() };
    runner.set_settings(settings).map_err(Failure::input)?;
    runner.set_automatic(true).map_err(Failure::input)
}

/// Returns the steps nearest to a duration, at least one unless it is 0, and whether they miss it.
fn count_steps(settings: Settings, duration: f64) -> (u64, bool) {
    let exact = duration / settings.step;
    let steps = if 0.0 < duration { exact.round().max(1.0) } else { 0.0 };
    // Rounding of the quotient stays far below a millionth of a step.
    let short = 1e-6 < (exact - steps).abs();
    (steps as u64, short)
}

/// Creates the watch over a new run, with its first findings and their words. The advice on the
/// step has options that lasted for `lasting` simulated seconds. `frame` is the time that
/// `--substeps` divides, and `stable` the longest stable substep, seconds.
pub fn watch_from(
    (start, scene): (&Runner, &Scene),
    frame: f64,
    stable: f64,
    lasting: f64,
) -> (Watch, Vec<Finding>, Vec<String>) {
    let mut watch = Watch::new(start, scene);
    watch.note_limit(start, stable);
    let early = watch.findings(start);
    let in_words = |finding: &Finding| match finding.kind {
        Kind::StabilityLimit { .. } => {
            format!("{}; {}", finding.sentence(), advise(start, frame, stable, lasting))
        }
        _ => finding.to_string(),
    };
    let warnings = early.iter().map(in_words).collect();
    (watch, early, warnings)
}
