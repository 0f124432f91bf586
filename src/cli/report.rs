//! `runner report`: summary and page from the records.

use std::path::PathBuf;

use clap::Args;
use stiction::record::pareto::{Work, pareto_table};
use stiction::record::{
    FoundRun, Pictured, RecordError, Records, ReportRun, SummaryRow, read_records, write_report, write_summary,
};

use super::Exit;
use super::terminal::{complain, plural, print};

/// Arguments of `report`.
#[derive(Args, Debug)]
pub struct Report {
    /// Folder of results; every run.json below it is read
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Keys of runs to show over time, or their beginnings [default: those that went wrong and a few more]
    #[arg(long, value_name = "KEY", num_args = 1..)]
    runs: Vec<String>,
    /// Where the page goes [default: report.html in RESULTS]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Report {
    /// Reads the records, and writes summary and page anew.
    pub fn execute(self) -> Result<Exit, Exit> {
        let fail = |error: RecordError| {
            complain(&format!("error: {error}"));
            Exit::Invalid
        };
        let records = read_records(&self.results).map_err(fail)?;
        records.skipped.iter().for_each(|error| complain(&format!("warning: passed over: {error}")));
        if records.runs.is_empty() {
            complain(&format!("error: no record of a run below {}", self.results.display()));
            return Err(Exit::Invalid);
        }
        let read = records.runs.len() + records.references.len();
        complain(&format!("{} read, {} passed over", plural(read, "record"), records.skipped.len()));
        let pictured = self.pictured(&records)?;
        let (rows, reference_rows) = (rows(&records.runs), rows(&records.references));
        let unwritten = |error: RecordError| {
            complain(&format!("error: {error}"));
            Exit::of_writing(&error)
        };
        let files = write_summary(&self.results, &rows).map_err(unwritten)?;
        let runs = as_reported(&rows, &records.runs);
        let references = as_reported(&reference_rows, &records.references);
        let page = self.output.unwrap_or_else(|| self.results.join("report.html"));
        write_report(&page, &self.results, &runs, &references, &pictured).map_err(unwritten)?;
        let accuracy = pareto_table(&rows.iter().map(Work::of).collect::<Vec<_>>());
        let air = if accuracy.is_empty() { "" } else { "\n" };
        let written: Vec<String> =
            [&files.csv, &files.parquet, &page].iter().map(|path| format!("  {}\n", path.display())).collect();
        print(&format!("{accuracy}{air}written:\n{}", written.concat()))?;
        Ok(Exit::Success)
    }

    /// The runs that the keys name; each must name some.
    fn pictured(&self, records: &Records) -> Result<Pictured, Exit> {
        if self.runs.is_empty() {
            return Ok(Pictured::Few);
        }
        let mut keys = Vec::new();
        for typed in &self.runs {
            let named = records.runs.iter().filter(|run| run.record.key.starts_with(typed.as_str()));
            let before = keys.len();
            for run in named {
                let key = run.record.key.clone();
                if !run.files.iter().any(|file| file.ends_with("log.mcap")) {
                    complain(&format!("warning: {} {key} left no log: there is nothing to show", run.record.scenario));
                }
                keys.push(key);
            }
            if keys.len() == before {
                complain(&format!("error: no run has a key that begins with `{typed}`; the summary has them all"));
                return Err(Exit::Invalid);
            }
        }
        Ok(Pictured::Keys(keys))
    }
}

fn rows(runs: &[FoundRun]) -> Vec<SummaryRow> {
    runs.iter().map(|run| run.record.summary_row()).collect()
}

fn as_reported<'a>(rows: &'a [SummaryRow], found: &'a [FoundRun]) -> Vec<ReportRun<'a>> {
    let run = |(row, found): (&'a SummaryRow, &'a FoundRun)| ReportRun {
        row,
        program: &found.record.program,
        machine: &found.record.timing.machine,
        notes: &found.record.notes,
        files: &found.files,
    };
    rows.iter().zip(found).map(run).collect()
}
