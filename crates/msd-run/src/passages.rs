//! Bodies that went through each other, by name.

use msd_core::{Model, Passage, Real, Simulation};
use serde::Serialize;
use std::fmt;

/// A body that was seen to go through another one or itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WentThrough {
    /// The name of the body, with its number where several have that name.
    pub body: String,
    /// The name of the other one; its own name where it went through itself.
    pub through: String,
    /// When that was first seen, simulated seconds.
    pub time: f64,
}

impl fmt::Display for WentThrough {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WentThrough { body, through, .. } = self;
        let through = if body == through { "itself" } else { through };
        write!(f, "{body} went through {through}")
    }
}

/// The bodies that were seen to go through each other since the start, each two once.
pub(crate) fn went_through<R: Real>(simulation: &Simulation<R>) -> Vec<WentThrough> {
    let model = simulation.model();
    let named = |&Passage { particles: [first, last], time }: &Passage| {
        // What is pinned stays. Otherwise a file has first what lies below.
        let first_moves = !has_pins(model, first) && has_pins(model, last);
        let [body, through] = if first_moves { [first, last] } else { [last, first] };
        let [body, through] = [body, through].map(|particle| name(model, particle));
        WentThrough { body, through, time }
    };
    simulation.ledger().passages().iter().map(named).collect()
}

/// The name of the body of a particle.
fn name<R: Real>(model: &Model<R>, particle: usize) -> String {
    let bodies = model.bodies();
    let Some(number) = body_of(model, particle) else { return format!("particle {particle}") };
    let name = &bodies[number].name;
    match bodies.iter().filter(|body| body.name == *name).count() {
        1 => name.clone(),
        _ => format!("{name} (body {number})"),
    }
}

fn has_pins<R: Real>(model: &Model<R>, particle: usize) -> bool {
    let number = body_of(model, particle);
    number.is_some_and(|at| model.bodies()[at].particles.clone().any(|at| model.is_pinned(at)))
}

fn body_of<R: Real>(model: &Model<R>, particle: usize) -> Option<usize> {
    model.bodies().iter().position(|body| body.particles.contains(&particle))
}
