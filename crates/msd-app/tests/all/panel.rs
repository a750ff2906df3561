//! The panels alone: widgets found by name, clicked and dragged without a window.

use crate::frames::{click, frame, window};
use egui::Vec2;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::input::read_pointer;
use msd_app::panel::{self, theme};
use msd_app::session::{Deed, MaterialEdit};
use msd_app::viewer::{Command, Viewer, catalogue};
use msd_core::{Integrator, Real, Vector};
use msd_render::Quantity;
use msd_run::on;
use msd_run::rescue::{Offer, Remedy};
use msd_scene::Precision;
use msd_scene::schema::SolverRow;

fn harness() -> Harness<'static, Viewer> {
    harness_of("jelly")
}

fn harness_of(scene: &str) -> Harness<'static, Viewer> {
    let loaded = msd_scene::open(scene).expect("a built-in scene");
    let viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    window(viewer, [1280.0, 800.0])
}

fn stiffness(harness: &Harness<'_, Viewer>) -> f64 {
    on!(harness.state().session.runner(), simulation => {
        simulation.model().stiffness(0).to_f64()
    })
}

/// Presses at a point, moves to another in two frames, and releases.
fn drag(harness: &mut Harness<'_, Viewer>, from: egui::Pos2, to: egui::Pos2) {
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from.lerp(to, 0.5));
    harness.run_steps(1);
    harness.hover_at(to);
    harness.run_steps(1);
    harness.drop_at(to);
    harness.run_steps(2);
}

/// Runs a frame on a machine that renders less than one per second.
fn slow_frame(ui: &mut egui::Ui, viewer: &mut Viewer) {
    read_pointer(ui.ctx(), viewer);
    viewer.session.advance(1.5, &|| 0.0);
    panel::show(ui, viewer);
}

#[test]
fn what_is_edited_from_a_press_to_its_release_is_one_edit_however_few_frames_there_are() {
    let loaded = msd_scene::open("jelly").expect("a built-in scene");
    let mut viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    viewer.session.toggle_pause();
    let builder = Harness::builder().with_size(Vec2::new(1280.0, 1600.0));
    let mut harness = builder.build_ui_state(slow_frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    let set = |harness: &Harness<'_, Viewer>| {
        let session = &harness.state().session;
        (*session.material().values(), session.runner().solver())
    };
    let before = set(&harness);
    let sliders = [
        ("Mass", "mass"),
        ("Stiffness", "stiffness"),
        ("Damping", "damping"),
        ("Rest length", "rest length"),
        ("Gravity", "gravity"),
        ("Restitution", "restitution"),
        ("Friction", "friction"),
        ("Substeps", "substeps"),
    ];
    for (label, words) in sliders {
        let slider = harness.get_by_role_and_label(Role::Slider, label).rect();
        let at = |part: f32| slider.left_center() + Vec2::new(part * slider.width(), 0.0);
        drag(&mut harness, at(0.3), at(0.9));
        let named = |deed: Option<Deed>| deed.map(Deed::words);
        assert_eq!(named(harness.state().session.undoes()), Some(words));
        assert_ne!(set(&harness), before, "{label}");
        // No frame passes between two drags, which are still two edits.
        let first = set(&harness);
        harness.drag_at(at(0.7));
        harness.hover_at(at(0.5));
        harness.run_steps(1);
        harness.drop_at(at(0.5));
        harness.run_steps(1);
        assert_ne!(set(&harness), first, "{label}");
        let session = &mut harness.state_mut().session;
        session.undo();
        assert_eq!(named(session.undoes()), Some(words), "the first drag of {label}");
        session.undo();
        assert_eq!((session.undoes(), named(session.redoes())), (None, Some(words)));
        assert_eq!(set(&harness), before, "{label}");
    }
}

#[test]
fn the_energy_is_seen_without_scrolling_and_the_timeline_is_as_wide_as_the_window() {
    let harness = harness();
    // The last line of the section is above the timeline.
    let timeline = harness.state().layout.landmarks["timeline"];
    let last = harness.get_by_label_contains("energy error\u{a0}").rect();
    assert!(last.bottom() < timeline.top(), "{last:?} {timeline:?}");
    assert!(0.7 * 1280.0 < timeline.width(), "{timeline:?}");
    let loaded = msd_scene::open("jelly").expect("a built-in scene");
    let viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    let small = Harness::builder().with_size(Vec2::new(800.0, 600.0));
    let mut small = small.build_ui_state(frame, viewer);
    small.run_steps(3);
    assert!(0.55 * 800.0 < small.state().layout.landmarks["timeline"].width());
}

#[test]
fn the_work_of_wind_is_shown_beside_what_is_dissipated_and_only_where_there_is_some() {
    let shows_supply = |scene: &str| {
        let mut harness = harness_of(scene);
        for _ in 0..30 {
            harness.state_mut().session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        }
        harness.run_steps(2);
        assert!(harness.query_by_label_contains("dissipated\u{a0}").is_some());
        harness.query_by_label_contains("supplied\u{a0}").is_some()
    };
    assert!(shows_supply("flag"), "wind works on it");
    assert!(!shows_supply("jelly"), "nothing drives it");
}

/// Returns the texts that end in some letters, with their areas and clip rectangles.
fn texts(harness: &Harness<'_, Viewer>, end: &str) -> Vec<(String, egui::Rect, egui::Rect)> {
    let mut found = Vec::new();
    for clipped in &harness.output().shapes {
        if let egui::Shape::Text(text) = &clipped.shape
            && text.galley.text().ends_with(end)
        {
            let rect = clipped.shape.visual_bounding_rect();
            found.push((text.galley.text().into(), rect, clipped.clip_rect));
        }
    }
    found
}

#[test]
fn no_number_of_the_time_axis_is_cut_off() {
    let mut harness = harness_of("chain");
    let plot = harness.get_by_label_contains("energy error\u{a0}").rect();
    let mut seen = 0;
    // Ticks enter at the right edge from 12 s on, every 5 s, and get wider.
    for frame in 0..60 * 22 {
        harness.state_mut().session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        if frame < 60 * 9 || frame % 8 != 0 {
            continue;
        }
        harness.step();
        for (text, rect, clip) in texts(&harness, " s") {
            let is_of_the_plot = plot.left() < rect.left() && rect.bottom() < plot.top();
            if is_of_the_plot && 600.0 < rect.top() && text.starts_with(|c: char| c.is_numeric()) {
                seen += 1;
                let inside = clip.left() <= rect.left() && rect.right() <= clip.right();
                assert!(inside, "{text} at {rect:?} in {clip:?}");
            }
        }
    }
    // At least two in each frame.
    assert!(150 < seen, "only {seen} numbers were there");
}

#[test]
fn the_main_numbers_stay_in_sight_where_the_panel_is_longer_than_the_window() {
    let mut harness = harness();
    let is_short = |harness: &Harness<'_, Viewer>| {
        harness.query_by_label_contains("energy\u{a0}error").is_none()
    };
    assert!(is_short(&harness), "the panel fits");
    click(&mut harness, Role::CheckBox, "Estimate error");
    harness.get_by_label_contains("Compare with").click();
    harness.run_steps(6);
    for words in
        ["substep:\u{a0}", "error\u{a0}", "twin\u{a0}", "energy\u{a0}", "energy\u{a0}error\u{a0}"]
    {
        // The energy section also says "energy error", below the edge.
        let bottom = harness.state().layout.landmarks["timeline"].top();
        let mut lines = harness.query_all_by_label_contains(words).map(|line| line.rect());
        assert!(lines.any(|line| 0.0 < line.top() && line.bottom() < bottom), "{words}");
    }
    harness.state_mut().session.set_twin(None);
    harness.state_mut().session.set_estimating(false);
    harness.run_steps(6);
    assert!(is_short(&harness), "it fits again");
}

#[test]
fn a_drag_goes_on_where_it_makes_the_panel_longer_than_the_window() {
    let mut harness = harness();
    click(&mut harness, Role::CheckBox, "Estimate error");
    let rect = harness.get_by_role_and_label(Role::Slider, "Wind").rect();
    // The first half of the way makes a wind, which adds two sliders.
    drag(&mut harness, rect.left_center() + Vec2::new(6.0, 0.0), rect.right_center());
    assert!(50.0 < harness.state().session.wind().strength);
    assert!(harness.query_by_label_contains("energy\u{a0}error").is_some(), "it is longer");
}

#[test]
fn dragging_the_slider_changes_k_in_the_simulation() {
    let mut harness = harness();
    assert_eq!(stiffness(&harness), 2200.0);
    let rect = harness.get_by_role_and_label(Role::Slider, "Stiffness").rect();
    drag(&mut harness, rect.center(), rect.right_center() - Vec2::new(4.0, 0.0));
    assert!(1e5 < stiffness(&harness), "k is {}", stiffness(&harness));
    drag(&mut harness, rect.center(), rect.left_center() + Vec2::new(20.0, 0.0));
    assert!(stiffness(&harness) < 100.0, "k is {}", stiffness(&harness));
}

#[test]
fn the_pause_button_pauses_and_runs() {
    let mut harness = harness();
    click(&mut harness, Role::Button, "Pause");
    assert!(harness.state().session.is_paused());
    click(&mut harness, Role::Button, "Run");
    assert!(!harness.state().session.is_paused());
}

#[test]
fn steps_go_forward_and_back() {
    let mut harness = harness();
    click(&mut harness, Role::Button, "Step");
    click(&mut harness, Role::Button, "Step");
    assert_eq!(harness.state().session.runner().steps(), 2);
    click(&mut harness, Role::Button, "Back");
    assert_eq!(harness.state().session.runner().steps(), 1);
    click(&mut harness, Role::Button, "Restart");
    assert_eq!(harness.state().session.runner().steps(), 0);
}

#[test]
fn the_scene_list_switches_scenes_and_frames_them() {
    let mut harness = harness();
    let before = harness.state().camera;
    harness.get_by_label_contains("cloth").click();
    harness.run_steps(3);
    assert_eq!(harness.state().session.loaded().name, "cloth");
    assert_eq!(harness.state().session.runner().particle_count(), 31 * 31);
    assert_ne!(harness.state().camera, before);
}

#[test]
fn method_and_precision_are_chosen() {
    let mut harness = harness();
    click(&mut harness, Role::ComboBox, "Method");
    click(&mut harness, Role::Button, "rk4");
    assert_eq!(harness.state().session.runner().integrator(), Integrator::Rk4);
    click(&mut harness, Role::Button, "f64");
    assert_eq!(harness.state().session.runner().precision(), Precision::F64);
}

#[test]
fn every_method_can_be_chosen_and_runs() {
    let mut harness = harness();
    harness.state_mut().open_named("square4");
    harness.run_steps(3);
    for integrator in Integrator::ALL {
        click(&mut harness, Role::ComboBox, "Method");
        click(&mut harness, Role::Button, integrator.name());
        assert_eq!(harness.state().session.runner().integrator(), integrator);
        let before = harness.state().session.runner().steps();
        for _ in 0..30 {
            harness.state_mut().command(Command::StepForward);
        }
        let session = &harness.state().session;
        assert_eq!(session.failure(), None, "{integrator}");
        assert_eq!(session.runner().steps(), before + 30, "{integrator}");
    }
}

#[test]
fn a_method_has_the_controls_that_it_reads() {
    let mut harness = harness();
    for integrator in Integrator::ALL {
        harness.state_mut().session.tune(SolverRow::integrator(integrator));
        harness.state_mut().session.advance(0.0, &|| 0.0);
        harness.run_steps(3);
        let there = |label| harness.query_by_role_and_label(Role::Slider, label).is_some();
        let adaptive = integrator == Integrator::DormandPrince;
        let implicit = [Integrator::BackwardEuler, Integrator::ImplicitMidpoint];
        let implicit = implicit.contains(&integrator);
        assert_eq!(there("Tolerance"), adaptive, "{integrator}");
        assert_eq!(there("Substeps"), !adaptive, "{integrator}");
        assert_eq!(there("Newton"), implicit, "{integrator}");
        let says = |text| harness.query_by_label(text).is_some();
        let stable = implicit || integrator == Integrator::Xpbd;
        assert_eq!(says("any step is stable"), stable, "{integrator}");
        assert_eq!(says("the step follows the tolerance"), adaptive);
    }
}

#[test]
fn dragging_the_tolerance_sets_it() {
    let mut harness = harness();
    harness.state_mut().session.tune(SolverRow::integrator(Integrator::DormandPrince));
    harness.run_steps(3);
    let tolerance =
        |harness: &Harness<'_, Viewer>| harness.state().session.runner().settings().tolerance;
    let rect = harness.get_by_role_and_label(Role::Slider, "Tolerance").rect();
    drag(&mut harness, rect.center(), rect.left_center() + Vec2::new(6.0, 0.0));
    assert!((1e-10..1e-8).contains(&tolerance(&harness)), "{}", tolerance(&harness));
    drag(&mut harness, rect.center(), rect.right_center() - Vec2::new(6.0, 0.0));
    assert!((1e-2..=1e-1).contains(&tolerance(&harness)), "{}", tolerance(&harness));
}

#[test]
fn the_error_is_estimated_on_demand() {
    let mut harness = harness();
    let says =
        |harness: &Harness<'_, Viewer>, text: &str| harness.query_by_label_contains(text).is_some();
    assert!(!says(&harness, "measuring") && harness.state().session.error().is_none());
    click(&mut harness, Role::CheckBox, "Estimate error");
    assert!(says(&harness, "measuring"));
    for _ in 0..30 {
        harness.state_mut().command(Command::StepForward);
    }
    harness.run_steps(2);
    assert!(says(&harness, "error over the last 0.5 s") && says(&harness, "largest: particle"));
    click(&mut harness, Role::CheckBox, "Estimate error");
    assert!(!says(&harness, "error over the last") && !says(&harness, "measuring"));
}

#[test]
fn a_particle_is_dragged_and_thrown() {
    let mut harness = harness();
    // The corner of the block that is nearest to the camera.
    let viewer = harness.state();
    let depth = |particle: usize| viewer.camera.depth(viewer.session.position(particle).as_vec3());
    let corner = (0..1000).min_by(|&a, &b| depth(a).total_cmp(&depth(b))).expect("particles");
    let at = viewer.session.position(corner).as_vec3();
    let from = viewer.viewport().project(at).expect("in view");
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(2);
    assert_eq!(harness.state().session.held(), Some(corner));
    let to = from + Vec2::new(0.0, -120.0);
    harness.hover_at(to);
    harness.run_steps(1);
    // The target is at the pointer, independently of the particle.
    let target = harness.state().session.grab_target().expect("held").as_vec3();
    let shown = harness.state().viewport().project(target).expect("in view");
    assert!(shown.distance(to) < 1.0, "{shown:?} {to:?}");
    let still = on!(harness.state().session.runner(), simulation => {
        simulation.velocity(corner).to_f64()
    });
    for _ in 0..10 {
        harness.state_mut().session.advance(1.0 / 60.0, &|| 0.0);
    }
    harness.drop_at(to);
    harness.run_steps(1);
    assert_eq!(harness.state().session.held(), None);
    let thrown = on!(harness.state().session.runner(), simulation => {
        simulation.velocity(corner).to_f64()
    });
    assert!(still.y + 1.0 < thrown.y, "{still} {thrown}");
}

#[test]
fn a_drag_beside_the_body_turns_the_camera_and_a_slider_does_not() {
    let mut harness = harness();
    let before = harness.state().camera;
    let corner = harness.state().layout.rect.left_top() + Vec2::splat(20.0);
    drag(&mut harness, corner, corner + Vec2::new(100.0, 30.0));
    let after = harness.state().camera;
    assert_ne!((after.yaw, after.pitch), (before.yaw, before.pitch));
    let rect = harness.get_by_role_and_label(Role::Slider, "Gravity").rect();
    // Out of the panel and over the scene: the slider keeps the pointer until release.
    drag(&mut harness, rect.center(), rect.center() - Vec2::new(500.0, 0.0));
    assert_eq!(harness.state().camera, after);
    assert_eq!(harness.state().session.held(), None);
    assert_eq!(harness.state().session.material().values().gravity, 0.0);
}

/// Returns whether a percentage of the limit is shown.
fn shows_limit(harness: &Harness<'_, Viewer>) -> bool {
    harness.query_by_label_contains("the stable limit").is_some()
        || harness.query_by_label_contains("step is stable").is_some()
}

#[test]
fn the_percentage_is_gone_in_the_very_next_frame() {
    let mut harness = harness();
    let predict = |harness: &mut Harness<'_, Viewer>| {
        harness.state_mut().session.advance(0.0, &|| 0.0);
        harness.run_steps(1);
        assert!(shows_limit(harness));
    };
    predict(&mut harness);
    click(&mut harness, Role::ComboBox, "Method");
    assert!(shows_limit(&harness));
    // Chosen in one frame, gone in the next.
    harness.get_by_role_and_label(Role::Button, "explicit-euler").click();
    harness.run_steps(2);
    assert_eq!(harness.state().session.runner().integrator(), Integrator::ExplicitEuler);
    assert!(!shows_limit(&harness));
    assert!(harness.query_by_label("predicting…").is_some());
    predict(&mut harness);
    harness.state_mut().session.edit(MaterialEdit::Stiffness(3e5));
    harness.run_steps(1);
    assert!(!shows_limit(&harness));
    // The energy of the old springs is gone too.
    assert!(harness.query_by_label("elastic\u{a0}…").is_some());
    predict(&mut harness);
    assert!(harness.query_by_label("elastic\u{a0}…").is_none());
}

#[test]
fn a_divergence_shows_ways_out_and_what_the_panel_shows() {
    let mut harness = harness();
    let session = &mut harness.state_mut().session;
    session.tune(SolverRow::substeps(1));
    session.edit(MaterialEdit::Stiffness(1e6));
    session.advance(0.0, &|| 0.0);
    (0..600).for_each(|_| {
        session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
    });
    let offers = session.offers().to_vec();
    harness.run_steps(3);
    // The box and the panel show the same share of the limit.
    let share = harness.query_all_by_label_contains("× the stable limit").count()
        + harness.query_all_by_label_contains("% of the stable limit").count();
    assert_eq!(share, 2);
    assert!(harness.query_by_label("Reset to the scene's values").is_some());
    let method = |offer: &Offer| matches!(offer.remedy, Remedy::Method(..));
    assert!(offers.iter().any(method));
    let substeps = offers.iter().find_map(|offer| match offer.remedy {
        Remedy::Substeps(substeps) => Some(substeps),
        _ => None,
    });
    let substeps = substeps.expect("a number of substeps");
    click(&mut harness, Role::Button, &format!("{substeps} substeps"));
    let session = &harness.state().session;
    assert!(session.failure().is_none() && !session.is_paused());
    assert_eq!(session.runner().settings().substeps, substeps);
}

#[test]
fn the_camera_does_not_follow_debris() {
    let mut harness = harness();
    let viewer = harness.state_mut();
    viewer.session.tune(SolverRow::substeps(1));
    viewer.session.edit(MaterialEdit::Stiffness(1e6));
    viewer.session.advance(0.0, &|| 0.0);
    for _ in 0..600 {
        viewer.session.advance(1.0 / 60.0 + 1e-9, &|| 0.0);
        viewer.look(1.0 / 60.0);
    }
    assert!(viewer.session.failure().is_some());
    harness.run_steps(2);
    let viewer = harness.state();
    for particle in 0..viewer.session.runner().particle_count() {
        let at = viewer.session.position(particle).as_vec3();
        let place = viewer.viewport().project(at).expect("in front");
        assert!(viewer.layout.rect.contains(place), "{place:?}");
    }
}

#[test]
fn help_opens_and_closes() {
    let mut harness = harness();
    harness.state_mut().command(Command::Help);
    harness.run_steps(3);
    assert!(harness.query_by_label("pause / resume").is_some());
    harness.state_mut().command(Command::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("pause / resume").is_none());
}

#[test]
fn every_command_is_harmless_in_every_scene() {
    let mut harness = harness();
    for index in 0..catalogue().entries.len() {
        harness.state_mut().open_entry(index);
        for command in [
            Command::TogglePause,
            Command::StepForward,
            Command::StepBack,
            Command::StepBack,
            Command::Pin,
            Command::Undo,
            Command::Redo,
            Command::Freeze,
            Command::Wireframe,
            Command::FrameAll,
            Command::Escape,
            Command::Restart,
            Command::TogglePause,
            Command::Scene(99),
        ] {
            harness.state_mut().command(command);
        }
        harness.run_steps(2);
        assert_eq!(harness.state().session.loaded().name, catalogue().entries[index].name);
    }
    assert!(!harness.state().wishes.quit);
}

#[test]
fn what_was_carried_away_comes_back_into_the_picture() {
    let mut harness = harness();
    let viewer = harness.state_mut();
    viewer.look(0.0);
    viewer.session.toggle_pause();
    // As after a long drag: the scene is far to the right of the camera's target.
    viewer.camera.target -= viewer.camera.right() * 20.0;
    viewer.aim.follow = false;
    viewer.look(0.0);
    viewer.aim.follow = true;
    (0..60).for_each(|_| viewer.look(1.0 / 60.0));
    let viewport = viewer.viewport();
    for particle in 0..viewer.session.runner().particle_count() {
        let place =
            viewport.project(viewer.session.position(particle).as_vec3()).expect("in front");
        assert!(viewer.layout.rect.contains(place), "{place:?}");
    }
}

#[test]
fn a_scene_of_a_file_stays_in_the_list() {
    let mut loaded = msd_scene::open("square").expect("a built-in scene");
    loaded.title = "of a file".to_owned();
    let mut viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
    let strain = Some(Quantity::Strain);
    assert!(viewer.style.colour_by == strain && viewer.current().is_none());
    viewer.open_entry(0);
    assert!(viewer.style.colour_by.is_none() && viewer.opened().is_some());
    viewer.reopen();
    assert_eq!(viewer.session.loaded().title, "of a file");
    assert!(viewer.style.colour_by == strain && viewer.current().is_none());
    for index in 0..catalogue().entries.len() {
        let loaded = msd_scene::open(catalogue().entries[index].name).expect("a built-in scene");
        let viewer = Viewer::new(loaded, catalogue()).expect("a valid scene");
        assert_eq!(viewer.current(), Some(index));
    }
}

#[test]
fn explicit_euler_is_one_click_from_the_first_screen() {
    let mut harness = harness();
    click(&mut harness, Role::Button, "Compare with explicit-euler");
    let twin = harness.state().session.twin().expect("it is on");
    assert_eq!(twin.settings().integrator, Integrator::ExplicitEuler);
    (0..10).for_each(|_| harness.state_mut().session.step_forward());
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("apart (rms)").is_some());
    assert!(harness.query_by_label_contains("explicit-euler as points").is_none());
    click(&mut harness, Role::Button, "End twin");
    assert!(harness.state().session.twin().is_none());
}

#[test]
fn the_timeline_is_dragged_and_undo_has_its_buttons() {
    let mut harness = harness();
    (0..100).for_each(|_| harness.state_mut().session.step_forward());
    harness.run_steps(2);
    let rect = harness.get_by_role_and_label(Role::Slider, "Timeline").rect();
    drag(&mut harness, rect.right_center() - Vec2::new(4.0, 0.0), rect.center());
    let ahead = harness.state().session.steps_ahead();
    assert!((45..=55).contains(&ahead), "{ahead} steps back");
    assert_eq!(harness.state().session.runner().steps(), 100 - ahead as u64);
    harness.run_steps(1);
    assert!(harness.query_by_label_contains("resume from here").is_some());
    harness.state_mut().session.edit(MaterialEdit::Stiffness(1e3));
    harness.run_steps(2);
    assert_eq!(harness.state().session.steps_ahead(), 0);
    click(&mut harness, Role::Button, "Undo");
    assert_eq!(stiffness(&harness), 2200.0);
    click(&mut harness, Role::Button, "Redo");
    assert_eq!(stiffness(&harness), 1e3);
}

#[test]
fn automatic_substeps_are_a_click_and_the_slider_ends_them() {
    let mut harness = harness();
    click(&mut harness, Role::CheckBox, "Automatic substeps");
    assert!(harness.state().session.runner().is_automatic());
    assert!(harness.query_by_role_and_label(Role::ProgressIndicator, "Stability").is_some());
    let rect = harness.get_by_role_and_label(Role::Slider, "Substeps").rect();
    drag(&mut harness, rect.center(), rect.center() + Vec2::new(20.0, 0.0));
    assert!(!harness.state().session.runner().is_automatic());
}
