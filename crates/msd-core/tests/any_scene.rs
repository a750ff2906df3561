//! Arbitrary scenes: each is refused, runs on finite numbers, or stops with an error.
//!
//! Scenes, settings and interactions are made of valid and invalid parts, over 24 decades.

use msd_core::glam::DVec3;
use msd_core::{
    Body, Corner, Friction, Integrator, Interaction, Particle, Pin, Plane, Real, Scene, Select,
    Settings, Simulation, Spring, Surface, Vector, World,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// A positive number from 1e-12 to 1e12.
fn decade() -> impl Strategy<Value = f64> {
    (-12.0..12.0).prop_map(|exponent| 10f64.powf(exponent))
}

/// Numbers that a careless or hostile user may write.
fn any_number() -> impl Strategy<Value = f64> {
    let odd = vec![0.0, -0.0, 1e-300, 1e300, 1e-39, 3.5e38, 5e-324, f64::MAX, f64::NAN];
    prop_oneof![
        8 => -10.0..10.0,
        4 => decade(),
        2 => decade().prop_map(|number| -number),
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(odd),
    ]
}

/// A number that is mostly positive.
fn usual() -> impl Strategy<Value = f64> {
    prop_oneof![20 => Just(1.0), 40 => decade(), 1 => any_number()]
}

/// A number that is mostly from 0 to 1.
fn fraction() -> impl Strategy<Value = f64> {
    prop_oneof![20 => 0.0..=1.0, 1 => any_number()]
}

fn any_vector() -> impl Strategy<Value = DVec3> {
    [any_number(), any_number(), any_number()].prop_map(DVec3::from_array)
}

/// A vector that is mostly usable.
fn vector() -> impl Strategy<Value = DVec3> {
    let plain = [-3.0..3.0, -3.0..3.0, -3.0..3.0].prop_map(DVec3::from_array);
    let far = (decade(), 0usize..3).prop_map(|(size, axis)| DVec3::AXES[axis] * size.min(1e6));
    prop_oneof![10 => plain, 4 => far, 2 => Just(DVec3::ZERO), 1 => any_vector()]
}

/// An index that is mostly below six.
fn index() -> impl Strategy<Value = usize> {
    prop_oneof![40 => 0usize..6, 1 => 6usize..9, 1 => Just(usize::MAX)]
}

fn friction() -> impl Strategy<Value = Friction> {
    prop_oneof![usual().prop_map(Friction::Coulomb), fraction().prop_map(Friction::TangentialLoss)]
}

prop_compose! {
    fn particle()(position in vector(), velocity in vector(), mass in usual()) -> Particle {
        Particle { position, velocity, mass }
    }
}

prop_compose! {
    fn spring()(
        ends in prop_oneof![(index(), index()), (0usize..3, 3usize..6)],
        (rest_length, stiffness, damping) in (usual(), usual(), usual()),
    ) -> Spring {
        Spring { ends: [ends.0, ends.1], rest_length, stiffness, damping }
    }
}

prop_compose! {
    fn plane()(
        normal in prop_oneof![Just(DVec3::Y), vector()],
        offset in prop_oneof![3 => -3.0..0.0, 1 => any_number()],
        restitution in fraction(),
        friction in friction(),
    ) -> Plane {
        Plane { normal, offset, restitution, friction }
    }
}

prop_compose! {
    fn body()(
        (start, end, springs) in (index(), index(), index()),
        corners in prop::collection::vec(index(), 0..3),
        triangles in prop::collection::vec([0u32..4, 0u32..4, 0u32..4], 0..2),
    ) -> Body {
        let corner = |particle| Corner { particle: particle as u32, uv: [0.0; 2] };
        let corners = corners.into_iter().map(corner).collect();
        let surface = Surface { corners, triangles, two_sided: true };
        Body { name: "body".into(), particles: start..end, springs: 0..springs, surface }
    }
}

prop_compose! {
    fn world()(
        gravity in vector(),
        force in vector(),
        drag in usual(),
        extent in prop_oneof![9 => Just(1e6), 1 => usual()],
    ) -> World {
        World { gravity, force, drag, extent }
    }
}

fn any_scene() -> impl Strategy<Value = Scene> {
    let pin = (index(), vector()).prop_map(|(particle, velocity)| Pin { particle, velocity });
    let world = prop_oneof![Just(World::default()), world()];
    let particles = prop_oneof![
        20 => prop::collection::vec(particle(), 6),
        1 => prop::collection::vec(particle(), 0..6)
    ];
    let rows = (particles, prop::collection::vec(spring(), 0..6));
    let plane = prop::collection::vec(plane(), 0..3);
    let few = (prop::collection::vec(pin, 0..2), prop::option::weighted(0.2, body()));
    (world, rows, plane, few).prop_map(|(world, (particles, springs), planes, (pins, body))| {
        Scene { world, particles, springs, planes, pins, bodies: body.into_iter().collect() }
    })
}

fn any_settings() -> impl Strategy<Value = Settings> {
    let step = prop_oneof![4 => Just(1.0 / 60.0), 4 => decade(), 1 => any_number()];
    let tolerance = prop_oneof![8 => Just(1e-4), 1 => any_number()];
    let integrator = prop::sample::select(Integrator::ALL.to_vec());
    let count = || prop_oneof![20 => 1u32..4, 1 => Just(0)];
    (integrator, step, count(), tolerance, count()).prop_map(
        |(integrator, step, substeps, tolerance, newton)| Settings {
            integrator,
            step,
            substeps,
            tolerance,
            newton,
        },
    )
}

fn select() -> impl Strategy<Value = Select> {
    prop_oneof![
        Just(Select::All),
        (0usize..2).prop_map(Select::Body),
        index().prop_map(Select::One),
        (index(), index()).prop_map(|(start, end)| Select::Range(start, end)),
    ]
}

fn any_interaction() -> impl Strategy<Value = Interaction> {
    use Interaction::*;
    let one = || (index(), prop_oneof![vector(), any_vector()]);
    let of = || (select(), usual());
    let grab = (one(), usual(), usual(), prop_oneof![Just(f64::MAX), any_number()]).prop_map(
        |((particle, target), frequency, damping_ratio, max_force)| Grab {
            particle,
            target,
            frequency,
            damping_ratio,
            max_force,
        },
    );
    let plane = (index(), fraction(), friction()).prop_map(|(plane, restitution, friction)| {
        SetPlane { plane: plane % 3, restitution, friction }
    });
    let single = prop_oneof![
        3 => grab,
        1 => index().prop_map(|particle| Release { particle }),
        1 => one().prop_map(|(particle, velocity)| Pin { particle, velocity }),
        1 => index().prop_map(|particle| Unpin { particle }),
        1 => one().prop_map(|(particle, force)| Push { particle, force }),
        1 => index().prop_map(|spring| Cut { spring }),
        1 => plane,
        1 => any_vector().prop_map(|value| SetGravity { value }),
    ];
    let many = prop_oneof![
        of().prop_map(|(springs, value)| SetStiffness { springs, value }),
        of().prop_map(|(springs, value)| SetDamping { springs, value }),
        of().prop_map(|(particles, value)| SetMass { particles, value }),
        of().prop_map(|(springs, value)| SetRestLength { springs, value }),
        of().prop_map(|(springs, factor)| ScaleRestLength { springs, factor }),
        select().prop_map(|springs| Freeze { springs }),
        (select(), any_vector()).prop_map(|(particles, impulse)| Impulse { particles, impulse }),
        (select(), any_vector()).prop_map(|(particles, velocity)| Spin { particles, velocity }),
    ];
    prop_oneof![single, many]
}

/// Runs a scene with an interaction before each step.
fn runs_on_finite_numbers_or_stops<R: Real>(
    scene: &Scene,
    settings: Settings,
    interactions: &[Interaction],
) {
    let Ok(mut simulation) = Simulation::<R>::new(scene, settings) else { return };
    check_state(&simulation);
    for &interaction in interactions {
        let queued = simulation.queued().len();
        if simulation.queue(interaction).is_err() {
            assert_eq!(simulation.queued().len(), queued, "{interaction:?} was refused");
        }
        let before = simulation.state().positions;
        match simulation.step() {
            Ok(()) => (),
            Err(error) if error.is_of_step() => {
                assert_eq!(simulation.state().positions, before, "the last good state is kept");
                // Or the next step would fail as well.
                simulation.clear_queue();
            }
            Err(error) => panic!("{error}"),
        }
        check_state(&simulation);
        // One that gives up takes a million substeps to do so.
        if simulation.work().is_some_and(|work| 10_000 < work.evaluations) {
            break;
        }
    }
}

fn check_state<R: Real>(simulation: &Simulation<R>) {
    let extent = simulation.model().extent();
    for (position, velocity) in simulation.positions().zip(simulation.velocities()) {
        // A comparison that a NaN fails.
        assert!(position.extent() <= extent, "{position:?} is outside of {extent}");
        assert!(velocity.to_f64().is_finite(), "{velocity:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]
    #[test]
    fn any_scene_is_refused_or_stays_finite_or_stops(
        scene in any_scene(),
        settings in any_settings(),
        interactions in prop::collection::vec(any_interaction(), 1..12),
    ) {
        // An adaptive method out of its depth tries for seconds; see the test below.
        prop_assume!(!settings.integrator.is_adaptive());
        runs_on_finite_numbers_or_stops::<f32>(&scene, settings, &interactions);
        runs_on_finite_numbers_or_stops::<f64>(&scene, settings, &interactions);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn any_scene_under_an_adaptive_method_is_refused_or_stays_finite_or_stops(
        scene in any_scene(),
        interactions in prop::collection::vec(any_interaction(), 1..6),
    ) {
        let (step, tolerance) = (1e-6, 1e-3);
        let integrator = Integrator::DormandPrince;
        let settings = Settings { integrator, step, tolerance, ..Settings::default() };
        runs_on_finite_numbers_or_stops::<f32>(&scene, settings, &interactions);
        runs_on_finite_numbers_or_stops::<f64>(&scene, settings, &interactions);
    }
}

#[test]
fn a_fair_share_of_the_scenes_is_valid() {
    let mut lot = TestRunner::deterministic();
    let mut draw = || any_scene().new_tree(&mut lot).expect("a scene").current();
    let mut is_valid = |_: &usize| Simulation::<f32>::new(&draw(), Settings::default()).is_ok();
    let valid = (0..400).filter(|row| is_valid(row)).count();
    // A test of refusals alone would pass whatever a step does, one of valid scenes alone whatever
    // the checks let in.
    assert!((80..320).contains(&valid), "{valid} of 400");
}
