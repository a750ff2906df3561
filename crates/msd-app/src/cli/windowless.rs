//! `msd view` and `msd render` in a build without the window, where they fail with a message.

use super::arguments::{RenderArguments, ViewArguments};
use super::failure::Failure;

/// Refuses to show a scene.
pub fn view(_: ViewArguments) -> Result<(), Failure> {
    refuse("has no window")
}

/// Refuses to draw a scene.
pub fn render(_: &RenderArguments) -> Result<(), Failure> {
    refuse("cannot render")
}

fn refuse(what: &str) -> Result<(), Failure> {
    Err(Failure::input(format!("this build of msd {what}: build it with the default features")))
}
