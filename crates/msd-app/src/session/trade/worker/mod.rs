//! Background work, on a thread or, in a browser, in a web worker.

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

/// State of a worker.
#[derive(Debug)]
pub struct Report<T> {
    /// Progress; `None` before the start.
    pub progress: Option<Progress>,
    /// Results so far.
    pub found: Option<Arc<T>>,
    /// Whether no work is left.
    pub idle: bool,
    /// Reason for a failure.
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

/// Background work as a state machine, driven by a thread or a web worker.
pub(crate) trait Task: Send + 'static {
    /// Type of the result.
    type Found;
    /// Name of the task for a web worker.
    #[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, reason = "a thread is given it"))]
    const NAME: &'static str;
    /// Whether the task has many pieces, pauses between them, and waits for choices after the last.
    /// A task in one piece restarts after a pause if it cannot wait within the piece.
    const IN_PIECES: bool;

    /// Works on the next piece, a trial of `choice` if the user requests one. Returns the result so
    /// far, or `None` if no work was left.
    ///
    /// # Errors
    /// Refusals of the core, and errors of [`Monitor::proceed`].
    fn advance(
        &mut self,
        choice: Option<Choice>,
        monitor: &mut dyn Monitor,
    ) -> Result<Option<Self::Found>, Halt>;
}

/// Message after a panic of a worker.
const BROKEN: &str = "it failed: please report this";
