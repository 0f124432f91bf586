//! Runs many simulations in parallel: plan, execution, expectations, progress, results.
//!
//! ```text
//! files -> prepare -> Plan -> workers (a pool of threads)      -> Events -> dispatcher -> results
//!                          -> repetitions (one thread, timing) ->
//! ```
//!
//! [`prepare`] checks everything before anything runs. [`Batch::run`] runs the jobs. Worker threads
//! simulate, write the files of their runs and append to `runs.jsonl`; the dispatcher alone prints
//! and collects the rows in the order of the plan. It knows live clients by the trait
//! [`LiveClients`] only.
//!
//! Imports: `geometry`, `text`, `input`, `robot`, `terrain`, `contact`, `sim`, `scenario`, `files`,
//! `convert`, `script`, `log`, `assemble`, `results`, `remote`, `search`. Used by: `report`,
//! `replay`, `api`, `cli`, `console`, `fit`.

mod batch_error;
mod dispatch;
mod filter;
mod message;
mod options;
mod plan;
mod report;
mod resume;
mod run;
mod runner;

pub use crate::text::Severity;
pub use batch_error::BatchError;
pub use dispatch::cancellation::{Cancellation, Reason};
pub use dispatch::listener::{Listener, NoListener};
pub use dispatch::progress::Progress;
pub use filter::{Filter, Selection};
pub use message::junit::{Junit, is_slow};
pub use message::{
    BatchFinished, BatchStarted, CheckFinished, DiagnosticMessage, MESSAGE_SCHEMA, Message, MessageWriter,
    message_schema,
};
pub use options::Options;
pub use plan::batch_plan::{Job, Plan, Role};
pub use plan::finding::{Finding, Findings};
pub use plan::planner::{DEFAULT_TIME_LIMIT, Overrides, prepare, prepare_loaded, prepare_within};
pub use plan::shard::{Part, Shard, ShardError};
pub use report::{Finished, PageText, Report, ShownResults};
pub use resume::resumed::{Rerun, Resumed};
pub use run::live_clients::LiveClients;
pub use run::outputs::{Body, RunOutputs, Track};
pub use run::plausibility::marks_implausible;
pub use run::run_end::RunEnd;
pub use run::simulate::{
    Scene, open_log, open_log_of, simulate, simulate_with_clients, simulate_with_command_source, topics,
};
pub use runner::{Batch, Interrupter, on_threads};
