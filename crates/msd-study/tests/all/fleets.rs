//! Cells of a sweep whose steps a device takes: the same files, whatever the device does.

use msd_core::{Error, Integrator, Ledger};
use msd_run::{Runner, on};
use msd_scene::{AnyState, Precision};
use msd_study::choice::{Choice, Fineness};
use msd_study::conduct::{INTERRUPTED, Plan, add_device, study};
use msd_study::device::{Device, LoadError, Pace};
use msd_study::monitor::{Halt, Monitor, Progress};
use msd_study::sweep::{Datum, Store, Summary, Sweep, run, run_on};
use msd_study::trial::{DeviceTime, time_on};
use msd_study::tune::{Goal, Tuner, tune_on};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A device that is the processor, but measures no more than a graphics card.
struct Mirror {
    /// Runs that it can hold, and steps after which it fails.
    most: usize,
    fails_after: u64,
    /// Whether it computes other bits.
    is_wrong: bool,
    /// The runs of each load that it could hold.
    loaded: Vec<usize>,
    ended: Vec<Option<Error>>,
    steps: u64,
}

impl Mirror {
    fn new() -> Self {
        let (loaded, ended) = (Vec::new(), Vec::new());
        let (most, fails_after, is_wrong) = (usize::MAX, u64::MAX, false);
        Mirror { most, fails_after, is_wrong, loaded, ended, steps: 0 }
    }
}

impl Device for Mirror {
    fn name(&self) -> String {
        "mirror".into()
    }

    fn takes(&self, runner: &Runner) -> bool {
        let is_known = Integrator::EXPLICIT.contains(&runner.integrator());
        is_known && matches!(runner, Runner::F32(..)) && !runner.is_automatic()
    }

    fn load(&mut self, runners: &[Runner]) -> Result<(), LoadError> {
        assert!(runners.iter().all(|runner| Pace::of(runner) == Pace::of(&runners[0])));
        if self.most < runners.len() {
            return Err(LoadError::TooLarge("it is too small".into()));
        }
        self.loaded.push(runners.len());
        self.ended = vec![None; runners.len()];
        Ok(())
    }

    fn advance(
        &mut self,
        runners: &mut [Runner],
        steps: u64,
    ) -> Result<Vec<Option<Error>>, String> {
        self.steps += steps;
        if self.fails_after < self.steps {
            return Err("it was lost".into());
        }
        for (runner, ended) in runners.iter_mut().zip(&mut self.ended) {
            if ended.is_none() {
                *ended = (0..steps).try_for_each(|_| runner.step()).err();
                if self.is_wrong {
                    let (mut state, steps) = (runner.state(), runner.steps());
                    let AnyState::F32(single) = &mut state else { unreachable!("not taken") };
                    single.positions[0].x += 1.0;
                    runner.set_state(&state, steps).expect("a good state");
                }
                on!(&mut *runner, simulation => simulation.set_ledger(Ledger::of(f64::NAN)));
            }
        }
        Ok(self.ended.clone())
    }

    fn finish(&mut self) -> Result<(), String> {
        Ok(())
    }
}

/// Columns that a device measures, as a line of a sweep file.
const COLUMNS: &str = "columns = ['integrator', 'precision', 'substeps', 'stable_substep', \
    'outcome', 'diverged_time', 'diverged_particle', 'duration', 'steps', 'rms_error', \
    'energy_error', 'samples', 'kinetic', 'elastic', 'gravitational', 'state_hash', 'note']\n";

/// Sixteen cells that a device takes, of two methods, numbers of substeps and steps, and sixteen in
/// double precision. Those of stiff springs diverge.
fn sweep(folder: &Path, columns: &str) -> Sweep {
    let text = format!(
        "version = 1\nscene = 'square'\nduration = 0.5\nerror = true\n{columns}[grid]\n\
         'solver.integrator' = ['symplectic-euler', 'rk4']\n'solver.substeps' = [1, 16]\n\
         'solver.step' = [0.016666666666666666, 0.008333333333333333]\n\
         'bodies[0].stiffness' = [50, 1e7]\n'solver.precision' = ['f32', 'f64']\n"
    );
    fs::write(folder.join("square.toml"), text).expect("a file");
    Sweep::open(&folder.join("square.toml")).expect("a sweep")
}

fn files(store: &Store) -> BTreeMap<String, String> {
    let entries = fs::read_dir(store.folder()).expect("a folder").flatten();
    let read = |entry: fs::DirEntry| {
        let text = fs::read_to_string(entry.path()).expect("a file");
        (entry.file_name().to_string_lossy().into_owned(), text)
    };
    entries.map(read).collect()
}

fn stores(sweep: &Sweep, folder: &TempDir) -> [Store; 2] {
    ["here", "there"].map(|name| Store::of(sweep, Some(folder.path().join(name))))
}

fn fly(sweep: &Sweep, store: &Store, device: &mut Mirror, jobs: usize) -> Summary {
    let cells = (0..sweep.len(), jobs, Some(device as &mut dyn Device));
    run_on(sweep, store, cells, &mut ()).expect("a run")
}

#[test]
fn files_of_a_device_are_those_of_the_processor_byte_by_byte() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = sweep(folder.path(), COLUMNS);
    assert!(sweep.columns_of_processor().is_empty());
    let [here, there] = stores(&sweep, &folder);
    let alone = run(&sweep, &here, (0..sweep.len(), 1), &mut ()).expect("a run");
    let mut mirror = Mirror::new();
    let together = fly(&sweep, &there, &mut mirror, 2);
    assert_eq!(Summary { on_device: 0, ..together.clone() }, alone);
    assert_eq!((together.run, together.on_device, together.fault), (32, 16, None));
    // Two values of the stiffness for each method, number of substeps and step.
    assert_eq!(mirror.loaded, [2; 8]);
    assert!(4 <= alone.diverged && alone.diverged <= 16, "{alone:?}");
    assert_eq!(files(&here), files(&there));
}

#[test]
fn a_device_that_is_too_small_or_fails_changes_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = sweep(folder.path(), COLUMNS);
    let [here, there] = stores(&sweep, &folder);
    run(&sweep, &here, (0..sweep.len(), 1), &mut ()).expect("a run");
    let mut small = Mirror { most: 1, ..Mirror::new() };
    assert_eq!(fly(&sweep, &there, &mut small, 1).on_device, 16);
    assert_eq!(small.loaded, [1; 16]);
    assert_eq!(files(&here), files(&there));
    for (most, fails_after, why) in [(0, u64::MAX, None), (9, 100, Some("it was lost"))] {
        fs::remove_dir_all(there.folder()).expect("a folder");
        let mut broken = Mirror { most, fails_after, ..Mirror::new() };
        let summary = fly(&sweep, &there, &mut broken, 2);
        assert_eq!((summary.run, summary.fault.as_deref()), (32, why));
        assert_eq!(summary.on_device == 0, most == 0, "{summary:?}");
        assert_eq!(files(&here), files(&there));
    }
}

#[test]
fn columns_that_a_device_does_not_measure_are_empty_in_its_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = sweep(folder.path(), "");
    let [store, _] = stores(&sweep, &folder);
    fly(&sweep, &store, &mut Mirror::new(), 1);
    let table = store.collect(&sweep).expect("a table").0;
    let names = sweep.columns_of_processor();
    assert_eq!(names.len(), 7);
    let place = |name: &str| table.place(name).expect(name);
    // A cell that diverges in its first step has no time of a second on the processor either.
    let finished = Datum::Text("finished".into());
    for row in table.rows.iter().filter(|row| row[place("outcome")] == finished) {
        let is_single = row[place("precision")] == Datum::Text("f32".into());
        for name in &names {
            assert_eq!(row[place(name)] == Datum::Nothing, is_single, "{name}: {row:?}");
        }
        assert!(row[place("elastic")].as_number().is_some());
    }
}

/// A user who cancels a sweep at its tenth step.
struct Hasty(usize);

impl Monitor for Hasty {
    fn report(&mut self, progress: Progress) {
        self.0 += usize::from(progress.now.contains("cells on mirror"));
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.0 < 10 { Ok(()) } else { Err(Halt::Cancelled) }
    }
}

#[test]
fn a_sweep_on_a_device_that_is_cancelled_goes_on_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = sweep(folder.path(), COLUMNS);
    let [here, there] = stores(&sweep, &folder);
    run(&sweep, &here, (0..sweep.len(), 1), &mut ()).expect("a run");
    let mut mirror = Mirror::new();
    let cells = (0..sweep.len(), 1, Some(&mut mirror as &mut dyn Device));
    let summary = run_on(&sweep, &there, cells, &mut Hasty(0)).expect("what is done");
    assert_eq!(summary.run + summary.left, 32);
    assert!(0 < summary.left, "{summary:?}");
    assert_eq!(fly(&sweep, &there, &mut Mirror::new(), 1).skipped, summary.run);
    assert_eq!(files(&here), files(&there));
}

#[test]
fn the_time_of_a_choice_on_a_device_is_known_unless_its_bits_differ() {
    let scene = msd_scene::open("chain").expect("a built-in scene").scene;
    let choice = |integrator, precision, substeps| {
        (&scene, Choice { integrator, fineness: Fineness::Substeps(substeps), precision })
    };
    let verlet = choice(Integrator::VelocityVerlet, Precision::F32, 8);
    let time = |mut mirror: Mirror, choice| time_on(&mut mirror, choice, 30, &mut ());
    let cost = time(Mirror::new(), verlet).expect("a scene that runs");
    assert!(matches!(cost, DeviceTime::Cost(cost) if 0.0 < cost && cost < 60.0), "{cost:?}");
    for untaken in [
        choice(Integrator::VelocityVerlet, Precision::F64, 8),
        choice(Integrator::BackwardEuler, Precision::F32, 8),
    ] {
        assert_eq!(time(Mirror::new(), untaken), Ok(DeviceTime::Untaken));
    }
    let wrong = time(Mirror { is_wrong: true, ..Mirror::new() }, verlet);
    let Ok(DeviceTime::Failed(why)) = wrong else { panic!("{wrong:?}") };
    assert!(why.starts_with("mirror computed other bits than the processor by "), "{why}");
    let lost = time(Mirror { fails_after: 3, ..Mirror::new() }, verlet);
    assert_eq!(lost, Ok(DeviceTime::Failed("it was lost".into())));
}

#[test]
fn a_search_for_a_device_chooses_among_what_it_steps_and_ends_where_it_fails() {
    let scene = msd_scene::open("chain").expect("a built-in scene").scene;
    let mut mirror = Mirror::new();
    let mut tuner = Tuner::new(&mut mirror);
    let goal = Goal::MaxError(1e-3);
    let tuned = tune_on((&scene, &mut tuner), 0.2, goal, &mut ()).expect("a scene that runs");
    assert!(tuned.met && tuner.fault.is_none());
    for found in tuned.others.iter().chain([&tuned.best]) {
        let Choice { integrator, precision, .. } = found.trial.choice;
        assert!(Integrator::EXPLICIT.contains(&integrator) && precision == Precision::F32);
        assert!(found.trial.cost.is_finite() && found.trial.error() <= 1e-3);
    }
    let mut broken = Mirror { fails_after: 0, ..Mirror::new() };
    let mut tuner = Tuner::new(&mut broken);
    let ended = tune_on((&scene, &mut tuner), 0.2, goal, &mut ());
    assert_eq!((ended, tuner.fault.as_deref()), (Err(Halt::Cancelled), Some("it was lost")));
}

#[test]
fn a_study_has_the_costs_of_a_device_and_says_where_it_failed() {
    let loaded = msd_scene::open("chain").expect("a built-in scene");
    let plan = Plan { duration: 0.1, budget: 2.0, ..Plan::default() };
    let mut studied = study(&loaded, plan, &mut ()).expect("a scene that runs").0;
    let trials = studied.trials.clone();
    add_device(&mut studied, &loaded.scene, &mut Mirror::new(), &mut ()).expect("a scene");
    assert_eq!(studied.trials, trials);
    let is_taken = |choice: Choice| {
        Integrator::EXPLICIT.contains(&choice.integrator) && choice.precision == Precision::F32
    };
    for trial in &trials {
        let is_timed = studied.cost_on_device(trial.choice).is_some();
        assert_eq!(is_timed, trial.errors.is_some() && is_taken(trial.choice));
    }
    let front = studied.front_on_device();
    assert!(!front.is_empty() && front.is_sorted_by(|a, b| a.1 <= b.1), "{front:?}");
    let errors = front.iter().map(|&(row, _)| trials[row].error());
    assert!(errors.is_sorted_by(|a, b| b <= a), "cheaper is less accurate");
    assert!(studied.words.contains(" On mirror the cheapest is "), "{}", studied.words);
    let mut broken = Mirror { fails_after: 0, ..Mirror::new() };
    add_device(&mut studied, &loaded.scene, &mut broken, &mut ()).expect("a scene");
    assert!(
        studied.words.contains("The timing on the device stopped early: it was lost."),
        "{}",
        studied.words
    );
    let mut hasty = Hasty(10);
    add_device(&mut studied, &loaded.scene, &mut Mirror::new(), &mut hasty).expect("a scene");
    let said = "No setting was timed on mirror. The timing on the device stopped early: \
        interrupted.";
    assert!(studied.words.contains(said), "{}", studied.words);
    assert_eq!(studied.on_device.expect("a device").fault.as_deref(), Some(INTERRUPTED));
}
