//! Ledger of the energy dissipated, and of that driven in, since the start.
//!
//! Everything is counted where it acts. Dampers and drag count by the power at each evaluation,
//! weighted by the quadrature of the method. Contact counts by the speed, impulse and path of each
//! particle that it stops. So [`crate::Energy::total`] is constant as far as the method is exact,
//! and its drift is the error of the method.
//!
//! Energy that a moving solid, a moving pin or a user-defined element drives in is counted
//! separately: it is neither negative dissipation nor an error of the method.

use crate::contact::Contacts;
use crate::contact::shells::ShellPassage;
use alloc::vec::Vec;

/// Energy dissipated and energy driven in, joules.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ledger {
    /// Energy dissipated, less that driven in.
    counted: f64,
    /// Energy driven in by user-defined elements and surfaces, not negative.
    #[cfg_attr(feature = "serde", serde(default))]
    given: f64,
    /// The effect of obstacles.
    #[cfg_attr(feature = "serde", serde(default))]
    contacts: Contacts,
    /// Number of times that shells may have crossed.
    #[cfg_attr(feature = "serde", serde(default))]
    passes: u64,
    /// The shells that were seen to go through each other.
    #[cfg_attr(feature = "serde", serde(default))]
    passages: Vec<ShellPassage>,
}

impl Ledger {
    /// A ledger with this much energy dissipated, joules.
    pub fn of(counted: f64) -> Self {
        Ledger { counted, ..Ledger::default() }
    }

    /// The same with this much energy driven in, joules.
    pub fn with_given(self, given: f64) -> Self {
        Ledger { given, ..self }
    }

    /// Energy dissipated, joules.
    pub fn dissipated(&self) -> f64 {
        self.counted + self.given
    }

    /// Energy that moving solids, moving pins and user-defined elements have driven into the
    /// system, joules; not negative.
    pub fn given(&self) -> f64 {
        self.given
    }

    /// The effect of obstacles.
    pub fn contacts(&self) -> Contacts {
        self.contacts
    }

    /// Number of times that shells may have crossed. It counts substeps in which particles were so
    /// fast that contacts may have been missed, and features that were seen to have gone through
    /// each other.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// The first passage of each two shells that were seen to go through each other, in the order
    /// of time; at most sixteen.
    pub fn passages(&self) -> &[ShellPassage] {
        &self.passages
    }

    /// Counts more of those.
    pub(crate) fn note_passes(&mut self, passes: u64, seen: impl Iterator<Item = ShellPassage>) {
        self.passes += passes;
        seen.for_each(|passage| passage.add_to(&mut self.passages));
    }

    /// Books a step in which `counted` was dissipated and `given` driven in, joules.
    pub(crate) fn book(&mut self, counted: f64, given: f64, contacts: Contacts) {
        self.counted += counted;
        self.given += given;
        self.contacts += contacts;
    }
}
