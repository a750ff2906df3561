//! Memory of a simulation: bytes per particle at its start, and no allocation after the first step.

use allocation_counter::measure;
use msd_core::glam::DVec3;
use msd_core::{
    Air, Bend, Friction, Gust, Integrator, Interaction, Material, Particle, Pin, Plane, Real,
    Scene, Settings, Simulation, Spring, shape,
};
use std::fmt::Write;
use std::path::Path;

fn plane(normal: DVec3, offset: f64, friction: Friction) -> Plane {
    Plane { normal, offset, restitution: 0.3, friction }
}

/// A block with drag and a pin just above a floor and beside a wall, on both of which it slides;
/// with dampers it is in gusty air too.
fn busy_scene(damping: f64) -> Scene {
    let material = Material { mass: 1.0, stiffness: 2000.0, damping };
    let mut part = shape::block([4, 4, 4], 0.5, material).expect("a block");
    part.set_motion(DVec3::new(-1.0, -0.5, 0.3), DVec3::new(0.3, 1.0, -0.4));
    let mut scene = Scene::of("block", part);
    scene.world.drag = 0.05;
    let gust = Gust { strength: 1.0, ..Gust::default() };
    // Explicit Euler hardly bears it without dampers.
    scene.world.air = (0.0 < damping).then(|| Air { gust, ..Air::default() });
    let lowest = |axis: DVec3| {
        let along = scene.particles.iter().map(|particle| particle.position.dot(axis));
        along.fold(f64::MAX, f64::min) - 0.2
    };
    let floor = plane(DVec3::Y, lowest(DVec3::Y), Friction::Coulomb(0.5));
    let wall = plane(DVec3::X, lowest(DVec3::X), Friction::TangentialLoss(0.3));
    scene.planes = vec![floor, wall];
    scene.bends = (0..62).map(|row| Bend::line([row, row + 1, row + 2], 20.0, damping)).collect();
    scene.pins.push(Pin { particle: 63, velocity: DVec3::new(0.0, -0.2, 0.0) });
    scene
}

/// A step with the user input and the readings of a window around it.
fn step_with_a_hand<R: Real>(simulation: &mut Simulation<R>, hand: bool) {
    if hand {
        let target = DVec3::new(1.0 - 0.5 * simulation.time(), 1.0, 0.5);
        let (frequency, damping_ratio, max_force) = (2.0, 0.7, 500.0);
        let grab = Interaction::Grab { particle: 21, target, frequency, damping_ratio, max_force };
        simulation.queue(grab).expect("a valid grab");
        let force = DVec3::new(3.0, 0.0, 0.0);
        simulation.queue(Interaction::Push { particle: 40, force }).expect("a valid push");
    }
    simulation.step().expect("a run that stays in the world");
    let energy = simulation.energy().total() + simulation.dissipated();
    assert!(energy.is_finite() && simulation.momentum().linear.is_finite());
    assert_eq!(simulation.snapshot().positions().count(), 64);
}

/// Asserts that nothing is allocated after the first step, and that there was something to do.
fn steps_allocate_nothing<R: Real>(integrator: Integrator) {
    for (damping, hand) in [(5.0, false), (5.0, true), (0.0, false)] {
        let settings = Settings { integrator, substeps: 32, ..Settings::default() };
        let mut simulation =
            Simulation::<R>::new(&busy_scene(damping), settings).expect("a valid scene");
        step_with_a_hand(&mut simulation, hand);
        let (mut contacts, first) = (0, simulation.touched());
        let asked = measure(|| {
            for _ in 0..120 {
                step_with_a_hand(&mut simulation, hand);
                contacts += u32::from(simulation.touched());
            }
        });
        let what = format!("{integrator} in {} with damping {damping}, hand: {hand}", R::NAME);
        assert!(!first && 0 < contacts, "{what}: nothing touches a plane for the first time");
        assert_eq!(asked.count_total, 0, "{what}");
    }
}

macro_rules! each_method {
    ($($name:ident $integrator:ident)*) => {
        mod a_step_allocates_nothing_after_the_first {
            $(#[test]
            fn $name() {
                super::steps_allocate_nothing::<f32>(super::Integrator::$integrator);
                super::steps_allocate_nothing::<f64>(super::Integrator::$integrator);
            })*
            pub const METHODS: &[super::Integrator] = &[$(super::Integrator::$integrator),*];
        }
    };
}

each_method! {
    explicit_euler ExplicitEuler
    symplectic_euler SymplecticEuler
    velocity_verlet VelocityVerlet
    rk4 Rk4
    dormand_prince DormandPrince
    backward_euler BackwardEuler
    implicit_midpoint ImplicitMidpoint
    xpbd Xpbd
}

#[test]
fn every_method_is_among_those_whose_allocations_are_counted() {
    assert_eq!(a_step_allocates_nothing_after_the_first::METHODS, Integrator::ALL);
}

/// An unstructured body of particles and springs, so soft that it hardly moves, above a floor.
fn unstructured([particles, springs]: [usize; 2], own_material: bool) -> Scene {
    let particle = |row: usize| Particle {
        position: DVec3::new(row as f64, 0.0, 0.0),
        velocity: DVec3::ZERO,
        mass: 1.0 + row as f64,
    };
    let spring = |row: usize| Spring {
        ends: [row % particles, (row + 1 + (row / particles * 811 + row % 7)) % particles],
        rest_length: 1.0,
        stiffness: if own_material { 1e-6 * row as f64 } else { 1e-6 },
        damping: if own_material { 2e-6 * row as f64 } else { 1e-6 },
    };
    Scene {
        particles: (0..particles).map(particle).collect(),
        springs: (0..springs).map(spring).collect(),
        planes: vec![plane(DVec3::Y, -1.0, Friction::Coulomb(0.5))],
        ..Scene::default()
    }
}

/// Memory that a simulation holds once it has taken a step, bytes.
fn held<R: Real>(integrator: Integrator, scene: &Scene) -> i64 {
    let settings = Settings { integrator, ..Settings::default() };
    let mut kept = None;
    let asked = measure(|| {
        let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
        simulation.step().expect("a calm scene");
        kept = Some(simulation);
    });
    drop(kept);
    asked.bytes_current
}

#[test]
fn a_method_that_is_left_keeps_no_memory() {
    let (scene, first) = (cloth(), Integrator::SymplecticEuler);
    for left in [Integrator::Rk4, Integrator::BackwardEuler] {
        let mut simulation = None;
        let asked = measure(|| {
            let settings = |integrator| Settings { integrator, ..Settings::default() };
            let mut run = Simulation::<f32>::new(&scene, settings(left)).expect("a valid scene");
            run.step().expect("a calm scene");
            run.set_settings(settings(first)).expect("a valid method");
            run.step().expect("a calm scene");
            simulation = Some(run);
        });
        drop(simulation);
        assert_eq!(asked.bytes_current, held::<f32>(first, &scene), "{left}");
    }
}

/// Few enough that no step is shared among threads, whose pool would be counted too.
const COUNT: usize = 48 * 48;

/// Sheet of springs that reach as far from each particle, 8 from each but at its borders.
fn cloth() -> Scene {
    let material = Material { mass: 1.0, stiffness: 1e-6, damping: 1e-6 };
    let mut scene = Scene::of("cloth", shape::cloth([48, 48], 1.0, material).expect("a cloth"));
    scene.planes = vec![plane(DVec3::Y, -100.0, Friction::Coulomb(0.5))];
    scene
}

/// Memory for each particle, bytes, rounded up.
fn cost<R: Real>(integrator: Integrator, scene: &Scene) -> i64 {
    held::<R>(integrator, scene).div_euclid(COUNT as i64) + 1
}

#[test]
fn memory_is_what_the_documents_say() {
    let mut table = String::from(
        "| method | cloth, f32 | cloth, f64 | unstructured, f32 | unstructured, f64 |\n\
         |---|---|---|---|---|\n",
    );
    let (cloth, other) = (cloth(), unstructured([COUNT, 8 * COUNT], false));
    for integrator in Integrator::ALL {
        let [a, b] = [cost::<f32>(integrator, &cloth), cost::<f64>(integrator, &cloth)];
        let [c, d] = [cost::<f32>(integrator, &other), cost::<f64>(integrator, &other)];
        writeln!(table, "| {integrator} | {a} | {b} | {c} | {d} |").expect("a string has room");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/measured/endurance.md");
    let text = std::fs::read_to_string(path).expect("the document");
    assert!(text.contains(&table), "docs/measured/endurance.md must have this table:\n{table}");
}

#[test]
fn springs_pay_for_a_material_of_their_own_alone() {
    let springs = 8 * COUNT as i64;
    let scenes = [false, true].map(|own| unstructured([COUNT, 8 * COUNT], own));
    for integrator in Integrator::ALL {
        // A stiffness and a damping per spring are two numbers of the model and two in rows of the
        // kernel, of which up to a quarter of the lanes are empty.
        let [uniform, own] = scenes.each_ref().map(|scene| held::<f32>(integrator, scene));
        let more = own - uniform;
        assert!((16 * springs..19 * springs).contains(&more), "{integrator}: {more}");
    }
}

#[test]
fn rows_of_a_scene_take_what_the_documents_say() {
    // Seven doubles; two indices and three doubles.
    assert_eq!([size_of::<Particle>(), size_of::<Spring>()], [56, 40]);
}

/// It is moved about with its owner, on stacks that may be small.
#[test]
fn what_predicts_is_small_to_move() {
    assert!(size_of::<msd_core::stability::Estimator>() < 1024);
}
