//! A session whose steps a graphics device takes: the same states, and no frame that waits.
//!
//! Without a graphics adapter each test prints that it skips, unless `MSD_REQUIRE_ADAPTER` is set.

use crate::frames::{FRAME, session};
use msd_app::session::Session;
use msd_core::glam::DVec3;
use msd_gpu::{Device, Verdict, probe};
use msd_run::recording::load_recording;
use msd_scene::Precision;
use msd_scene::schema::SolverRow;

fn device() -> Option<Device> {
    match pollster::block_on(Device::open("")) {
        Ok(device) => match pollster::block_on(probe(&device)) {
            Ok(Verdict::SameBits(manner)) => Some(device.with_manner(manner)),
            other => panic!("{}: {other:?}", device.name()),
        },
        Err(error) => {
            assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
            println!("SKIPPED: {error}");
            None
        }
    }
}

/// A session with fixed substeps, on a device.
fn on_device(name: &str, device: &Device) -> Session {
    let mut session = session(name);
    session.tune(SolverRow::substeps(10));
    session.set_device(Some(device.clone()));
    assert!(session.device().is_some(), "{:?}", session.refusal());
    session
}

/// Draws frames until so many steps are taken.
fn run_to(session: &mut Session, steps: u64) {
    for _ in 0..100_000 {
        if steps <= session.runner().steps() {
            return;
        }
        session.advance(FRAME + 1e-9, &|| 0.0);
        std::thread::yield_now();
    }
    panic!("the device does not get on: {} steps", session.runner().steps());
}

/// The state after so many steps, while the user drags a particle, lets it go and changes a method.
fn played(mut session: Session) -> Session {
    run_to(&mut session, 5);
    session.grab(40, DVec3::new(0.0, 1.0, 0.5));
    for step in 6..12 {
        session.move_grab(DVec3::new(0.0, 1.0, 0.1 * step as f64));
        run_to(&mut session, step);
    }
    session.release();
    run_to(&mut session, 15);
    session.tune(SolverRow::integrator(msd_core::Integrator::VelocityVerlet));
    run_to(&mut session, 20);
    session.step_back();
    session.step_back();
    session.toggle_pause();
    run_to(&mut session, 25);
    session
}

#[test]
fn what_a_user_does_has_the_same_bits_on_a_device() {
    let Some(device) = device() else { return };
    let mut alone = session("cloth");
    alone.tune(SolverRow::substeps(10));
    let (here, there) = (played(alone), played(on_device("cloth", &device)));
    let tally = there.device().expect("it goes on").tally();
    assert!(15 < tally.device && 0 < tally.checked, "{tally:?}");
    assert_eq!(here.runner().steps(), there.runner().steps());
    assert_eq!(here.runner().state(), there.runner().state());
}

#[test]
fn a_device_takes_neither_automatic_substeps_nor_f64_and_says_so() {
    let Some(device) = device() else { return };
    let mut session = session("cloth");
    session.tune(SolverRow::automatic());
    session.set_device(Some(device.clone()));
    assert!(session.device().is_none());
    assert!(session.refusal().expect("a reason").contains("automatic substeps"));
    let mut session = on_device("cloth", &device);
    session.tune(SolverRow::precision(Precision::F64));
    run_to(&mut session, 3);
    assert!(session.device().is_none());
    let refusal = session.refusal().expect("a reason");
    assert!(refusal.contains("f64") && refusal.contains("continues on the processor"), "{refusal}");
}

#[test]
fn a_session_goes_on_when_its_device_is_lost() {
    let Some(device) = device() else { return };
    let mut session = on_device("jelly", &device);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("jelly.msdrec");
    session.start_recording(&file);
    run_to(&mut session, 3);
    device.lose();
    run_to(&mut session, 10);
    assert!(session.device().is_none());
    assert!(session.refusal().expect("a reason").contains("was lost"), "{:?}", session.refusal());
    session.stop_recording();
    let recording = load_recording(&file).expect("a recording");
    let notes: Vec<_> = recording.notes().collect();
    assert!(matches!(notes[..], [(3 | 4, note)] if note.contains("was lost")), "{notes:?}");
}

#[test]
fn energies_that_a_device_does_not_measure_are_not_shown() {
    let Some(device) = device() else { return };
    let mut session = on_device("jelly", &device);
    run_to(&mut session, 5);
    session.advance(FRAME, &|| 0.0);
    let energy = session.energy().expect("read");
    assert!(energy.dissipated.is_nan() && energy.kinetic.is_finite());
    assert_eq!(session.energy_imbalance(), None);
}
