//! The ledger: energy taken away, and driven in, since the start.
//!
//! Everything is counted where it acts: dampers and drag by the power at each evaluation, weighed
//! by the quadrature of the method, and contact by the speed, impulse and way of each particle that
//! it stops. So [`crate::Energy::total`] stays where it is as far as the method is exact, and what
//! it drifts by is the error of the method.
//!
//! What an element or a surface of the caller's own drives in is taken away less than nothing; it
//! is also counted apart, so that it is not mistaken for an error of the method.

use crate::obstacles::Contacts;

/// What was taken away and what was driven in, joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ledger {
    /// Taken away, less what was driven in.
    counted: f64,
    /// Driven in by elements and surfaces of the caller's own, not negative.
    #[cfg_attr(feature = "serde", serde(default))]
    given: f64,
    /// What obstacles did.
    #[cfg_attr(feature = "serde", serde(default))]
    contacts: Contacts,
}

impl Ledger {
    /// A ledger in which this much was taken away.
    pub fn of(counted: f64) -> Self {
        Ledger { counted, ..Ledger::default() }
    }

    /// What was taken away, joules.
    pub fn dissipated(&self) -> f64 {
        self.counted
    }

    /// Energy that elements and surfaces of the caller's own have driven into the system, joules;
    /// not negative.
    pub fn given(&self) -> f64 {
        self.given
    }

    /// What obstacles did.
    pub fn contacts(&self) -> Contacts {
        self.contacts
    }

    /// Books a step in which `counted` was taken away and `given` driven in, joules.
    pub(crate) fn book(&mut self, counted: f64, given: f64, contacts: Contacts) {
        self.counted += counted;
        self.given += given;
        self.contacts += contacts;
    }
}
