//! Claims: guarantees of their tests by exact enumeration, and verdicts of batches.

mod batches;
mod coverage;
mod outputs;
