//! Tables of the page.

use crate::metrics::{names_unit, unit};
use crate::report::ReportRun;
use crate::report::labels::short;
use serde::Serialize;

/// Greatest number of rows of a table.
pub(super) const MAX_ROWS: usize = 1000;

/// A table in parts, each with a heading.
#[derive(Debug, Default, Serialize)]
pub(super) struct Table {
    pub head: Vec<Head>,
    pub parts: Vec<Part>,
    /// Note on omitted rows.
    pub more: String,
}

/// The head of a column.
#[derive(Debug, Serialize)]
pub(super) struct Head {
    /// Its name, in pieces between which a line may break.
    pub pieces: Vec<String>,
    pub unit: &'static str,
    /// True for a right-aligned column.
    pub number: bool,
}

/// Rows under a heading.
#[derive(Debug, Serialize)]
pub(super) struct Part {
    /// May be empty.
    pub title: String,
    pub rows: Vec<Vec<Cell>>,
}

/// A cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Cell {
    pub text: String,
    /// A class of the style sheet, or none.
    pub class: &'static str,
}

impl Head {
    /// A column of text.
    pub fn text(name: &str) -> Self {
        Self { pieces: vec![name.to_owned()], unit: "", number: false }
    }

    /// A column of numbers with a unit.
    pub fn number(name: &str, unit: &'static str) -> Self {
        Self { pieces: vec![name.to_owned()], unit, number: true }
    }

    /// A column of the summary. Its unit is added where the name lacks it.
    pub fn column(name: &str) -> Self {
        let has_unit = names_unit(name);
        // No line break before a unit.
        let mut pieces: Vec<String> = name.split_inclusive('_').map(str::to_owned).collect();
        if has_unit && pieces.len() > 1 {
            let end = pieces.pop().unwrap_or_default();
            pieces.iter_mut().next_back().into_iter().for_each(|last| last.push_str(&end));
        }
        Self { pieces, unit: if has_unit { "" } else { unit(name) }, number: true }
    }
}

impl Cell {
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), class: "" }
    }

    /// Text without line breaks.
    pub fn unbroken(text: &str) -> Self {
        Self { text: text.to_owned(), class: "word" }
    }

    /// A number to three digits; none is a dash.
    pub fn number(x: Option<f64>) -> Self {
        Self { text: x.map_or_else(|| "–".to_owned(), short), class: "n" }
    }

    /// A whole number.
    pub fn count(n: u64) -> Self {
        Self { text: n.to_string(), class: "n" }
    }
}

/// Positions of the runs of a table, in order, and a note on the omitted ones. Failed runs take
/// precedence where not all fit.
pub(super) fn bounded(runs: &[ReportRun]) -> (Vec<usize>, String) {
    let mut order: Vec<usize> = (0..runs.len()).collect();
    // A stable sort keeps both kinds in order.
    order.sort_by_key(|&i| !runs[i].is_refused());
    order.truncate(MAX_ROWS);
    order.sort_unstable();
    let more = match runs.len() - order.len() {
        0 => String::new(),
        omitted => {
            format!("{omitted} more runs are in summary.csv; this table has the failed ones and the first others")
        }
    };
    (order, more)
}
