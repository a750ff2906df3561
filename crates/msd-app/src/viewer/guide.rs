//! The tour: five steps of a new user with the real controls.

use crate::session::{ErrorNow, Session};

/// The steps of the tour, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideStep {
    /// Grab a body and throw it.
    Grab,
    /// Make it stiffer until the step exceeds the limit.
    Stiffen,
    /// Watch it diverge.
    BlowUp,
    /// Apply a recovery option.
    Mend,
    /// See the remaining error, and the cost of a step.
    Cost,
}

impl GuideStep {
    /// All steps.
    pub const ALL: [GuideStep; 5] =
        [GuideStep::Grab, GuideStep::Stiffen, GuideStep::BlowUp, GuideStep::Mend, GuideStep::Cost];

    /// Returns the instruction or, once the step is done, its result: one sentence.
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
            GuideStep::Mend => "Choose a recovery option in the box: each shows its cost.",
            GuideStep::Cost => {
                "Tick Estimate error: it shows the error of this setting, and ms/step its cost."
            }
        }
    }

    /// Returns how long the step stays after it is done, seconds: stiff springs diverge before the
    /// user has read the instruction.
    fn stay(self) -> f64 {
        if self == GuideStep::BlowUp { 4.0 } else { 0.0 }
    }

    /// Returns whether the step is done; `held` is whether a particle was held in the last frame.
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

/// Progress of a user in the tour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guide {
    done: usize,
    held: bool,
    /// Time since the current step was done, seconds.
    reached: Option<f64>,
}

impl Guide {
    /// Returns the current step; `None` once all are done.
    pub fn step(&self) -> Option<GuideStep> {
        GuideStep::ALL.get(self.done).copied()
    }

    /// Returns the sentence of the current step.
    pub fn text(&self) -> Option<&'static str> {
        self.step().map(|step| step.text(self.reached.is_some()))
    }

    /// Returns the number of completed steps.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Checks a session, once per frame; `real` is the duration of the last frame, seconds. Returns
    /// how long the completed step stays, seconds.
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
