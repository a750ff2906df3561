//! Contact points on springs: thin solids hold sparse bodies, and impulses are shared to the ends.

use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Particle, Scene, Settings, Shape, Simulation, Solid, Spring,
    World, shape,
};
use std::f64::consts::FRAC_PI_2;

/// A rod along z through the origin, of 10 cm.
fn rod(springs: bool) -> Solid {
    let mut rod = Solid::new(Shape::Capsule { radius: 0.05, length: 3.0 });
    rod.axes = rotation(DVec3::X, FRAC_PI_2);
    Solid { friction: Friction::Coulomb(0.5), springs, ..rod }
}

/// A cloth of 6 x 6 particles, 25 cm apart, above the rod, which no particle would meet.
fn cloth(springs: bool) -> Scene {
    let material = Material { mass: 0.05, stiffness: 400.0, damping: 2.0 };
    let mut cloth = shape::cloth([6, 6], 0.25, material).expect("a cloth");
    let flat = DMat3::from_rotation_x(FRAC_PI_2);
    cloth.place(flat, DVec3::new(0.01, 0.3, 0.03));
    Scene { solids: vec![rod(springs)], ..Scene::of("cloth", cloth) }
}

fn simulation(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<f64> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

fn run(scene: &Scene, integrator: Integrator, seconds: usize) -> Simulation<f64> {
    let mut simulation = simulation(scene, integrator, 32);
    (0..60 * seconds).for_each(|_| simulation.step().expect("a calm run"));
    simulation
}

#[test]
fn a_sparse_cloth_hangs_over_a_thin_rod() {
    for integrator in Integrator::ALL {
        // It falls by 4.9 m in the first second.
        let pierced = run(&cloth(false), integrator, 2).centre_of_mass(0..36).y;
        assert!(pierced < -4.0, "{integrator}: held by nothing at {pierced} m");
        // Dormand-Prince meets points where its long substeps end, between which they creep.
        let seconds = if integrator == Integrator::DormandPrince { 1 } else { 3 };
        let held = run(&cloth(true), integrator, seconds);
        let middle = held.centre_of_mass(0..36).y;
        assert!((-0.5..0.05).contains(&middle), "{integrator}: {middle} m");
        // Springs lie outside of the rod, but for what a point falls in a substep and one sinks in
        // between.
        for &[a, b] in held.model().springs().ends() {
            let [a, b] = [a, b].map(|end| held.position(end as usize));
            for part in [0.25, 0.5, 0.75] {
                let point = a + (b - a) * part;
                let depth = 0.05 - DVec3::new(point.x, point.y, 0.0).length();
                assert!(depth < 2e-3, "{integrator}: {depth} m inside");
            }
        }
    }
}

/// Two particles on a spring fall flat on the rod, a quarter of the way from the first: rigid in
/// no direction but along, so that each goes on as the shared impulse says.
#[test]
fn an_impulse_is_shared_to_the_ends_by_weight() {
    let (masses, part, restitution) = ([0.3, 0.5], 0.25, 0.6);
    for integrator in Integrator::ALL {
        let ends = [-part, 1.0 - part].map(|x| DVec3::new(x, 0.2, 0.0));
        let fall = DVec3::new(0.0, -3.0, 0.0);
        let particles =
            (0..2).map(|at| Particle { position: ends[at], velocity: fall, mass: masses[at] });
        let spring = Spring { ends: [0, 1], rest_length: 1.0, stiffness: 1.0, damping: 0.0 };
        let solid = Solid { restitution, friction: Friction::Coulomb(0.0), ..rod(true) };
        let scene = Scene {
            world: World { gravity: DVec3::ZERO, ..World::default() },
            particles: particles.collect(),
            springs: vec![spring],
            solids: vec![solid],
            ..Scene::default()
        };
        let mut simulation = simulation(&scene, integrator, 64);
        let before = simulation.energy();
        // The impact is after 50 ms; what the point sinks into a round rod turns the push a little.
        (0..4).for_each(|_| simulation.step().expect("a calm run"));
        let weights = [1.0 - part, part];
        let reciprocal: f64 = (0..2).map(|at| weights[at] * weights[at] / masses[at]).sum();
        let impulse = (1.0 + restitution) * 3.0 / reciprocal;
        for at in 0..2 {
            let expected = -3.0 + impulse * weights[at] / masses[at];
            let found = simulation.velocity(at).y;
            assert!((found - expected).abs() < 2e-3 * 3.0, "{integrator} {at}: {found}");
        }
        // What the rod took is what is missing.
        let lost = 0.5 * (1.0 - restitution * restitution) * 9.0 / reciprocal;
        let (after, contacts) = (simulation.energy(), simulation.contacts());
        assert!(
            (contacts.taken - lost).abs() < 5e-3 * lost,
            "{integrator}: {contacts:?} of {lost}"
        );
        assert!((after.total() - before.total()).abs() < 5e-3 * lost, "{integrator}");
    }
}

#[test]
fn the_ledger_closes_over_a_rod() {
    let error = |integrator, substeps| {
        let mut simulation = simulation(&cloth(true), integrator, substeps);
        let before = simulation.energy().total();
        (0..120).for_each(|_| simulation.step().expect("a calm run"));
        let after = simulation.energy();
        (after.total() - before).abs() / after.dissipated
    };
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4] {
        let (coarse, fine) = (error(integrator, 16), error(integrator, 128));
        assert!(coarse < 0.1 && fine < 0.01, "{integrator}: {coarse}, {fine}");
    }
}

/// Obstacles add no stiffness: the predicted step is that without.
#[test]
fn points_leave_the_stable_step_as_it_is() {
    let stable = |springs| {
        let simulation = run(&cloth(springs), Integrator::default(), 0);
        simulation.stable_substep()
    };
    assert_eq!(stable(true), stable(false));
}

/// Springs that are cut have no points, and none that is shorter than the solid is thick.
#[test]
fn only_long_springs_that_are_there_have_points() {
    let mut thick = cloth(true);
    thick.solids[0].shape = Shape::Capsule { radius: 0.18, length: 3.0 };
    let springs = thick.springs.len();
    let mut cut = simulation(&cloth(true), Integrator::default(), 32);
    for spring in 0..springs {
        let interaction = msd_core::Interaction::Cut { spring };
        cut.queue(interaction).expect("a spring of the scene");
    }
    (0..90).for_each(|_| cut.step().expect("a calm run"));
    // Each particle falls on its own, beside the rod.
    assert!((0..36).all(|particle| cut.position(particle).y < -5.0));
    // A rod of 36 cm is met by the particles themselves, whether it meets springs or not.
    let mut end = |springs: bool| {
        thick.solids[0].springs = springs;
        run(&thick, Integrator::default(), 1).state()
    };
    assert_eq!(end(true), end(false));
}
