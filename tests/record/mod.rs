//! Tests of the results of runs: written, then read back, partly by other libraries.

mod layout;
mod log;
mod log_values;
mod pareto;
mod problems;
mod read_log;
mod report;
mod run;
mod salvage;
pub mod sample;
mod summary;
mod wire;
