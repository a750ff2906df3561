//! From a scene to a run: opened, given the solver of the command line and a state.

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

/// A frame of the command line, seconds: `--substeps` divides it, and so does `--step auto` of the
/// window.
pub const FRAME: f64 = 1.0 / 60.0;

/// The most integration steps of a run: weeks on any machine.
const MAX_STEPS: f64 = 1e10;

/// A run that is about to start.
pub struct Prepared {
    /// The name of the scene.
    pub name: String,
    /// One line on what is seen.
    pub title: String,
    /// What was done to its input.
    pub notes: Vec<String>,
    /// The files that it was read from.
    pub files: Vec<PathBuf>,
    /// What its bodies are made of.
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "the window alone shows it"))]
    pub made: Vec<Option<Made>>,
    /// The particles of sets that rows of pins name.
    pub held: Vec<(String, Vec<usize>)>,
    /// From where its author wants it looked at.
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "the window alone shows it"))]
    pub camera: Viewpoint,
    /// Whether it is a saved run that goes on.
    pub is_resumed: bool,
    /// The run.
    pub runner: Runner,
    /// Its start.
    pub start: Moment,
    /// The longest stable substep predicted at its start, seconds.
    pub stable: f64,
    /// The watch over it, and what it found at the start, which the warnings have.
    pub watch: Watch,
    pub early: Vec<Finding>,
    /// Steps to take.
    pub steps: u64,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
}

impl Prepared {
    /// Whether the user was warned of the step, with what to do about it.
    pub fn is_advised(&self) -> bool {
        self.early.iter().any(|finding| matches!(finding.kind, Kind::StabilityLimit { .. }))
    }

    /// What the watch found since the start, with `advice` on the step where there is any; it is
    /// printed, and among the warnings from now on.
    pub fn warn(&mut self, advice: Option<&str>) {
        let found = self.watch.findings(&self.runner).into_iter();
        let late = found.filter(|late| self.early.iter().all(|early| !early.is_same(late)));
        let late: Vec<String> = late
            .map(|finding| match finding.kind {
                Kind::StabilityLimit { .. } => finding.sentence() + &appended(advice),
                _ => finding.to_string(),
            })
            .collect();
        late.iter().for_each(|warning| note(&format!("warning: {warning}")));
        self.warnings.extend(late);
    }
}

/// The link that a scene is named by, if it is.
pub fn link(scene: &Path) -> Result<Option<Link>, Failure> {
    let text = scene.to_str().filter(|text| Link::is_meant(text));
    text.map(Link::parse).transpose().map_err(Failure::input)
}

/// Opens a scene, or what a link makes of it, to be studied.
pub fn open_scene(scene: &Path, set: &[Assignment]) -> Result<Loaded, Failure> {
    match link(scene)? {
        Some(_) if !set.is_empty() => Err(no_keys()),
        Some(link) => link.open().map_err(Failure::input),
        None => open_set(scene, set).map_err(Failure::input),
    }
}

/// The failure of values that are set in a link.
fn no_keys() -> Failure {
    Failure::input("--set takes a scene by name or file, not by link")
}

/// Opens a scene as its author wrote it, at whatever spacing it is to be run.
pub fn open_draft(scene: &Path, set: &[Assignment]) -> Result<Draft, Failure> {
    if link(scene)?.is_some() {
        return Err(Failure::input("--mesh takes a scene by name or file, not by link"));
    }
    let mut draft = Draft::open(scene, Path::new("")).map_err(Failure::input)?;
    draft.set(set);
    Ok(draft)
}

/// Opens a scene and makes it ready to run for some seconds; prints warnings.
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
        // Automatic substeps are those of the state that it starts from.
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
        // More digits than elsewhere, as it may be nearly a multiple.
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

/// A line on solids and pins that move: a state holds no time, so their motion starts anew.
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
        "{} holds no time: {moving} anew; `--save RUN.msd` keeps a run that goes on where it was",
        shown_path(state),
    ))
}

/// Opens a scene, or what a link makes of it, with the solver of the command line.
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
        // The file is right in its own precision.
        let asked = solver.precision.map(|precision| format!(" in {precision}"));
        Failure::input(format!("{}: {error}{}", loaded.name, asked.unwrap_or_default()))
    })?;
    if let Some(link) = &link {
        link.edit(&loaded, &mut runner).map_err(Failure::input)?;
    }
    Ok((loaded, runner))
}

/// The longest stable substep, seconds; of a million particles that takes a while.
fn predict(runner: &Runner) -> f64 {
    let count = runner.particle_count();
    let _notice =
        SlowNotice::new(format!("predicting the longest stable step of {count} particles"));
    runner.stable_substep()
}

/// The longest automatic substep, seconds, which takes as long to find.
fn longest_automatic(runner: &Runner) -> f64 {
    let count = runner.particle_count();
    let _notice = SlowNotice::new(format!("choosing a step of {count} particles"));
    runner.longest_automatic_substep()
}

/// Whether so many integration steps would not be done in weeks.
pub fn is_endless(steps: f64) -> bool {
    MAX_STEPS < steps
}

/// The keys of the solver that the command line sets.
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
    // One that is chosen when the state is known has one substep too: it matters to Verlet.
    match step {
        Some(Step::Auto) => SolverRow { substeps: Some(OrAuto::Given(1)), ..row },
        _ => row.with_frame(),
    }
}

/// Sets the longest step that is no longer than automatic substeps would be and ends a run of
/// `duration` seconds on time; from then on it is divided where that is needed.
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
    // Not a rounding error longer: that would be two substeps.
    let steps = if longest < duration / steps { steps + 1.0 } else { steps };
    let step = if 0.0 < duration { duration / steps } else { longest };
    let settings = Settings { step, substeps: 1, ..runner.settings() };
    runner.set_settings(settings).map_err(Failure::input)?;
    runner.set_automatic(true).map_err(Failure::input)
}

/// The number of steps nearest to a duration, at least one unless it is 0; whether they miss it.
fn count_steps(settings: Settings, duration: f64) -> (u64, bool) {
    let exact = duration / settings.step;
    let steps = if 0.0 < duration { exact.round().max(1.0) } else { 0.0 };
    // Rounding of the quotient stays far below a millionth of a step.
    let short = 1e-6 < (exact - steps).abs();
    (steps as u64, short)
}

/// A watch over a run that is about to start, with what it finds at once, and these findings in
/// words: the step has options to use instead, which lasted for so many simulated seconds. `frame`
/// is the time that `--substeps` divides, and `stable` the longest stable substep, seconds.
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
