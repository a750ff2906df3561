//! The panels on a small screen: one at a time, beside a view of the body, high enough for fingers.

use crate::frames::{loaded, window};
use egui::accesskit::Role;
use egui::{Rect, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::viewer::{Command, Viewer, catalogue};

/// Space that the bar of the page leaves on a phone, upright and in landscape, points.
const SCREENS: [[f32; 2]; 2] = [[390.0, 790.0], [844.0, 336.0]];
const TABS: [&str; 5] = ["Run", "Material", "Solver", "Energy", "View"];

fn harness(size: [f32; 2]) -> Harness<'static, Viewer> {
    let mut viewer = Viewer::new(loaded("jelly"), catalogue()).expect("a valid scene");
    (viewer.layout.by_touch, viewer.layout.in_page) = (true, true);
    window(viewer, size)
}

fn click(harness: &mut Harness<'_, Viewer>, label: &str) {
    harness.get_by_role_and_label(Role::Button, label).click();
    harness.run_steps(4);
}

/// Returns the roles and areas of all touch targets.
fn controls(harness: &Harness<'_, Viewer>) -> Vec<(Role, Rect)> {
    const PRESSED: [Role; 5] =
        [Role::Button, Role::CheckBox, Role::ComboBox, Role::Slider, Role::SpinButton];
    let roles = PRESSED.into_iter().flat_map(|role| {
        let places: Vec<_> = harness.query_all_by_role(role).map(|node| node.rect()).collect();
        places.into_iter().map(move |place| (role, place))
    });
    roles.collect()
}

#[test]
fn one_panel_at_a_time_leaves_the_body_in_view() {
    for size in SCREENS {
        let mut harness = harness(size);
        for tab in TABS {
            click(&mut harness, tab);
            let view = harness.state().layout.rect;
            assert!(0.5 * size[0] * size[1] <= view.area(), "{size:?} {tab}: {view}");
            assert!(200.0 <= view.width().min(view.height()), "{size:?} {tab}: {view}");
            for (role, place) in controls(&harness) {
                assert!(!view.intersects(place.shrink(1.0)), "{tab}: {role:?} {place} over {view}");
            }
        }
        harness.state_mut().command(Command::Panels);
        harness.run_steps(3);
        // The harness has a margin of eight points.
        assert_eq!(harness.state().layout.rect.size(), Vec2::from(size) - Vec2::splat(16.0));
    }
}

#[test]
fn what_a_finger_presses_is_44_points_high_and_within_the_panel() {
    for size in SCREENS {
        let mut harness = harness(size);
        for tab in TABS {
            click(&mut harness, tab);
            let controls = controls(&harness);
            assert!(TABS.len() <= controls.len(), "{tab}");
            for (role, place) in controls {
                assert!(43.9 <= place.height(), "{size:?} {tab}: {role:?} {place}");
                assert!(place.right() <= size[0], "{size:?} {tab}: {role:?} {place}");
            }
        }
    }
}

#[test]
fn a_panel_scrolls_to_its_end() {
    let mut harness = harness(SCREENS[0]);
    click(&mut harness, "Material");
    let bottom = |harness: &Harness<'_, Viewer>| {
        harness.get_by_role_and_label(Role::Slider, "Wind").rect().bottom()
    };
    assert!(SCREENS[0][1] < bottom(&harness), "it is longer than the screen");
    harness.get_by_role_and_label(Role::Slider, "Wind").scroll_to_me();
    harness.run_steps(30);
    assert!(bottom(&harness) <= SCREENS[0][1], "{}", bottom(&harness));
}

#[test]
fn hints_speak_of_fingers_and_no_button_of_the_page_is_there_twice() {
    let mut harness = harness(SCREENS[0]);
    harness.state_mut().command(Command::Help);
    harness.run_steps(4);
    assert!(harness.query_by_label("Two fingers").is_some());
    assert!(harness.query_by_label_contains("Wheel").is_none());
    harness.state_mut().command(Command::Help);
    for tab in TABS {
        click(&mut harness, tab);
        for label in ["Pause", "Step", "Restart", "Frame all", "Copy link", "Save run", "Tour"] {
            let twice = harness.query_by_role_and_label(Role::Button, label);
            assert!(twice.is_none(), "{tab}: {label}");
        }
    }
}
