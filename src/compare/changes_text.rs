//! Text of the differences for the terminal.

use std::fmt::{self, Display, Formatter};

use crate::compare::Changes;
use crate::text::text_table::{Alignment, TextTable};
use crate::text::visible::visible;

/// Number of differences that are listed.
const MAX_LISTED: usize = 50;

impl Display for Changes {
    /// Missing runs, outcomes, values beyond the tolerances, columns that differ, and counts.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let omitted = self.omitted;
        let sides = [(&self.only_in_a, omitted.only_in_a, "A"), (&self.only_in_b, omitted.only_in_b, "B")];
        for (rows, omitted, side) in sides {
            rows.iter().take(MAX_LISTED).try_for_each(|run| writeln!(f, "only in {side}: {}", visible(run)))?;
            more(f, rows.len(), omitted, "runs")?;
        }
        for change in self.outcomes.iter().take(MAX_LISTED) {
            writeln!(f, "outcome: {}: {} in A, {} in B", visible(&change.run), visible(&change.a), visible(&change.b))?;
        }
        more(f, self.outcomes.len(), omitted.outcomes, "outcomes")?;
        for change in self.claims.iter().take(MAX_LISTED) {
            writeln!(f, "claim: {}: {} in A, {} in B", visible(&change.claim), change.a, change.b)?;
        }
        more(f, self.claims.len(), 0, "claims")?;
        for change in self.searches.iter().take(MAX_LISTED) {
            writeln!(
                f,
                "search: {}: {} in A, {} in B",
                visible(&change.search),
                visible(&change.a),
                visible(&change.b)
            )?;
        }
        more(f, self.searches.len(), 0, "searches")?;
        if !self.beyond.is_empty() {
            let header = ["beyond", "run", "A", "B", "distance", "allowed"];
            let lines = self.beyond.iter().take(MAX_LISTED).map(|d| {
                let cell = |text: &str| if text.is_empty() { "-".to_owned() } else { visible(text).into_owned() };
                let distance = d.distance.map_or("-".to_owned(), |x| format!("{x:.2e}"));
                vec![
                    visible(&d.column).into_owned(),
                    visible(&d.run).into_owned(),
                    cell(&d.a),
                    cell(&d.b),
                    distance,
                    format!("{:.2e}", d.allowed),
                ]
            });
            write!(f, "{}", aligned(&header, lines))?;
            more(f, self.beyond.len(), omitted.beyond, "values")?;
        }
        if !self.columns.is_empty() {
            let header = ["column", "rows differ", "beyond", "greatest", "relative"];
            let lines = self.columns.iter().map(|c| {
                let short = |x: f64| format!("{x:.2e}");
                let (differ, beyond) = (c.differ.to_string(), c.beyond.to_string());
                vec![visible(&c.column).into_owned(), differ, beyond, short(c.greatest), short(c.greatest_relative)]
            });
            write!(f, "\n{}\n", aligned(&header, lines))?;
        }
        if !self.columns_in_one.is_empty() {
            writeln!(f, "not compared, in one of them only: {}", visible(&self.columns_in_one.join(", ")))?;
        }
        let by_key = match self.matched_by_key {
            n if n == self.matched => String::new(),
            n => format!(" ({n} by their keys)"),
        };
        let (runs, values) = (self.matched, self.beyond.len() + omitted.beyond);
        let missing = self.only_in_a.len() + omitted.only_in_a + self.only_in_b.len() + omitted.only_in_b;
        let outcomes = self.outcomes.len() + omitted.outcomes;
        let verdict = if self.is_within() { "within the tolerances" } else { "different" };
        writeln!(
            f,
            "{runs} runs compared{by_key}: {verdict}; {values} values beyond tolerance, {outcomes} outcomes changed, {missing} runs missing"
        )
    }
}

fn aligned(header: &[&str], lines: impl Iterator<Item = Vec<String>>) -> String {
    let text = if header.contains(&"run") { 2 } else { 1 };
    let side = |column: usize| if column < text { Alignment::Left } else { Alignment::Right };
    let mut table = TextTable::new(header.iter().enumerate().map(|(column, name)| (*name, side(column))));
    lines.for_each(|line| table.push(line));
    table.render(usize::MAX)
}

/// Reports the entries that are not listed: of a list of `kept`, and `omitted` ones.
fn more(f: &mut Formatter<'_>, kept: usize, omitted: usize, what: &str) -> fmt::Result {
    match (kept.saturating_sub(MAX_LISTED) + omitted, omitted) {
        (0, _) => Ok(()),
        (n, 0) => writeln!(f, "and {n} more {what}; --format json has all"),
        (n, _) => writeln!(f, "and {n} more {what}; --format json has the first {kept}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Omitted;

    #[test]
    fn entries_beyond_the_lists_are_counted() {
        let omitted = Omitted { only_in_a: 7, ..Omitted::default() };
        let changes = Changes { only_in_a: vec!["run".into(); 60], omitted, ..Changes::default() };
        let text = changes.to_string();
        assert_eq!(text.matches("only in A: run\n").count(), MAX_LISTED);
        assert!(text.contains("and 17 more runs; --format json has the first 60\n"), "{text}");
        assert!(text.ends_with("67 runs missing\n") && !changes.is_within(), "{text}");
        let json = serde_json::to_value(&changes).unwrap();
        assert_eq!(json["omitted"]["only_in_a"], 7);
        assert!(serde_json::to_value(Changes::default()).unwrap().get("omitted").is_none());
    }
}
