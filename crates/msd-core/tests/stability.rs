//! The predicted limit of the substep, against the substep at which runs blow up.

mod common;

use common::{Random, forces_at, weightless};
use msd_core::elements::{Element, Motion, Vectors};
use msd_core::glam::DVec3;
use msd_core::stability::{Estimator, Mode, is_stable};
use msd_core::{
    Integrator, Interaction, Material, Part, Pin, Real, Scene, Settings, Simulation, Vector, shape,
};

const SPRING: Material = Material { mass: 2.0, stiffness: 300.0, damping: 0.0 };

fn scene(part: Part) -> Scene {
    Scene { world: weightless(), ..Scene::of("scene", part) }
}

fn block(material: Material) -> Scene {
    scene(shape::block([4, 4, 4], 1.0, material).unwrap())
}

/// Stiffness times 1 to 100, mass times 1 to 10, and of each damper its own share.
fn random(mut scene: Scene, damping: f64, seed: u64) -> Scene {
    let mut random = Random(seed);
    for spring in &mut scene.springs {
        spring.stiffness *= 100f64.powf(random.unit());
        spring.damping = damping * random.unit();
    }
    for particle in &mut scene.particles {
        particle.mass *= 10f64.powf(random.unit());
    }
    scene
}

/// The scene with the particles on its hull pinned and every length times `factor`.
fn stretched(mut scene: Scene, factor: f64) -> Scene {
    let reach = |values: &dyn Fn(DVec3) -> f64| {
        let all = scene.particles.iter().map(|particle| values(particle.position));
        all.fold(f64::NEG_INFINITY, f64::max)
    };
    let faces = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let faces: Vec<(DVec3, f64)> = faces.map(|axis| (axis, reach(&|x| axis.dot(x)))).collect();
    for (particle, row) in scene.particles.iter().enumerate() {
        if faces.iter().any(|&(axis, reach)| reach - axis.dot(row.position) < 1e-9) {
            scene.pins.push(Pin { particle, velocity: DVec3::ZERO });
        }
    }
    scene.particles.iter_mut().for_each(|particle| particle.position *= factor);
    scene
}

/// Forces that balance those of a start state.
#[derive(Debug)]
struct Balance(Vec<DVec3>);

impl<R: Real> Element<R> for Balance {
    fn add_forces(&self, _: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        let rows = self.0.iter().enumerate();
        rows.for_each(|(particle, &force)| forces.add(particle, R::Vec3::of(-force)));
        0.0
    }
}

/// Whether a tiny disturbance of a scene held in balance grows.
fn blows_up(scene: &Scene, settings: Settings, steps: u32) -> bool {
    let mut simulation = Simulation::<f64>::new(scene, settings).unwrap();
    let model = simulation.model();
    let mut disturbed = simulation.state();
    let balance = Balance(forces_at(model, &disturbed));
    // A push that excites every motion, small beside any length.
    let (mut random, speed) = (Random(7), 1e-10 / settings.substep());
    for (velocity, &w) in disturbed.velocities.iter_mut().zip(model.inverse_masses()) {
        *velocity = if w == 0.0 { DVec3::ZERO } else { (random.vector() - 0.5) * speed };
    }
    simulation.set_state(&disturbed, 0).unwrap();
    simulation.add_element(balance);
    for _ in 0..steps / settings.substeps {
        simulation.step().unwrap();
        if simulation.velocities().any(|velocity| 1e4 * speed < velocity.extent()) {
            return true;
        }
    }
    false
}

/// Asserts that runs 0.5 % below the predicted limit stay bounded, and runs 0.5 % above it blow up.
fn is_observed(name: &str, scene: &Scene, integrators: &[Integrator], steps: u32) {
    is_observed_within(0.005, name, scene, integrators, steps);
}

fn is_observed_within(
    room: f64,
    name: &str,
    scene: &Scene,
    integrators: &[Integrator],
    steps: u32,
) {
    let start = Simulation::<f64>::new(scene, Settings::default()).unwrap();
    for &integrator in integrators {
        let many = if integrator == Integrator::VelocityVerlet { 4 } else { 1 };
        for substeps in (1..=many).step_by(3) {
            let predicted = start.stable_substep_of(integrator, substeps);
            let blows_up = |share: f64| {
                let step = share * predicted * f64::from(substeps);
                let settings = Settings { integrator, step, substeps, ..Settings::default() };
                blows_up(scene, settings, steps)
            };
            let name = format!("{name}, {integrator}, {substeps} substeps of {predicted} s");
            assert!(!blows_up(1.0 - room), "{name}: too long");
            assert!(blows_up(1.0 + room), "{name}: too short");
            let safe = start.guaranteed_substep(integrator);
            assert!(safe <= 1.005 * predicted, "{name}: guaranteed up to {safe} s");
        }
    }
}

/// All but explicit Euler, which has no limit to observe without damping.
const DAMPED_OR_NOT: [Integrator; 3] =
    [Integrator::SymplecticEuler, Integrator::VelocityVerlet, Integrator::Rk4];

#[test]
fn springs_whose_ends_almost_coincide_set_no_limit() {
    // Buckling sets no limit, however hard a spring is pushed; sums over springs bound the others.
    for gap in [0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let mut scene = block(Material { damping: 5.0, ..SPRING });
        let mut random = Random(7);
        for particle in &mut scene.particles {
            particle.position.y = 0.0;
            particle.position += gap * DVec3::from_array([0; 3].map(|_| random.unit()));
        }
        let start = Simulation::<f64>::new(&scene, Settings::default()).unwrap();
        for integrator in DAMPED_OR_NOT {
            let predicted = start.stable_substep_of(integrator, 4);
            let safe = start.guaranteed_substep(integrator);
            // Sums of rows are two to four times those of a lattice.
            assert!((safe..5.0 * safe).contains(&predicted), "{gap}, {integrator}: {predicted} s");
        }
    }
}

#[test]
fn lattices_and_ropes_blow_up_where_predicted() {
    let damped = |damping: f64| Material { damping, ..SPRING };
    let rope = |count: usize, damping| scene(shape::rope(count, 1.0, damped(damping)).unwrap());
    let cloth = |damping| scene(shape::cloth([8, 8], 1.0, damped(damping)).unwrap());
    for damping in [0.0, 0.5, 5.0, 60.0, 600.0] {
        // Growth a half per cent above the limit: by its damping per substep, or faster.
        is_observed("block", &block(damped(damping)), &DAMPED_OR_NOT, 6000);
        is_observed("cloth", &cloth(damping), &DAMPED_OR_NOT, 6000);
        is_observed("rope", &rope(20, damping), &DAMPED_OR_NOT, 6000);
    }
    for damping in [20.0, 60.0, 600.0] {
        is_observed("block", &block(damped(damping)), &[Integrator::ExplicitEuler], 40_000);
    }
}

#[test]
fn random_stiffness_mass_and_damping_blow_up_where_predicted() {
    for (seed, damping) in [0.0, 4.0, 30.0, 60.0, 120.0, 500.0, 5e3].into_iter().enumerate() {
        let seed = 1 + seed as u64;
        is_observed("block", &random(block(SPRING), damping, seed), &DAMPED_OR_NOT, 8000);
        let rope = scene(shape::rope(30, 1.0, SPRING).unwrap());
        is_observed("rope", &random(rope, damping, seed), &DAMPED_OR_NOT, 8000);
        let cloth = scene(shape::cloth([9, 7], 1.0, SPRING).unwrap());
        is_observed("cloth", &random(cloth, damping, seed), &DAMPED_OR_NOT, 8000);
    }
}

/// The motion that grows first may be any. Weaker dampers would take longer runs to show it.
#[test]
fn explicit_euler_with_dampers_of_their_own_blows_up_where_predicted() {
    for (seed, damping) in [60.0, 120.0, 500.0].into_iter().enumerate() {
        for size in [[2, 3, 4], [4, 4, 4], [5, 5, 5]] {
            let scene =
                random(scene(shape::block(size, 1.0, SPRING).unwrap()), damping, seed as u64);
            let name = format!("block of {size:?}, dampers up to {damping}");
            is_observed_within(0.02, &name, &scene, &[Integrator::ExplicitEuler], 60_000);
        }
    }
}

/// A buckling motion grows at any step, and is left out: a limit is never negative.
#[test]
fn a_compressed_body_has_a_limit_under_explicit_euler_too() {
    for factor in [0.1, 0.5, 0.9] {
        let mut squeezed = random(block(SPRING), 30.0, 5);
        squeezed.particles.iter_mut().for_each(|particle| particle.position *= factor);
        let run = Simulation::<f64>::new(&squeezed, Settings::default()).unwrap();
        let limit = run.stable_substep_of(Integrator::ExplicitEuler, 1);
        assert!(0.0 < limit && limit.is_finite(), "{factor}: {limit}");
    }
}

#[test]
fn stretched_and_compressed_states_blow_up_where_predicted() {
    for damping in [0.0, 10.0, 80.0] {
        let damped = Material { damping, ..SPRING };
        for factor in [0.8, 1.3, 3.0, 30.0] {
            let name = format!("block at {factor} of its length");
            is_observed(&name, &stretched(block(damped), factor), &DAMPED_OR_NOT, 6000);
        }
        let mut cloth = scene(shape::cloth([8, 8], 1.0, damped).unwrap());
        cloth.particles.iter_mut().for_each(|particle| particle.position *= 4.0);
        is_observed("stretched cloth", &cloth, &DAMPED_OR_NOT, 6000);
    }
}

#[test]
fn drag_and_a_hand_count() {
    let mut dragged = random(block(SPRING), 20.0, 3);
    dragged.world.drag = 40.0;
    is_observed("drag", &dragged, &DAMPED_OR_NOT, 6000);
    let mut simulation = Simulation::<f64>::new(&block(SPRING), Settings::default()).unwrap();
    let free = simulation.stable_substep();
    let hold = Interaction::Grab {
        particle: 0,
        target: DVec3::ZERO,
        frequency: 1e3,
        damping_ratio: 1.0,
        max_force: 1e9,
    };
    simulation.queue(hold).unwrap();
    simulation.apply_queued().unwrap();
    // The grab is capped at a tenth of the substeps per second, far above the frequencies of the
    // springs.
    assert!(simulation.stable_substep() < 0.9 * free);
}

#[test]
fn two_masses_have_the_spectrum_of_their_reduced_mass() {
    let scene = common::two_masses([1.0, 3.0], 30.0, 2.0, 0.0);
    let mode = Simulation::<f64>::new(&scene, Settings::default()).unwrap().fastest_mode();
    let per_mass = 1.0 + 1.0 / 3.0;
    assert!((mode.stiffness - 30.0 * per_mass).abs() < 1e-9);
    assert!((mode.damping - 2.0 * per_mass).abs() < 1e-9);
}

#[test]
fn the_fastest_motion_is_that_of_the_stiffest_spring() {
    let mut rope = scene(shape::rope(6, 1.0, SPRING).unwrap());
    rope.springs[2].stiffness *= 1e4;
    let [a, b] = rope.springs[2].ends;
    let motion = Simulation::<f64>::new(&rope, Settings::default()).unwrap().fastest_motion();
    assert!((motion[a] + motion[b]).length() < 1e-3, "{motion:?}");
    assert!((motion[a].length() - 1.0).abs() < 1e-3, "{motion:?}");
    // Others follow by the ratio of stiffness.
    let others = (0..6).filter(|&particle| particle != a && particle != b);
    others.for_each(|other| assert!(motion[other].length() < 1e-3, "{motion:?}"));
    rope.springs.iter_mut().for_each(|spring| spring.stiffness = 0.0);
    let slack = Simulation::<f64>::new(&rope, Settings::default()).unwrap();
    assert!(slack.fastest_motion().is_empty());
}

#[test]
fn the_regions_are_those_of_the_textbooks() {
    let limit = |integrator, zeta: f64| {
        Mode { stiffness: 1.0, damping: 2.0 * zeta }.largest_substep(integrator, 1)
    };
    // Undamped: 2 / w for Verlet and symplectic Euler, 2 √2 / w for RK4, none for explicit Euler.
    assert!((limit(Integrator::SymplecticEuler, 0.0) - 2.0).abs() < 1e-6);
    assert!((limit(Integrator::VelocityVerlet, 0.0) - 2.0).abs() < 1e-6);
    assert!((limit(Integrator::Rk4, 0.0) - 8f64.sqrt()).abs() < 1e-6);
    assert_eq!(limit(Integrator::ExplicitEuler, 0.0), 0.0);
    // On the imaginary axis and on the real one; Hairer and Wanner (1996), section IV.2: 3.3.
    assert!((limit(Integrator::Rk4, 1e6) * 2e6 - 2.7853).abs() < 1e-3);
    assert!((limit(Integrator::DormandPrince, 1e6) * 2e6 - 3.3066).abs() < 1e-3);
    assert!((limit(Integrator::DormandPrince, 0.0) - 1.0).abs() < 0.05);
    for zeta in [1e-4f64, 0.1, 0.5, 1.0, 3.0] {
        // Symplectic Euler: W/4 + Z/2 = 1; explicit Euler below critical damping: h = 2 ζ / w.
        let exact = 2.0 * ((zeta * zeta + 1.0).sqrt() - zeta);
        assert!((limit(Integrator::SymplecticEuler, zeta) - exact).abs() < 1e-6);
        if zeta <= 1.0 {
            assert!((limit(Integrator::ExplicitEuler, zeta) - 2.0 * zeta).abs() < 1e-6);
        }
    }
    // A step of many substeps of Verlet has the limit of symplectic Euler, damped or not.
    for zeta in [0.0f64, 0.01, 0.3, 1.0, 10.0] {
        let exact = 2.0 * ((zeta * zeta + 1.0).sqrt() - zeta);
        let stable = |h: f64| is_stable(Integrator::VelocityVerlet, 64, h * h, 2.0 * zeta * h);
        assert!(stable(0.99 * exact) && !stable(1.01 * exact), "{zeta}");
    }
}

#[test]
fn free_particles_have_no_limit_and_pins_raise_it() {
    let mut scene = common::two_masses([1.0, 1.0], 30.0, 0.0, 0.0);
    let limit = |scene: &Scene| {
        Simulation::<f32>::new(scene, Settings::default()).unwrap().stable_substep()
    };
    let free = limit(&scene);
    scene.pins = vec![msd_core::Pin { particle: 0, velocity: Default::default() }];
    // A pin doubles the reduced mass: √2 slower.
    assert!((limit(&scene) / free - 2f64.sqrt()).abs() < 1e-6);
    scene.springs.clear();
    assert_eq!(limit(&scene), f64::INFINITY);
}

#[test]
fn what_is_stiffer_than_any_number_bears_no_step() {
    let scene = common::two_masses([1e-200, 1e-200], 1e200, 0.0, 0.0);
    let (rk4, mut estimator) = (Integrator::Rk4, Estimator::default());
    let stiff = common::simulation::<f64>(&scene, rk4, 1e-3);
    assert_eq!(stiff.stable_substep_by(&mut estimator), 0.0);
    // The columns that this leaves also serve another, larger system.
    let block = common::simulation::<f64>(&block(SPRING), rk4, 1e-3);
    assert_eq!(block.stable_substep_by(&mut estimator), block.stable_substep());
}

/// The result of a prediction in pieces, and the number of pieces.
fn in_pieces(simulation: &Simulation<f32>, how: (Integrator, u32)) -> (f64, usize) {
    let mut estimator = Estimator::default();
    // A prediction that was not finished leaves nothing.
    for _ in 0..5 {
        simulation.stable_substep_piecewise(Integrator::Rk4, 3, &mut estimator);
    }
    estimator.restart();
    let (integrator, substeps) = how;
    let mut pieces = 0;
    loop {
        pieces += 1;
        let piece = simulation.stable_substep_piecewise(integrator, substeps, &mut estimator);
        if let Some(limit) = piece {
            return (limit, pieces);
        }
    }
}

#[test]
fn a_prediction_in_pieces_has_the_same_bits() {
    let uneven = random(block(SPRING), 5.0, 3);
    for scene in [block(SPRING), uneven, common::two_masses([1.0, 1.0], 30.0, 0.0, 0.0)] {
        for integrator in Integrator::EXPLICIT {
            for substeps in [1, 8] {
                let simulation = Simulation::<f32>::new(&scene, Settings::default()).unwrap();
                let (limit, pieces) = in_pieces(&simulation, (integrator, substeps));
                let whole = simulation.stable_substep_of(integrator, substeps);
                assert_eq!(limit.to_bits(), whole.to_bits(), "{integrator} x {substeps}");
                assert!(10 < pieces, "{pieces}");
            }
        }
    }
}
