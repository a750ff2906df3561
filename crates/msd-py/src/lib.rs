//! msd for Python: `import msd`. The classes and functions here stand in the package `msd`, whose
//! Python files are in `python/msd`.
#![forbid(unsafe_code)]
#![expect(clippy::too_many_arguments, reason = "they are keywords in Python")]

mod errors;
mod values;
mod arrays;
mod options;
mod caller;
mod run;
mod pictures;
mod scene;
mod network;
mod simulation;
mod judgement;
mod sweep;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _msd {
    #[pymodule_export]
    use super::judgement::{inspect, report, study, tune};
    #[pymodule_export]
    use super::network::{mesh, network};
    #[pymodule_export]
    use super::pictures::film;
    #[pymodule_export]
    use super::run::Simulation;
    #[pymodule_export]
    use super::run::lock::note_fork;
    #[pymodule_export]
    use super::scene::{Scene, open, scene, schema};
    #[pymodule_export]
    use super::sweep::{Sweep, run_cell, sweep};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Otherwise a step without a pool would use all cores of the machine, whose threads a
        // forked child lacks. Fails if a pool exists, after a second import.
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        drop(one.build_global());
        crate::errors::add_to(module)?;
        module.add("scenes", msd_scene::BUILTINS.map(|scene| scene.name).to_vec())?;
        module
            .add("integrators", msd_core::Integrator::ALL.map(|method| method.name()).to_vec())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
