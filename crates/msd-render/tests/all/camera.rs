//! The camera, and the pointer that finds objects in its view.

use crate::scenes::{Still, block, particle, scene_of};
use glam::{DVec3, Vec3};
use msd_core::Scene;
use msd_render::{Camera, bounds, drag_point, pick};

const ASPECT: f32 = 16.0 / 9.0;

fn cameras() -> Vec<Camera> {
    let mut cameras = Vec::new();
    for yaw in [-3.0, -0.7, 0.0, 0.6, 2.0] {
        for pitch in [-1.5, -0.3, 0.0, 0.35, 1.55] {
            let target = Vec3::new(1.0, -2.0, 3.0);
            cameras.push(Camera { target, distance: 17.0, yaw, pitch, fov_deg: 45.0 });
        }
    }
    cameras
}

#[test]
fn a_ray_through_a_projected_point_meets_the_point() {
    for camera in cameras() {
        for x in [-0.9f32, 0.0, 0.4] {
            for y in [-0.8f32, 0.0, 0.7] {
                let ray = camera.ray(x, y, ASPECT);
                let point = ray.origin + ray.direction * 12.0;
                let [px, py] = camera.project(point, ASPECT).unwrap();
                // Coordinates of about 20 m in f32 are rounded by 1e-6 m, seen over 12 m.
                assert!((px - x).abs() < 1e-5 && (py - y).abs() < 1e-5, "{camera:?}");
            }
        }
    }
}

#[test]
fn the_matrices_agree_with_the_projection() {
    for camera in cameras() {
        let point = Vec3::new(2.0, -1.0, 1.5);
        let clip = camera.view_projection(ASPECT) * point.extend(1.0);
        let [x, y] = camera.project(point, ASPECT).unwrap();
        assert!((clip.x / clip.w - x).abs() < 1e-5 && (clip.y / clip.w - y).abs() < 1e-5);
        // Depth is near / distance: between 0 at infinity and 1 at the near plane.
        let depth = camera.near() / camera.depth(point);
        assert!((clip.z / clip.w - depth).abs() < 1e-5);
    }
}

#[test]
fn what_is_behind_the_camera_is_not_projected() {
    for camera in cameras() {
        assert_eq!(camera.project(camera.eye() - camera.forward(), ASPECT), None);
        assert_eq!(camera.project(camera.eye(), ASPECT), None);
        assert_eq!(camera.project(Vec3::NAN, ASPECT), None);
    }
}

#[test]
fn a_framed_box_is_inside_the_picture_and_fills_most_of_it() {
    let (low, high) = (Vec3::new(-3.0, 2.0, -1.0), Vec3::new(5.0, 4.0, 9.0));
    for mut camera in cameras() {
        for aspect in [0.4, 1.0, ASPECT, 3.0] {
            camera.frame((low, high), aspect);
            let mut widest = 0.0f32;
            for corner in 0..8 {
                let choose =
                    |bit: i32, low: f32, high: f32| if corner & bit == 0 { low } else { high };
                let point = Vec3::new(
                    choose(1, low.x, high.x),
                    choose(2, low.y, high.y),
                    choose(4, low.z, high.z),
                );
                let [x, y] = camera.project(point, aspect).unwrap();
                assert!(x.abs() <= 1.0 && y.abs() <= 1.0, "{x} {y} {camera:?} {aspect}");
                widest = widest.max(x.abs()).max(y.abs());
            }
            // The corner that decides the distance is at 1 / 1.08 of the half picture.
            assert!((widest - 1.0 / 1.08).abs() < 1e-3, "{widest}");
        }
    }
}

#[test]
fn a_box_without_size_is_seen_from_the_default_distance() {
    let mut camera = Camera::default();
    camera.frame((Vec3::X, Vec3::X), ASPECT);
    assert_eq!((camera.target, camera.distance), (Vec3::X, Camera::default().distance));
}

#[test]
fn a_broken_camera_still_has_finite_matrices() {
    let broken = Camera {
        target: Vec3::NAN,
        distance: f32::NEG_INFINITY,
        yaw: f32::NAN,
        pitch: f32::INFINITY,
        fov_deg: 0.0,
    };
    for aspect in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(broken.view_projection(aspect).is_finite());
    }
    let mut camera = broken;
    camera.orbit(f32::NAN, 1.0);
    camera.zoom(f32::NAN);
    camera.pan(f32::INFINITY, 0.0);
    camera.frame((Vec3::NAN, Vec3::ONE), 0.0);
    assert!(camera.view_projection(1.0).is_finite());
}

#[test]
fn orbit_keeps_the_target_and_the_distance_and_never_turns_over() {
    let mut camera = Camera::default();
    camera.orbit(0.3, 10.0);
    assert!((camera.eye().distance(camera.target) - camera.distance).abs() < 1e-4);
    assert!(0.0 < camera.up().y, "the picture is upside down");
}

#[test]
fn panning_moves_the_target_with_the_pointer() {
    let mut camera = Camera::default();
    let before = camera.target;
    camera.pan(0.25, 0.1);
    // A quarter of the height to the right is half of the half height: y from −1 to 1 is a height.
    let [x, y] = camera.project(before, 1.0).unwrap();
    assert!((x - 0.5).abs() < 1e-4 && (y + 0.2).abs() < 1e-4, "{x} {y}");
}

#[test]
fn zoom_multiplies_the_distance_and_stays_in_its_domain() {
    let mut camera = Camera::default();
    camera.zoom(0.5);
    assert_eq!(camera.distance, 10.0);
    camera.zoom(1e-20);
    assert_eq!(camera.distance, 1e-3);
    camera.zoom(1e30);
    assert_eq!(camera.distance, 1e8);
}

#[test]
fn bounds_leave_out_what_is_not_finite() {
    let scene = scene_of(block(2), &[]);
    let mut still = Still::<f64>::new(&scene);
    still.positions[0] = DVec3::NAN;
    still.positions[1] = DVec3::splat(f64::INFINITY);
    let (low, high) = bounds(&still.snapshot()).unwrap();
    assert_eq!((low, high), (Vec3::splat(-0.5), Vec3::splat(0.5)));
    still.positions.fill(DVec3::NAN);
    assert_eq!(bounds(&still.snapshot()), None);
}

#[test]
fn picking_takes_the_front_of_two_particles_in_line() {
    let mut scene = Scene::default();
    for z in [0.0, -5.0, 3.0] {
        scene.particles.push(particle(0.0, 0.0, z));
    }
    scene.particles.push(particle(4.0, 0.0, 3.0));
    let still = Still::<f32>::new(&scene);
    let snapshot = still.snapshot();
    let camera = Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() };
    let size = [800.0, 600.0];
    assert_eq!(pick(&snapshot, &camera, [403.0, 299.0], size, 12.0), Some(2));
    // Particle 3 is 17 m away and 4 m aside: 4 / (17 tan 19°) of half the height of 300 pixels.
    let aside = 4.0 / (17.0 * 19.0f32.to_radians().tan()) * 300.0;
    assert_eq!(pick(&snapshot, &camera, [400.0 + aside, 300.0], size, 2.0), Some(3));
    assert_eq!(pick(&snapshot, &camera, [100.0, 100.0], size, 12.0), None);
    assert_eq!(pick(&snapshot, &camera, [f32::NAN, 0.0], size, 12.0), None);
    assert_eq!(pick(&snapshot, &camera, [0.0, 0.0], [0.0, 0.0], 12.0), None);
}

#[test]
fn dragging_stays_at_the_depth_of_the_particle_and_under_the_pointer() {
    for camera in cameras() {
        let through = Vec3::new(0.5, -1.0, 2.0);
        let ray = camera.ray(0.3, -0.2, ASPECT);
        let point = drag_point(&camera, &ray, through);
        assert!((camera.depth(point) - camera.depth(through)).abs() < 1e-4);
        let [x, y] = camera.project(point, ASPECT).unwrap();
        assert!((x - 0.3).abs() < 1e-5 && (y + 0.2).abs() < 1e-5);
    }
    let camera = Camera::default();
    let mut backwards = camera.ray(0.0, 0.0, ASPECT);
    backwards.direction = -backwards.direction;
    assert_eq!(drag_point(&camera, &backwards, Vec3::X), Vec3::X);
}

#[test]
fn a_camera_below_ground_rises_above_it_and_another_stays() {
    let below = Camera { pitch: -0.5, distance: 10.0, ..Camera::default() };
    let mut raised = below;
    raised.rise_above(-1.0);
    // A fiftieth of the distance above the ground, in single precision.
    assert!((raised.eye().y + 0.8).abs() < 1e-4, "{}", raised.eye().y);
    assert_eq!((raised.target, raised.yaw), (below.target, below.yaw));
    let above = Camera { pitch: 0.3, ..below };
    let mut kept = above;
    kept.rise_above(-1.0);
    assert_eq!(kept, above);
    // Ground far above the target: no pitch would do.
    let mut lost = above;
    lost.rise_above(100.0);
    assert_eq!(lost, above);
}
