//! Ctrl-C, or a polite kill: a long command ends with what it has done so far.

use crate::cli::failure::INTERRUPTED;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user wants a command to end; whoever asks once more does not want to wait either.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Catches Ctrl-C from now on, and SIGTERM, by which `kill`, `timeout` and clusters end a
    /// program. Where that cannot be, they end it as ever.
    pub fn catch() -> Self {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: what is asked for the second time was asked for before.
            let code = INTERRUPTED.into();
            if register_conditional_shutdown(signal, code, Arc::clone(&asked)).is_ok() {
                let _ = register(signal, Arc::clone(&asked));
            }
        }
        Interrupt(asked)
    }

    /// Whether the command is to end.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
