//! One run from its job to its record.
//!
//! [`job_run`] calls [`simulate`], turns a panic into an outcome, evaluates [`expectations`], checks
//! [`plausibility`] and writes the record. [`outputs`] lists other files; [`live_clients`] observe.

pub(in crate::batch) mod awaited_reference;
pub(in crate::batch) mod expectations;
pub(in crate::batch) mod job_run;
pub(in crate::batch) mod live_clients;
pub(in crate::batch) mod outputs;
pub(in crate::batch) mod plausibility;
pub(in crate::batch) mod run_end;
pub(in crate::batch) mod run_timer;
pub(in crate::batch) mod simulate;
