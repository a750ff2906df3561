//! Contact under the implicit methods: holding, sliding and falling.
//!
//! Planes look in any direction, at any distance from the origin, and runs are in either precision.

use crate::common::{Random, positions, simulation};
use msd_core::glam::{DMat3, DVec3};
use msd_core::{
    Friction, Integrator, KeyFrame, Material, Particle, Pin, Plane, Real, Scene, Settings, Shape,
    Simulation, Solid, Spring, Vector, World, shape,
};

const BOTH: [Integrator; 2] = [Integrator::BackwardEuler, Integrator::ImplicitMidpoint];
const G: f64 = 9.82;
const H: f64 = 1.0 / 60.0;

/// A direction anywhere on the sphere, of any length, as a user may write it.
fn direction(random: &mut Random) -> DVec3 {
    loop {
        let vector = random.vector() * 2.0 - 1.0;
        if (0.1..1.0).contains(&vector.length()) {
            return vector;
        }
    }
}

/// A slope with Coulomb friction, and down it.
#[derive(Clone, Copy, Debug)]
struct Slope {
    normal: DVec3,
    down: DVec3,
    /// A point of it.
    foot: DVec3,
    /// Its angle with the ground, radians.
    angle: f64,
}

impl Slope {
    /// A slope of this angle that looks anywhere, through a point this far from the origin.
    fn any(random: &mut Random, angle: f64, away: f64) -> Slope {
        let normal = direction(random);
        let unit = normal.normalize();
        let down = unit.cross(direction(random).normalize()).normalize();
        Slope { normal, down, foot: direction(random).normalize() * away, angle }
    }

    fn gravity(&self) -> DVec3 {
        (self.down * self.angle.sin() - self.normal.normalize() * self.angle.cos()) * G
    }

    fn plane(&self, friction: f64) -> Plane {
        let offset = self.normal.normalize().dot(self.foot);
        let friction = Friction::Coulomb(friction);
        Plane { normal: self.normal, offset, restitution: 0.0, friction }
    }

    /// A scene in which a block of so many particles down, up and across stands on it.
    fn block(&self, counts: [usize; 3], stiffness: f64, friction: f64) -> Scene {
        let material = Material { mass: 1.0, stiffness, damping: 50.0 };
        let mut part = shape::block(counts, 0.5, material).unwrap();
        let unit = self.normal.normalize();
        let axes = DMat3::from_cols(self.down, unit, self.down.cross(unit));
        part.place(axes, self.foot + unit * (0.25 * (counts[1] - 1) as f64));
        let mut scene = Scene::of("block", part);
        scene.world.gravity = self.gravity();
        scene.planes = vec![self.plane(friction)];
        scene
    }
}

/// A particle at rest and a plane.
fn ball(position: DVec3, plane: Plane) -> Scene {
    let particle = Particle { position, velocity: DVec3::ZERO, mass: 1.0 };
    Scene { particles: vec![particle], planes: vec![plane], ..Scene::default() }
}

fn centre<R: Real>(simulation: &Simulation<R>) -> DVec3 {
    let positions = positions(simulation);
    positions.iter().sum::<DVec3>() / positions.len() as f64
}

fn steps<R: Real>(simulation: &mut Simulation<R>, count: usize) {
    (0..count).for_each(|_| simulation.step().expect("a calm scene"));
}

/// How far something slides in 2 s from rest, measured between 1 and 2 s and taken times 4/3.
fn slid<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> f64 {
    let settings = Settings { integrator, step: H, substeps, ..Settings::default() };
    let mut run = Simulation::<R>::new(scene, settings).unwrap();
    steps(&mut run, 60);
    let start = centre(&run);
    steps(&mut run, 60);
    (centre(&run) - start).length() * 4.0 / 3.0
}

fn slides_as_friction_lets_it<R: Real>(count: usize) {
    let mut random = Random(17);
    for case in 0..30 {
        // Steeper and rougher, a cube topples.
        let angle = 0.1 + 0.4 * random.unit();
        let factor = angle.tan() * random.unit();
        // A slide of some metres is a thousand roundings of a coordinate at least.
        let away =
            [0.0, 1.0, 1e3, 1e6][case % 4] * if R::EPSILON.to_f64() < 1e-9 { 1.0 } else { 1e-3 };
        let slope = Slope::any(&mut random, angle, away);
        let scene = slope.block([count; 3], 5e3, factor);
        let exact = 0.5 * G * (angle.sin() - factor * angle.cos()) * 4.0;
        for integrator in BOTH {
            let slid = slid::<R>(&scene, integrator, 1);
            // Backward Euler is h / t early; friction is found to one part in a hundred of the
            // pressure, and a block takes a few steps to lean.
            let pressed = 0.5 * G * factor * angle.cos() * 4.0;
            let bound = 0.02 * exact + 0.01 * pressed + if count == 1 { 1e-3 } else { 0.03 };
            assert!(
                (slid - exact).abs() < bound,
                "{integrator} {}: {slid} of {exact}, {slope:?}, {factor}",
                R::NAME
            );
        }
    }
}

#[test]
fn a_particle_slides_down_any_slope_as_coulomb_says() {
    slides_as_friction_lets_it::<f32>(1);
    slides_as_friction_lets_it::<f64>(1);
}

#[test]
fn a_block_slides_down_any_slope_as_coulomb_says() {
    slides_as_friction_lets_it::<f32>(3);
    slides_as_friction_lets_it::<f64>(3);
}

#[test]
fn a_slope_written_by_whole_numbers_rubs_like_any_other() {
    // What was lost: 8.15 m for 0.176.
    let (angle, factor) = (0.5f64.atan(), 0.49);
    let normal = DVec3::new(-1.0, 2.0, 0.0);
    let friction = Friction::Coulomb(factor);
    let scene = ball(DVec3::ZERO, Plane { normal, offset: 0.0, restitution: 0.0, friction });
    let exact = 0.5 * G * (angle.sin() - factor * angle.cos()) * 4.0;
    for integrator in BOTH {
        for substeps in [1, 8] {
            for slid in [
                slid::<f32>(&scene, integrator, substeps),
                slid::<f64>(&scene, integrator, substeps),
            ] {
                // One rounding of friction, 4e-7 of 9 m; h / t.
                assert!((slid - exact).abs() < 0.02 * exact, "{integrator}: {slid} of {exact}");
            }
        }
    }
}

/// A few roundings of what the gap of a plane at a point is computed from, metres.
fn roundings<R: Real>(plane: &Plane, x: DVec3) -> f64 {
    let unit = plane.normal.normalize();
    10.0 * R::EPSILON.to_f64() * ((unit * x).abs().element_sum() + plane.offset.abs())
}

fn rests_on_the_plane<R: Real>() {
    let mut random = Random(3);
    for case in 0..20 {
        // A block of 1 m is still one where a coordinate is rounded to 0.8 mm.
        let away =
            [0.0, 1.0, 1e3, 1e6][case % 4] * if R::EPSILON.to_f64() < 1e-9 { 1.0 } else { 1e-2 };
        let angle = 0.3 * random.unit();
        let slope = Slope::any(&mut random, angle, away);
        let scene = slope.block([3; 3], 5e3, 0.6);
        let plane = &scene.planes[0];
        for integrator in BOTH {
            let mut run = simulation::<R>(&scene, integrator, H);
            steps(&mut run, 300);
            let lowest = |x: &DVec3| plane.normal.normalize().dot(*x) - plane.offset;
            let positions = positions(&run);
            let near = positions.iter().map(lowest).fold(f64::MAX, f64::min);
            let widest = positions.iter().map(|x| roundings::<R>(plane, *x)).fold(0.0, f64::max);
            let bound = widest;
            assert!(near.abs() <= bound, "{integrator} {}: {near} of {bound}, {slope:?}", R::NAME);
        }
    }
}

#[test]
fn what_lies_on_a_plane_lies_within_a_few_roundings_of_it_wherever_that_is() {
    rests_on_the_plane::<f32>();
    rests_on_the_plane::<f64>();
}

fn falls<R: Real>(integrator: Integrator, away: DVec3, height: f64) {
    let friction = Friction::Coulomb(0.5);
    let plane = Plane { normal: DVec3::Y, offset: 0.0, restitution: 0.0, friction };
    let scene = ball(away + DVec3::Y * height, plane);
    let mut run = simulation::<R>(&scene, integrator, H);
    steps(&mut run, 60);
    // What a substep adds to the speed is rounded too, and so is how far that goes.
    let rounding = 8.0 * R::EPSILON.to_f64() * 2.0 * G * H * H;
    let y = run.position(0).to_f64().y;
    assert!((0.0..rounding).contains(&y), "{integrator} from {height} at {away}: {y}");
}

#[test]
fn what_is_above_a_level_plane_falls_on_it_however_far_away() {
    for integrator in BOTH {
        for away in [DVec3::ZERO, DVec3::X * 1e5, DVec3::X * 9e5, DVec3::new(-9e5, 0.0, 8e5)] {
            for height in [1e-6, 1e-3, 0.5] {
                falls::<f32>(integrator, away, height);
                falls::<f64>(integrator, away, height);
            }
        }
    }
}

/// How far a particle moves at most between 10 s and `until`, in roundings of the farthest
/// coordinate.
fn creep<R: Real>(scene: &Scene, integrator: Integrator, until: f64) -> f64 {
    let mut run = simulation::<R>(scene, integrator, H);
    steps(&mut run, 600);
    let (before, mut moved) = (positions(&run), 0.0);
    let widest = before.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    for _ in 0..((until - 10.0) / H) as usize / 10 {
        steps(&mut run, 10);
        let rows = before.iter().zip(positions(&run));
        moved = rows.map(|(a, b)| (*a - b).abs().max_element()).fold(moved, f64::max);
    }
    moved / (R::EPSILON.to_f64() * widest)
}

fn stays<R: Real>(stiffness: f64, integrators: &[Integrator]) {
    let mut random = Random(7);
    for case in 0..20 {
        let angle = 0.05 + 0.45 * random.unit();
        let factor = angle.tan() * (1.05 + 0.5 * random.unit());
        // Where a rounding of a coordinate times the stiffness is still little beside the weight.
        let reach = 1e-10 / (R::EPSILON.to_f64() * stiffness);
        let away = [0.0, 1.0, 1e3, 1e6][case % 4] * reach.min(1.0);
        let slope = Slope::any(&mut random, angle, away);
        let scene = slope.block([3; 3], stiffness, factor);
        let until = if case < 2 { 600.0 } else { 30.0 };
        for &integrator in integrators {
            let creep = creep::<R>(&scene, integrator, until);
            // Each coordinate may be rounded to the one or to the other side of where it is.
            assert!(creep <= 4.0, "{integrator} {}: {creep}, {slope:?}, {factor}", R::NAME);
        }
    }
}

#[test]
fn a_block_that_friction_holds_does_not_creep() {
    stays::<f32>(5e3, &BOTH);
    stays::<f64>(5e3, &BOTH);
}

#[test]
fn a_stiff_block_that_friction_holds_does_not_creep_under_backward_euler() {
    stays::<f32>(1e6, &BOTH[..1]);
    stays::<f64>(1e6, &BOTH[..1]);
}

#[test]
fn a_column_stands_still() {
    let mut random = Random(11);
    for away in [0.0, 10.0, 1e6] {
        let slope = Slope::any(&mut random, 0.0, away);
        let scene = slope.block([3, 9, 3], 5e3, 0.3);
        for integrator in BOTH {
            let creep = creep::<f64>(&scene, integrator, 60.0);
            assert!(creep <= 4.0, "{integrator}: {creep} at {away}");
        }
    }
}

#[test]
fn what_lies_in_a_wedge_comes_to_rest() {
    let mut random = Random(13);
    for _ in 0..10 {
        let slope = Slope::any(&mut random, 0.3, 1.0);
        let mut scene = slope.block([3; 3], 5e3, 0.3);
        let unit = slope.normal.normalize();
        // A wall across the slope that leans over to the block or away from it.
        let normal = unit * (random.unit() - 0.5) - slope.down;
        let lowest = scene.particles.iter().map(|x| normal.normalize().dot(x.position));
        let offset = lowest.fold(f64::MAX, f64::min) - 0.01;
        let friction = Friction::Coulomb(0.1);
        scene.planes.push(Plane { normal, offset, restitution: 0.0, friction });
        for integrator in BOTH {
            let creep = creep::<f64>(&scene, integrator, 30.0);
            assert!(creep <= 10.0, "{integrator}: {creep}, {normal}");
        }
    }
}

/// A wall presses a spring together by key frames, and stays: the work of the wall is the energy of
/// the spring, 2 J, and nothing is lost.
#[test]
fn a_wall_that_speeds_up_and_slows_down_holds_what_it_presses() {
    let particle = |x: f64| Particle { position: DVec3::X * x, velocity: DVec3::ZERO, mass: 0.01 };
    let mut wall = Solid::new(Shape::Box { size: DVec3::splat(0.4) });
    wall.position = DVec3::X * 1.2;
    let there = KeyFrame { time: 1.0, position: DVec3::X * 1.1, axes: wall.axes };
    wall.keys = vec![there];
    let scene = Scene {
        world: World { gravity: DVec3::ZERO, ..World::default() },
        particles: vec![particle(0.0), particle(1.0)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 400.0, damping: 0.0 }],
        pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
        solids: vec![wall],
        ..Scene::default()
    };
    for integrator in BOTH {
        for substeps in [4, 32] {
            let settings = Settings { integrator, substeps, ..Settings::default() };
            let mut simulation = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
            for _ in 0..90 {
                simulation.step().expect("a step");
            }
            // Backward Euler takes the force of the end of each substep: half of the way in one,
            // 0.1 m in a second, times 40 N. What it damps of 0.15 m/s is of second order.
            let first_order = integrator == Integrator::BackwardEuler;
            let h = settings.substep();
            let (late, damped) = if first_order { (6.0 * h, 1e-3 * h) } else { (1e-9, 1e-9) };
            let (supplied, lost) = (simulation.energy().supplied, simulation.dissipated());
            assert!((supplied - 2.0).abs() < late, "{integrator} {substeps}: {supplied} J");
            assert!(lost.abs() < damped, "{integrator} {substeps}: {lost} J");
            assert!((simulation.position(1).x - 0.9).abs() < 1e-12);
        }
    }
}
