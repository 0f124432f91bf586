//! `--resume`: finds runs whose results are in the folder, and why the others must run.

pub(in crate::batch) mod rerun_reason;
pub(in crate::batch) mod resumed;
