//! `msd view`: a scene in the window.

use super::arguments::{SolverArguments, Step, ViewArguments};
use super::failure::Failure;
use super::places::Places;
use super::run::prepare::{FRAME, Prepared, link, prepare};
use msd_app::{Missing, ViewError};
use msd_scene::{Loaded, shown_path};
use std::path::PathBuf;

/// Exit code after a loss of the graphics device.
const LOST: u8 = 1;

/// Shows a scene in a window until it is closed.
pub fn view(ViewArguments { scene, set, solver }: ViewArguments) -> Result<(), Failure> {
    let scene = scene.unwrap_or_else(|| {
        // The file may no longer exist.
        let last = msd_app::last_scene().filter(|last| msd_scene::open(last).is_ok());
        last.unwrap_or(msd_scene::BUILTINS[0].name.into()).into()
    });
    if let Some(link) = link(&scene)?
        && solver == SolverArguments::default()
        && set.set.is_empty()
    {
        return msd_app::view_link(&link).map_err(failure);
    }
    // With options of its own, it is a run that continues, instead of the scene of that name.
    let is_set = !set.set.is_empty();
    let mut loaded = if solver == SolverArguments::default() && !is_set {
        msd_scene::open(&scene).map_err(Failure::input)?
    } else {
        let frame = if solver.step == Some(Step::Auto) { FRAME } else { 0.0 };
        into_loaded(prepare((&scene, &set), &solver, ("--step", frame))?)
    };
    let mut places = Places::of(&loaded.files, solver.from.as_deref());
    if is_set {
        // The file no longer matches, and must not be saved or linked instead.
        loaded.files.clear();
    }
    let status = std::env::var_os("MSD_STATUS").map(PathBuf::from);
    status.iter().try_for_each(|status| places.write("MSD_STATUS", status))?;
    msd_app::view_as(loaded, &shown_path(&scene)).map_err(failure)
}

/// Converts a prepared run for the window.
fn into_loaded(prepared: Prepared) -> Loaded {
    let Prepared { name, title, notes, files, made, camera, runner, .. } = prepared;
    Loaded { notes, files, made, camera, ..runner.to_loaded(&name, &title) }
}

/// Returns the failure of a window that could not be opened, or that ended by itself.
fn failure(error: ViewError) -> Failure {
    let failure = Failure::input(&error);
    let is_lost = matches!(error.what, Missing::Device(_));
    if is_lost { Failure { code: LOST, ..failure } } else { failure }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::arguments::SetArguments;
    use msd_core::Integrator;
    use msd_run::Runner;
    use msd_scene::Precision;
    use std::path::Path;

    #[test]
    fn the_window_opens_what_the_command_line_asks_for() {
        let solver = SolverArguments {
            integrator: Some(Integrator::Rk4),
            step: Some(Step::Auto),
            precision: Some(Precision::F64),
            ..SolverArguments::default()
        };
        let prepared =
            prepare((Path::new("cube"), &SetArguments::default()), &solver, ("--step", FRAME));
        let prepared = prepared.unwrap_or_else(|failure| panic!("{}", failure.message));
        let stable = prepared.stable;
        let runner = Runner::open(&into_loaded(prepared)).expect("a valid scene");
        let settings = runner.settings();
        assert_eq!((settings.integrator, runner.precision()), (Integrator::Rk4, Precision::F64));
        // Whole steps of a frame, as few as fit within nine tenths.
        let count = FRAME / settings.step;
        assert!((count - count.round()).abs() < 1e-9, "{count}");
        let most = FRAME / (count - 1.0);
        assert!(settings.step <= 0.91 * stable && 0.89 * stable < most && runner.is_automatic());
    }
}
