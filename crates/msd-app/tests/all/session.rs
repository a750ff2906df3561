//! The session alone: all actions of a user, without a window.

use crate::frames::{FRAME, loaded, run, session};
use msd_app::session::{ErrorNow, MaterialEdit, Session};
use msd_core::glam::DVec3;
use msd_core::{Friction, Integrator, Real, Select, Vector};
use msd_run::on;
use msd_scene::schema::SolverRow;
use msd_scene::{AnyState, Precision};

/// Steps until there is an estimate of the error.
const WINDOW: usize = msd_app::session::ERROR_WINDOW as usize;

fn stiffness(session: &Session, spring: usize) -> f64 {
    on!(session.runner(), simulation => simulation.model().stiffness(spring).to_f64())
}

#[test]
fn real_time_takes_a_step_per_sixtieth() {
    let mut session = session("jelly");
    run(&mut session, 30);
    assert_eq!(session.runner().steps(), 30);
    let pace = session.pace().expect("frames were measured");
    assert!((pace.real_time_factor - 1.0).abs() < 1e-3);
}

#[test]
fn pausing_stops_time_and_going_on_owes_nothing() {
    let mut session = session("jelly");
    run(&mut session, 5);
    session.toggle_pause();
    run(&mut session, 100);
    assert_eq!(session.runner().steps(), 5);
    session.toggle_pause();
    session.advance(10.0, &|| 0.0);
    run(&mut session, 2);
    assert_eq!(session.runner().steps(), 7);
}

#[test]
fn slow_motion_takes_the_same_steps_less_often() {
    let (mut fast, mut slow) = (session("chain"), session("chain"));
    slow.set_speed(0.25);
    slow.advance(0.0, &|| 0.0);
    run(&mut fast, 10);
    run(&mut slow, 40);
    assert_eq!(fast.runner().settings(), slow.runner().settings());
    assert_eq!(fast.runner().state(), slow.runner().state());
}

#[test]
fn a_step_back_returns_to_the_very_state() {
    let mut session = session("jelly");
    run(&mut session, 40);
    let (state, energy) = (session.runner().state(), session.runner().energy());
    session.step_forward();
    session.step_forward();
    assert_ne!(session.runner().state(), state);
    assert!(session.step_back() && session.step_back());
    assert_eq!(session.runner().state(), state);
    assert_eq!(session.runner().steps(), 40);
    // The terms of the sum have another order: one rounding.
    assert!(
        (session.runner().energy().dissipated - energy.dissipated).abs()
            <= 1e-9 * energy.total().abs()
    );
    assert!(session.is_paused());
}

#[test]
fn a_step_back_past_an_edit_knows_what_was_dissipated_before_it() {
    let mut session = session("mattress");
    let touches = |session: &Session| 0 < session.runner().contacts().count;
    for _ in 0..600 {
        if !touches(&session) {
            run(&mut session, 1);
        }
    }
    assert!(touches(&session), "it touches the floor");
    let before = session.runner().energy();
    session.edit(MaterialEdit::Gravity(1.6));
    run(&mut session, 10);
    (0..10).for_each(|_| assert!(session.step_back()));
    // On the moon, the same state has less energy, without dissipation.
    let after = session.runner().energy();
    assert!(after.gravitational < 0.5 * before.gravitational, "{after:?}");
    assert!((after.dissipated - before.dissipated).abs() <= 1e-9 * before.total().abs());
}

#[test]
fn the_first_state_is_the_end_of_stepping_back() {
    let mut session = session("chain");
    session.step_forward();
    assert!(session.step_back());
    assert!(!session.step_back());
    assert_eq!(session.runner().time(), 0.0);
}

#[test]
fn a_restart_keeps_what_was_set_and_forgets_what_was_done() {
    let mut session = session("jelly");
    let start = session.runner().state();
    session.edit(MaterialEdit::Stiffness(1234.0));
    session.tune(SolverRow::substeps(11));
    session.tune(SolverRow::integrator(Integrator::Rk4));
    run(&mut session, 10);
    session.freeze();
    session.pin_toggle(3);
    session.restart();
    assert_eq!(session.runner().state(), start);
    assert_eq!(stiffness(&session, 0), 1234.0);
    assert_eq!(session.runner().settings().substeps, 11);
    assert_eq!(session.runner().integrator(), Integrator::Rk4);
    assert!(!session.is_pinned(3));
    assert_eq!(session.steps_back(), 0);
    session.reset_material();
    assert_eq!(stiffness(&session, 0), 2200.0);
}

#[test]
fn a_step_that_would_take_minutes_ends_in_a_failure_that_is_told() {
    let mut session = session("jelly");
    session.tune(SolverRow::precision(Precision::F64));
    session.tune(SolverRow::integrator(Integrator::DormandPrince));
    session.tune(SolverRow::tolerance(1e-10));
    session.edit(MaterialEdit::Stiffness(1e14));
    session.set_twin(Some(session.runner().settings()));
    let before = session.runner().state();
    run(&mut session, 3);
    let work = on!(session.runner(), simulation => simulation.work()).expect("it is adaptive");
    let text = &session.failure().expect("it gave up").text;
    assert!(text.contains("evaluations of the forces"), "{text}");
    assert!(session.is_paused() && session.runner().state() == before);
    // A fifth of the limit on the work of a step, which also holds for small scenes.
    assert!(work.evaluations < 150_000, "{}", work.evaluations);
}

#[test]
fn sliders_act_on_one_body_or_all() {
    let mut two = loaded("jelly");
    let part = msd_core::shape::rope(4, 1.0, msd_core::Material::default()).expect("a valid rope");
    two.scene.add("rope", part);
    let mut session = Session::new(two).expect("a valid scene");
    let last = session.runner().spring_count() - 1;
    session.select(Select::Body(1));
    session.edit(MaterialEdit::Stiffness(50.0));
    assert_eq!((stiffness(&session, 0), stiffness(&session, last)), (2200.0, 50.0));
    session.select(Select::All);
    assert!(session.material().values().stiffness.is_some_and(|value| value.mixed));
    session.edit(MaterialEdit::Stiffness(70.0));
    assert_eq!((stiffness(&session, 0), stiffness(&session, last)), (70.0, 70.0));
    assert_eq!(
        session.material().values().stiffness.map(|value| (value.first, value.mixed)),
        Some((70.0, false))
    );
}

#[test]
fn the_world_is_set_as_a_whole() {
    let mut session = session("jelly");
    session.edit(MaterialEdit::Gravity(3.0));
    session.edit(MaterialEdit::Restitution(0.25));
    session.edit(MaterialEdit::Friction(Friction::Coulomb(0.7)));
    let (gravity, planes) = on!(session.runner(), simulation => {
        let model = simulation.model();
        let law = |plane: usize| {
            (model.planes()[plane].restitution(), model.planes()[plane].friction())
        };
        (model.gravity().to_f64(), [law(0), law(1)])
    });
    assert!((gravity - DVec3::new(0.0, -3.0, 0.0)).length() < 1e-6);
    assert_eq!(planes, [(0.25, Friction::Coulomb(0.7)); 2]);
    // With zero gravity, its direction is kept.
    session.edit(MaterialEdit::Gravity(0.0));
    session.edit(MaterialEdit::Gravity(5.0));
    assert_eq!(session.material().values().gravity, 5.0);
}

#[test]
fn precision_changes_and_the_state_stays() {
    let mut session = session("jelly");
    run(&mut session, 20);
    let AnyState::F32(before) = session.runner().state() else { panic!("jelly runs in f32") };
    session.tune(SolverRow::precision(Precision::F64));
    let AnyState::F64(after) = session.runner().state() else { panic!("f64 was asked for") };
    assert_eq!(before.positions[7].as_dvec3(), after.positions[7]);
    assert_eq!(session.runner().steps(), 20);
    // The earlier history is still valid.
    assert!(session.step_back());
}

#[test]
fn a_refused_number_is_reported_and_changes_nothing() {
    let mut session = session("jelly");
    session.edit(MaterialEdit::Mass(-1.0));
    assert!(session.refusal().is_some_and(|text| text.contains("mass")));
    assert_eq!(session.material().values().mass.map(|value| value.first), Some(1.0));
    session.edit(MaterialEdit::Mass(2.0));
    assert_eq!(session.refusal(), None);
}

#[test]
fn the_stability_light_follows_the_settings() {
    let mut session = session("jelly");
    let share = |session: &Session| session.stability().map(|(share, _)| share);
    let before = share(&session).expect("predicted in the first frame");
    session.tune(SolverRow::substeps(session.runner().settings().substeps * 2));
    session.advance(FRAME, &|| 0.0);
    let after = share(&session).expect("predicted");
    assert!((after / before - 0.5).abs() < 0.05, "{before} {after}");
}

#[test]
fn a_grab_lifts_a_whole_body_and_throws_it() {
    for name in ["jelly", "cloth", "chain", "mattress", "teapot", "foam", "bunny"] {
        let mut session = session(name);
        run(&mut session, 60);
        let particle = session.runner().particle_count() / 2;
        let start = session.position(particle);
        let size = on!(session.runner(), simulation => {
            let columns = || simulation.positions().map(|position| position.to_f64());
            let high = columns().fold(DVec3::NEG_INFINITY, DVec3::max);
            (high - columns().fold(DVec3::INFINITY, DVec3::min)).length()
        });
        session.grab(particle, start);
        // One and a half sizes sideways and up, within a second.
        let way = DVec3::new(1.0, 1.0, 0.0).normalize() * 1.5 * size;
        let rest =
            on!(session.runner(), simulation => simulation.model().inverse_masses().contains(&0.0));
        for frame in 1..=60 {
            session.move_grab(start + way * (f64::from(frame) / 60.0));
            run(&mut session, 1);
        }
        run(&mut session, 90);
        assert!(session.failure().is_none(), "{name} blew up while held");
        if !rest {
            let left = (session.position(particle) - (start + way)).length();
            assert!(
                left < 0.4 * size,
                "{name}: the particle is {left} m from the mouse, of a size of {size} m"
            );
        }
        session.release();
        run(&mut session, 60);
        assert!(session.failure().is_none(), "{name} blew up after it was thrown");
    }
}

#[test]
fn a_pinned_particle_follows_the_mouse_and_stays_where_it_is_left() {
    let mut session = session("cloth");
    let pin = (0..session.runner().particle_count())
        .find(|&particle| session.is_pinned(particle))
        .expect("the cloth hangs from pins");
    let target = session.position(pin) + DVec3::new(0.0, 2.0, 1.0);
    session.grab(pin, session.position(pin));
    session.move_grab(target);
    run(&mut session, 60);
    // Three quarters of the way are left after each step: 0.75^60 of it in the end.
    assert!((session.position(pin) - target).length() < 1e-4);
    session.release();
    run(&mut session, 30);
    assert!((session.position(pin) - target).length() < 1e-4);
}

#[test]
fn a_particle_pinned_while_held_stays_there() {
    let mut session = session("jelly");
    session.grab(5, session.position(5));
    run(&mut session, 10);
    session.pin_toggle(5);
    let there = session.position(5);
    run(&mut session, 60);
    assert_eq!(session.position(5), there);
    assert_eq!(session.held(), None);
    session.pin_toggle(5);
    run(&mut session, 5);
    assert_ne!(session.position(5), there);
}

#[test]
fn freezing_leaves_no_elastic_energy() {
    let mut session = session("jelly");
    run(&mut session, 120);
    assert!(1.0 < session.runner().energy().elastic);
    session.toggle_pause();
    session.freeze();
    // Lengths are rounded to single precision: a relative 1e-7 of some metres, squared.
    assert!(session.runner().energy().elastic < 1e-3);
}

#[test]
fn every_method_runs() {
    for integrator in Integrator::ALL {
        let mut session = session("square");
        session.tune(SolverRow::integrator(integrator));
        run(&mut session, 30);
        assert_eq!(session.failure(), None, "{integrator}");
        assert_eq!(session.runner().steps(), 30, "{integrator}");
        // It has been in free fall, 9.82/2 · 0.5² m from 2 m: within the first-order term h g t.
        let height = session.runner().energy().gravitational / (16.0 * 9.82);
        let late = 9.82 * session.runner().settings().substep() * 0.5;
        assert!((height - (2.0 - 1.2275)).abs() <= late, "{integrator}: {height} m");
    }
}

#[test]
fn tolerance_and_newton_iterations_are_set_and_kept() {
    let mut session = session("chain");
    session.tune(SolverRow::tolerance(1e-7));
    session.tune(SolverRow::newton(3));
    session.restart();
    let settings = session.runner().settings();
    assert_eq!((settings.tolerance, settings.newton), (1e-7, 3));
    session.tune(SolverRow::tolerance(0.0));
    assert!(session.refusal().is_some_and(|text| text.contains("tolerance")));
    assert_eq!(session.runner().settings(), settings);
}

#[test]
fn only_explicit_methods_have_a_limit() {
    let mut session = session("chain");
    for integrator in Integrator::ALL {
        session.tune(SolverRow::integrator(integrator));
        session.advance(FRAME, &|| 0.0);
        let limited = Integrator::EXPLICIT.contains(&integrator);
        assert_eq!(
            session.stability().is_some_and(|(share, _)| 0.0 < share),
            limited,
            "{integrator}"
        );
    }
}

/// Returns the last estimate of the error: root mean square, metres.
fn estimate(session: &Session) -> Option<f64> {
    match session.error()? {
        ErrorNow::Known(last) => Some(last.error.rms),
        ErrorNow::Measuring | ErrorNow::Lost => None,
    }
}

/// Returns a session in double precision with an error estimate.
fn measured(name: &str) -> Session {
    let mut session = session(name);
    session.tune(SolverRow::precision(Precision::F64));
    session.set_estimating(true);
    session
}

#[test]
fn the_estimate_appears_after_a_window_and_shrinks_with_the_substep() {
    let error = |substeps: u32| {
        let mut session = measured("chain");
        session.tune(SolverRow::substeps(substeps));
        run(&mut session, WINDOW - 1);
        assert_eq!(estimate(&session), None);
        run(&mut session, 1);
        estimate(&session).expect("a window has passed")
    };
    let (coarse, fine) = (error(16), error(64));
    // Velocity Verlet is of second order, and the chain has no contacts: the ratio is sixteen if
    // the substep is short enough for the leading term.
    assert!((coarse / fine / 16.0 - 1.0).abs() < 0.1, "{coarse} m, {fine} m");
}

#[test]
fn the_estimate_appears_for_every_method() {
    for integrator in Integrator::ALL {
        let mut session = measured("chain");
        session.tune(SolverRow::integrator(integrator));
        run(&mut session, WINDOW);
        let error = estimate(&session).expect("a window has passed");
        // The chain is so calm that an adaptive run and its copy both take whole steps.
        let seen = 0.0 < error || integrator.is_adaptive();
        assert!(seen && error < 0.3, "{integrator}: {error} m");
    }
}

#[test]
fn whatever_replaces_the_state_or_the_settings_restarts_the_estimate() {
    type Change = fn(&mut Session);
    let changes: [(&str, Change); 7] = [
        ("step back", |session| assert!(session.step_back())),
        ("restart", Session::restart),
        ("substeps", |session| session.tune(SolverRow::substeps(9))),
        ("method", |session| session.tune(SolverRow::integrator(Integrator::Rk4))),
        ("precision", |session| session.tune(SolverRow::precision(Precision::F32))),
        ("off and on", |session| {
            session.set_estimating(false);
            session.set_estimating(true);
        }),
        ("load", |session| session.open(loaded("cloth")).expect("a valid scene")),
    ];
    for (name, change) in changes {
        let mut session = measured("chain");
        // Into the second window.
        run(&mut session, 125);
        assert!(estimate(&session).is_some(), "{name}");
        change(&mut session);
        assert_eq!(session.error(), Some(ErrorNow::Measuring), "{name}");
        (1..WINDOW).for_each(|_| session.step_forward());
        assert_eq!(session.error(), Some(ErrorNow::Measuring), "{name}");
        session.step_forward();
        let Some(ErrorNow::Known(last)) = session.error() else { panic!("{name}") };
        assert_eq!(last.error.at, session.runner().time(), "{name}");
    }
}

#[test]
fn a_divergence_restarts_the_estimate() {
    let mut session = measured("jelly");
    session.tune(SolverRow::substeps(1));
    run(&mut session, 1);
    session.edit(MaterialEdit::Stiffness(1e6));
    run(&mut session, 600);
    assert!(session.failure().is_some());
    assert_eq!(session.error(), Some(ErrorNow::Measuring));
}

#[test]
fn estimating_changes_no_bit_of_the_run_and_off_copies_nothing() {
    let (mut plain, mut watched) = (session("jelly"), session("jelly"));
    watched.set_estimating(true);
    for session in [&mut plain, &mut watched] {
        run(session, 5);
        let there = session.position(7);
        session.grab(7, there);
        for _ in 0..20 {
            session.move_grab(there + DVec3::Y);
            run(session, 1);
        }
        session.release();
        session.edit(MaterialEdit::RestScale(1.1));
        run(session, 40);
    }
    assert!(plain.error().is_none() && estimate(&watched).is_some());
    assert_eq!(plain.runner().state(), watched.runner().state());
    assert_eq!(plain.runner().energy(), watched.runner().energy());
    watched.set_estimating(false);
    assert!(watched.error().is_none());
}

#[test]
fn what_the_user_does_is_no_error() {
    let mut session = measured("chain");
    session.tune(SolverRow::substeps(40));
    session.pin_toggle(2);
    session.edit(MaterialEdit::RestScale(1.2));
    let start = session.position(0);
    session.grab(0, start);
    for frame in 0..WINDOW {
        session.move_grab(start + DVec3::Y * (frame as f64 / WINDOW as f64));
        run(&mut session, 1);
    }
    assert!(0.3 < session.position(0).y);
    // A copy without any of these inputs would be decimetres off.
    let error = estimate(&session).expect("a window has passed");
    assert!(error < 1e-3, "{error} m");
}

#[test]
fn the_worst_particle_is_named() {
    let mut session = measured("chain");
    run(&mut session, WINDOW);
    let Some(ErrorNow::Known(last)) = session.error() else { panic!("a window has passed") };
    let (particle, error) = last.worst;
    assert_eq!(last.error.particles[particle], error);
    assert!(last.error.particles.iter().all(|&other| other <= error));
    assert!((last.error.over - 0.5).abs() < 1e-12 && last.error.rms <= error);
}

#[test]
fn automatic_substeps_follow_the_sliders_and_a_restart() {
    let mut session = session("cube");
    let substeps = |session: &Session| session.runner().settings().substeps;
    session.tune(SolverRow::automatic());
    let few = substeps(&session);
    assert!(few < 12, "{few}: the scene asks for more than it needs");
    session.edit(MaterialEdit::Stiffness(6e5));
    // A hundred times as stiff: ten times as many substeps, up to rounding to whole ones.
    let many = substeps(&session);
    assert!((10 * (few - 1)..=10 * few).contains(&many), "{few}, {many}");
    run(&mut session, 3);
    session.restart();
    assert_eq!((substeps(&session), session.runner().is_automatic()), (many, true));
    session.tune(SolverRow::substeps(7));
    session.edit(MaterialEdit::Stiffness(7e5));
    assert_eq!((substeps(&session), session.runner().is_automatic()), (7, false));
    session.restart();
    assert_eq!((substeps(&session), session.runner().is_automatic()), (7, false));
}

/// Runs foam against a sticky wall until its automatic substeps are renewed.
fn renewed(session: &mut Session) {
    session.tune(SolverRow::automatic());
    let before = session.runner().settings().substeps;
    let is_renewed = (0..800).any(|_| {
        run(session, 1);
        session.runner().settings().substeps != before
    });
    assert!(is_renewed, "its limit falls as it is squashed");
}

#[test]
fn a_renewal_voids_what_depends_on_the_substeps_and_keeps_the_energy() {
    let mut session = session("foam");
    session.set_estimating(true);
    renewed(&mut session);
    assert!(session.energy().is_some(), "a state has the energy that it has");
    assert!(!matches!(session.error(), Some(ErrorNow::Known(_))));
    let (share, _) = session.stability().expect("predicted in the same frame");
    let limit = session.runner().stable_substep();
    assert!((share - session.runner().settings().substep() / limit).abs() < 0.02, "{share}");
}

#[test]
fn rest_lengths_that_were_frozen_are_those_that_the_slider_counts_from() {
    let mut session = session("chain");
    let shown = |session: &Session| session.material().values().rest_scale.map(|scale| scale.first);
    session.edit(MaterialEdit::RestScale(1.25));
    assert_eq!(shown(&session), Some(1.25));
    session.freeze();
    assert_eq!(shown(&session), Some(1.0));
    session.undo();
    assert_eq!(shown(&session), Some(1.25));
}
