//! Plans a batch: loads scenarios and robots, checks every run, gives each its key.
//!
//! [`planner`] builds a [`batch_plan`] from what [`run_check`] finds in parallel; a [`shard`] is a
//! part of it. A [`finding`] is an error, warning or note. Planning runs nothing and writes nothing.

pub(in crate::batch) mod batch_plan;
pub(in crate::batch) mod finding;
pub(in crate::batch) mod input_hashes;
pub(in crate::batch) mod plan_claims;
pub(in crate::batch) mod plan_search;
pub(in crate::batch) mod planner;
pub(in crate::batch) mod robot_cache;
mod run_check;
mod run_key;
pub(in crate::batch) mod shard;
