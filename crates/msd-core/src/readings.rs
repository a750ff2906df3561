//! What can be measured of a simulation?

use crate::energy::{self, Energy, Momentum};
use crate::real::Real;
use crate::simulation::Simulation;
use crate::snapshot::Snapshot;
use crate::stability::Estimator;

impl<R: Real> Simulation<R> {
    /// Predicts the largest stable substep at the present state, seconds: 0 if no step is stable,
    /// infinite if every step is.
    pub fn stable_substep(&self) -> f64 {
        self.stable_substep_by(&mut Estimator::default())
    }

    /// Predicts like [`Simulation::stable_substep`], in columns that are kept for the next time.
    pub fn stable_substep_by(&self, estimator: &mut Estimator) -> f64 {
        self.largest_step_from(&self.state, estimator)
    }

    /// What a renderer may see.
    pub fn snapshot(&self) -> Snapshot<'_, R> {
        Snapshot::new(&self.model, &self.state)
    }

    /// Where the energy is.
    pub fn energy(&self) -> Energy {
        self.energy_and_rounding().0
    }

    /// Where the energy is, and by how much rounding every coordinate and speed once can change
    /// it, joules: see [`energy::energy_and_rounding`].
    pub fn energy_and_rounding(&self) -> (Energy, f64) {
        let (energy, rounding) = energy::energy_and_rounding(&self.model, &self.state);
        let dissipated = self.ledger.dissipated(|| energy.total());
        (Energy { dissipated, ..energy }, rounding)
    }

    /// Energy taken away since the start by dampers, drag and contact, joules.
    pub fn dissipated(&self) -> f64 {
        self.ledger.dissipated(|| energy::energy(&self.model, &self.state, 0.0).total())
    }

    /// Linear and angular momentum.
    pub fn momentum(&self) -> Momentum {
        energy::momentum(&self.model, &self.state)
    }
}
