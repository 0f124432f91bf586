//! Columns by name and by pattern.

use crate::export::ExportError;
use crate::export::columns::{Column, TIME};
use crate::text::pattern::matches;

/// The columns that match any of the patterns, in the order of the patterns and once each; all when there are none.
pub(super) fn choose<'a>(columns: Vec<Column<'a>>, patterns: &[String]) -> Result<Vec<Column<'a>>, ExportError> {
    if patterns.is_empty() {
        return Ok(columns);
    }
    let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
    let mut order: Vec<usize> = Vec::new();
    for pattern in patterns {
        let found: Vec<usize> = (0..names.len()).filter(|i| matches(pattern, names[*i])).collect();
        if found.is_empty() && !matches(pattern, TIME) {
            return Err(ExportError::UnknownColumn { name: pattern.clone(), help: help(pattern, &names) });
        }
        order.extend(found);
    }
    let mut left: Vec<Option<Column<'a>>> = columns.into_iter().map(Some).collect();
    Ok(order.into_iter().filter_map(|i| left[i].take()).collect())
}

/// The nearest name, or names that contain what was asked for, or where to find them all.
pub(super) fn help(wanted: &str, names: &[&str]) -> String {
    const ALL: &str = "`--list-columns` shows what this log has";
    if wanted.contains(['*', '?']) {
        return format!("no column is like that; {ALL}");
    }
    let distance = |name: &str| strsim::damerau_levenshtein(&wanted.to_lowercase(), &name.to_lowercase());
    // A third of the letters may be wrong.
    let near = names.iter().map(|n| (distance(n), n)).filter(|(d, n)| *d <= n.len().max(wanted.len()) / 3).min();
    let within = names.iter().find(|n| n.contains(wanted));
    match near.map(|(_, name)| name).or(within) {
        Some(name) => format!("did you mean `{name}`? {ALL}"),
        None => ALL.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_none_is_answered_with_the_nearest() {
        let names = ["base_x_m", "base_z_m", "sole.left.force_z_N"];
        assert!(help("base_z", &names).starts_with("did you mean `base_z_m`?"));
        assert!(help("left", &names).starts_with("did you mean `sole.left.force_z_N`?"));
        assert!(help("colour", &names).starts_with("`--list-columns`"));
        assert!(help("joint.*", &names).starts_with("no column is like that"));
    }
}
