//! Solids around bodies: they are in the picture, and do not hide its subject.
//!
//! Without any graphics adapter, not even a software one, a test says that it skips.

use crate::scenes::{Still, block, gpu, scene_of};
use glam::{DVec3, Vec3};
use msd_core::{Shape, Solid};
use msd_render::{View, bounds, bounds_with_solids, render_image};

fn solid(shape: Shape, position: DVec3) -> Solid {
    Solid { position, ..Solid::new(shape) }
}

#[test]
fn solids_near_bodies_count_as_a_whole_and_large_ones_by_what_is_near() {
    let mut scene = scene_of(block(2), &[]);
    let framed = |scene: &_| bounds_with_solids(&Still::<f64>::new(scene).snapshot()).unwrap();
    let alone = bounds(&Still::<f64>::new(&scene).snapshot()).unwrap();
    assert_eq!((alone, framed(&scene)), ((Vec3::splat(-0.5), Vec3::splat(0.5)), alone));
    // A post, turned by a right angle about z: its length lies along x.
    let mut post = solid(Shape::Cylinder { radius: 0.25, length: 2.0 }, DVec3::Y);
    post.axes = glam::DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);
    scene.solids = vec![post];
    assert_eq!(framed(&scene), (Vec3::new(-1.0, -0.5, -0.5), Vec3::new(1.0, 1.25, 0.5)));
    // A table of 40 m ends out of sight, and far parts do not count.
    scene.solids = vec![
        solid(Shape::Box { size: DVec3::new(40.0, 0.5, 40.0) }, DVec3::Y * -0.75),
        solid(Shape::Sphere { radius: 1.0 }, DVec3::X * 10.0),
        solid(Shape::HalfSpace, DVec3::Y * -5.0),
    ];
    assert_eq!(framed(&scene), (Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.0, 0.5, 2.0)));
}

#[test]
fn a_solid_that_hides_all_bodies_is_cut_open() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(block(3), &[]);
    let mut view = View::default();
    view.camera.frame((Vec3::splat(-3.0), Vec3::splat(3.0)), 1.0);
    let picture = |scene: &_, view: &View| {
        let still = Still::<f32>::new(scene);
        render_image(&gpu, &still.snapshot(), view, 120, 120).unwrap()
    };
    // The colour of the body: stone is grey.
    let coloured = |scene: &_, view: &View| {
        let pixels = picture(scene, view).rgba;
        let spread = |p: &&[u8]| 40 < p[..3].iter().max().unwrap() - p[..3].iter().min().unwrap();
        pixels.chunks_exact(4).filter(spread).count()
    };
    let bare = coloured(&scene, &view);
    scene.solids = vec![solid(Shape::Sphere { radius: 3.0 }, DVec3::ZERO)];
    // The near half of the body is before the section.
    let inside = coloured(&scene, &view);
    assert!(0 < bare && bare / 2 < inside, "{bare} pixels of the body, {inside} in a ball");
    // So it does from another side.
    view.camera.yaw += 2.0;
    let inside = coloured(&scene, &view);
    assert!(bare / 4 < inside, "{bare} pixels of the body, {inside} in a ball");
}
