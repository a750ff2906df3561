//! Volumes: blocks of any Poisson's ratio, against Hooke's law and closed forms of their volume.

use crate::common::{Random, weightless};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Elasticity, Friction, Instructions, Integrator, Interaction, Plane, Real, Scene, Settings,
    Simulation, State, Substance, Volume, World, shape, testing,
};
use proptest::prelude::*;

const SPACING: f64 = 0.01;
const YOUNG: f64 = 12_500.0;

fn solid(poisson: f64, relaxation_time: f64) -> Substance {
    let elasticity = Elasticity::Solid { young: YOUNG, poisson };
    Substance { elasticity, density: 1050.0, relaxation_time }
}

/// λ − μ.
fn modulus(poisson: f64) -> f64 {
    let mu = YOUNG / (2.0 * (1.0 + poisson));
    2.0 * mu * poisson / (1.0 - 2.0 * poisson) - mu
}

/// A block in free flight, shaken and turning.
fn shaken(size: [usize; 3], seed: u64, (poisson, relaxation_time): (f64, f64)) -> Scene {
    let mut part = shape::body(size, SPACING, &solid(poisson, relaxation_time)).expect("a block");
    part.set_motion(DVec3::new(0.1, 0.2, -0.3), DVec3::new(3.0, 1.0, -2.0));
    let mut random = Random(seed | 1);
    for particle in &mut part.particles {
        particle.position += (random.vector() - 0.5) * (0.2 * SPACING);
        particle.velocity += (random.vector() - 0.5) * 0.1;
    }
    Scene { world: weightless(), ..Scene::of("block", part) }
}

fn simulation(scene: &Scene, integrator: Integrator, step: f64) -> Simulation<f64> {
    let settings = Settings { integrator, step, substeps: 1, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

/// A scene of one cell of a block, with its volume and no springs, moved by a function.
fn cell(poisson: f64, move_to: impl Fn(DVec3) -> DVec3) -> Scene {
    let mut part = shape::body([2, 2, 2], SPACING, &solid(poisson, 0.0)).expect("a block");
    part.springs.clear();
    part.particles.iter_mut().for_each(|row| row.position = move_to(row.position));
    Scene { world: weightless(), ..Scene::of("cell", part) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn volumes_pass_every_check(seed in any::<u64>(), poisson in 0.0..0.45) {
        let scene = shaken([3, 4, 3], seed, (poisson, 0.01));
        let simulation = simulation(&scene, Integrator::Rk4, 0.01);
        let (volumes, state) = (simulation.model().volumes(), simulation.state());
        prop_assert_eq!(volumes.count(), 2 * 3 * 2);
        prop_assert_eq!(testing::check_gradient(volumes, &state), Ok(()));
        prop_assert_eq!(testing::check_products(volumes, &state), Ok(()));
        prop_assert_eq!(testing::check_reaction(volumes, &state), Ok(()));
        prop_assert_eq!(testing::check_rotation(volumes, &state), Ok(()));
    }

    #[test]
    fn what_a_cell_takes_away_its_springs_have_stored(
        stretches in prop::array::uniform3(-1.5..1.5),
        axis in prop::array::uniform3(-1.0..1.0),
        angle in 0.0..3.0,
    ) {
        // Poisson's ratio 0 takes most away.
        let mut part = shape::body([2, 2, 2], SPACING, &solid(0.0, 0.0)).expect("a block");
        let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X);
        let stretch = DMat3::from_diagonal(DVec3::from_array(stretches.map(f64::exp)));
        let deform = stretch * DMat3::from_axis_angle(axis, angle);
        part.particles.iter_mut().for_each(|row| row.position = deform * row.position);
        let mut scene = Scene { world: weightless(), ..Scene::of("cell", part) };
        let whole = simulation(&scene, Integrator::Rk4, 0.01).energy().elastic;
        scene.volumes.clear();
        let springs = simulation(&scene, Integrator::Rk4, 0.01).energy().elastic;
        prop_assert!(0.3 * springs <= whole, "{whole} of {springs} J");
    }

    #[test]
    fn damped_cells_take_no_motion_more_than_they_give(seed in any::<u64>()) {
        let scene = shaken([3, 3, 3], seed, (0.0, 0.01));
        let simulation = simulation(&scene, Integrator::Rk4, 0.01);
        let (_, power) = simulation.forces();
        prop_assert!(0.0 <= power, "{power} W");
    }
}

#[test]
fn the_volume_of_a_warped_cell_is_that_of_its_trilinear_map() {
    // Gauss's rule of 2 x 2 x 2 points is exact: the Jacobian is of degree 2 in each coordinate.
    let mut random = Random(5);
    for _ in 0..20 {
        let mut scene = cell(0.4, |x| x);
        scene.particles.iter_mut().for_each(|row| {
            row.position += (random.vector() - 0.5) * (0.6 * SPACING);
        });
        let at = |corner: usize| scene.particles[scene.volumes[0].particles[corner]].position;
        let points = [-1.0, 1.0].map(|side: f64| 0.5 + 0.5 * side / 3f64.sqrt());
        let mut volume = 0.0;
        for point in 0..8 {
            let place = [points[point & 1], points[point >> 1 & 1], points[point >> 2]];
            let mut map = [DVec3::ZERO; 3];
            for corner in 0..8 {
                let far = [corner & 1, corner >> 1 & 1, corner >> 2].map(|bit| bit == 1);
                let share = |axis: usize| if far[axis] { place[axis] } else { 1.0 - place[axis] };
                for axis in 0..3 {
                    let others: f64 = (0..3).filter(|&other| other != axis).map(share).product();
                    map[axis] += at(corner) * if far[axis] { others } else { -others };
                }
            }
            volume += map[0].cross(map[1]).dot(map[2]) / 8.0;
        }
        let energy = simulation(&scene, Integrator::Rk4, 0.01).energy().elastic;
        let rest = SPACING.powi(3);
        let expected = 0.5 * modulus(0.4) * rest * (volume / rest - 1.0).powi(2);
        assert!((energy / expected - 1.0).abs() < 1e-12, "{energy}, {expected}");
    }
}

#[test]
fn a_strained_cell_pulls_by_its_law_over_the_area_of_its_faces() {
    let deform = DMat3::from_cols_array(&[1.2, 0.1, 0.3, -0.2, 0.9, 0.2, 0.1, -0.3, 1.1]);
    let (ratio, rest) = (deform.determinant(), SPACING.powi(3));
    let e = ratio - 1.0;
    for poisson in [0.0, 0.1, 0.2, 0.3, 0.45] {
        let scene = cell(poisson, |x| deform * x);
        let simulation = simulation(&scene, Integrator::Rk4, 0.01);
        // Of a positive modulus e²/2; of a negative one (1 + e) e²/(2 q).
        let stored = |e: f64| {
            let q = 1.0 + 5.0 / 3.0 * e + 2.0 * e * e + e.powi(4) / 3.0;
            0.5 * e * e * if 0.25 < poisson { 1.0 } else { (1.0 + e) / q }
        };
        // By differences of fourth order: their error is 1e-13 and rounding 1e-12 of the slope.
        let difference = |by: f64| (stored(e + by) - stored(e - by)) / (2.0 * by);
        let tension = modulus(poisson) * (4.0 * difference(5e-4) - difference(1e-3)) / 3.0;
        let energy = modulus(poisson) * rest * stored(e);
        let stored = simulation.energy().elastic;
        assert!((stored / energy - 1.0).abs() < 1e-12, "{poisson}: {stored}, {energy}");
        // Nanson: areas turn and grow by J F⁻ᵀ; a corner has a quarter of three of them.
        let areas = deform.inverse().transpose() * ratio;
        let (forces, _) = simulation.forces();
        for (row, force) in cell(poisson, |x| x).particles.iter().zip(forces) {
            let expected = areas * row.position.signum() * (-0.25 * SPACING * SPACING * tension);
            assert!((force - expected).length() < 1e-11 * expected.length(), "{poisson}: {force}");
        }
    }
}

#[test]
fn no_shape_of_a_cell_stores_less_than_it_does_at_rest() {
    // From any shape downhill, by drag: the lowest is at rest, and 0. At Poisson's ratio 0 the
    // volume takes most away. Rounding is that of the energy at the start, some E a³.
    let mut random = Random(17);
    let scale = YOUNG * SPACING.powi(3);
    for poisson in [0.0, 0.1] {
        for _ in 0..60 {
            let mut part = shape::body([2, 2, 2], SPACING, &solid(poisson, 0.0)).expect("a block");
            for row in &mut part.particles {
                row.position = (random.vector() - 0.5) * (2.5 * SPACING);
            }
            let world = World { drag: 0.02, ..weightless() };
            let scene = Scene { world, ..Scene::of("cell", part) };
            let mut simulation = simulation(&scene, Integrator::SymplecticEuler, 1e-4);
            let mut least = f64::INFINITY;
            for _ in 0..3000 {
                simulation.step().expect("a stable step");
                least = least.min(simulation.energy().elastic);
            }
            assert!(-1e-12 * scale < least, "{poisson}: {least} of {scale} J");
        }
    }
}

#[test]
fn a_mirrored_cell_of_a_negative_modulus_resists_by_the_closed_form() {
    // Springs are as long as at rest; f(−2) = −2/11.
    for poisson in [0.0, 0.1, 0.2] {
        let scene = cell(poisson, |x| x * DVec3::new(-1.0, 1.0, 1.0));
        let energy = simulation(&scene, Integrator::Rk4, 0.01).energy().elastic;
        let expected = -2.0 / 11.0 * modulus(poisson) * SPACING.powi(3);
        assert!((energy / expected - 1.0).abs() < 1e-12, "{poisson}: {energy}, {expected}");
    }
}

#[test]
fn a_block_of_ratio_nought_that_falls_hard_has_no_negative_energy() {
    // 5 x 5 x 5 particles of 100 kPa from 30 cm on a corner: cells turn over on the way.
    let substance = Substance {
        elasticity: Elasticity::Solid { young: 1e5, poisson: 0.0 },
        density: 1000.0,
        relaxation_time: 2e-3,
    };
    let mut part = shape::body([5, 5, 5], 0.1, &substance).expect("a block");
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 0.3, 0.0).normalize(), 20f64.to_radians());
    for row in &mut part.particles {
        row.position = turn * row.position + DVec3::Y * 0.55;
    }
    let friction = Friction::Coulomb(0.4);
    let plane = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    let scene = Scene { planes: vec![plane], ..Scene::of("block", part) };
    let mut simulation = simulation(&scene, Integrator::VelocityVerlet, 1.0 / 3840.0);
    let start = simulation.energy().total();
    for _ in 0..3840 {
        simulation.step().expect("a stable step");
        let energy = simulation.energy();
        assert!(0.0 <= energy.elastic, "{} J", energy.elastic);
        // A tenth of the energy of the fall, m g 0.3 m: contact ends within a substep.
        assert!((energy.total() - start).abs() < 0.1 * 64.0 * 9.81 * 0.3, "{}", energy.total());
    }
}

#[test]
fn sixteen_cells_at_a_time_have_the_bits_of_one_by_one_with_all_instructions() {
    // With many bundles, full ones and others, and with none.
    for (size, poisson) in
        [([9, 8, 10], 0.4), ([9, 8, 10], 0.1), ([3, 3, 30], 0.4), ([2, 3, 3], 0.1)]
    {
        for relaxation_time in [0.0, 0.01] {
            let mut scene = shaken(size, 7, (poisson, relaxation_time));
            scene.springs.iter_mut().for_each(|row| (row.stiffness, row.damping) = (0.0, 0.0));
            let double = simulation(&scene, Integrator::Rk4, 0.01);
            let plain = testing::forces(double.model().volumes(), &double.state());
            bits_are_alike(double, Some(&plain));
            let single = Simulation::<f32>::new(&scene, Settings::default()).expect("valid");
            bits_are_alike(single, None);
        }
    }
}

/// Asserts that all instructions give the same forces, and those given.
fn bits_are_alike<R: Real>(mut simulation: Simulation<R>, plain: Option<&[R::Vec3]>) {
    simulation.set_instructions(Instructions::ALL[0]);
    let (first, _) = simulation.forces();
    let expected = crate::common::bits::<R>(plain.unwrap_or(&first));
    for instructions in Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best()) {
        simulation.set_instructions(instructions);
        let (forces, _) = simulation.forces();
        assert_eq!(crate::common::bits::<R>(&forces), expected, "{instructions:?}");
    }
}

#[test]
fn volumes_keep_momentum_and_the_balance_of_energy() {
    for poisson in [0.0, 0.45] {
        let scene = shaken([5, 4, 6], 3, (poisson, 2e-4));
        let mut simulation = simulation(&scene, Integrator::VelocityVerlet, 1e-4);
        let (momentum, energy) = (simulation.momentum(), simulation.energy());
        (0..2000).for_each(|_| simulation.step().expect("a stable step"));
        let now = simulation.momentum();
        // Roundings of 2000 steps add up like those of a walk.
        let linear = momentum.linear.length();
        assert!((now.linear - momentum.linear).length() < 1e-12 * linear);
        let angular = momentum.angular.length();
        assert!((now.angular - momentum.angular).length() < 1e-12 * angular);
        let moving = energy.kinetic + energy.elastic;
        let drift = simulation.energy().total() - energy.total();
        assert!(0.1 * moving < simulation.energy().dissipated, "dampers at work");
        // Of second order: (w h)² of the fastest motion is 0.03.
        assert!(drift.abs() < 3e-3 * moving, "{poisson}: {drift} of {moving} J");
    }
}

/// The largest distance of positions from those of the finest run.
fn error(scene: &Scene, (integrator, steps): (Integrator, usize), reference: &State<f64>) -> f64 {
    let mut simulation = simulation(scene, integrator, 0.02 / steps as f64);
    (0..steps).for_each(|_| simulation.step().expect("a stable step"));
    crate::common::distance(&simulation.state(), reference)
}

#[test]
fn every_method_converges_with_volumes_by_its_order() {
    for poisson in [0.05, 0.45] {
        let scene = shaken([3, 4, 3], 5, (poisson, 1e-4));
        let mut reference = simulation(&scene, Integrator::Rk4, 0.02 / 4000.0);
        (0..4000).for_each(|_| reference.step().expect("a stable step"));
        for (integrator, order, steps) in [
            (Integrator::SymplecticEuler, 1, 1000),
            (Integrator::VelocityVerlet, 2, 500),
            (Integrator::Rk4, 4, 250),
            (Integrator::BackwardEuler, 1, 4000),
            (Integrator::ImplicitMidpoint, 2, 500),
            (Integrator::Xpbd, 1, 4000),
        ] {
            let state = reference.state();
            let errors = [steps, 2 * steps].map(|steps| error(&scene, (integrator, steps), &state));
            let ratio = errors[0] / errors[1] / f64::from(1 << order);
            assert!((ratio - 1.0).abs() < 0.15, "{poisson}, {integrator}: {errors:?}, {ratio}");
        }
    }
}

#[test]
fn methods_that_damp_bear_any_volumes() {
    // The midpoint rule damps nothing by itself. It does not bear motions that it does not resolve,
    // as a volume is of third degree in positions.
    for integrator in [Integrator::BackwardEuler, Integrator::Xpbd] {
        for poisson in [0.0, 0.45] {
            let mut scene = shaken([4, 4, 5], 11, (poisson, 0.0));
            scene.springs.iter_mut().for_each(|row| row.stiffness *= 1e4);
            scene.volumes.iter_mut().for_each(|row| row.modulus *= 1e4);
            let mut simulation = simulation(&scene, integrator, 1.0 / 60.0);
            (0..600).for_each(|_| {
                simulation.step().unwrap_or_else(|e| panic!("{integrator}, {poisson}: {e}"));
            });
            let far = simulation.positions().map(|x| x.length()).fold(0.0, f64::max);
            // It drifts by 0.37 m/s for 10 s.
            assert!(far < 5.0, "{integrator}, {poisson}: {far}");
        }
    }
}

#[test]
fn what_is_cut_or_removed_does_not_keep_its_volume() {
    let scene = shaken([3, 3, 3], 1, (0.4, 0.0));
    let mut simulation = simulation(&scene, Integrator::VelocityVerlet, 1e-4);
    let of = |simulation: &Simulation<f64>, particle: usize| {
        simulation.model().volumes().rows().filter(|row| row.particles.contains(&particle)).count()
    };
    // The middle particle is a corner of all eight cells, the edge to its neighbour of four.
    assert_eq!(of(&simulation, 13), 8);
    let spring = scene.springs.iter().position(|row| row.ends == [13, 14]).expect("a spring");
    simulation.queue(Interaction::Cut { spring }).expect("there");
    simulation.step().expect("a stable step");
    assert_eq!([13, 14].map(|particle| of(&simulation, particle)), [4, 0]);
    simulation.remove_particle(0).expect("there");
    assert_eq!(of(&simulation, 13), 3);
    simulation.remove_spring(spring).expect("there");
    simulation.remove_body(0).expect("there");
    assert_eq!(simulation.model().volumes().count(), 0);
}

#[test]
fn a_resumed_run_with_volumes_has_the_same_bits_after_cuts_and_additions() {
    for integrator in [Integrator::VelocityVerlet, Integrator::ImplicitMidpoint, Integrator::Xpbd] {
        let scene = shaken([8, 7, 9], 9, (0.4, 1e-4));
        let settings = Settings { integrator, step: 4e-4, substeps: 4, ..Settings::default() };
        let mut run = Simulation::<f32>::new(&scene, settings).expect("valid");
        for spring in [3, 30, 31, 77] {
            run.queue(Interaction::Cut { spring }).expect("there");
        }
        (0..10).for_each(|_| run.step().expect("a stable step"));
        let count = run.model().volumes().count();
        assert!(count < 7 * 6 * 8);
        let part = shape::body([3, 4, 5], SPACING, &solid(0.1, 0.0)).expect("a block");
        run.add_body("other", part).expect("valid");
        assert_eq!(run.model().volumes().count(), count + 2 * 3 * 4);
        run.remove_particle(40).expect("there");
        (0..10).for_each(|_| run.step().expect("a stable step"));
        crate::common::check_resumed(run, integrator.name());
    }
}

#[test]
fn a_volume_outside_its_domain_is_refused_by_row_and_domain() {
    let refused = |change: &dyn Fn(&mut Volume)| {
        let mut scene = shaken([2, 2, 3], 1, (0.4, 0.0));
        change(&mut scene.volumes[1]);
        Simulation::<f32>::new(&scene, Settings::default()).expect_err("a refusal").to_string()
    };
    assert_eq!(
        refused(&|row| row.rest_volume = 0.0),
        "rest volume of volume 1 is 0; it must be between 1e-24 and 1e24"
    );
    assert!(refused(&|row| row.modulus = f64::NAN).contains("modulus of volume 1"));
    assert_eq!(
        refused(&|row| row.damping = -1.0),
        "damping of volume 1 is -1; it must be finite and of the sign of the modulus"
    );
    assert!(refused(&|row| row.particles[7] = 12).contains("volume 1 names particle 12"));
    for poisson in [-0.01, 0.46, 0.5, f64::NAN] {
        let error = shape::body([2, 2, 2], SPACING, &solid(poisson, 0.0)).expect_err("a refusal");
        assert!(error.to_string().contains("it must be 0 to 0.45"), "{error}");
    }
}

#[test]
fn a_block_of_a_quarter_is_made_of_springs_alone() {
    let part = shape::body([3, 3, 3], SPACING, &solid(0.25, 0.0)).expect("a block");
    assert!(part.volumes.is_empty());
    // As in the formulas: 8/15 E a inside.
    let inside = part.springs.iter().map(|row| row.stiffness).fold(0.0, f64::max);
    assert_eq!(inside, 8.0 / 15.0 * (YOUNG * SPACING));
}
