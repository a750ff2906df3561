//! A thread that takes steps again.

use super::again::{Again, Difference, Taken};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

/// The rest after a check, in durations of the check: the thread works for a tenth of the time at
/// most.
const REST: u32 = 9;

/// The thread. It ends with this value.
#[derive(Debug)]
pub struct ThreadWorker {
    send: Sender<Taken>,
    results: Receiver<Option<Difference>>,
}

impl ThreadWorker {
    pub fn new() -> Self {
        let (send, taken) = channel();
        let (send_result, results) = channel();
        thread::spawn(move || take_again(&taken, &send_result));
        ThreadWorker { send, results }
    }

    /// Begins to take a step again.
    pub fn begin(&mut self, taken: Taken) {
        // The thread ends with the worker, not before.
        drop(self.send.send(taken));
    }

    /// The result, if there is a new one.
    pub fn result(&mut self) -> Option<Option<Difference>> {
        self.results.try_recv().ok()
    }

    /// Waits for the result of the step that was begun.
    pub fn wait(&mut self) -> Option<Option<Difference>> {
        self.results.recv().ok()
    }

    /// The time from the end of a check to the start of the next, at least.
    pub fn rest_after(check: Duration) -> Duration {
        check * REST
    }
}

/// Takes steps again until nobody sends any more.
fn take_again(taken: &Receiver<Taken>, results: &Sender<Option<Difference>>) {
    let mut again = Again::default();
    for taken in taken {
        if results.send(again.take(taken)).is_err() {
            break;
        }
    }
}
