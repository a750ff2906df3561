//! Films of `msd render`: frames, formats, and refusals.
#![cfg(feature = "window")]

use crate::common::{done, folder, msd, parse, refused};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

const SIZE: [u32; 2] = [96, 64];

/// Returns whether pictures can be rendered; CI has a driver, so there they must be.
fn can_draw(folder: &Path) -> bool {
    let output = crate::common::outcome(msd(folder, &["render", "chain", "--out", "try.png"]));
    let said = crate::common::text(&output.stderr);
    fs::remove_file(folder.join("try.png")).ok();
    if output.status.success() {
        return true;
    }
    assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "{said}");
    eprintln!("SKIPPED: {said}");
    false
}

/// Renders a film of half a second of the dice, six frames.
fn film(folder: &Path, out: &str, more: &[&str]) -> serde_json::Value {
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let render = ["render", "dice", "--frames", "0:0.5:1/10", "--size", &size, "--json", "--out"];
    parse(&done(msd(folder, &[&render[..], &[out], more].concat())))
}

/// Reads the pixels of a PNG.
fn png(path: &Path) -> Vec<u8> {
    image::open(path).expect("a picture").into_rgba8().into_raw()
}

/// Reads the frames of an animated WebP, each with its duration, milliseconds.
fn webp(path: &Path) -> Vec<(Vec<u8>, u32)> {
    let file = BufReader::new(File::open(path).expect("a film"));
    let mut decoder = image_webp::WebPDecoder::new(file).expect("a WebP file");
    assert!(decoder.has_alpha());
    let mut frame = vec![0; decoder.output_buffer_size().expect("a size")];
    let count = decoder.num_frames();
    (0..count)
        .map(|_| {
            let lasting = decoder.read_frame(&mut frame).expect("a frame");
            (frame.clone(), lasting)
        })
        .collect()
}

/// Returns the similarity of two pictures where they are visible: the peak signal-to-noise ratio,
/// decibels.
fn closeness(a: &[u8], b: &[u8]) -> f64 {
    let pairs = a.chunks_exact(4).zip(b.chunks_exact(4)).filter(|(a, b)| (a[3], b[3]) != (0, 0));
    let errors: Vec<f64> = pairs
        .flat_map(|(a, b)| (0..4).map(|part| f64::from(a[part].abs_diff(b[part])).powi(2)))
        .collect();
    10.0 * (255.0_f64.powi(2) * errors.len() as f64 / errors.iter().sum::<f64>()).log10()
}

#[test]
fn a_film_as_webp_looks_as_its_frames_do() {
    let folder = folder();
    let path = folder.path();
    if !can_draw(path) {
        return;
    }
    for more in [&[][..], &["--background", "none"], &["--camera", "orbit"]] {
        let report = film(path, "film/%03d.png", more);
        assert_eq!((&report["frames"], &report["time"]), (&6.into(), &0.5.into()));
        film(path, "film.webp", more);
        let frames = webp(&path.join("film.webp"));
        assert_eq!(frames.len(), 6);
        for (number, (pixels, lasting)) in frames.iter().enumerate() {
            let alone = png(&path.join(format!("film/{number:03}.png")));
            // The pictures are small, and colours have half their resolution. Films with
            // transparency are lossless.
            let close = closeness(pixels, &alone);
            let least = if more.contains(&"none") { f64::INFINITY } else { 33.0 };
            assert!(least <= close, "{more:?}: frame {number}: {close} dB");
            assert_eq!(*lasting, 100);
        }
        let differs = frames.windows(2).filter(|pair| pair[0].0 != pair[1].0).count();
        assert_eq!(differs, 5, "{more:?}: it does not move");
    }
}

#[test]
fn a_film_of_four_seconds_is_small_enough_to_be_sent_and_clean() {
    let folder = folder();
    let path = folder.path();
    if !can_draw(path) {
        return;
    }
    // A fifth of its frames.
    let render = ["render", "jelly", "--frames", "0:4:1/6", "--size", "640x360", "--out"];
    for out in ["%02d.png", "film.webp"] {
        done(msd(path, &[&render[..], &[out]].concat()));
    }
    let bytes = fs::metadata(path.join("film.webp")).expect("a film").len();
    assert!(bytes < 2_000_000 / 5, "{bytes} bytes");
    for (number, (pixels, _)) in webp(&path.join("film.webp")).iter().enumerate() {
        let close = closeness(pixels, &png(&path.join(format!("{number:02}.png"))));
        // From 40 dB on a difference is not visible; one level of error in every channel is 48 dB.
        assert!(40.0 < close, "frame {number}: {close} dB");
    }
}

#[test]
fn a_film_as_gif_has_its_frames_in_few_colours() {
    let folder = folder();
    let path = folder.path();
    if !can_draw(path) {
        return;
    }
    film(path, "film/%d.png", &[]);
    film(path, "film.gif", &[]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let file = File::open(path.join("film.gif")).expect("a film");
    let mut decoder = options.read_info(file).expect("a GIF file");
    let width = usize::from(decoder.width());
    assert_eq!([u32::from(decoder.width()), u32::from(decoder.height())], SIZE);
    let (mut canvas, mut number) = (vec![0; 4 * (SIZE[0] * SIZE[1]) as usize], 0);
    while let Some(frame) = decoder.read_next_frame().expect("a frame") {
        assert_eq!(frame.delay, 10);
        for (row, pixels) in frame.buffer.chunks_exact(4 * usize::from(frame.width)).enumerate() {
            let start = 4 * ((row + usize::from(frame.top)) * width + usize::from(frame.left));
            for (column, pixel) in pixels.chunks_exact(4).enumerate().filter(|(_, p)| p[3] != 0) {
                canvas[start + 4 * column..start + 4 * column + 4].copy_from_slice(pixel);
            }
        }
        let alone = png(&path.join(format!("film/{number}.png")));
        let apart = canvas.iter().zip(&alone).map(|(a, b)| f64::from(a.abs_diff(*b)));
        let mean = apart.sum::<f64>() / alone.len() as f64;
        // The picture has few hues, for which 256 colours are enough.
        assert!(mean < 3.0, "frame {number}: {mean} levels off in the mean");
        number += 1;
    }
    assert_eq!(number, 6);
}

#[test]
fn the_camera_holds_all_that_moves_in_the_picture() {
    let folder = folder();
    let path = folder.path();
    if !can_draw(path) {
        return;
    }
    // The body falls within the view in all frames: no pixel of it touches the edge.
    let more = ["--background", "none", "--camera", "front"];
    film(path, "film/%d.png", &more);
    let [width, height] = SIZE.map(|side| side as usize);
    for number in 0..6 {
        let pixels = png(&path.join(format!("film/{number}.png")));
        let is_seen = |x: usize, y: usize| pixels[4 * (y * width + x) + 3] != 0;
        assert!((0..width).any(|x| (0..height).any(|y| is_seen(x, y))), "frame {number} is empty");
        let rim = (0..width).flat_map(|x| [(x, 0), (x, height - 1)]);
        let mut rim = rim.chain((0..height).flat_map(|y| [(0, y), (width - 1, y)]));
        assert!(!rim.any(|(x, y)| is_seen(x, y)), "frame {number} is cut off");
    }
}

#[test]
fn colours_stand_for_what_was_asked_for_on_one_scale_with_a_legend() {
    let folder = folder();
    let path = folder.path();
    if !can_draw(path) {
        return;
    }
    let picture = |out: &str, more: &[&str]| {
        let render = ["render", "chain", "--time", "0.3", "--size", "480x360", "--out", out];
        done(msd(path, &[&render[..], more].concat()));
        png(&path.join(out))
    };
    let own = picture("own.png", &["--no-legend"]);
    assert!(picture("alone.png", &[]) == own, "no legend without a quantity");
    for quantity in ["strain", "force", "energy", "speed"] {
        let bare = picture("bare.png", &["--colour-by", quantity, "--no-legend"]);
        assert!(bare != own, "{quantity}");
        let explained = picture("explained.png", &["--colour-by", quantity]);
        let rows = bare.chunks_exact(4 * 480).zip(explained.chunks_exact(4 * 480));
        // The legend is in the lower left corner: 12 points from the sides, 104 by 150.
        for (row, (bare, explained)) in rows.enumerate() {
            let [left, right] = [bare, explained].map(|row| row.split_at(4 * (12 + 104)));
            assert!(left.1 == right.1, "{quantity}: row {row}");
            let is_legend = (360 - 12 - 150..360 - 12).contains(&row);
            assert_eq!(left.0 != right.0, is_legend, "{quantity}: row {row}");
        }
        let other = ["--colour-by", quantity, "--no-legend", "--full-scale", "1234"];
        assert!(picture("other.png", &other) != bare, "{quantity}");
    }
    // All frames of a film have the same scale, which ends at 1, 2 or 5 times a power of ten.
    let speeds = |scale: &[&str]| {
        let speeds = ["--colour-by", "speed", "--no-legend"];
        film(path, "%d.png", &[&speeds[..], scale].concat());
        ["0.png", "2.png", "5.png"].map(|frame| png(&path.join(frame)))
    };
    let chosen = speeds(&[]);
    let is_chosen = |full: &&str| speeds(&["--full-scale", *full]) == chosen;
    assert_eq!(["20", "50", "100", "200"].into_iter().filter(is_chosen).count(), 1);
}

#[test]
fn what_is_no_film_is_refused_before_the_run() {
    let folder = folder();
    let frames = ["--frames", "0:1e4:1/30"];
    let refuse = |out: &str, more: &[&str], told: &str| {
        let said =
            refused(msd(folder.path(), &[&["render", "dice", "--out", out], more].concat()), 2);
        assert!(said.contains(told), "{said}");
        assert_eq!(folder.path().read_dir().expect("a folder").count(), 0, "{out}");
    };
    refuse("a.png", &frames, "a.png: a picture per frame needs its number in the name");
    refuse("a.gif", &[], "a.gif: a film takes --frames FROM:TO:EVERY");
    refuse("a.avi", &frames, "a.avi: unknown extension");
    let quantities = "[possible values: strain, force, energy, speed]";
    refuse("a.png", &["--colour-by", "error"], quantities);
    refuse("a.png", &["--full-scale", "0"], "must be a number, positive and finite");
    refuse("a.gif", &["--frames", "2:1:1/30"], "must be FROM:TO:EVERY");
    refuse("a.gif", &["--frames", "0:1"], "must be FROM:TO:EVERY");
    refuse("a.gif", &["--frames", "0:1:1e-3"], "--frames: 1 ms is less than a step of the run");
    refuse("a.gif", &["--camera", "below"], "must be front, back, left, right, top, orbit or");
    refuse("a.png", &["--background", "red"], "possible values: none");
    let mut without =
        msd(folder.path(), &["render", "dice", "--frames", "0:1:1/10", "--out", "a.mp4"]);
    without.env("PATH", "");
    let said = refused(without, 2);
    assert!(said.contains(".mp4 needs ffmpeg, which is not installed"), "{said}");
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 0);
}
