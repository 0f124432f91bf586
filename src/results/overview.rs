//! Table of a batch for a terminal: one line per scenario.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::results::RunStatistics;
use crate::text::text_table::{Side, TextTable, significant};
use crate::text::visible::visible;

/// One line per scenario: runs, how they ended, expectations that held, simulated and processor time. A last line sums up. Scenarios with
/// implausible runs are `marked`.
pub fn overview(statistics: &RunStatistics, marked: &BTreeSet<&str>, width: usize) -> String {
    let columns = [
        ("scenario", Side::Left),
        ("runs", Side::Right),
        ("outcomes", Side::Left),
        ("held", Side::Left),
        ("sim s", Side::Right),
        ("cpu s", Side::Right),
    ];
    let mut table = TextTable::new(columns);
    for sums in statistics.scenarios() {
        // At the front, where no width clips it.
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
    let plural = if statistics.runs() == 1 { "run" } else { "runs" };
    let counted: Vec<String> = statistics.outcomes().iter().map(|(name, count)| format!("{count} {name}")).collect();
    // A String takes every write.
    let _ = write!(out, "\n{} {plural}: {}", statistics.runs(), counted.join(", "));
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
