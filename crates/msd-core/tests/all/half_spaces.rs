//! Half spaces: their normals, moved by an interaction, and refused. `contact/` tests their effect.

use crate::common::Random;
use msd_core::glam::DVec3;
use msd_core::scene::solid::rotation;
use msd_core::{
    Integrator, Interaction, Particle, Real, Scene, Settings, Shape, Simulation, Solid, Vector,
    testing,
};

const MASS: f64 = 0.3;

fn scene(position: DVec3, velocity: DVec3, floor: Solid) -> Scene {
    let particles = vec![Particle { position, velocity, mass: MASS }];
    Scene { particles, solids: vec![floor], ..Scene::default() }
}

fn simulation<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

fn second<R: Real>(run: &mut Simulation<R>) {
    (0..60).for_each(|_| run.step().expect("a calm run"));
}

#[test]
fn the_normal_is_the_gradient_of_the_gap_still_and_moving() {
    let mut random = Random(7);
    let points: Vec<DVec3> = (0..200).map(|_| (random.vector() - 0.5) * 4.0).collect();
    let mut solid = Solid::new(Shape::HalfSpace);
    assert_eq!(testing::check_obstacle(&solid, &points, 0.0), Ok(()));
    solid.axes = rotation(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8);
    solid.position = DVec3::new(0.2, 0.1, -0.3);
    (solid.velocity, solid.spin) = (DVec3::X * 0.4, DVec3::new(0.5, -0.2, 0.9));
    assert_eq!(testing::check_obstacle(&solid, &points, 1.7), Ok(()));
}

/// It has no end: a particle that falls nearly a thousand kilometres from its middle lies on it
/// too, in both precisions. An interaction moves it as any solid.
#[test]
fn it_has_no_end_and_is_moved_by_an_interaction() {
    fn falls<R: Real>() {
        let floor = Solid { springs: true, ..Solid::new(Shape::HalfSpace) };
        let start = scene(DVec3::new(-9e5, 1.0, 9e5), DVec3::ZERO, floor);
        let mut run = simulation::<R>(&start, Integrator::VelocityVerlet, 8);
        second(&mut run);
        assert_eq!(run.position(0).to_f64(), DVec3::new(-9e5, 0.0, 9e5));
        let (position, still) = (DVec3::Y * 0.25, DVec3::ZERO);
        let moved = Interaction::MoveSolid { solid: 0, position, velocity: still, spin: still };
        run.queue(moved).expect("it is there");
        second(&mut run);
        assert_eq!(run.position(0).to_f64(), DVec3::new(-9e5, 0.25, 9e5));
    }
    falls::<f32>();
    falls::<f64>();
}

#[test]
fn one_that_is_nowhere_is_refused() {
    let refused = |change: &dyn Fn(&mut Solid)| {
        let mut solid = Solid::new(Shape::HalfSpace);
        change(&mut solid);
        let start = scene(DVec3::Y * 3.0, DVec3::ZERO, solid);
        Simulation::<f64>::new(&start, Settings::default()).expect_err("refused").to_string()
    };
    assert!(refused(&|solid| solid.position.x = f64::INFINITY).contains("position of solid 0"));
    assert!(refused(&|solid| solid.velocity.z = f64::NAN).contains("velocity of solid 0"));
    assert!(refused(&|solid| solid.spin.y = f64::NEG_INFINITY).contains("spin of solid 0"));
    assert!(refused(&|solid| solid.axes.y_axis.y = f64::NAN).contains("rotation"));
}
