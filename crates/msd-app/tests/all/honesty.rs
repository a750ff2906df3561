//! Validity of the session's values: no reading outlives a change of its source, and each recovery
//! option leads to a run that does not diverge.

use crate::frames::{FRAME, loaded, run};
use msd_app::session::{ErrorNow, MaterialEdit, Session, Wind};
use msd_core::glam::DVec3;
use msd_core::{Friction, Integrator, Material, Real, Scene, Settings, Vector, shape};
use msd_run::rescue::{Offer, Origin, Remedy};
use msd_run::{Finding, on};
use msd_scene::schema::SolverRow;
use msd_scene::{Loaded, Precision};
use msd_study::choice::{Choice, Fineness};

/// Fails if a reading from before a change is still shown.
fn check(session: &Session, what: &str) {
    check_readings(session, what);
    // The change of energy restarts at zero.
    assert!(matches!(session.energy_imbalance(), None | Some(0.0)), "{what}");
    assert!(matches!(session.energy_of_contact(), None | Some(0.0)), "{what}");
    let is_of_now = |found: &Finding| found.since == session.runner().time();
    assert!(session.findings().iter().all(is_of_now) && session.pace().is_none(), "{what}");
}

fn check_readings(session: &Session, what: &str) {
    let runner = session.runner();
    if let Some((share, _)) = session.stability() {
        let stable = match Integrator::EXPLICIT.contains(&runner.integrator()) {
            true => runner.stable_substep(),
            false => f64::INFINITY,
        };
        assert_eq!(share, runner.settings().substep() / stable, "{what}");
    }
    if let Some(energy) = session.energy() {
        assert_eq!(energy, runner.energy(), "{what}");
    }
    assert!(!matches!(session.error(), Some(ErrorNow::Known(_))), "{what}");
    let stiffness = on!(runner, simulation => simulation.model().stiffness(0).to_f64());
    let shown = session.material().values();
    assert_eq!(shown.stiffness.map(|value| value.first), Some(stiffness), "{what}");
    let gravity = on!(runner, simulation => simulation.model().gravity().to_f64().length());
    assert_eq!(shown.gravity, gravity, "{what}");
}

type Change = fn(&mut Session);

const RK4: Choice = Choice {
    integrator: Integrator::Rk4,
    fineness: Fineness::Substeps(4),
    precision: Precision::F32,
};

/// Every change of a run by a user.
const CHANGES: &[(&str, Change)] = &[
    ("method", |session| session.tune(SolverRow::integrator(Integrator::ExplicitEuler))),
    ("implicit", |session| session.tune(SolverRow::integrator(Integrator::BackwardEuler))),
    ("adaptive", |session| session.tune(SolverRow::integrator(Integrator::DormandPrince))),
    ("substeps", |session| session.tune(SolverRow::substeps(9))),
    ("tolerance", |session| session.tune(SolverRow::tolerance(1e-3))),
    ("newton", |session| session.tune(SolverRow::newton(3))),
    ("precision", |session| session.tune(SolverRow::precision(Precision::F32))),
    ("a choice of the trade", |session| session.adopt(RK4)),
    ("mass", |session| session.edit(MaterialEdit::Mass(0.3))),
    ("stiffness", |session| session.edit(MaterialEdit::Stiffness(3e5))),
    ("damping", |session| session.edit(MaterialEdit::Damping(30.0))),
    ("rest length", |session| session.edit(MaterialEdit::RestScale(1.5))),
    ("gravity", |session| session.edit(MaterialEdit::Gravity(1.6))),
    ("restitution", |session| session.edit(MaterialEdit::Restitution(0.5))),
    ("friction", |session| session.edit(MaterialEdit::Friction(Friction::Coulomb(0.4)))),
    ("freeze", Session::freeze),
    ("pin", |session| session.pin_toggle(3)),
    ("unpin", |session| session.pin_toggle(1)),
    ("grab", |session| session.grab(3, session.position(3) + DVec3::Y)),
    ("grab of a group", |session| {
        session.select_group(vec![3, 4, 5]);
        session.grab(4, session.position(4) + DVec3::Y);
    }),
    ("cut", |session| session.cut(&[5, 6, 7])),
    ("wind", |session| session.set_wind(Wind { strength: 3.0, heading: 0.0, gusts: 0.0 })),
    ("gusts", |session| session.set_wind(Wind { strength: 3.0, heading: 0.0, gusts: 0.5 })),
    ("step back", |session| assert!(session.step_back())),
    ("automatic substeps", |session| session.tune(SolverRow::automatic())),
    ("cut", |session| session.cut(&[5, 9])),
    ("undo", Session::undo),
    ("undo and redo", |session| {
        session.undo();
        session.redo();
    }),
    ("look back", |session| session.look_back(7)),
    ("restart", Session::restart),
    ("the values of the scene", Session::reset_material),
    ("another scene", |session| session.open(loaded("cloth")).expect("a valid scene")),
];

#[test]
fn no_shown_number_outlives_what_it_was_computed_from() {
    for &(what, change) in CHANGES {
        let mut session = Session::new(loaded("jelly")).expect("a valid scene");
        session.tune(SolverRow::precision(Precision::F64));
        session.edit(MaterialEdit::Stiffness(1500.0));
        session.pin_toggle(1);
        session.set_estimating(true);
        session.advance(0.0, &|| 0.0);
        run(&mut session, 125);
        let is_all_shown = session.stability().is_some()
            && session.energy().is_some()
            && session.pace().is_some()
            && matches!(session.error(), Some(ErrorNow::Known(_)));
        assert!(is_all_shown, "before: {what}");
        change(&mut session);
        check(&session, what);
        if !session.is_paused() {
            session.toggle_pause();
        }
        // A paused window computes it in the next frame, on a machine where that is cheap.
        assert!(session.is_working() || session.stability().is_some());
        session.advance(0.0, &|| 0.0);
        check(&session, what);
        assert!(session.stability().is_some() && session.energy().is_some(), "after: {what}");
    }
}

/// Returns the root mean square distance of the particles of a session and its twin, metres.
fn distance(session: &Session) -> f64 {
    let twin = session.twin().expect("it is on").positions();
    let squared = |(particle, position): (usize, &[f32; 3])| {
        let there = DVec3::from_array(position.map(f64::from));
        (session.position(particle) - there).length_squared()
    };
    let sum: f64 = twin.iter().enumerate().map(squared).sum();
    (sum / twin.len() as f64).sqrt()
}

#[test]
fn the_distance_of_a_twin_is_that_of_the_states_that_are_shown() {
    let others = CHANGES.iter().filter(|change| change.0 != "another scene");
    for (what, change) in others {
        let mut session = Session::new(loaded("jelly")).expect("a valid scene");
        let settings = session.runner().settings();
        let rough = Settings { integrator: Integrator::SymplecticEuler, ..settings };
        session.edit(MaterialEdit::Stiffness(1500.0));
        session.set_twin(Some(rough));
        session.pin_toggle(1);
        run(&mut session, 40);
        for _ in 0..2 {
            let shown = session.twin().expect("it is on").apart();
            // Positions of the twin are read in single precision: 1e-7 of some ten metres.
            assert!((shown.rms - distance(&session)).abs() < 1e-5, "{what}");
            assert_eq!(shown.time, session.runner().time(), "{what}");
            change(&mut session);
        }
    }
    let mut session = Session::new(loaded("jelly")).expect("a valid scene");
    session.set_twin(Some(session.runner().settings()));
    session.open(loaded("cloth")).expect("a valid scene");
    assert!(session.twin().is_none());
}

#[test]
fn what_goes_on_by_itself_voids_nothing() {
    let mut session = Session::new(loaded("jelly")).expect("a valid scene");
    session.grab(3, session.position(3));
    run(&mut session, 10);
    let is_shown = |session: &Session| session.stability().is_some() && session.energy().is_some();
    for _ in 0..5 {
        session.move_grab(session.position(3) + DVec3::Y);
        assert!(is_shown(&session) && session.pace().is_some());
        run(&mut session, 1);
        assert!(is_shown(&session));
    }
    session.release();
    assert!(!is_shown(&session));
}

/// Returns a block of 64 particles over a floor.
fn block() -> Loaded {
    let mut loaded = loaded("jelly");
    let material = Material { mass: 1.0, stiffness: 2200.0, damping: 0.1 };
    let part = shape::block([4, 4, 4], 1.0, material).expect("small");
    let planes = std::mem::take(&mut loaded.scene.planes);
    loaded.scene = Scene { planes, ..Scene::of("block", part) };
    loaded
}

/// Steps, paused, until the run stops by itself; returns whether it did.
fn blows_up(session: &mut Session, steps: usize) -> bool {
    (0..steps).any(|_| {
        session.step_forward();
        session.failure().is_some()
    })
}

/// Returns a run with a method and one substep, with an extreme value set after half a second.
fn extreme(method: Integrator, edit: MaterialEdit) -> Session {
    let mut session = Session::new(block()).expect("a valid scene");
    session.tune(SolverRow::integrator(method));
    session.tune(SolverRow::substeps(1));
    if !blows_up(&mut session, 30) {
        session.edit(edit);
    }
    session
}

#[test]
fn every_way_out_leads_to_a_run_that_stays_up() {
    use MaterialEdit::{Damping, Mass, Stiffness};
    let edits =
        [Mass(0.01), Mass(100.0), Stiffness(0.0), Stiffness(1e6), Damping(0.0), Damping(1e3)];
    let mut kinds = [0; 4];
    for method in Integrator::ALL {
        for edit in edits {
            let mut session = extreme(method, edit);
            if session.failure().is_none() && !blows_up(&mut session, 300) {
                continue;
            }
            session.advance(0.0, &|| 0.0);
            let offers = session.offers().to_vec();
            assert!(!session.is_searching() && !offers.is_empty(), "{method}, {edit:?}");
            for offer in offers {
                let what = format!("{method}, {edit:?}: {offer:?}");
                assert!(offer.is_tried, "{what}");
                let mut again = extreme(method, edit);
                assert!(again.failure().is_some() || blows_up(&mut again, 300), "{what}");
                again.take(offer);
                assert!(again.failure().is_none() && !again.is_paused(), "{what}");
                assert!(!blows_up(&mut again, 120), "{what}");
                kinds[match offer.remedy {
                    Remedy::Back => 0,
                    Remedy::Substeps(_) | Remedy::Tolerance(_) => 1,
                    Remedy::Method(..) => 2,
                    Remedy::SceneValues => 3,
                }] += 1;
            }
        }
    }
    // The default of eight substeps is enough; with one, many of the 48 runs diverge.
    assert!(10 <= kinds[1] && 20 <= kinds[2] && 20 <= kinds[3], "{kinds:?}");
}

/// Returns jelly that has just been made far too stiff for one substep.
fn blown_up() -> Session {
    let mut session = Session::new(loaded("jelly")).expect("a valid scene");
    session.tune(SolverRow::substeps(1));
    session.edit(MaterialEdit::Stiffness(1e5));
    assert!(blows_up(&mut session, 600));
    session
}

fn substeps(session: &Session) -> Offer {
    let is_it = |offer: &&Offer| matches!(offer.remedy, Remedy::Substeps(_));
    *session.offers().iter().find(is_it).expect("a number of substeps")
}

#[test]
fn a_run_that_blew_up_rests_at_a_state_that_holds_together() {
    let mut session = blown_up();
    let longest = on!(session.runner(), simulation => {
        let springs = 0..simulation.model().spring_count();
        springs.map(|spring| simulation.length(spring)).fold(0.0, f64::max)
    });
    // The longest at the start are the diagonals of its cubes.
    assert!(longest < 3.0 * 3f64.sqrt(), "{longest} m");
    let text = &session.failure().expect("it blew up").text;
    assert!(text.contains("left the world") && text.contains("last valid state"), "{text}");
    assert!(session.is_paused() && session.stability().is_none());
    session.advance(0.0, &|| 0.0);
    check_readings(&session, "after a failure");
    // The energy added by the method up to then is still included.
    assert!(session.energy_imbalance().is_some_and(|added| 0.0 < added));
    assert!(1.0 < session.stability().expect("worked out").0);
    // The highlighted springs belong to the scene, and are some of many.
    let marked = session.fastest_springs();
    assert!((1..100).contains(&marked.len()), "{}", marked.len());
    assert!(marked.iter().all(|&spring| spring < session.runner().spring_count()));
    session.take(substeps(&session));
    assert!(session.offers().is_empty() && session.fastest_springs().is_empty());
}

#[test]
fn what_is_offered_follows_the_sliders() {
    let mut session = blown_up();
    session.advance(0.0, &|| 0.0);
    let before = substeps(&session);
    session.edit(MaterialEdit::Stiffness(1e6));
    assert!(session.offers().is_empty() && session.is_searching());
    session.advance(0.0, &|| 0.0);
    let (Remedy::Substeps(few), Remedy::Substeps(many)) =
        (before.remedy, substeps(&session).remedy)
    else {
        panic!("substeps are offered");
    };
    assert!(few < many, "{few} {many}");
}

#[test]
fn a_second_of_history_helps_where_a_hand_was_to_blame() {
    let mut small = block();
    small.scene.world.extent = 15.0;
    let mut session = Session::new(small).expect("a valid scene");
    (0..120).for_each(|_| session.step_forward());
    // Pulled by its middle particle, from the floor at -5 m, at 4 m/s, out of the world.
    let start = session.position(21);
    session.grab(21, start);
    let is_lost = (1..600).any(|step| {
        session.move_grab(start + DVec3::Y * 4.0 * f64::from(step) * FRAME);
        blows_up(&mut session, 1)
    });
    assert!(is_lost);
    session.advance(0.0, &|| 0.0);
    let back = session.offers().iter().find(|offer| offer.origin == Origin::Earlier).copied();
    let steps = session.runner().steps();
    session.take(back.expect("let go a second earlier, it falls down again"));
    assert_eq!(session.runner().steps() + 60, steps);
    assert!(!blows_up(&mut session, 120));
}
