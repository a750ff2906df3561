//! A film from the window: the states of the timeline, written by a thread while the run continues.
#![cfg(feature = "window")]

use crate::common::names;
use crate::frames::FRAME;
use msd_app::viewer::{Command, FilmFormat, Viewer, catalogue};
use msd_render::{Gpu, Style, View, render_image};
use msd_run::on;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::{Duration, Instant};

/// Returns the chain after a second, in a view of 120 x 80 points; `None` without graphics.
fn viewer(folder: &Path) -> Option<(Viewer, Gpu)> {
    let gpu = match msd_film::open_gpu() {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "{error}");
            eprintln!("SKIPPED: no adapter: {error}");
            return None;
        }
    };
    let loaded = msd_scene::open("chain").expect("a built-in scene");
    let mut viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    viewer.folder = folder.to_owned();
    viewer.layout.rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(120.0, 80.0));
    viewer.frame_all();
    viewer.aim.follow = false;
    viewer.session.advance(0.0, &|| 0.0);
    step(&mut viewer, 60);
    Some((viewer, gpu))
}

fn step(viewer: &mut Viewer, frames: usize) {
    (0..frames).for_each(|_| {
        viewer.session.advance(FRAME + 1e-9, &|| 0.0);
    });
}

/// Waits for the end of a film, and returns its message.
fn wait(viewer: &mut Viewer) -> String {
    let start = Instant::now();
    while viewer.follow_film() {
        assert!(start.elapsed() < Duration::from_secs(120), "it does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
    viewer.note.clone().expect("what came of it")
}

#[test]
fn a_film_has_the_states_of_the_timeline_as_they_are_looked_at() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((mut viewer, gpu)) = viewer(folder.path()) else { return };
    // Looking back has no effect: later states are filmed too.
    viewer.look_back(7);
    viewer.film(FilmFormat::WebP);
    // One film at a time, while the run continues.
    viewer.film(FilmFormat::Png);
    assert_eq!(viewer.filming.as_ref().map(|filming| filming.progress()[1]), Some(31));
    assert_eq!(wait(&mut viewer), {
        let name = folder.path().join("chain-1.webp");
        format!("saved {}, 31 frames", name.display())
    });
    assert_eq!(names(folder.path()), ["chain-1.webp"]);
    let file = BufReader::new(File::open(folder.path().join("chain-1.webp")).expect("a film"));
    let mut decoder = image_webp::WebPDecoder::new(file).expect("a WebP file");
    assert_eq!((decoder.dimensions(), decoder.num_frames()), ((120, 80), 31));
    let mut frame = vec![0; decoder.output_buffer_size().expect("a size")];
    for _ in 0..31 {
        let lasting = decoder.read_frame(&mut frame).expect("a frame");
        assert!((33..=34).contains(&lasting), "{lasting} ms");
    }
    viewer.film(FilmFormat::Png);
    wait(&mut viewer);
    let view = View { camera: viewer.camera, style: viewer.style };
    for number in 0..31 {
        let path = folder.path().join(format!("chain-1.frames/{number:04}.png"));
        let frame = image::open(path).expect("a picture").into_rgba8().into_raw();
        // Every second of the 61 states from the first to the last.
        viewer.look_back(60 - 2 * number);
        let image = on!(viewer.session.runner(), simulation => {
            render_image(&gpu, &simulation.snapshot(), &view, 120, 80)
        });
        assert!(frame == image.expect("a picture").rgba, "frame {number}");
    }
}

#[test]
fn a_film_as_pictures_has_one_per_frame_and_what_is_cancelled_leaves_no_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((mut viewer, _)) = viewer(folder.path()) else { return };
    viewer.film(FilmFormat::Png);
    let told = wait(&mut viewer);
    assert!(told.starts_with("saved ") && told.ends_with("31 frames"), "{told}");
    assert_eq!(names(folder.path()), ["chain-1.frames"]);
    let pictures = names(&folder.path().join("chain-1.frames"));
    assert_eq!((pictures.len(), &*pictures[30]), (31, "0030.png"));
    step(&mut viewer, 240);
    viewer.film(FilmFormat::WebP);
    viewer.filming.as_ref().expect("it is being written").cancel();
    assert_eq!(wait(&mut viewer), "the film was cancelled");
    // Nor does a dropped film, as when the window closes.
    viewer.film(FilmFormat::WebP);
    drop(viewer);
    assert_eq!(names(folder.path()), ["chain-1.frames"]);
}

#[test]
fn a_film_that_cannot_be_written_is_told_of_and_the_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((mut viewer, _)) = viewer(&folder.path().join("gone")) else { return };
    for format in [FilmFormat::WebP, FilmFormat::Png] {
        viewer.film(format);
        let told = wait(&mut viewer);
        assert!(told.contains("gone") && told.contains("chain-1"), "{told}");
    }
    let steps = viewer.session.runner().steps();
    viewer.command(Command::StepForward);
    assert_eq!(viewer.session.runner().steps(), steps + 1);
}

#[test]
fn a_key_takes_a_picture_of_what_is_seen_and_not_of_the_timeline() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some((mut viewer, gpu)) = viewer(folder.path()) else { return };
    viewer.look_back(7);
    viewer.command(Command::Picture);
    let told = wait(&mut viewer);
    assert_eq!(told, format!("saved {}", folder.path().join("chain-1.png").display()));
    let view = View { camera: viewer.camera, style: Style { legend: true, ..viewer.style } };
    let image = on!(viewer.session.runner(), simulation => {
        render_image(&gpu, &simulation.snapshot(), &view, 120, 80)
    });
    let taken = image::open(folder.path().join("chain-1.png")).expect("a picture").into_rgba8();
    assert!(taken.into_raw() == image.expect("a picture").rgba);
}
