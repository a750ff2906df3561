//! Ctrl-C and SIGTERM: a long command stops and keeps the output so far.

use crate::cli::failure::INTERRUPTED;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Flag of a requested stop; a second signal ends the program at once.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Catches Ctrl-C from now on, and SIGTERM, by which `kill`, `timeout` and clusters end a
    /// program. If that fails, the signals end the program as usual.
    pub fn catch() -> Self {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order, so that only the second signal finds the flag set, and exits.
            let code = INTERRUPTED.into();
            if register_conditional_shutdown(signal, code, Arc::clone(&asked)).is_ok() {
                let _ = register(signal, Arc::clone(&asked));
            }
        }
        Interrupt(asked)
    }

    /// Returns whether a stop was requested.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
