//! The msd program: a window, and a command line that works without one.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
mod cli;

/// Runs the program and returns its exit code: 0 done, 2 bad input or usage or a file that could
/// not be written, 3 diverged. The window ends with 1 where its graphics device or its
/// display goes away; the run is saved then.
#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    // Silent unless asked: one clear line is the whole message of an error.
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
