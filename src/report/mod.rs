//! Writes `report.html`: a batch on one page, without network access and scripts.
//!
//! | section | file |
//! |---|---|
//! | runs, machines and dates | `head` |
//! | searches | `searches`, drawn by `boundary_plot`, `line_plot`, `best_plot` |
//! | claims | `claims`, drawn by `claim_plot` |
//! | history of results | `history`, drawn by `history_plot` |
//! | error over cost | `cost_section`, drawn by `cost_plot` |
//! | residuals | `residuals` |
//! | runs over time, from their logs | `pictures`, drawn by `run_plot` |
//! | expectations | `expectations` |
//! | all runs, notes, files | `runs` |
//!
//! `fit_page` writes the page on a fit, whose signals `fit_plot` draws. All are drawn on a `canvas`, with the axes of
//! `chart`.
//!
//! Names, messages and paths are untrusted text: the templates escape all of it. The size of the
//! page is bounded for any number of runs, and the page states what it omits.
//!
//! Imports: `math`, `text`, `metrics`, `contact`, `sim`, `files`, `log`, `results`, `batch`,
//! `history`. Used by: `replay`, `api`, `cli`, `fit`.

mod axis;
mod batch_page;
mod best_plot;
mod boundary_plot;
mod canvas;
mod chart;
mod claim_plot;
mod claims;
mod cost_plot;
mod cost_section;
mod expectations;
mod fit_page;
mod fit_plot;
mod head;
mod history;
mod history_plot;
mod labels;
mod line_plot;
mod palette;
mod pictures;
mod residuals;
mod rewrite;
mod run_history;
mod run_plot;
mod runs;
mod searches;
mod table;

pub use batch_page::batch_page;
pub use fit_page::{FitPage, PlainTable, write_fit_page};
pub use fit_plot::FittedSignal;
pub use history::ShownHistory;
pub use rewrite::rewrite_results;

use crate::files::names;
use crate::files::{RecordError, atomic, modified};
use crate::results::claims::ClaimVerdict;
use crate::results::pareto::Work;
use crate::results::searches::SearchResult;
use crate::results::{FoundRun, Machine, RunRecord, RunStatistics, SummaryRow};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, State, UndefinedBehavior, Value, context};
use serde::Serialize;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A run as the report shows it.
#[derive(Clone, Copy, Debug)]
pub struct ReportRun<'a> {
    /// Row of the summary.
    pub row: &'a SummaryRow,
    /// Program with its version, and machine; none for rows of a table.
    pub origin: Option<(&'a str, &'a Machine)>,
    /// Further notes for the user.
    pub notes: &'a [String],
    /// Files of the run: `run.json`, log and problems.
    pub files: &'a [PathBuf],
}

impl<'a> ReportRun<'a> {
    /// A run read from its record, with its row.
    pub fn found(row: &'a SummaryRow, found: &'a FoundRun) -> Self {
        let RunRecord { program, timing, notes, .. } = &found.record;
        ReportRun { row, origin: Some((program, &timing.machine)), notes, files: &found.files }
    }

    /// A run of which only the row is known.
    pub fn of_row(row: &'a SummaryRow) -> Self {
        ReportRun { row, origin: None, notes: &[], files: &[] }
    }

    fn file(&self, name: &str) -> Option<&Path> {
        self.files.iter().map(PathBuf::as_path).find(|path| path.file_name().is_some_and(|n| n == name))
    }

    fn is_refused(&self) -> bool {
        self.row.is_refused()
    }
}

/// Selection of runs to draw over time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Pictured {
    /// A few runs with logs: failed ones, then the first others.
    #[default]
    Few,
    /// The runs of these keys.
    Keys(Vec<String>),
}

/// What the report shows of a batch as a whole.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShownBatch<'a> {
    /// Results of claims.
    pub claims: &'a [ClaimVerdict],
    /// Results of searches.
    pub searches: &'a [SearchResult],
    /// Earlier results.
    pub history: Option<ShownHistory<'a>>,
    /// Files of the folder that are still being written.
    pub pending: &'a [&'static str],
}

/// Writes the report on runs, in the given order, and on their reference runs. Paths on the page
/// are relative to `results`, the folder of the records. The page names logs that cannot be read.
///
/// # Errors
/// The file cannot be written, or a picture cannot be drawn.
pub fn write_report(
    path: &Path,
    results: &Path,
    runs: &[ReportRun],
    references: &[ReportRun],
    pictured: &Pictured,
) -> Result<(), RecordError> {
    let mut statistics = RunStatistics::default();
    runs.iter().for_each(|run| statistics.add(run.row, run.origin, run.file(names::RUN_RECORD).and_then(modified)));
    write_report_of(path, results, (runs, &statistics), references, (pictured, ShownBatch::default()))
}

/// Writes the report on a sample of the runs, with the statistics of all and of the batch.
///
/// # Errors
/// See [`write_report`].
pub fn write_report_of(
    path: &Path,
    results: &Path,
    (runs, statistics): (&[ReportRun], &RunStatistics),
    references: &[ReportRun],
    batch: (&Pictured, ShownBatch),
) -> Result<(), RecordError> {
    publish_report(path, results, &report_html(path, results, (runs, statistics), references, batch)?)
}

/// The text that [`write_report_of`] writes to `path`.
///
/// # Errors
/// A picture cannot be drawn.
fn report_html(
    path: &Path,
    results: &Path,
    (runs, statistics): (&[ReportRun], &RunStatistics),
    references: &[ReportRun],
    batch: (&Pictured, ShownBatch),
) -> Result<String, RecordError> {
    let page = page(results, (runs, statistics), references, batch)?;
    render(&page).map_err(|source| RecordError::Report { path: path.to_owned(), source: source.into() })
}

/// Writes the text of a report.
///
/// # Errors
/// The file cannot be written.
fn publish_report(path: &Path, results: &Path, html: &str) -> Result<(), RecordError> {
    let fill = |out: &mut BufWriter<File>| out.write_all(html.as_bytes()).map_err(RecordError::io(path));
    // A link in the folder of results is replaced, not followed.
    if path.parent() == Some(results) {
        atomic::write(path, fill)
    } else {
        atomic::write_named(path, atomic::OutputKind::Page, fill)
    }
}

/// Writes the report on a sample of runs read from their records, with the statistics of all.
///
/// # Errors
/// See [`write_report`].
pub fn write_report_of_found(
    path: &Path,
    results: &Path,
    (runs, statistics): (&[FoundRun], &RunStatistics),
    references: &[FoundRun],
    batch: ShownBatch,
) -> Result<(), RecordError> {
    let rows = |runs: &[FoundRun]| runs.iter().map(|run| run.record.summary_row()).collect::<Vec<_>>();
    let (run_rows, reference_rows) = (rows(runs), rows(references));
    let (runs, references) = (found_runs(&run_rows, runs), found_runs(&reference_rows, references));
    write_report_of(path, results, (&runs, statistics), &references, (&Pictured::Few, batch))
}

/// Runs read from their records, with their rows.
pub fn found_runs<'a>(rows: &'a [SummaryRow], found: &'a [FoundRun]) -> Vec<ReportRun<'a>> {
    rows.iter().zip(found).map(|(row, found)| ReportRun::found(row, found)).collect()
}

/// Values of the template.
#[derive(Serialize)]
struct Page {
    head: head::Overview,
    /// Note on runs that are only counted.
    left_out: String,
    searches: searches::Section,
    claims: claims::Section,
    history: history::Section,
    work: cost_section::Section,
    residuals: table::Table,
    pictures: pictures::Section,
    expectations: table::Table,
    runs: table::Table,
    references: table::Table,
    notes: Vec<String>,
    files: (Vec<String>, usize),
}

fn page(
    results: &Path,
    (runs, statistics): (&[ReportRun], &RunStatistics),
    references: &[ReportRun],
    (pictured, batch): (&Pictured, ShownBatch),
) -> Result<Page, RecordError> {
    let scenarios = statistics.scenarios().iter().map(|own| own.scenario.clone()).collect();
    let works: Vec<Work> = runs.iter().map(|run| Work::of(run.row)).collect();
    Ok(Page {
        head: head::head(statistics),
        left_out: left_out(statistics.runs() - runs.len()),
        searches: searches::section(batch.searches)?,
        claims: claims::section(batch.claims)?,
        history: history::section(batch.history, &scenarios, batch.claims)?,
        work: cost_section::sections(&works)?,
        residuals: residuals::residuals(runs),
        pictures: pictures::pictures(runs, pictured)?,
        expectations: expectations::expectations(runs),
        runs: runs::runs(runs, &works),
        references: runs::references(references),
        notes: runs::notes(runs),
        files: runs::files(results, runs, references, batch.pending),
    })
}

fn left_out(runs: usize) -> String {
    match runs {
        0 => String::new(),
        n => format!(
            "{n} more runs are counted here and listed in summary.csv and summary.parquet; the following shows the others: \
             failed runs and the first ones"
        ),
    }
}

/// Templates by name; the extension `html` enables escaping.
const TEMPLATES: [(&str, &str); 3] = [
    ("report.html", include_str!("page/report.html")),
    ("fit.html", include_str!("page/fit.html")),
    ("table.html", include_str!("page/table.html")),
];

fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Lines with nothing but a block leave no empty line.
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    for (name, source) in TEMPLATES {
        environment.add_template(name, source)?;
    }
    environment.add_filter("table", |state: &State, table: Value| {
        let html = state.env().get_template("table.html")?.render(context! { table })?;
        Ok::<_, minijinja::Error>(Value::from_safe_string(html))
    });
    Ok(environment)
}

fn render(page: &Page) -> Result<String, minijinja::Error> {
    let style = Value::from_safe_string(include_str!("page/style.css").to_owned());
    environment()?.get_template("report.html")?.render(context! { style, ..Value::from(Serde(page)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_sheet_has_every_colour() {
        let style = include_str!("page/style.css");
        for colour in palette::ALL.into_iter().flatten() {
            for attribute in ["fill", "stroke"] {
                assert!(style.contains(&format!("[{attribute}=\"{colour}\"]")), "{attribute} {colour}");
            }
        }
    }
}
