//! Text of results against a baseline for the terminal.

use std::fmt::{self, Display, Formatter};

use crate::history::append::Appended;
use crate::history::baseline::{Compared, Overview, ResultChanges};
use crate::history::series::{HistoryChanges, Series};
use crate::results::claims::claim_table;
use crate::text::plural::plural;
use crate::text::text_table::{Alignment, TextTable, significant};
use crate::text::visible::visible;

/// Number of series that are listed.
const MAX_LISTED: usize = 50;

/// Digits of a value.
const DIGITS: usize = 9;

impl Display for Compared {
    /// The differences of each result, and of several an overview.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (index, result) in self.results.iter().enumerate() {
            let air = if index > 0 { "\n" } else { "" };
            writeln!(f, "{air}A: {}\nB: {}", visible(&self.baseline), visible(&result.results))?;
            write!(f, "{result}")?;
        }
        if self.results.len() > 1 {
            write!(f, "\n{}{}", results_table(&self.results), self.overview)?;
        }
        Ok(())
    }
}

impl Display for ResultChanges {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.is_compared {
            true => write!(f, "{}", self.changes)?,
            false => writeln!(f, "not compared: the history has no other results")?,
        }
        if let Some(history) = &self.history {
            write!(f, "{history}")?;
        }
        if !self.claims.is_empty() {
            write!(f, "\n{}\n", claim_table(&self.claims, usize::MAX))?;
        }
        match &self.appended {
            None => Ok(()),
            Some(Appended::Known { label, date }) => {
                let title = label.as_ref().unwrap_or(date);
                writeln!(f, "not appended: the history has this result as {}", visible(title))
            }
            Some(Appended::New { results, rows, removed }) => {
                let removed = if *removed == 0 { String::new() } else { format!(", {removed} old ones removed") };
                writeln!(
                    f,
                    "appended: the history has {} of {}{removed}",
                    plural(*results, "result"),
                    plural(*rows, "run")
                )
            }
        }
    }
}

impl Display for HistoryChanges {
    /// Series with a change or trend, and counts.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let is_listed = |series: &&Series| series.is_changed || series.trend.is_some_and(|trend| trend.is_shown);
        let listed: Vec<&Series> = self.series.iter().filter(is_listed).collect();
        if !listed.is_empty() {
            let left = |name| (name, Alignment::Left);
            let right = |name| (name, Alignment::Right);
            let header = ["value", "last", "median", "spread", "values", "trend p"].map(right);
            let mut table = TextTable::new([left("history"), left("run")].into_iter().chain(header));
            listed.iter().take(MAX_LISTED).for_each(|series| table.push(line(series)));
            write!(f, "\n{}\n", table.render(usize::MAX))?;
        }
        if listed.len() > MAX_LISTED {
            writeln!(f, "and {} more series; --format json has all", listed.len() - MAX_LISTED)?;
        }
        let (results, varied) = (plural(self.results, "result"), self.series.len() + self.omitted);
        let tests = plural(self.tested, "test");
        writeln!(
            f,
            "{results} in the history: {varied} series vary, {} do not; {} at the level {} of {tests}",
            self.constant,
            plural(self.trends, "trend"),
            self.level
        )
    }
}

fn line(series: &Series) -> Vec<String> {
    let number = |x: f64| significant(x, DIGITS);
    let trend = match series.trend {
        None => "-".to_owned(),
        Some(trend) => {
            let direction = if trend.s > 0 { "rises" } else { "falls" };
            format!("{:.1e}{}", trend.p, if trend.is_shown { format!(" {direction}") } else { String::new() })
        }
    };
    vec![
        visible(&series.column).into_owned(),
        visible(&series.run).into_owned(),
        series.value.map_or_else(|| "-".to_owned(), number),
        number(series.last),
        number(series.median),
        format!("{:.2e}", series.spread),
        series.values.to_string(),
        trend,
    ]
}

/// A line per result.
fn results_table(results: &[ResultChanges]) -> String {
    let left = [("verdict", Alignment::Left), ("results", Alignment::Left)];
    let right = ["runs", "values", "outcomes", "missing", "trends", "claims"].map(|name| (name, Alignment::Right));
    let mut table = TextTable::new(left.into_iter().chain(right));
    for result in results {
        let (changes, omitted) = (&result.changes, result.changes.omitted);
        let missing = changes.only_in_a.len() + omitted.only_in_a + changes.only_in_b.len() + omitted.only_in_b;
        let verdict = match (result.is_compared, result.is_within) {
            (false, _) => "not compared",
            (true, true) => "within",
            (true, false) => "different",
        };
        table.push(vec![
            verdict.to_owned(),
            visible(&result.results).into_owned(),
            changes.matched.to_string(),
            (changes.beyond.len() + omitted.beyond).to_string(),
            (changes.outcomes.len() + omitted.outcomes).to_string(),
            missing.to_string(),
            result.history.as_ref().map_or_else(|| "-".to_owned(), |history| history.trends.to_string()),
            result.claims.len().to_string(),
        ]);
    }
    format!("{}\n", table.render(usize::MAX))
}

impl Display for Overview {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if !self.columns.is_empty() {
            let right = ["results", "rows beyond", "greatest"].map(|name| (name, Alignment::Right));
            let mut table = TextTable::new([("column", Alignment::Left)].into_iter().chain(right));
            for column in &self.columns {
                let (results, beyond) = (column.results.to_string(), column.beyond.to_string());
                let greatest = format!("{:.2e}", column.greatest);
                table.push(vec![visible(&column.column).into_owned(), results, beyond, greatest]);
            }
            write!(f, "\n{}\n", table.render(usize::MAX))?;
        }
        writeln!(f, "{} compared: {} within the tolerances", plural(self.results, "result"), self.within)
    }
}
