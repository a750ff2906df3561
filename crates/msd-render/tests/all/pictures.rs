//! Pictures show the snapshot: facts about pixels, drawn without a window.
//!
//! Without any graphics adapter, not even a software one, each test says that it skips.

use crate::scenes::{
    Still, block, floor, gpu, particle, pin, plane, rope, scene_of, sheet, spring,
};
use glam::{DMat3, DVec3, Vec3};
use msd_core::{Grab, Look, Pattern, Plane, Scene, Shape, Solid, Vector};
use msd_render::{
    Camera, Gpu, Image, Offscreen, Quality, Quantity, RenderError, Renderer, Scale, Sheet, Style,
    View, bounds, render_image, scale_colour, wgpu,
};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;
const ASPECT: f32 = WIDTH as f32 / HEIGHT as f32;

fn draw(gpu: &Gpu, scene: &Scene, view: &View) -> Image {
    let still = Still::<f32>::new(scene);
    render_image(gpu, &still.snapshot(), view, WIDTH, HEIGHT).unwrap()
}

/// A view of the whole scene.
fn framed(scene: &Scene) -> View {
    let still = Still::<f32>::new(scene);
    let mut view = View::default();
    view.camera.frame(bounds(&still.snapshot()).unwrap(), ASPECT);
    view
}

fn pixel(image: &Image, x: u32, y: u32) -> [i32; 3] {
    let at = 4 * (y * image.width + x) as usize;
    [0, 1, 2].map(|part| i32::from(image.rgba[at + part]))
}

/// The colour where a point of the world appears.
fn seen_at(image: &Image, camera: &Camera, point: Vec3) -> [i32; 3] {
    let [x, y] = camera.project(point, image.width as f32 / image.height as f32).unwrap();
    let column = (x + 1.0) * 0.5 * image.width as f32;
    let row = (1.0 - y) * 0.5 * image.height as f32;
    pixel(image, column as u32, row as u32)
}

fn brightness(colour: [i32; 3]) -> i32 {
    colour.iter().sum()
}

/// Number of pixels that differ visibly.
fn difference(a: &Image, b: &Image) -> usize {
    let pairs = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| 8 < a.abs_diff(*b));
    pairs.filter(differs).count()
}

#[test]
fn the_same_snapshot_twice_is_the_same_picture() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(block(4), &[floor(-3.0)]);
    let view = View {
        style: Style { colour_by: Some(Quantity::Strain), ..Style::default() },
        ..framed(&scene)
    };
    let first = draw(&gpu, &scene, &view);
    assert_eq!(first, draw(&gpu, &scene, &view), "within one machine pictures are exact");
    assert_eq!(first.rgba.len(), (4 * WIDTH * HEIGHT) as usize);
    assert!(first.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255), "pictures are opaque");
}

#[test]
fn single_and_double_precision_look_the_same() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(block(3), &[floor(-3.0)]);
    let still = Still::<f64>::new(&scene);
    let view = framed(&scene);
    let double = render_image(&gpu, &still.snapshot(), &view, WIDTH, HEIGHT).unwrap();
    // These positions are exact in both precisions.
    assert_eq!(double, draw(&gpu, &scene, &view));
}

#[test]
fn the_background_is_a_light_blue_above_a_horizon_and_grey_below_it() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(block(2), &[]);
    let level = Camera { pitch: 0.0, ..framed(&scene).camera };
    let image = draw(&gpu, &scene, &View { camera: level, ..View::default() });
    for x in [0, WIDTH - 1] {
        let [red, green, blue] = pixel(&image, x, 0);
        assert!(red < green && green < blue && 150 < green, "above: {red} {green} {blue}");
        let [red, green, blue] = pixel(&image, x, HEIGHT - 1);
        let is_grey = (red - blue).abs() < 12 && (red - green).abs() < 12;
        assert!(is_grey && 130 < green, "below: {red} {green} {blue}");
    }
}

#[test]
fn the_edge_of_a_block_is_an_edge_and_a_curved_side_is_smooth() {
    let Some(gpu) = gpu() else { return };
    // Light along x alone: of a block turned by 45° one side has it, the other has none, up to
    // their edge in the middle of the picture.
    let scene = scene_of(block(4), &[]);
    let style = Style { light: Vec3::X, shadows: false, ..Style::default() };
    let camera = Camera { yaw: std::f32::consts::FRAC_PI_4, pitch: 0.0, ..framed(&scene).camera };
    let image = draw(&gpu, &scene, &View { camera, style });
    let beside = |by: f32| brightness(seen_at(&image, &camera, Vec3::new(1.5, 0.0, 1.5 - by)));
    let other = |by: f32| brightness(seen_at(&image, &camera, Vec3::new(1.5 - by, 0.0, 1.5)));
    assert!(other(0.1) + 100 < beside(0.1), "{} against {}", other(0.1), beside(0.1));
    for side in [&beside as &dyn Fn(f32) -> i32, &other] {
        let [near, far] = [side(0.1), side(1.5)];
        // The rest is the gloss, which changes with the angle of view.
        assert!((near - far).abs() < 60, "{near} near the edge, {far} in the middle");
    }
}

#[test]
fn a_look_has_its_colour_on_either_side_and_its_pattern() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(sheet(5, 4.0), &[]);
    scene.bodies[0].look = Look {
        colour: Some([0.8, 0.1, 0.1]),
        back: Some([0.1, 0.1, 0.8]),
        pattern: Pattern::Stripes,
        pattern_size: 1.0,
        ..Look::default()
    };
    let style = Style { shadows: false, ..Style::default() };
    let above = Camera { pitch: 1.2, yaw: 0.0, distance: 12.0, ..Camera::default() };
    let below = Camera { pitch: -1.2, ..above };
    let [top, bottom] = [above, below].map(|camera| draw(&gpu, &scene, &View { camera, style }));
    let place = Vec3::new(0.5, 0.0, 0.5);
    let [red, _, blue] = seen_at(&top, &above, place);
    let [other_red, _, other_blue] = seen_at(&bottom, &below, place);
    assert!(
        blue + 60 < red && other_red + 60 < other_blue,
        "{red} {blue}, {other_red} {other_blue}"
    );
    // Along v, which is z, four stripes of one metre; within one nothing changes.
    let at = |z: f32| brightness(seen_at(&top, &above, Vec3::new(0.0, 0.0, z)));
    let stripes = [-1.5, -0.5, 0.5, 1.5].map(at);
    for pair in stripes.windows(2) {
        assert!(15 < (pair[0] - pair[1]).abs(), "{stripes:?}");
    }
    assert!((at(0.3) - at(0.7)).abs() < 8, "{} and {}", at(0.3), at(0.7));
}

#[test]
fn the_floor_is_below_balls_that_lie_on_it_and_a_fast_picture_is_like_a_full_one() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(rope(2, 2.0), &[floor(0.0)]);
    scene.particles.iter_mut().for_each(|particle| particle.position.y = 0.0);
    let style = Style { particle_radius: 0.5, grid: false, ..Style::default() };
    let camera = Camera { pitch: 0.0, yaw: 0.0, distance: 12.0, ..Camera::default() };
    let view = View { camera, style };
    let image = draw(&gpu, &scene, &view);
    // The lower half of a ball is seen, in its colour.
    let [red, _, blue] = seen_at(&image, &camera, Vec3::new(-1.0, -0.3, 0.4));
    assert!(blue + 15 < red, "{red} {blue}: sunk into the floor");
    let still = Still::<f32>::new(&scene);
    let fast = Offscreen::with_quality(&gpu, [WIDTH, HEIGHT], Quality::Fast);
    let fast = fast.unwrap().render(&still.snapshot(), &view).unwrap();
    let changed = difference(&image, &fast);
    // Rims of shadows and of the balls.
    assert!(changed < (WIDTH * HEIGHT / 10) as usize, "{changed} pixels differ");
}

#[test]
fn springs_are_grey_at_rest_red_when_stretched_and_blue_when_compressed() {
    let Some(gpu) = gpu() else { return };
    let at = |x: f64, y: f64| particle(x, y, 0.0);
    let ends = [1.0, 0.0, -1.0].map(|y| [at(-2.0, y), at(2.0, y)]);
    let scene = Scene {
        particles: ends.as_flattened().to_vec(),
        // All are 4 m long: at rest, and stretched and compressed by more than 20 %.
        springs: vec![spring(0, 1, 4.0), spring(2, 3, 3.0), spring(4, 5, 6.0)],
        ..Scene::default()
    };
    let style = Style {
        colour_by: Some(Quantity::Strain),
        legend: false,
        line_width: 4.0,
        ..Style::default()
    };
    let view = View { style, ..framed(&scene) };
    let image = draw(&gpu, &scene, &view);
    let seen = |y: f32| seen_at(&image, &view.camera, Vec3::new(0.5, y, 0.0));
    let [red, green, blue] = seen(1.0);
    assert!((red - green).abs() < 12 && (green - blue).abs() < 12, "rest: {red} {green} {blue}");
    let [red, green, blue] = seen(0.0);
    assert!(green + 120 < red && blue + 120 < red, "stretched: {red} {green} {blue}");
    let [red, green, blue] = seen(-1.0);
    assert!(red + 120 < blue && green + 60 < blue, "compressed: {red} {green} {blue}");
}

/// Two springs of 4 m at the sides of the origin: one pulls with 500 N and stores 125 J, the other
/// pushes with 250 N and stores 31.25 J.
fn pulled_and_pushed() -> Scene {
    let ends = [1.0, -1.0].map(|y| [particle(-2.0, y, 0.0), particle(2.0, y, 0.0)]);
    Scene {
        particles: ends.as_flattened().to_vec(),
        // 1000 N/m: f = k (L − rest), E = k (L − rest)² / 2.
        springs: vec![spring(0, 1, 3.5), spring(2, 3, 4.25)],
        ..Scene::default()
    }
}

#[test]
fn springs_have_the_colours_of_their_force_and_energy() {
    let Some(gpu) = gpu() else { return };
    let scene = pulled_and_pushed();
    let view = framed(&scene);
    let seen = |quantity, full_scale, y: f32| {
        let style = Style {
            colour_by: Some(quantity),
            full_scale,
            legend: false,
            line_width: 4.0,
            ..view.style
        };
        let image = draw(&gpu, &scene, &View { style, ..view });
        seen_at(&image, &view.camera, Vec3::new(0.5, y, 0.0))
    };
    // The scale of these values ends at 500 N, and at 200 J.
    for (quantity, full, values) in
        [(Quantity::Force, 500.0, [500.0, -250.0]), (Quantity::Energy, 200.0, [125.0, 31.25])]
    {
        for (y, value) in [1.0, -1.0].into_iter().zip(values) {
            let colour = scale_colour(Scale { quantity, full }, value);
            let expected = colour.map(|part| (255.0 * part).round() as i32);
            for full_scale in [None, Some(full)] {
                let colour = seen(quantity, full_scale, y);
                // Lines are drawn in their colours; a step is the rounding of a byte.
                let apart = |part: usize| (colour[part] - expected[part]).abs();
                assert!(
                    (0..3).all(|part| apart(part) <= 1),
                    "{quantity:?} at {y}: {colour:?} for {expected:?}"
                );
            }
        }
    }
    // At ten times the scale the pull is nearly grey.
    let [red, green, blue] = seen(Quantity::Force, Some(5000.0), 1.0);
    assert!((red - blue).abs() < 60 && (red - green).abs() < 60, "{red} {green} {blue}");
}

#[test]
fn particles_and_surfaces_have_the_colours_of_their_speed() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(sheet(3, 2.0), &[]);
    let mut other = sheet(3, 2.0);
    other.place(DMat3::IDENTITY, DVec3::new(4.0, 0.0, 0.0));
    other.particles.iter_mut().for_each(|particle| particle.velocity = DVec3::new(0.0, 3.0, 4.0));
    scene.add("moving", other);
    scene.bodies[0].look.pattern = Pattern::Checks;
    let mut view = framed(&scene);
    view.camera.pitch = 1.2;
    view.style =
        Style { colour_by: Some(Quantity::Speed), shadows: false, legend: false, ..view.style };
    let image = draw(&gpu, &scene, &view);
    let seen = |x: f32| seen_at(&image, &view.camera, Vec3::new(x, 0.0, 0.3));
    // At rest the dark blue of no speed, and at 5 m/s, where the scale ends, the light yellow.
    let [red, green, blue] = seen(0.3);
    assert!(red + 30 < blue && green + 30 < blue && blue < 200, "at rest: {red} {green} {blue}");
    let [red, green, blue] = seen(4.3);
    assert!(blue + 60 < red && blue + 40 < green && 150 < red, "moving: {red} {green} {blue}");
    // All bodies at rest are of one colour, without their patterns.
    let patterned = Style { pattern: false, ..view.style };
    assert_eq!(image, draw(&gpu, &scene, &View { style: patterned, ..view }));
    // On a scale of 1000 m/s both rest.
    let slow = Style { full_scale: Some(1e3), ..view.style };
    let image = draw(&gpu, &scene, &View { style: slow, ..view });
    let [red, green, blue] = seen_at(&image, &view.camera, Vec3::new(4.3, 0.0, 0.3));
    assert!(red + 30 < blue && green + 30 < blue, "slow: {red} {green} {blue}");
}

#[test]
fn particles_have_the_colours_of_the_errors_that_are_known_alone() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(sheet(3, 2.0), &[]);
    let still = Still::<f32>::new(&scene);
    let Gpu { device, queue, .. } = &gpu;
    let mut renderer = Renderer::new(device, (Sheet::FORMAT, Quality::Full));
    let sheet = Sheet::new(&gpu, WIDTH, HEIGHT).unwrap();
    let view = framed(&scene);
    let mut picture = |errors: &[f32], colour_by| {
        let style = Style { colour_by, ..view.style };
        renderer.set_errors(errors.iter().copied());
        renderer.prepare(device, queue, &still.snapshot(), &View { style, ..view });
        let mut encoder = device.create_command_encoder(&Default::default());
        let whole = [0.0, 0.0, WIDTH as f32, HEIGHT as f32];
        renderer.draw(&mut encoder, &sheet.target(), [WIDTH, HEIGHT], whole);
        queue.submit([encoder.finish()]);
        sheet.read(&gpu).unwrap()
    };
    let by_error = Some(Quantity::Error);
    let own = picture(&[], None);
    assert_eq!(picture(&[1.0; 9], None), own, "nobody asked for them");
    assert_eq!(picture(&[1.0; 4], by_error), own, "not all are known");
    let known = picture(&[1.0; 9], by_error);
    assert!(500 < difference(&known, &own));
}

#[test]
fn a_line_that_passes_the_camera_is_drawn_and_does_not_flip() {
    let Some(gpu) = gpu() else { return };
    // The camera is at z = 20 and looks at the origin; the line starts 20 m behind it.
    let scene = Scene {
        particles: vec![particle(0.0, -1.0, 40.0), particle(0.0, -1.0, -10.0)],
        // Longer than at rest: it is red.
        springs: vec![spring(0, 1, 25.0)],
        ..Scene::default()
    };
    let camera = Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() };
    let style = Style {
        colour_by: Some(Quantity::Strain),
        legend: false,
        line_width: 4.0,
        ..Style::default()
    };
    let image = draw(&gpu, &scene, &View { camera, style });
    let [red, green, _] = seen_at(&image, &camera, Vec3::new(0.0, -1.0, 10.0));
    assert!(green + 60 < red, "the line is missing below the middle");
    let [red, green, _] = seen_at(&image, &camera, Vec3::new(0.0, 1.0, 10.0));
    assert!(red < green + 60, "the end behind the camera shows above the middle");
}

#[test]
fn a_floating_sheet_darkens_the_floor_below_it_and_nothing_else() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(sheet(5, 4.0), &[floor(-3.0)]);
    // Straight light, so that the shadow lies right below the sheet.
    let style = Style { light: Vec3::Y, grid: false, ..Style::default() };
    let camera = Camera { distance: 16.0, pitch: 0.15, ..Camera::default() };
    let lit = draw(&gpu, &scene, &View { camera, style: Style { shadows: false, ..style } });
    let shaded = draw(&gpu, &scene, &View { camera, style });
    let below = Vec3::new(0.0, -3.0, 0.0);
    let [before, after] = [&lit, &shaded].map(|image| brightness(seen_at(image, &camera, below)));
    // The sun is more than half of the light on the floor; sRGB shows a third of it as 3/5.
    assert!(after * 10 < before * 8, "{before} became {after}");
    let beside = Vec3::new(4.0, -3.0, 0.0);
    let [before, after] = [&lit, &shaded].map(|image| brightness(seen_at(image, &camera, beside)));
    assert!((before - after).abs() <= 6, "{before} became {after}");
}

#[test]
fn a_solid_that_is_larger_than_the_bodies_throws_a_shadow_beside_theirs() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(block(2), &[floor(-3.0)]);
    let mut roof = Solid::new(Shape::Box { size: DVec3::new(6.0, 0.2, 6.0) });
    roof.position = DVec3::Y * 1.2;
    scene.solids.push(roof);
    let style = Style { light: Vec3::Y, grid: false, ..Style::default() };
    let camera = Camera { distance: 16.0, pitch: 0.15, ..Camera::default() };
    let lit = draw(&gpu, &scene, &View { camera, style: Style { shadows: false, ..style } });
    let shaded = draw(&gpu, &scene, &View { camera, style });
    // The block reaches to 0.5 m from the middle, and the map of shadows one more block beyond it.
    let beside = Vec3::new(1.2, -3.0, 1.2);
    let [before, after] = [&lit, &shaded].map(|image| brightness(seen_at(image, &camera, beside)));
    assert!(after * 10 < before * 8, "{before} became {after}");
}

#[test]
fn a_half_space_is_drawn_where_it_is_as_a_plane_is() {
    let Some(gpu) = gpu() else { return };
    let slope = DMat3::from_rotation_z(0.5);
    let planes = scene_of(block(4), &[floor(-3.0), plane(slope.y_axis, -6.0)]);
    let mut solids = scene_of(block(4), &[]);
    for (axes, position) in [(DMat3::IDENTITY, DVec3::Y * -3.0), (slope, slope.y_axis * -6.0)] {
        solids.solids.push(Solid { position, axes, ..Solid::new(Shape::HalfSpace) });
    }
    let view = framed(&planes);
    let [moving, still] = [solids, planes].map(|scene| draw(&gpu, &scene, &view));
    assert_eq!(difference(&moving, &still), 0);
}

#[test]
fn a_flat_sheet_does_not_shadow_itself() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(sheet(9, 4.0), &[]);
    let view = framed(&scene);
    let bare = View { style: Style { shadows: false, ..view.style }, ..view };
    let changed = difference(&draw(&gpu, &scene, &view), &draw(&gpu, &scene, &bare));
    assert!(changed < 20, "{changed} pixels of acne");
}

#[test]
fn both_sides_of_a_sheet_are_lit_from_above() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(sheet(5, 4.0), &[]);
    let grey = Some([0.5; 3]);
    scene.bodies[0].look = Look { colour: grey, back: grey, ..Look::default() };
    let style = Style { pattern: false, shadows: false, light: Vec3::Y, ..Style::default() };
    let camera = Camera { pitch: 0.8, distance: 12.0, ..Camera::default() };
    let view = View { camera, style };
    let above = brightness(seen_at(&draw(&gpu, &scene, &view), &camera, Vec3::ZERO));
    for triangle in &mut scene.bodies[0].surface.triangles {
        triangle.swap(1, 2);
    }
    // Turned around, the same side of the same sheet is toward the viewer and the light.
    let turned = brightness(seen_at(&draw(&gpu, &scene, &view), &camera, Vec3::ZERO));
    assert!((above - turned).abs() <= 3, "{above} against {turned}");
}

#[test]
fn wireframe_particles_pins_and_grabs_each_change_the_picture() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene_of(sheet(6, 5.0), &[]);
    scene.bodies[0].look.pattern = Pattern::Checks;
    scene.pins = vec![pin(0), pin(5)];
    let view = framed(&scene);
    let off = Style { pins: false, grabs: false, ..view.style };
    let drawn = |style| draw(&gpu, &scene, &View { style, ..view });
    let coloured = Style { colour_by: Some(Quantity::Strain), legend: false, ..off };
    // With points of a pixel each the legend is more than half as high as the picture.
    let small = Style { pixels_per_point: 0.75, ..coloured };
    let [plain, bare] = [off, small].map(drawn);
    for (what, before, style) in [
        ("wireframe", &plain, Style { wireframe: true, ..off }),
        ("springs", &plain, coloured),
        ("particles", &plain, Style { particles: true, ..off }),
        ("pins", &plain, Style { pins: true, ..off }),
        ("pattern", &plain, Style { pattern: false, ..off }),
        ("legend", &bare, Style { legend: true, ..small }),
    ] {
        let changed = difference(before, &drawn(style));
        // Two marks of pins cover at least 4 x 4 pixels each, everything else much more.
        assert!(32 <= changed, "{what} changed {changed} pixels");
    }
    let still = Still::<f32>::new(&scene);
    let target = Vec3::new(0.0, 1.0, 0.0);
    let place = Vector::of(target.as_dvec3());
    let grab = Grab { particle: 14, target: place, stiffness: 1.0, damping: 1.0, max_force: 1.0 };
    let mut snapshot = still.snapshot();
    let grabs = [grab];
    snapshot.grabs = &grabs;
    let held =
        render_image(&gpu, &snapshot, &View { style: Style::default(), ..view }, WIDTH, HEIGHT);
    let [red, green, blue] = seen_at(&held.unwrap(), &view.camera, target);
    assert!(green + 60 < red && green + 20 < blue, "the handle is {red} {green} {blue}");
}

#[test]
fn a_plane_hides_what_is_under_its_front_and_shows_what_is_under_its_back() {
    let Some(gpu) = gpu() else { return };
    let camera = Camera { distance: 12.0, pitch: 0.4, ..Camera::default() };
    let view = View { camera, ..View::default() };
    // The eye is at y = 4.7, the plane at y = 2, and a blue block at the origin.
    let blueness = |plane: Plane| {
        let image = draw(&gpu, &scene_of(block(2), &[plane]), &view);
        let [red, _, blue] = seen_at(&image, &camera, Vec3::ZERO);
        blue - red
    };
    let through_front = blueness(floor(2.0));
    let through_back = blueness(plane(DVec3::NEG_Y, -2.0));
    assert!(through_front < 30, "the block shows through the floor: {through_front}");
    assert!(60 < through_back, "the block is hidden by the back of the floor: {through_back}");
}

#[test]
fn broken_and_empty_snapshots_are_drawn_without_harm() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(sheet(4, 3.0), &[floor(-1.0)]);
    let mut still = Still::<f64>::new(&scene);
    let style = Style {
        colour_by: Some(Quantity::Strain),
        particles: true,
        wireframe: true,
        ..Style::default()
    };
    let view = View { style, ..View::default() };
    for value in [f64::NAN, f64::INFINITY, 1e300, 1e12, 0.0] {
        still.positions[5] = DVec3::splat(value);
        render_image(&gpu, &still.snapshot(), &view, 64, 48).unwrap();
        still.positions.fill(DVec3::splat(value));
        render_image(&gpu, &still.snapshot(), &view, 64, 48).unwrap();
    }
    let mut empty = still.snapshot().with_positions(&[]);
    (empty.inverse_masses, empty.ends, empty.rest_lengths) = (&[], &[], &[]);
    (empty.planes, empty.grabs, empty.bodies) = (&[], &[], &[]);
    render_image(&gpu, &empty, &view, 64, 48).unwrap();
    // Columns that do not match: springs, surfaces and bodies of particles that are not there.
    let torn = still.snapshot().with_positions(&still.positions[..2]);
    render_image(&gpu, &torn, &view, 64, 48).unwrap();
    let broken = Style {
        full_scale: Some(f32::NAN),
        particle_radius: f32::NAN,
        line_width: f32::NAN,
        pixels_per_point: f32::NAN,
        light: Vec3::NAN,
        ..style
    };
    let view = View { style: broken, ..view };
    render_image(&gpu, &still.snapshot(), &view, 64, 48).unwrap();
}

#[test]
fn sizes_out_of_their_domain_are_refused_with_the_value() {
    let Some(gpu) = gpu() else { return };
    let limit = gpu.device.limits().max_texture_dimension_2d;
    for (width, height) in [(0, 10), (10, 0), (limit + 1, 10), (10, u32::MAX)] {
        let error = Offscreen::new(&gpu, width, height).unwrap_err();
        assert!(matches!(error, RenderError::Size { .. }), "{error}");
        assert!(error.to_string().contains(&format!("{width}x{height}")), "{error}");
    }
    let scene = scene_of(block(2), &[]);
    let still = Still::<f32>::new(&scene);
    let snapshot = still.snapshot();
    // One pixel, and a width whose rows are padded.
    for (width, height) in [(1, 1), (65, 3)] {
        let image = render_image(&gpu, &snapshot, &View::default(), width, height).unwrap();
        assert_eq!(image.rgba.len(), (4 * width * height) as usize);
    }
}

#[test]
fn any_viewport_and_format_is_drawn_without_a_validation_error() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(block(3), &[floor(-2.0)]);
    let still = Still::<f32>::new(&scene);
    for format in [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8UnormSrgb] {
        let mut renderer = Renderer::new(&gpu.device, (format, Quality::Full));
        for size in [[64, 48], [1, 1], [80, 20]] {
            let target = target(&gpu, format, size);
            let whole = [0.0, 0.0, size[0] as f32, size[1] as f32];
            let outside = [-10.0, 5.5, 1e6, 1e6];
            for viewport in [whole, outside, [20.2, 3.3, 7.7, 8.8], [0.0; 4], [f32::NAN; 4]] {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                // wgpu panics on a validation error that nobody asked for.
                renderer.draw(&mut encoder, &target, size, viewport);
                gpu.queue.submit([encoder.finish()]);
                let snapshot = still.snapshot();
                renderer.prepare(&gpu.device, &gpu.queue, &snapshot, &View::default());
            }
        }
    }
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
}

fn target(gpu: &Gpu, format: wgpu::TextureFormat, size: [u32; 2]) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

#[test]
fn without_a_sky_a_picture_is_transparent_beside_the_bodies_and_has_their_colours() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(block(4), &[]);
    let whole = framed(&scene);
    let style = Style { sky: false, ..whole.style };
    let [with, without] = [whole, View { style, ..whole }].map(|view| draw(&gpu, &scene, &view));
    let opacity = |at: usize| without.rgba[4 * at + 3];
    let pixels = (WIDTH * HEIGHT) as usize;
    assert_eq!((opacity(0), opacity(pixels - 1)), (0, 0));
    let solid: Vec<usize> = (0..pixels).filter(|&at| opacity(at) == 255).collect();
    assert!(pixels / 20 < solid.len(), "{} pixels of the block", solid.len());
    let colour = |image: &Image, at: usize| image.rgba[4 * at..4 * at + 3].to_vec();
    assert!(solid.iter().all(|&at| colour(&with, at) == colour(&without, at)));
    // The rim is as bright as the block beside it, not mixed with black.
    let rim = (0..pixels).filter(|&at| (64..192).contains(&opacity(at)));
    let darkest = solid
        .iter()
        .map(|&at| colour(&without, at).iter().map(|&part| i32::from(part)).sum::<i32>())
        .min();
    let rim_sum = |at: usize| colour(&without, at).iter().map(|&part| i32::from(part)).sum::<i32>();
    let (mut count, mut dark) = (0, 0);
    rim.for_each(|at| {
        count += 1;
        dark += usize::from(rim_sum(at) + 30 < darkest.unwrap_or(0));
    });
    assert!(10 < count && dark * 20 < count, "{dark} of {count} pixels of the rim are dark");
}
