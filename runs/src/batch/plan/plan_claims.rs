//! The claims of a plan: the part of each run in them, in the order of the plan of all shards.

use std::collections::HashMap;
use std::sync::Arc;

use crate::batch::plan::batch_plan::Source;
use crate::results::claims::{ClaimHead, GroupHead, RunClaim};
use crate::scenario::PlannedClaim;

/// The claims of a plan.
#[derive(Clone, Debug, Default)]
pub(in crate::batch) struct PlanClaims {
    pub heads: Vec<ClaimHead>,
    /// By claim.
    runs: Vec<ClaimRuns>,
}

/// The runs of one claim.
#[derive(Clone, Debug)]
struct ClaimRuns {
    /// Position of its scenario among the sources.
    source: usize,
    /// Group, unit and side of each run of the source by its number.
    parts: Vec<Option<(u32, u32, bool)>>,
}

impl PlanClaims {
    /// Claims about all runs of the sources.
    pub fn of_all(sources: &[Arc<Source>]) -> Self {
        Self::new(sources, &|_, _| true)
    }

    /// Claims about the selected runs of the sources, by source and number. A claim whose scenario
    /// has no selected run is left out.
    pub fn new(sources: &[Arc<Source>], is_selected: &dyn Fn(usize, usize) -> bool) -> Self {
        let mut all = PlanClaims::default();
        for (index, source) in sources.iter().enumerate() {
            for claim in source.expansion.claims() {
                let runs = source.expansion.runs();
                let selected = (0..runs).filter(|number| is_selected(index, *number));
                if selected.clone().next().is_none() {
                    continue;
                }
                let (groups, parts) = parts(claim, selected, runs);
                all.heads.push(ClaimHead { scenario: source.name.clone(), claim: claim.spec.clone(), groups });
                all.runs.push(ClaimRuns { source: index, parts });
            }
        }
        all
    }

    /// The parts of a run in claims, by its source and number.
    pub fn of_run(&self, source: usize, number: usize) -> impl Iterator<Item = RunClaim> {
        let own = self.runs.iter().enumerate().filter(move |(_, claim)| claim.source == source);
        own.filter_map(move |(claim, runs)| {
            let (group, unit, second) = runs.parts.get(number).copied().flatten()?;
            Some(RunClaim { claim, group: group as usize, unit: unit as usize, side: usize::from(second) })
        })
    }
}

/// The groups of a claim, and the part of each run in it. A pair is a unit at the position of its
/// later run; a run without the other one has no part.
#[expect(clippy::type_complexity)]
fn parts(
    claim: &PlannedClaim,
    selected: impl Iterator<Item = usize>,
    runs: usize,
) -> (Vec<GroupHead>, Vec<Option<(u32, u32, bool)>>) {
    let mut groups: Vec<GroupHead> =
        claim.groups.iter().map(|label| GroupHead { label: label.clone(), planned: 0 }).collect();
    let mut parts = vec![None; runs];
    let mut halves: HashMap<usize, (usize, bool)> = HashMap::new();
    for number in selected {
        let Some(place) = claim.place(number) else { continue };
        let other = match claim.is_paired() {
            true => match halves.remove(&place.unit) {
                Some(other) => Some(other),
                None => {
                    halves.insert(place.unit, (number, place.side == 1));
                    continue;
                }
            },
            false => None,
        };
        let group = &mut groups[place.group];
        let unit = group.planned as u32;
        group.planned += 1;
        parts[number] = Some((place.group as u32, unit, place.side == 1));
        if let Some((first, second)) = other {
            parts[first] = Some((place.group as u32, unit, second));
        }
    }
    (groups, parts)
}
