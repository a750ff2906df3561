//! A saved run goes on to the last bit, and a file that is not whole is refused.

use msd_core::glam::{DMat3, DVec3};
use msd_core::{Error, Guide, Integrator, Interaction, KeyFrame, Lead, Pin, Select};
use msd_run::{Runner, on};
use msd_scene::{
    FileError, Loaded, Output, Precision, SceneFormat, load_saved, open, parse, read_saved,
    state_hash, write_saved,
};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use std::path::Path;

/// Saves a run in a file.
fn save(runner: &Runner, path: &Path) {
    let output = Output::create(path).expect("a file");
    write_saved(&runner.to_loaded("test", "a test"), output).expect("room on the disk");
}

/// Saves a run in a file and reads it again.
fn there_and_back(runner: &Runner) -> Runner {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.msd");
    save(runner, &path);
    Runner::open(&load_saved(&path).expect("a saved run")).expect("a run that goes on")
}

fn bytes() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.msd");
    save(&handled(Integrator::VelocityVerlet, Precision::F32), &path);
    std::fs::read(&path).expect("the file")
}

fn act(runner: &mut Runner, interaction: Interaction) {
    runner.queue(interaction).expect("a valid interaction");
}

fn step(runner: &mut Runner, steps: usize) {
    (0..steps).for_each(|_| runner.step().expect("a step"));
}

/// A waffle between walls to which everything is done that a hand can do, halfway between two
/// steps: with a grab that holds, a pin that moves, springs cut, a push applied and another queued.
fn handled(integrator: Integrator, precision: Precision) -> Runner {
    let mut loaded = open("waffle").expect("a built-in scene");
    // Explicit Euler needs short steps to stay in the world for a second.
    (loaded.settings.substeps, loaded.settings.integrator) = (32, integrator);
    loaded.precision = precision;
    loaded.scene.pins.push(Pin { particle: 3, velocity: DVec3::new(0.1, 0.2, 0.0) });
    let place = loaded.scene.particles[4].position;
    let key = KeyFrame { time: 0.4, position: place + DVec3::X * 0.1, axes: DMat3::IDENTITY };
    let lead = Lead::Path { since: 0.0, position: place, velocity: DVec3::ZERO, keys: vec![key] };
    let held = vec![(4, DVec3::ZERO)];
    loaded.scene.guides.push(Guide { held, lead, until: Some(0.3) });
    let mut runner = Runner::open(&loaded).expect("a run");
    step(&mut runner, 7);
    let target = DVec3::new(0.5, 2.0, 0.1);
    let (frequency, damping_ratio, max_force) = (3.0, 0.7, 1e300);
    act(
        &mut runner,
        Interaction::Grab { particle: 9, target, frequency, damping_ratio, max_force },
    );
    act(&mut runner, Interaction::Cut { spring: 17 });
    act(&mut runner, Interaction::SetRestLength { springs: Select::Range(2, 5), value: 0.9 });
    act(&mut runner, Interaction::ScaleRestLength { springs: Select::One(8), factor: 1.1 });
    act(&mut runner, Interaction::SetStiffness { springs: Select::One(1), value: 321.0 });
    act(&mut runner, Interaction::SetMass { particles: Select::One(4), value: 0.3 });
    act(&mut runner, Interaction::SetGravity { value: DVec3::new(0.3, -7.0, 0.0) });
    act(&mut runner, Interaction::Pin { particle: 20, velocity: DVec3::new(0.0, 0.3, 0.0) });
    step(&mut runner, 8);
    act(&mut runner, Interaction::Push { particle: 30, force: DVec3::new(5.0, 0.0, 1.0) });
    runner.apply_queued().unwrap();
    act(&mut runner, Interaction::Push { particle: 31, force: DVec3::new(0.0, 2.0, 1.0) });
    act(&mut runner, Interaction::Cut { spring: 4 });
    runner
}

fn goes_on_as_if_never_stopped(mut whole: Runner) {
    let name = (whole.integrator(), whole.precision());
    let mut resumed = there_and_back(&whole);
    assert!(resumed.progress() == whole.progress(), "{name:?}");
    for _ in 0..20 {
        step(&mut whole, 1);
        step(&mut resumed, 1);
        assert_eq!(state_hash(&resumed.state()), state_hash(&whole.state()), "{name:?}");
    }
    // Not the state alone: the next save is the same file, the energy account included.
    assert!(resumed.progress() == whole.progress(), "{name:?}");
    assert_eq!(resumed.time(), whole.time());
    assert_eq!(resumed.energy(), whole.energy());
}

#[test]
fn n_steps_and_m_from_a_file_are_n_and_m_for_every_integrator_and_precision() {
    for integrator in Integrator::ALL {
        for precision in [Precision::F32, Precision::F64] {
            goes_on_as_if_never_stopped(handled(integrator, precision));
        }
    }
}

#[test]
fn an_undamped_run_goes_on_to_the_bit() {
    // Velocity Verlet remembers accelerations from step to step where nothing damps.
    let mut loaded = open("square").expect("a built-in scene");
    loaded.scene.springs.iter_mut().for_each(|spring| spring.damping = 0.0);
    let mut runner = Runner::open(&loaded).expect("a run");
    step(&mut runner, 5);
    goes_on_as_if_never_stopped(runner);
}

#[test]
fn a_run_whose_precision_and_step_were_changed_goes_on_to_the_bit() {
    let mut runner = handled(Integrator::VelocityVerlet, Precision::F32);
    step(&mut runner, 2);
    let mut settings = runner.settings();
    (settings.step, settings.substeps) = (0.01, 20);
    runner.set_settings(settings).expect("valid settings");
    step(&mut runner, 3);
    let mut runner = runner.convert(Precision::F64).expect("another precision");
    step(&mut runner, 3);
    let runner = runner.convert(Precision::F32).expect("another precision");
    // Steps of two lengths: the time is not a multiple of either.
    let time = 17.0 / 60.0 + 6.0 * 0.01;
    assert!((runner.time() - time).abs() < 1e-12);
    goes_on_as_if_never_stopped(runner);
}

#[test]
fn a_saved_run_is_a_scene_that_another_solver_may_take() {
    let runner = handled(Integrator::VelocityVerlet, Precision::F32);
    let mut loaded = runner.to_loaded("test", "a test");
    loaded.precision = Precision::F64;
    loaded.settings.substeps = 64;
    let mut other = Runner::open(&loaded).expect("a run");
    let mut expected = runner.convert(Precision::F64).expect("another precision");
    expected.set_settings(loaded.settings).expect("valid settings");
    assert!(other.progress().0 == expected.progress().0);
    step(&mut other, 5);
    step(&mut expected, 5);
    assert_eq!(state_hash(&other.state()), state_hash(&expected.state()));
}

#[test]
fn a_title_of_two_lines_is_saved_as_one() {
    let text = "version = 1\ntitle = \"two\\nlines\"\n[[bodies]]\nkind = \"rope\"\nsize = [3]\n\
        spacing = 1\nmass = 1\nstiffness = 10\n";
    let loaded = parse(text, SceneFormat::Toml, "a\tscene.toml").expect("a scene");
    let runner = Runner::open(&loaded).expect("a run");
    let saved = runner.to_loaded(&loaded.name, &loaded.title);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.msd");
    write_saved(&saved, Output::create(&path).expect("a file")).expect("room on the disk");
    let again = load_saved(&path).expect("a saved run");
    assert_eq!((again.title.as_str(), again.name.as_str()), ("two lines", "a scene"));
}

#[test]
fn a_file_cut_short_anywhere_is_refused() {
    let bytes = bytes();
    for end in (0..bytes.len()).step_by(97).chain(bytes.len() - 40..bytes.len()) {
        let error = read_saved(&bytes[..end], "s.msd").expect_err("a refusal").to_string();
        let told = ["s.msd: is cut short", "s.msd: is not a saved run of msd"];
        assert!(told.contains(&&*error), "{end}: {error}");
    }
}

#[test]
fn a_file_with_a_bit_changed_is_refused() {
    let bytes = bytes();
    let first = bytes.iter().position(|&byte| byte == b'\n').expect("a first line") + 9;
    for at in (first..bytes.len()).step_by(83) {
        let mut changed = bytes.clone();
        changed[at] ^= 4;
        let error = read_saved(&changed, "s.msd").expect_err("a refusal").to_string();
        assert_eq!(error, "s.msd: is damaged: its checksum does not fit", "{at}");
    }
    let more = [&bytes[..], b"more"].concat();
    assert!(read_saved(&more, "s.msd").is_err());
}

#[test]
fn a_file_of_another_format_is_refused_by_name() {
    let bytes =
        String::from_utf8_lossy(&bytes()).replacen("format 17", "format 18", 1).into_bytes();
    let error = read_saved(&bytes, "s.msd").expect_err("a refusal");
    assert!(matches!(error, FileError::Format { found: 18, known: 17, .. }), "{error}");
    assert_eq!(error.to_string(), "s.msd: is a saved run of format 18; this msd reads format 17");
}

#[test]
fn a_file_of_another_kind_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.msd");
    // A hole of 4 GB: were it read into memory, this would take long.
    let file = std::fs::File::create(&path).expect("a file");
    file.set_len(4 << 30).expect("a sparse file");
    let error = open(path.to_str().expect("a path")).expect_err("a refusal").to_string();
    assert!(error.ends_with("s.msd: is not a saved run of msd"), "{error}");
    assert!(matches!(open("nothing.msd"), Err(FileError::Unreadable { .. })));
}

#[test]
fn what_a_file_from_elsewhere_tells_is_checked_row_by_row() {
    let fresh = || handled(Integrator::Rk4, Precision::F32).to_loaded("test", "");
    let refused = |change: &dyn Fn(&mut Loaded)| {
        let mut loaded = fresh();
        change(&mut loaded);
        Runner::open(&loaded).expect_err("a refusal").to_string()
    };
    let message = refused(&|loaded| loaded.scene.springs[3].ends = [0, 1 << 40]);
    assert!(message.contains("spring 3 names particle 1099511627776"), "{message}");
    let message = refused(&|loaded| loaded.scene.particles[5].velocity.x = f64::NAN);
    assert!(message.contains("velocity of particle 5 is NaN"), "{message}");
    let message = refused(&|loaded| loaded.scene.planes[0].normal *= 2.0);
    assert!(message.contains("square of the normal of plane 0 is 4"), "{message}");
    let held = |change: &dyn Fn(&mut msd_core::Progress)| {
        refused(&|loaded| change(loaded.progress.as_mut().expect("a saved run")))
    };
    let message = held(&|progress| progress.grabs[0].particle = 1 << 33);
    assert!(message.contains("grab 0 names particle 8589934592"), "{message}");
    let message = held(&|progress| progress.grabs[0].stiffness = -1.0);
    assert!(message.contains("stiffness of grab 0 is -1"), "{message}");
    let message = held(&|progress| progress.pushes[0].0 = 1 << 33);
    assert!(message.contains("push 0 names particle 8589934592"), "{message}");
    let message = held(&|progress| progress.queue.push(Interaction::Cut { spring: 1 << 33 }));
    assert!(message.contains("names spring 8589934592"), "{message}");
    let message = held(&|progress| progress.epoch.0 = progress.steps + 1);
    assert!(message.contains("start of the epoch of run 0 is 16"), "{message}");
    let message = held(&|progress| progress.steps = u64::MAX);
    assert!(message.contains("number of steps"), "{message}");
    let message = held(&|progress| progress.size = 0.0);
    assert!(message.contains("size of run 0 is 0"), "{message}");
    let message = held(&|progress| progress.settings.substeps = 0);
    assert!(message.contains("substeps"), "{message}");
    assert!(Runner::open(&fresh()).is_ok());
    assert!(matches!(
        Runner::resume(&Default::default(), &fresh().progress.expect("progress"), Precision::F32),
        Err(Error::Empty)
    ));
}

/// A saved run whose content was changed and whose checksum was made to fit again.
fn forged(bytes: &[u8], change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let content = bytes.iter().position(|&byte| byte == b'\n').expect("a first line") + 9;
    let hash = bytes.len() - 32;
    let mut forged = bytes.to_vec();
    change(&mut forged[content..hash]);
    let sum = blake3::hash(&forged[content..hash]);
    forged[hash..].copy_from_slice(sum.as_bytes());
    forged
}

#[test]
fn bytes_that_fit_their_checksum_and_make_no_sense_never_panic() {
    let bytes = bytes();
    assert_eq!(forged(&bytes, |_| {}), bytes);
    let mut lot = Pcg32::new(7, 7);
    let (mut refused, mut ran) = (0, 0);
    for _ in 0..3000 {
        let (at, value) = (lot.next_u32() as usize, lot.next_u32() as u8);
        // Half of them near the end, where the progress is.
        let near_end = lot.next_u32().is_multiple_of(2);
        let forged = forged(&bytes, |content| {
            let count = content.len();
            let at = if near_end { count - 1 - at % 400 } else { at % count };
            content[at] = value;
        });
        let runner = read_saved(&forged, "s").map(|loaded| Runner::open(&loaded));
        let Ok(Ok(mut runner)) = runner else {
            refused += 1;
            continue;
        };
        // A changed number of substeps may take hours.
        if runner.settings().substeps < 100 && !runner.integrator().is_adaptive() {
            ran += usize::from(runner.step().is_ok());
        }
    }
    assert!(100 < refused && 100 < ran, "{refused} {ran}");
}

#[test]
fn springs_are_alike_after_a_cut_as_after_a_file() {
    // Of three stiffnesses the only other one is cut: one value is left for all.
    let mut runner = Runner::open(&open("square4").expect("a built-in scene")).expect("a run");
    act(&mut runner, Interaction::SetStiffness { springs: Select::One(2), value: 77.0 });
    act(&mut runner, Interaction::SetDamping { springs: Select::All, value: 0.0 });
    act(&mut runner, Interaction::Cut { spring: 2 });
    runner.apply_queued().unwrap();
    let same = |runner: &Runner| {
        on!(runner, simulation => {
            let model = simulation.model();
            let there = (0..model.ends().len()).filter(|&spring| !model.is_cut(spring));
            let mut stiffnesses = there.map(|spring| model.stiffness(spring));
            let first = stiffnesses.next().expect("springs are left");
            !model.is_damped() && stiffnesses.all(|stiffness| stiffness == first)
        })
    };
    assert!(same(&runner) && same(&there_and_back(&runner)));
}

#[test]
fn a_run_in_gusts_is_that_of_its_scene_and_goes_on_from_a_saved_one() {
    let text = "version = 1\n[world]\nforce = [0.01, 0.02, 0.03]\nwind = { strength = 0.2, \
                heading_deg = 30, gusts = 0.75 }\n[solver]\nprecision = 'f64'\n[[bodies]]\n\
                kind = 'cloth'\nsize = [5, 5]\nmass = 0.02\n[[pins]]\nset = 'top'\n";
    let loaded = parse(text, SceneFormat::Toml, "windy").expect("a scene");
    assert_eq!(loaded.wind().gusts, 0.75);
    let mut runner = Runner::open(&loaded).expect("a valid scene");
    let mut steady = runner.clone();
    steady.calm();
    step(&mut runner, 20);
    step(&mut steady, 20);
    assert_ne!(state_hash(&runner.state()), state_hash(&steady.state()));
    let mut again = there_and_back(&runner);
    step(&mut runner, 20);
    step(&mut again, 20);
    assert_eq!(state_hash(&again.state()), state_hash(&runner.state()));
}
