//! The guide: five steps that a new user takes with the real controls.

use crate::session::{ErrorNow, Session};

/// The steps of the guide, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideStep {
    /// Grab it and throw it.
    Grab,
    /// Make it stiffer until the step is too long for it.
    Stiffen,
    /// Watch it blow up.
    BlowUp,
    /// Take a way out.
    Mend,
    /// See what is left of the error, and what a step costs.
    Cost,
}

impl GuideStep {
    /// All steps.
    pub const ALL: [GuideStep; 5] =
        [GuideStep::Grab, GuideStep::Stiffen, GuideStep::BlowUp, GuideStep::Mend, GuideStep::Cost];

    /// What is to be done, or, where it was, what happened: one sentence.
    fn text(self, is_reached: bool) -> &'static str {
        match self {
            GuideStep::Grab => "Press on the body, drag it, and let go to throw it.",
            GuideStep::Stiffen => {
                "Drag Stiffness, under Material, right until the percentage under Solver turns red."
            }
            GuideStep::BlowUp if is_reached => {
                "It blew up: the step is too long for the stiffest springs."
            }
            GuideStep::BlowUp => "Wait: a step beyond the limit makes it blow up.",
            GuideStep::Mend => "Choose a way out in the box: each says what it costs.",
            GuideStep::Cost => {
                "Tick Estimate error: that is what this setting gets wrong, and ms/step is what it \
                 costs."
            }
        }
    }

    /// How long it stays once it was done, seconds: stiff springs blow up before one has read that
    /// they will.
    fn stay(self) -> f64 {
        if self == GuideStep::BlowUp { 4.0 } else { 0.0 }
    }

    /// Whether a session shows that it was done; `held` says whether something was held before.
    fn is_done(self, session: &Session, held: bool) -> bool {
        let share = session.stability().map(|(share, _)| share);
        match self {
            GuideStep::Grab => held && session.held().is_none(),
            GuideStep::Stiffen => {
                session.failure().is_some() || share.is_some_and(|share| 1.0 < share)
            }
            GuideStep::BlowUp => session.failure().is_some(),
            GuideStep::Mend => {
                session.failure().is_none() && share.is_some_and(|share| share <= 1.0)
            }
            GuideStep::Cost => matches!(session.error(), Some(ErrorNow::Known(_))),
        }
    }
}

/// How far a user has got in the guide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guide {
    done: usize,
    held: bool,
    /// How long ago the present step was done, seconds.
    reached: Option<f64>,
}

impl Guide {
    /// The step to take now; `None` once all are done.
    pub fn step(&self) -> Option<GuideStep> {
        GuideStep::ALL.get(self.done).copied()
    }

    /// The sentence of the step to take now.
    pub fn text(&self) -> Option<&'static str> {
        self.step().map(|step| step.text(self.reached.is_some()))
    }

    /// Steps that were done.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Looks at a session, once per frame; `real` is how long the frame before was shown, seconds.
    /// Returns how long the step that was done stays, seconds.
    pub fn follow(&mut self, session: &Session, real: f64) -> Option<f64> {
        let held = std::mem::replace(&mut self.held, session.held().is_some());
        let step = self.step()?;
        match &mut self.reached {
            Some(reached) => *reached += real,
            None => self.reached = step.is_done(session, held).then_some(0.0),
        }
        let left = step.stay() - self.reached?;
        if 0.0 < left {
            return Some(left);
        }
        (self.done, self.reached) = (self.done + 1, None);
        None
    }
}
