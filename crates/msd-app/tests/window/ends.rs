//! Losses of the window: its surface, its graphics device.

use super::desk::{desk_with, numbers};
use super::x11::picture;
use serde_json::Value;

#[test]
fn a_lost_surface_is_made_anew() {
    let environment = [("MSD_LOSE", "surface"), ("RUST_LOG", "msd_app=warn")];
    let Some(mut desk) = desk_with("1400x900x24", "jelly", &environment) else { return };
    desk.wait("it runs", |now| 3 < now["steps"].as_u64().unwrap_or(0));
    desk.xdotool("key space");
    let paused = desk.wait("it pauses", |now| now["paused"] == true);
    desk.settle();
    let before = picture(&desk.display);
    desk.xdotool("key h");
    desk.wait("the panels are hidden", |now| now["view"] != paused["view"]);
    desk.settle();
    let after = picture(&desk.display);
    let [left, top, width, height]: [f64; 4] = numbers(&paused["landmarks"]["pause"]);
    let at = [(left + 0.5 * width) as usize, (top + 0.2 * height) as usize];
    assert_ne!(before.pixel(at), after.pixel(at), "the scene is where the panel was");
    desk.xdotool("key ctrl+q");
    let (code, told) = desk.end();
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("the surface was lost"), "{told}");
}

#[test]
fn a_lost_device_ends_the_window_and_the_run_is_kept() {
    let environment = [("MSD_LOSE", "device")];
    let Some(mut desk) = desk_with("1400x900x24", "jelly", &environment) else { return };
    let steps = |now: &Value| now["steps"].as_u64().unwrap_or(0);
    desk.wait("it runs", |now| 3 < steps(now));
    desk.key("space");
    let (code, told) = desk.end();
    assert_eq!((code, told.lines().count()), (Some(1), 2), "{told}");
    assert!(told.contains("the graphics device was lost"), "{told}");
    assert!(told.contains("msd view jelly-1.msd"), "{told}");
    let saved = msd_scene::open(desk.folder.path().join("jelly-1.msd")).expect("a saved run");
    assert_eq!(saved.progress.expect("a saved run").steps, steps(&desk.last()));
    assert!(desk.folder.path().join("preferences.json").is_file(), "preferences too");
}
