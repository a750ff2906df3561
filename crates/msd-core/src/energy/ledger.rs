//! The ledger: energy taken away, and driven in, since the start.
//!
//! Dampers and drag are counted where they act. A particle that rests on a plane falls a little and
//! is moved back in every substep, and its dampers work at a speed it does not have; so while
//! something touches an obstacle and no hand does work, what was taken away is what the balance
//! leaves.
//! A contact that *adds* energy then shows as dissipation that goes down.
//!
//! What an element of the caller's own drives in is taken away less than nothing; it is also
//! counted apart, so that it is not mistaken for an error of the method.

/// What was taken away and what was driven in, joules.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ledger {
    /// Counted up to the start of the present contact.
    counted: f64,
    /// Total energy at the start of the present contact.
    balance: Option<f64>,
    /// Driven in by elements of the caller's own, not negative.
    #[cfg_attr(feature = "serde", serde(default))]
    given: f64,
}

impl Ledger {
    /// A ledger in which this much was taken away.
    pub fn of(counted: f64) -> Self {
        Ledger { counted, ..Ledger::default() }
    }

    /// What was taken away; `mechanical` measures the rest of the energy now.
    pub fn dissipated(&self, mechanical: impl FnOnce() -> f64) -> f64 {
        self.balance.map_or(self.counted, |total| total - mechanical())
    }

    /// Energy that elements of the caller's own have driven into the system, joules; not negative.
    pub fn given(&self) -> f64 {
        self.given
    }

    /// Books energy that elements of the caller's own have driven in, joules; not negative.
    pub fn give(&mut self, joules: f64) {
        self.given += joules;
    }

    /// Whether what was taken away depends on the energy now.
    pub fn is_open(&self) -> bool {
        self.balance.is_some()
    }

    /// Ends the present contact, if there is one; `mechanical` measures the energy at its end.
    pub fn close(&mut self, mechanical: impl FnOnce() -> f64) {
        *self = Ledger { given: self.given, ..Ledger::of(self.dissipated(mechanical)) };
    }

    /// Books a step in which `counted` was taken away; `mechanical` measures the energy before it.
    pub fn book(&mut self, counted: f64, contact_alone: bool, mechanical: impl FnOnce() -> f64) {
        if !contact_alone {
            self.close(mechanical);
            self.counted += counted;
        } else if self.balance.is_none() {
            self.balance = Some(self.counted + mechanical());
        }
    }
}
