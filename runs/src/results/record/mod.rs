//! The record of one run, `run.json`: its inputs, outcome, metrics, verdicts, and distance from its
//! reference run.
//!
//! Imports `files`, `input` and `metrics`, and `sim` for outcomes. The rest of `results` reads and writes
//! records.

mod comparison;
mod parameter;
mod run_record;

pub use comparison::{Comparison, Repeats, TruthError};
pub(super) use parameter::compare_values;
pub use parameter::{ParamValue, is_truth};
pub use run_record::{BUILD, InputHash, Machine, PROGRAM, RUN_SCHEMA, RunRecord, Timing, hash_input};
