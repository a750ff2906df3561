//! The control with the focus: visible and framed, in dark and in light panels.

use crate::frames::{loaded, window};
use egui::accesskit::Role;
use egui::{Color32, Key, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::panel::theme;
use msd_app::viewer::{Viewer, catalogue};
use msd_core::Integrator;

fn harness(size: [f32; 2]) -> Harness<'static, Viewer> {
    let viewer = Viewer::new(loaded("cube"), catalogue()).expect("a valid scene");
    window(viewer, size)
}

/// Returns the contrast of two opaque colours by WCAG 2.1.
fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |colour: Color32| {
        let [red, green, blue, _] = egui::Rgba::from(colour).to_array();
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    };
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// Returns the frames around a place that are not clipped: width, colour, and fill.
fn frames_at(harness: &Harness<'_, Viewer>, place: egui::Rect) -> Vec<(f32, Color32, Color32)> {
    let mut shapes: Vec<_> =
        harness.output().shapes.iter().map(|clipped| (clipped.clip_rect, &clipped.shape)).collect();
    let mut found = Vec::new();
    while let Some((clip, shape)) = shapes.pop() {
        match shape {
            Shape::Vec(inner) => shapes.extend(inner.iter().map(|shape| (clip, shape))),
            Shape::Rect(rect) if place.expand(4.0).contains_rect(rect.rect) => {
                let is_whole = clip.expand(1.0).contains_rect(rect.rect);
                if is_whole && 0.0 < rect.stroke.width {
                    found.push((rect.stroke.width, rect.stroke.color, rect.fill));
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn what_has_the_keyboard_is_in_sight_and_framed() {
    for (light, size) in [(false, [800.0, 600.0]), (true, [1280.0, 800.0])] {
        let mut harness = harness(size);
        theme::choose(&harness.ctx, light);
        harness.run_steps(3);
        let paper = harness.ctx.global_style().visuals.panel_fill;
        let mut reached = Vec::new();
        for _ in 0..120 {
            harness.key_press(Key::Tab);
            harness.run_steps(30);
            let id = harness.ctx.memory(|memory| memory.focused()).expect("the focus");
            if reached.contains(&id) {
                break;
            }
            reached.push(id);
            let control = harness.ctx.read_response(id).expect("it is shown");
            let with = frames_at(&harness, control.rect);
            harness.ctx.memory_mut(|memory| memory.surrender_focus(id));
            harness.run_steps(2);
            let without = frames_at(&harness, control.rect);
            harness.ctx.memory_mut(|memory| memory.request_focus(id));
            harness.run_steps(2);
            let is_seen = |frame: &&(f32, Color32, Color32)| {
                let around = if frame.2.a() == 255 { frame.2 } else { paper };
                // Level AA for graphics.
                !without.contains(frame)
                    && 3.0 <= contrast(frame.1, around)
                    && 3.0 <= contrast(frame.1, paper)
            };
            assert!(
                with.iter().any(|frame| is_seen(&frame)),
                "light {light}, number {} at {:?}: {with:?}, else {without:?}",
                reached.len(),
                control.rect
            );
        }
        assert!(40 < reached.len(), "{}", reached.len());
    }
}

#[test]
fn a_choice_is_opened_walked_and_taken_by_keys_alone() {
    let mut harness = harness([1280.0, 800.0]);
    harness.get_by_role_and_label(Role::ComboBox, "Method").focus();
    harness.run_steps(2);
    // From the field into the list, and to its second line.
    for key in [Key::Enter, Key::ArrowDown, Key::ArrowDown, Key::Enter] {
        harness.key_press(key);
        harness.run_steps(3);
    }
    assert_eq!(harness.state().session.runner().integrator(), Integrator::ALL[1]);
    assert!(harness.query_by_label(Integrator::Rk4.name()).is_none(), "the list is closed");
}

#[test]
fn a_list_that_is_longer_than_the_window_fades_into_the_paper_of_its_theme() {
    let mut harness = harness([800.0, 600.0]);
    for light in [false, true] {
        theme::choose(&harness.ctx, light);
        harness.run_steps(3);
        let paper = harness.ctx.global_style().visuals.panel_fill;
        let mut faded = 0;
        for shown in &harness.output().shapes {
            let Shape::Mesh(mesh) = &shown.shape else { continue };
            for colour in mesh.vertices.iter().map(|vertex| vertex.color) {
                if mesh.texture_id == egui::TextureId::default() && 0 < colour.a() {
                    faded += 1;
                    // Premultiplied, rounded to whole levels.
                    let full =
                        colour.to_array().map(|part| i32::from(part) * 255 / i32::from(colour.a()));
                    let far = |row: usize| (full[row] - i32::from(paper.to_array()[row])).abs();
                    assert!(
                        (0..3).all(|row| far(row) <= 255 / i32::from(colour.a()) + 1),
                        "{colour:?}"
                    );
                }
            }
        }
        assert!(2 <= faded, "nothing fades");
    }
}
