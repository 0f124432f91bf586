//! Pairs the rows of two results that belong to the same run.

use std::collections::HashMap;

use crate::results::compare::{ResultRow, Results};

/// Pairs of rows.
pub(super) struct Pairs<'a> {
    pub matched: Vec<(&'a ResultRow, &'a ResultRow)>,
    /// Number of pairs with equal keys.
    pub by_key: usize,
    pub only_in_a: Vec<&'a ResultRow>,
    pub only_in_b: Vec<&'a ResultRow>,
}

/// Pairs rows by scenario and key; then the others by scenario, swept parameters, method,
/// integrator and seed, since keys depend on the versions of program and scenario. Rows that remain
/// ambiguous pair in their order.
pub(super) fn pair<'a>(a: &'a Results, b: &'a Results) -> Pairs<'a> {
    let mut partner: Vec<Option<usize>> = vec![None; a.rows.len()];
    let mut taken = vec![false; b.rows.len()];
    let by_key = link(a, b, &mut partner, &mut taken, |row| [row.text("scenario"), row.text("key")].join("\n"));
    link(a, b, &mut partner, &mut taken, identity);
    let rows = || a.rows.iter().zip(&partner);
    Pairs {
        matched: rows().filter_map(|(row, partner)| Some((row, &b.rows[(*partner)?]))).collect(),
        by_key,
        only_in_a: rows().filter(|(_, partner)| partner.is_none()).map(|(row, _)| row).collect(),
        only_in_b: b.rows.iter().zip(&taken).filter(|(_, taken)| !**taken).map(|(row, _)| row).collect(),
    }
}

/// Pairs the unpaired rows with equal `name`; returns the number of pairs.
fn link(
    a: &Results,
    b: &Results,
    partner: &mut [Option<usize>],
    taken: &mut [bool],
    name: impl Fn(&ResultRow) -> String,
) -> usize {
    let mut free: HashMap<String, Vec<usize>> = HashMap::new();
    for (i, row) in b.rows.iter().enumerate().rev().filter(|(i, _)| !taken[*i]) {
        free.entry(name(row)).or_default().push(i);
    }
    let mut linked = 0;
    for (row, partner) in a.rows.iter().zip(partner).filter(|(_, partner)| partner.is_none()) {
        if let Some(i) = free.get_mut(&name(row)).and_then(Vec::pop) {
            (*partner, taken[i]) = (Some(i), true);
            linked += 1;
        }
    }
    linked
}

/// Identity of a run independent of the program's version.
fn identity(row: &ResultRow) -> String {
    let own = ["scenario", "method", "integrator", "seed"].map(|name| row.text(name).to_owned());
    // Equal numbers may be written differently.
    let same = |value: &str| value.parse::<f64>().map_or(value.to_owned(), |x| format!("{x:e}"));
    let parameters = row.parameters().map(|(name, value)| format!("{name}={}", same(value)));
    own.into_iter().chain(parameters).collect::<Vec<_>>().join("\n")
}
