//! State files of any bytes.
//!
//! The first byte selects the number of particles and the precision.

use super::promise::{check_message, check_state};
use msd_core::{Material, Real, Scene, Settings, Simulation, State, Vector, shape};
use msd_run::Runner;
use msd_scene::{AnyState, Precision, read_state};

/// Reads bytes as a state, puts it into a simulation, and steps on from there.
pub fn check(bytes: &[u8]) {
    let Some((&first, bytes)) = bytes.split_first() else { return };
    let count = usize::from(first % 16);
    let precision = if first & 16 == 0 { Precision::F32 } else { Precision::F64 };
    match read_state(bytes, precision, ("state", count)) {
        Ok(state) => {
            match &state {
                AnyState::F32(state) => check_read(state, count),
                AnyState::F64(state) => check_read(state, count),
            }
            go_on(&state, count);
        }
        Err(error) => check_message(&error),
    }
}

fn check_read<R: Real>(state: &State<R>, count: usize) {
    assert_eq!([state.positions.len(), state.velocities.len()], [count, count]);
    for vector in state.positions.iter().chain(&state.velocities) {
        assert!(vector.extent().to_f64().is_finite(), "{vector:?}");
    }
}

/// A state is taken by runs of either precision, or refused.
fn go_on(state: &AnyState, count: usize) {
    let Ok(rope) = shape::rope(count, 1.0, Material::default()) else { return };
    let scene = Scene::of("rope", rope);
    for precision in [Precision::F32, Precision::F64] {
        let mut runner = Runner::new(&scene, Settings::default(), precision).expect("a plain rope");
        let before = runner.state();
        if let Err(error) = runner.set_state(state, 3) {
            check_message(&error);
            assert_eq!(runner.state(), before);
        } else if let Err(error) = runner.step() {
            check_message(&error);
        }
        match &runner {
            Runner::F32(simulation, _) => check_inside(simulation),
            Runner::F64(simulation, _) => check_inside(simulation),
        }
    }
}

fn check_inside<R: Real>(simulation: &Simulation<R>) {
    check_state(&simulation.state(), simulation.model().extent());
}
