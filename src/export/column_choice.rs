//! Chooses columns by name and by pattern.

use crate::export::export_error::ExportError;
use crate::export::log_columns::{LogColumn, TIME};
use crate::text::pattern::matches;

/// The columns that match any of the patterns, in the order of the patterns and once each; all when
/// there are none.
pub(super) fn choose<'a>(columns: Vec<LogColumn<'a>>, patterns: &[String]) -> Result<Vec<LogColumn<'a>>, ExportError> {
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
    let mut remaining: Vec<Option<LogColumn<'a>>> = columns.into_iter().map(Some).collect();
    Ok(order.into_iter().filter_map(|i| remaining[i].take()).collect())
}

/// Suggests the most similar name, or one that contains the pattern, or where to find all names.
pub(super) fn help(pattern: &str, names: &[&str]) -> String {
    const ALL: &str = "`--list-columns` shows what this log has";
    if pattern.contains(['*', '?']) {
        return format!("no column matches; {ALL}");
    }
    let distance = |name: &str| strsim::damerau_levenshtein(&pattern.to_lowercase(), &name.to_lowercase());
    // A third of the letters may differ.
    let near = names.iter().map(|n| (distance(n), n)).filter(|(d, n)| *d <= n.len().max(pattern.len()) / 3).min();
    let within = names.iter().find(|n| n.contains(pattern));
    match near.map(|(_, name)| name).or(within) {
        Some(name) => format!("did you mean `{name}`? {ALL}"),
        None => ALL.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_suggests_the_most_similar() {
        let names = ["base_x_m", "base_z_m", "sole.left.force_z_N"];
        assert!(help("base_z", &names).starts_with("did you mean `base_z_m`?"));
        assert!(help("left", &names).starts_with("did you mean `sole.left.force_z_N`?"));
        assert!(help("colour", &names).starts_with("`--list-columns`"));
        assert!(help("joint.*", &names).starts_with("no column matches"));
    }
}
