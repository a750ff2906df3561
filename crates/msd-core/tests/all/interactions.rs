//! Interactions: the effect of each, between steps and only there.

use crate::common::{simulation, two_masses, weightless};
use msd_core::glam::DVec3;
use msd_core::{
    Effects, Error, Integrator, Interaction, Look, Material, Model, Scene, Select, Settings,
    Simulation, shape,
};

const H: f64 = 1e-3;

fn pair() -> Simulation<f64> {
    simulation(&two_masses([1.0, 3.0], 50.0, 2.0, 0.0), Integrator::VelocityVerlet, H)
}

fn cubes() -> Simulation<f64> {
    let material = Material { mass: 2.0, stiffness: 100.0, damping: 1.0 };
    let mut scene = Scene { world: weightless(), ..Scene::default() };
    for (name, x) in [("left", -5.0), ("right", 5.0)] {
        let mut part = shape::block([2, 2, 2], 1.0, material).unwrap();
        part.place(msd_core::glam::DMat3::IDENTITY, DVec3::new(x, 0.0, 0.0));
        scene.add(name, part);
    }
    simulation(&scene, Integrator::VelocityVerlet, H)
}

fn apply<const N: usize>(simulation: &mut Simulation<f64>, interactions: [Interaction; N]) {
    for interaction in interactions {
        simulation.queue(interaction).unwrap();
    }
    simulation.step().unwrap();
}

fn grab(particle: usize, target: DVec3, frequency: f64) -> Interaction {
    let max_force = f64::MAX;
    Interaction::Grab { particle, target, frequency, damping_ratio: 1.0, max_force }
}

#[test]
fn a_grab_pulls_its_particle_to_the_target_and_release_lets_go() {
    let mut pair = pair();
    let target = DVec3::new(4.0, 0.0, 0.0);
    apply(&mut pair, [grab(1, target, 5.0)]);
    (0..20_000).for_each(|_| pair.step().unwrap());
    // The other end swings on with b / 2m = 1 per second: exp(−20) of 3 m is left.
    assert!((pair.position(1) - target).length() < 1e-6);
    apply(&mut pair, [Interaction::Release { particle: 1 }]);
    assert!(pair.model().grabs().is_empty());
}

#[test]
fn a_grab_has_the_stiffness_of_its_frequency_and_no_more_force_than_its_cap() {
    let mut pair = pair();
    let interaction = Interaction::Grab {
        particle: 1,
        target: DVec3::new(1000.0, 0.0, 0.0),
        frequency: 5.0,
        damping_ratio: 0.5,
        max_force: 12.0,
    };
    apply(&mut pair, [interaction]);
    let rate = std::f64::consts::TAU * 5.0;
    let held = pair.model().grabs()[0];
    assert!((held.stiffness - 3.0 * rate * rate).abs() < 1e-9);
    assert!((held.damping - 3.0 * rate).abs() < 1e-9);
    // One step of the capped force on 4 kg in all.
    let momentum = pair.momentum().linear;
    assert!((momentum - DVec3::new(12.0 * H, 0.0, 0.0)).length() < 1e-12);
}

#[test]
fn a_grab_cannot_blow_up_a_scene_however_stiff_it_is_asked_to_be() {
    let mut pair = pair();
    let interaction = Interaction::Grab {
        particle: 1,
        target: DVec3::new(2.0, 0.0, 0.0),
        frequency: 1e9,
        damping_ratio: 1e9,
        max_force: f64::MAX,
    };
    apply(&mut pair, [interaction]);
    (0..5000).for_each(|_| pair.step().unwrap());
    assert!(H < pair.stable_substep());
    // A longer substep weakens a grab that is active already.
    pair.set_settings(Settings { step: 20.0 * H, ..pair.settings() }).unwrap();
    (0..500).for_each(|_| pair.step().unwrap());
}

#[test]
fn pin_stops_a_particle_and_unpin_frees_it() {
    let mut pair = pair();
    let velocity = DVec3::ZERO;
    apply(&mut pair, [Interaction::Pin { particle: 0, velocity }]);
    let held = pair.position(0);
    let impulse = DVec3::new(9.0, 0.0, 0.0);
    apply(&mut pair, [Interaction::Impulse { particles: Select::All, impulse }]);
    (0..100).for_each(|_| pair.step().unwrap());
    assert_eq!(pair.position(0), held);
    assert!(1.0 < pair.velocity(1).x, "the free one took the whole impulse");
    apply(&mut pair, [Interaction::Unpin { particle: 0 }]);
    assert!(!pair.model().is_pinned(0));
    (0..100).for_each(|_| pair.step().unwrap());
    assert!(held.x < pair.position(0).x);
}

#[test]
fn a_push_lasts_one_step_without_dampers_too() {
    // Undamped, Verlet may reuse the accelerations of the step before.
    let scene = two_masses([1.0, 3.0], 50.0, 0.0, 0.0);
    let mut pair = simulation::<f64>(&scene, Integrator::VelocityVerlet, H);
    let force = DVec3::new(0.0, 8.0, 0.0);
    apply(&mut pair, [Interaction::Push { particle: 0, force }]);
    (0..10).for_each(|_| pair.step().unwrap());
    assert!((pair.momentum().linear - force * H).length() < 1e-12);
}

#[test]
fn an_older_state_does_not_set_a_pinned_particle_moving() {
    let mut pair = pair();
    let impulse = DVec3::new(0.0, 4.0, 0.0);
    apply(&mut pair, [Interaction::Impulse { particles: Select::All, impulse }]);
    let moving = pair.state();
    apply(&mut pair, [Interaction::Pin { particle: 0, velocity: DVec3::ZERO }]);
    pair.set_state(&moving, 1).unwrap();
    (0..10).for_each(|_| pair.step().unwrap());
    assert_eq!(pair.position(0), moving.positions[0]);
}

#[test]
fn an_interaction_that_blows_up_the_scene_is_undone_with_the_step() {
    let mut pair = pair();
    pair.step().unwrap();
    let before = pair.state();
    let impulse = DVec3::new(1e30, 0.0, 0.0);
    pair.queue(Interaction::Impulse { particles: Select::All, impulse }).unwrap();
    assert!(matches!(pair.step(), Err(Error::Diverged(_))));
    assert_eq!(pair.state(), before);
    pair.clear_queue();
    pair.step().unwrap();
}

#[test]
fn time_goes_on_when_the_step_changes() {
    let mut pair = pair();
    (0..10).for_each(|_| pair.step().unwrap());
    pair.set_settings(Settings { step: 2.0 * H, ..pair.settings() }).unwrap();
    pair.step().unwrap();
    assert!((pair.time() - 12.0 * H).abs() < 1e-15);
}

#[test]
fn a_push_lasts_one_step_and_an_impulse_is_at_once() {
    let mut pair = pair();
    let force = DVec3::new(0.0, 8.0, 0.0);
    apply(&mut pair, [Interaction::Push { particle: 0, force }]);
    (0..10).for_each(|_| pair.step().unwrap());
    assert!((pair.momentum().linear - force * H).length() < 1e-12);
    let impulse = DVec3::new(0.0, 0.0, 4.0);
    pair.queue(Interaction::Impulse { particles: Select::All, impulse }).unwrap();
    pair.apply_queued().unwrap();
    assert!((pair.momentum().linear - force * H - impulse).length() < 1e-12);
    // Shared by mass: both gain the same velocity.
    assert!((pair.velocity(0).z - pair.velocity(1).z).abs() < 1e-12);
}

#[test]
fn spin_adds_the_angular_momentum_of_a_rigid_turn_and_no_linear_momentum() {
    let mut cubes = cubes();
    let velocity = DVec3::new(0.0, 0.0, 2.0);
    cubes.queue(Interaction::Spin { particles: Select::Body(1), velocity }).unwrap();
    cubes.apply_queued().unwrap();
    let momentum = cubes.momentum();
    assert!(momentum.linear.length() < 1e-12);
    // Eight masses of 2 kg at √½ m from the axis: I = 8 kg m².
    assert!((momentum.angular - DVec3::new(0.0, 0.0, 16.0)).length() < 1e-12);
}

#[test]
fn setting_a_column_for_one_body_leaves_the_other_alone() {
    let mut cubes = cubes();
    let springs = Select::Body(1);
    apply(
        &mut cubes,
        [
            Interaction::SetStiffness { springs, value: 7.0 },
            Interaction::SetDamping { springs, value: 0.5 },
            Interaction::SetMass { particles: Select::Body(1), value: 9.0 },
            Interaction::ScaleRestLength { springs, factor: 2.0 },
            Interaction::SetRestLength { springs: Select::One(0), value: 0.25 },
        ],
    );
    let model = cubes.model();
    let (first, last) = (1, model.spring_count() - 1);
    assert_eq!([first, last].map(|s| model.stiffness(s)), [100.0, 7.0]);
    assert_eq!([first, last].map(|s| model.damping(s)), [1.0, 0.5]);
    assert_eq!([0, 15].map(|p| model.masses()[p]), [2.0, 9.0]);
    assert_eq!([0, 15].map(|p| model.inverse_masses()[p]), [0.5, 1.0 / 9.0]);
    assert_eq!(model.rest_lengths()[last], 2.0 * 3f64.sqrt());
    assert_eq!([0, 1].map(|s| model.rest_lengths()[s]), [0.25, 1.0]);
    apply(&mut cubes, [Interaction::SetStiffness { springs: Select::All, value: 7.0 }]);
    let model = cubes.model();
    assert!((0..model.ends().len()).all(|spring| model.stiffness(spring) == 7.0));
}

#[test]
fn freeze_makes_present_lengths_rest_lengths_and_takes_the_elastic_energy_away() {
    let mut pair =
        simulation::<f64>(&two_masses([1.0, 3.0], 50.0, 2.0, 0.3), Integrator::VelocityVerlet, H);
    assert!(1.0 < pair.energy().elastic);
    pair.queue(Interaction::Freeze { springs: Select::All }).unwrap();
    pair.apply_queued().unwrap();
    assert_eq!(pair.energy().elastic, 0.0);
    assert!((pair.model().rest_lengths()[0] - 1.3).abs() < 1e-15);
}

#[test]
fn cut_removes_a_spring_for_good_and_the_others_keep_their_numbers() {
    let mut cubes = cubes();
    let (count, bodies) = (cubes.model().spring_count(), cubes.model().bodies().to_vec());
    let ends = cubes.model().ends().to_vec();
    apply(
        &mut cubes,
        [
            Interaction::SetStiffness { springs: Select::One(4), value: 1.0 },
            Interaction::Cut { spring: 3 },
            Interaction::Cut { spring: 3 },
            Interaction::Cut { spring: count - 1 },
        ],
    );
    let model = cubes.model();
    assert_eq!(model.spring_count(), count - 2);
    assert_eq!((model.bodies(), model.ends()), (&bodies[..], &ends[..]));
    let cut = |&spring: &usize| model.is_cut(spring);
    assert_eq!((0..count).filter(cut).collect::<Vec<_>>(), [3, count - 1]);
    assert_eq!(model.stiffness(4), 1.0);
    // Stiffness brings no spring back.
    apply(&mut cubes, [Interaction::SetStiffness { springs: Select::All, value: 50.0 }]);
    assert_eq!(cubes.model().spring_count(), count - 2);
    let error = cubes.queue(Interaction::Cut { spring: count }).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    cubes.step().unwrap();
}

#[test]
fn an_interaction_changes_what_its_effects_say_and_nothing_else() {
    let (all, one) = (Select::All, Select::One(1));
    let (particle, velocity) = (0, DVec3::new(0.0, 3.0, 0.0));
    let friction = msd_core::Friction::Coulomb(0.5);
    let interactions = [
        grab(0, DVec3::Y, 5.0),
        Interaction::Release { particle: 9 },
        Interaction::Pin { particle, velocity },
        Interaction::Unpin { particle: 8 },
        Interaction::Push { particle, force: DVec3::X },
        Interaction::Cut { spring: 3 },
        Interaction::SetStiffness { springs: one, value: 7.0 },
        Interaction::SetDamping { springs: one, value: 7.0 },
        Interaction::SetMass { particles: all, value: 1e-3 },
        Interaction::SetRestLength { springs: one, value: 0.1 },
        Interaction::ScaleRestLength { springs: all, factor: 2.0 },
        Interaction::Freeze { springs: all },
        Interaction::Impulse { particles: all, impulse: DVec3::X },
        Interaction::Spin { particles: all, velocity },
        Interaction::SetGravity { value: DVec3::Z },
        Interaction::SetForce { value: DVec3::ONE },
        Interaction::SetPlane { plane: 0, restitution: 0.5, friction },
        Interaction::SetDrag { value: 0.5 },
        Interaction::RemovePlanes,
        Interaction::AddPlane {
            plane: msd_core::Plane { normal: DVec3::Y, offset: -7.0, restitution: 0.5, friction },
        },
    ];
    let mut scene = Scene::default();
    let material = Material { mass: 2.0, stiffness: 100.0, damping: 1.0 };
    scene.add("cube", shape::block([2, 2, 2], 1.0, material).unwrap());
    scene.add("rope", shape::rope(3, 1.0, material).unwrap());
    scene.particles.iter_mut().for_each(|particle| particle.position *= 1.1);
    let plane = msd_core::Plane { normal: DVec3::Y, offset: -9.0, restitution: 0.0, friction };
    (scene.planes, scene.pins) =
        (vec![plane], vec![msd_core::Pin { particle: 8, velocity: DVec3::ZERO }]);
    for interaction in interactions {
        let mut run = simulation::<f64>(&scene, Integrator::VelocityVerlet, H);
        // Strong enough for the cap of a lighter particle.
        apply(&mut run, [grab(9, DVec3::ZERO, 1e3)]);
        let (before, state) = (run.clone(), run.state());
        run.queue(interaction).unwrap();
        run.apply_queued().unwrap();
        let (now, was) = (run.model(), before.model());
        let springs = |model: &Model<f64>| {
            let there = (0..model.ends().len()).filter(|&spring| !model.is_cut(spring));
            let row = |spring: usize| {
                let rest = model.rest_lengths()[spring];
                (model.ends()[spring], rest, model.stiffness(spring), model.damping(spring))
            };
            there.map(row).collect::<Vec<_>>()
        };
        let masses = |model: &Model<f64>| [model.masses(), model.inverse_masses()].concat();
        let found = Effects {
            springs: springs(now) != springs(was),
            masses: masses(now) != masses(was),
            state: run.state() != state,
            energy: run.energy_at(&state) != before.energy_at(&state),
            grabs: now.grabs() != was.grabs(),
        };
        assert_eq!(found, interaction.effects(), "{interaction:?}");
    }
}

#[test]
fn gravity_and_planes_change_between_steps() {
    let mut scene = two_masses([1.0, 1.0], 50.0, 0.0, 0.0);
    let friction = msd_core::Friction::Coulomb(0.0);
    scene.planes =
        vec![msd_core::Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction }];
    let mut pair = simulation::<f64>(&scene, Integrator::VelocityVerlet, H);
    apply(
        &mut pair,
        [
            Interaction::SetGravity { value: DVec3::new(0.0, 2.0, 0.0) },
            Interaction::SetPlane { plane: 0, restitution: 0.25, friction },
        ],
    );
    assert!((pair.velocity(0).y - 2.0 * H).abs() < 1e-15);
    assert_eq!(pair.model().planes()[0].restitution(), 0.25);
}

#[test]
fn planes_come_and_go_and_drag_slows_a_fall_by_its_closed_form() {
    let mut scene = two_masses([1.0, 1.0], 0.0, 0.0, 0.0);
    let friction = msd_core::Friction::Coulomb(0.0);
    let plane = msd_core::Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    scene.planes = vec![plane];
    let value = DVec3::new(0.0, -2.0, 0.0);
    let mut pair = simulation::<f64>(&scene, Integrator::VelocityVerlet, H);
    apply(&mut pair, [Interaction::SetGravity { value }, Interaction::RemovePlanes]);
    assert!(pair.model().planes().is_empty());
    assert!((pair.velocity(0).y + 2.0 * H).abs() < 1e-15, "it falls where it stood");
    // The number of a plane that is gone by the time it is set names nothing.
    pair.queue(Interaction::AddPlane { plane }).unwrap();
    pair.queue(Interaction::RemovePlanes).unwrap();
    pair.queue(Interaction::AddPlane { plane }).unwrap();
    pair.apply_queued().unwrap();
    pair.queue(Interaction::RemovePlanes).unwrap();
    pair.queue(Interaction::SetPlane { plane: 0, restitution: 0.5, friction }).unwrap();
    pair.apply_queued().unwrap();
    assert!(pair.model().planes().is_empty());
    apply(&mut pair, [Interaction::AddPlane { plane }]);
    assert!(0.0 <= pair.position(0).y && pair.velocity(0).y == 0.0, "it is moved out and stopped");
    let mut falling = simulation::<f64>(&two_masses([1.0; 2], 0.0, 0.0, 0.0), Integrator::Rk4, H);
    let drag = 3.0;
    apply(&mut falling, [Interaction::SetGravity { value }, Interaction::SetDrag { value: drag }]);
    (1..200).for_each(|_| falling.step().unwrap());
    // v = -(m g / c)(1 - exp(-c t / m)); the local error of the fourth order is (c h)^5 / 120.
    let right = -(2.0 / drag) * -(-drag * falling.time()).exp_m1();
    let order = 200.0 * (drag * H).powi(5) / 120.0;
    assert!((falling.velocity(0).y - right).abs() <= order + 1e-12, "{right}");
    let bad = msd_core::Plane { normal: DVec3::ZERO, ..plane };
    assert!(pair.queue(Interaction::AddPlane { plane: bad }).is_err());
    assert!(pair.queue(Interaction::SetDrag { value: -1.0 }).is_err());
}

#[test]
fn a_uniform_force_accelerates_each_particle_by_its_own_mass_and_counts_as_energy() {
    let mut scene = two_masses([1.0, 4.0], 0.0, 0.0, 0.0);
    scene.world.gravity = DVec3::ZERO;
    let mut pair = simulation::<f64>(&scene, Integrator::VelocityVerlet, H);
    let before = pair.energy().total();
    let force = DVec3::new(0.0, 0.0, 2.0);
    apply(&mut pair, [Interaction::SetForce { value: force }]);
    assert_eq!(pair.model().force(), force);
    for (particle, mass) in [(0, 1.0), (1, 4.0)] {
        assert!((pair.velocity(particle).z - 2.0 / mass * H).abs() < 1e-15);
    }
    // Both start in the plane z = 0: they gain in speed the energy that they lose in the field.
    assert!((pair.energy().total() - before).abs() < 1e-15);
}

#[test]
fn an_interaction_out_of_its_domain_is_refused_and_changes_nothing() {
    let mut pair = pair();
    let before = pair.progress();
    let all = Select::All;
    let bad = [
        grab(2, DVec3::ZERO, 5.0),
        grab(0, DVec3::new(f64::NAN, 0.0, 0.0), 5.0),
        grab(0, DVec3::ZERO, -1.0),
        Interaction::Release { particle: 9 },
        Interaction::Unpin { particle: 9 },
        Interaction::Pin { particle: 0, velocity: DVec3::splat(f64::INFINITY) },
        Interaction::Push { particle: 7, force: DVec3::ZERO },
        Interaction::Cut { spring: 1 },
        Interaction::SetMass { particles: all, value: 0.0 },
        Interaction::SetMass { particles: Select::One(2), value: 1.0 },
        Interaction::SetStiffness { springs: all, value: -1.0 },
        Interaction::SetStiffness { springs: Select::Range(1, 0), value: 1.0 },
        Interaction::SetStiffness { springs: Select::Range(0, 2), value: 1.0 },
        Interaction::SetDamping { springs: Select::Body(0), value: 1.0 },
        Interaction::SetRestLength { springs: all, value: f64::NAN },
        Interaction::ScaleRestLength { springs: all, factor: 0.0 },
        Interaction::SetGravity { value: DVec3::splat(f64::NAN) },
        Interaction::SetForce { value: DVec3::splat(f64::INFINITY) },
        Interaction::SetPlane {
            plane: 0,
            restitution: 0.0,
            friction: msd_core::Friction::Coulomb(0.0),
        },
        Interaction::ScaleMaterial {
            bodies: Select::One(0),
            number: msd_core::MaterialNumber::Young,
            factor: 1.0,
        },
        Interaction::ScaleMaterial {
            bodies: all,
            number: msd_core::MaterialNumber::Density,
            factor: 0.0,
        },
        Interaction::SetRelaxationTime { bodies: Select::Body(0), value: 1.0 },
        Interaction::SetRelaxationTime { bodies: all, value: -1.0 },
        Interaction::SetLook { body: 0, look: Look::default() },
    ];
    for interaction in bad {
        let refused = pair.queue(interaction);
        assert!(refused.is_err(), "{interaction:?}");
    }
    pair.apply_queued().unwrap();
    assert_eq!(before, pair.progress());
}

#[test]
fn a_look_out_of_its_domain_is_refused_and_another_changes_the_body_alone() {
    let part = msd_core::shape::cloth([3, 3], 1.0, msd_core::Material::default()).unwrap();
    let scene = Scene::of("cloth", part);
    let mut cloth = Simulation::<f64>::new(&scene, Settings::default()).unwrap();
    let look = Look { roughness: 0.1, colour: Some([0.0, 0.5, 1.0]), ..Look::default() };
    for bad in [
        Look { roughness: 1.5, ..look },
        Look { translucency: f32::NAN, ..look },
        Look { pattern_size: -1.0, ..look },
        Look { colour: Some([0.0, 2.0, 0.0]), ..look },
        Look { back: Some([-0.5, 0.0, 0.0]), ..look },
    ] {
        assert!(cloth.queue(Interaction::SetLook { body: 0, look: bad }).is_err(), "{bad:?}");
    }
    assert!(cloth.queue(Interaction::SetLook { body: 1, look }).is_err());
    let (mut expected, progress) = cloth.progress();
    cloth.queue(Interaction::SetLook { body: 0, look }).unwrap();
    cloth.apply_queued().unwrap();
    expected.bodies[0].look = look;
    assert_eq!(cloth.progress(), (expected, progress));
}

#[test]
fn precision_changes_while_running_and_everything_else_stays() {
    let mut pair = pair();
    apply(
        &mut pair,
        [Interaction::SetStiffness { springs: Select::All, value: 64.0 }, grab(1, DVec3::X, 2.0)],
    );
    let single = pair.convert::<f32>().unwrap();
    assert_eq!(single.time(), pair.time());
    assert_eq!(single.model().stiffness(0), 64.0);
    assert_eq!(single.model().grabs().len(), 1);
    assert_eq!(single.settings(), pair.settings());
    let short = Settings { step: 1e-30, ..Settings::default() };
    pair.set_settings(short).unwrap();
    assert!(pair.convert::<f32>().is_err(), "1e-30 squared is no f32");
}

#[test]
fn a_velocity_that_overflows_is_refused_while_paused_too() {
    let mut pair = pair();
    let before = pair.state();
    let impulse = DVec3::splat(f64::MAX);
    pair.queue(Interaction::SetMass { particles: Select::All, value: 1e-3 }).unwrap();
    pair.queue(Interaction::Impulse { particles: Select::All, impulse }).unwrap();
    assert!(matches!(pair.apply_queued(), Err(Error::Diverged(_))));
    assert_eq!(pair.state(), before);
}

#[test]
fn a_pin_keeps_its_velocity_where_the_step_it_came_with_diverges() {
    let velocity = DVec3::new(0.5, 0.0, 0.0);
    for integrator in Integrator::ALL {
        // The force overflows, and even a pinned particle has a part of it: infinity times zero.
        let mut pair = simulation::<f64>(&two_masses([1.0; 2], 1e308, 0.0, 9.0), integrator, H);
        let pin = Interaction::Pin { particle: 0, velocity };
        pair.queue(pin).unwrap();
        if pair.step().is_err() {
            assert_eq!(pair.queued(), [pin], "{integrator}");
            pair.apply_queued().unwrap();
            assert!(pair.step().is_err());
            assert_eq!(pair.state().velocities, [velocity, DVec3::ZERO], "{integrator}");
        }
        assert_eq!(pair.velocity(0), velocity, "{integrator}");
    }
}

#[test]
fn a_step_that_fails_leaves_the_run_and_its_queue_as_they_were() {
    use Interaction::*;
    let (all, value) = (Select::All, DVec3::new(0.0, -3.0, 0.0));
    let queue = [
        Impulse { particles: all, impulse: DVec3::X },
        SetMass { particles: all, value: 2.0 },
        ScaleRestLength { springs: all, factor: 1.5 },
        Pin { particle: 0, velocity: DVec3::Y },
        grab(1, DVec3::new(4.0, 0.0, 0.0), 5.0),
        SetStiffness { springs: all, value: 900.0 },
        SetGravity { value },
        Push { particle: 1, force: DVec3::Z },
        Spin { particles: all, velocity: DVec3::Z },
    ];
    // Some change the model, some the grabs alone, and some the state alone.
    for queue in [&queue[..], &queue[4..5], &queue[6..7], &queue[7..]] {
        let (mut run, push) = (pair(), Push { particle: 0, force: DVec3::Y });
        run.queue(push).unwrap();
        run.apply_queued().unwrap();
        queue.iter().for_each(|&interaction| run.queue(interaction).unwrap());
        let mut never_failed = run.clone();
        let before = run.progress();
        let short = run.settings();
        run.set_settings(Settings { step: 1e6, substeps: 9, ..short }).unwrap();
        let long = run.progress();
        assert!(matches!(run.step(), Err(Error::Diverged(_))));
        assert!(run.progress() == long, "{queue:?}");
        run.set_settings(short).unwrap();
        assert!(run.progress() == before, "{queue:?}");
        run.step().unwrap();
        never_failed.step().unwrap();
        assert_eq!(run.state(), never_failed.state(), "{queue:?}");
        assert!(run.queued().is_empty());
    }
}

#[test]
fn a_grab_of_extreme_numbers_is_a_finite_spring() {
    let mut pair = pair();
    pair.queue(Interaction::SetMass { particles: Select::All, value: 1e307 }).unwrap();
    for (frequency, damping_ratio) in [(0.0, 1e300), (f64::MAX, 0.0), (1e300, 1e300)] {
        let (target, max_force) = (DVec3::ZERO, f64::MAX);
        let grab = Interaction::Grab { particle: 0, target, frequency, damping_ratio, max_force };
        pair.queue(grab).unwrap();
        pair.apply_queued().unwrap();
        let grab = pair.model().grabs()[0];
        assert!(grab.stiffness.is_finite() && grab.damping.is_finite(), "{grab:?}");
    }
}

#[test]
fn a_hand_that_moves_gives_the_bits_of_a_run_that_starts_at_every_step() {
    for integrator in Integrator::ALL {
        let run = |restarts: bool| {
            let mut cubes = cubes();
            cubes.set_settings(Settings { integrator, step: H, ..Settings::default() }).unwrap();
            for frame in 0..40 {
                let target = DVec3::new(0.1 * f64::from(frame), 1.0, 0.0);
                let hand = match frame {
                    0..5 => None,
                    5..30 => Some(grab(3, target, 5.0)),
                    _ => Some(Interaction::Release { particle: 3 }),
                };
                hand.into_iter().for_each(|hand| cubes.queue(hand).unwrap());
                cubes.apply_queued().unwrap();
                if restarts {
                    let state = cubes.state();
                    cubes.set_state(&state, cubes.steps()).unwrap();
                }
                cubes.step().unwrap();
            }
            cubes.state()
        };
        assert_eq!(run(false), run(true), "{integrator}");
    }
}
