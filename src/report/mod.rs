//! `report.html`: a batch on one page, without network and without scripts.
//!
//! | section | file |
//! |---|---|
//! | what was run, where and when | [`head`] |
//! | error over cost | [`work`], drawn by [`plot_work`] |
//! | residuals | [`residuals`] |
//! | runs over time, from their logs | [`pictures`], drawn by [`plot_run`] |
//! | expectations | [`expectations`] |
//! | all runs, notes, files | [`runs`] |
//!
//! Names, messages and paths are other people's text: the templates escape all of it. The page is bounded however many
//! runs there are, and says what it leaves out.

mod canvas;
mod expectations;
mod head;
mod history;
mod palette;
mod pictures;
mod plot_run;
mod plot_work;
mod residuals;
mod runs;
mod table;
mod ticks;
mod units;
mod utc;
mod words;
mod work;

use crate::files::names;
use crate::files::{RecordError, atomic};
use crate::results::pareto::Work;
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
    /// Its row of the summary.
    pub row: &'a SummaryRow,
    /// Program and version that made it.
    pub program: &'a str,
    /// Where it was made.
    pub machine: &'a Machine,
    /// What else there is to tell a person.
    pub notes: &'a [String],
    /// Its files: `run.json`, and what else it left.
    pub files: &'a [PathBuf],
}

impl<'a> ReportRun<'a> {
    /// A run read from its record, with its row.
    pub fn found(row: &'a SummaryRow, found: &'a FoundRun) -> Self {
        let RunRecord { program, timing, notes, .. } = &found.record;
        ReportRun { row, program, machine: &timing.machine, notes, files: &found.files }
    }

    fn file(&self, name: &str) -> Option<&Path> {
        self.files.iter().map(PathBuf::as_path).find(|path| path.file_name().is_some_and(|n| n == name))
    }

    fn is_refused(&self) -> bool {
        self.row.is_refused()
    }
}

/// Runs whose course over time is shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Pictured {
    /// Those that ended as they should not, and the first others, as far as they have logs; a few.
    #[default]
    Few,
    /// The runs of these keys.
    Keys(Vec<String>),
}

/// Writes the report on runs, in the order given, and on the references they were compared with. Paths in it are shown from
/// `results`, the folder of the records.
///
/// A log that cannot be read is said so in the page.
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
    runs.iter().for_each(|run| statistics.add(run.row, run.program, run.machine, run.file(names::RUN_RECORD)));
    write_report_of(path, results, (runs, &statistics), references, pictured)
}

/// The same for some of the runs, beside what there is to say of all.
///
/// # Errors
/// See [`write_report`].
pub fn write_report_of(
    path: &Path,
    results: &Path,
    (runs, statistics): (&[ReportRun], &RunStatistics),
    references: &[ReportRun],
    pictured: &Pictured,
) -> Result<(), RecordError> {
    let page = page(results, (runs, statistics), references, pictured)?;
    let html = render(&page).map_err(|source| RecordError::Report { path: path.to_owned(), source })?;
    let fill = |out: &mut BufWriter<File>| out.write_all(html.as_bytes()).map_err(RecordError::io(path));
    // What stands in the folder of results is replaced, not followed.
    if path.parent() == Some(results) {
        atomic::write(path, fill)
    } else {
        atomic::write_named(path, atomic::Made::Page, fill)
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
) -> Result<(), RecordError> {
    let rows = |runs: &[FoundRun]| runs.iter().map(|run| run.record.summary_row()).collect::<Vec<_>>();
    let (run_rows, reference_rows) = (rows(runs), rows(references));
    let (runs, references) = (found_runs(&run_rows, runs), found_runs(&reference_rows, references));
    write_report_of(path, results, (&runs, statistics), &references, &Pictured::Few)
}

/// Runs read from their records, with their rows.
pub fn found_runs<'a>(rows: &'a [SummaryRow], found: &'a [FoundRun]) -> Vec<ReportRun<'a>> {
    rows.iter().zip(found).map(|(row, found)| ReportRun::found(row, found)).collect()
}

/// What the template is filled with.
#[derive(Serialize)]
struct Page {
    head: head::Overview,
    /// What is said of too many runs.
    left_out: String,
    work: work::Section,
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
    pictured: &Pictured,
) -> Result<Page, RecordError> {
    let works: Vec<Work> = runs.iter().map(|run| Work::of(run.row)).collect();
    Ok(Page {
        head: head::head(statistics),
        left_out: left_out(statistics.runs() - runs.len()),
        work: work::work(&works)?,
        residuals: residuals::residuals(runs),
        pictures: pictures::pictures(runs, pictured)?,
        expectations: expectations::expectations(runs),
        runs: runs::runs(runs, &works),
        references: runs::references(references),
        notes: runs::notes(runs),
        files: runs::files(results, runs, references),
    })
}

fn left_out(runs: usize) -> String {
    match runs {
        0 => String::new(),
        n => format!(
            "{n} more runs are counted here and stand in summary.csv and summary.parquet; what follows is of the others: \
             those that went wrong and the first"
        ),
    }
}

/// The templates, by names that say that they are to be escaped.
const TEMPLATES: [(&str, &str); 2] =
    [("report.html", include_str!("report.html")), ("table.html", include_str!("table.html"))];

fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Lines that hold nothing but a block leave nothing behind.
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
    let style = Value::from_safe_string(include_str!("style.css").to_owned());
    environment()?.get_template("report.html")?.render(context! { style, ..Value::from(Serde(page)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_sheet_knows_every_colour() {
        let style = include_str!("style.css");
        for colour in palette::ALL.into_iter().flatten() {
            for attribute in ["fill", "stroke"] {
                assert!(style.contains(&format!("[{attribute}=\"{colour}\"]")), "{attribute} {colour}");
            }
        }
    }
}
