//! The msd program: a window, and a command line that works without one.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
mod cli;

/// Runs the program and returns its exit code: 0 done, 2 bad input, bad usage or a file that could
/// not be written, 3 diverged. The window exits with 1 after a loss of its graphics device or its
/// display, and saves the run first.
#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    // Silent by default: the message of an error is a single clear line.
    let environment = env_logger::Env::default().default_filter_or("off");
    env_logger::Builder::from_env(environment).init();
    let done = match <cli::Arguments as clap::Parser>::try_parse() {
        Ok(arguments) => cli::run_command(arguments),
        Err(error) => cli::explain(&error),
    };
    cli::exit_code(done)
}

/// Runs once in the page of a browser, and in each of its workers; the page starts the window, see
/// `msd_app::start`.
#[cfg(target_arch = "wasm32")]
fn main() {
    msd_app::report_panics();
}
