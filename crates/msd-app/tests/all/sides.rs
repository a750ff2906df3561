//! A twin beside the run: two views, the same camera and the same input.

use crate::frames::{FRAME, frame, loaded};
use egui::{Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::catalogue;
use msd_app::panel::theme;
use msd_app::viewer::{Side, Viewer};
use msd_core::{Integrator, Settings, Vector};
use msd_run::on;

/// Returns a window with a twin beside the run, started and set by its buttons.
fn harness(scene: &str) -> Harness<'static, Viewer> {
    let mut viewer = Viewer::new(loaded(scene), catalogue()).expect("a valid scene");
    viewer.session.toggle_pause();
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 800.0));
    let mut harness = builder.build_ui_state(frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    harness.get_by_label_contains("Compare with").click();
    harness.run_steps(3);
    assert_eq!(harness.state().sides(), [Side::Run]);
    harness.get_by_label("Side by side").click();
    harness.run_steps(3);
    assert_eq!(harness.state().sides(), [Side::Run, Side::Twin]);
    harness
}

/// Returns the position of a particle of a side in the window.
fn place(viewer: &Viewer, side: Side, particle: usize) -> Pos2 {
    let position =
        on!(viewer.runner_of(side), simulation => simulation.position(particle).to_f32());
    viewer.viewport_of(side).project(position).expect("in front of the camera")
}

fn height(viewer: &Viewer, side: Side, particle: usize) -> f64 {
    on!(viewer.runner_of(side), simulation => simulation.position(particle).to_f64().y)
}

#[test]
fn each_side_shows_the_whole_scene_by_the_same_camera() {
    let mut harness = harness("cube");
    let count = harness.state().session.runner().particle_count();
    let viewer = harness.state();
    let [run, twin] = [Side::Run, Side::Twin].map(|side| viewer.viewport_of(side).rect);
    assert_eq!((run.right(), run.size()), (twin.left(), twin.size()));
    for particle in 0..count {
        for (side, rect) in [(Side::Run, run), (Side::Twin, twin)] {
            assert!(rect.contains(place(viewer, side, particle)), "{side:?} {particle}");
        }
    }
    // Both have the same state: half a window apart, to the rounding of single precision.
    let apart = place(viewer, Side::Twin, 5) - place(viewer, Side::Run, 5);
    assert!((apart - Vec2::new(run.width(), 0.0)).length() < 1e-2);
    let settings = harness.state().session.runner().settings();
    let other = Settings { integrator: Integrator::Rk4, ..settings };
    harness.state_mut().session.set_twin(None);
    assert_eq!(harness.state().sides(), [Side::Run], "without a twin the picture is whole");
    harness.state_mut().session.set_twin(Some(other));
    assert_eq!(harness.state().sides().len(), 2);
}

#[test]
fn picking_works_on_both_sides_and_a_grab_moves_both() {
    for side in [Side::Run, Side::Twin] {
        let mut harness = harness("cube");
        // The highest particle is not hidden.
        let viewer = harness.state();
        let count = viewer.session.runner().particle_count();
        let top = (0..count).map(|particle| place(viewer, side, particle));
        let at = top.min_by(|a, b| a.y.total_cmp(&b.y)).expect("a particle");
        harness.hover_at(at);
        harness.run_steps(2);
        harness.drag_at(at);
        harness.run_steps(2);
        // One of the particles that are as near to the pointer, within the reach of a click.
        let particle = harness.state().session.held().expect("a particle");
        assert!(place(harness.state(), side, particle).distance(at) < 18.0, "{side:?}");
        let before = [Side::Run, Side::Twin].map(|side| height(harness.state(), side, particle));
        harness.hover_at(at - Vec2::new(0.0, 60.0));
        harness.run_steps(2);
        harness.state_mut().session.toggle_pause();
        for _ in 0..12 {
            harness.state_mut().session.advance(FRAME + 1e-9, &|| 0.0);
        }
        for (row, of) in [Side::Run, Side::Twin].into_iter().enumerate() {
            let now = height(harness.state(), of, particle);
            assert!(before[row] + 0.01 < now, "{of:?} by a grab in {side:?}: {now}");
        }
        let apart = harness.state().session.twin().expect("a twin").apart();
        assert!(0.0 < apart.rms, "they are stepped differently");
    }
}
