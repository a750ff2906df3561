//! Behaviour of the panels: stable positions, confirmations, names.

use crate::frames::{click, loaded, window};
use egui::Rect;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use msd_app::session::MaterialEdit;
use msd_app::viewer::{Viewer, catalogue};
use msd_core::Real;
use msd_run::on;
use msd_scene::parts::Part;

fn harness_of(viewer: Viewer, size: [f32; 2]) -> Harness<'static, Viewer> {
    window(viewer, size)
}

fn harness(scene: &str, size: [f32; 2]) -> Harness<'static, Viewer> {
    harness_of(Viewer::new(loaded(scene), catalogue()).expect("a valid scene"), size)
}

/// Returns the places of the controls of the right panel.
fn places(harness: &Harness<'_, Viewer>) -> Vec<Rect> {
    let controls = [
        (Role::Slider, "Stiffness"),
        (Role::ComboBox, "Method"),
        (Role::Button, "Accuracy vs. cost"),
        (Role::CheckBox, "Estimate error"),
        (Role::CheckBox, "Colour by error"),
        (Role::Label, "ENERGY"),
    ];
    let place = |&(role, label): &_| harness.get_by_role_and_label(role, label).rect();
    controls.iter().map(place).collect()
}

#[test]
fn no_control_moves_where_a_text_comes_or_goes() {
    let mut harness = harness("jelly", [1280.0, 1000.0]);
    click(&mut harness, Role::CheckBox, "Estimate error");
    let before = places(&harness);
    assert!(harness.query_by_label_contains("measuring").is_some());
    (0..30).for_each(|_| harness.state_mut().session.step_forward());
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("error over the last").is_some());
    assert_eq!(places(&harness), before, "when the estimate comes");
    click(&mut harness, Role::CheckBox, "Colour by error");
    assert!(harness.state().scale().is_some(), "there is a scale of colours");
    assert_eq!(places(&harness), before, "when colours come");
    harness.state_mut().session.refuse(Err("it is not to be had"));
    harness.run_steps(2);
    assert!(harness.query_by_label("it is not to be had").is_some());
    assert_eq!(places(&harness), before, "when something is refused");
}

#[test]
fn the_distance_of_a_twin_is_read_off_in_metres_and_seconds() {
    let mut harness = harness("jelly", [1280.0, 800.0]);
    harness.get_by_label_contains("Compare with").click();
    harness.run_steps(3);
    for steps in [20, 40, 60] {
        (0..steps).for_each(|_| harness.state_mut().session.step_forward());
        harness.run_steps(3);
        let plot = harness.get_by_label_contains(" apart (rms)").rect();
        // Above the material sliders.
        let end = harness.get_by_label("MATERIAL").rect().top();
        for unit in ["m", "s"] {
            let is_number = |shown: &&egui::epaint::ClippedShape| match &shown.shape {
                egui::Shape::Text(text) => {
                    let words = text.galley.text();
                    let place = shown.shape.visual_bounding_rect();
                    words.starts_with(|first: char| first.is_numeric())
                        && words.ends_with(unit)
                        && plot.bottom() <= place.top()
                        && place.bottom() < end
                }
                _ => false,
            };
            let count = harness.output().shapes.iter().filter(is_number).count();
            assert!(2 <= count, "{count} numbers in {unit}");
        }
    }
}

#[test]
fn a_link_that_is_copied_says_so_and_one_that_cannot_be_says_why() {
    // High enough to show the whole left panel.
    let size = [1280.0, 1000.0];
    let mut harness = harness("jelly", size);
    click(&mut harness, Role::Button, "Copy link");
    assert!(harness.query_by_label("link copied").is_some());
    let mut unknown = loaded("jelly");
    unknown.title = "of another machine".into();
    let viewer = Viewer::new(unknown, catalogue()).expect("a valid scene");
    let mut harness = harness_of(viewer, size);
    click(&mut harness, Role::Button, "Copy link");
    assert!(harness.query_by_label("it is not from a file").is_some());
    assert!(harness.query_by_label("link copied").is_none());
}

#[test]
fn contact_that_is_switched_off_is_not_called_a_lack_of_planes() {
    let mut jelly = harness("jelly", [1280.0, 800.0]);
    assert!(jelly.query_by_label("contact is switched off").is_none());
    jelly.state_mut().session.switch(Part::Contact, false);
    jelly.run_steps(2);
    assert!(jelly.query_by_label("contact is switched off").is_some());
    let mut chain = loaded("chain");
    chain.scene.planes.clear();
    let chain = Viewer::new(chain, catalogue()).expect("a valid scene");
    let chain = harness_of(chain, [1280.0, 800.0]);
    assert!(chain.query_by_label("no planes in this scene").is_some());
}

#[test]
fn a_stiffness_is_shown_with_a_prefix_and_kept_to_its_last_digit() {
    let mut harness = harness("jelly", [1280.0, 800.0]);
    let shown = |harness: &Harness<'_, Viewer>| {
        let number = harness.get_by_role_and_label(Role::SpinButton, "Stiffness");
        number.accesskit_node().value()
    };
    harness.state_mut().session.edit(MaterialEdit::Stiffness(1e6));
    harness.run_steps(2);
    assert_eq!(shown(&harness).as_deref(), Some("1 MN/m"));
    harness.state_mut().session.edit(MaterialEdit::Stiffness(2345.678));
    harness.run_steps(2);
    assert_eq!(shown(&harness).as_deref(), Some("2.346 kN/m"));
    let k = |harness: &Harness<'_, Viewer>| {
        let runner = harness.state().session.runner();
        on!(runner, simulation => simulation.model().stiffness(0).to_f64())
    };
    let before = k(&harness);
    harness.get_by_role_and_label(Role::SpinButton, "Stiffness").focus();
    harness.run_steps(2);
    harness.get_by_role_and_label(Role::SpinButton, "Damping").focus();
    harness.run_steps(2);
    assert_eq!(k(&harness), before, "the focus only passed by");
}

#[test]
fn all_of_the_trade_is_within_reach_in_a_small_window() {
    for size in [[1280.0, 800.0], [800.0, 600.0]] {
        let mut harness = harness("jelly", size);
        harness.state_mut().session.set_trading(true);
        harness.state_mut().session.set_study_paused(true);
        harness.run_steps(3);
        let view = harness.state().layout.rect;
        for label in ["from start", "double precision"] {
            let node = |harness: &Harness<'_, Viewer>| harness.get_by_label(label).rect();
            harness.get_by_label(label).scroll_to_me();
            harness.run_steps(60);
            let rect = node(&harness);
            assert!(view.x_range().contains(rect.left()), "{label} in {size:?}: {rect:?}");
            assert!(view.x_range().contains(rect.right()), "{label} in {size:?}: {rect:?}");
            let room = view.bottom()..=size[1];
            assert!(room.contains(&rect.top()) && room.contains(&rect.bottom()), "{rect:?}");
        }
        harness.state_mut().session.set_trading(false);
    }
}
