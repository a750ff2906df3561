//! User input in the scene: a box selection, the wind, a dropped file, the tour.

use super::desk::{Desk, desk, desk_with, distance, numbers};
use super::x11::drop_file;
use serde_json::json;

#[test]
fn a_box_the_wind_and_a_dropped_file_act_on_the_simulation() {
    let Some(desk) = desk("1400x900x24") else { return };
    what_a_box_holds_is_grabbed_together(&desk);
    wind_drives_the_body_along(&desk);
    it_turns_and_comes_in_gusts(&desk);
    a_dropped_file_is_opened(&desk);
    a_ball_is_pushed_through_a_cloth(&desk);
}

fn what_a_box_holds_is_grabbed_together(desk: &Desk) {
    desk.xdotool("key space");
    let start = desk.wait("it pauses", |now| now["paused"] == true);
    let [x, y] = numbers(&start["aim"]["screen"]);
    desk.xdotool("keydown ctrl");
    desk.drag(1, [x - 40.0, y - 40.0], [x + 40.0, y + 40.0]);
    desk.xdotool("keyup ctrl");
    let count = |value: &serde_json::Value| value.as_u64().unwrap_or(0);
    let boxed = desk.wait("a box makes a group", |now| 1 < count(&now["group"]));
    assert_eq!(boxed["camera"]["yaw"], start["camera"]["yaw"], "a box turns nothing");
    desk.move_to([x, y]);
    desk.wait("the particle is under the pointer", |now| !now["hovered"].is_null());
    desk.xdotool("mousedown 1");
    desk.wait("all of the group is held", |now| now["grabs"] == boxed["group"]);
    desk.xdotool("key space");
    desk.move_to([x + 60.0, y - 120.0]);
    let held = desk.wait("it is pulled", |now| {
        distance::<2>(numbers(&now["held_screen"]), [x + 60.0, y - 120.0]) < 60.0
    });
    assert_eq!(held["grabs"], boxed["group"]);
    desk.xdotool("mouseup 1");
    desk.wait("release lets go of all", |now| count(&now["grabs"]) == 0);
    desk.xdotool("key Escape");
    desk.wait("Escape forgets the group", |now| count(&now["group"]) == 0);
}

fn wind_drives_the_body_along(desk: &Desk) {
    let start = desk.wait("it runs", |now| now["paused"] == false);
    assert_eq!(start["wind"], 0.0);
    let [left, top, _, height]: [f64; 4] = numbers(&start["landmarks"]["wind"]);
    let y = top + 0.5 * height;
    desk.drag(1, [left + 6.0, y], [left + 84.0, y]);
    let blown = desk.wait("it blows", |now| now["wind"].as_f64().is_some_and(|wind| 1.0 < wind));
    // The camera follows the centre of the scene; the wind blows along x.
    let along = |now: &serde_json::Value| now["camera"]["target"][0].as_f64().unwrap_or(0.0);
    desk.wait("the body goes along", |now| along(&blown) + 0.5 < along(now));
}

fn it_turns_and_comes_in_gusts(desk: &Desk) {
    let force = |now: &serde_json::Value| numbers::<3>(&now["force"]);
    let steady = desk.last();
    let [east, _, south] = force(&steady);
    assert!(1.0 < east && south == 0.0, "{steady}");
    // The rail is 96 points long: a quarter turn is three quarters of it, from -180° to 180°.
    let [left, top, _, height]: [f64; 4] = numbers(&steady["landmarks"]["heading"]);
    let y = top + 0.5 * height;
    desk.drag(1, [left + 48.0, y], [left + 72.0, y]);
    let turned = desk.wait("the wind turns", |now| force(now)[2] < -0.9 * east);
    assert!(force(&turned)[0].abs() < 0.3 * east, "{turned}");
    let along = |now: &serde_json::Value| now["camera"]["target"][2].as_f64().unwrap_or(0.0);
    desk.wait("the body goes along", |now| along(now) + 0.5 < along(&turned));
    let [left, top, _, height]: [f64; 4] = numbers(&turned["landmarks"]["gusts"]);
    let y = top + 0.5 * height;
    desk.drag(1, [left + 4.0, y], [left + 90.0, y]);
    let strength = |now: &serde_json::Value| -force(now)[2];
    desk.wait("it abates", |now| strength(now) < 0.7 * strength(&turned));
    desk.wait("it comes back", |now| 1.2 * strength(&turned) < strength(now));
}

fn a_dropped_file_is_opened(desk: &Desk) {
    let file = desk.folder.path().join("a rope.toml");
    std::fs::write(&file, "version = 1\n[[bodies]]\nkind = 'rope'\nsize = [4]\n").expect("a file");
    drop_file(&desk.display, &file);
    let opened = desk.wait("the file is opened", |now| now["scene"] == "a rope");
    assert_eq!(opened["note"], serde_json::Value::Null, "{opened}");
}

/// A ball beside a cloth that hangs by its upper edge, seen along the cloth.
const CURTAIN: &str = r#"
version = 1
[camera]
yaw_deg = 90
pitch_deg = 5
distance = 5
target = [0, 1, 0]
[[world.solids]]
kind = "sphere"
radius = 0.3
position = [0, 1, 1.2]
[[bodies]]
kind = "cloth"
size = [21, 21]
spacing = 0.08
mass = 0.005
stiffness = 60
damping = 0.02
position = [0, 1.1, 0]
touch = { obstacles = true }
[[pins]]
set = "top"
"#;

fn a_ball_is_pushed_through_a_cloth(desk: &Desk) {
    let file = desk.folder.path().join("a curtain.toml");
    std::fs::write(&file, CURTAIN).expect("a file");
    drop_file(&desk.display, &file);
    let start = desk.wait("it is opened", |now| now["scene"] == "a curtain");
    let [left, _, width, _]: [f64; 4] = numbers(&start["view"]);
    let [x, y] = numbers(&start["solids"][0]);
    let beyond = 2.0 * left + width - x;
    desk.move_to([x, y]);
    desk.xdotool("mousedown 1");
    desk.wait("the press takes the ball", |now| now["held_solid"] == 0);
    assert_eq!(start["contacts"], 0);
    for part in 1..=30 {
        desk.move_to([x + (beyond - x) * f64::from(part) / 30.0, y]);
    }
    let through = desk.wait("it comes out on the other side", |now| {
        left + 0.7 * width < numbers::<2>(&now["solids"][0])[0] && now["crossings"].is_u64()
    });
    assert!(0 < through["contacts"].as_u64().unwrap_or(0), "it pushes the cloth: {through}");
    assert_eq!((&through["findings"], &through["crossings"]), (&json!([]), &0.into()));
    desk.xdotool("mouseup 1");
    desk.wait("release leaves it there", |now| now["held_solid"].is_null());
}

#[test]
fn the_guide_is_followed_to_its_end() {
    let Some(desk) = desk_with("1400x900x24", "cube", &[]) else { return };
    let is_done = |steps: u64| move |now: &serde_json::Value| now["guide"] == steps;
    desk.wait("it is offered", is_done(0));
    desk.xdotool("key space");
    let start = desk.wait("it pauses", |now| now["paused"] == true);
    let [x, y] = numbers(&start["aim"]["screen"]);
    desk.drag(1, [x, y], [x + 40.0, y - 40.0]);
    desk.wait("a throw is the first step", is_done(1));
    desk.xdotool("key space");
    let runs = desk.wait("it runs", |now| now["paused"] == false);
    let [left, top, width, height]: [f64; 4] = numbers(&runs["landmarks"]["stiffness"]);
    let y = top + 0.5 * height;
    desk.drag(1, [left + 30.0, y], [left + width, y]);
    desk.wait("it blows up, the third step", is_done(3));
    desk.click("way out");
    desk.wait("a way out is the fourth", is_done(4));
    desk.click("estimate");
    desk.wait("the estimate is the last", is_done(5));
}
