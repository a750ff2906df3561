//! One who follows a study or a search: what is told, and how long the patience lasts.

use crate::candidates::choice::Choice;
use crate::measure::leave::Halt;
use crate::measure::reference::{Reference, Stage, Wish, watched_reference};
use crate::study::Study;
use msd_core::Scene;
use serde::{Deserialize, Serialize};
use web_time::{Duration, Instant};

/// The part of the patience after which a reference is not tightened further, of the processor.
const REFERENCE: f64 = 0.3;
/// Where the follower lets it wait for longer than this, that is a pause, which takes no patience.
const PAUSE: Duration = Duration::from_secs(1);

/// How far a study is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// What is being done.
    pub now: String,
    /// Trials done.
    pub done: usize,
    /// Methods, each in one precision, of which nothing is left to try, and all of them; none while
    /// no method is tried.
    pub methods: Option<[usize; 2]>,
    /// Time of the processor still to be spent, at most, seconds; none before it can be told.
    pub left: Option<f64>,
}

impl Progress {
    /// Before the first trial.
    pub(crate) fn of_reference(stage: Option<Stage>) -> Self {
        let now = "making the reference".to_owned();
        let now = stage.map_or(now.clone(), |stage| format!("{now}: {}", stage.words()));
        Progress { now, done: 0, methods: None, left: None }
    }

    /// Between the reference and the first trial.
    pub(crate) fn of_prediction() -> Self {
        let now = "predicting how long the steps may be".into();
        Progress { now, done: 0, methods: None, left: None }
    }

    /// How many methods are done, as far as that is known, and what is being done, in words.
    pub fn words(&self) -> String {
        match self.methods {
            Some([done, all]) => {
                format!("{done} of {all} pairs of method and precision done; {}", self.now)
            }
            None => self.now.clone(),
        }
    }
}

/// One who follows a study while it is made.
pub trait Follower {
    /// Hears how far it is.
    fn hear(&mut self, progress: Progress);

    /// Sees what was found so far, whenever a trial was added or timed again.
    fn see(&mut self, _study: &Study) {}

    /// Asked after every frame or so: may wait, and ends the study by saying no.
    fn goes_on(&mut self) -> bool {
        true
    }

    /// How long a search, or the reference of a study, may take by the clock, pauses left out,
    /// seconds: then the best that a search has found is its answer, and there is no study.
    fn patience(&self) -> f64 {
        f64::INFINITY
    }

    /// A choice to be tried before all others. One that has nothing else to do, as it is `idle`,
    /// waits for the answer, and ends where there is none.
    fn wish(&mut self, _idle: bool) -> Option<Choice> {
        None
    }
}

/// One who listens, to the end.
pub(crate) struct Listener<'a>(pub &'a mut dyn FnMut(Progress));

impl Follower for Listener<'_> {
    fn hear(&mut self, progress: Progress) {
        (self.0)(progress);
    }
}

/// A follower, and since when it is waited for, pauses left out.
pub(crate) struct Hurried<'a> {
    follower: &'a mut dyn Follower,
    since: Instant,
}

impl<'a> Hurried<'a> {
    /// One whose patience begins now.
    pub(crate) fn new(follower: &'a mut dyn Follower) -> Self {
        Hurried { follower, since: Instant::now() }
    }

    /// How a reference is to be made for it.
    pub(crate) fn wish(&self, duration: f64, uncertainty: f64) -> Wish {
        let wish = Wish { duration, uncertainty, ..Wish::default() };
        Wish { patience: wish.patience.min(REFERENCE * self.follower.patience()), ..wish }
    }

    /// The reference of a scene; what is done is told.
    pub(crate) fn reference(&mut self, scene: &Scene, wish: Wish) -> Result<Reference, Halt> {
        self.hear(Progress::of_reference(None));
        let right = watched_reference(scene, wish, &mut |stage| {
            self.hear(Progress::of_reference(Some(stage)));
            self.goes_on()
        });
        right.map_err(|halt| self.reason(halt))
    }

    pub(crate) fn hear(&mut self, progress: Progress) {
        self.follower.hear(progress);
    }

    fn is_late(&self) -> bool {
        self.follower.patience() < self.since.elapsed().as_secs_f64()
    }

    /// Whether the work goes on.
    pub(crate) fn goes_on(&mut self) -> bool {
        let asked = Instant::now();
        let goes_on = self.follower.goes_on();
        let waited = asked.elapsed();
        if PAUSE < waited {
            self.since += waited;
        }
        goes_on && !self.is_late()
    }

    /// Why it does not: whether the follower ended it or the time is over.
    pub(crate) fn reason(&self, halt: Halt) -> Halt {
        if halt == Halt::Stopped && self.is_late() { Halt::Late } else { halt }
    }
}
