//! Shade on the ground, in pictures that are to be cheap.
//!
//! Without any graphics adapter, not even a software one, the test says that it skips.

use crate::scenes::{Still, block, floor, gpu, scene_of};
use glam::Vec3;
use msd_render::{Camera, Offscreen, Quality, Style, View};

const SIZE: [u32; 2] = [320, 240];

#[test]
fn the_shade_below_a_body_is_grey_and_has_no_grain_in_a_fast_picture() {
    let Some(gpu) = gpu() else { return };
    // 3 m wide and 0.6 m high, its lower side 0.4 m above the floor.
    let mut scene = scene_of(block(4), &[floor(-0.7)]);
    scene.particles.iter_mut().for_each(|particle| particle.position.y *= 0.2);
    // The sun is so low that its shadow begins elsewhere.
    let light = Vec3::new(-0.9, 0.25, 0.0);
    let style = Style { grid: false, pattern: false, light, ..Style::default() };
    let camera = Camera { pitch: 0.4, yaw: 0.0, distance: 9.0, ..Camera::default() };
    let still = Still::<f32>::new(&scene);
    let image = Offscreen::with_quality(&gpu, SIZE, Quality::Fast)
        .and_then(|mut fast| fast.render(&still.snapshot(), &View { camera, style }))
        .expect("a picture");
    let brightness = |pixel: &[u8]| pixel[..3].iter().map(|&part| i32::from(part)).sum::<i32>();
    let pixels: Vec<i32> = image.rgba.chunks_exact(4).map(brightness).collect();
    // Below the body: its lower side is above the middle of the picture.
    let floor: Vec<&[i32]> = pixels.chunks_exact(SIZE[0] as usize).skip(150).collect();
    let bend = |part: &&[i32]| 9 < (part[0] - 2 * part[1] + part[2]).abs();
    // Rounding aside, no pixel of the floor is redder than the lit ones, which are a neutral grey.
    let redness = |pixel: &[u8]| i32::from(pixel[0]) - i32::from(pixel[2]);
    let floor_pixels = image.rgba[(150 * 4 * SIZE[0]) as usize..].chunks_exact(4);
    let reddest = floor_pixels.map(redness).max().expect("pixels");
    assert!(reddest <= 1, "the shade is brown: {reddest}");
    let grains = floor.iter().flat_map(|row| row.windows(3)).filter(bend).count();
    let [darkest, brightest] = [i32::min, i32::max]
        .map(|of| floor.iter().flat_map(|row| row.iter().copied()).reduce(of).expect("pixels"));
    assert!(30 < brightest - darkest, "no shade: from {darkest} to {brightest}");
    // At the rims of the shadow and of the body.
    assert!(grains < 300, "{grains} grains");
}
