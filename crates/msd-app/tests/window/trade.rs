//! The trade-off in the window: the timeline, the twin, the slider from fast to accurate, a search,
//! the gallery.

use super::desk::{Desk, desk_with, numbers};
use serde_json::Value;

fn steps(now: &Value) -> u64 {
    now["steps"].as_u64().unwrap_or(0)
}

/// Returns a point at a fraction of the width of a landmark, in the middle of its height.
fn across(now: &Value, landmark: &str, part: f64) -> [f64; 2] {
    let [left, top, width, height]: [f64; 4] = numbers(&now["landmarks"][landmark]);
    [left + part * width, top + 0.5 * height]
}

#[test]
fn one_looks_back_compares_chooses_and_opens_by_the_mouse() {
    let Some(desk) = desk_with("1280x800x24", "chain", &[]) else { return };
    the_timeline_spans_the_window_and_the_run_goes_on_from_any_point(&desk);
    a_twin_drifts_away(&desk);
    the_slider_walks_along_the_front(&desk);
    a_wish_is_searched_for_unless_esc_takes_it_back(&desk);
    a_search_is_ended_by_its_button(&desk);
    the_gallery_draws_the_scenes_and_opens_one(&desk);
    a_path_that_is_typed_is_opened_or_refused_in_words(&desk);
}

fn the_timeline_spans_the_window_and_the_run_goes_on_from_any_point(desk: &Desk) {
    desk.wait("it runs", |now| 60 < steps(now));
    desk.xdotool("key space");
    let paused = desk.wait("it pauses", |now| now["paused"] == true);
    let [.., width, _]: [f64; 4] = numbers(&paused["landmarks"]["timeline"]);
    assert!(0.7 * 1280.0 < width, "the timeline is {width} points wide");
    desk.drag(1, across(&paused, "timeline", 0.99), across(&paused, "timeline", 0.5));
    let back = desk.wait("it looks back", |now| 20 < now["past"]["ahead"].as_u64().unwrap_or(0));
    assert_eq!(
        steps(&back) + back["past"]["ahead"].as_u64().unwrap_or(0),
        steps(&paused),
        "{back}"
    );
    // Dragged forward, and back to the same place.
    desk.drag(1, across(&back, "timeline", 0.5), across(&back, "timeline", 0.75));
    let later = desk.wait("it looks ahead", |now| steps(&back) < steps(now));
    assert!(steps(&later) < steps(&paused), "{later}");
    desk.xdotool("key Escape");
    desk.xdotool("key space");
    let on = desk.wait("what comes after is dropped", |now| now["past"]["ahead"] == 0);
    assert!(steps(&later) < steps(&on) && steps(&on) < steps(&paused), "it goes on there: {on}");
    desk.wait("steps are taken", |now| steps(&paused) < steps(now));
}

fn a_twin_drifts_away(desk: &Desk) {
    assert_eq!(desk.last()["twin"], Value::Null);
    desk.click("twin");
    let apart = |now: &Value| now["twin"].as_f64().unwrap_or(-1.0);
    desk.wait("explicit Euler drifts away from Verlet", |now| 1e-3 < apart(now));
}

fn the_slider_walks_along_the_front(desk: &Desk) {
    desk.click("trade");
    let measured = |now: &Value| now["trade"]["measured"].as_u64().unwrap_or(0);
    let start = desk.wait("some settings are measured and shown", |now| {
        60 < measured(now) && now["landmarks"]["fast to accurate"].is_array()
    });
    let place = |part| across(&start, "fast to accurate", part);
    desk.drag(1, place(0.6), place(0.98));
    let fine = desk.wait("the accurate end", |now| now["solver"] != start["solver"]);
    assert_eq!(fine["past"]["undo"], "chosen setting", "{fine}");
    desk.xdotool("key Escape");
    desk.xdotool("key ctrl+z");
    desk.wait("Ctrl+Z takes it back", |now| now["solver"] == start["solver"]);
}

fn a_wish_is_searched_for_unless_esc_takes_it_back(desk: &Desk) {
    for (key, is_wished) in [("Escape", false), ("Return", true)] {
        desk.click("within");
        desk.wait("the field has the keyboard", |now| now["focus"] == true);
        desk.xdotool("key ctrl+a");
        desk.xdotool("type --delay 60 300");
        desk.xdotool(&format!("key {key}"));
        let left = desk.wait("the field is left", |now| now["focus"] == false);
        if is_wished {
            desk.wait("it is searched for", |now| now["trade"]["search"].is_string());
        } else {
            assert_eq!(left["trade"]["search"], Value::Null, "{left}");
        }
    }
}

fn a_search_is_ended_by_its_button(desk: &Desk) {
    let before = desk.wait("it is done", |now| now["landmarks"]["stop"].is_null());
    // While paused it does not end by itself.
    desk.click("rest");
    desk.click("within");
    desk.wait("the field has the keyboard", |now| now["focus"] == true);
    desk.xdotool("key ctrl+a");
    desk.xdotool("type --delay 60 200");
    desk.xdotool("key Return");
    let words = |now: &Value| now["trade"]["search"].as_str().unwrap_or_default().to_owned();
    desk.wait("it is searched for", |now| {
        words(now).starts_with("searching for error below 200 mm")
    });
    desk.click("stop");
    let after = desk.wait("it is ended, and its button gone", |now| {
        now["trade"]["search"].is_null() && now["landmarks"]["stop"].is_null()
    });
    assert_eq!(after["solver"], before["solver"], "nothing is changed");
    desk.click("rest");
    desk.click("trade");
    desk.wait("the panel is closed", |now| now["trade"].is_null());
}

fn the_gallery_draws_the_scenes_and_opens_one(desk: &Desk) {
    desk.xdotool("key o");
    let scenes = msd_app::catalogue().entries;
    desk.wait("every picture is drawn", |now| now["gallery"] == msd_scene::BUILTINS.len());
    desk.click("second picture");
    let opened = desk.wait("it is opened", |now| now["scene"] == scenes[1].name);
    assert_eq!(opened["gallery"], Value::Null, "{opened}");
}

fn a_path_that_is_typed_is_opened_or_refused_in_words(desk: &Desk) {
    let text = "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [4]\n";
    std::fs::create_dir(desk.folder.path().join("mine")).expect("a folder");
    std::fs::write(desk.folder.path().join("mine/rope.toml"), text).expect("a file");
    let before = desk.last();
    for (path, is_there) in [("mine/none.toml", false), ("mine/rope.toml", true)] {
        desk.xdotool("key o");
        desk.click("file");
        desk.wait("the field has the keyboard", |now| now["focus"] == true);
        desk.xdotool(&format!("type --delay 60 {path}"));
        desk.xdotool("key Return");
        if is_there {
            desk.wait("the file is opened", |now| now["scene"] == "rope");
        } else {
            let words = |now: &Value| now["note"].as_str().unwrap_or_default().to_owned();
            desk.wait("it is refused in words", |now| words(now).contains("none.toml: cannot"));
            let after = desk.last();
            assert_eq!(after["scene"], before["scene"], "{after}");
            assert!(!after["gallery"].is_null(), "the path stays, to be mended: {after}");
            desk.xdotool("key Escape");
        }
        desk.wait("the gallery is closed", |now| now["gallery"].is_null());
    }
}
