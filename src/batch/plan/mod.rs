//! Plans a batch: loads scenarios and robots, checks every run, gives each its key.
//!
//! [`planner`] makes a [`batch_plan`], of which a [`shard`] keeps a part; a [`finding`] is an error, warning or note.
//! Nothing runs and nothing is written here.

pub(in crate::batch) mod batch_plan;
pub(in crate::batch) mod finding;
pub(in crate::batch) mod planner;
pub(in crate::batch) mod robot_cache;
pub(in crate::batch) mod run_key;
pub(in crate::batch) mod shard;
