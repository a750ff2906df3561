//! A prediction in pieces, so that who waits for it can do something else in between.

use super::Estimator;
use super::few::{Few, How};
use super::region::Region;
use super::spectrum::OperatingPoint;
use crate::number::Real;
use crate::system::{Columns, Model};
use core::mem;
use core::ops::ControlFlow;

/// The search for a limit begins at this share of the expected value.
const START: f64 = 0.93;
/// The most times that the motion that grows first is added to those.
const ROUNDS: usize = 5;

/// Progress of a prediction.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase {
    /// The basis is made; nothing before it begins.
    Exploring(Option<Growth>),
    /// A few motions of it have a limit, seconds, after so many rounds.
    Resolving { limit: f64, rounds: usize },
    /// Explicit Euler is run about the state.
    Running,
}

/// Progress of a basis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    /// The limit that is expected, seconds.
    pub(super) guess: f64,
    /// The vectors that are to come, of the first half or of the second.
    pub(super) left: usize,
    pub(super) is_second: bool,
}

impl Default for Phase {
    fn default() -> Self {
        Phase::Exploring(None)
    }
}

impl Estimator {
    /// Forgets a prediction that is not at its end.
    pub fn restart(&mut self) {
        self.phase = Phase::default();
    }

    /// Predicts the largest stable substep about a state, seconds: 0 where none is stable, infinite
    /// where every one is. That of Dormand-Prince is where stability rather than its tolerance
    /// would set its step.
    ///
    /// Within 0.5 % of the observed limit, tested; 2 % for explicit Euler with damping that does
    /// not go with stiffness, whose limit large systems may miss by more. Strongly damped bends
    /// that are straight count as damped in all directions, so that the true limit may be longer by
    /// a third.
    pub(crate) fn limit<R: Real>(
        &mut self,
        about: (&Model<R>, &Columns<R>),
        time: f64,
        how: How,
    ) -> f64 {
        self.restart();
        loop {
            if let Some(limit) = self.advance(about, time, how) {
                return limit;
            }
        }
    }

    /// Does a piece of the same, which is to be about the same state as the piece before; returns
    /// the limit at its end.
    pub(crate) fn advance<R: Real>(
        &mut self,
        (model, state): (&Model<R>, &Columns<R>),
        time: f64,
        how: How,
    ) -> Option<f64> {
        if how.0 == Region::Everything {
            return Some(f64::INFINITY);
        }
        let point = OperatingPoint { model, motion: state.motion(&model.slots, time) };
        let next = match mem::take(&mut self.phase) {
            Phase::Exploring(growth) => self.explore_on(&point, how, growth),
            Phase::Resolving { limit, rounds } => {
                match self.resolve(&point, how, (limit, rounds)) {
                    ControlFlow::Break(limit) => self.begin_run(&point, how, limit),
                    next => next,
                }
            }
            Phase::Running => match self.euler.advance(&point, &mut self.basis) {
                Some(limit) => ControlFlow::Break(limit),
                None => ControlFlow::Continue(Phase::Running),
            },
        };
        match next {
            ControlFlow::Continue(phase) => {
                self.phase = phase;
                None
            }
            ControlFlow::Break(limit) => Some(limit),
        }
    }

    fn explore_on<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        how: How,
        growth: Option<Growth>,
    ) -> ControlFlow<f64, Phase> {
        // A step of few substeps of Verlet favours strongly damped motions: others fail first.
        let both = how == (Region::VelocityVerlet, 1);
        let (guess, motions) = match self.grow(point, both, growth) {
            ControlFlow::Continue(growth) => {
                return ControlFlow::Continue(Phase::Exploring(Some(growth)));
            }
            ControlFlow::Break(None) => return ControlFlow::Break(f64::INFINITY),
            ControlFlow::Break(Some((0.0, _))) => return ControlFlow::Break(0.0),
            ControlFlow::Break(Some(explored)) => explored,
        };
        *self.few = Few::new(motions, &self.basis, None);
        let mut limit = self.few.limit(how, START * guess);
        if both {
            for _ in 0..3 {
                *self.few = Few::new(motions, &self.basis, Some(limit));
                limit = self.few.limit(how, START * limit);
            }
        }
        ControlFlow::Continue(Phase::Resolving { limit, rounds: 0 })
    }

    /// Begins to run explicit Euler, whose limit the fastest motions do not show.
    fn begin_run<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        how: How,
        limit: f64,
    ) -> ControlFlow<f64, Phase> {
        let is_run = how.0 == Region::EXPLICIT_EULER && 0.0 < limit;
        if !is_run {
            return ControlFlow::Break(limit);
        }
        self.euler.begin(point, &self.basis, limit);
        ControlFlow::Continue(Phase::Running)
    }

    /// Adds the motion that grows first.
    fn resolve<R: Real>(
        &mut self,
        point: &OperatingPoint<'_, R>,
        how: How,
        (before, rounds): (f64, usize),
    ) -> ControlFlow<f64, Phase> {
        let is_over = rounds == ROUNDS || self.few.is_single();
        if is_over || !self.few.extend(point, &mut self.basis, (how, before)) {
            return ControlFlow::Break(before);
        }
        let limit = self.few.limit(how, START * before);
        if (limit - before).abs() <= 5e-5 * limit {
            return ControlFlow::Break(limit);
        }
        ControlFlow::Continue(Phase::Resolving { limit, rounds: rounds + 1 })
    }
}
