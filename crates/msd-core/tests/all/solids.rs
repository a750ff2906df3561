//! Solids of a shape: their surfaces, their motion and their refusals. `contact/` tests collisions
//! with them.

use crate::common::{Random, grid_of_ball};
use msd_core::glam::{DMat3, DVec3};
use msd_core::obstacles::Placed;
use msd_core::scene::solid::rotation;
use msd_core::{
    DistanceGrid, Friction, Integrator, Interaction, KeyFrame, Particle, Real, Scene, Settings,
    Shape, Simulation, Solid, Vector, testing,
};
use std::sync::Arc;

const SHAPES: [Shape; 5] = [
    Shape::Sphere { radius: 0.7 },
    Shape::Capsule { radius: 0.4, length: 1.1 },
    Shape::Box { size: DVec3::new(0.8, 1.2, 0.5) },
    Shape::Cylinder { radius: 0.6, length: 0.9 },
    Shape::Torus { radius: 0.8, tube: 0.25 },
];

fn scene(position: DVec3, velocity: DVec3, solids: Vec<Solid>) -> Scene {
    let particles = vec![Particle { position, velocity, mass: 0.3 }];
    Scene { particles, solids, ..Scene::default() }
}

fn simulation<R: Real>(scene: &Scene, integrator: Integrator, substeps: u32) -> Simulation<R> {
    let settings = Settings { integrator, substeps, ..Settings::default() };
    Simulation::new(scene, settings).expect("a valid scene")
}

#[test]
fn the_normal_is_the_gradient_of_the_gap_still_and_moving() {
    let mut random = Random(3);
    for shape in &SHAPES {
        let points: Vec<DVec3> = (0..200).map(|_| (random.vector() - 0.5) * 4.0).collect();
        let mut solid = Solid::new(shape.clone());
        assert_eq!(testing::check_obstacle(&solid, &points, 0.0), Ok(()), "{shape:?}");
        solid.axes = rotation(DVec3::new(2.0, -1.0, 2.0) / 3.0, 0.8);
        solid.position = DVec3::new(0.2, 0.1, -0.3);
        (solid.velocity, solid.spin) = (DVec3::X * 0.4, DVec3::new(0.5, -0.2, 0.9));
        assert_eq!(testing::check_obstacle(&solid, &points, 1.7), Ok(()), "{shape:?}");
    }
}

#[test]
fn gaps_are_distances_and_nothing_is_beyond_the_reach() {
    let mut random = Random(5);
    let anywhere = (0..500).map(|_| (random.vector() - 0.5) * 4.0);
    // On the axis, where the round side is as near all round.
    let on_axis = [-0.9, -0.55, -0.3, 0.0, 0.2, 0.44, 0.7].map(|y| DVec3::Y * y);
    let points: Vec<DVec3> = anywhere.chain(on_axis).collect();
    for shape in &SHAPES {
        for &point in &points {
            // The way back along the normal, or out against it, ends on the surface.
            let foot = point - shape.normal(point) * shape.gap(point);
            assert!(shape.gap(foot).abs() < 1e-14, "{shape:?} {point}");
            assert!(foot.length() < shape.reach() + 1e-14, "{shape:?} {point}");
        }
    }
    assert_eq!(SHAPES[2].gap(DVec3::new(0.7, 1.0, 0.0)), 0.5);
    assert_eq!(SHAPES[3].gap(DVec3::new(0.0, 0.2, 0.0)), 0.2 - 0.45);
    assert!((SHAPES[4].gap(DVec3::ZERO) - 0.55).abs() < 1e-15);
}

#[test]
fn solids_are_kept_by_checkpoints_conversions_and_moves() {
    let mut ball = Solid::new(Shape::Sphere { radius: 1.0 });
    ball.spin = DVec3::Z;
    let start = scene(DVec3::Y, DVec3::X * 0.1, vec![ball.clone()]);
    let mut run = simulation::<f64>(&start, Integrator::VelocityVerlet, 8);
    (0..20).for_each(|_| run.step().expect("a calm run"));
    let (rows, progress) = run.progress();
    assert_eq!(rows.solids, [ball.clone()]);
    let mut resumed = Simulation::<f64>::resume(&rows, &progress).expect("a checkpoint");
    (0..20).for_each(|_| (run.step().unwrap(), resumed.step().unwrap()).0);
    assert_eq!(run.state(), resumed.state());
    assert_eq!(run.convert::<f32>().expect("it fits").model().solids(), [ball.clone()]);
    let moved = start.moved(DVec3::X * 3.0);
    assert_eq!(moved.solids[0].position, DVec3::X * 3.0);
    let far = scene(DVec3::Y * 9.0, DVec3::ZERO, vec![ball]);
    assert_eq!(Vector::to_f64(simulation::<f32>(&far, Integrator::Rk4, 1).position(0)).y, 9.0);
}

#[test]
fn what_is_no_solid_is_refused() {
    let refused = |change: &dyn Fn(&mut Solid)| {
        let mut solid = Solid::new(Shape::Sphere { radius: 1.0 });
        change(&mut solid);
        let scene = scene(DVec3::Y * 3.0, DVec3::ZERO, vec![solid]);
        Simulation::<f64>::new(&scene, Settings::default()).expect_err("refused").to_string()
    };
    let radius = refused(&|solid| solid.shape = Shape::Sphere { radius: 0.0 });
    assert!(radius.contains("radius") && radius.contains("solid 0"), "{radius}");
    let tube = refused(&|solid| solid.shape = Shape::Torus { radius: 1.0, tube: 1.0 });
    assert!(tube.contains("smaller than the radius"), "{tube}");
    assert!(refused(&|solid| solid.spin.y = f64::NAN).contains("spin"));
    assert!(refused(&|solid| solid.axes.x_axis.x = 2.0).contains("rotation"));
    assert!(refused(&|solid| solid.axes.x_axis.x = f64::NAN).contains("rotation"));
    assert!(refused(&|solid| solid.restitution = 1.5).contains("restitution"));
    let grid = |change: &dyn Fn(&mut DistanceGrid)| {
        let mut grid = grid_of_ball(1.0, 0.5);
        change(&mut grid);
        refused(&|solid| solid.shape = Shape::Mesh(Arc::new(grid.clone())))
    };
    assert!(grid(&|grid| grid.counts[1] = 1).contains("at least 2"));
    assert!(grid(&|grid| grid.counts = [usize::MAX; 3]).contains("at most 4194304"));
    assert!(grid(&|grid| grid.distances.truncate(9)).contains("that of the points"));
    assert!(grid(&|grid| grid.distances[3] = f64::NAN).contains("length of solid 0 is NaN"));
    assert!(grid(&|grid| grid.cell = 0.0).contains("edge of a cell"));
    assert!(grid(&|grid| grid.triangles.push([0, 0, 0])).contains("corner"));
    let keys = |times: [f64; 2], position: DVec3| {
        let key = |time| KeyFrame { time, position, axes: DMat3::IDENTITY };
        refused(&|solid| solid.keys = times.map(key).to_vec())
    };
    assert!(keys([2.0, 1.0], DVec3::ZERO).contains("key frame of solid 0 is 1; it must be later"));
    assert!(keys([0.0, 1.0], DVec3::ZERO).contains("key frame of solid 0 is 0; it must be later"));
    assert!(keys([1.0, f64::INFINITY], DVec3::ZERO).contains("it must be later"));
    assert!(keys([1.0, 2.0], DVec3::NAN).contains("position of a key frame"));
    let both = refused(&|solid| {
        solid.keys = vec![KeyFrame { time: 1.0, position: DVec3::X, axes: DMat3::IDENTITY }];
        solid.spin = DVec3::X;
    });
    assert!(both.contains("beside key frames"), "{both}");
}

/// A solid that goes through places and turns that no formula knows.
fn wanderer(shape: Shape) -> Solid {
    let mut random = Random(11);
    let key = |number: i32| KeyFrame {
        time: 0.4 * f64::from(number) + 0.1 * f64::from(number % 2),
        position: random.vector() - 0.5,
        axes: rotation(random.vector().normalize(), 2.5 * f64::from(number % 3)),
    };
    Solid { keys: (1..6).map(key).collect(), ..Solid::new(shape) }
}

#[test]
fn a_motion_through_key_frames_is_smooth_and_passes_through_each() {
    let solid = wanderer(Shape::Box { size: DVec3::new(0.8, 1.2, 0.5) });
    let start = KeyFrame { time: 0.0, position: DVec3::ZERO, axes: DMat3::IDENTITY };
    let keys: Vec<_> = [start].iter().chain(&solid.keys).copied().collect();
    for key in &keys {
        let placed = Placed::new(&solid, key.time);
        assert!((placed.middle - key.position).length() < 1e-15, "{key:?}");
        let off = placed.axes - key.axes;
        assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-14), "{key:?}: {off}");
    }
    let step = 1e-6;
    for tick in 0..2500 {
        let time = 1e-3 * f64::from(tick) - 0.1;
        let [before, now, after] =
            [time - step, time, time + step].map(|time| Placed::new(&solid, time));
        let velocity = (after.middle - before.middle) / (2.0 * step);
        // Differences are right to the square of the step, and to its length where the
        // acceleration jumps, at a key frame.
        assert!((velocity - now.velocity).length() < 1e-4, "{time}: {velocity}");
        let turned = (after.axes - before.axes) * (0.5 / step);
        for axis in 0..3 {
            let carried = now.spin.cross(now.axes.col(axis));
            let off = (turned.col(axis) - carried).length();
            assert!(off < 1e-3, "{time}, {axis}: {off} of {}", now.spin.length());
        }
        // No coordinate leaves the range of the key frames around it.
        let next = keys.partition_point(|key| key.time <= time);
        let [low, high] =
            [next.saturating_sub(1), next.min(keys.len() - 1)].map(|index| keys[index].position);
        let (low, high) = (low.min(high) - 1e-15, low.max(high) + 1e-15);
        assert!(now.middle.cmpge(low).all() && now.middle.cmple(high).all(), "{time}");
    }
    let points: Vec<DVec3> = (0..50).map(|n| DVec3::new(0.1, 0.05, 0.0) * f64::from(n)).collect();
    assert_eq!(testing::check_obstacle(&solid, &points, 1.03), Ok(()));
}

/// Key frames that a steady motion passes through give that motion, but for its start and its end.
#[test]
fn steady_key_frames_move_steadily() {
    let (velocity, spin) = (DVec3::new(0.3, -0.2, 0.1), DVec3::new(0.4, 0.8, -0.3));
    let key = |time: f64| {
        let axes = rotation(spin.normalize(), spin.length() * time);
        KeyFrame { time, position: velocity * time, axes }
    };
    // The longest turn, from 1 s to 4 s, is by 2.8 rad.
    let keys = [1.0, 4.0, 6.0].map(key).to_vec();
    let solid = Solid { keys, ..Solid::new(Shape::Sphere { radius: 1.0 }) };
    for time in [1.0, 1.5, 2.5, 3.9] {
        let placed = Placed::new(&solid, time);
        assert!((placed.velocity - velocity).length() < 1e-14, "{time}: {}", placed.velocity);
        assert!((placed.spin - spin).length() < 1e-13, "{time}: {}", placed.spin);
        assert!((placed.middle - velocity * time).length() < 1e-14, "{time}");
    }
    for time in [0.0, 6.0, 20.0] {
        assert_eq!(Placed::new(&solid, time).velocity, DVec3::ZERO);
    }
}

#[test]
fn a_solid_that_is_moved_goes_on_as_one_that_always_did_so() {
    let thrown = scene(DVec3::Y * 1.2, DVec3::X * 0.2, Vec::new());
    let with = |solid: Solid| Scene { solids: vec![solid], ..thrown.clone() };
    let mut moving = Solid::new(Shape::Sphere { radius: 1.0 });
    moving.position = DVec3::new(0.1, -0.2, 0.3);
    (moving.velocity, moving.spin) = (DVec3::new(0.0, 0.3, -0.1), DVec3::Z);
    moving.friction = Friction::Coulomb(0.4);
    let solid = Solid { keys: wanderer(moving.shape.clone()).keys, ..moving.clone() };
    let solid = Solid { velocity: DVec3::ZERO, spin: DVec3::ZERO, ..solid };
    let act = Interaction::MoveSolid {
        solid: 0,
        position: moving.position,
        velocity: moving.velocity,
        spin: moving.spin,
    };
    for integrator in Integrator::ALL {
        let mut steady = simulation::<f64>(&with(moving.clone()), integrator, 20);
        let mut moved = simulation::<f64>(&with(solid.clone()), integrator, 20);
        moved.queue(act).expect("there is such a solid");
        (0..30).for_each(|_| (steady.step().unwrap(), moved.step().unwrap()).0);
        assert!(0 < steady.contacts().count, "{integrator}: it meets the solid");
        assert_eq!(steady.state(), moved.state(), "{integrator}");
        // Moved again on its way, and resumed from a checkpoint.
        let again = Interaction::MoveSolid {
            solid: 0,
            position: DVec3::new(0.1, -0.1, 0.3),
            velocity: DVec3::Y,
            spin: DVec3::X,
        };
        moved.queue(again).expect("there is such a solid");
        (0..10).for_each(|_| moved.step().expect("a calm run"));
        let (rows, progress) = moved.progress();
        let mut resumed = Simulation::<f64>::resume(&rows, &progress).expect("a checkpoint");
        (0..20).for_each(|_| (moved.step().unwrap(), resumed.step().unwrap()).0);
        assert_eq!(moved.state(), resumed.state(), "{integrator}");
        let place = Placed::new(&moved.model().solids()[0], 1.0).middle;
        assert!((place - DVec3::new(0.1, 0.4, 0.3)).length() < 1e-12, "{place}");
    }
}

#[test]
fn a_step_that_fails_leaves_solids_where_they_were() {
    let solid = wanderer(Shape::Sphere { radius: 0.3 });
    let mut run = simulation::<f64>(
        &scene(DVec3::Y * 3.0, DVec3::ZERO, vec![solid.clone()]),
        Integrator::SymplecticEuler,
        4,
    );
    let (position, velocity, spin) = (DVec3::X, DVec3::ZERO, DVec3::ZERO);
    run.queue(Interaction::MoveSolid { solid: 0, position, velocity, spin }).expect("a solid");
    let push = Interaction::Push { particle: 0, force: DVec3::X * 1e30 };
    run.queue(push).expect("a particle");
    assert!(run.step().is_err());
    assert_eq!(run.model().solids(), [solid]);
    let none = Interaction::MoveSolid { solid: 1, position, velocity, spin };
    let refused = run.queue(none).expect_err("no such solid").to_string();
    assert!(refused.contains("solid 1"), "{refused}");
}

/// Whatever a gap moves out lies on the interpolated surface, whose error is that of a chord.
#[test]
fn the_gap_of_a_grid_is_the_way_to_its_surface() {
    let mut random = Random(7);
    let radius = 0.7;
    for cell in [0.2, 0.1, 0.05] {
        let grid = grid_of_ball(radius, cell);
        for _ in 0..500 {
            let point =
                (random.vector() - 0.5).normalize() * (radius + (random.unit() - 0.5) * cell);
            let (gap, normal) = (grid.gap(point), grid.normal(point));
            let foot = point - normal * gap;
            assert!(grid.sample(foot).0.abs() < 1e-15, "{cell} {point}: {}", grid.sample(foot).0);
            // A trilinear interpolant is off by at most 3/8 of the second derivatives, which are
            // 1/r, times the square of the cell.
            let error = 0.375 * cell * cell / (radius - cell);
            assert!((foot.length() - radius).abs() < error, "{cell} {point}: {}", foot.length());
        }
        // Beyond the grid the way to it counts.
        let far = DVec3::new(3.0, 0.2, -0.1);
        assert!((grid.gap(far) - (far.length() - radius)).abs() < 0.1);
        assert!((grid.normal(far).length() - 1.0).abs() < 1e-15);
    }
}
