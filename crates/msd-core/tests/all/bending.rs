//! Bends: ropes and sheets that resist bending, against beams, plates and the elastica.

use crate::common::{Random, weightless};
use msd_core::glam::DVec3;
use msd_core::{
    Bend, Bending, Elasticity, Error, Instructions, Integrator, Interaction, Part, Pin, Real,
    Scene, Settings, Simulation, Spring, State, Substance, Vector, World, shape, testing,
};
use proptest::prelude::*;
use std::f64::consts::PI;

const SPACING: f64 = 0.01;
const WOVEN: Bending = Bending { warp: 3e-5, weft: 1e-5, bias: 1.6e-5 };

fn sheet(bending: Bending, relaxation_time: f64) -> Substance {
    let elasticity = Elasticity::Sheet { warp: 9.0, weft: 4.0, shear: 0.6, bending };
    Substance { elasticity, density: 0.2, relaxation_time }
}

/// A rope of a bending stiffness that does not stretch much.
fn rope(count: usize, spacing: f64, bending: f64) -> Part {
    let elasticity = Elasticity::Rope { stretch: 1e4 * bending, bending };
    let substance = Substance { elasticity, density: 0.1, relaxation_time: 0.0 };
    shape::body([1, count, 1], spacing, &substance).expect("a rope")
}

/// A sheet in free flight, shaken and turning.
fn shaken(size: [usize; 3], seed: u64, relaxation_time: f64) -> Scene {
    let mut part = shape::body(size, SPACING, &sheet(WOVEN, relaxation_time)).expect("a sheet");
    part.set_motion(DVec3::new(0.1, 0.2, -0.3), DVec3::new(3.0, 1.0, -2.0));
    let mut random = Random(seed | 1);
    for particle in &mut part.particles {
        particle.position += (random.vector() - 0.5) * (0.3 * SPACING);
        particle.velocity += (random.vector() - 0.5) * 0.1;
    }
    Scene { world: weightless(), ..Scene::of("sheet", part) }
}

fn simulation(scene: &Scene, integrator: Integrator, step: f64) -> Simulation<f64> {
    let settings = Settings { integrator, step, substeps: 1, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn bends_pass_every_check(seed in any::<u64>()) {
        let simulation = simulation(&shaken([4, 5, 1], seed, 0.01), Integrator::Rk4, 0.01);
        let (bends, state) = (simulation.model().bends(), simulation.state());
        // Three rows of lines along columns and four along rows, and a twist in each cell.
        prop_assert_eq!(bends.count(), 2 * 5 + 4 * 3 + 3 * 4);
        prop_assert_eq!(testing::check_gradient(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_products(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_reaction(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_rotation(bends, &state), Ok(()));
    }
}

/// The forces of bends one by one, in their order.
fn plain_forces<R: Real>(simulation: &Simulation<R>) -> Vec<R::Vec3> {
    let state = simulation.state();
    let mut forces = vec![R::Vec3::ZERO; state.positions.len()];
    for bend in simulation.model().bends().rows() {
        let weights = bend.weights.map(R::of);
        let sum = |column: &[R::Vec3]| {
            let of = |end: usize| column[bend.particles[end]];
            let mut sum = R::Vec3::ZERO;
            for end in (1..4).filter(|&end| weights[end] != R::ZERO) {
                sum += (of(end) - of(0)) * weights[end];
            }
            sum
        };
        let (bent, rate) = (sum(&state.positions), sum(&state.velocities));
        let (square, along) = (bent.dot(bent), bent.dot(rate));
        let drag = along * R::of(bend.damping) * (R::ONE / square);
        let drag = if R::SHORTEST_SQUARED <= square { drag } else { R::ZERO };
        let pull = bent * (R::of(bend.stiffness) + drag);
        for end in (0..4).filter(|&end| weights[end] != R::ZERO) {
            forces[bend.particles[end]] -= pull * weights[end];
        }
    }
    forces
}

fn packs_are_plain<R: Real>(scene: &Scene) {
    let mut simulation = Simulation::<R>::new(scene, Settings::default()).expect("valid");
    let plain = plain_forces(&simulation);
    for instructions in Instructions::ALL.into_iter().filter(|&set| set <= Instructions::best()) {
        simulation.set_instructions(instructions);
        let (forces, _) = simulation.forces();
        assert_eq!(
            crate::common::bits::<R>(&forces),
            crate::common::bits::<R>(&plain),
            "{instructions:?}"
        );
    }
}

#[test]
fn sixteen_bends_at_a_time_have_the_bits_of_one_by_one_with_all_instructions() {
    // 35 x 30 particles: lines along rows cross from one lane to the next for six in seven.
    let sizes = [[35, 30, 1], [3, 90, 1], [16, 20, 1], [16, 16, 1]];
    for (size, damping) in sizes.into_iter().flat_map(|size| [(size, 0.0), (size, 0.01)]) {
        let mut scene = shaken(size, 7, damping);
        // Springs that pull nothing keep their order of the particles.
        scene.springs.iter_mut().for_each(|row| (row.stiffness, row.damping) = (0.0, 0.0));
        packs_are_plain::<f32>(&scene);
        packs_are_plain::<f64>(&scene);
    }
}

/// A sheet rolled up by a curvature about an axis in it that is turned from the rows.
fn roll(part: &mut Part, curvature: f64, angle: f64) {
    let (along, axis) =
        (DVec3::new(angle.sin(), angle.cos(), 0.0), DVec3::new(angle.cos(), -angle.sin(), 0.0));
    for particle in &mut part.particles {
        let x = particle.position;
        let turn = along.dot(x) * curvature;
        let around = along * turn.sin() + DVec3::Z * (1.0 - turn.cos());
        particle.position = axis * axis.dot(x) + around * (1.0 / curvature);
    }
}

#[test]
fn a_cylinder_stores_half_its_stiffness_times_curvature_squared_by_direction() {
    let [rows, columns] = [13, 17];
    let area = SPACING * SPACING;
    // The area for which the lines along rows, along columns and the cells stand. There is no bend
    // about the free ends of a line, which have no moment either.
    let areas =
        [(rows - 2) * (columns - 1), (rows - 1) * (columns - 2), (rows - 1) * (columns - 1)]
            .map(|count| f64::from(count) * area);
    let Bending { warp, weft, bias } = WOVEN;
    let twist = bias - 0.25 * (warp + weft);
    for angle in [0.0, 0.125 * PI, 0.25 * PI, 0.5 * PI] {
        let (s, c) = angle.sin_cos();
        let errors = [0.2, 0.1].map(|turn: f64| {
            let size = [rows as usize, columns as usize, 1];
            let mut part = shape::body(size, SPACING, &sheet(WOVEN, 0.0)).expect("a sheet");
            let curvature = turn / SPACING;
            roll(&mut part, curvature, angle);
            part.springs.clear();
            let scene = Scene { world: weightless(), ..Scene::of("sheet", part) };
            let energy = simulation(&scene, Integrator::Rk4, 0.01).energy().elastic;
            let stiffness = warp * c.powi(4) * areas[0]
                + weft * s.powi(4) * areas[1]
                + 4.0 * twist * (s * c).powi(2) * areas[2];
            energy / (0.5 * stiffness * curvature * curvature) - 1.0
        });
        // On a circle s is R (2 − 2 cos θ), so that s² is short by θ²/6: 0.7 % at 0.2.
        assert!(errors[0].abs() < 0.0068, "{angle}: {errors:?}");
        assert!((errors[0] / errors[1] - 4.0).abs() < 0.1, "{angle}: {errors:?}");
    }
    // On the bias a square has the stiffness of the bias.
    assert!((4.0 * twist * 0.25 + 0.25 * (warp + weft) - bias).abs() < 1e-12 * bias);
}

#[test]
fn an_isotropic_plate_bends_alike_in_all_directions_by_the_formula() {
    let (young, thickness) = (2e6, 1e-3);
    let Elasticity::Sheet { bending, .. } = Elasticity::sheet(young, thickness) else {
        panic!("a sheet")
    };
    let plate = young * thickness.powi(3) / (12.0 * (1.0 - 1.0 / 9.0));
    for value in [bending.warp, bending.weft, bending.bias] {
        assert!((value / plate - 1.0).abs() < 1e-14);
    }
    let diameter: f64 = 3e-3;
    let Elasticity::Rope { stretch, bending } = Elasticity::rope(young, diameter) else {
        panic!("a rope")
    };
    assert!((stretch / (young * 0.25 * PI * diameter.powi(2)) - 1.0).abs() < 1e-14);
    assert!((bending / (young * PI / 64.0 * diameter.powi(4)) - 1.0).abs() < 1e-14);
}

/// A scene whose particles near its left end, at most so far from it, are pinned.
fn clamped(part: Part, reach: f64, gravity: f64) -> Scene {
    let left = part.particles.iter().map(|row| row.position.x).fold(f64::INFINITY, f64::min);
    let is_held = |particle: &usize| part.particles[*particle].position.x < left + reach;
    let held: Vec<usize> = (0..part.particles.len()).filter(is_held).collect();
    let world = World { gravity: DVec3::new(0.0, 0.0, -gravity), ..World::default() };
    let pin = |particle| Pin { particle, velocity: DVec3::ZERO };
    Scene { world, pins: held.into_iter().map(pin).collect(), ..Scene::of("strip", part) }
}

/// Lets a scene come to rest: backward Euler at steps far beyond its periods takes all motion.
fn at_rest(scene: &Scene, step: f64) -> Vec<DVec3> {
    let settings = Settings {
        integrator: Integrator::BackwardEuler,
        step,
        substeps: 1,
        newton: 4,
        ..Settings::default()
    };
    let mut simulation = Simulation::<f64>::new(scene, settings).expect("a valid scene");
    for _ in 0..2000 {
        simulation.step().expect("a solved step");
        let speed = simulation.velocities().map(|v| v.length()).fold(0.0, f64::max);
        if speed * step < 1e-7 * simulation.model().size() {
            return simulation.positions().collect();
        }
    }
    panic!("still moving");
}

#[test]
fn a_clamped_rope_sags_by_its_weight_over_its_bending_stiffness_of_second_order() {
    let (length, bending, gravity) = (0.5, 1e-3, 1e-3);
    let errors = [12, 24, 48].map(|count: usize| {
        let spacing = length / (count as f64 - 1.5);
        let positions =
            at_rest(&clamped(rope(count, spacing, bending), 1.5 * spacing, gravity), 10.0);
        let sag = -positions[count - 1].z;
        sag / (0.1 * gravity * length.powi(4) / (8.0 * bending)) - 1.0
    });
    assert!(errors[2].abs() < 2e-3, "{errors:?}");
    for pair in errors.windows(2) {
        // Of fourth order 16 % of the remainder at 12 particles.
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.7, "{errors:?}");
    }
}

/// Angle below the horizontal of the line from clamp to tip, degrees, of a strip along x that is
/// clamped in the middle of its first two particles.
fn tip_angle(part: Part, gravity: f64) -> f64 {
    let left = part.particles.iter().map(|row| row.position.x).fold(f64::INFINITY, f64::min);
    let positions = at_rest(&clamped(part, 1.5 * SPACING, gravity), 3.0);
    let tip = positions.iter().map(|x| x.x).fold(f64::NEG_INFINITY, f64::max);
    let end: Vec<&DVec3> = positions.iter().filter(|x| tip - 0.1 * SPACING < x.x).collect();
    let depth = -end.iter().map(|x| x.z).sum::<f64>() / end.len() as f64;
    (depth / (tip - left - 0.5 * SPACING)).atan().to_degrees()
}

#[test]
fn the_cantilever_test_of_fabrics_returns_the_bending_stiffness() {
    // ASTM D1388: where the tip hangs 41.5 degrees down, the bending length c is half of the
    // overhang, and B = w c³ by the weight w per area. The elastica agrees within 0.1 %.
    let (columns, rows) = (22, 5);
    let overhang = (columns as f64 - 1.5) * SPACING;
    for (bending, size) in [(WOVEN.weft, [rows, columns, 1]), (WOVEN.warp, [columns, rows, 1])] {
        let part = || {
            let mut part = shape::body(size, SPACING, &sheet(WOVEN, 0.0)).expect("a strip");
            if size[0] == columns {
                let swap = |x: DVec3| DVec3::new(x.y, x.x, x.z);
                part.particles.iter_mut().for_each(|row| row.position = swap(row.position));
            }
            part
        };
        let (mut low, mut high) = (0.0, 4.0 * bending / (0.2 * (0.5 * overhang).powi(3)));
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            let is_steep = 41.5 < tip_angle(part(), middle);
            *(if is_steep { &mut high } else { &mut low }) = middle;
        }
        let measured = 0.2 * low * (0.5 * overhang).powi(3);
        println!("B = {bending:e} N m comes back as {measured:e} N m");
        assert!((measured / bending - 1.0).abs() < 0.03, "{measured} N m, not {bending} N m");
    }
}

/// A strip cut on the bias, its long side along x: the particles of a sheet that are near its
/// diagonal, and the elements that join them. Its ends are straight; the particles of the last one
/// stand for half of a column.
fn bias_strip(length: usize, half: usize, substance: &Substance) -> Part {
    let sheet = shape::body([length, length, 1], SPACING, substance).expect("a sheet");
    let column = |particle: usize| particle % length + particle / length;
    let last = 2 * (length - 1) - half;
    let is_in = |&particle: &usize| {
        let across = (particle % length).abs_diff(particle / length);
        across <= half && half <= column(particle) && column(particle) <= last
    };
    let kept: Vec<usize> = (0..length * length).filter(is_in).collect();
    let row = |particle: usize| kept.binary_search(&particle).ok();
    let turn = |x: DVec3| DVec3::new(x.x + x.y, x.y - x.x, 0.0) * 0.5f64.sqrt();
    let particle = |&particle: &usize| {
        let row = sheet.particles[particle];
        let share = if column(particle) == last { 0.5 } else { 1.0 };
        msd_core::Particle { position: turn(row.position), mass: share * row.mass, ..row }
    };
    let spring = |spring: &Spring| {
        let [a, b] = spring.ends.map(row);
        Some(Spring { ends: [a?, b?], ..*spring })
    };
    let bend = |bend: &Bend| {
        let [a, b, c, d] = bend.particles.map(row);
        Some(Bend { particles: [a?, b?, c?, d?], ..*bend })
    };
    Part {
        particles: kept.iter().map(particle).collect(),
        springs: sheet.springs.iter().filter_map(spring).collect(),
        bends: sheet.bends.iter().filter_map(bend).collect(),
        ..Part::default()
    }
}

#[test]
fn a_strip_on_the_bias_sags_more_by_the_ratio_of_the_stiffnesses() {
    // Softer on the bias than along the threads, as fabrics are. Its sides being free, the strip
    // curls across, which makes it softer still: with D11 = b, D12 = B − b and D22 = b on the bias,
    // D11 − D12²/D22. Near the clamp it cannot curl, which takes some 2 % of the sag.
    let (threads, bias) = (2e-5, 1.6e-5);
    let free = bias - (threads - bias) * (threads - bias) / bias;
    let substance = sheet(Bending { warp: threads, weft: threads, bias }, 0.0);
    let (gravity, half) = (2e-5, 3);
    let strip = bias_strip(40, half, &substance);
    let right = strip.particles.iter().map(|row| row.position.x).fold(0.0, f64::max);
    let step = SPACING * 0.5f64.sqrt();
    // Of each 2 half + 1 particles 2 half − 1 are in the middle of lines and cells.
    let share = (2 * half - 1) as f64 / (2 * half + 1) as f64;
    let positions = at_rest(&clamped(strip, 10.5 * step, gravity), 30.0);
    let tip = positions.iter().map(|x| x.x).fold(0.0, f64::max);
    let sag = -positions.iter().find(|x| x.x == tip).expect("a tip").z;
    let length = 2.0 * right - 9.5 * step;
    let expected = 0.2 * gravity * length.powi(4) / (8.0 * free * share);
    println!("sag {sag}, expected {expected}: {}", sag / expected);
    assert!((sag / expected - 1.0).abs() < 0.03, "{sag} m, not {expected} m");
}

#[test]
fn a_clamped_rope_swings_at_the_frequency_of_euler_and_bernoulli() {
    let (length, bending, density) = (0.5f64, 1e-3, 0.1);
    let root = 1.875_104_068_711_961;
    let expected = root * root * (bending / (density * length.powi(4))).sqrt();
    let errors = [20, 40].map(|count: usize| {
        let spacing = length / (count as f64 - 1.5);
        let mut scene = clamped(rope(count, spacing, bending), 1.5 * spacing, 0.0);
        let left = scene.particles[0].position.x + 0.5 * spacing;
        // The first mode of a clamped beam.
        let sigma = (root.cosh() + root.cos()) / (root.sinh() + root.sin());
        for row in &mut scene.particles {
            let x = root * (row.position.x - left).max(0.0) / length;
            row.position.z = 1e-5 * (x.cosh() - x.cos() - sigma * (x.sinh() - x.sin()));
        }
        let step = 2.0 * PI / expected / 16000.0;
        let mut simulation = simulation(&scene, Integrator::VelocityVerlet, step);
        let mut last = simulation.position(count - 1).z;
        let mut crossings = Vec::new();
        while crossings.len() < 9 {
            simulation.step().expect("a stable step");
            let now = simulation.position(count - 1).z;
            if last.signum() != now.signum() {
                crossings.push(simulation.time() - step * now / (now - last));
            }
            last = now;
        }
        let period = (crossings[8] - crossings[0]) / 4.0;
        2.0 * PI / period / expected - 1.0
    });
    println!("{errors:?}");
    assert!(errors[1].abs() < 0.001, "{errors:?}");
    assert!((errors[0] / errors[1] - 4.0).abs() < 0.7, "{errors:?}");
}

#[test]
fn bends_keep_momentum_and_the_balance_of_energy() {
    let scene = shaken([6, 7, 1], 3, 2e-4);
    let mut simulation = simulation(&scene, Integrator::VelocityVerlet, 4e-5);
    let (momentum, energy) = (simulation.momentum(), simulation.energy());
    assert!(0.0 < energy.elastic);
    (0..2000).for_each(|_| simulation.step().expect("a stable step"));
    let now = simulation.momentum();
    let scale = momentum.linear.length();
    // Roundings of 2000 steps add up like those of a walk.
    assert!((now.linear - momentum.linear).length() < 1e-12 * scale);
    assert!((now.angular - momentum.angular).length() < 1e-12 * momentum.angular.length());
    let moving = energy.kinetic + energy.elastic;
    let drift = simulation.energy().total() - energy.total();
    assert!(0.1 * moving < simulation.energy().dissipated, "dampers at work");
    // Of second order: (w h)² of the fastest motion is 0.01.
    assert!(drift.abs() < 1e-3 * moving, "{drift} of {moving} J");
}

/// The largest distance of positions from those of the finest run.
fn error(scene: &Scene, (integrator, steps): (Integrator, usize), reference: &State<f64>) -> f64 {
    let time = 0.02;
    let mut simulation = simulation(scene, integrator, time / steps as f64);
    (0..steps).for_each(|_| simulation.step().expect("a stable step"));
    crate::common::distance(&simulation.state(), reference)
}

#[test]
fn every_method_converges_with_bends_by_its_order() {
    // Springs so soft that bends decide. The damper of a bend turns quickly where that is all but
    // straight, which no method of fourth order follows.
    let [damped, free] = [1e-5, 0.0].map(|relaxation_time| {
        let mut scene = shaken([4, 9, 1], 5, relaxation_time);
        scene.bends.iter_mut().for_each(|row| {
            (row.stiffness, row.damping) = (30.0 * row.stiffness, 30.0 * row.damping);
        });
        let mut reference = simulation(&scene, Integrator::Rk4, 0.02 / 16000.0);
        (0..16000).for_each(|_| reference.step().expect("a stable step"));
        (scene, reference.state())
    });
    for (integrator, order, steps, (scene, reference)) in [
        (Integrator::SymplecticEuler, 1, 1000, &damped),
        (Integrator::VelocityVerlet, 2, 1000, &damped),
        (Integrator::Rk4, 4, 500, &free),
        (Integrator::BackwardEuler, 1, 32000, &damped),
        (Integrator::ImplicitMidpoint, 2, 1000, &damped),
        (Integrator::Xpbd, 1, 16000, &damped),
    ] {
        let errors = [steps, 2 * steps].map(|steps| error(scene, (integrator, steps), reference));
        let ratio = errors[0] / errors[1];
        let expected = f64::from(1 << order);
        assert!((ratio / expected - 1.0).abs() < 0.15, "{integrator}: {errors:?}, {ratio}");
    }
}

#[test]
fn methods_for_stiff_scenes_bear_any_bending() {
    for integrator in [Integrator::BackwardEuler, Integrator::ImplicitMidpoint, Integrator::Xpbd] {
        let mut scene = shaken([8, 9, 1], 11, 0.0);
        scene.bends.iter_mut().for_each(|row| row.stiffness *= 1e6);
        let mut simulation = simulation(&scene, integrator, 1.0 / 60.0);
        (0..600).for_each(|_| simulation.step().unwrap_or_else(|e| panic!("{integrator}: {e}")));
        let far = simulation.positions().map(|x| x.length()).fold(0.0, f64::max);
        // It drifts by 0.37 m/s for 10 s.
        assert!(far < 5.0, "{integrator}: {far}");
    }
}

#[test]
fn what_is_cut_or_removed_does_not_go_on_bending() {
    let scene = shaken([3, 5, 1], 1, 0.0);
    let settings = Settings { step: 1e-4, ..Settings::default() };
    let mut simulation = Simulation::<f64>::new(&scene, settings).expect("valid");
    let joined = |simulation: &Simulation<f64>, pair: [usize; 2]| {
        let rows = simulation.model().bends().rows();
        rows.filter(|bend| pair.iter().all(|end| bend.particles.contains(end))).count()
    };
    // From 6 to 7 in the middle row: two lines along it, and the twists above and below.
    assert_eq!(joined(&simulation, [6, 7]), 4);
    let spring = scene.springs.iter().position(|row| row.ends == [6, 7]).expect("a spring");
    let before = simulation.model().bends().count();
    simulation.queue(Interaction::Cut { spring }).expect("there");
    simulation.step().expect("a stable step");
    assert_eq!(joined(&simulation, [6, 7]), 0);
    assert_eq!(simulation.model().bends().count(), before - 4);
    simulation.remove_particle(0).expect("there");
    assert!(simulation.model().bends().rows().all(|bend| !bend.particles.contains(&0)));
    simulation.remove_spring(spring).expect("there");
    simulation.remove_body(0).expect("there");
    assert_eq!(simulation.model().bends().count(), 0);
}

#[test]
fn a_resumed_run_with_bends_has_the_same_bits_after_cuts_and_additions() {
    for integrator in [Integrator::VelocityVerlet, Integrator::ImplicitMidpoint, Integrator::Xpbd] {
        let scene = shaken([12, 9, 1], 9, 1e-4);
        let settings = Settings { integrator, step: 4e-4, substeps: 8, ..Settings::default() };
        let mut run = Simulation::<f32>::new(&scene, settings).expect("valid");
        for spring in [3, 30, 31, 77] {
            run.queue(Interaction::Cut { spring }).expect("there");
        }
        (0..10).for_each(|_| run.step().expect("a stable step"));
        let count = run.model().bends().count();
        let part = shape::body([5, 4, 1], SPACING, &sheet(WOVEN, 0.0)).expect("a sheet");
        let added = part.bends.len();
        run.add_body("other", part).expect("valid");
        assert_eq!(run.model().bends().count(), count + added);
        run.remove_particle(40).expect("there");
        (0..10).for_each(|_| run.step().expect("a stable step"));
        crate::common::check_resumed(run, integrator.name());
    }
}

#[test]
fn a_bend_outside_its_domain_is_refused_by_row_and_domain() {
    let refused = |bend: Bend| {
        let mut scene = shaken([3, 3, 1], 1, 0.0);
        scene.bends = vec![scene.bends[0], bend];
        Simulation::<f32>::new(&scene, Settings::default()).expect_err("a refusal").to_string()
    };
    let line = Bend::line([0, 1, 2], 1.0, 0.0);
    assert_eq!(
        refused(Bend { stiffness: -1.0, ..line }),
        "stiffness of bend 1 is -1; it must be finite and not negative"
    );
    assert!(refused(Bend { damping: f64::NAN, ..line }).contains("damping of bend 1"));
    assert_eq!(
        refused(Bend { weights: [1.0, -1.0, 1.0, 0.0], ..line }),
        "sum of the weights of bend 1 is 1; it must be 0"
    );
    assert!(refused(Bend { weights: [f64::INFINITY; 4], ..line }).contains("weight of bend 1"));
    assert!(refused(Bend::line([0, 1, 9], 1.0, 0.0)).contains("bend 1 names particle 9"));
    let refused = |bending| {
        let part = shape::body([3, 3, 1], SPACING, &sheet(bending, 0.0));
        let error = part.expect_err("a refusal");
        assert!(matches!(error, Error::OutOfDomain { .. }));
        error.to_string()
    };
    assert!(refused(Bending { warp: -1.0, ..WOVEN }).contains("bending of the warp"));
    assert!(refused(Bending { weft: f64::NAN, ..WOVEN }).contains("bending of the weft"));
    let stiff = Bending { bias: 0.9e-5, ..WOVEN };
    assert!(refused(stiff).contains("at least a quarter of the sum of the other two"));
}
