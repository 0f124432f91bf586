//! Tests of batches without execution of runs.

mod filter;
