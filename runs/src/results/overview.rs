//! Table of a batch for a terminal: one line per scenario.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::results::RunStatistics;
use crate::text::plural::plural;
use crate::text::text_table::{Alignment, TextTable, significant};
use crate::text::visible::visible;

/// One line per scenario: runs, how they ended, expectations that held, simulated and processor
/// time. The last line gives the totals. Scenarios with implausible runs are `marked`.
pub fn overview(statistics: &RunStatistics, marked: &BTreeSet<&str>, width: usize) -> String {
    let columns = [
        ("scenario", Alignment::Left),
        ("runs", Alignment::Right),
        ("outcomes", Alignment::Left),
        ("held", Alignment::Left),
        ("sim s", Alignment::Right),
        ("cpu s", Alignment::Right),
    ];
    let mut table = TextTable::new(columns);
    for sums in statistics.scenarios() {
        // In front of the name, where clipping keeps it.
        let mark = if marked.contains(sums.scenario.as_str()) { "! " } else { "" };
        table.push(vec![
            format!("{mark}{}", visible(&sums.scenario)),
            sums.runs.to_string(),
            outcomes(&sums.outcomes),
            if sums.expected == 0 { "-".to_owned() } else { format!("{} of {}", sums.held, sums.expected) },
            significant(sums.simulated_s, 3),
            significant(sums.cpu_s, 3),
        ]);
    }
    let mut out = table.render(width);
    let counted: Vec<String> = statistics.outcomes().iter().map(|(name, count)| format!("{count} {name}")).collect();
    // A String takes every write.
    let _ = write!(out, "\n{}: {}", plural(statistics.runs(), "run"), counted.join(", "));
    let (held, expected) = statistics.expectations();
    if expected > 0 {
        let _ = write!(out, "; {held} of {expected} expectations held");
    }
    out.push('\n');
    out
}

/// `passed`, or `11 passed, 1 failed`
fn outcomes(counts: &[(&'static str, usize)]) -> String {
    match counts {
        [(name, _)] => (*name).to_owned(),
        several => several.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", "),
    }
}
