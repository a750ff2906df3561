//! Work in the background: on a thread, or in a browser in a worker of the page.

#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

#[cfg(not(target_arch = "wasm32"))]
pub use native::MANNERS;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use native::{Job, Worker};
#[cfg(target_arch = "wasm32")]
pub use web::MANNERS;
#[cfg(target_arch = "wasm32")]
pub(crate) use web::{Hand, Labour, PageJob as Job, PageWorker as Worker};

use msd_study::Study;
use msd_study::choice::Choice;
use msd_study::conduct::{Follower, Progress};
use msd_study::leave::Halt;
use serde::Serialize;
use std::sync::Arc;

/// How long the reference of a study may take, seconds.
const STUDYING: f64 = 120.0;

/// What a worker has to show.
#[derive(Debug)]
pub struct Report<T> {
    /// How far it is; nothing before it began.
    pub progress: Option<Progress>,
    /// What it found so far.
    pub found: Option<Arc<T>>,
    /// Whether nothing is left to do.
    pub idle: bool,
    /// Why it gave up.
    pub failure: Option<String>,
}

impl<T> Default for Report<T> {
    fn default() -> Self {
        Report { progress: None, found: None, idle: false, failure: None }
    }
}

impl<T> Clone for Report<T> {
    fn clone(&self) -> Self {
        let Report { progress, found, idle, failure } = self;
        let (progress, failure) = (progress.clone(), failure.clone());
        Report { progress, found: found.clone(), idle: *idle, failure }
    }
}

/// What can be worked out in the background.
pub(crate) trait Task: Send + 'static {
    /// What comes of it.
    type Found;
    /// What a worker of a page knows it by.
    #[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, reason = "a thread is given it"))]
    const NAME: &'static str;
    /// Whether there is a place to rest between its pieces: what has only one begins anew after a
    /// rest where it cannot wait within.
    #[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, reason = "a thread waits anywhere"))]
    const IN_PIECES: bool;

    /// Does the next piece. Returns whether there is more to do.
    ///
    /// # Errors
    /// What the core refuses; [`Halt::Stopped`] where the job was ended.
    fn advance(&mut self, job: &mut Job<Self::Found>) -> Result<bool, Halt>;
}

impl Follower for Job<Study> {
    fn hear(&mut self, progress: Progress) {
        self.tell(progress);
    }

    fn see(&mut self, study: &Study) {
        self.show(study.clone());
    }

    fn goes_on(&mut self) -> bool {
        self.may_go_on()
    }

    fn patience(&self) -> f64 {
        STUDYING
    }

    fn wish(&mut self, idle: bool) -> Option<Choice> {
        self.wished(idle)
    }
}

/// Follows work that has nothing to show before its end, for so many seconds.
pub(crate) struct Patient<'a, T>(pub &'a mut Job<T>, pub f64);

impl<T: Serialize> Follower for Patient<'_, T> {
    fn hear(&mut self, progress: Progress) {
        self.0.tell(progress);
    }

    fn goes_on(&mut self) -> bool {
        self.0.may_go_on()
    }

    fn patience(&self) -> f64 {
        self.1
    }
}

/// What is said of a study or a search whose time was over before anything could be judged.
const LATE: &str = "its time was over before the right motion was known to compare with; from a \
                    calmer state it may be known in time";
/// What is said of a worker that broke down.
const BROKEN: &str = "it failed: please report this";
