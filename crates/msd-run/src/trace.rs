//! Traces of a run: a row of energy and momentum per step, as CSV.

use crate::on;
use crate::runner::Runner;
use msd_core::{Contacts, Real, Simulation, Vector};
use msd_scene::{FileError, Output};
use std::io::Write;

/// A trace that is being written: CSV with a row for the start and one after every step.
#[derive(Debug)]
pub struct Trace {
    output: Output,
    watched: Vec<usize>,
    held: Vec<Vec<usize>>,
}

impl Trace {
    /// Begins a trace with its header: the step (0 is the start), the time, s, the energies, J,
    /// what contact took and what it added by its own account, J, the linear momentum, N s, the
    /// angular momentum about the origin, N m s, the position, m, of each watched particle, and the
    /// force, N, with which pins hold the particles of each set in `held`.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn begin(
        mut output: Output,
        watched: Vec<usize>,
        held: Vec<(String, Vec<usize>)>,
    ) -> Result<Self, FileError> {
        let mut header = String::from(
            "step,time,kinetic,elastic,gravitational,dissipated,supplied,total,\
             contact_taken,contact_added,px,py,pz,lx,ly,lz",
        );
        for particle in &watched {
            header.push_str(&format!(",x{particle},y{particle},z{particle}"));
        }
        for (name, _) in &held {
            // A name may have any letters, but a column no comma.
            let name = name.replace([',', '"'], "_");
            header.push_str(&format!(",fx.{name},fy.{name},fz.{name}"));
        }
        writeln!(output, "{header}").map_err(|error| output.refused(&error))?;
        let held = held.into_iter().map(|(_, particles)| particles).collect();
        Ok(Trace { output, watched, held })
    }

    /// Adds the row of the current state.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn add(&mut self, runner: &Runner) -> Result<(), FileError> {
        let (energy, momentum) = (runner.energy(), runner.momentum());
        let Contacts { mut taken, mut added, .. } = runner.contacts();
        if energy.dissipated.is_nan() {
            // Nor does a graphics device measure these.
            (taken, added) = (f64::NAN, f64::NAN);
        }
        let mut row = vec![
            runner.time(),
            energy.kinetic,
            energy.elastic,
            energy.gravitational,
            energy.dissipated,
            energy.supplied,
            energy.total(),
            taken,
            added,
        ];
        row.extend(momentum.linear.to_array());
        row.extend(momentum.angular.to_array());
        let mut text = runner.steps().to_string();
        row.iter().for_each(|value| text.push_str(&format!(",{value:?}")));
        for &particle in &self.watched {
            on!(runner, simulation => push_position(&mut text, simulation, particle));
        }
        if !self.held.is_empty() {
            let groups = self.held.iter().map(|held| held.iter().copied());
            let forces = on!(runner, simulation => simulation.pin_forces(groups));
            let numbers = forces.iter().flat_map(|force| force.to_array());
            numbers.for_each(|number| text.push_str(&format!(",{number:?}")));
        }
        writeln!(self.output, "{text}").map_err(|error| self.output.refused(&error))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn finish(self) -> Result<(), FileError> {
        self.output.finish()
    }
}

fn push_position<R: Real>(text: &mut String, simulation: &Simulation<R>, particle: usize) {
    let position = simulation.position(particle);
    for component in position.components() {
        text.push_str(&format!(",{component:?}"));
    }
}
