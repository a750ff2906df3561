//! Keys for the scene and the window: pins, steps, undo, the camera, the focus, files.

use super::desk::{Desk, desk_with, distance, if_there, numbers};
use super::x11::clipboard;
use serde_json::Value;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

fn steps(now: &Value) -> u64 {
    now["steps"].as_u64().unwrap_or(0)
}

#[test]
fn keys_act_on_the_scene_the_camera_and_the_window() {
    let Some(desk) = desk_with("1280x800x24", "jelly", &[]) else { return };
    // So that the motions below differ from those of a body at rest.
    desk.wait("it runs", |now| 6 < steps(now));
    desk.xdotool("key space");
    desk.wait("it pauses", |now| now["paused"] == true);
    steps_go_forward_and_back(&desk);
    p_pins_what_can_be_undone_and_dragged(&desk);
    drags_move_the_camera_sideways(&desk);
    arrows_turn_until_tab_gives_a_control_the_keyboard(&desk);
    f_makes_the_present_shape_the_shape_at_rest(&desk);
    ctrl_plus_and_minus_scale_the_panels(&desk);
    f11_asks_for_the_full_screen(&desk);
}

fn steps_go_forward_and_back(desk: &Desk) {
    let start = steps(&desk.last());
    for ahead in 1..=2 {
        desk.xdotool("key period");
        desk.wait("a step forward", |now| steps(now) == start + ahead);
    }
    desk.xdotool("key comma");
    desk.wait("a step back", |now| steps(now) == start + 1);
}

fn p_pins_what_can_be_undone_and_dragged(desk: &Desk) {
    let start = desk.last();
    let at: [f64; 2] = numbers(&start["aim"]["screen"]);
    desk.move_to(at);
    desk.wait("the particle is under the pointer", |now| !now["hovered"].is_null());
    desk.xdotool("key p");
    let pinned = desk.wait("P pins it", |now| now["pins"] == 1);
    assert_eq!((&start["pins"], &pinned["past"]["undo"]), (&0.into(), &"pin".into()), "{pinned}");
    desk.xdotool("key ctrl+z");
    let undone = desk.wait("Ctrl+Z frees it", |now| now["pins"] == 0);
    assert_eq!(undone["past"]["redo"], "pin", "{undone}");
    desk.xdotool("key ctrl+shift+z");
    desk.wait("with Shift it is pinned again", |now| now["pins"] == 1);
    // A dragged pin moves while time passes, and stays there.
    desk.xdotool("mousedown 1");
    let held = desk.wait("the press takes the pin", |now| !now["held"].is_null());
    desk.xdotool("key space");
    let goal = [at[0] - 60.0, at[1] - 40.0];
    desk.move_to(goal);
    let there = desk.wait("the pin reaches the pointer", |now| {
        distance(numbers(&now["held_screen"]), goal) < 8.0
    });
    assert_eq!((&there["held"], &there["pins"]), (&held["held"], &1.into()), "{there}");
    desk.xdotool("mouseup 1");
    let left = desk.wait("it is let go", |now| now["held"].is_null());
    desk.wait("it hangs there", |now| steps(&left) + 20 < steps(now));
    desk.xdotool("key space");
    desk.wait("it pauses", |now| now["paused"] == true);
    desk.xdotool("key Escape");
}

fn drags_move_the_camera_sideways(desk: &Desk) {
    let start = desk.last();
    let [left, top, ..]: [f64; 4] = numbers(&start["view"]);
    let target = |now: &Value| numbers::<3>(&now["camera"]["target"]);
    let [from, to] = [60.0, 140.0].map(|x| [left + x, top + 90.0]);
    desk.xdotool("keydown shift");
    desk.drag(1, from, to);
    desk.xdotool("keyup shift");
    let moved = desk.wait("a Shift drag moves", |now| target(now) != target(&start));
    desk.drag(2, to, from);
    // Back over the same way, except for the motion of the following camera.
    let back = desk.wait("a middle drag moves", |now| target(now) != target(&moved));
    let [there, here] = [&moved, &back].map(|now| distance(target(now), target(&start)));
    assert!(here < 0.5 * there, "{here} m of {there} m");
    for now in [&moved, &back] {
        assert_eq!(now["camera"]["yaw"], start["camera"]["yaw"], "it turns nothing");
    }
}

fn arrows_turn_until_tab_gives_a_control_the_keyboard(desk: &Desk) {
    let start = desk.last();
    assert_eq!(start["focus"], false, "{start}");
    let part = |name: &'static str| move |now: &Value| now["camera"][name].clone();
    desk.xdotool("key Right");
    let turned = desk.wait("an arrow turns", |now| part("yaw")(now) != part("yaw")(&start));
    desk.xdotool("key Up");
    desk.wait("and tilts", |now| part("pitch")(now) != part("pitch")(&turned));
    desk.xdotool("key plus");
    let near = desk.wait("plus zooms", |now| part("distance")(now) != part("distance")(&turned));
    desk.xdotool("key Tab");
    desk.wait("Tab gives a control the keyboard", |now| now["focus"] == true);
    desk.xdotool("key Right");
    let focused = desk.last();
    assert_eq!(focused["camera"]["yaw"], near["camera"]["yaw"], "the arrow is the control's");
    desk.xdotool("key Escape");
    desk.wait("Esc leaves it", |now| now["focus"] == false);
    desk.xdotool("key Left");
    desk.wait("arrows turn again", |now| part("yaw")(now) != part("yaw")(&near));
}

fn f_makes_the_present_shape_the_shape_at_rest(desk: &Desk) {
    let elastic = |now: &Value| now["elastic"].as_f64().unwrap_or(f64::NAN);
    let bent = desk.wait("it hangs by its pin", |now| 1.0 < elastic(now));
    desk.xdotool("key f");
    let frozen = desk.wait("F freezes", |now| elastic(now) < 1e-6 * elastic(&bent));
    assert_eq!(frozen["past"]["undo"], "freeze", "{frozen}");
    desk.xdotool("key ctrl+z");
    desk.wait("Ctrl+Z takes it back", |now| 0.5 * elastic(&bent) < elastic(now));
}

fn ctrl_plus_and_minus_scale_the_panels(desk: &Desk) {
    let pixels = |now: &Value| now["pixels_per_point"].as_f64().unwrap_or(f64::NAN);
    let start = desk.last();
    desk.xdotool("key ctrl+plus");
    let large = desk.wait("panels are larger", |now| pixels(&start) < pixels(now));
    let height = |now: &Value| numbers::<4>(&now["landmarks"]["pause"])[3];
    assert!(height(&start) < height(&large), "{large}");
    desk.xdotool("key ctrl+minus");
    desk.wait("panels are as before", |now| pixels(now) == pixels(&start));
}

fn f11_asks_for_the_full_screen(desk: &Desk) {
    for full in [true, false] {
        desk.xdotool("key F11");
        desk.wait("F11 asks for the screen, or gives it back", |now| now["full_screen"] == full);
    }
}

#[test]
fn a_window_manager_gives_the_whole_screen_and_takes_it_back() {
    let Some(desk) = desk_with("1500x950x24", "chain", &[]) else { return };
    let Some(_manager) = if_there(Manager::on(&desk)) else { return };
    // The width of the view with the right panel.
    let width = |now: &Value| {
        let [left, _, width, _]: [f64; 4] = numbers(&now["view"]);
        left + width + 292.0
    };
    let framed = desk.wait("it has a frame", |now| width(now) < 1500.0);
    desk.xdotool("key F11");
    let full = desk.wait("it has the screen", |now| width(now) == 1500.0);
    assert_eq!(full["full_screen"], true, "{full}");
    desk.xdotool("key F11");
    desk.wait("it has its frame again", |now| width(now) == width(&framed));
}

/// A window manager, until it is dropped.
struct Manager(Child);

impl Manager {
    fn on(desk: &Desk) -> Result<Self, String> {
        let mut command = Command::new("blackbox");
        command.env("DISPLAY", &desk.display).env("HOME", desk.folder.path());
        let spawned = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let manager = spawned.map_err(|error| format!("blackbox does not start: {error}"))?;
        // Fails until the manager runs and has framed the window.
        let activate = "search --onlyvisible --name ^msd: windowactivate --sync";
        for _ in 0..60 {
            let mut command = Command::new("xdotool");
            command.args(activate.split(' ')).env("DISPLAY", &desk.display);
            if command.stderr(Stdio::null()).status().is_ok_and(|status| status.success()) {
                desk.settle();
                return Ok(Manager(manager));
            }
            sleep(Duration::from_millis(500));
        }
        panic!("the window is never active")
    }
}

impl Drop for Manager {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

#[test]
fn runs_scenes_recordings_and_commands_are_kept_and_can_be_had_again() {
    let Some(desk) = desk_with("1280x800x24", "chain", &[]) else { return };
    desk.wait("it runs", |now| 3 < steps(now));
    a_recording_says_its_file_and_is_replayed(&desk);
    s_saves_the_run_ctrl_s_the_scene_and_ctrl_c_copies_the_command(&desk);
    a_button_films_what_was_seen_while_the_run_goes_on(&desk);
}

fn a_button_films_what_was_seen_while_the_run_goes_on(desk: &Desk) {
    desk.xdotool("key space");
    let runs = desk.wait("it runs", |now| now["paused"] == false);
    // Down to the buttons.
    desk.move_to([80.0, 600.0]);
    (0..10).for_each(|_| desk.xdotool("click 5"));
    // The film is short then.
    desk.xdotool("key r");
    desk.wait("it starts again", |now| steps(now) < steps(&runs));
    desk.click("Film");
    let begun = desk.wait("a film is made", |now| now["filming"].is_u64());
    desk.wait("frames are written", |now| 0 < now["filming"].as_u64().unwrap_or(0));
    desk.wait("the run goes on meanwhile", |now| steps(&begun) < steps(now));
    // A whole film takes minutes on a busy machine: a test without a window covers its end.
    desk.click("cancel film");
    let ended = desk.wait("it has ended", |now| now["filming"].is_null());
    let told = ended["note"].as_str().unwrap_or_default();
    assert!(told == "the film was cancelled" || told.starts_with("saved chain-1.webp"), "{told}");
    let names = std::fs::read_dir(desk.folder.path()).expect("a folder").flatten();
    let parts = names.filter(|name| name.file_name().to_string_lossy().contains(".part")).count();
    assert_eq!(parts, 0);
}

/// Runs `msd` in the folder of the desk; returns its messages.
fn msd(desk: &Desk, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msd"));
    let ran = command.args(arguments).current_dir(&desk.folder).output().expect("it starts");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "msd {arguments:?}: {said}");
    String::from_utf8_lossy(&ran.stdout).into_owned()
}

fn a_recording_says_its_file_and_is_replayed(desk: &Desk) {
    desk.xdotool("key F9");
    let begun = desk.wait("F9 records", |now| now["recording"].is_string());
    let file = begun["recording"].as_str().expect("a name").to_owned();
    let note = begun["note"].as_str().expect("a note");
    assert_eq!(note, format!("recording into {file}; F9 ends it"));
    desk.wait("it is recorded for a while", |now| steps(&begun) + 20 < steps(now));
    desk.xdotool("key space");
    desk.wait("it pauses", |now| now["paused"] == true);
    desk.xdotool("key F9");
    let ended = desk.wait("F9 ends it", |now| now["recording"].is_null());
    let note = ended["note"].as_str().expect("a note");
    let command = note.strip_prefix("recorded; replay it with: msd ").expect(note);
    // The line of the note, as a user would type it.
    let words: Vec<&str> = command.split(' ').collect();
    assert_eq!(words, ["run", "--replay", &file]);
    let told: Value =
        serde_json::from_str(&msd(desk, &[&words[..], &["--json"]].concat())).expect("a report");
    assert_eq!(told["time"], ended["time"], "{told}");
    assert_eq!(told["replay"]["same_bits"], true, "{told}");
}

fn s_saves_the_run_ctrl_s_the_scene_and_ctrl_c_copies_the_command(desk: &Desk) {
    let start = desk.last();
    desk.xdotool("key s");
    let saved = desk.wait("S saves", |now| now["note"] != start["note"]);
    let note = saved["note"].as_str().expect("a note");
    assert_eq!(note, "saved chain-1.msd; resume it with: msd view chain-1.msd");
    let run = msd_scene::open(desk.folder.path().join("chain-1.msd")).expect("a saved run");
    assert_eq!(run.progress.map(|progress| progress.steps), saved["steps"].as_u64());
    desk.xdotool("key ctrl+s");
    let saved = desk.wait("Ctrl+S saves", |now| now["note"] != saved["note"]);
    assert!(saved["note"].as_str().is_some_and(|note| note.contains("chain-1.toml")), "{saved}");
    msd_scene::open(desk.folder.path().join("chain-1.toml")).expect("a scene file");
    desk.xdotool("key ctrl+c");
    let copied = desk.wait("Ctrl+C copies", |now| now["note"] != saved["note"]);
    let note = copied["note"].as_str().expect("a note");
    let line = note.strip_prefix("copied: ").expect(note);
    assert_eq!(clipboard(&desk.display), line);
    assert!(line.starts_with("msd view "), "{line}");
}
