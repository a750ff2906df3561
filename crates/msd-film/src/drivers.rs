//! Suppression of the messages that graphics drivers print on standard error.

use msd_render::{Gpu, RenderError};
use std::sync::{Mutex, PoisonError};

/// Opens a graphics device without a window, [`quietly`].
///
/// # Errors
/// See [`Gpu::headless`].
pub fn open_gpu() -> Result<Gpu, RenderError> {
    quietly(|| pollster::block_on(Gpu::headless()))
}

/// Runs `open`, which starts graphics drivers, and hides their messages on standard error.
///
/// The libraries of OpenGL and Vulkan report there each failed attempt, such as a Wayland display
/// that `XDG_RUNTIME_DIR` would name; the caller needs only the result. The messages appear with
/// `RUST_LOG` at `warn` or more, and after a panic.
pub fn quietly<T>(open: impl FnOnce() -> T) -> T {
    // One call at a time: a second one would take the file of the first for standard error.
    static ONE: Mutex<()> = Mutex::new(());
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    #[cfg(unix)]
    let _aside = if log::log_enabled!(log::Level::Warn) { None } else { aside::Aside::new().ok() };
    open()
}

#[cfg(unix)]
mod aside {
    use rustix::stdio::dup2_stderr;
    use std::fs::File;
    use std::io::{self, Seek};
    use std::os::fd::{AsFd, OwnedFd};

    /// The process's standard error, redirected to a nameless file.
    pub(super) struct Aside {
        kept: OwnedFd,
        notes: File,
    }

    impl Aside {
        pub(super) fn new() -> io::Result<Self> {
            let notes = tempfile::tempfile()?;
            let kept = io::stderr().as_fd().try_clone_to_owned()?;
            dup2_stderr(&notes)?;
            Ok(Aside { kept, notes })
        }
    }

    impl Drop for Aside {
        fn drop(&mut self) {
            // Without standard error there is nowhere to report a failure.
            dup2_stderr(&self.kept).ok();
            if std::thread::panicking() && self.notes.rewind().is_ok() {
                io::copy(&mut self.notes, &mut io::stderr()).ok();
            }
        }
    }
}
