//! Solves that fail under the implicit methods: reported, and gravity never lost.

use crate::common::{Random, simulation, tumbling_block};
use msd_core::elements::{Block, Blocks, Element, Motion, Products, Vectors};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Error, Friction, Integrator, Material, Pin, Plane, Real, Scene, Simulation, Vector, shape,
};

const BOTH: [Integrator; 2] = [Integrator::BackwardEuler, Integrator::ImplicitMidpoint];
const G: f64 = 9.82;
const H: f64 = 1.0 / 60.0;

/// A level cloth of 1 m.
fn cloth(mass: f64, stiffness: f64) -> Scene {
    let material = Material { mass, stiffness, damping: 0.0 };
    let mut part = shape::cloth([5, 5], 0.25, material).unwrap();
    part.place(DMat3::from_rotation_x(0.5 * std::f64::consts::PI), DVec3::ZERO);
    Scene::of("cloth", part)
}

fn falls_as_one<R: Real>(integrator: Integrator, ratio: f64, spin: DVec3) {
    let mut scene = cloth(1.0, ratio / (H * H));
    for particle in &mut scene.particles {
        particle.velocity = DVec3::X + spin.cross(particle.position);
    }
    let mut run = simulation::<R>(&scene, integrator, H);
    let mut fastest: f64 = 10.0;
    for step in 1..=60 {
        run.step().unwrap();
        fastest = run.velocities().map(|v| v.to_f64().length()).fold(fastest, f64::max);
        let velocity = run.momentum().linear / 25.0;
        let exact = DVec3::new(1.0, -G * f64::from(step) * H, 0.0);
        // A rounding of each velocity per step.
        let rounding = f64::from(step) * R::EPSILON.to_f64() * fastest;
        let error = (velocity - exact).length();
        assert!(error <= rounding, "{integrator} {} {ratio:e}: {error}", R::NAME);
    }
}

#[test]
fn the_whole_falls_as_it_must_however_stiff_it_is() {
    let mut random = Random(23);
    for ratio in [4.0, 4e3, 4e5, 4e6, 4e8] {
        for _ in 0..3 {
            let spin = (random.vector() - 0.5) * 6.0;
            for integrator in BOTH {
                falls_as_one::<f64>(integrator, ratio, spin);
                falls_as_one::<f32>(integrator, ratio, spin);
                falls_as_one::<f32>(integrator, ratio, DVec3::ZERO);
            }
        }
    }
}

#[test]
fn two_halves_of_a_cloth_fall_apart_each_with_its_own_momentum() {
    let mut scene = cloth(1.0, 4e5 / (H * H));
    let side = |row: usize| scene.particles[row].position.x < 0.1;
    let halves: Vec<bool> = (0..25).map(side).collect();
    scene.bodies.clear();
    scene.springs.retain(|spring| halves[spring.ends[0]] == halves[spring.ends[1]]);
    scene.pins = vec![Pin {
        particle: halves.iter().position(|&left| left).unwrap(),
        velocity: DVec3::ZERO,
    }];
    scene.particles.iter_mut().for_each(|particle| particle.velocity = DVec3::Z);
    for integrator in BOTH {
        let mut run = simulation::<f32>(&scene, integrator, H);
        (0..60).for_each(|_| run.step().unwrap());
        let free: Vec<DVec3> =
            run.velocities().zip(&halves).filter(|row| !row.1).map(|row| row.0.to_f64()).collect();
        let mean = free.iter().sum::<DVec3>() / free.len() as f64;
        assert!(
            (mean - DVec3::new(0.0, -G, 1.0)).length() < 60.0 * 1.2e-7 * 10.0,
            "{integrator}: {mean}"
        );
    }
}

#[test]
fn a_body_in_one_hand_and_on_a_slope_moves_as_a_whole_however_stiff_it_is() {
    // Smooth and level: nothing holds it sideways, and a force of 1 N/kg does.
    let mut scene = cloth(1.0, 4e6 / (H * H));
    scene.world.force = DVec3::new(1.0, 0.0, -0.5);
    let friction = Friction::Coulomb(0.0);
    scene.planes = vec![Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction }];
    for integrator in BOTH {
        let mut run = simulation::<f32>(&scene, integrator, H);
        (0..60).for_each(|_| run.step().unwrap());
        let velocity = run.momentum().linear / 25.0;
        let error = (velocity - scene.world.force).length();
        assert!(error < 60.0 * 1.2e-7 * 2.0, "{integrator}: {velocity}");
    }
}

/// An element that fails at one particle from some time on.
#[derive(Debug)]
struct Broken {
    particle: usize,
    from: f64,
    value: f64,
    products: bool,
}

impl<R: Real> Element<R> for Broken {
    fn add_forces(&self, motion: &Motion<'_, R>, forces: &mut Vectors<'_, R>) -> f64 {
        if self.from < motion.time() && !self.products {
            forces.add(self.particle, R::Vec3::of(DVec3::X * self.value));
        }
        0.0
    }
    fn add_products(&self, motion: &Motion<'_, R>, _: &[DVec3], products: &mut Products<'_>) {
        if self.from < motion.time() && self.products {
            products.stiffness[self.particle] += DVec3::Y * self.value;
        }
    }
    fn add_blocks(&self, _: &Motion<'_, R>, _: &mut Blocks<'_>) {
        let _: Block = Block::default();
    }
}

#[test]
fn a_force_that_is_no_number_is_an_error_that_names_the_particle() {
    for value in [f64::NAN, f64::INFINITY] {
        for products in [false, true] {
            // The last lies on the floor and sticks to it, the first is pinned.
            for particle in [0, 3, 24] {
                let mut scene = cloth(1.0, 100.0);
                scene.pins = vec![Pin { particle: 0, velocity: DVec3::ZERO }];
                let friction = Friction::Coulomb(1.0);
                scene.planes =
                    vec![Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction }];
                for integrator in BOTH {
                    let mut run = simulation::<f64>(&scene, integrator, H);
                    run.add_element(Broken { particle, from: 5.25 * H, value, products });
                    (0..5).for_each(|_| run.step().unwrap());
                    let good = run.state();
                    let error = run.step().unwrap_err();
                    let Error::Diverged(report) = error else { panic!("{integrator}: {error}") };
                    assert_eq!((report.step, run.state()), (6, good), "{integrator}");
                    // Products may spread the failure to others before it is noticed.
                    assert!(products || report.particle == particle, "{integrator}: {report}");
                }
            }
        }
    }
}

#[test]
fn masses_and_stiffnesses_that_cannot_be_solved_for_do_not_hang_in_the_air_unnoticed() {
    let masses = [1e38, 1e37, 1e30, 1e-10, 1e-30, 1e-37].map(|mass| (mass, 100.0));
    let stiffnesses = [1e10, 1e20, 1e30, 1e37, 3e38].map(|stiffness| (1.0, stiffness));
    for (mass, stiffness) in masses.into_iter().chain(stiffnesses) {
        for pinned in [false, true] {
            let mut scene = cloth(mass, stiffness);
            if pinned {
                scene.pins = [0, 4].map(|particle| Pin { particle, velocity: DVec3::ZERO }).into();
            }
            for integrator in BOTH {
                let mut run = simulation::<f32>(&scene, integrator, H);
                let ended = (0..60).try_for_each(|_| run.step());
                let start = scene.particles.iter().map(|x| x.position.y).sum::<f64>();
                let moved = run.positions().map(|x| f64::from(x.y)).sum::<f64>() - start;
                let what = format!("{integrator} {mass:e} {stiffness:e} {pinned}: {moved}");
                match ended {
                    // A swing of unresolved stiffness may do anything but stay.
                    Ok(()) if pinned => assert!(0.25 < moved.abs(), "{what}"),
                    Ok(()) => assert!((moved / 25.0 + 0.5 * G).abs() < 0.1, "{what}"),
                    Err(error) => assert!(error.is_of_step(), "{what}: {error}"),
                }
            }
        }
    }
}

#[test]
fn a_run_says_how_far_its_solves_got() {
    let scene = tumbling_block(4.0);
    for (integrator, tolerance) in BOTH.into_iter().zip([1e-3, 1e-6]) {
        let mut run = simulation::<f64>(&scene, integrator, H);
        assert_eq!(run.solved(), None);
        run.step().unwrap();
        let solved = run.solved().unwrap();
        assert!(2 <= solved.iterations && solved.residual <= tolerance, "{solved:?}");
    }
    let mut run = simulation::<f64>(&scene, Integrator::VelocityVerlet, 1e-3);
    run.step().unwrap();
    assert_eq!(run.solved(), None);
}

#[test]
fn a_step_that_is_not_solved_keeps_the_state_and_says_what_was_left() {
    let mut scene = cloth(1.0, 1e37);
    scene.pins = [0, 4].map(|particle| Pin { particle, velocity: DVec3::ZERO }).into();
    for integrator in BOTH {
        let mut run: Simulation<f32> = simulation(&scene, integrator, H);
        let before = run.state();
        let error = run.step().unwrap_err();
        let Error::Unsolved { residual, step, time, .. } = error else { panic!("{error}") };
        assert!(1.0 <= residual && (step, time) == (1, 0.0), "{error}");
        assert_eq!((run.state(), run.steps()), (before, 0));
    }
}
