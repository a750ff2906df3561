//! Sweeps of a scene over a grid of its keys. Every cell is a separate run with a separate file, so
//! that a sweep can be stopped, resumed and spread over machines. See `docs/reference/sweeps.md`.
//!
//! ```no_run
//! use msd_study::sweep::{Store, Sweep};
//! let sweep = Sweep::open("cloth-sweep.toml".as_ref())?;
//! let store = Store::of(&sweep, None);
//! msd_study::sweep::run(&sweep, &store, (0..sweep.len(), 1), &mut ())?;
//! store.collect(&sweep)?.0.write("cloth.csv".as_ref(), msd_study::sweep::TableFormat::Csv)?;
//! # Ok::<(), msd_scene::FileError>(())
//! ```

mod value;
mod table;
mod measure;
mod columns;
mod file;
mod plan;
mod row;
mod store;
mod under_way;
mod fleet;
mod run;
mod task;

pub use plan::{Cell, Sweep};
pub use run::{Summary, run, run_on, unfinished};
pub use store::Store;
pub use table::{Column, Datum, Kind, Table, TableFormat};
pub use task::Task;
