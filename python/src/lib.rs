//! Native module of the Python package `stiction`.
//!
//! | file | content |
//! |---|---|
//! | `scenario_file` | scenarios from files, texts and dictionaries; their runs and diagnostics |
//! | `batch_run` | batches, as `runner run` executes them |
//! | `table` | summaries, time series and events as columns and Arrow streams |
//! | `simulation`, `stepped`, `state` | one run, stepped; how far it is; its motion and contacts |
//! | `checkpoint` | saved states |
//! | `batch` | many simulations, stepped in parallel |
//! | `callables` | Python functions as tasks and force models |
//! | `arrays`, `values` | NumPy arrays; conversion of other values |
//! | `errors` | exceptions, which `stiction/_errors.py` defines |
//!
//! Long work releases the interpreter's lock.

mod arrays;
mod batch;
mod batch_run;
mod callables;
mod checkpoint;
mod errors;
mod scenario_file;
mod simulation;
mod state;
mod stepped;
mod table;
mod values;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Executes the command `runner` with these arguments; returns its exit code. `launcher` is the path of
/// the program that starts it again.
#[pyfunction]
fn main(py: Python<'_>, launcher: PathBuf, arguments: Vec<OsString>) -> u8 {
    py.detach(|| stiction::cli::main_of_launcher(launcher, arguments) as u8)
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::batch::Batch;
    #[pymodule_export]
    use super::batch_run::run;
    #[pymodule_export]
    use super::callables::{JointCommand, TaskContext};
    #[pymodule_export]
    use super::checkpoint::Checkpoint;
    #[pymodule_export]
    use super::main;
    #[pymodule_export]
    use super::scenario_file::{ScenarioFile, check, runs};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::state::{Contact, State};
    #[pymodule_export]
    use super::table::{Table, columns, events, report, series, summary};

    /// Version of the package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
