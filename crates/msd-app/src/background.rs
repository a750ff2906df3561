//! Priority of background threads.

/// Gives every other thread precedence over this one, where the system allows it.
pub(crate) fn lower_priority() {
    // On Linux the priority belongs to a thread; elsewhere it belongs to the whole program.
    #[cfg(target_os = "linux")]
    rustix::process::setpriority_process(None, 19).ok();
}
