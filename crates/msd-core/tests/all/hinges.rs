//! Bends between two triangles that may be curved at rest: shells, against plates.

use crate::common::{Random, weightless};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Bend, Integrator, Interaction, Part, Particle, Scene, Settings, Simulation, Spring, State,
    testing,
};
use proptest::prelude::*;
use std::collections::BTreeMap;

const EDGE: f64 = 0.01;
const BENDING: f64 = 1e-5;

/// A flat patch of rows of triangles: equilateral, or half squares whose diagonals all go one way.
struct Patch {
    points: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Patch {
    fn new([rows, columns]: [usize; 2], is_equilateral: bool) -> Self {
        let (shift, height) = if is_equilateral { (0.5, 0.75f64.sqrt()) } else { (0.0, 1.0) };
        let point = |number: usize| {
            let (row, column) = ((number / columns) as f64, (number % columns) as f64);
            DVec3::new(column + shift * row, height * row, 0.0) * EDGE
        };
        let mut triangles = Vec::new();
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let [a, b] = [row * columns + column, (row + 1) * columns + column];
                // The shorter diagonal of sheared rows, that along (1, 1) of straight ones.
                match is_equilateral {
                    true => triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]),
                    false => triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]),
                }
            }
        }
        Patch { points: (0..rows * columns).map(point).collect(), triangles }
    }

    /// The pairs of triangles with a common edge: its ends, and the corners opposite.
    fn pairs(&self) -> Vec<[usize; 4]> {
        let mut sides: BTreeMap<[usize; 2], Vec<([usize; 2], usize)>> = BTreeMap::new();
        for corners in &self.triangles {
            for turn in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|corner| corners[(corner + turn) % 3]);
                sides.entry([a.min(b), a.max(b)]).or_default().push(([a, b], c));
            }
        }
        let pair = |sides: &Vec<([usize; 2], usize)>| match sides[..] {
            [([a, b], c), (_, d)] => Some([a, b, c, d]),
            _ => None,
        };
        sides.values().filter_map(pair).collect()
    }

    /// Its hinges, where it is at rest rolled up to a cylinder.
    fn hinges(&self, roll: Roll) -> Vec<Bend> {
        let at = |[a, b, c, d]: [usize; 4]| [a, b, c, d].map(|end| roll.of(self.points[end]));
        let hinge = |pair| Bend::hinge(pair, at(pair), BENDING).expect("triangles");
        self.pairs().into_iter().map(hinge).collect()
    }

    /// A scene of it in free flight, with soft springs along its edges.
    fn scene(&self, roll: Roll, damping: f64) -> Scene {
        let particle =
            |&at: &DVec3| Particle { position: roll.of(at), velocity: DVec3::ZERO, mass: 1e-4 };
        let mut part =
            Part { particles: self.points.iter().map(particle).collect(), ..Part::default() };
        let mut edges: Vec<[usize; 2]> = Vec::new();
        for &[a, b, c] in &self.triangles {
            edges.extend([[a.min(b), a.max(b)], [b.min(c), b.max(c)], [a.min(c), a.max(c)]]);
        }
        edges.sort_unstable();
        edges.dedup();
        for ends in edges {
            let [a, b] = ends.map(|end| part.particles[end].position);
            let rest_length = a.distance(b);
            part.springs.push(Spring { ends, rest_length, stiffness: 1.0, damping: damping * 1.0 });
        }
        part.bends = self.hinges(roll);
        part.bends.iter_mut().for_each(|bend| bend.damping = damping * bend.stiffness);
        Scene { world: weightless(), ..Scene::of("shell", part) }
    }
}

/// The map that rolls a flat sheet up to a cylinder of a curvature along a direction in it.
#[derive(Clone, Copy)]
struct Roll {
    curvature: f64,
    angle: f64,
}

impl Roll {
    fn of(self, x: DVec3) -> DVec3 {
        let (sine, cosine) = self.angle.sin_cos();
        let (along, axis) = (DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0));
        if self.curvature == 0.0 {
            return x;
        }
        let turn = along.dot(x) * self.curvature;
        let around = along * turn.sin() + DVec3::Z * (1.0 - turn.cos());
        axis * axis.dot(x) + around / self.curvature
    }
}

/// A patch that is curved at rest, shaken and turning.
fn shaken(seed: u64, damping: f64) -> Scene {
    let roll = Roll { curvature: 40.0, angle: 0.4 };
    let mut scene = Patch::new([4, 5], seed.is_multiple_of(2)).scene(roll, damping);
    let mut random = Random(seed | 1);
    for particle in &mut scene.particles {
        let spin = DVec3::new(3.0, 1.0, -2.0).cross(particle.position);
        particle.velocity = DVec3::new(0.1, 0.2, -0.3) + spin + (random.vector() - 0.5) * 0.1;
        particle.position += (random.vector() - 0.5) * (0.3 * EDGE);
    }
    scene
}

fn simulation(scene: &Scene, integrator: Integrator, step: f64) -> Simulation<f64> {
    crate::common::simulation(scene, integrator, step)
}

/// The energy of the bends of a scene at positions, joules.
fn energy(hinges: &[Bend], positions: &[DVec3]) -> f64 {
    let mut scene = Scene { world: weightless(), bends: hinges.to_vec(), ..Scene::default() };
    let particle = |&position: &DVec3| Particle { position, velocity: DVec3::ZERO, mass: 1.0 };
    scene.particles = positions.iter().map(particle).collect();
    simulation(&scene, Integrator::Rk4, 0.01).energy().elastic
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn hinges_pass_every_check(seed in any::<u64>()) {
        let simulation = simulation(&shaken(seed, 0.01), Integrator::Rk4, 0.01);
        let (bends, state) = (simulation.model().bends(), simulation.state());
        prop_assert!(bends.rows().all(|bend| bend.rest != 0.0 || seed % 2 == 1));
        prop_assert!(bends.rows().filter(|bend| bend.rest != 0.0).count() > 10);
        prop_assert_eq!(testing::check_gradient(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_products(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_reaction(bends, &state), Ok(()));
        prop_assert_eq!(testing::check_rotation(bends, &state), Ok(()));
    }

    #[test]
    fn two_triangles_of_any_shape_are_at_rest_as_they_are_and_fold_by_their_stiffness(
        seed in any::<u64>(), fold in -2.5f64..2.5
    ) {
        // Corners on both sides of an edge along x, folded about it.
        let mut random = Random(seed | 1);
        let mut side = |sign: f64| {
            let [x, y] = [2.0 * random.unit() - 0.5, 0.2 + random.unit()];
            DVec3::new(x, sign * y, 0.0)
        };
        let (c, d) = (side(1.0), side(-1.0));
        let folded = |angle: f64| {
            let turned = DMat3::from_rotation_x(angle) * d;
            let at = [DVec3::ZERO, DVec3::X, c, turned];
            // Anywhere, in any direction.
            let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.3);
            at.map(|x| turn * x + DVec3::new(1.0, -2.0, 0.5))
        };
        let hinge = Bend::hinge([0, 1, 2, 3], folded(fold), BENDING).expect("triangles");
        let (area, small) = (0.5 * (c.y - d.y), 1e-4);
        let plate = 0.5 * BENDING * small * small / area;
        prop_assert!(energy(&[hinge], &folded(fold)) < 1e-20 * BENDING);
        let found = energy(&[hinge], &folded(fold + small)) / plate;
        // A fold of more than a right angle is softer, by the square of a cosine.
        let expected = (0.5 * fold).cos().powi(2).min(0.5) / 0.5;
        let expected = if fold.abs() < std::f64::consts::FRAC_PI_2 { 1.0 } else { expected };
        // Of second order in the small angle: its third derivative adds at most that by tan(θ/2).
        let room = 4.0 * small * (1.0 + (0.5 * fold).tan().abs());
        prop_assert!((found / expected - 1.0).abs() < room, "{fold}: {found}, not {expected}");
        // The same angle to the other side is another shape, of more energy.
        prop_assume!(0.1 < fold.abs());
        prop_assert!(1e3 * plate < energy(&[hinge], &folded(-fold)));
    }
}

#[test]
fn triangles_that_fold_through_each_other_keep_their_energy() {
    // Half of the angle at rest is 30°; each wing is 0.8 long, on an edge along x.
    let wing = |angle: f64| DVec3::new(0.5, 0.8 * angle.sin(), 0.8 * angle.cos());
    let shape = |angle: f64| [DVec3::ZERO, DVec3::X, wing(angle), wing(-angle)];
    // It stores 0.9 J at most, of the 3.7 J that move.
    let hinge = Bend::hinge([0, 1, 2, 3], shape(std::f64::consts::FRAC_PI_3), 0.5);
    let hinge = hinge.expect("triangles");
    let [shut, through] = [1e-6, -1e-6].map(|angle| energy(&[hinge], &shape(angle)));
    // It goes with the sine of the angle squared: by 1e-6 of itself.
    assert!((shut - through).abs() <= 1e-5 * shut, "{shut} and {through} J");
    let mut scene = Scene::default();
    scene.world.gravity = DVec3::ZERO;
    for position in shape(std::f64::consts::FRAC_PI_3) {
        scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass: 0.1 });
    }
    scene.particles[2].velocity = DVec3::new(0.0, -6.0, 1.0);
    scene.particles[3].velocity = DVec3::new(0.0, 6.0, 1.0);
    scene.bends.push(hinge);
    for ends in [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3]] {
        let [a, b] = ends.map(|end| scene.particles[end].position);
        let rest_length = a.distance(b);
        scene.springs.push(Spring { ends, rest_length, stiffness: 1e3, damping: 0.0 });
    }
    let mut run = simulation(&scene, Integrator::Rk4, 1e-4);
    let (before, mut crossed) = (run.energy(), false);
    for _ in 0..10_000 {
        run.step().expect("a stable step");
        crossed |= run.position(2).y < run.position(3).y;
        let off = run.energy().total() - before.total();
        // RK4 at a hundredth of its limit: 1e-6 and less.
        assert!(off.abs() <= 1e-5 * before.total(), "{off} of {} J", before.total());
    }
    assert!(crossed, "it folded through");
}

#[test]
fn the_damper_of_an_edge_that_shrinks_to_nothing_adds_no_energy() {
    // The ends of the edge pass each other at a distance of a thousandth of it.
    let at = [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.3, 0.7], [0.0, 0.3, -0.7]];
    let at = at.map(DVec3::from_array);
    let mut scene = Scene::default();
    scene.world.gravity = DVec3::ZERO;
    for position in at {
        scene.particles.push(Particle { position, velocity: DVec3::ZERO, mass: 0.1 });
    }
    scene.particles[0].velocity = DVec3::new(3.0, 0.0, 3e-3);
    scene.particles[1].velocity = DVec3::new(-3.0, 0.0, -3e-3);
    let hinge = Bend::hinge([0, 1, 2, 3], at, 1e-3).expect("triangles");
    scene.bends.push(Bend { damping: 0.05, ..hinge });
    let mut run = simulation(&scene, Integrator::VelocityVerlet, 1e-4);
    let (mut before, mut passed) = (run.energy().mechanical(), false);
    for _ in 0..10_000 {
        run.step().expect("a stable step");
        passed |= run.position(1).x < run.position(0).x;
        let now = run.energy().mechanical();
        assert!(now <= 1.0001 * before, "{now} J after {before} J");
        before = now;
    }
    assert!(passed, "its ends passed each other");
}

/// The energy per area about the middle of a patch that is bent from one cylinder to another, as a
/// part of that of a plate.
fn part_of_a_plate(is_equilateral: bool, angle: f64, [rest, bent]: [f64; 2]) -> f64 {
    let patch = Patch::new([9, 9], is_equilateral);
    let middle = 4 * 9 + 4;
    let hinges = patch.hinges(Roll { curvature: rest, angle });
    // Half of each edge that ends there: the particles inside are all alike.
    let around: Vec<Bend> =
        hinges.into_iter().filter(|bend| bend.particles[..2].contains(&middle)).collect();
    assert_eq!(around.len(), 6);
    let roll = Roll { curvature: bent, angle };
    let positions: Vec<DVec3> = patch.points.iter().map(|&x| roll.of(x)).collect();
    let area = EDGE * EDGE * if is_equilateral { 0.75f64.sqrt() } else { 1.0 };
    0.5 * energy(&around, &positions) / (0.5 * BENDING * (bent - rest).powi(2) * area)
}

#[test]
fn equilateral_triangles_bend_from_cylinder_to_cylinder_as_a_plate_in_any_direction() {
    for step in 0..12 {
        let angle = f64::from(step) * std::f64::consts::PI / 12.0;
        for curvatures in [[0.0, 2.0], [5.0, 7.0], [5.0, 0.0], [5.0, -5.0]] {
            let part = part_of_a_plate(true, angle, curvatures);
            // Turns of an edge of 0.05 at most: chords of arcs are short by the square of it.
            assert!((part - 1.0).abs() < 0.003, "{angle}, {curvatures:?}: {part}");
        }
    }
}

#[test]
fn half_squares_are_up_to_three_times_as_stiff_along_their_diagonals() {
    for step in 0..12 {
        let angle = f64::from(step) * std::f64::consts::PI / 12.0;
        let (sine, cosine) = angle.sin_cos();
        // Edges along the rows and columns turn by a (κ cos² + κ sin cos) and the like, diagonals
        // by √2 a κ sin cos; see `Bend::hinge` for the energy of that.
        let expected = (sine + cosine).powi(2) + 4.0 * (sine * cosine).powi(2);
        let part = part_of_a_plate(false, angle, [3.0, 5.0]);
        assert!((part - expected).abs() < 0.01, "{angle}: {part}, not {expected}");
    }
}

#[test]
fn shells_keep_momentum_and_the_balance_of_energy() {
    let scene = shaken(4, 2e-3);
    let mut simulation = simulation(&scene, Integrator::VelocityVerlet, 2e-5);
    let (momentum, energy) = (simulation.momentum(), simulation.energy());
    (0..4000).for_each(|_| simulation.step().expect("a stable step"));
    let now = simulation.momentum();
    // Roundings of 4000 steps add up like those of a walk.
    assert!((now.linear - momentum.linear).length() < 1e-12 * momentum.linear.length());
    assert!((now.angular - momentum.angular).length() < 1e-11 * momentum.angular.length());
    let drift = simulation.energy().total() - energy.total();
    let moving = energy.kinetic + energy.elastic;
    assert!(0.05 * moving < simulation.energy().dissipated, "dampers at work");
    assert!(drift.abs() < 1e-3 * moving, "{drift} of {moving} J");
}

#[test]
fn a_shell_that_turns_as_a_whole_is_not_braked() {
    let mut scene = Patch::new([4, 5], true).scene(Roll { curvature: 40.0, angle: 0.4 }, 1.0);
    for particle in &mut scene.particles {
        particle.velocity = DVec3::new(3.0, 1.0, -2.0).cross(particle.position);
    }
    let simulation = simulation(&scene, Integrator::Rk4, 1e-4);
    let (bends, state) = (simulation.model().bends(), simulation.state());
    let scale = bends.rows().map(|bend| bend.damping).fold(0.0, f64::max) * 4.0 * EDGE;
    for force in testing::forces(bends, &state) {
        assert!(force.length() < 1e-12 * scale, "{force}");
    }
}

#[test]
fn every_method_converges_with_hinges_by_its_order() {
    let scene = shaken(6, 1e-4);
    let time = 0.01;
    let run = |integrator, steps: usize| -> State<f64> {
        crate::common::run(&scene, integrator, time / steps as f64, steps)
    };
    let reference = run(Integrator::Rk4, 8000);
    for (integrator, order, steps) in [
        (Integrator::SymplecticEuler, 1, 1000),
        (Integrator::VelocityVerlet, 2, 500),
        (Integrator::Rk4, 4, 250),
        (Integrator::BackwardEuler, 1, 8000),
        (Integrator::ImplicitMidpoint, 2, 500),
        (Integrator::Xpbd, 1, 8000),
    ] {
        let errors = [steps, 2 * steps]
            .map(|steps| crate::common::distance(&run(integrator, steps), &reference));
        let ratio = errors[0] / errors[1] / f64::from(1 << order);
        assert!((ratio - 1.0).abs() < 0.15, "{integrator}: {errors:?}, {ratio}");
    }
}

#[test]
fn methods_for_stiff_scenes_bear_any_hinges() {
    for integrator in [Integrator::BackwardEuler, Integrator::ImplicitMidpoint, Integrator::Xpbd] {
        let mut scene = Patch::new([6, 7], true).scene(Roll { curvature: 40.0, angle: 0.4 }, 0.0);
        scene.bends.iter_mut().for_each(|row| row.stiffness *= 1e5);
        let mut random = Random(3);
        for particle in &mut scene.particles {
            particle.velocity = (random.vector() - 0.5) * 0.05;
        }
        // One iteration per substep does not do for the midpoint rule, which damps nothing.
        let newton = if integrator == Integrator::ImplicitMidpoint { 8 } else { 1 };
        let settings =
            Settings { integrator, newton, step: 1.0 / 60.0, substeps: 1, ..Settings::default() };
        let mut simulation = Simulation::<f64>::new(&scene, settings).expect("valid");
        (0..600).for_each(|_| simulation.step().unwrap_or_else(|e| panic!("{integrator}: {e}")));
        let far = simulation.positions().map(|x| x.length()).fold(0.0, f64::max);
        // It drifts by less than 0.025 m/s for 10 s.
        assert!(far < 0.4, "{integrator}: {far}");
    }
}

#[test]
fn a_resumed_run_with_hinges_has_the_same_bits_after_cuts() {
    for integrator in [Integrator::VelocityVerlet, Integrator::ImplicitMidpoint, Integrator::Xpbd] {
        let settings = Settings { integrator, step: 4e-4, substeps: 8, ..Settings::default() };
        let mut scene = shaken(8, 1e-4);
        // Triangles of any shape: their weights are rounded.
        scene.bends = scene
            .bends
            .iter()
            .filter_map(|bend| {
                let at = bend.particles.map(|particle| scene.particles[particle].position);
                Bend::hinge(bend.particles, at, BENDING)
                    .map(|hinge| Bend { damping: 1e-6, ..hinge })
            })
            .collect();
        let mut run = Simulation::<f32>::new(&scene, settings).expect("valid");
        let before = run.model().bends().count();
        for spring in [3, 9, 20] {
            run.queue(Interaction::Cut { spring }).expect("there");
        }
        (0..10).for_each(|_| run.step().expect("a stable step"));
        assert!(run.model().bends().count() < before);
        run.remove_particle(12).expect("there");
        assert!(run.model().bends().rows().all(|bend| !bend.particles.contains(&12)));
        (0..10).for_each(|_| run.step().expect("a stable step"));
        crate::common::check_resumed(run, integrator.name());
    }
}

#[test]
fn a_tangent_at_rest_outside_its_domain_is_refused_and_so_is_a_triangle_without_an_area() {
    let refused = |bend: Bend| {
        let mut scene = shaken(2, 0.0);
        scene.bends = vec![bend];
        Simulation::<f32>::new(&scene, Settings::default()).expect_err("a refusal").to_string()
    };
    let line = Bend::line([0, 1, 2], 1.0, 0.0);
    assert_eq!(
        refused(Bend { rest: 0.1, ..line }),
        "tangent at rest of bend 0 is 0.1; it must be 0 unless its four particles differ"
    );
    let twist = Bend::twist([0, 1, 2, 3], 1.0, 0.0);
    let message = refused(Bend { rest: f64::NAN, ..twist });
    assert_eq!(message, "tangent at rest of bend 0 is NaN; it must be finite");
    let flat = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X, DVec3::Y];
    assert_eq!(Bend::hinge([0, 1, 2, 3], flat, 1.0), None);
    assert_eq!(Bend::hinge([0, 1, 2, 3], [DVec3::Y; 4], 1.0), None);
}
