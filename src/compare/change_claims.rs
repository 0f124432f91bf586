//! Judges claims about changes by the pairs of runs of a baseline and other results.

use std::collections::HashMap;

use crate::compare::CompareError;
use crate::compare::result_row::ResultRow;
use crate::compare::results::Results;
use crate::compare::row_pairs::{pair, same_text};
use crate::results::claims::{ChangeClaim, ClaimVerdict, GroupChanges, judge_changes};

/// A claim with its runs.
struct Judged {
    claim: ChangeClaim,
    /// The column is in both results.
    is_common: bool,
    groups: Vec<GroupChanges>,
    /// Positions in `groups` by label.
    positions: HashMap<String, usize>,
}

/// Judges the claims about changes of results B, which are in `claims.json` next to their rows, against
/// baseline A.
///
/// # Errors
/// A row cannot be read.
pub fn judge_change_claims(a: &mut Results, b: &mut Results) -> Result<Vec<ClaimVerdict>, CompareError> {
    let claims = b.changes().to_vec();
    if claims.is_empty() {
        return Ok(Vec::new());
    }
    let is_common = |claim: &ChangeClaim| {
        claim.claim.column().is_some_and(|column| a.position(column).is_some() && b.position(column).is_some())
    };
    let judged = |claim: ChangeClaim| {
        let is_common = is_common(&claim);
        Judged { claim, is_common, groups: Vec::new(), positions: HashMap::new() }
    };
    let mut all: Vec<Judged> = claims.into_iter().map(judged).collect();
    let pairs = pair(a, b)?;
    let mut partner_of_b: Vec<Option<usize>> = vec![None; b.len()];
    for (position, partner) in pairs.partner.iter().enumerate() {
        if let Some(partner) = partner {
            partner_of_b[*partner] = Some(position);
        }
    }
    let (mut row_a, mut row_b) = (a.blank_row(), b.blank_row());
    // The order of B is that of the plan.
    for (position, partner) in partner_of_b.into_iter().enumerate() {
        b.read(position, &mut row_b)?;
        if let Some(partner) = partner {
            a.read(partner, &mut row_a)?;
        }
        all.iter_mut().for_each(|claim| claim.add(partner.map(|_| &row_a), &row_b));
    }
    for position in (0..a.len()).filter(|position| pairs.partner[*position].is_none()) {
        a.read(position, &mut row_a)?;
        all.iter_mut().for_each(|claim| claim.add(None, &row_a));
    }
    // A scenario without runs has one verdict, from none.
    let verdicts = all.into_iter().flat_map(|mut judged| {
        if judged.groups.is_empty() {
            judged.groups.push(GroupChanges::default());
        }
        judge_changes(&judged.claim, &judged.groups)
    });
    Ok(verdicts.collect())
}

impl Judged {
    /// Adds a run with that of the baseline, or one that only one of them has.
    fn add(&mut self, baseline: Option<&ResultRow>, row: &ResultRow) {
        if row.text("scenario") != self.claim.scenario {
            return;
        }
        let claim = &self.claim.claim;
        let parts = claim.per.iter().map(|key| format!("{key}={}", value_text(row.text(key))));
        let label = parts.collect::<Vec<_>>().join(" ");
        let position = *self.positions.entry(label).or_insert_with_key(|label| {
            self.groups.push(GroupChanges { label: label.clone(), ..GroupChanges::default() });
            self.groups.len() - 1
        });
        let column = claim.column().unwrap_or("");
        match baseline.filter(|_| self.is_common) {
            Some(baseline) => {
                let [old, new] = [baseline, row].map(|row| (row.text("outcome"), row.text(column).parse().ok()));
                self.groups[position].push(old, new);
            }
            None => self.groups[position].unpaired += 1,
        }
    }
}

/// A value of `per` as both results label it: `0.5`, however it is written.
fn value_text(cell: &str) -> String {
    let number = same_text(cell).parse::<f64>().ok().filter(|x| x.is_finite());
    number.map_or_else(|| if cell.is_empty() { "unset".to_owned() } else { cell.to_owned() }, |x| x.to_string())
}
