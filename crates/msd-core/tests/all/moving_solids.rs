//! Solids that move, and what moves far in a substep: on which side it ends, whose work it was, and
//! where it lands.

use crate::common::Random;
use msd_core::glam::{DMat3, DVec3};
use msd_core::scene::solid::rotation;
use msd_core::{
    Friction, Integrator, Material, Particle, Plane, Real, Scene, Settings, Shape, Simulation,
    Solid, Vector, World, shape,
};

const MASS: f64 = 0.3;

fn start<R: Real>(
    (position, velocity): (DVec3, DVec3),
    solid: Solid,
    gravity: DVec3,
    (integrator, substeps): (Integrator, u32),
) -> Simulation<R> {
    let particles = vec![Particle { position, velocity, mass: MASS }];
    let world = World { gravity, ..World::default() };
    let scene = Scene { particles, solids: vec![solid], world, ..Scene::default() };
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(&scene, settings).expect("a valid scene")
}

fn plate(thickness: f64, restitution: f64) -> Solid {
    let size = DVec3::new(4.0, thickness, 4.0);
    Solid { restitution, ..Solid::new(Shape::Box { size }) }
}

/// Ways of a substep of up to a hundred times the thickness, from either side.
fn a_plate_is_a_wall<R: Real>() {
    let mut random = Random(7);
    for integrator in Integrator::ALL {
        for restitution in [0.0, 0.6] {
            for thickness in [0.2, 0.02, 0.002] {
                for side in [-1.0, 1.0] {
                    let speed = 5.0 + 20.0 * random.vector().x;
                    let from = DVec3::new(0.3, side * (0.1 + random.vector().x), 0.2);
                    let motion = (from, DVec3::new(0.5, -side * speed, 0.2));
                    let solid = plate(thickness, restitution);
                    let mut run = start::<R>(motion, solid, DVec3::ZERO, (integrator, 2));
                    (0..20).for_each(|_| run.step().expect("a calm run"));
                    let (height, speed_after) = {
                        let [x, v] = [run.position(0), run.velocity(0)].map(Vector::to_f64);
                        (x.y * side - 0.5 * thickness, v.y * side)
                    };
                    let off = 1e-4 * speed;
                    let name = format!("{integrator} {restitution} {thickness} {side}");
                    assert!(-1e-6 < height, "{name}: {height}");
                    assert!(
                        (speed_after - restitution * speed).abs() < off,
                        "{name}: {speed_after}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_thin_plate_is_a_wall_from_both_sides() {
    a_plate_is_a_wall::<f64>();
    a_plate_is_a_wall::<f32>();
}

/// A ball of 5 cm at 60 m/s is 12 cm further after a substep.
#[test]
fn a_small_ball_does_not_miss_what_is_in_its_way() {
    for integrator in Integrator::ALL {
        for offset in [0.0, 0.01, 0.03] {
            let mut ball = Solid::new(Shape::Sphere { radius: 0.05 });
            (ball.restitution, ball.velocity) = (1.0, DVec3::X * 60.0);
            ball.position = DVec3::new(-1.03, offset, 0.0);
            let motion = (DVec3::ZERO, DVec3::ZERO);
            let mut run = start::<f64>(motion, ball, DVec3::ZERO, (integrator, 8));
            (0..3).for_each(|_| run.step().expect("a calm run"));
            // The normal where it hits: twice the part of the velocity along it.
            let sine: f64 = -offset / 0.05;
            let cosine = (1.0 - sine * sine).sqrt();
            let expected = DVec3::new(cosine, sine, 0.0) * (120.0 * cosine);
            let off = run.velocity(0).distance(expected);
            assert!(off < 1e-2, "{integrator} {offset}: {}", run.velocity(0));
        }
    }
}

/// What goes through a box in a substep ends on the side where it went in, and nothing that passes
/// by is touched: against the intersection of a line with slabs.
#[test]
fn ways_through_a_box_end_where_they_went_in() {
    let mut random = Random(11);
    let (mut hits, mut misses) = (0, 0);
    for _ in 0..2000 {
        let size = DVec3::new(0.02, 0.3, 0.2) + random.vector() * DVec3::new(0.03, 0.1, 0.1);
        let [from, to] = [0, 1].map(|_| (random.vector() - 0.5) * 0.8);
        let half = size * 0.5;
        let far = (from.abs() - half).max_element() > 1e-3 && (to - from).length() > 0.3;
        if !far {
            continue;
        }
        let h = 1.0 / 60.0;
        let velocity = (to - from) / h;
        let solid = Solid::new(Shape::Box { size });
        let motion = (from, velocity);
        let mut run = start::<f64>(motion, solid, DVec3::ZERO, (Integrator::VelocityVerlet, 1));
        run.step().expect("a calm run");
        let way = to - from;
        let [low, high] = [-half, half].map(|side| (side - from) / way);
        let (enters, leaves) = (low.min(high), low.max(high));
        let part = enters.max_element();
        let is_hit = (0.0..1.0).contains(&part) && part < leaves.min_element();
        if !is_hit {
            assert!(run.velocity(0).distance(velocity) < 1e-12 * velocity.length());
            misses += 1;
            continue;
        }
        hits += 1;
        let axis = enters.to_array().iter().position(|&enter| enter == part).expect("an axis");
        let normal = DVec3::AXES[axis] * -way[axis].signum();
        let height = run.position(0).dot(normal) - half[axis];
        assert!(-1e-6 < height, "{from} to {to} through {size}: {height}");
        assert!(run.velocity(0).dot(normal).abs() < 1e-9 * velocity.length(), "{from} to {to}");
    }
    assert!(200 < hits && 200 < misses, "{hits} hits, {misses} misses");
}

/// The methods that hold by its velocity what lies on an obstacle.
const HOLDING: [Integrator; 2] = [Integrator::VelocityVerlet, Integrator::Rk4];

/// Friction takes back some of the way of a substep, along a tangent: by as much as would leave a
/// particle thousands of roundings above a ball.
#[test]
fn what_lands_on_a_rough_ball_is_on_it() {
    for integrator in HOLDING {
        for friction in [0.1, 2.0] {
            let mut ball = Solid::new(Shape::Sphere { radius: 0.5 });
            ball.friction = Friction::Coulomb(friction);
            let motion = (DVec3::new(-0.1, 0.7, 0.05), DVec3::new(0.8, -2.0, 0.3));
            let mut run = start::<f64>(motion, ball, DVec3::ZERO, (integrator, 1));
            while run.contacts().count == 0 {
                run.step().expect("a calm run");
            }
            let gap = run.position(0).length() - 0.5;
            assert!(gap.abs() < 1e-14, "{integrator} {friction}: {gap:e}");
        }
    }
}

/// At three quarters of the stable substep, by the middles of particles and by points between them.
#[test]
fn the_energy_of_a_soft_block_on_a_rough_solid_is_accounted_for() {
    let material = Material { mass: 0.01, stiffness: 60.0, damping: 0.05 };
    let mut block = shape::block([7, 7, 7], 0.1, material).expect("a block");
    block.place(DMat3::IDENTITY, DVec3::new(0.02, 1.0, 0.0));
    let mut ball = Solid::new(Shape::Sphere { radius: 0.25 });
    (ball.position.y, ball.friction) = (0.2, Friction::Coulomb(0.5));
    let mut rod = Solid::new(Shape::Capsule { radius: 0.03, length: 2.0 });
    rod.axes = rotation(DVec3::X, std::f64::consts::FRAC_PI_2);
    (rod.position, rod.friction, rod.springs) =
        (DVec3::new(0.05, 0.4, 0.0), Friction::Coulomb(0.5), true);
    for (integrator, solid) in HOLDING.iter().flat_map(|&by| [(by, &ball), (by, &rod)]) {
        let scene = Scene { solids: vec![solid.clone()], ..Scene::of("block", block.clone()) };
        let settings = Settings { integrator, substeps: 4, ..Settings::default() };
        let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
        let before = run.energy().total();
        let mut elastic = 0.0f64;
        for _ in 0..36 {
            run.step().expect("a calm run");
            elastic = elastic.max(run.energy().elastic);
        }
        let name = format!("{integrator} {:?}", solid.shape);
        assert!(1.0 < run.contacts().taken, "{name}: it has landed");
        // Velocity Verlet moves the energy of a mode by up to (h w)²/8 of itself; w is that of the
        // fastest here, by the substep of 2/w that is stable.
        let stable = run.stable_substep_of(Integrator::VelocityVerlet, settings.substeps);
        let part = (settings.substep() / stable).powi(2) / 2.0;
        let change = run.energy().total() - before;
        assert!(change.abs() < part * elastic, "{name}: {change} of {elastic}, {part}");
    }
}

/// A ball that goes into the floor leaves what lies there no room; one that stays above it does, as
/// does a groove of 60°.
#[test]
fn what_has_no_room_is_told() {
    let plane = |normal| {
        let friction = Friction::Coulomb(0.3);
        Plane { normal, offset: 0.0, restitution: 0.0, friction }
    };
    let (sine, cosine) = (0.5, 0.75f64.sqrt());
    let groove = [cosine, -cosine].map(|x| plane(DVec3::new(x, sine, 0.0))).to_vec();
    let ball = |speed: f64| {
        let ball = Solid::new(Shape::Sphere { radius: 0.25 });
        vec![Solid { position: DVec3::Y * 0.6, velocity: DVec3::Y * -speed, ..ball }]
    };
    let floor = vec![plane(DVec3::Y)];
    let cases =
        [(floor.clone(), ball(2.0), true), (floor, ball(1.0), false), (groove, Vec::new(), false)];
    // Dormand-Prince meets one after the other, in no time.
    let told = |&integrator: &Integrator| integrator != Integrator::DormandPrince;
    for integrator in Integrator::ALL.into_iter().filter(told) {
        for (planes, solids, expected) in cases.clone() {
            let (position, velocity) = (DVec3::new(0.01, 0.1, 0.0), DVec3::new(0.0, -1.0, 0.0));
            let particles = vec![Particle { position, velocity, mass: MASS }];
            let scene = Scene { particles, planes, solids, ..Scene::default() };
            let settings = Settings { integrator, ..Settings::default() };
            let mut run = Simulation::<f64>::new(&scene, settings).expect("a valid scene");
            (0..20).for_each(|_| run.step().expect("a calm run"));
            assert_eq!(run.contacts().squeezed, expected, "{integrator}: {scene:?}");
        }
    }
}
