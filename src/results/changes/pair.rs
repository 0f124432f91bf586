//! Which rows of two results are the same run.

use std::collections::HashMap;

use crate::results::changes::{Results, Row};

/// Rows side by side.
pub(super) struct Pairs<'a> {
    pub matched: Vec<(&'a Row, &'a Row)>,
    /// How many of them have one key.
    pub by_key: usize,
    pub only_in_a: Vec<&'a Row>,
    pub only_in_b: Vec<&'a Row>,
}

/// By scenario and key; what is left by scenario, swept parameters, method, integrator and seed, since another version of
/// the program or another edition of the scenario has other keys. Where that still leaves several they pair in their order.
pub(super) fn pair<'a>(a: &'a Results, b: &'a Results) -> Pairs<'a> {
    let mut partner: Vec<Option<usize>> = vec![None; a.rows.len()];
    let mut taken = vec![false; b.rows.len()];
    let by_key = link(a, b, &mut partner, &mut taken, |row| [row.text("scenario"), row.text("key")].join("\n"));
    link(a, b, &mut partner, &mut taken, nature);
    let rows = || a.rows.iter().zip(&partner);
    Pairs {
        matched: rows().filter_map(|(row, partner)| Some((row, &b.rows[(*partner)?]))).collect(),
        by_key,
        only_in_a: rows().filter(|(_, partner)| partner.is_none()).map(|(row, _)| row).collect(),
        only_in_b: b.rows.iter().zip(&taken).filter(|(_, taken)| !**taken).map(|(row, _)| row).collect(),
    }
}

/// Pairs rows that are still alone and that `name` calls the same; returns how many.
fn link(
    a: &Results,
    b: &Results,
    partner: &mut [Option<usize>],
    taken: &mut [bool],
    name: impl Fn(&Row) -> String,
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

/// What a run is, whatever program made it.
fn nature(row: &Row) -> String {
    let own = ["scenario", "method", "integrator", "seed"].map(|name| row.text(name).to_owned());
    // A number has several writings.
    let same = |value: &str| value.parse::<f64>().map_or(value.to_owned(), |x| format!("{x:e}"));
    let parameters = row.parameters().map(|(name, value)| format!("{name}={}", same(value)));
    own.into_iter().chain(parameters).collect::<Vec<_>>().join("\n")
}
