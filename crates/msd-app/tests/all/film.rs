//! The whole window as images: scene, panels and pointer, frame by frame, without a display.
//!
//! Without a graphics adapter each test prints that it skips, unless `MSD_REQUIRE_ADAPTER` is set.
#![cfg(not(target_arch = "wasm32"))]

use egui::accesskit::Role;
use egui::{Event, Modifiers, PointerButton, Pos2, Vec2, pos2, vec2};
use image::{ColorType, ImageFormat};
use msd_app::session::{ErrorNow, Session};
use msd_app::viewer::{GuideStep, Preferences, Side, Viewer, catalogue};
use msd_app::window::Film;
use msd_core::Vector;
use msd_render::Image;
use msd_run::on;
use msd_run::rescue::Remedy;
use std::path::Path;

/// Time from one frame to the next, seconds.
const FRAME: f64 = 1.0 / 30.0;
/// Size of the window for the tour, pixels.
const TOUR: [u32; 2] = [1180, 800];

fn viewer(scene: &str) -> Viewer {
    let loaded = msd_scene::open(scene).expect("a built-in scene");
    Viewer::new(loaded, catalogue()).expect("a valid scene")
}

fn film(scene: &str, size: [u32; 2]) -> Option<Film> {
    film_of(viewer(scene), size)
}

/// Creates a film, or prints why that failed; CI has a driver, so there it must succeed.
fn film_of(viewer: Viewer, size: [u32; 2]) -> Option<Film> {
    let gpu = match msd_film::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            eprintln!("SKIPPED: no adapter: {error}");
            return None;
        }
    };
    Some(Film::new(viewer, gpu, size).expect("a picture of this size"))
}

fn wait(film: &mut Film, frames: usize) -> Image {
    (1..frames).for_each(|_| drop(film.frame(FRAME, Vec::new()).unwrap()));
    film.frame(FRAME, Vec::new()).unwrap()
}

fn button(at: Pos2, pressed: bool) -> Event {
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    Event::PointerButton { pos: at, button, pressed, modifiers }
}

/// Returns the middle particle of the upper face, nearest to the camera, and its screen position.
fn corner(film: &Film) -> (usize, Pos2) {
    let viewer = film.viewer();
    let positions: Vec<_> = on!(viewer.session.runner(), simulation => {
        simulation.positions().map(|position| position.to_f64().as_vec3()).collect()
    });
    let height = |at: &usize| positions[*at].y;
    let top = (0..positions.len()).map(|at| height(&at)).fold(f32::MIN, f32::max);
    let near = |at: &usize| viewer.camera.depth(positions[*at]);
    let upper = (0..positions.len()).filter(|at| top - 0.1 < height(at));
    let nearest = upper.min_by(|a, b| near(a).total_cmp(&near(b))).expect("a particle");
    (nearest, viewer.viewport().project(positions[nearest]).expect("in front of the camera"))
}

/// Returns the height of a particle, metres.
fn height(film: &Film, particle: usize) -> f64 {
    on!(film.viewer().session.runner(), simulation => simulation.position(particle).to_f64().y)
}

#[test]
fn what_the_user_does_shows_in_the_same_frame() {
    let Some(mut moved) = film("cube", [900, 560]) else { return };
    let mut still = film("cube", [900, 560]).expect("as before");
    assert_eq!(wait(&mut moved, 10), wait(&mut still, 10), "the same pictures without the user");
    let (particle, at) = corner(&moved);
    let shown = moved.frame(FRAME, vec![Event::PointerMoved(at)]).unwrap();
    assert_ne!(shown, wait(&mut still, 1), "the particle under the pointer is marked");
    for film in [&mut moved, &mut still] {
        film.frame(FRAME, vec![Event::PointerMoved(at), button(at, true)]).unwrap();
        assert_eq!(film.viewer().session.held(), Some(particle));
    }
    moved.frame(FRAME, vec![Event::PointerMoved(at - vec2(0.0, 80.0))]).unwrap();
    wait(&mut still, 1);
    assert!(
        height(&still, particle) + 0.01 < height(&moved, particle),
        "it moves in the frame of the event"
    );
}

#[test]
fn a_twin_beside_the_run_is_drawn_as_the_run_is() {
    let begin = |viewer: &mut Viewer| {
        let settings = viewer.session.runner().settings();
        let other = msd_core::Settings { integrator: msd_core::Integrator::Rk4, ..settings };
        viewer.session.toggle_pause();
        viewer.session.set_twin(Some(other));
        viewer.layout.side_by_side = true;
    };
    // The panels take 450 points: the rest divides by two.
    let mut viewer = viewer("cube");
    begin(&mut viewer);
    let Some(mut film) = film_of(viewer, [1050, 560]) else { return };
    let image = wait(&mut film, 3);
    let sides = [Side::Run, Side::Twin].map(|side| film.viewer().viewport_of(side).rect);
    let pixel = |at: Pos2| {
        let index = 4 * (at.y as usize * image.width as usize + at.x as usize);
        [image.rgba[index], image.rgba[index + 1], image.rgba[index + 2]]
    };
    // The middle of each shows the body, and a point far from it the sky, below the captions and
    // above the hint.
    for rect in sides {
        assert_ne!(pixel(rect.center()), pixel(rect.left_top() + vec2(12.0, 60.0)), "{rect}");
    }
    let (mut equal, mut all) = (0, 0);
    for row in 60..(sides[0].height() - 90.0) as usize {
        for column in 8..(sides[0].width() - 8.0) as usize {
            let at = vec2(column as f32, row as f32);
            let [a, b] = sides.map(|rect| pixel(rect.min + at));
            all += 1;
            // Colours are dithered by the position in the window.
            let is_near = |(a, b): (u8, u8)| a.abs_diff(b) <= 4;
            equal += usize::from(a.into_iter().zip(b).all(is_near));
        }
    }
    // Except for a few pixels on edges, which rounding may put on either side.
    assert!(0.99 * f64::from(all as u32) <= f64::from(equal as u32), "{equal} of {all}");
}

/// Returns the offset of the pointer from the grab: over to the cloth, up with it off the ball, to
/// and fro, and release above it.
fn path(seconds: f64) -> Vec2 {
    let keys: [(f64, Vec2); 7] = [
        (0.0, vec2(190.0, 150.0)),
        (1.0, vec2(0.0, 0.0)),
        (1.2, vec2(0.0, 0.0)),
        (2.3, vec2(-40.0, -170.0)),
        (2.9, vec2(40.0, -160.0)),
        (3.5, vec2(0.0, -170.0)),
        (4.1, vec2(0.0, -120.0)),
    ];
    let Some(next) = keys.iter().position(|key| seconds < key.0) else { return keys[6].1 };
    let ((from, a), (to, b)) = (keys[next - 1], keys[next]);
    let part = ((seconds - from) / (to - from)) as f32;
    a + (b - a) * (part * part * (3.0 - 2.0 * part))
}

/// Draws the pointer, normally drawn by the window system: a white disc, orange while pressed.
fn draw_pointer(image: &mut Image, at: Pos2, pressed: bool) {
    let fill = if pressed { [255, 140, 40] } else { [255, 255, 255] };
    let width = image.width as usize;
    for (index, pixel) in image.rgba.chunks_exact_mut(4).enumerate() {
        let distance = at.distance(Pos2::new((index % width) as f32, (index / width) as f32));
        if distance < 9.0 {
            pixel[..3].copy_from_slice(if distance < 7.0 { &fill } else { &[20, 22, 28] });
        }
    }
}

fn save(image: &Image, path: &Path) {
    let (rgba, format) = (ColorType::Rgba8, ImageFormat::Png);
    image::save_buffer_with_format(path, &image.rgba, image.width, image.height, rgba, format)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// Clicks a control at a fraction of its width.
fn click(film: &mut Film, (role, name): (Role, &str), part: f32) -> Pos2 {
    let place = film.place(role, name).unwrap_or_else(|| panic!("no {role:?} {name}"));
    let at = pos2(place.left() + part * place.width(), place.center().y);
    film.frame(FRAME, vec![Event::PointerMoved(at)]).unwrap();
    film.frame(FRAME, vec![button(at, true)]).unwrap();
    film.frame(FRAME, vec![button(at, false)]).unwrap();
    at
}

/// Runs frames until a session meets a condition, for at most ten seconds.
fn until(film: &mut Film, is_so: impl Fn(&Session) -> bool) -> Image {
    for _ in 0..300 {
        let image = wait(film, 1);
        if is_so(&film.viewer().session) {
            return image;
        }
    }
    panic!("it took more than ten seconds");
}

fn share(session: &Session) -> f64 {
    session.stability().map_or(0.0, |(share, _)| share)
}

/// Runs the five steps of the tour with the real controls, with an image for each.
fn tour(mut keep: impl FnMut(&str, Image)) {
    let mut viewer = viewer("cube");
    // The preferences of a new user.
    viewer.set_preferences(Preferences::default());
    let Some(mut film) = film_of(viewer, TOUR) else { return };
    wait(&mut film, 60);
    let at = corner(&film).1;
    film.frame(FRAME, vec![Event::PointerMoved(at)]).unwrap();
    film.frame(FRAME, vec![button(at, true)]).unwrap();
    let to = |part: f32| at + vec2(60.0, -90.0) * part;
    for frame in 1..=10u8 {
        film.frame(FRAME, vec![Event::PointerMoved(to(f32::from(frame) / 10.0))]).unwrap();
    }
    let mut image = wait(&mut film, 5);
    draw_pointer(&mut image, to(1.0), true);
    keep("grab", image);
    film.frame(FRAME, vec![button(to(1.0), false)]).unwrap();
    // At rest: a bent body would jump when it is made stiffer.
    wait(&mut film, 240);
    assert_eq!(film.viewer().layout.guide.and_then(|guide| guide.step()), Some(GuideStep::Stiffen));

    // Paused, as with too long a step there is no time to look at the meter.
    click(&mut film, (Role::Button, "Pause"), 0.5);
    let slider = film.place(Role::Slider, "Stiffness").expect("a slider");
    let at = |part: usize| slider.lerp_inside(vec2(part as f32 / 100.0, 0.5));
    film.frame(FRAME, vec![Event::PointerMoved(at(50)), button(at(50), true)]).unwrap();
    let (at, mut image) = (51..100)
        .find_map(|part| {
            film.frame(FRAME, vec![Event::PointerMoved(at(part))]).unwrap();
            let image = until(&mut film, |session| session.stability().is_some());
            (1.0 < share(&film.viewer().session)).then_some((at(part), image))
        })
        .expect("stiffer than the step allows");
    film.frame(0.0, vec![button(at, false)]).unwrap();
    assert!(film.viewer().session.failure().is_none(), "the meter says so before it happens");
    draw_pointer(&mut image, at, true);
    keep("stiffen", image);
    click(&mut film, (Role::Button, "Run"), 0.5);

    until(&mut film, |session| !session.offers().is_empty());
    keep("blow-up", wait(&mut film, 2));
    // The tour stays until the user has read that the run diverged.
    film.frame(4.0, Vec::new()).unwrap();
    let substeps = film.viewer().session.offers().iter().find_map(|offer| match offer.remedy {
        Remedy::Substeps(substeps) => Some(format!("{substeps} substeps")),
        _ => None,
    });
    click(&mut film, (Role::Button, &substeps.expect("more substeps are a way out")), 0.5);
    until(&mut film, |session| session.failure().is_none() && share(session) <= 1.0);
    keep("mend", wait(&mut film, 30));

    click(&mut film, (Role::CheckBox, "Estimate error"), 0.1);
    keep("cost", until(&mut film, |session| matches!(session.error(), Some(ErrorNow::Known(_)))));
    wait(&mut film, 2);
    assert_eq!(
        film.viewer().layout.guide.map(|guide| guide.step()),
        Some(None),
        "all steps are done"
    );
}

#[test]
#[ignore = "writes the pictures of the first five minutes into the folder MSD_FILM"]
fn pictures_of_the_first_five_minutes() {
    let folder = std::env::var_os("MSD_FILM").expect("MSD_FILM names a folder");
    tour(|name, image| save(&image, &Path::new(&folder).join(format!("{name}.png"))));
}

/// `scripts/pictures.sh` makes the picture of the README from it.
#[test]
#[ignore = "writes the frames of the picture of the README into the folder MSD_FILM"]
fn film_of_a_grab() {
    let folder = std::env::var_os("MSD_FILM").expect("MSD_FILM names a folder");
    let mut film = film("drape", [1200, 680]).expect("an adapter");
    let aside = Event::PointerMoved(pos2(400.0, 300.0));
    film.frame(FRAME, vec![aside]).unwrap();
    click(&mut film, (Role::CheckBox, "Follow"), 0.1);
    wait(&mut film, 150);
    let mut grabbed = corner(&film).1;
    let [grab, throw] = [1.1, 4.1].map(|seconds| (seconds / FRAME) as usize);
    for frame in 0..(6.0 / FRAME) as usize {
        if frame <= grab {
            grabbed = corner(&film).1;
        }
        let at = grabbed + path(frame as f64 * FRAME);
        let mut events = vec![Event::PointerMoved(at)];
        if frame == grab || frame == throw {
            events.push(button(at, frame == grab));
        }
        let mut image = film.frame(FRAME, events).unwrap();
        draw_pointer(&mut image, at, (grab..throw).contains(&frame));
        save(&image, &Path::new(&folder).join(format!("{frame:03}.png")));
    }
}
