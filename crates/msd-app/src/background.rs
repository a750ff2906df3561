//! Threads in the background.

/// Gives every other thread precedence over this one. Where that is not possible nothing is done.
pub(crate) fn lower_priority() {
    // On Linux the priority is that of a thread; elsewhere it would be that of the whole program.
    #[cfg(target_os = "linux")]
    rustix::process::setpriority_process(None, 19).ok();
}
