//! `runner report`: rewrites summary and page from the records, or writes the page of a table.

use std::path::{Path, PathBuf};

use crate::compare::read_table;
use crate::files::{OutputKind, RecordError, check_replaceable, names};
use crate::history::History;
use crate::report::{Pictured, ReportRun, ShownBatch, ShownHistory, rewrite_results, write_report_of};
use crate::results::pareto::{Work, pareto_table};
use crate::results::{Listing, ResultsLock, SummaryRow, list_records};
use crate::text::visible::{visible_lines, visible_path};
use clap::Args;

use crate::cli::Exit;
use crate::cli::terminal::{complain, complain_of, plural, print, width};

/// Arguments of `report`.
#[derive(Args, Debug)]
pub struct Report {
    /// Folder of results; all run.json files below it are read. Or a table with the columns of summary.csv, which
    /// another program may have written: then only the page is written
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Keys of runs to plot over time, or their beginnings [default: failed runs and a few others]
    #[arg(long, value_name = "KEY", num_args = 1..)]
    runs: Vec<String>,
    /// A history of results to show, a file that `runner compare --append` wrote [default: history.parquet in RESULTS, or
    /// next to the table, if there is one]
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// File of the page [default: report.html in RESULTS, or next to the table]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Report {
    /// Reads the records and rewrites summary and page.
    pub fn execute(self) -> Result<Exit, Exit> {
        let fail = |error: RecordError| {
            complain_of(error);
            Exit::Invalid
        };
        if let Some(page) = &self.output {
            check_replaceable(page, OutputKind::Page).map_err(fail)?;
        }
        if self.results.is_file() {
            return self.of_table();
        }
        // Until the page is written: a batch would change the records, and write its own.
        let _lock = ResultsLock::alone(&self.results).map_err(fail)?;
        let listing = list_records(&self.results).map_err(fail)?;
        listing.skipped.iter().for_each(|error| complain(&format!("warning: passed over: {error}")));
        if listing.runs() == 0 {
            complain_of(format!("no record of a run below {}", self.results.display()));
            return Err(Exit::Invalid);
        }
        let unwritten = |error: RecordError| {
            complain_of(&error);
            Exit::of_writing(&error)
        };
        let read = listing.runs() + listing.references.len();
        complain(&format!("{} read, {} passed over", plural(read, "record"), listing.skipped.len()));
        let (selected, pictured) = self.pictured(&listing)?;
        let history = self.read_history(&self.results)?;
        let page = self.output.unwrap_or_else(|| self.results.join(names::REPORT));
        let (files, rows) = rewrite_results(&self.results, &listing, &selected, (&page, &pictured, history.as_ref()))
            .map_err(unwritten)?;
        print_written(&rows, &[&files.csv, &files.parquet, &page])
    }

    /// Reads the rows of a table and writes the page.
    fn of_table(self) -> Result<Exit, Exit> {
        if !self.runs.is_empty() {
            complain_of(format!("--runs draws logs, which the table {} does not have", self.results.display()));
            return Err(Exit::Invalid);
        }
        let table = read_table(&self.results).map_err(|error| {
            complain_of(error);
            Exit::Invalid
        })?;
        for (outcome, rows) in &table.passed_over {
            let rows = plural(*rows, "row");
            complain(&format!("{rows} with the outcome `{}` passed over", visible_lines(outcome)));
        }
        if table.rows.is_empty() {
            complain_of(format!("no row of a run in {}", self.results.display()));
            return Err(Exit::Invalid);
        }
        complain(&format!("{} read", plural(table.statistics.runs(), "row")));
        let folder = self.results.parent().unwrap_or(Path::new("")).to_owned();
        let history = self.read_history(&folder)?;
        let page = self.output.unwrap_or_else(|| folder.join(names::REPORT));
        let shown: Vec<ReportRun> = table.rows.iter().map(ReportRun::of_row).collect();
        let history = history.as_ref().map(|history| ShownHistory { history, changes: &[] });
        let shown_batch = ShownBatch { history, ..ShownBatch::default() };
        let runs = (&shown[..], &table.statistics);
        let written = write_report_of(&page, &folder, runs, &[], (&Pictured::Few, shown_batch));
        written.map_err(|error| {
            complain_of(&error);
            Exit::of_writing(&error)
        })?;
        print_written(&table.rows, &[&page])
    }

    /// The history that is named, or else in `folder`.
    fn read_history(&self, folder: &Path) -> Result<Option<History>, Exit> {
        let beside = Some(folder.join(names::HISTORY)).filter(|path| path.is_file());
        let read = self.history.clone().or(beside).map(|path| History::read(&path)).transpose();
        read.map_err(|error| {
            complain_of(error);
            Exit::Invalid
        })
    }

    /// Positions and keys of the runs that the arguments name; each argument must match a run.
    fn pictured(&self, listing: &Listing) -> Result<(Vec<usize>, Pictured), Exit> {
        if self.runs.is_empty() {
            return Ok((Vec::new(), Pictured::Few));
        }
        let (mut places, mut keys) = (Vec::new(), Vec::new());
        for typed in &self.runs {
            let before = places.len();
            for place in listing.with_key_prefix(typed) {
                let (key, log) = listing.key_and_log(place);
                if log.is_none() {
                    let scenario = listing.scenario(place);
                    complain(&format!("warning: {scenario} {key} left no log: there is nothing to show"));
                }
                keys.push(key.to_owned());
                places.push(place);
            }
            if places.len() == before {
                complain_of(format!("no run has a key that begins with `{typed}`; the summary has them all"));
                return Err(Exit::Invalid);
            }
        }
        Ok((places, Pictured::Keys(keys)))
    }
}

/// Prints accuracy over cost, and the paths written.
fn print_written(rows: &[SummaryRow], paths: &[&PathBuf]) -> Result<Exit, Exit> {
    let accuracy = pareto_table(&rows.iter().map(Work::of).collect::<Vec<_>>(), width());
    let air = if accuracy.is_empty() { "" } else { "\n" };
    let written: Vec<String> = paths.iter().map(|path| format!("  {}\n", visible_path(path))).collect();
    print(&format!("{}{air}written:\n{}", visible_lines(&accuracy), written.concat()))?;
    Ok(Exit::Success)
}
