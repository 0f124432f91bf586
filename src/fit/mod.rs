//! Fits parameters of a scenario to recorded data by least squares over runs.
//!
//! ```text
//! fit file -> data + scenario -> runs with trial values -> residuals -> estimates, intervals, checks
//!
//! r_i = (simulated_i - measured_i) / sigma_i         minimize |r|^2 / 2
//! cov = (J^T J)^-1,  J = dr / dp                     chi^2 = |r|^2 ~ chi-square with n - p
//! ```
//!
//! - `fit_file`, `format`: the file and its checks. `recording`: logs and tables. `experiment`: a
//!   data set with the run that repeats it, sampled at the recorded instants (`frame_recorder`).
//! - `problem`: residuals of all runs, which are simulated in parallel and summed in order.
//! - `least_squares`: the search. `identifiability`: what the data determine. `estimate`: estimates,
//!   intervals and checks (`results`).
//! - `summary_text`, `result_files`: output.
//!
//! Imports: `math`, `text`, `input`, `robot`, `sim`, `statistics`, `scenario`, `files`, `log`,
//! `assemble`, `report`, `export`, `batch`. Used by: `cli`.

mod estimate;
mod experiment;
mod fit_file;
mod format;
mod frame_recorder;
mod identifiability;
mod least_squares;
mod problem;
mod recording;
mod result_files;
mod results;
mod summary_text;
mod units;

pub use estimate::FitError;
pub use fit_file::FitFile;
pub use format::{FitSpec, schema};
pub use problem::{Fit, Parameter};
pub use recording::{Channel, Recording};
pub use result_files::{ResultFiles, write};
pub use results::{Agreement, ChannelResult, DataResult, Direction, Estimate, ParameterResult, Status};
pub use summary_text::summary;
