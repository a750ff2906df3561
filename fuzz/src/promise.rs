//! Promises that hold whatever the input: messages in lines, and states inside the world.

use msd_core::{Real, Simulation, State, Vector};
use std::fmt::Display;

/// Checks that a message is one line that says something, or up to ten of a scene file.
pub(crate) fn check_message(error: &impl Display) {
    error.to_string().lines().for_each(check_line);
    assert!((1..=10).contains(&error.to_string().lines().count()), "{error}");
}

fn check_line(message: &str) {
    assert!(!message.chars().any(char::is_control), "{message:?}");
}

/// Checks that positions are inside the world and velocities finite.
pub(crate) fn check_state<R: Real>(state: &State<R>, extent: R) {
    for (row, (position, velocity)) in state.positions.iter().zip(&state.velocities).enumerate() {
        // A comparison that a NaN fails.
        let inside = position.extent() <= extent;
        assert!(inside, "position {row} is {position:?} in a world of {extent}");
        let finite = velocity.extent().to_f64().is_finite();
        assert!(finite, "velocity {row} is {velocity:?}");
    }
}

/// Checks that a simulation may be stepped: its state, and every number a step multiplies by.
pub(crate) fn check_simulation<R: Real>(simulation: &Simulation<R>) {
    let model = simulation.model();
    check_state(&simulation.state(), model.extent());
    let finite = |what: &str, row: usize, value: R| {
        assert!(value.to_f64().is_finite(), "{what} of row {row} is {value}");
    };
    for (row, &mass) in model.masses().iter().enumerate() {
        finite("mass", row, mass);
    }
    for (row, &inverse) in model.inverse_masses().iter().enumerate() {
        finite("inverse mass", row, inverse);
    }
    for row in (0..model.ends().len()).filter(|&row| !model.is_cut(row)) {
        finite("rest length", row, model.rest_lengths()[row]);
        finite("stiffness", row, model.stiffness(row));
        finite("damping", row, model.damping(row));
    }
    for (row, grab) in model.grabs().iter().enumerate() {
        finite("grab stiffness", row, grab.stiffness);
        finite("grab damping", row, grab.damping);
        finite("grab target", row, grab.target.extent());
    }
    for (row, plane) in model.planes().iter().enumerate() {
        finite("plane offset", row, plane.offset);
        finite("plane normal", row, plane.normal.extent());
        finite("plane restitution", row, R::of(plane.restitution()));
    }
    finite("gravity", 0, model.gravity().extent());
    finite("force", 0, model.force().extent());
    finite("drag", 0, model.drag());
    assert!(simulation.time().is_finite());
}

/// Steps, and returns whether the step was made. One that was not must keep the positions and
/// report why.
pub(crate) fn step<R: Real>(simulation: &mut Simulation<R>) -> bool {
    let before = simulation.state().positions;
    let (steps, queue) = (simulation.steps(), simulation.queued().to_vec());
    let Err(error) = simulation.step() else {
        assert_eq!(simulation.steps(), steps + 1);
        return true;
    };
    check_message(&error);
    assert!(error.is_of_step(), "{error}");
    assert_eq!(simulation.steps(), steps);
    assert_eq!(simulation.state().positions, before, "the last good state is kept");
    // It would make every step to come fail.
    assert_eq!(simulation.queued(), queue);
    simulation.clear_queue();
    false
}
