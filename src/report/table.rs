//! Tables of the page.

use crate::report::ReportRun;
use crate::report::units::{is_said, unit};
use crate::report::words::short;
use serde::Serialize;

/// Rows of a table, at the most.
pub(super) const MOST_ROWS: usize = 1000;

/// A table in parts with a heading each.
#[derive(Debug, Default, Serialize)]
pub(super) struct Table {
    pub head: Vec<Head>,
    pub parts: Vec<Part>,
    /// What is left out, in words.
    pub more: String,
}

/// The head of a column.
#[derive(Debug, Serialize)]
pub(super) struct Head {
    /// Its name, in the pieces between which a line may break.
    pub pieces: Vec<String>,
    pub unit: &'static str,
    /// Right-aligned?
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
    /// Of words.
    pub fn text(name: &str) -> Self {
        Self { pieces: vec![name.to_owned()], unit: "", number: false }
    }

    /// Of numbers of a unit.
    pub fn number(name: &str, unit: &'static str) -> Self {
        Self { pieces: vec![name.to_owned()], unit, number: true }
    }

    /// Of a column of the summary, under its name; most names say their units.
    pub fn column(name: &str) -> Self {
        let says_unit = is_said(name);
        // A unit stays with the word before it.
        let mut pieces: Vec<String> = name.split_inclusive('_').map(str::to_owned).collect();
        if says_unit && pieces.len() > 1 {
            let end = pieces.pop().unwrap_or_default();
            pieces.iter_mut().next_back().into_iter().for_each(|last| last.push_str(&end));
        }
        Self { pieces, unit: if says_unit { "" } else { unit(name) }, number: true }
    }
}

impl Cell {
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), class: "" }
    }

    /// A word that is not to be broken.
    pub fn word(word: &str) -> Self {
        Self { text: word.to_owned(), class: "word" }
    }

    /// A number in three digits; none is a dash.
    pub fn number(x: Option<f64>) -> Self {
        Self { text: x.map_or_else(|| "–".to_owned(), short), class: "n" }
    }

    /// A whole number.
    pub fn count(n: u64) -> Self {
        Self { text: n.to_string(), class: "n" }
    }
}

/// Positions of the runs that a table has room for, in order: of too many all that ended as they should not, before the
/// first others; and what is left out in words.
pub(super) fn bounded(runs: &[ReportRun]) -> (Vec<usize>, String) {
    let mut order: Vec<usize> = (0..runs.len()).collect();
    // Stable: both kinds stay in order.
    order.sort_by_key(|&i| !runs[i].is_refused());
    order.truncate(MOST_ROWS);
    order.sort_unstable();
    let more = match runs.len() - order.len() {
        0 => String::new(),
        left => format!("{left} more runs are in summary.csv; shown are those that went wrong and the first others"),
    };
    (order, more)
}
