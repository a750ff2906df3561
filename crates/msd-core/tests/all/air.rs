//! Air on surfaces: closed forms of drag and lift, the ledger, the damping matrix, and gusts.

use msd_core::elements::air::AirLoads;
use msd_core::glam::DVec3;
use msd_core::testing::{forces, products};
use msd_core::{
    Air, Body, Corner, Gust, Integrator, Interaction, Material, Particle, Pin, Real, Scene,
    Settings, Simulation, State, Surface, Vector, World, shape, state_hash,
};

const G: f64 = 9.82;

/// A right-angled triangle of these legs, metres, flat in the plane y = 0; its area is 0.06 m².
const LEGS: [f64; 2] = [0.3, 0.4];
const AREA: f64 = 0.5 * LEGS[0] * LEGS[1];

fn corners() -> [DVec3; 3] {
    [DVec3::ZERO, DVec3::X * LEGS[0], DVec3::Z * LEGS[1]]
}

/// The surface of a triangle, of its first three particles.
fn surface(two_sided: bool) -> Surface {
    let corner = |particle| Corner { particle, uv: [0.0; 2] };
    Surface { corners: [0, 1, 2].map(corner).to_vec(), triangles: vec![[0, 1, 2]], two_sided }
}

fn sheet(two_sided: bool) -> Body {
    Body { particles: 0..3, surface: surface(two_sided), ..Body::default() }
}

/// Three particles of 5 g, at these places, as a sheet in the air.
fn falling(places: [DVec3; 3], air: Air) -> Scene {
    let particle = |position| Particle { position, velocity: DVec3::ZERO, mass: 0.005 };
    Scene {
        world: World { air: Some(air), ..World::default() },
        particles: places.map(particle).to_vec(),
        bodies: vec![sheet(true)],
        ..Scene::default()
    }
}

fn air_of(drag: f64, lift: f64) -> Air {
    Air { drag, lift, ..Air::default() }
}

fn run<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32, steps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    let mut simulation = Simulation::<R>::new(scene, settings).expect("a valid scene");
    for _ in 0..steps {
        simulation.step().expect("a stable run");
    }
    simulation
}

/// At the terminal speed drag is the weight: v = sqrt(2 m g / (ρ A C)).
fn terminal(drag: f64) -> f64 {
    (2.0 * 3.0 * 0.005 * G / (1.2 * AREA * drag)).sqrt()
}

/// The triangle upright, one edge along the fall.
fn edge_on() -> [DVec3; 3] {
    corners().map(|corner| DVec3::new(corner.x, corner.z, 0.0))
}

#[test]
fn a_falling_sheet_reaches_the_terminal_speed_flat_and_edge_on() {
    let (drag, lift) = (1.2, 0.9);
    for (places, drag_here) in [(corners(), drag), (edge_on(), drag - lift)] {
        let scene = falling(places, air_of(drag, lift));
        let expected = terminal(drag_here);
        for integrator in Integrator::ALL {
            // After ten times v/g nothing of the start is left: tanh(10) is 1 to 4e-9.
            let steps = (10.0 * expected / G * 60.0).ceil() as u32;
            let double = run::<f64>(&scene, integrator, 4, steps);
            let single = run::<f32>(&scene, integrator, 4, steps);
            for particle in 0..3 {
                let fall = -double.velocity(particle).y;
                assert!((fall - expected).abs() < 1e-7 * expected, "{integrator}: {fall}");
                // Nothing but rounding changes the area, by 1e-6 m in edges of 0.3 m at each step.
                let fall = f64::from(-single.velocity(particle).y);
                assert!((fall - expected).abs() < 1e-4 * expected, "{integrator}: {fall}");
            }
        }
    }
}

/// v = v∞ tanh(g t / v∞).
#[test]
fn a_sheet_gains_speed_as_the_closed_form_says() {
    let scene = falling(corners(), air_of(1.2, 0.9));
    let expected = |time: f64| terminal(1.2) * (G * time / terminal(1.2)).tanh();
    let off = |integrator, substeps| {
        let simulation = run::<f64>(&scene, integrator, substeps, 12);
        (-simulation.velocity(0).y - expected(0.2)).abs()
    };
    for (integrator, order) in
        [(Integrator::VelocityVerlet, 2.0), (Integrator::ImplicitMidpoint, 2.0)]
    {
        let [coarse, fine] = [4, 8].map(|substeps| off(integrator, substeps));
        let measured = (coarse / fine).log2();
        assert!((measured - order).abs() < 0.2, "{integrator}: {measured}");
        assert!(fine < 1e-3 * expected(0.2), "{integrator}: {fine}");
    }
    assert!(off(Integrator::Rk4, 8) < 1e-9);
}

/// A state of the flat triangle that moves as a whole.
fn moving(velocity: DVec3) -> State<f64> {
    State { positions: corners().to_vec(), velocities: vec![velocity; 3] }
}

#[test]
fn a_sheet_at_an_angle_has_the_coefficients_of_a_flat_plate() {
    let (drag, lift, speed) = (1.3, 0.8, 7.0);
    let loads = AirLoads::new(&air_of(drag, lift), &[sheet(true)]);
    let pressure = 0.5 * 1.2 * AREA * speed * speed;
    for degrees in [-180, -150, -90, -45, -10, 0, 5, 30, 60, 90, 135] {
        let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
        // The sheet moves down at an angle to its own plane.
        let way = DVec3::new(cosine, -sine, 0.0);
        let found = forces(&loads, &moving(way * speed));
        let total: DVec3 = found.iter().sum();
        let across = DVec3::new(sine, cosine, 0.0);
        let along = drag * sine * sine + (drag - lift) * cosine * cosine;
        let expected = [along * pressure, lift * sine * cosine * pressure];
        for (found, expected) in [-total.dot(way), total.dot(across)].into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13 * pressure, "{degrees}: {found}, {expected}");
        }
        assert!(total.z.abs() < 1e-13 * pressure);
        assert!(found.iter().all(|force| (*force - total / 3.0).length() < 1e-13 * pressure));
    }
}

#[test]
fn both_sides_of_a_sheet_are_alike_and_those_of_a_closed_surface_add_up_to_it() {
    let air = air_of(1.2, 1.0);
    let turned = |two_sided| {
        let mut body = sheet(two_sided);
        body.surface.triangles = vec![[0, 2, 1]];
        body
    };
    let state = moving(DVec3::new(3.0, -2.0, 0.7));
    let sum = |bodies: &[Body]| forces(&AirLoads::new(&air, bodies), &state);
    let expected = sum(&[sheet(true)]);
    for found in [sum(&[turned(true)]), sum(&[sheet(false), turned(false)])] {
        for (found, expected) in found.iter().zip(&expected) {
            assert!((*found - *expected).length() < 1e-14, "{found} {expected}");
        }
    }
}

/// Only its front has a part in the drag of a cube without friction.
#[test]
fn a_cube_has_the_drag_of_its_front() {
    let material = Material { mass: 1.0, stiffness: 1.0, damping: 0.0 };
    let scene = Scene::of("cube", shape::block([4, 4, 4], 0.1, material).expect("a cube"));
    let positions = scene.particles.iter().map(|particle| particle.position).collect();
    let velocities = vec![DVec3::new(0.0, 0.0, 5.0); scene.particles.len()];
    let air = Air { velocity: DVec3::Z, ..air_of(1.1, 1.1) };
    let loads = AirLoads::new(&air, &scene.bodies);
    let total: DVec3 = forces(&loads, &State { positions, velocities }).iter().sum();
    let expected = DVec3::NEG_Z * (0.5 * 1.2 * 0.3 * 0.3 * 1.1 * 16.0);
    assert!((total - expected).length() < 1e-12, "{total} {expected}");
}

#[test]
fn nothing_acts_without_surfaces_without_density_or_with_the_wind() {
    let wind = DVec3::new(4.0, 1.0, -2.0);
    let air = Air { velocity: wind, ..Air::default() };
    let zero = |air: &Air, bodies: &[Body], velocity| {
        let found = forces(&AirLoads::new(air, bodies), &moving(velocity));
        found.iter().all(|force| *force == DVec3::ZERO)
    };
    assert!(zero(&air, &[], DVec3::X));
    assert!(zero(&Air { density: 0.0, ..air }, &[sheet(true)], DVec3::X));
    assert!(zero(&air, &[sheet(true)], wind));
    assert!(!zero(&air, &[sheet(true)], DVec3::ZERO));
    // A rope has the bits that it has without air.
    let rope = shape::rope(9, 0.1, Material::default()).expect("a rope");
    let mut scene = Scene::of("rope", rope);
    let end =
        |scene: &Scene| state_hash(&run::<f32>(scene, Integrator::VelocityVerlet, 8, 60).state());
    let without = end(&scene);
    scene.world.air = Some(air);
    assert_eq!(end(&scene), without);
}

/// A cloth held by its left column in a gusty wind.
fn flag(strength: f64) -> Scene {
    let material = Material { mass: 0.002, stiffness: 20.0, damping: 0.02 };
    let mut scene = Scene::of("flag", shape::cloth([7, 10], 0.1, material).expect("a cloth"));
    let gust = Gust { strength, length: 0.8, time: 0.5, seed: 3, ..Gust::default() };
    let air = Air { velocity: DVec3::new(4.0, 0.0, 1.0), gust, ..Air::default() };
    scene.world.air = Some(air);
    let pin = |row: usize| Pin { particle: row * 10, velocity: DVec3::ZERO };
    scene.pins = (0..7).map(pin).collect();
    scene
}

#[test]
fn energy_taken_and_given_balances_within_the_error_of_the_method() {
    let scene = flag(2.0);
    let drift = |integrator, substeps| {
        let start = run::<f64>(&scene, integrator, substeps, 0).energy().total();
        let simulation = run::<f64>(&scene, integrator, substeps, 30);
        assert!(0.0 < simulation.given(), "{integrator}: the wind drives");
        let energy = simulation.energy();
        (energy.total() - start).abs() / (energy.kinetic + energy.elastic)
    };
    let [coarse, fine] = [16, 32].map(|substeps| drift(Integrator::VelocityVerlet, substeps));
    assert!(fine < 0.3 * coarse && fine < 4e-3, "of second order: {coarse} {fine}");
    // Conserves quadratic energies; the remainder is the tolerance of its solves.
    assert!(drift(Integrator::ImplicitMidpoint, 32) < 1e-3);
    assert!(drift(Integrator::Rk4, 32) < 1e-5);
    // It books power that drives by the trapezoidal rule.
    assert!(drift(Integrator::DormandPrince, 1) < 1e-3);
}

#[test]
fn still_air_only_takes_energy() {
    let mut scene = flag(0.0);
    scene.world.air = Some(Air::default());
    for integrator in Integrator::ALL {
        let simulation = run::<f64>(&scene, integrator, 32, 60);
        assert_eq!(simulation.given(), 0.0, "{integrator}");
        assert!(0.0 < simulation.energy().dissipated, "{integrator}");
    }
}

#[test]
fn products_are_the_derivative_of_the_forces() {
    let loads = AirLoads::new(&air_of(1.3, 1.0), &[sheet(true)]);
    let drag_alone = AirLoads::new(&air_of(1.3, 0.0), &[sheet(true)]);
    let slanted = DVec3::new(2.0, -1.0, 0.5);
    let any = DVec3::new(0.3, 0.5, -0.8);
    // At an angle the change of the lift with the speed along the sheet is left out.
    let cases = [
        (&loads, DVec3::NEG_Y * 3.0, any),
        (&loads, DVec3::X * 3.0, any),
        (&loads, slanted, DVec3::Y),
        (&drag_alone, slanted, any),
    ];
    for (loads, velocity, way) in cases {
        let direction = [way, way * -0.4, way * 2.0];
        let state = moving(velocity);
        let [stiffness, damping] = products(loads, &state, &direction);
        assert!(stiffness.iter().all(|product| *product == DVec3::ZERO));
        let side = |by: f64| {
            let rows = state.velocities.iter().zip(&direction);
            let velocities = rows.map(|(v, d)| *v + *d * by).collect();
            forces(loads, &State { velocities, ..state.clone() })
        };
        // The error of a difference is its length squared, or rounding over it.
        let reach = 1e-5;
        for ((ahead, back), product) in side(reach).iter().zip(side(-reach)).zip(&damping) {
            let slope = (back - *ahead) / (2.0 * reach);
            assert!((slope - *product).length() < 1e-9, "{velocity}: {slope} {product}");
        }
    }
}

#[test]
fn the_damping_is_symmetric_and_never_negative() {
    for two_sided in [true, false] {
        let loads = AirLoads::new(&air_of(1.2, 1.2), &[sheet(two_sided)]);
        for velocity in [DVec3::new(2.0, -1.0, 0.5), DVec3::NEG_Y, DVec3::X, DVec3::Y] {
            let [a, b] = [DVec3::new(0.3, 0.5, -0.8), DVec3::new(-0.1, 0.7, 0.2)];
            let (a, b) = ([a, b, a * 0.5], [b, -a, b * 0.3]);
            let [da, db] = [a, b].map(|row| products(&loads, &moving(velocity), &row)[1].clone());
            let dot = |x: &[DVec3], y: &[DVec3]| x.iter().zip(y).map(|(x, y)| x.dot(*y)).sum();
            let [ab, ba, aa]: [f64; 3] = [dot(&a, &db), dot(&b, &da), dot(&a, &da)];
            assert!((ab - ba).abs() < 1e-14 && 0.0 <= aa, "{velocity}: {ab} {ba} {aa}");
        }
    }
}

/// Face-on, m v' = −½ ρ A C v² about the speed U of the wind is damped by ρ A C U; symplectic Euler
/// is stable up to twice the mass over that.
#[test]
fn the_stable_step_knows_the_damping_of_the_air() {
    let air = Air { velocity: DVec3::Y * 40.0, ..air_of(1.2, 1.0) };
    let mut scene = falling(corners(), air);
    scene.world.gravity = DVec3::ZERO;
    let simulation = run::<f64>(&scene, Integrator::SymplecticEuler, 1, 0);
    let expected = 2.0 * 0.015 / (1.2 * AREA * 1.2 * 40.0);
    let predicted = simulation.stable_substep();
    assert!((predicted - expected).abs() < 5e-3 * expected, "{predicted} {expected}");
}

#[test]
fn gusts_have_their_strength_no_mean_and_no_divergence() {
    let gust = Gust { strength: 3.0, length: 0.5, time: 0.7, seed: 11, ..Gust::default() };
    let loads = AirLoads::new(&Air { gust, ..Air::default() }, &[]);
    let (mut sum, mut squares, mut count) = (DVec3::ZERO, 0.0, 0.0);
    for row in 0..20_000 {
        let row = f64::from(row);
        // Places and times far apart: a walk without a short period.
        let place = DVec3::new(row * 0.618_034, row * 1.324_718 - 9e3, row * 0.271_828);
        let wind = loads.velocity_at(place, row * 0.577_216);
        (sum, squares, count) = (sum + wind, squares + wind.length_squared(), count + 1.0);
    }
    // A mean of 20 000 samples is off by about the strength over their root.
    assert!((sum / count).length() < 4.0 * 3.0 / count.sqrt(), "{}", sum / count);
    assert!(((squares / count).sqrt() - 3.0).abs() < 0.06, "{}", squares / count);
    let reach = 1e-5;
    for place in [DVec3::ZERO, DVec3::new(3.0, -2.0, 0.4), DVec3::new(0.1, 70.0, 5.0)] {
        let slope = |axis: DVec3| {
            let [ahead, back] = [1.0, -1.0]
                .map(|side| loads.velocity_at(place + axis * (side * reach), 1.3).dot(axis));
            (ahead - back) / (2.0 * reach)
        };
        let divergence: f64 = DVec3::AXES.into_iter().map(slope).sum();
        assert!(divergence.abs() < 1e-4, "{divergence}");
    }
}

#[test]
fn gusts_drift_with_the_wind_and_follow_their_seed() {
    let velocity = DVec3::new(5.0, 0.0, 1.0);
    let gust = Gust { strength: 1.0, time: 1e9, ..Gust::default() };
    let at = |gust: Gust, place, time| {
        AirLoads::new(&Air { velocity, gust, ..Air::default() }, &[]).velocity_at(place, time)
    };
    let place = DVec3::new(0.3, 2.0, -1.0);
    let (start, later) = (at(gust, place, 2.0), at(gust, place + velocity * 3.0, 5.0));
    assert!((start - later).length() < 1e-7, "{start} {later}");
    assert_ne!(start, at(Gust { seed: 1, ..gust }, place, 2.0));
    // A scene that is moved takes its gusts along.
    let moved = Scene { world: flag(1.0).world, ..flag(1.0) }.moved(DVec3::new(64.0, 0.0, -8.0));
    let origin = moved.world.air.expect("air").gust.origin;
    assert_eq!(origin, DVec3::new(64.0, 0.0, -8.0));
}

#[test]
fn a_run_resumes_to_the_bit_with_gusts_and_cuts() {
    let scene = flag(2.0);
    let mut whole = run::<f32>(&scene, Integrator::VelocityVerlet, 8, 20);
    for spring in [30, 31, 32, 90] {
        whole.queue(Interaction::Cut { spring }).expect("a spring");
    }
    whole.step().expect("a stable run");
    whole.remove_particle(9).expect("a particle");
    let (rows, progress) = whole.progress();
    assert_eq!(rows.world.air, scene.world.air);
    let mut resumed = Simulation::<f32>::resume(&rows, &progress).expect("a valid checkpoint");
    for _ in 0..40 {
        whole.step().expect("a stable run");
        resumed.step().expect("a stable run");
    }
    assert_eq!(state_hash(&whole.state()), state_hash(&resumed.state()));
}

#[test]
fn a_body_that_is_added_feels_the_air() {
    let mut simulation = run::<f64>(&flag(0.0), Integrator::VelocityVerlet, 8, 1);
    let count = simulation.model().particle_count();
    let part = shape::cloth([2, 2], 0.1, Material::default()).expect("a cloth");
    simulation.add_body("sail", part).expect("room for a body");
    simulation.step().expect("a stable run");
    assert!(0.0 < simulation.velocity(count).to_f64().x);
}
