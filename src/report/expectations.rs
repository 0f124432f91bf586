//! The table of expectations and their results.

use crate::report::ReportRun;
use crate::report::labels::{parameters, short};
use crate::report::table::{Cell, Head, MAX_ROWS, Part, Table};
use crate::results::Verdict;
use crate::text::plural::plural;

/// Expectations that failed and those with a value; limits that held are counted in the head.
pub(super) fn expectations(runs: &[ReportRun]) -> Table {
    let all: Vec<(&ReportRun, &Verdict)> =
        runs.iter().flat_map(|run| run.row.verdicts.iter().map(move |v| (run, v))).collect();
    let mut listed: Vec<_> = all.iter().filter(|(_, v)| !v.held || v.truth.is_some()).collect();
    // Failed expectations take precedence where not all fit; all stay in order.
    if listed.len() > MAX_ROWS {
        listed.sort_by_key(|(_, v)| v.held);
        listed.truncate(MAX_ROWS);
    }
    let hidden = all.len() - listed.len();
    let heads = [
        Head::text("scenario"),
        Head::text("parameters"),
        Head::text("method"),
        Head::text("metric"),
        Head::number("measured", ""),
        Head::number("expected", ""),
        Head::number("error", ""),
        Head::number("relative", ""),
        Head::number("allowed", ""),
        Head::text("held"),
        Head::text("message"),
    ];
    Table {
        head: if listed.is_empty() { Vec::new() } else { heads.into() },
        parts: vec![Part { title: String::new(), rows: listed.into_iter().map(|(run, v)| row(run, v)).collect() }],
        more: if hidden == 0 { String::new() } else { format!("{} not shown that held", plural(hidden, "more")) },
    }
}

fn row(run: &ReportRun, v: &Verdict) -> Vec<Cell> {
    let expected = match (v.truth, v.min, v.max) {
        (Some(truth), ..) => format!("{truth:?}"),
        (None, Some(min), Some(max)) => format!("{}..{}", short(min), short(max)),
        (None, Some(min), None) => format!("≥ {}", short(min)),
        (None, None, Some(max)) => format!("≤ {}", short(max)),
        (None, None, None) => String::new(),
    };
    let relative = v.error.zip(v.truth.filter(|t| *t != 0.0)).map(|(error, truth)| (error / truth).abs());
    vec![
        Cell::text(run.row.scenario.clone()),
        Cell::text(parameters(run.row).join(" ")),
        Cell::unbroken(&run.row.method),
        Cell::text(v.metric.clone()),
        // All digits, for comparison with the expected value.
        Cell { text: v.measured.map_or_else(|| "–".to_owned(), |x| format!("{x:?}")), class: "n" },
        Cell { text: expected, class: "n" },
        Cell::number(v.error),
        Cell::number(relative),
        Cell::number(v.allowed),
        if v.held { Cell::text("yes") } else { Cell { text: "no".into(), class: "bad" } },
        Cell::text(v.message.clone()),
    ]
}
