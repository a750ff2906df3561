//! The msd program: a window, and a command line that works without one.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
mod cli;

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    cli::run_program()
}

/// A browser starts the window from a page, see `msd_app::start`.
#[cfg(target_arch = "wasm32")]
fn main() {}
