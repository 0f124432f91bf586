//! The section on searches: a table of what was found, and pictures of the values that were run.

use crate::files::RecordError;
use crate::report::best_plot::best_plot;
use crate::report::boundary_plot::boundary_plot;
use crate::report::line_plot::line_plot;
use crate::report::table::{Cell, Head, MAX_ROWS, Part, Table};
use crate::results::searches::{SearchKind, SearchResult, SearchVerdict};
use crate::text::plural::plural;
use serde::Serialize;

/// Largest number of pictures.
const MAX_PICTURES: usize = 24;

/// The section.
#[derive(Debug, Default, Serialize)]
pub(super) struct Section {
    pub table: Table,
    pub pictures: Vec<Picture>,
    /// Note on omitted pictures.
    pub more: String,
}

/// The picture of a search, or of all of a scenario over one key.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub name: String,
    pub svg: String,
}

pub(super) fn section(searches: &[SearchResult]) -> Result<Section, RecordError> {
    if searches.is_empty() {
        return Ok(Section::default());
    }
    let is_over_one = |search: &SearchResult| search.search == SearchKind::Boundary && search.keys.len() == 1;
    let pictured: Vec<&[SearchResult]> =
        searches.chunk_by(|a, b| a.scenario == b.scenario && is_over_one(a) && is_over_one(b)).collect();
    let picture = |group: &&[SearchResult]| {
        let search = &group[0];
        let svg = match search.search {
            SearchKind::Boundary if is_over_one(search) => boundary_plot(group)?,
            SearchKind::Boundary => line_plot(search)?,
            _ => best_plot(search)?,
        };
        let label = if is_over_one(search) { "" } else { &search.label };
        let name = format!("{}: {} over {} {label}", search.scenario, search.goal(), search.keys.join(", "));
        Ok::<_, RecordError>(Picture { name: name.trim_end().to_owned(), svg })
    };
    let pictures = pictured.iter().take(MAX_PICTURES).map(picture).collect::<Result<Vec<_>, _>>()?;
    let more = match pictured.len() - pictures.len() {
        0 => String::new(),
        n => format!("{} without a picture here", plural(n, "more search")),
    };
    Ok(Section { table: table(searches), pictures, more })
}

fn table(searches: &[SearchResult]) -> Table {
    let head = vec![
        Head::text("search"),
        Head::text("scenario"),
        Head::text("swept values"),
        Head::text("over"),
        Head::text("of"),
        Head::text("found"),
        Head::text("holds"),
        Head::number("runs", ""),
        Head::text("result"),
    ];
    let hidden = searches.len().saturating_sub(MAX_ROWS);
    Table {
        head,
        parts: vec![Part { title: String::new(), rows: searches.iter().take(MAX_ROWS).map(row).collect() }],
        more: if hidden == 0 { String::new() } else { format!("{} in searches.json", plural(hidden, "more search")) },
    }
}

fn row(search: &SearchResult) -> Vec<Cell> {
    let class = if search.verdict == SearchVerdict::Found { "" } else { "bad" };
    let side = match search.interval.as_ref().map(|interval| interval.holds_above) {
        Some(true) => "above",
        Some(false) => "below",
        None => "",
    };
    vec![
        Cell { text: search.verdict.name().into(), class },
        Cell::text(search.scenario.clone()),
        Cell::text(search.label.clone()),
        Cell::text(search.keys.join(", ")),
        Cell::text(search.goal()),
        // All digits: they are those of the values that were run.
        Cell::text(search.found()),
        Cell::text(side.to_owned()),
        Cell::count(search.runs as u64),
        Cell::text(search.summary()),
    ]
}
