//! `runner merge`: merges the results of shards into one folder.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::batch::marks_implausible;
use crate::files::{make_durable, names};
use crate::merge::{MergeError, Merged, Shards};
use crate::report::{ShownBatch, write_report_of_found};
use crate::results::claims::{Judgement, claim_table};
use crate::results::searches::{SearchVerdict, search_table};
use crate::results::{endings, overview};
use crate::text::visible::{visible_lines, visible_path};
use clap::Args;

use crate::cli::Exit;
use crate::cli::exit::Ending;
use crate::cli::terminal::{complain, complain_of, print, width};

/// Arguments of `merge`.
#[derive(Args, Debug)]
pub struct Merge {
    /// Folders of results, one per shard
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Folder of the merged results
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Merge even if shards or runs are missing
    #[arg(long)]
    partial: bool,
    /// Wait until each file is on the storage device (fsync)
    #[arg(long)]
    durable: bool,
}

impl Merge {
    /// Checks everything, then writes everything.
    pub fn execute(self) -> Result<Exit, Exit> {
        let refused = |error: MergeError| {
            complain_of(error);
            Exit::Invalid
        };
        if self.durable {
            make_durable();
        }
        let shards = Shards::open(&self.folders).map_err(refused)?;
        shards.check_output(&self.output).map_err(refused)?;
        let missing = shards.check().map_err(refused)?;
        missing.lines.iter().for_each(|what| match self.partial {
            true => complain(&format!("warning: {what}")),
            false => complain_of(what),
        });
        if !missing.lines.is_empty() && !self.partial {
            complain("nothing was written; --partial takes what is there");
            return Err(Exit::Invalid);
        }
        let merged = shards.write(&self.output, &missing).map_err(refused)?;
        let page = self.output.join(names::REPORT);
        let runs = (merged.runs.as_slice(), &merged.statistics);
        let batch = ShownBatch { claims: &merged.claims, searches: &merged.searches, ..ShownBatch::default() };
        write_report_of_found(&page, &self.output, runs, &merged.references, batch)
            .map_err(|error| refused(error.into()))?;
        print(&visible_lines(&summary(&merged, &page)))?;
        let is_any = |judgement| merged.claims.iter().any(|claim| claim.verdict == judgement);
        Ok(Exit::of_ending(Ending {
            interrupted: None,
            unfinished: merged.unfinished > 0,
            failed: merged.failed > 0 || is_any(Judgement::Fails),
            undecided: is_any(Judgement::Undecided)
                || merged.searches.iter().any(|search| search.verdict != SearchVerdict::Found),
        }))
    }
}

/// The summary of `run` without notes and times.
fn summary(merged: &Merged, page: &Path) -> String {
    let rows: Vec<_> = merged.runs.iter().map(|run| run.record.summary_row()).collect();
    let marked = merged.runs.iter().filter(|run| run.record.notes.iter().any(|note| marks_implausible(note)));
    let marked = marked.map(|run| run.record.scenario.as_str()).collect();
    let mut out = overview(&merged.statistics, &marked, width());
    let failed = endings(&rows, false);
    if !failed.is_empty() {
        out += &format!("\n{failed}");
    }
    let searches = search_table(&merged.searches, width());
    if !searches.is_empty() {
        out += &format!("\n{searches}");
    }
    let claims = claim_table(&merged.claims, width());
    if !claims.is_empty() {
        out += &format!("\n{claims}");
    }
    out += "\nwritten:\n";
    let claims = merged.claims_file.as_deref();
    let files = [&*merged.summary.csv, &merged.summary.parquet, &merged.runs_log, page];
    let searches = merged.search_files.iter().map(PathBuf::as_path);
    for path in files.into_iter().chain(searches).chain(claims) {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "  {}", visible_path(path));
    }
    out
}
