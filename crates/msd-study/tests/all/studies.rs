//! The reference is right, errors are as stated, and tuning delivers.

use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::Shell;
use msd_core::{
    Friction, Integrator, Material, Particle, Pin, Plane, Scene, Simulation, Spring, World, shape,
};
use msd_run::Runner;
use msd_scene::{Loaded, Precision};
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::conduct::{Course, Plan, study};
use msd_study::errors::{Errors, rms_distance};
use msd_study::live_error::{Estimator, calibrate};
use msd_study::monitor::{Deadline, Halt, Monitor, Progress};
use msd_study::quantity::rounded;
use msd_study::reference::{Wish, make_reference};
use msd_study::trial::{Trial, try_choice};
use msd_study::tune::{Goal, retry, tune};
use msd_study::words::words;

fn weightless() -> World {
    World { gravity: DVec3::ZERO, ..World::default() }
}

/// Two masses on a spring of rest length 1, stretched by `stretch`.
fn two_masses(stiffness: f64, damping: f64, stretch: f64) -> Scene {
    let particle =
        |x: f64| Particle { position: DVec3::new(x, 0.0, 0.0), velocity: DVec3::ZERO, mass: 1.0 };
    Scene {
        world: weightless(),
        particles: vec![particle(0.0), particle(1.0 + stretch)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness, damping }],
        ..Scene::default()
    }
}

fn cloth() -> Loaded {
    let material = Material { mass: 1.0, stiffness: 500.0, damping: 1.0 };
    let mut loaded = msd_scene::open("chain").unwrap();
    let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    let part = shape::cloth([5, 5], 1.0, material).unwrap();
    loaded.scene = Scene { pins, ..Scene::of("cloth", part) };
    loaded.name = "cloth".into();
    loaded
}

#[test]
fn the_reference_is_the_closed_form_within_its_own_uncertainty() {
    let (k, b, a) = (300.0, 4.0, 0.2);
    let wish = Wish { uncertainty: 1e-9, ..Wish::default() };
    let reference = make_reference(&two_masses(k, b, a), wish, &mut ()).unwrap();
    assert!(reference.uncertainty() <= 1e-9 * reference.size);
    // Relative motion: m/2 y'' + b y' + k y = 0, from y = a at rest.
    let (decay, w2) = (b, 2.0 * k);
    let w = (w2 - decay * decay).sqrt();
    for (&frame, state) in reference.frames.iter().zip(&reference.states) {
        let t = frame as f64 * FRAME;
        let y = a * (-decay * t).exp() * ((w * t).cos() + decay / w * (w * t).sin());
        let length = state.positions[1].x - state.positions[0].x;
        // The uncertainty is of the position of each, root mean square.
        assert!((length - 1.0 - y).abs() <= 4.0 * reference.uncertainty(), "t = {t}");
    }
}

#[test]
fn free_fall_has_a_reference_in_closed_form() {
    let mut scene = two_masses(0.0, 0.0, 0.0);
    scene.springs.clear();
    scene.world = World::default();
    scene.particles[1].velocity = DVec3::new(1.0, 2.0, 3.0);
    let reference =
        make_reference(&scene, Wish { duration: 2.0, ..Wish::default() }, &mut ()).unwrap();
    assert_eq!((reference.tolerance, reference.uncertainty()), (0.0, 0.0));
    let last = reference.states.last().unwrap();
    assert!((last.positions[0].y + 0.5 * 9.82 * 4.0).abs() < 1e-12);
    assert!((last.positions[1].x - 3.0).abs() < 1e-12);
}

/// A small cloth above a larger, pinned one, both with a thickness.
fn sheets() -> Scene {
    let material = Material { mass: 0.1, stiffness: 200.0, damping: 0.5 };
    let mut scene = Scene::default();
    for (size, offset) in [(5, DVec3::ZERO), (3, DVec3::new(0.03, 0.05, 0.02))] {
        let mut part = shape::cloth([size, size], 0.1, material).unwrap();
        part.place(DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2), offset);
        scene.add("sheet", part);
    }
    scene.pins = (0..25).map(|particle| Pin { particle, velocity: DVec3::ZERO }).collect();
    for body in &scene.bodies {
        let triangles = body.surface.particles();
        let triangles = triangles.map(|corners| corners.map(|corner| corner as usize)).collect();
        scene.shells.push(Shell { triangles, thickness: 0.01, friction: 0.3, ..Shell::default() });
    }
    scene
}

#[test]
fn where_shells_meet_a_finer_run_confirms_the_reference() {
    let scene = sheets();
    let wish = Wish { duration: 0.3, uncertainty: 1e-4, patience: 10.0 };
    let reference = make_reference(&scene, wish, &mut ()).unwrap();
    let substeps = 4 * reference.substeps;
    let fineness = Fineness::Substeps(substeps);
    let finer = Choice { integrator: Integrator::Rk4, fineness, precision: Precision::F64 };
    let mut run = Simulation::<f64>::new(&scene, finer.settings()).unwrap();
    (0..18).for_each(|_| run.step().unwrap());
    let off = rms_distance(&run.state(), &reference.states.last().unwrap().state());
    assert!(off <= reference.uncertainty(), "{off} m and {} m", reference.uncertainty());
    assert!((run.position(29).y - 0.02).abs() <= 1e-3, "{}, on the lower one", run.position(29));
}

#[test]
fn tuning_chooses_among_the_methods_that_let_shells_meet() {
    let tuned = tune(&sheets(), 0.3, Goal::MaxError(1e-3), &mut ()).unwrap();
    let Trial { choice, .. } = tuned.best.trial;
    assert!(tuned.met && choice.integrator.lets_shells_meet(), "{choice}");
    assert!(tuned.uncertainty <= 1e-4, "{} m", tuned.uncertainty);
}

#[test]
fn a_tower_that_falls_is_told_to_be_unpredictable_and_a_pendulum_is_not() {
    // A chain stood on its end grows a sideways perturbation by e every √(l/g): here e¹² in 1 s
    // or so, which takes 1e-12 to about 1e-7.
    let material = Material { mass: 1.0, stiffness: 1e4, damping: 0.0 };
    let mut part = shape::rope(6, 0.1, material).unwrap();
    for (row, particle) in part.particles.iter_mut().enumerate() {
        particle.position = DVec3::new(0.0, 0.1 * row as f64, 0.0);
    }
    let pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
    let tower = Scene { pins, ..Scene::of("tower", part) };
    let wish = Wish { duration: 1.5, uncertainty: 1e-9, ..Wish::default() };
    let reference = make_reference(&tower, wish, &mut ()).unwrap();
    let grown = reference.grown.last().unwrap() / (1e-12 * reference.size);
    assert!(1e3 < grown, "grew {grown:.1e} times");
    let (early, late) = (reference.grown[5], *reference.grown.last().unwrap());
    assert!(reference.horizon(0.5 * (early + late)).is_some());
    assert!(reference.reliable(0.5 * (early + late)) < reference.frames.len());
    let calm = make_reference(&two_masses(10.0, 1.0, 0.1), wish, &mut ()).unwrap();
    assert_eq!(calm.horizon(1e-6), None);
}

#[test]
fn errors_shrink_at_the_order_of_the_method() {
    let scene = cloth().scene;
    let wish = Wish { duration: 0.5, uncertainty: 1e-12, ..Wish::default() };
    let right = make_reference(&scene, wish, &mut ()).unwrap();
    let precision = Precision::F64;
    for (integrator, substeps) in [
        (Integrator::SymplecticEuler, 64),
        (Integrator::VelocityVerlet, 16),
        (Integrator::Rk4, 4),
        (Integrator::BackwardEuler, 64),
    ] {
        let error = |substeps| {
            let choice = Choice { integrator, fineness: Fineness::Substeps(substeps), precision };
            try_choice(&scene, choice, (&right, right.frames.len()), &mut ()).unwrap().error()
        };
        let order = (error(substeps) / error(2 * substeps)).log2();
        // The next term is a fraction of about h w of the leading one: w = 60, h w < 0.3.
        assert!((order - f64::from(integrator.order())).abs() < 0.3, "{integrator}: {order:.2}");
    }
}

#[test]
fn tuning_delivers_what_is_asked_and_no_coarser_choice_would() {
    let scene = cloth().scene;
    let tight = Wish { duration: 0.5, uncertainty: 1e-10, ..Wish::default() };
    let right = make_reference(&scene, tight, &mut ()).unwrap();
    for fraction in [1e-2, 1e-4, 1e-6] {
        let asked = fraction * right.size;
        let tuned = tune(&scene, 0.5, Goal::MaxError(asked), &mut ()).unwrap();
        assert!(tuned.met);
        let choice = tuned.best.trial.choice;
        let delivered =
            try_choice(&scene, choice, (&right, right.frames.len()), &mut ()).unwrap().error();
        assert!(delivered <= asked, "{choice}: {delivered:.1e} of {asked:.1e}");
        // Predicted from another trial of the same method, by its order: a factor, not a digit.
        let ratio = tuned.best.predicted_error.unwrap() / delivered;
        assert!((0.05..20.0).contains(&ratio), "{choice}: predicted {ratio:.2} times what came");
        if let (Fineness::Substeps(substeps), true) = (choice.fineness, fraction < 1e-3) {
            // A choice of half the substeps would do if the search had not looked for the coarsest.
            let coarse = Choice { fineness: Fineness::Substeps((substeps / 2).max(1)), ..choice };
            let coarse = try_choice(&scene, coarse, (&right, right.frames.len()), &mut ()).unwrap();
            assert!(asked < coarse.error() || substeps == 1, "{choice} is finer than needed");
        }
    }
}

/// Dormand-Prince at its loosest, which lets energy grow as long as each substep is within it.
const LOOSE: Choice = Choice {
    integrator: Integrator::DormandPrince,
    fineness: Fineness::Tolerance(1e-2),
    precision: Precision::F32,
};

#[test]
fn a_source_of_energy_is_measured_and_is_no_choice_however_near_it_is() {
    let scene = msd_scene::open("jelly").unwrap().scene;
    let right = make_reference(&scene, Wish::default(), &mut ()).unwrap();
    let loose = try_choice(&scene, LOOSE, (&right, 1), &mut ()).unwrap();
    // All that moves is some tens of kilojoules: the drift detector of `msd run` warns, too.
    assert!(0.0 < loose.gained && loose.errors.is_some(), "{}", loose.gained);
    assert!(!loose.is_sound() && !loose.is_within(1e9));
    let fine = Choice { fineness: Fineness::Tolerance(1e-6), ..LOOSE };
    let fine = try_choice(&scene, fine, (&right, 1), &mut ()).unwrap();
    assert!(fine.is_sound() && fine.gained == 0.0, "{}", fine.gained);
    let mut studied = study(&cloth(), quick(), &mut ()).unwrap().0;
    // As near as can be and cheaper than all others: only its added energy speaks against it.
    let best = Trial { cost: 1e-12, errors: Some(Errors::default()), ..loose };
    studied.trials.push(best);
    let row = studied.trials.len() - 1;
    assert!(!studied.front().contains(&row));
    let told = words(&studied);
    assert!(told.contains("gains energy") && !told.contains("tolerance 1e-2"), "{told}");
    studied.trials[row].gained = 0.0;
    assert!(studied.front().contains(&row) && words(&studied).contains("tolerance 1e-2"));
}

fn quick() -> Plan {
    Plan { duration: 0.2, budget: 0.5, ..Plan::default() }
}

#[test]
fn what_was_found_is_passed_over_where_it_adds_energy_from_another_state() {
    let scene = msd_scene::open("jelly").unwrap().scene;
    let right = make_reference(&scene, Wish { duration: 0.2, ..Wish::default() }, &mut ()).unwrap();
    // The first fifth of a second is free fall: nothing speaks against it there.
    let loose = try_choice(&scene, LOOSE, (&right, right.frames.len()), &mut ()).unwrap();
    assert!(loose.is_within(0.3), "{} m off, {} J", loose.error(), loose.gained);
    let verlet = Integrator::VelocityVerlet;
    let choice = Choice { integrator: verlet, fineness: Fineness::Substeps(16), ..LOOSE };
    let sound = try_choice(&scene, choice, (&right, right.frames.len()), &mut ()).unwrap();
    assert!(sound.is_within(0.3), "{} m off, {} J", sound.error(), sound.gained);
    let mut run = Runner::new(&scene, choice.settings(), Precision::F64).unwrap();
    (0..60).for_each(|_| run.step().unwrap());
    let here = run.progress().0;
    let wish = (Goal::MaxError(0.3), 0.2, 2.0);
    let elsewhere = retry(&here, &[LOOSE, choice], wish, &mut ()).unwrap();
    assert_eq!(elsewhere.held.map(|trial| trial.choice), Some(choice));
    let [(refused, why)] = &elsewhere.refused[..] else { panic!("{:?}", elsewhere.refused) };
    assert_eq!(*refused, LOOSE);
    assert!(why.contains("adds ") && why.contains("J that nothing supplied"), "{why}");
    // A choice that is not as near as asked from there is passed over as well.
    let wish = (Goal::MaxError(1e-9), 0.2, 2.0);
    let elsewhere = retry(&here, &[choice], wish, &mut ()).unwrap();
    assert!(elsewhere.held.is_none() && elsewhere.refused.len() == 1, "{elsewhere:?}");
}

/// One whose deadline is in a trial.
struct Impatient {
    left: usize,
}

impl Monitor for Impatient {
    fn report(&mut self, progress: Progress) {
        self.left = self.left.saturating_sub(usize::from(progress.parts.is_some()));
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.left == 0 { Err(Halt::Deadline) } else { Ok(()) }
    }
}

#[test]
fn a_search_whose_time_is_over_takes_the_best_so_far_or_says_that_there_is_none() {
    let scene = cloth().scene;
    let goal = Goal::MaxError(1e-3);
    let search = |left| tune(&scene, 0.2, goal, &mut Impatient { left });
    let whole = tune(&scene, 0.2, goal, &mut ()).unwrap();
    let short = search(6).unwrap();
    assert!(short.is_cut_short && !whole.is_cut_short);
    assert_eq!(short.tried, 5, "the sixth was not ended");
    assert!(short.met && goal.is_met_by(&short.best.trial), "{short:?}");
    assert_eq!(search(0).unwrap_err(), Halt::Deadline, "before there is a reference");
    // Nor is there a reference to try the found choices from elsewhere.
    let wish = (goal, 0.2, 2.0);
    let choices = [short.best.trial.choice; 2];
    let elsewhere = retry(&scene, &choices, wish, &mut Impatient { left: 0 }).unwrap();
    let [(_, why)] = &elsewhere.refused[..] else { panic!("{elsewhere:?}") };
    assert!(elsewhere.held.is_none() && why.contains("time was over"), "{why}");
}

/// A cloth in a gravity that no test had before: its reference is not in the cache.
fn unknown() -> Loaded {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
    let mut loaded = cloth();
    loaded.scene.world.gravity.y -= 1e-9 * f64::from(now.subsec_nanos());
    loaded
}

#[test]
fn a_study_whose_reference_takes_too_long_says_so() {
    let begun = Course::begin(unknown(), quick(), &mut Impatient { left: 0 });
    assert_eq!(begun.err(), Some(Halt::Deadline));
    // A closure has none, unless one is set; a pause does not count.
    let mut slow = |_: Progress| ();
    let begun = Course::begin(unknown(), quick(), &mut Deadline::new(&mut slow, 0.0));
    assert_eq!(begun.err(), Some(Halt::Deadline));
}

#[test]
fn how_far_a_reference_is_is_told_run_by_run() {
    let mut heard: Vec<String> = Vec::new();
    let mut hear = |progress: Progress| {
        heard.extend(progress.now.strip_prefix("making the reference: ").map(str::to_owned));
    };
    Course::begin(unknown(), quick(), &mut hear).unwrap();
    let frames = (quick().duration * 60.0).round() as usize;
    assert!(3 * frames <= heard.len() && heard.len().is_multiple_of(frames), "{:?}", heard);
    for (row, words) in heard.iter().enumerate() {
        let (run, time) = (row / frames + 1, (row % frames) as f64 / 60.0);
        let (all, time) = (run.max(3), rounded(time, 2));
        let expected = format!("run {run} of {all} at least, {time} s of ");
        assert!(words.starts_with(&expected), "{words}, not {expected}");
    }
}

#[test]
fn how_many_methods_are_done_is_told_of_all_there_are() {
    let mut heard = Vec::new();
    tune(&cloth().scene, 0.2, Goal::MaxError(1e-3), &mut |now: Progress| heard.push(now)).unwrap();
    let methods: Vec<_> = heard.iter().filter_map(|now| now.parts).collect();
    // Eight methods in two precisions each, the cloth being damped.
    assert!(methods.iter().all(|&[done, all]| done < all && all == 16), "{methods:?}");
    assert!(methods.is_sorted() && 8 < methods[methods.len() - 1][0], "{methods:?}");
    assert_eq!(heard[0].words(), "making the reference");
    let last = &heard[heard.len() - 1];
    assert!(
        last.words().contains(" of 16 pairs of method and precision done; "),
        "{}",
        last.words()
    );
    let mut heard = Vec::new();
    study(&cloth(), quick(), &mut |now: Progress| heard.push(now)).unwrap();
    let methods: Vec<_> = heard.iter().filter_map(|now| now.parts).collect();
    assert!(methods.is_sorted() && methods.iter().all(|&[done, all]| done < all && all == 16));
}

#[test]
fn tuning_says_so_when_nothing_meets_the_wish() {
    let scene = cloth().scene;
    assert!(!tune(&scene, 0.2, Goal::Budget(1e-12), &mut ()).unwrap().met);
    let tuned = tune(&scene, 0.2, Goal::MaxError(1e-30), &mut ()).unwrap();
    assert!(!tuned.met);
    assert!(tuned.best.trial.error() < 1e-3);
}

#[test]
fn a_study_has_a_front_that_falls_and_words_that_name_its_choice() {
    let plan = Plan { duration: 0.3, budget: 3.0, fresh: true, ..Plan::default() };
    let studied = study(&cloth(), plan, &mut ()).unwrap().0;
    let front: Vec<_> = studied.front().into_iter().map(|row| &studied.trials[row]).collect();
    assert!(1 < front.len());
    for pair in front.windows(2) {
        assert!(pair[0].cost <= pair[1].cost && pair[1].error() < pair[0].error());
    }
    let beaten = |trial: &&msd_study::trial::Trial| {
        front.iter().any(|best| best.cost < trial.cost && best.error() < trial.error())
    };
    assert!(studied.trials.iter().filter(beaten).count() < studied.trials.len());
    let chosen = msd_study::words::cheapest(&studied, studied.wanted).unwrap();
    assert!(studied.words.contains(chosen.choice.integrator.name()), "{}", studied.words);
    // Every method was tried in both precisions, or it is said why not.
    for integrator in Integrator::ALL {
        let tried = studied.of(integrator).count();
        let told = studied.left_out.iter().any(|line| line.contains(integrator.name()));
        assert!(0 < tried || told, "{integrator}");
    }
}

#[test]
fn the_live_estimate_is_near_the_truth_without_contact() {
    let mut loaded = cloth();
    loaded.precision = Precision::F64;
    for (integrator, substeps) in
        [(Integrator::SymplecticEuler, 16), (Integrator::VelocityVerlet, 8)]
    {
        loaded.settings.integrator = integrator;
        loaded.settings.substeps = substeps;
        for calibration in calibrate(&loaded, &[0.0, 0.5], 15).unwrap() {
            let ratio = calibration.estimated / calibration.true_error;
            // Richardson's estimate leaves a relative error of about h w, here at most 0.3.
            assert!((0.7..1.4).contains(&ratio), "{integrator}: {calibration:?}");
        }
    }
}

#[test]
fn an_estimate_comes_at_the_end_of_each_window_and_costs_nothing_between() {
    let mut runner = Runner::open(&cloth()).unwrap();
    let mut estimator = Estimator::new(3, 10);
    let mut found = Vec::new();
    for step in 1..=25 {
        estimator.before_step(&runner);
        runner.step().unwrap();
        if let Some(estimate) = estimator.after_step(&runner) {
            assert_eq!(estimate.particles.len(), 25);
            assert!(estimate.rms <= estimate.worst().1);
            found.push(step);
        }
    }
    assert_eq!(found, [3, 13, 23]);
}

#[test]
fn contact_leaves_the_reference_certain_and_penetration_is_measured() {
    let material = Material { mass: 1.0, stiffness: 300.0, damping: 0.5 };
    let mut part = shape::block([2, 2, 2], 1.0, material).unwrap();
    part.particles.iter_mut().for_each(|particle| particle.position.y += 1.2);
    let friction = Friction::Coulomb(0.3);
    let floor = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.5, friction };
    let scene = Scene { planes: vec![floor], ..Scene::of("block", part) };
    let wish = Wish { uncertainty: 1e-6, ..Wish::default() };
    let right = make_reference(&scene, wish, &mut ()).unwrap();
    assert!(right.uncertainty() < 1e-4 * right.size, "{:.1e}", right.uncertainty());
    let lowest = right.states.iter().flat_map(|state| &state.positions).map(|x| x.y);
    assert!(-1e-9 <= lowest.fold(f64::MAX, f64::min), "the reference stays out of the floor");
}

/// A user who cancels a study after so many trials.
struct Guest(usize);

impl Monitor for Guest {
    fn report(&mut self, progress: Progress) {
        self.0 = if progress.done < self.0 { self.0 } else { 0 };
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        if self.0 == 0 { Err(Halt::Cancelled) } else { Ok(()) }
    }
}

#[test]
fn a_study_has_each_point_as_it_is_made_grants_wishes_and_stops_when_cancelled() {
    let plan = Plan { duration: 0.1, budget: 0.5, fresh: true, ..Plan::default() };
    // Seven is on no ladder.
    let wish = Choice {
        integrator: Integrator::VelocityVerlet,
        fineness: Fineness::Substeps(7),
        precision: Precision::F64,
    };
    let mut course = Course::begin(cloth(), plan, &mut ()).unwrap();
    let mut trials = 0;
    while course.advance(&mut ()).unwrap() {
        assert!(course.study().trials.len() <= trials + 1);
        trials = course.study().trials.len();
        if trials == 3 {
            course.grant(wish, &mut ()).unwrap();
            trials = course.study().trials.len();
            assert_eq!((trials, course.study().trials[3].choice), (4, wish));
        }
    }
    course.grant(wish, &mut ()).unwrap();
    assert!(4 < trials && course.study().trials.len() == trials, "tried once");
    let mut guest = Guest(5);
    let mut course = Course::begin(cloth(), plan, &mut guest).unwrap();
    let halt = loop {
        if let Err(halt) = course.advance(&mut guest) {
            break halt;
        }
    };
    assert_eq!((halt, course.study().trials.len()), (Halt::Cancelled, 5));
}
