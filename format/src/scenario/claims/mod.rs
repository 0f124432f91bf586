//! `[[claim]]`: reads the claims of a file, and finds the runs that each is about.
//!
//! - `read`: decodes and checks claims against the sweep.
//! - `units`: the units of a claim (runs or pairs) and their groups, by the numbers of runs.

mod read;
mod units;

pub(super) use read::read;
pub use units::{ClaimPlace, PlannedClaim};
