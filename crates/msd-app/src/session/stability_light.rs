//! How near is the substep to the largest stable one?

/// Shortest time between two predictions, seconds.
const REFRESH: f64 = 1.0;
/// The largest share of the wall clock that predictions may take.
const SHARE: f64 = 0.005;

/// The predicted stable substep, renewed at a bounded rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margin {
    /// Largest stable substep, seconds: 0 if none is, infinite if every one is; none before the
    /// first prediction.
    pub stable: Option<f64>,
    /// Wall-clock time since the last prediction, seconds.
    age: f64,
    /// What the last prediction cost, seconds.
    cost: f64,
    /// Whether something changed since.
    stale: bool,
}

impl Margin {
    /// Says that a setting changed, so that the prediction should be renewed soon.
    pub fn touch(&mut self) {
        self.stale = true;
    }

    /// Lets wall-clock time pass and says whether to predict now.
    pub fn is_due(&mut self, real: f64) -> bool {
        self.age += real.max(0.0);
        // A changed setting is answered at once where that is cheap, and never at the price of
        // the motion where it is not.
        let wait = if self.stale { 0.0 } else { REFRESH }.max(self.cost / SHARE);
        self.stable.is_none() || wait <= self.age
    }

    /// Stores a prediction and its cost in seconds.
    pub fn set(&mut self, stable: f64, cost: f64) {
        // What costs less than a millisecond may be renewed at every change.
        let cost = if cost < 1e-3 { 0.0 } else { cost };
        *self = Margin { stable: Some(stable), age: 0.0, cost, stale: false };
    }

    /// The substep as a share of the largest stable one: 1 is the limit, infinite where no step is
    /// stable.
    pub fn share(&self, substep: f64) -> Option<f64> {
        self.stable.map(|stable| if stable == 0.0 { f64::INFINITY } else { substep / stable })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_answered_at_once_where_cheap() {
        let mut margin = Margin::default();
        assert!(margin.is_due(0.0));
        margin.set(0.01, 2e-4);
        assert!(!margin.is_due(0.5));
        margin.touch();
        assert!(margin.is_due(0.0));
        assert_eq!(margin.share(0.005), Some(0.5));
    }

    #[test]
    fn an_expensive_prediction_is_rare() {
        let mut margin = Margin::default();
        margin.set(0.01, 0.1);
        margin.touch();
        assert!(!margin.is_due(10.0));
        assert!(margin.is_due(10.0));
    }

    #[test]
    fn no_stable_step_is_infinitely_far_over_the_limit() {
        let mut margin = Margin::default();
        margin.set(0.0, 0.0);
        assert_eq!(margin.share(1e-9), Some(f64::INFINITY));
        margin.set(f64::INFINITY, 0.0);
        assert_eq!(margin.share(1.0), Some(0.0));
    }
}
