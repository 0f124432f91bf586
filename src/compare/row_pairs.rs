//! Pairs the rows of two results that belong to the same run.

use std::collections::HashMap;

use crate::compare::columns::{RunDigest, digest};
use crate::compare::result_row::ResultRow;
use crate::compare::results::{Results, ResultsError};

/// Pairs of rows, by their positions.
pub(super) struct Pairs {
    /// For each row of A, the row of B.
    pub partner: Vec<Option<usize>>,
    /// Number of pairs with equal keys.
    pub by_key: usize,
    /// Rows of B without a row of A.
    pub only_in_b: Vec<usize>,
}

/// Pairs rows by scenario and key; then the others by scenario, swept parameters, method,
/// integrator and seed, since keys depend on the versions of program and scenario. Rows that remain
/// ambiguous pair in their order.
pub(super) fn pair(a: &mut Results, b: &mut Results) -> Result<Pairs, ResultsError> {
    let mut partner: Vec<Option<usize>> = vec![None; a.len()];
    let mut taken = vec![false; b.len()];
    let keyed = |runs: &[RunDigest]| runs.iter().copied().enumerate().collect::<Vec<_>>();
    let by_key = link(&keyed(a.runs()), &keyed(b.runs()), &mut partner, &mut taken);
    let left = |unpaired: Vec<usize>, of: &mut Results| -> Result<Vec<(usize, RunDigest)>, ResultsError> {
        let mut row = of.blank_row();
        let name = |position| of.read(position, &mut row).map(|()| (position, identity(&row)));
        unpaired.into_iter().map(name).collect()
    };
    let in_a: Vec<usize> = (0..a.len()).filter(|i| partner[*i].is_none()).collect();
    let in_b: Vec<usize> = (0..b.len()).filter(|i| !taken[*i]).collect();
    if !in_a.is_empty() && !in_b.is_empty() {
        link(&left(in_a, a)?, &left(in_b, b)?, &mut partner, &mut taken);
    }
    let only_in_b = (0..b.len()).filter(|i| !taken[*i]).collect();
    Ok(Pairs { partner, by_key, only_in_b })
}

/// Pairs the given rows with equal digests; returns the number of pairs.
fn link(
    a: &[(usize, RunDigest)],
    b: &[(usize, RunDigest)],
    partner: &mut [Option<usize>],
    taken: &mut [bool],
) -> usize {
    // Rows of B by digest: the first of each, and for each row the next one with its digest.
    let mut first: HashMap<RunDigest, usize> = HashMap::with_capacity(b.len());
    let mut next: Vec<Option<usize>> = vec![None; b.len()];
    for (i, (_, digest)) in b.iter().enumerate().rev() {
        next[i] = first.insert(*digest, i);
    }
    let mut linked = 0;
    for (row, digest) in a {
        let Some(&i) = first.get(digest) else { continue };
        match next[i] {
            Some(following) => first.insert(*digest, following),
            None => first.remove(digest),
        };
        partner[*row] = Some(b[i].0);
        taken[b[i].0] = true;
        linked += 1;
    }
    linked
}

/// Identity of a run independent of the program's version.
pub(crate) fn identity(row: &ResultRow) -> RunDigest {
    let own = ["scenario", "method", "integrator", "seed"].map(|name| row.text(name));
    identity_of(own, row.parameters())
}

/// Like [`identity`], of scenario, method, integrator and seed, and swept parameters in the order of their
/// names.
pub(crate) fn identity_of<'a>(own: [&str; 4], parameters: impl Iterator<Item = (&'a str, &'a str)>) -> RunDigest {
    let parameters = parameters.map(|(name, value)| format!("{name}={}", same_text(value)));
    let parts: Vec<String> = own.map(str::to_owned).into_iter().chain(parameters).collect();
    digest(parts.iter().map(String::as_str))
}

/// Equal numbers, which may be written differently, as equal texts.
pub(crate) fn same_text(value: &str) -> String {
    value.parse::<f64>().map_or(value.to_owned(), |x| format!("{x:e}"))
}
