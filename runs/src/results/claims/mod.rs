//! Judges the claims of scenarios by the rows of their runs.
//!
//! - `change_claim`: claims about changes against a baseline.
//! - `claim_head`: a claim with its planned units, and the part of a run in it.
//! - `tally`: observations in the order of the plan, and when they decide a claim.
//! - `verdict`: the result of a claim, its bounds and their history.
//! - `claims_file`: `claims.json`; `claim_table`: lines for the terminal.
//!
//! Only the order of the plan counts: the verdict is the same for any order in which runs end.

mod change_claim;
mod claim_head;
mod claim_table;
mod claims_file;
mod tally;
mod verdict;

pub use change_claim::{ChangeClaim, GroupChanges, RunChange, judge_changes};
pub use claim_head::{ClaimHead, GroupHead, RunClaim};
pub use claim_table::claim_table;
pub use claims_file::{CLAIMS_SCHEMA, read_claims, write_claims};
pub use tally::Tally;
pub use verdict::{ClaimVerdict, Judgement, TracePoint};
