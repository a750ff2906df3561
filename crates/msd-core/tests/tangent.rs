//! Is the matrix of an implicit method the derivative of the forces?

mod common;

use common::{forces_at, random_scene, two_masses};
use msd_core::glam::DVec3;
use msd_core::tangent::Tangent;
use msd_core::{Interaction, Model, Scene, Settings, Simulation, Spring, State};

fn moved(state: &State<f64>, x: &[DVec3], (by_x, by_v): (f64, f64)) -> State<f64> {
    let add = |column: &[DVec3], by: f64| column.iter().zip(x).map(|(a, x)| *a + *x * by).collect();
    State { positions: add(&state.positions, by_x), velocities: add(&state.velocities, by_v) }
}

/// A x = M x − τ ∂f/∂v x − τ² ∂f/∂x x by central differences.
fn product_by_differences(
    model: &Model<f64>,
    state: &State<f64>,
    tau: f64,
    x: &[DVec3],
) -> Vec<DVec3> {
    let step = 1e-5;
    // Moving positions by τ and velocities by 1 times the step gives both derivatives at once.
    let ahead = forces_at(model, &moved(state, x, (tau * step, step)));
    let behind = forces_at(model, &moved(state, x, (-tau * step, -step)));
    let rows = model.masses().iter().zip(x).zip(ahead.iter().zip(&behind));
    rows.map(|((&m, &x), (&a, &b))| x * m - (a - b) * (tau / (2.0 * step))).collect()
}

fn product(model: &Model<f64>, state: &State<f64>, tau: f64, x: &[DVec3]) -> Vec<DVec3> {
    let mut tangent = Tangent::new(model);
    tangent.linearise(model, state.motion(), tau);
    let mut y = vec![DVec3::ZERO; x.len()];
    tangent.set_product(model.ends(), x, &mut y);
    y
}

fn directions(count: usize) -> Vec<DVec3> {
    let mut random = common::Random(7);
    (0..count).map(|_| random.vector() - 0.5).collect()
}

fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}

/// A random scene whose springs all pull.
fn stretched(seed: u64) -> Scene {
    let mut scene = random_scene(seed);
    let ends = |spring: &Spring| spring.ends.map(|end| scene.particles[end].position);
    let lengths: Vec<f64> =
        scene.springs.iter().map(|s| (ends(s)[1] - ends(s)[0]).length()).collect();
    for (spring, length) in scene.springs.iter_mut().zip(lengths) {
        spring.rest_length = 0.7 * length;
    }
    scene.world.drag = 0.3;
    scene
}

#[test]
fn the_matrix_is_the_derivative_of_the_forces() {
    let tau = 0.1;
    for seed in 0..20 {
        let mut scene = stretched(seed);
        // Dampers at rest: what is left out of the matrix is proportional to the relative speed.
        scene.particles.iter_mut().for_each(|particle| particle.velocity = DVec3::ONE);
        let mut simulation = Simulation::<f64>::new(&scene, Settings::default()).unwrap();
        let target = scene.particles[0].position + DVec3::X;
        let (frequency, damping_ratio) = (1.0, 0.5);
        let grab = |particle, max_force| Interaction::Grab {
            particle,
            target,
            frequency,
            damping_ratio,
            max_force,
        };
        simulation.queue(grab(0, 1e6)).unwrap();
        simulation.apply_queued().unwrap();
        let (model, state) = (simulation.model(), &simulation.state());
        let x = directions(model.particle_count());
        let exact = product_by_differences(model, state, tau, &x);
        // Central differences err by step² times third derivatives, some 1e-10 · k / length².
        let error = apart(&product(model, state, tau, &x), &exact);
        assert!(error < 1e-7, "seed {seed}: {error}");
    }
}

#[test]
fn a_grab_at_its_largest_force_is_a_constant_in_the_matrix() {
    let scene = two_masses([1.0, 1.0], 50.0, 0.0, 0.1);
    let mut simulation = Simulation::<f64>::new(&scene, Settings::default()).unwrap();
    let x = directions(2);
    let before = product(simulation.model(), &simulation.state(), 0.1, &x);
    let (particle, target, max_force) = (0, DVec3::Y * 100.0, 1.0);
    let (frequency, damping_ratio) = (2.0, 1.0);
    let grab = Interaction::Grab { particle, target, frequency, damping_ratio, max_force };
    simulation.queue(grab).unwrap();
    simulation.apply_queued().unwrap();
    assert_eq!(product(simulation.model(), &simulation.state(), 0.1, &x), before);
}

#[test]
fn a_moving_damper_is_the_derivative_along_its_spring() {
    // Ends that part or close up along the spring: nothing is left out but where it pushes.
    for (stretch, speed) in [(0.3, 2.0), (0.3, -0.5)] {
        let mut scene = two_masses([1.0, 3.0], 50.0, 4.0, stretch);
        scene.particles[1].velocity = DVec3::X * speed;
        let (model, state) = Model::<f64>::new(&scene).unwrap();
        let x = directions(2);
        let exact = product_by_differences(&model, &state, 0.1, &x);
        assert!(apart(&product(&model, &state, 0.1, &x), &exact) < 1e-8);
    }
}

#[test]
fn a_spring_that_pushes_resists_along_itself_and_not_sideways() {
    let (model, state) = Model::<f64>::new(&two_masses([1.0, 3.0], 50.0, 4.0, -0.4)).unwrap();
    let sideways = [DVec3::Y, DVec3::Z];
    assert_eq!(product(&model, &state, 0.1, &sideways), [DVec3::Y, DVec3::Z * 3.0]);
    // Exact derivatives would make it less than the mass: m − τ² k (rest / L − 1).
    let exact = product_by_differences(&model, &state, 0.1, &sideways);
    assert!(exact[0].y < 1.0);
    let along = [DVec3::X, -DVec3::X];
    let exact = product_by_differences(&model, &state, 0.1, &along);
    assert!(apart(&product(&model, &state, 0.1, &along), &exact) < 1e-8);
}

#[test]
fn the_matrix_is_symmetric_and_no_lighter_than_the_masses() {
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    for seed in 0..20 {
        let (model, state) = Model::<f64>::new(&random_scene(seed)).unwrap();
        let x = directions(model.particle_count());
        let y: Vec<DVec3> = x.iter().rev().map(|x| DVec3::new(x.z, x.x, x.y)).collect();
        let (ax, ay) = (product(&model, &state, 0.1, &x), product(&model, &state, 0.1, &y));
        // Rounding of some 400 products of about 10.
        assert!((dot(&y, &ax) - dot(&x, &ay)).abs() < 1e-10);
        let mass: f64 = x.iter().zip(model.masses()).map(|(x, m)| x.dot(*x) * m).sum();
        assert!(mass <= dot(&x, &ax));
    }
}
