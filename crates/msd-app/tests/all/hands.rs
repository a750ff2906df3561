//! User input: cuts, groups, the force of a grab, the wind, throws.

use crate::frames::{FRAME, loaded, run, window};
use egui::{Key, Modifiers, Pos2, Vec2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use msd_app::input::{read_pointer, take_commands};
use msd_app::panel::{self, theme};
use msd_app::session::{MOST_HELD, MaterialEdit, Session, Wind};
use msd_app::viewer::{Tool, Viewer, catalogue};
use msd_core::glam::DVec3;
use msd_core::obstacles::Placed;
use msd_core::{Particle, Pin, Scene, Spring, Vector};
use msd_run::on;
use msd_scene::Precision;
use msd_scene::schema::SolverRow;

/// Returns a scene in a window without a clock.
fn harness(name: &str) -> Harness<'static, Viewer> {
    let viewer = Viewer::new(loaded(name), catalogue()).expect("a valid scene");
    window(viewer, [1280.0, 800.0])
}

/// Presses a key as the window passes it on.
fn key(harness: &mut Harness<'_, Viewer>, key: Key) {
    let modifiers = Modifiers::NONE;
    let event =
        egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    let mut input = egui::RawInput { events: vec![event], ..Default::default() };
    for command in take_commands(&mut input, false) {
        harness.state_mut().command(command);
    }
    harness.run_steps(1);
}

/// Drags along points, one per frame.
fn drag(harness: &mut Harness<'_, Viewer>, path: &[Pos2], modifiers: Modifiers) {
    harness.event(egui::Event::ModifiersChanged(modifiers));
    harness.hover_at(path[0]);
    harness.run_steps(2);
    harness.drag_at(path[0]);
    harness.run_steps(1);
    for &at in &path[1..] {
        harness.hover_at(at);
        harness.run_steps(1);
    }
    harness.drop_at(path[path.len() - 1]);
    harness.run_steps(2);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(1);
}

/// Returns the uniform force on every particle, newtons.
fn force(session: &Session) -> DVec3 {
    on!(session.runner(), simulation => simulation.model().force().to_f64())
}

fn cut_springs(session: &Session) -> Vec<usize> {
    on!(session.runner(), simulation => {
        let model = simulation.model();
        (0..model.ends().len()).filter(|&spring| model.is_cut(spring)).collect()
    })
}

#[test]
fn a_stroke_cuts_the_springs_that_it_crosses_in_the_picture_and_no_others() {
    let mut harness = harness("cloth");
    let rect = harness.state().layout.rect;
    let (left, right, y) = (rect.center().x - 90.3, rect.center().x + 70.7, rect.center().y + 0.37);
    // The intersection of each spring with the height of the stroke.
    let viewer = harness.state();
    let place = |end: u32| {
        let position = viewer.session.position(end as usize).as_vec3();
        viewer.viewport().project(position).expect("in front")
    };
    let ends = on!(viewer.session.runner(), simulation => simulation.model().ends().to_vec());
    let crosses = |ends: [u32; 2]| {
        let [a, b] = ends.map(place);
        let share = (y - a.y) / (b.y - a.y);
        let x = a.x + share * (b.x - a.x);
        (0.0..=1.0).contains(&share) && (left..=right).contains(&x)
    };
    let expected: Vec<usize> = (0..ends.len()).filter(|&spring| crosses(ends[spring])).collect();
    assert!(10 < expected.len() && expected.len() < ends.len() / 2, "{}", expected.len());
    let camera = harness.state().camera;
    key(&mut harness, Key::C);
    assert_eq!(harness.state().hand.tool, Tool::Cut);
    let path = [0.0, 0.3, 0.35, 1.0].map(|share| pos2(egui::lerp(left..=right, share), y));
    drag(&mut harness, &path, Modifiers::NONE);
    let viewer = harness.state();
    assert_eq!(cut_springs(&viewer.session), expected);
    assert_eq!((viewer.camera, viewer.session.held()), (camera, None), "a stroke only cuts");
    // A second stroke along the same line cuts nothing.
    drag(&mut harness, &path, Modifiers::NONE);
    assert_eq!(cut_springs(&harness.state().session), expected);
    harness.state_mut().session.restart();
    assert!(cut_springs(&harness.state().session).is_empty(), "a restart mends");
}

#[test]
fn what_hangs_on_a_spring_falls_freely_once_that_is_cut() {
    let particle =
        |y: f64| Particle { position: DVec3::new(0.0, y, 0.0), velocity: DVec3::ZERO, mass: 1.0 };
    let mut pair = loaded("jelly");
    pair.scene = Scene {
        particles: vec![particle(0.0), particle(-1.0)],
        springs: vec![Spring { ends: [0, 1], rest_length: 1.0, stiffness: 1e4, damping: 0.0 }],
        pins: vec![Pin { particle: 0, velocity: DVec3::ZERO }],
        ..Scene::default()
    };
    let mut session = Session::new(pair).expect("a valid scene");
    (0..30).for_each(|_| session.step_forward());
    assert!((session.position(1).y + 1.0).abs() < 0.01, "it hangs");
    session.restart();
    session.cut(&[0]);
    assert_eq!(session.runner().spring_count(), 0);
    (0..30).for_each(|_| session.step_forward());
    // Half a second of free fall, late by at most the first-order term h g t.
    let late = session.runner().settings().substep() * 9.82 * 0.5;
    assert!((session.position(1).y + 1.0 + 0.5 * 9.82 * 0.25).abs() <= late);
}

#[test]
fn the_tool_is_chosen_in_the_panel_and_escape_grabs_again() {
    let mut harness = harness("cloth");
    for (name, tool) in [("Cut", Tool::Cut), ("Box", Tool::Select), ("Grab", Tool::Grab)] {
        harness.get_by_label(name).click();
        harness.run_steps(2);
        assert_eq!(harness.state().hand.tool, tool);
    }
    key(&mut harness, Key::C);
    key(&mut harness, Key::Escape);
    assert_eq!(harness.state().hand.tool, Tool::Grab);
}

#[test]
fn what_a_box_holds_is_grabbed_together_and_keeps_its_shape() {
    let mut harness = harness("jelly");
    let rect = harness.state().layout.rect;
    let corners = [rect.center() - Vec2::new(60.0, 45.0), rect.center() + Vec2::new(50.0, 40.0)];
    drag(&mut harness, &corners, Modifiers::COMMAND);
    let viewer = harness.state();
    let area = egui::Rect::from_two_pos(corners[0], corners[1]);
    let count = viewer.session.runner().particle_count();
    let is_inside = |&particle: &usize| {
        let at = viewer.viewport().project(viewer.session.position(particle).as_vec3());
        at.is_some_and(|at| area.contains(at))
    };
    let inside: Vec<usize> = (0..count).filter(is_inside).collect();
    let group = viewer.session.group().to_vec();
    assert_eq!(group.len(), inside.len().min(MOST_HELD));
    assert!(4 < group.len() && group.iter().all(|particle| inside.contains(particle)));
    // The nearest of them is certainly the one under the pointer.
    let depth = |particle: usize| viewer.camera.depth(viewer.session.position(particle).as_vec3());
    let first = *group.iter().min_by(|&&a, &&b| depth(a).total_cmp(&depth(b))).expect("some");
    let from = viewer.viewport().project(viewer.session.position(first).as_vec3()).expect("there");
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from + Vec2::new(80.0, -60.0));
    harness.run_steps(1);
    let session = &harness.state().session;
    assert!(group.contains(&session.held().expect("held")));
    let targets = on!(session.runner(), simulation => {
        let grabs = simulation.model().grabs().iter();
        grabs.map(|grab| (grab.particle as usize, grab.target.to_f64())).collect::<Vec<_>>()
    });
    assert_eq!(targets.len(), group.len());
    let ways: Vec<DVec3> =
        targets.iter().map(|&(particle, to)| to - session.position(particle)).collect();
    assert!(0.5 < ways[0].length());
    // Targets are rounded to single precision at some ten metres.
    assert!(ways.iter().all(|way| (*way - ways[0]).length() < 1e-4), "one way for all");
    let before = harness.state().session.runner().state();
    harness.drop_at(from + Vec2::new(80.0, -60.0));
    harness.run_steps(1);
    let session = &harness.state().session;
    assert_eq!(on!(session.runner(), simulation => simulation.model().grabs().len()), 0);
    assert_eq!(session.runner().state(), before, "what is let go keeps its velocity");
    key(&mut harness, Key::Escape);
    assert!(harness.state().session.group().is_empty());
}

/// Runs a frame of the window: input, steps, panels.
fn timed_frame(ui: &mut egui::Ui, viewer: &mut Viewer) {
    read_pointer(ui.ctx(), viewer);
    viewer.session.advance(FRAME + 1e-9, &|| 0.0);
    panel::show(ui, viewer);
}

#[test]
fn what_the_pointer_does_is_in_the_picture_of_the_same_frame() {
    let mut viewer = Viewer::new(loaded("jelly"), catalogue()).expect("a valid scene");
    viewer.session.advance(0.0, &|| 0.0);
    let mut harness =
        Harness::builder().with_size(Vec2::new(1280.0, 800.0)).build_ui_state(timed_frame, viewer);
    theme::apply(&harness.ctx);
    harness.run_steps(3);
    let viewer = harness.state();
    let depth = |particle: usize| viewer.camera.depth(viewer.session.position(particle).as_vec3());
    let near = (0..1000).min_by(|&a, &b| depth(a).total_cmp(&depth(b))).expect("particles");
    let at = viewer.viewport().project(viewer.session.position(near).as_vec3()).expect("there");
    harness.hover_at(at);
    harness.run_steps(1);
    harness.drag_at(at);
    harness.run_steps(1);
    let held = harness.state().session.held().expect("taken in the frame of the press");
    let velocity = |harness: &Harness<'_, Viewer>| {
        let runner = harness.state().session.runner();
        on!(runner, simulation => simulation.velocity(held).to_f64())
    };
    let (before, steps) = (velocity(&harness), harness.state().session.runner().steps());
    harness.hover_at(at + Vec2::new(0.0, -100.0));
    // One frame: reads the motion, takes a step with its force, and draws the result.
    harness.step();
    assert_eq!(harness.state().session.runner().steps(), steps + 1);
    // A particle of 1 kg at the largest force, 294 kN, or in oscillations of 47 Hz: tens of metres
    // per second. Without it, gravity and springs at rest: less than one.
    let change = (velocity(&harness) - before).length();
    assert!(5.0 < change, "{change} m/s");
}

#[test]
fn a_group_is_thinned_where_it_is_too_large_to_be_held() {
    let mut session = Session::new(loaded("jelly")).expect("a valid scene");
    session.select_group((0..1000).collect());
    let group = session.group();
    assert_eq!(group.len(), MOST_HELD);
    assert!(group.windows(2).all(|pair| pair[0] < pair[1]) && 990 < group[MOST_HELD - 1]);
}

#[test]
fn the_force_shown_is_the_weight_of_what_hangs_from_the_pointer() {
    let mut only = loaded("jelly");
    let particle = Particle { position: DVec3::ZERO, velocity: DVec3::ZERO, mass: 2.0 };
    only.scene = Scene { particles: vec![particle], ..Scene::default() };
    let mut session = Session::new(only).expect("a valid scene");
    assert_eq!(session.grab_force(), None);
    session.tune(SolverRow::precision(Precision::F64));
    session.grab(0, DVec3::ZERO);
    // A damping ratio of 0.7 at 1.5 Hz: in 10 s the swing decays by exp(−0.7 · 1.5 · 2π · 10).
    run(&mut session, 600);
    let force = session.grab_force().expect("it is held");
    // Gravity was rounded to single precision before the run continued in double.
    assert!((force - 2.0 * 9.82).abs() < 20.0 * 6e-8, "{force} N");
    session.pin_toggle(0);
    session.grab(0, DVec3::ZERO);
    assert_eq!(session.grab_force(), None, "no force moves a pin");
}

#[test]
fn a_steady_wind_is_a_force_on_every_particle_and_takes_no_energy_from_nowhere() {
    let mut still = loaded("jelly");
    still.scene.world.gravity = DVec3::ZERO;
    still.scene.planes.clear();
    let mut session = Session::new(still).expect("a valid scene");
    session.tune(SolverRow::precision(Precision::F64));
    let velocity = |session: &Session| {
        let sum = on!(session.runner(), simulation => {
            simulation.velocities().map(|velocity| velocity.to_f64()).sum::<DVec3>()
        });
        sum / session.runner().particle_count() as f64
    };
    let before = velocity(&session);
    session.set_wind(Wind { strength: 0.5, heading: std::f64::consts::FRAC_PI_2, gusts: 0.0 });
    session.advance(0.0, &|| 0.0);
    run(&mut session, 30);
    let gained = velocity(&session) - before;
    // m = 1 kg: v = F t / m, towards −z; the springs between particles cancel to rounding.
    assert!((gained - DVec3::new(0.0, 0.0, -0.25)).length() < 1e-9, "{gained}");
    let steps = session.runner().steps();
    session.restart();
    (0..steps).for_each(|_| session.step_forward());
    // The first start was rounded to single precision.
    let again = velocity(&session) - before;
    assert!((again - gained).length() < 1e-6, "a restart keeps the wind");
    session.set_wind(Wind::default());
    assert_eq!(force(&session), DVec3::ZERO);
}

#[test]
fn gusts_void_no_reading_that_they_leave_true() {
    let mut session = Session::new(loaded("cloth")).expect("a valid scene");
    session.set_wind(Wind { strength: 0.05, heading: 0.3, gusts: 1.0 });
    assert_eq!((session.stability(), session.energy()), (None, None));
    run(&mut session, 5);
    for _ in 0..60 {
        let before = force(&session);
        run(&mut session, 1);
        assert_ne!(force(&session), before);
        assert!(session.stability().is_some() && session.energy().is_some());
        // Gusts do work, so the energy balance does not measure the method.
        assert_eq!((session.findings(), session.energy_imbalance()), (Vec::new(), Some(0.0)));
    }
    session.edit(MaterialEdit::Gravity(3.0));
    assert_eq!(session.stability(), None);
}

/// Returns position and velocity of the only solid.
fn solid(session: &Session) -> (DVec3, DVec3) {
    on!(session.runner(), simulation => {
        let placed = Placed::new(&simulation.model().solids()[0], simulation.time());
        (placed.middle, placed.velocity)
    })
}

#[test]
fn a_ball_that_is_dragged_takes_a_cloth_along_and_stays_where_it_is_left() {
    let mut harness = harness("drape");
    // From the side, the cloth above does not hide the ball.
    harness.state_mut().camera.pitch = 0.0;
    harness.run_steps(2);
    let (start, _) = solid(&harness.state().session);
    let viewport = harness.state().viewport();
    let at = |place: DVec3| viewport.project(place.as_vec3()).expect("in front");
    let from = at(start);
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(1);
    assert_eq!(harness.state().session.held_solid(), Some(0));
    assert_eq!(harness.state().session.held(), None);
    for frame in 1..40 {
        harness.hover_at(from - Vec2::new(0.0, 3.0 * frame as f32));
        harness.run_steps(1);
        run(&mut harness.state_mut().session, 1);
    }
    let target = harness.state().session.grab_target().expect("it is held");
    assert!(0.4 < target.y - start.y, "it is pulled up: {target}");
    run(&mut harness.state_mut().session, 60);
    harness.drop_at(from - Vec2::new(0.0, 117.0));
    harness.run_steps(2);
    let session = &mut harness.state_mut().session;
    assert!(!session.is_holding());
    let (left, velocity) = solid(session);
    // A quarter of the way in each of 60 steps.
    assert!((left - target).length() < 1e-3, "{left} of {target}");
    assert_eq!(velocity, DVec3::ZERO);
    run(session, 10);
    assert_eq!(solid(session).0, left);
    let count = session.runner().particle_count();
    let gaps = (0..count).map(|particle| (session.position(particle) - left).length() - 0.8);
    assert!(-1e-3 < gaps.fold(f64::MAX, f64::min), "a particle is inside the ball");
    let highest = (0..count).map(|particle| session.position(particle).y).fold(0.0, f64::max);
    assert!(left.y + 0.79 < highest, "the cloth lies on the ball: {highest}");
}
