//! Automatic substeps: their choice, their renewal, and that a run keeps its bits.

use msd_core::glam::DVec3;
use msd_core::stability::Estimator;
use msd_core::{Integrator, Interaction, Particle, Select, Settings, Simulation, Vector};
use msd_run::{History, Runner, on, steps_between};
use msd_scene::schema::Solver;
use msd_scene::{
    BUILTINS, Loaded, Output, Precision, SceneFormat, load_saved, open, parse, state_hash,
    write_saved,
};

fn automatic(name: &str) -> Loaded {
    Loaded { automatic: true, ..open(name).expect("a built-in scene") }
}

/// The square without diagonals, so stiff that it takes more than a hundred substeps: as it
/// collapses its springs come to lie along one line, and the limit falls by 30 %.
fn stiff() -> Loaded {
    let mut loaded = automatic("square4");
    for spring in &mut loaded.scene.springs {
        (spring.stiffness, spring.damping) = (2e7, 2.0);
    }
    loaded
}

/// A cube of foam at a sticky wall: squashed there, its dampers lie closer to one line, and the
/// limit falls by a quarter.
fn squashed() -> Loaded {
    automatic("foam")
}

/// Steps from one renewal of it to the next.
fn every(run: &Runner) -> usize {
    let predicted_at = on!(run, simulation => steps_between(simulation, 0.05));
    usize::try_from(predicted_at).expect("a few hundred")
}

fn runner(loaded: &Loaded) -> Runner {
    Runner::open(loaded).expect("a valid scene")
}

fn substeps(runner: &Runner) -> u32 {
    runner.settings().substeps
}

/// Hash of the state, and the substeps.
fn now(runner: &Runner) -> (u64, u32) {
    (state_hash(&runner.state()), substeps(runner))
}

fn step(runner: &mut Runner, steps: usize) {
    (0..steps).for_each(|_| runner.step().expect("a step"));
}

fn there_and_back(runner: &Runner) -> Runner {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.msd");
    let output = Output::create(&path).expect("a file");
    write_saved(&runner.to_loaded("test", "a test"), output).expect("room on the disk");
    Runner::open(&load_saved(&path).expect("a saved run")).expect("a run that goes on")
}

#[test]
fn nine_tenths_of_the_limit_are_taken_and_seven_where_dampers_set_it() {
    for (name, aim) in [("cube", 0.9), ("dice", 0.9), ("foam", 0.7), ("waffle", 0.7)] {
        let run = runner(&automatic(name));
        let stable = runner(&open(name).expect("a built-in scene")).stable_substep();
        let h = run.settings().substep();
        // The limit depends a little on the number of substeps.
        assert!(h <= 1.01 * aim * stable, "{name}: {h} s of {stable} s");
        let fewer = run.settings().step / f64::from(substeps(&run) - 1);
        assert!(0.99 * aim * stable < fewer, "{name}: one less would do");
    }
}

#[test]
fn what_may_fold_takes_what_is_stable_in_any_shape() {
    let run = runner(&stiff());
    let guaranteed = on!(&run, simulation => simulation.guaranteed_substep(run.integrator()));
    assert!(run.settings().substep() <= guaranteed);
    assert!(guaranteed < run.settings().step / f64::from(substeps(&run) - 1));
}

/// Scenes that take long; of those in which things touch, `drape` and `pile` are enough.
const LONG: [&str; 8] =
    ["snake", "trampoline", "twist", "funnel", "knot", "curtain", "gripper", "stairs"];

#[test]
fn the_built_in_scenes_stay_in_the_world() {
    for builtin in BUILTINS.iter().filter(|builtin| !LONG.contains(&builtin.name)) {
        let mut run = runner(&automatic(builtin.name));
        let stayed = (0..600).try_for_each(|_| run.step());
        assert!(stayed.is_ok(), "{}: {stayed:?}", builtin.name);
    }
}

#[test]
fn a_limit_that_falls_is_followed() {
    let mut run = runner(&squashed());
    let at_first = substeps(&run);
    step(&mut run, 800);
    assert!(at_first < substeps(&run), "{at_first}, then {}", substeps(&run));
    assert!(run.settings().substep() <= 0.9 * run.stable_substep());
}

/// A block without contraction across, dropped on a corner from half a metre: it is pressed flat
/// there, and stiffer than any prediction before.
const PRESSED: &str = "version = 1
[[world.planes]]
friction = 0.3
[[bodies]]
kind = 'block'
size = [7, 7, 6]
spacing = 0.02
young = 131642.55903116576
poisson = 0
density = 1000
relaxation_time = 2e-5
rotation = { axis = [0.243, 0.2834, 0.3833], angle_deg = 166.286 }
position = [0, 0.4857121781304672, 0]
";

#[test]
fn a_step_in_which_energy_appears_is_taken_again_with_more_substeps() {
    let loaded = parse(PRESSED, SceneFormat::Toml, "pressed.toml").expect("a valid scene");
    let mut run = runner(&loaded);
    let whole = |run: &Runner| run.energy().total();
    step(&mut run, 1);
    let (few, before) = (substeps(&run), whole(&run));
    step(&mut run, 119);
    assert!(few < substeps(&run), "{few} substeps as before");
    // A step may add a tenth of the kinetic energy.
    let off = whole(&run) - before;
    assert!(off.abs() < 0.5 * before, "{off} of {before} J");
    // At as few it blew up.
    let mut fixed = runner(&Loaded { automatic: false, ..loaded });
    fixed.set_settings(Settings { substeps: few, ..fixed.settings() }).expect("settings");
    assert!((0..120).any(|_| fixed.step().is_err()) || 2.0 * before < whole(&fixed));
}

#[test]
fn what_contact_takes_within_a_step_hides_no_energy_that_appears_in_it() {
    // The springs of a block that is pressed together gained up to ten times its energy. It slowed
    // down meanwhile and the floor took most of that.
    for (young, poisson) in [(9e4, 0.05), (4e5, 0.0), (4e5, 0.15), (4e5, 0.4)] {
        let text = format!(
            "version = 1\n[[world.planes]]\nfriction = 0.3\n[[bodies]]\nkind = 'block'\n\
             size = [6, 5, 4]\nspacing = 0.05\ndensity = 1100\nrelaxation_time = 5e-4\n\
             young = {young}\npoisson = {poisson}\nposition = [0, 0.6, 0]\n\
             rotation = {{ axis = [1, 0.2, 0.4], angle_deg = 33 }}\n"
        );
        let mut run = runner(&parse(&text, SceneFormat::Toml, "drop.toml").expect("a valid scene"));
        let before = run.energy().total();
        step(&mut run, 120);
        let off = run.energy().total() - before;
        assert!(off.abs() < 0.5 * before, "{off} of {before} J at {young} Pa and {poisson}");
    }
}

#[test]
fn a_step_that_ends_in_an_energy_without_bound_is_not_taken() {
    // Cells that resist a change of volume fly apart within two substeps that are too long. The
    // floor then books as given the energy that single precision cannot hold, which hid the gain.
    for (size, speed, axis, angle, substep) in [
        ([3, 5, 3], 3.8895, [0.04, -1.36, 0.03], 70.0, 1.0 / 480.0),
        ([3, 4, 4], 2.897, [0.04, 1.19, 0.71], 64.0, 1.0 / 360.0),
        ([5, 3, 3], 2.7301, [0.53, -0.41, 0.28], 137.0, 1.0 / 360.0),
    ] {
        let text = format!(
            "version = 1\n[[world.planes]]\nfriction = 0.1\n[[bodies]]\nkind = 'block'\n\
             size = {size:?}\nspacing = 0.0125\nmaterial = 'gelatine-3%'\npoisson = 0.45\n\
             position = [0, 0.06, 0]\nvelocity = [0, -{speed}, 0]\n\
             rotation = {{ axis = {axis:?}, angle_deg = {angle} }}\n"
        );
        let loaded = parse(&text, SceneFormat::Toml, "thrown.toml").expect("a valid scene");
        // One step that ends at each of these substeps.
        for substeps in 1..130 {
            let step = f64::from(substeps) * substep;
            let settings = Settings { step, substeps, ..loaded.settings };
            let mut run = Simulation::<f32>::new(&loaded.scene, settings).expect("a valid scene");
            let start = run.energy().mechanical();
            if run.step_unless_passing().is_ok_and(|is_taken| is_taken) {
                let total = run.energy().total();
                assert!(total.abs() < 2.0 * start, "{size:?}: {total} J after {substeps}");
            }
        }
    }
}

#[test]
fn a_run_saved_anywhere_goes_on_with_the_same_bits_and_substeps() {
    let whole = |steps: usize| {
        let mut run = runner(&squashed());
        step(&mut run, steps);
        run
    };
    let (end, every) = (now(&whole(800)), every(&whole(0)));
    assert!((100..700).contains(&every), "{every}");
    // Before, at and behind a renewal, and far from it.
    for at in [0, 1, every - 1, every, every + 1, 700] {
        let mut resumed = there_and_back(&whole(at));
        assert!(resumed.is_automatic());
        step(&mut resumed, 800 - at);
        assert_eq!(now(&resumed), end, "saved after {at} steps");
    }
}

#[test]
fn what_is_queued_when_a_run_is_saved_moves_the_limit_as_it_would_have() {
    let mut whole = runner(&automatic("cube"));
    step(&mut whole, 3);
    let stiffer = Interaction::SetStiffness { springs: Select::All, value: 1e5 };
    whole.queue(stiffer).expect("a valid interaction");
    let before = substeps(&whole);
    let mut resumed = there_and_back(&whole);
    for run in [&mut whole, &mut resumed] {
        step(run, 5);
    }
    assert_eq!(now(&whole), now(&resumed));
    // The limit goes with the root of the stiffness.
    let ratio = f64::from(substeps(&whole)) / f64::from(before);
    assert!((3.0..5.0).contains(&ratio), "{before}, then {}", substeps(&whole));
}

#[test]
fn a_return_restores_the_substeps_of_then() {
    let (mut run, mut history) = (runner(&squashed()), History::default());
    let mut seen = Vec::new();
    for _ in 0..800 {
        history.push(run.moment());
        seen.push(now(&run));
        step(&mut run, 1);
    }
    let end = now(&run);
    assert_ne!(seen[201].1, end.1);
    for back in [1, 300, 799 - every(&runner(&squashed())), 599] {
        run.go_back(history.nth_back(back).expect("so many states")).expect("a state");
        assert_eq!(now(&run), seen[800 - back]);
        step(&mut run, back);
        assert_eq!(now(&run), end, "{back} steps back");
    }
}

#[test]
fn a_choice_that_waits_still_does_after_a_return() {
    let loaded = automatic("cube");
    let mut run = Runner::open_lazily(&loaded, loaded.solver()).expect("a valid scene");
    let moment = run.moment();
    run.go_back(&moment).expect("a state");
    assert!(run.is_open());
}

#[test]
fn a_hand_and_a_pin_that_moves_choose_nothing() {
    let mut run = runner(&automatic("cloth"));
    let before = substeps(&run);
    let grab = Interaction::Grab {
        particle: 3,
        target: DVec3::Y,
        frequency: 50.0,
        damping_ratio: 0.7,
        max_force: 1e3,
    };
    let top = run.particle_count() - 31;
    let pin = Interaction::Pin { particle: top, velocity: DVec3::Y };
    for interaction in [grab, pin] {
        run.queue(interaction).expect("a valid interaction");
        run.apply_queued().expect("it is applied");
        assert_eq!(substeps(&run), before);
    }
}

#[test]
fn a_method_without_a_limit_keeps_its_number() {
    for method in [Integrator::BackwardEuler, Integrator::Xpbd, Integrator::DormandPrince] {
        let mut loaded = automatic("square");
        loaded.settings.integrator = method;
        assert_eq!(substeps(&runner(&loaded)), loaded.settings.substeps, "{method}");
    }
    // Nor is any step of explicit Euler stable without damping.
    let mut loaded = automatic("square");
    loaded.settings.integrator = Integrator::ExplicitEuler;
    loaded.scene.springs.iter_mut().for_each(|spring| spring.damping = 0.0);
    assert_eq!(substeps(&runner(&loaded)), loaded.settings.substeps);
}

#[test]
fn fixed_substeps_stay_and_settings_choose_anew() {
    let mut run = runner(&automatic("cube"));
    let few = substeps(&run);
    let settings = run.settings();
    run.set_settings(Settings { step: 2.0 * settings.step, ..settings }).expect("valid settings");
    assert!((2 * few - 1..=2 * few).contains(&substeps(&run)));
    run.set_automatic(false).expect("fixed from now on");
    run.set_settings(Settings { substeps: 77, ..settings }).expect("valid settings");
    let stiffer = Interaction::SetStiffness { springs: Select::All, value: 1e4 };
    run.queue(stiffer).expect("a valid interaction");
    step(&mut run, 2);
    assert_eq!(substeps(&run), 77);
    assert_eq!(run.convert(Precision::F64).map(|run| run.is_automatic()), Ok(false));
}

/// A run that chooses substeps in pieces, a few of them a frame; steps begin when none is left.
struct Lazy {
    run: Runner,
    estimator: Estimator,
    most: usize,
}

impl Lazy {
    fn step(&mut self) {
        let mut pieces = 0;
        while self.run.prepare(&mut self.estimator).expect("valid settings") {
            pieces += 1;
        }
        self.most = self.most.max(pieces);
        step(&mut self.run, 1);
    }
}

#[test]
fn what_is_chosen_in_pieces_is_what_is_chosen_at_once() {
    let (stiffer, held) = (
        Interaction::SetStiffness { springs: Select::All, value: 1e5 },
        Interaction::Pin { particle: 3, velocity: DVec3::ZERO },
    );
    for loaded in [squashed(), automatic("cube"), automatic("cloth")] {
        let Loaded { settings, .. } = loaded;
        let mut eager = runner(&loaded);
        let solver = Solver { automatic: true, ..loaded.solver() };
        let run = Runner::open_lazily(&loaded, solver).expect("a valid scene");
        assert!(run.is_open() && !eager.is_open());
        assert_eq!(substeps(&run), settings.substeps, "nothing is chosen yet");
        let mut lazy = Lazy { run, estimator: Estimator::default(), most: 0 };
        for at in 0..700 {
            for run in [&mut eager, &mut lazy.run] {
                match at {
                    5 => run.queue(held).and_then(|()| run.apply_queued()),
                    9 => run.queue(stiffer).and_then(|()| run.apply_queued()),
                    20 => run.set_automatic(true),
                    _ => Ok(()),
                }
                .expect("it is accepted");
            }
            // A choice that is begun is begun anew after a change.
            if at == 8 || at == 19 {
                lazy.run.set_automatic(true).expect("later");
                eager.set_automatic(true).expect("at once");
                lazy.run.prepare(&mut lazy.estimator).expect("a piece");
            }
            lazy.step();
            step(&mut eager, 1);
            assert_eq!(now(&lazy.run), now(&eager), "{} after {at} steps", loaded.name);
        }
        assert!(10 < lazy.most, "{} pieces", lazy.most);
    }
}

/// Two level sheets that fly at each other, by more than twenty times the sum of both thicknesses
/// in a substep that is stable.
fn shot(method: &str) -> Loaded {
    let sheet = |y: f64, v: f64| {
        format!(
            "[[bodies]]\nkind = 'cloth'\nsize = [5, 5]\nspacing = 0.1\nmass = 0.01\n\
             stiffness = 40\nposition = [0, {y}, 0]\nvelocity = [0, {v}, 0]\n\
             rotation = {{ axis = [1, 0, 0], angle_deg = 90 }}\n\
             touch = {{ thickness = 0.002, restitution = 0.2 }}\n"
        )
    };
    let text = format!(
        "version = 1\n[solver]\nintegrator = '{method}'\n[world]\ngravity = [0, 0, 0]\n{}{}",
        sheet(0.0, 120.0),
        sheet(1.2, -120.0)
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shot.toml");
    std::fs::write(&path, text).expect("a file");
    open(&path).expect("a scene")
}

/// Whether the sheet that was above still is, all of it.
fn is_above(run: &Runner) -> bool {
    let heights: Vec<f64> =
        on!(run, simulation => simulation.positions().map(|x| x.to_f64().y).collect());
    let (below, above) = heights.split_at(25);
    below.iter().zip(above).all(|(below, above)| below < above)
}

#[test]
fn what_would_pass_through_is_stepped_with_more_substeps() {
    for method in ["velocity-verlet", "symplectic-euler", "rk4", "xpbd"] {
        let loaded = shot(method);
        let mut run = runner(&loaded);
        let before = substeps(&run);
        let settings = Settings { substeps: before, ..loaded.settings };
        let mut fixed = runner(&Loaded { automatic: false, settings, ..loaded });
        let mut most = before;
        for _ in 0..12 {
            step(&mut run, 1);
            step(&mut fixed, 1);
            most = most.max(substeps(&run));
        }
        assert!(0 < fixed.passes(), "{method}");
        // A stage of another method may see the sheet in the middle of a substep.
        assert!(method != "velocity-verlet" || !is_above(&fixed));
        assert!(run.passes() == 0 && is_above(&run), "{method}: {}", run.passes());
        assert!(2 * before <= most && most.is_multiple_of(before), "{method}: {before} to {most}");
    }
}

#[test]
fn a_step_that_was_divided_is_resumed_returned_to_and_replayed_to_the_bit() {
    let mut run = runner(&shot("velocity-verlet"));
    let (mut history, mut seen) = (History::default(), vec![now(&run)]);
    for _ in 0..12 {
        history.push(run.moment());
        step(&mut run, 1);
        seen.push(now(&run));
    }
    let end = now(&run);
    let divided = seen.iter().position(|then| then.1 != seen[0].1).expect("a step that is divided");
    for at in [0, divided - 1, divided, 11] {
        let mut resumed = runner(&shot("velocity-verlet"));
        step(&mut resumed, at);
        resumed = there_and_back(&resumed);
        step(&mut resumed, 12 - at);
        assert_eq!(now(&resumed), end, "saved after {at} steps");
        // With the substeps of each step, and without a choice: as in a replay.
        let mut replayed = runner(&Loaded { automatic: false, ..shot("velocity-verlet") });
        for then in &seen[1..] {
            let settings = Settings { substeps: then.1, ..replayed.settings() };
            replayed.set_settings(settings).expect("valid settings");
            step(&mut replayed, 1);
            assert_eq!(now(&replayed), *then);
        }
        run.go_back(history.nth_back(12 - at).expect("so many states")).expect("a state");
        assert_eq!(now(&run), seen[at]);
        step(&mut run, 12 - at);
        assert_eq!(now(&run), end, "gone back to step {at}");
    }
}

#[test]
fn what_passes_raised_is_lowered_by_a_renewal() {
    for method in ["velocity-verlet", "xpbd"] {
        let mut run = runner(&shot(method));
        let few = substeps(&run);
        let raised = (0..12).any(|_| {
            step(&mut run, 1);
            few < substeps(&run)
        });
        let most = substeps(&run);
        assert!(raised, "{method}: {most} substeps");
        // A crumpled body may need more than at first.
        let lowered = (0..every(&run)).any(|_| {
            step(&mut run, 1);
            substeps(&run) < most
        });
        assert!(lowered, "{method}: still {most} substeps");
    }
}

#[test]
fn the_most_substeps_let_pass_what_still_would() {
    let mut loaded = shot("velocity-verlet");
    let velocity = DVec3::new(0.0, -1.2e5, 0.0);
    for particle in &mut loaded.scene.particles[25..] {
        particle.velocity = velocity;
    }
    let mut run = runner(&loaded);
    step(&mut run, 1);
    // By two metres in a substep.
    assert!(0 < run.passes());
    assert_eq!(substeps(&run), 1000);
}

#[test]
fn a_step_that_fails_leaves_the_substeps_as_they_were() {
    let mut loaded = shot("velocity-verlet");
    let mut run = runner(&loaded);
    let few = substeps(&run);
    let divided = (0..12).find(|_| {
        step(&mut run, 1);
        few < substeps(&run)
    });
    let divided = divided.expect("a step that is divided");
    // In that step another particle leaves the world: ten metres a step, of which five are left.
    let left = 10.0 * f64::from(divided) + 5.0;
    let position = DVec3::X * (loaded.scene.world.extent - left);
    let velocity = DVec3::X * (10.0 / loaded.settings.step);
    loaded.scene.particles.push(Particle { position, velocity, mass: 1.0 });
    let mut run = runner(&loaded);
    step(&mut run, divided as usize);
    let before = now(&run);
    assert_eq!(before.1, few, "it is divided no earlier");
    run.step().expect_err("a particle leaves the world");
    assert_eq!(now(&run), before);
}
