//! The choices of one method worth trying, from the coarsest that is stable to finer ones.

use crate::candidates::choice::{Choice, FRAME, Fineness};
use msd_core::scene::any_meet;
use msd_core::{Error, Integrator, Scene, Settings, Simulation};
use msd_scene::Precision;

/// A ladder reaches to this times the fewest substeps, and at least to [`LEAST_REACH`].
const REACH: u32 = 64;
/// A ladder reaches at least to this number of substeps.
const LEAST_REACH: u32 = 2048;

/// 1, 2, 3, 4, 6, 8, 12, 16 and so on: two per doubling.
fn round_numbers() -> impl Iterator<Item = u32> {
    let doublings = (1..=30).flat_map(|power| [1 << power, 3 << (power - 1)]);
    std::iter::once(1).chain(doublings)
}

/// The tolerances that studies try.
const TOLERANCES: [f64; 9] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// The work of [`ladders`], as a progress report prints it.
pub(crate) const PREDICTION: &str = "predicting how long the steps may be";
/// Both precisions.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// One method in one precision, and how coarse it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ladder {
    /// The method.
    pub integrator: Integrator,
    /// The precision.
    pub precision: Precision,
    /// Fewest substeps per frame that are predicted stable; none if no number is.
    pub fewest: Option<u32>,
}

impl Ladder {
    /// The choices of a study, coarsest first.
    pub fn rungs(&self) -> Vec<Choice> {
        if self.integrator.is_adaptive() {
            return TOLERANCES.map(|tolerance| self.choice(Fineness::Tolerance(tolerance))).into();
        }
        let Some(fewest) = self.fewest else { return Vec::new() };
        // The coarsest stable one is on the ladder whatever its number.
        let all = std::iter::once(fewest).chain(round_numbers().filter(|&n| fewest < n));
        let last = fewest.saturating_mul(REACH).max(LEAST_REACH);
        let all = all.take_while(|&substeps| substeps <= last);
        all.map(|substeps| self.choice(Fineness::Substeps(substeps))).collect()
    }

    /// A choice of this method and precision.
    pub fn choice(&self, fineness: Fineness) -> Choice {
        let Ladder { integrator, precision, .. } = *self;
        Choice { integrator, fineness, precision }
    }
}

/// Share of the largest stable substep that is used: contact and stretch make a scene stiffer.
const MARGIN: f64 = 0.95;

/// Every method that can run a scene in both precisions, with the fewest substeps that are
/// predicted stable.
///
/// # Errors
/// A scene that [`Simulation::new`] refuses.
pub fn ladders(scene: &Scene) -> Result<Vec<Ladder>, Error> {
    let simulation = Simulation::<f64>::new(scene, Settings::default())?;
    let fewest = |integrator: Integrator| {
        if integrator.is_adaptive() {
            return Some(1);
        }
        // Of many substeps per step: one alone of Verlet is stable up to a longer one.
        let stable = simulation.stable_substep_of(integrator, 64);
        if stable == f64::INFINITY {
            return Some(1);
        }
        let substeps = (FRAME / (MARGIN * stable)).ceil();
        (substeps <= f64::from(u32::MAX)).then_some((substeps as u32).max(1))
    };
    let each = |integrator: Integrator| {
        let fewest = fewest(integrator);
        PRECISIONS.map(|precision| Ladder { integrator, precision, fewest })
    };
    let is_able = |method: &Integrator| !any_meet(&scene.shells) || method.lets_shells_meet();
    Ok(Integrator::ALL.into_iter().filter(is_able).flat_map(each).collect())
}
