//! Distributes the jobs of a plan over threads and orders what they report.
//!
//! [`schedule`] hands out work; [`workers`] and [`repetitions`] do it. [`dispatcher`] receives
//! their [`event`]s, prints [`progress`] and calls the [`listener`]. [`cancellation`] ends runs;
//! [`finished_runs`] stores results, and [`claim_watch`] judges claims by them,
//! and [`search_watch`] chooses further runs.

pub(in crate::batch) mod cancellation;
pub(in crate::batch) mod claim_watch;
pub(in crate::batch) mod dispatcher;
pub(in crate::batch) mod event;
pub(in crate::batch) mod finished_runs;
pub(in crate::batch) mod listener;
pub(in crate::batch) mod progress;
pub(in crate::batch) mod repetitions;
pub(in crate::batch) mod schedule;
pub(in crate::batch) mod search_watch;
pub(in crate::batch) mod workers;
