//! A window that is hidden and shown again, and one on a high-resolution screen.

use super::desk::{Desk, PATIENCE, desk, desk_with, numbers};
use super::x11::{Cover, Desktop};
use std::thread::sleep;
use std::time::{Duration, Instant};

fn steps(now: &serde_json::Value) -> u64 {
    now["steps"].as_u64().unwrap_or(0)
}

#[test]
fn a_hidden_window_rests_and_catches_up_with_nothing() {
    let Some(desk) = desk("1400x900x24") else { return };
    desk.wait("it runs", |now| 3 < steps(now));
    let cover = Cover::over(&desk.display);
    let before = rested(&desk);
    sleep(Duration::from_secs(3));
    assert_eq!(desk.last()["frame"], before["frame"], "no frame, and no step, while hidden");
    drop(cover);
    let next = before["frame"].as_u64().map(|frame| frame + 1);
    desk.wait("it is drawn again", |now| now["frame"].as_u64() >= next);
    let first = desk.frame(next.expect("a frame"));
    assert!(steps(&first) <= steps(&before) + 1, "what it missed: {first}");
    desk.wait("it goes on", |now| steps(&first) + 3 < steps(now));
    // Unmapped, as by a window manager that minimises it, and mapped again.
    desk.xdotool("search --onlyvisible --name ^msd windowunmap --sync");
    sleep(Duration::from_secs(1));
    let away = desk.last();
    desk.xdotool("search --name ^msd: windowmap --sync windowfocus --sync");
    desk.wait("it goes on", |now| steps(&away) + 3 < steps(now));
    desk.xdotool("key space");
    desk.wait("keys act", |now| now["paused"] == true);
}

/// Returns the last report once none follows for a while.
fn rested(desk: &Desk) -> serde_json::Value {
    let start = Instant::now();
    loop {
        let last = desk.last();
        sleep(Duration::from_secs(2));
        if desk.last()["frame"] == last["frame"] {
            return last;
        }
        assert!(start.elapsed() < PATIENCE, "frames are drawn behind a cover");
    }
}

#[test]
fn fine_pixels_make_everything_as_much_larger() {
    let scale = [("WINIT_X11_SCALE_FACTOR", "2")];
    let Some(desk) = desk_with("1400x900x24", "jelly", &scale) else { return };
    let start = desk.wait("it is laid out", |now| !now["landmarks"]["pause"].is_null());
    assert_eq!(start["pixels_per_point"], 2.0);
    // At least 70 points wide.
    let [left, top, width, height]: [f64; 4] = numbers(&start["landmarks"]["pause"]);
    assert!(140.0 <= width, "{start}");
    assert!(left + width <= 1400.0 && top + height <= 900.0, "{start}");
    desk.click("pause");
    let paused = desk.wait("a click is where the button is", |now| now["paused"] == true);
    desk.move_to(numbers(&paused["aim"]["screen"]));
    desk.wait("and a particle where it is drawn", |now| !now["hovered"].is_null());
}

#[test]
fn a_scale_that_changes_while_it_runs_is_followed() {
    let Some(mut desk) = desk("1400x900x24") else { return };
    let desktop = Desktop::over(&desk.display);
    desk.open_next("jelly");
    let start = desk.wait("it is laid out", |now| !now["landmarks"]["pause"].is_null());
    assert_eq!(start["pixels_per_point"], 1.0);
    let area = |now: &serde_json::Value, name: &str| numbers::<4>(&now["landmarks"][name]);
    desktop.scale(1.5);
    // As wide as the screen, of which the right panel takes 292 points.
    let width = |now: &serde_json::Value| {
        let [left, _, width, _]: [f64; 4] = numbers(&now["view"]);
        left + width + 1.5 * 292.0
    };
    let fine = desk.wait("points are larger", |now| {
        now["pixels_per_point"] == 1.5 && (width(now) - 1400.0).abs() < 2.0
    });
    // Without a limit, the window would grow by a half, and leave the screen.
    let [left, top, width, height] = area(&fine, "pause");
    assert!(1.4 * area(&start, "pause")[2] < width, "{fine}");
    assert!(left + width <= 1400.0 && top + height <= 900.0, "{fine}");
    desk.click("pause");
    let paused = desk.wait("a click is where the button is", |now| now["paused"] == true);
    desk.move_to(numbers(&paused["aim"]["screen"]));
    desk.wait("and a particle where it is drawn", |now| !now["hovered"].is_null());
    desktop.scale(1.0);
    let back = desk.wait("points are as before", |now| now["pixels_per_point"] == 1.0);
    assert_eq!(area(&back, "pause")[2], area(&start, "pause")[2], "{back}");
}
