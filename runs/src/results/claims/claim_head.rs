//! A claim with its planned units, as shards list them.

use crate::scenario::ClaimSpec;
use serde::{Deserialize, Serialize};

/// A claim about the runs of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClaimHead {
    /// Name of the scenario.
    pub scenario: String,
    /// The claim.
    pub claim: ClaimSpec,
    /// Its groups, each with a verdict of its own.
    pub groups: Vec<GroupHead>,
}

/// A group of runs that is judged alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroupHead {
    /// The values of `per`; may be empty.
    pub label: String,
    /// Number of planned units: runs, or pairs of runs.
    pub planned: usize,
}

/// The part of a run in a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunClaim {
    /// Index of the claim.
    pub claim: usize,
    /// Index of the group.
    pub group: usize,
    /// Position of the unit in the group, in the order of the plan.
    pub unit: usize,
    /// 0, or 1 for the second run of a pair.
    pub side: usize,
}
