//! Claims about changes against a baseline: judged by the values of the same runs in both.

use crate::results::claims::claim_head::ClaimHead;
use crate::results::claims::tally::counts;
use crate::results::claims::verdict::{ClaimVerdict, Counted, verdict};
use crate::scenario::ClaimSpec;
use crate::sim::Outcome;
use serde::{Deserialize, Serialize};

/// A claim that a batch leaves to the comparison with a baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChangeClaim {
    /// Name of the scenario.
    pub scenario: String,
    /// The claim.
    pub claim: ClaimSpec,
}

/// A run in the baseline or in the results: the name of its outcome, and the value of the claim's column.
pub type RunChange<'a> = (&'a str, Option<f64>);

/// The runs of a claim that are judged together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupChanges {
    /// Values of `per`, such as `floor.friction=0.5`; empty without.
    pub label: String,
    /// Change of each run that both have, in the order of the results; none without a value.
    pub changes: Vec<Option<f64>>,
    /// Number of runs that only one of them has.
    pub unpaired: usize,
}

impl GroupChanges {
    /// Adds a run of both. A run that did not end normally, or without a value, has no change.
    pub fn push(&mut self, baseline: RunChange, result: RunChange) {
        let ended = [Outcome::Passed, Outcome::Failed, Outcome::Fallen].map(Outcome::name);
        let value = |(outcome, value): RunChange| value.filter(|_| ended.contains(&outcome));
        let change = value(result).zip(value(baseline)).map(|(result, baseline)| result - baseline);
        self.changes.push(change.filter(|change| !change.is_nan()));
    }
}

/// Judges a claim for each of its groups. Runs that only one of the results has are missing: the
/// claim holds or fails only if it does so whatever they would give.
pub fn judge_changes(claim: &ChangeClaim, groups: &[GroupChanges]) -> Vec<ClaimVerdict> {
    let head = ClaimHead { scenario: claim.scenario.clone(), claim: claim.claim.clone(), groups: Vec::new() };
    let unit = |change: &Option<f64>| {
        let value = change.map(|change| observation(&claim.claim, change));
        (value, counts(&claim.claim, value))
    };
    let judge = |group: &GroupChanges| {
        let units: Vec<_> = group.changes.iter().map(unit).collect();
        let planned = units.len() + group.unpaired;
        verdict(&head, &group.label, Counted { units, planned })
    };
    groups.iter().map(judge).collect()
}

/// The change, or for a share 1 where its limits hold and 0 where not.
fn observation(claim: &ClaimSpec, change: f64) -> f64 {
    claim.share.as_ref().map_or(change, |share| f64::from(share.check(change).is_ok()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::claims::Judgement;
    use crate::scenario::Expect;

    fn claim(quantile: Option<f64>, share: Option<Expect>, at_most: Option<f64>, at_least: Option<f64>) -> ChangeClaim {
        let change = Some("final_base_x".to_owned());
        let claim = ClaimSpec { name: "c".into(), change, quantile, share, at_most, at_least, ..ClaimSpec::default() };
        ChangeClaim { scenario: "s".into(), claim }
    }

    fn group(changes: &[f64], unpaired: usize) -> GroupChanges {
        GroupChanges { changes: changes.iter().map(|x| Some(*x)).collect(), unpaired, ..GroupChanges::default() }
    }

    #[test]
    fn five_equal_signs_show_a_median_and_missing_runs_may_undo_it() {
        // The sign test: 0.5^5 = 0.03 <= 0.05 < 0.5^4.
        let at_most = claim(None, None, Some(0.0), None);
        let of = |changes: &[f64], unpaired| judge_changes(&at_most, &[group(changes, unpaired)])[0].verdict;
        assert_eq!(of(&[-1.0; 5], 0), Judgement::Holds);
        assert_eq!(of(&[-1.0; 4], 0), Judgement::Undecided);
        assert_eq!(of(&[1.0; 5], 0), Judgement::Fails);
        assert_eq!(of(&[0.0; 5], 0), Judgement::Holds, "a change of 0 is at most 0");
        // One of six missing: 7 / 64 = 0.11. One of eight: 9 / 256 = 0.035.
        assert_eq!(of(&[-1.0; 5], 1), Judgement::Undecided);
        assert_eq!(of(&[-1.0; 7], 1), Judgement::Holds);
    }

    #[test]
    fn runs_without_a_value_count_against_the_claim() {
        let mut runs = GroupChanges::default();
        runs.push(("passed", Some(1.0)), ("failed", Some(1.5)));
        runs.push(("passed", Some(1.0)), ("diverged", Some(1.0)));
        runs.push(("passed", None), ("passed", Some(1.0)));
        runs.push(("passed", Some(f64::INFINITY)), ("fallen", Some(f64::INFINITY)));
        assert_eq!(runs.changes, [Some(0.5), None, None, None]);
        let judged = &judge_changes(&claim(None, None, Some(1.0), None), &[runs.clone()])[0];
        assert_eq!((judged.without_value, judged.used, judged.estimate), (3, 4, Some(f64::INFINITY)));
        let judged = &judge_changes(&claim(None, None, None, Some(0.0)), &[runs])[0];
        assert_eq!(judged.estimate, Some(f64::NEG_INFINITY));
    }

    #[test]
    fn a_share_of_changes_is_that_within_the_limits() {
        let share = Expect { min: Some(-0.1), max: Some(0.1), ..Expect::default() };
        let claim = claim(None, Some(share), None, Some(0.5));
        let judged = &judge_changes(&claim, &[group(&[0.0, 0.1, -0.1, 0.2, -0.2], 0)])[0];
        assert_eq!((judged.estimate, judged.verdict), (Some(0.6), Judgement::Undecided));
        let expected = "share of changes of final_base_x against the baseline from -0.1 to 0.1 at least 0.5";
        assert_eq!(judged.statement, expected);
        assert_eq!(judge_changes(&claim, &[group(&[0.05; 5], 0)])[0].verdict, Judgement::Holds);
    }
}
