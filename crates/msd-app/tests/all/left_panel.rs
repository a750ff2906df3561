//! The left panel: the list of scenes, view options, the coloured quantity and its legend.

use crate::frames::{click, loaded, window};
use egui::accesskit::Role;
use egui::{Rect, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::session::Pace;
use msd_app::viewer::{Command, Viewer, catalogue};
use msd_render::{Quality, Quantity, Scale};
use msd_run::on;

fn harness() -> Harness<'static, Viewer> {
    harness_of("jelly")
}

fn harness_of(scene: &str) -> Harness<'static, Viewer> {
    let viewer = Viewer::new(loaded(scene), catalogue()).expect("a valid scene");
    window(viewer, [1280.0, 800.0])
}

/// Returns the areas of a text and their clip rectangles.
fn texts(harness: &Harness<'_, Viewer>, wanted: &str) -> impl Iterator<Item = (Rect, Rect)> {
    harness.output().shapes.iter().filter_map(move |clipped| match &clipped.shape {
        Shape::Text(text) if text.galley.text() == wanted => {
            Some((clipped.shape.visual_bounding_rect(), clipped.clip_rect))
        }
        _ => None,
    })
}

#[test]
fn the_list_of_scenes_is_short_and_shows_the_scene_that_runs() {
    let mut harness = harness();
    // Without scrolling: the last control of the panel.
    let last = harness.get_by_role_and_label(Role::Button, "Larger").rect();
    assert!(last.bottom() < harness.state().layout.landmarks["timeline"].top(), "{last:?}");
    let is_seen = |harness: &Harness<'_, Viewer>, name: &str| {
        texts(harness, name).any(|(rect, clip)| clip.contains_rect(rect))
    };
    let mut entries = catalogue().entries;
    entries.retain(|entry| !entry.is_lesson);
    let (first, last) = (entries[0].name, entries[entries.len() - 1].name);
    assert!(is_seen(&harness, first) && !is_seen(&harness, last));
    harness.state_mut().open_named(last);
    harness.run_steps(60);
    assert!(is_seen(&harness, last) && !is_seen(&harness, first));
    // A visible scene there can be clicked.
    let above = entries[entries.len() - 3].name;
    harness.get_by_label_contains(above).click();
    harness.run_steps(3);
    assert_eq!(harness.state().session.loaded().name, above);
}

#[test]
fn a_picture_that_may_cost_little_is_told() {
    let mut harness = harness();
    assert!(harness.query_by_label("no GPU: reduced graphics").is_none());
    harness.state_mut().quality = Quality::Fast;
    harness.run_steps(2);
    assert!(harness.query_by_label("no GPU: reduced graphics").is_some());
    // Half the resolution is a switch, with a label if it was chosen automatically.
    let pace = Pace { frame_rate: 10.0, ..Pace::default() };
    let state = harness.state_mut();
    (0..30).for_each(|_| state.sharpness.follow(Quality::Fast, Some(pace)));
    harness.run_steps(2);
    assert!(harness.query_by_label("half resolution").is_some());
    click(&mut harness, Role::CheckBox, "Half resolution");
    assert!(!harness.state().sharpness.is_half());
    assert!(harness.query_by_label("half resolution").is_none());
}

#[test]
fn toggles_change_what_is_drawn() {
    let mut harness = harness();
    click(&mut harness, Role::CheckBox, "Shadows");
    click(&mut harness, Role::CheckBox, "Particles");
    let style = harness.state().style;
    assert!(style.particles && !style.shadows);
    assert_eq!((style.colour_by, harness.state().scale()), (None, None));
    for quantity in Quantity::ALL {
        click(&mut harness, Role::ComboBox, "Colour by");
        harness.get_by_role_and_label(Role::Button, quantity.name()).click();
        harness.run_steps(3);
        assert_eq!(harness.state().style.colour_by, Some(quantity));
    }
    // The last is the error, which switches on the estimate and appears once it is known.
    let viewer = harness.state();
    assert!(viewer.session.error().is_some() && viewer.scale().is_none());
    click(&mut harness, Role::CheckBox, "Estimate error");
    assert_eq!(harness.state().style.colour_by, None);
}

#[test]
fn the_legend_of_the_window_is_that_of_a_picture_and_its_scale_only_grows() {
    let mut harness = harness_of("chain");
    (0..20).for_each(|_| harness.state_mut().session.step_forward());
    for quantity in [Quantity::Strain, Quantity::Force, Quantity::Energy, Quantity::Speed] {
        harness.state_mut().colour_by(Some(quantity));
        harness.run_steps(2);
        let viewer = harness.state();
        // The maximum of the current state.
        let largest = on!(viewer.session.runner(), simulation => {
            quantity.largest(&simulation.snapshot())
        });
        assert!(0.0 < largest, "{quantity:?}");
        let scale = Scale { quantity, full: quantity.full_scale(largest) };
        assert_eq!(viewer.scale(), Some(scale));
        let words = scale.ticks().map(|(_, number)| number);
        for told in words.iter().chain([&scale.title()]) {
            assert!(texts(&harness, told).next().is_some(), "{told}");
        }
    }
    let full = |harness: &Harness<'_, Viewer>| harness.state().scale().map(|scale| scale.full);
    let mut before = full(&harness);
    for _ in 0..30 {
        (0..5).for_each(|_| harness.state_mut().session.step_forward());
        harness.run_steps(1);
        assert!(before <= full(&harness));
        before = full(&harness);
    }
    harness.state_mut().command(Command::Restart);
    harness.run_steps(2);
    // Nothing moves at the start.
    assert_eq!(full(&harness), Some(1.0));
}

#[test]
fn every_slider_says_what_it_means() {
    for scene in ["jelly", "teapot", "flag", "drape"] {
        let mut harness = harness_of(scene);
        harness.ctx.all_styles_mut(|style| style.interaction.tooltip_delay = 0.0);
        let sliders = harness.get_all_by_role(Role::Slider);
        let places: Vec<Rect> = sliders.map(|slider| slider.rect()).collect();
        assert!(5 < places.len(), "{scene}: {places:?}");
        for place in places {
            let has_tooltip = |harness: &Harness<'_, Viewer>| {
                let is_one = |layer: egui::LayerId| layer.order == egui::Order::Tooltip;
                harness
                    .ctx
                    .memory(|memory| memory.areas().visible_layer_ids().into_iter().any(is_one))
            };
            harness.hover_at(egui::pos2(5.0, 5.0));
            harness.run_steps(3);
            assert!(!has_tooltip(&harness), "{scene}: a tooltip beside {place}");
            harness.hover_at(place.center());
            harness.run_steps(3);
            assert!(has_tooltip(&harness), "{scene}: {place}");
        }
    }
}
