//! Graphics drivers, with their notes kept off the standard error.

use msd_render::{Gpu, RenderError};
use std::sync::{Mutex, PoisonError};

/// Opens a graphics device without a window, [`quietly`].
///
/// # Errors
/// See [`Gpu::headless`].
pub fn open_gpu() -> Result<Gpu, RenderError> {
    quietly(|| pollster::block_on(Gpu::headless()))
}

/// Runs `open`, which starts graphics drivers, without what these print on the standard error.
///
/// The libraries of OpenGL and Vulkan write there what they tried and did not find, such as the
/// Wayland display that `XDG_RUNTIME_DIR` would name; what matters is in the result. With
/// `RUST_LOG` at `warn` or more their notes appear, and after a panic as well.
pub fn quietly<T>(open: impl FnOnce() -> T) -> T {
    // One at a time: a second one would take the file of the first for the standard error.
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

    /// The standard error of the process, put aside for a file without a name.
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
            // Without a standard error there is nobody to tell.
            dup2_stderr(&self.kept).ok();
            if std::thread::panicking() && self.notes.rewind().is_ok() {
                io::copy(&mut self.notes, &mut io::stderr()).ok();
            }
        }
    }
}
