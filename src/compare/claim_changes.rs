//! Compares the verdicts of claims that two results have.

use serde::Serialize;

use crate::compare::Results;
use crate::results::claims::ClaimVerdict;

/// A claim with different verdicts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClaimChange {
    /// Scenario and name of the claim.
    pub claim: String,
    /// In A.
    pub a: &'static str,
    /// In B.
    pub b: &'static str,
}

/// Claims of both results with different verdicts, in the order of A. Claims are in `claims.json` next
/// to the rows.
pub(super) fn claim_changes(a: &Results, b: &Results) -> Vec<ClaimChange> {
    let (a, b) = (a.claims(), b.claims());
    let identity = |claim: &ClaimVerdict| (claim.scenario.clone(), claim.claim.clone(), claim.group.clone());
    let change = |first: &ClaimVerdict| {
        let second = b.iter().find(|other| identity(other) == identity(first))?;
        let claim = format!("{}: {}", first.scenario, first.name());
        (first.verdict != second.verdict).then(|| ClaimChange {
            claim,
            a: first.verdict.name(),
            b: second.verdict.name(),
        })
    };
    a.iter().filter_map(change).collect()
}
