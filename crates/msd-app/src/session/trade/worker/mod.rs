//! Work in the background: on a thread, or in a browser in a worker of the page.

#[cfg(not(target_arch = "wasm32"))]
mod native;
#[cfg(target_arch = "wasm32")]
mod web;

#[cfg(not(target_arch = "wasm32"))]
pub use native::MANNERS;
#[cfg(not(target_arch = "wasm32"))]
pub(crate) use native::Worker;
#[cfg(target_arch = "wasm32")]
pub use web::MANNERS;
#[cfg(target_arch = "wasm32")]
pub(crate) use web::{Drive, Note, Order, PageWorker as Worker, drive};

use msd_study::choice::Choice;
use msd_study::monitor::{Halt, Monitor, Progress};
use std::sync::Arc;

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

/// Work in the background, as a state machine that a thread or a worker of the page drives.
pub(crate) trait Task: Send + 'static {
    /// What comes of it.
    type Found;
    /// What a worker of a page knows it by.
    #[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, reason = "a thread is given it"))]
    const NAME: &'static str;
    /// Whether it has many pieces, between which it can pause, and waits for choices after the
    /// last: the only piece of another task begins anew after a pause where it cannot wait within.
    const IN_PIECES: bool;

    /// Does the next piece, which is a trial of `choice` where the user asks for one; returns the
    /// result so far, or `None` if nothing was left to do.
    ///
    /// # Errors
    /// What the core refuses; what [`Monitor::proceed`] returns.
    fn advance(
        &mut self,
        choice: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Self::Found>, Halt>;
}

/// What is said of a worker that broke down.
const BROKEN: &str = "it failed: please report this";
