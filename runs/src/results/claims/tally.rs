//! Counts the observations of claims in the order of the plan.

use crate::results::claims::change_claim::ChangeClaim;
use crate::results::claims::claim_head::{ClaimHead, RunClaim};
use crate::results::claims::verdict::{ClaimVerdict, Counted, verdict};
use crate::results::{SummaryRow, metric};
use crate::scenario::ClaimSpec;
use crate::sim::Outcome;
use crate::statistics::{Rule, ShareTest};

use std::collections::BTreeMap;

/// Observations of all claims of a plan.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    heads: Vec<ClaimHead>,
    /// By claim and group.
    groups: Vec<Vec<GroupTally>>,
}

/// A unit of which a run is known. A value is none for a run that gave none.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unit {
    /// One run of a pair.
    Half(usize, Option<f64>),
    Known(Option<f64>),
}

/// Observations of a group.
#[derive(Clone, Debug)]
struct GroupTally {
    planned: usize,
    /// Known units by their positions. A map, since heads of shards may state any number of units.
    units: BTreeMap<usize, Unit>,
    /// Number of units at the beginning that are known, up to the decision.
    prefix: usize,
    /// Of these, the units that count for the share.
    counted: usize,
    decided: bool,
}

impl Tally {
    /// Begins without observations.
    pub fn new(heads: Vec<ClaimHead>) -> Self {
        let group = |planned| GroupTally { planned, units: BTreeMap::new(), prefix: 0, counted: 0, decided: false };
        let groups = heads.iter().map(|head| head.groups.iter().map(|g| group(g.planned)).collect()).collect();
        Tally { heads, groups }
    }

    /// True if there are no claims.
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// Adds a finished run; true if it decides a claim that is judged early. A cancelled run has no
    /// result and is ignored, as are parts that the claims do not have.
    pub fn add(&mut self, part: RunClaim, row: &SummaryRow) -> bool {
        let Some(head) = self.heads.get(part.claim).filter(|_| row.outcome != Outcome::Cancelled) else { return false };
        let group = self.groups[part.claim].get_mut(part.group);
        let Some(group) = group.filter(|group| part.unit < group.planned) else { return false };
        let claim = &head.claim;
        let value = observation(claim, row);
        let unit = match (group.units.get(&part.unit), claim.difference.is_some()) {
            (Some(&Unit::Half(side, other)), true) if side != part.side => {
                let (first, second) = if side == 0 { (other, value) } else { (value, other) };
                let difference = first.zip(second).map(|(first, second)| first - second);
                Unit::Known(difference.filter(|difference| !difference.is_nan()))
            }
            (Some(_), _) => return false,
            (None, true) => Unit::Half(part.side, value),
            (None, false) => Unit::Known(value),
        };
        group.units.insert(part.unit, unit);
        claim.early && group.advance(claim)
    }

    /// True unless the claim is judged early and was decided without this part of a run.
    pub fn needs(&self, part: RunClaim) -> bool {
        let group = self.groups.get(part.claim).and_then(|groups| groups.get(part.group));
        group.is_none_or(|group| !group.decided || part.unit < group.prefix)
    }

    /// The claims that need a baseline, in the order of the plan.
    pub fn changes(&self) -> Vec<ChangeClaim> {
        let changes = self.heads.iter().filter(|head| head.claim.change.is_some());
        changes.map(|head| ChangeClaim { scenario: head.scenario.clone(), claim: head.claim.clone() }).collect()
    }

    /// The verdicts of the other claims, in the order of the plan. Groups without planned units are left
    /// out, unless the claim has no other.
    pub fn verdicts(&self) -> Vec<ClaimVerdict> {
        let mut verdicts = Vec::new();
        for (head, groups) in self.heads.iter().zip(&self.groups).filter(|(head, _)| head.claim.change.is_none()) {
            let all = head.groups.iter().zip(groups);
            let planned = all.clone().filter(|(group, _)| group.planned > 0);
            let mut own: Vec<ClaimVerdict> = planned.map(|(group, tally)| tally.verdict(head, &group.label)).collect();
            if own.is_empty() {
                own.extend(all.take(1).map(|(_, tally)| tally.verdict(head, "")));
            }
            verdicts.append(&mut own);
        }
        verdicts
    }
}

impl GroupTally {
    /// Extends the prefix of known units up to the decision; true if it is reached.
    fn advance(&mut self, claim: &ClaimSpec) -> bool {
        let (question, test) = (claim.question(), ShareTest { rule: Rule::Sequential, alpha: 1.0 - claim.confidence });
        while let (false, Some(Unit::Known(value))) = (self.decided, self.units.get(&self.prefix)) {
            self.prefix += 1;
            self.counted += usize::from(counts(claim, *value));
            let (n, k, q) = (self.prefix, self.counted, question.threshold);
            self.decided = test.shows_at_least(n, k, q) || test.shows_at_most(n, k, q);
            if self.decided {
                return true;
            }
        }
        false
    }

    fn verdict(&self, head: &ClaimHead, label: &str) -> ClaimVerdict {
        // A claim that is judged early is about the first units, another one about all.
        let used = if head.claim.early { self.prefix } else { self.planned };
        let values = self.units.range(..used).filter_map(|(_, unit)| match unit {
            Unit::Known(value) => Some((*value, counts(&head.claim, *value))),
            _ => None,
        });
        verdict(head, label, Counted { units: values.collect(), planned: self.planned })
    }
}

/// Whether a unit counts for the share of the claim. Without a value it counts against the claim.
pub(super) fn counts(claim: &ClaimSpec, value: Option<f64>) -> bool {
    match value {
        None => !claim.question().at_least,
        Some(value) if claim.share.is_some() => value == 1.0,
        Some(value) => claim.counts(value),
    }
}

/// What a run gives a claim: the value of the column, or 1 where the condition of the share holds
/// and 0 where not; none for a run that did not end normally, unless the claim names that outcome.
fn observation(claim: &ClaimSpec, row: &SummaryRow) -> Option<f64> {
    let outcome = row.outcome.name();
    let is_named = claim.share.as_ref().is_some_and(|share| share.outcome.is_some_and(|named| named.name() == outcome));
    if !is_named && !matches!(row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen) {
        return None;
    }
    match &claim.share {
        Some(share) => Some(f64::from(share.judge(outcome, |name| metric(row, name)).is_ok())),
        None => claim.column().and_then(|column| metric(row, column)).filter(|value| !value.is_nan()),
    }
}
