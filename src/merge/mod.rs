//! Merges shards into the folder of results that a single batch would have written.
//!
//! The `shard.jsonl` of each shard lists its runs with their indices in the plan. All checks come
//! before any write: the shards belong to one plan, none is missing, every run has its record, and
//! copies of one run are equal. Lists and records are read one by one, so memory grows by 8 bytes per
//! run.
//!
//! Imports: `input`, `sim`, `files`, `results`. Used by: `cli`.

mod copy_run;
mod merge_error;
mod merged;
mod missing;
mod missing_logs;
mod plan_walk;
mod record_difference;
mod references;
mod searches;
mod shard_check;
mod shards;
mod twins;

pub use merge_error::MergeError;
pub use merged::Merged;
pub use missing::Missing;
pub use shards::Shards;
