//! Writes the page on a fit: tables of its results, warnings, and pictures of its signals.

use crate::files::{RecordError, atomic};
use crate::report::environment;
use crate::report::fit_plot::{FittedSignal, fitted_over_time, legend};
use crate::report::table::{Cell, Head, Part, Table};
use minijinja::Value;
use minijinja::context;
use minijinja::value::Serde;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Greatest number of pictures.
const MAX_PICTURES: usize = 60;

/// What the page on a fit shows.
#[derive(Clone, Debug, Default)]
pub struct FitPage {
    /// Name of the fit.
    pub title: String,
    /// Its description; may be empty.
    pub description: String,
    /// Class and text of each label below the title: `passed`, `failed` or another.
    pub chips: Vec<(String, String)>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Tables: title, names of columns with whether they are numbers, and rows.
    pub tables: Vec<PlainTable>,
    /// Signals to draw.
    pub signals: Vec<FittedSignal>,
}

/// A table of text.
#[derive(Clone, Debug, Default)]
pub struct PlainTable {
    /// Title.
    pub title: String,
    /// Names of the columns, and whether each has numbers.
    pub head: Vec<(String, bool)>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

/// Values of the template.
#[derive(Serialize)]
struct Page<'a> {
    title: &'a str,
    description: &'a str,
    chips: &'a [(String, String)],
    warnings: &'a [String],
    tables: Vec<(&'a str, Table)>,
    legend: Vec<(String, String)>,
    pictures: Vec<(&'a str, String)>,
    more: usize,
}

/// Writes the page.
///
/// # Errors
/// The file cannot be written, or a picture cannot be drawn.
pub fn write_fit_page(path: &Path, page: &FitPage) -> Result<(), RecordError> {
    let drawn = page.signals.iter().take(MAX_PICTURES);
    let pictures = drawn.map(|signal| Ok((signal.title.as_str(), fitted_over_time(signal)?)));
    let values = Page {
        title: &page.title,
        description: &page.description,
        chips: &page.chips,
        warnings: &page.warnings,
        tables: page.tables.iter().map(|table| (table.title.as_str(), of_plain(table))).collect(),
        legend: legend(),
        pictures: pictures.collect::<Result<_, RecordError>>()?,
        more: page.signals.len().saturating_sub(MAX_PICTURES),
    };
    let style = Value::from_safe_string(include_str!("page/style.css").to_owned());
    let html = environment()
        .and_then(|environment| {
            environment.get_template("fit.html")?.render(context! { style, ..Value::from(Serde(&values)) })
        })
        .map_err(|source| RecordError::Report { path: path.to_owned(), source: source.into() })?;
    atomic::write_named(path, atomic::OutputKind::Page, |out| {
        out.write_all(html.as_bytes()).map_err(RecordError::io(path))
    })
}

fn of_plain(table: &PlainTable) -> Table {
    let head = |(name, number): &(String, bool)| if *number { Head::number(name, "") } else { Head::text(name) };
    let cell = |(text, (_, number)): (&String, &(String, bool))| Cell {
        text: text.clone(),
        class: if *number { "n" } else { "" },
    };
    let rows = table.rows.iter().map(|row| row.iter().zip(&table.head).map(cell).collect()).collect();
    let part = Part { title: String::new(), rows };
    Table { head: table.head.iter().map(head).collect(), parts: vec![part], more: String::new() }
}
