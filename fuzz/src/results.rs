//! Files of results, as a stranger's folder may have them; the first byte selects the kind.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use stiction::compare::{Limits, Results, compare};
use stiction::files::names;
use stiction::history::{Baseline, KEPT_RESULTS, TrendRule, append};
use stiction::merge::Shards;
use stiction::report::{Pictured, ShownBatch, ShownHistory, found_runs, write_report_of};
use stiction::results::claims::{claim_table, read_claims};
use stiction::results::pareto::{Work, pareto_table};
use stiction::results::searches::{read_searches, search_table};
use stiction::results::{
    FoundRun, ListedVerdicts, RunStatistics, RunsLog, SampledRuns, ShardList, SummaryRow, endings, list_records,
    overview, read_records, table, verdicts, write_summary_of,
};
use stiction::view::ViewableRuns;

use super::{samples, scratch};

/// Kinds: a record, `shard.jsonl`, `claims.json`, `searches.json`, `runs.jsonl`, `summary.csv`, `summary.parquet`,
/// `history.parquet`.
pub const KINDS: [u8; 8] = *b"rlasjcph";

/// Width of a terminal.
const WIDTH: usize = 100;

/// Reads a file of results; the first byte is the letter of its kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    match kind {
        b'r' => record(bytes),
        b'l' => shard_list(bytes),
        b'j' => runs_log(bytes),
        b'c' => summary(bytes, names::SUMMARY_CSV),
        b'p' => summary(bytes, names::SUMMARY_PARQUET),
        b'a' => claims(bytes),
        b's' => searches(bytes),
        b'h' => history(bytes),
        _ => {}
    }
}

/// A record of a run and of a reference run: summary, tables and report, as `runner report` writes
/// them.
fn record(bytes: &[u8]) {
    let folder = scratch::empty_folder("record");
    scratch::write(&folder.join("slide/0123456789abcdef").join(names::RUN_RECORD), bytes);
    scratch::write(&folder.join("slide").join(names::REFERENCES).join("fedc").join(names::RUN_RECORD), bytes);
    let found = read_records(&folder).expect("a folder");
    found.skipped.iter().for_each(|error| drop(error.to_string()));
    let listing = list_records(&folder).expect("a folder");
    assert_eq!((listing.runs(), listing.references.len()), (found.runs.len(), found.references.len()));
    if listing.runs() == 0 {
        return;
    }
    listing.with_key_prefix("0").for_each(|run| drop((listing.scenario(run), listing.key_and_log(run))));
    let rows = listing.rows(&[0]);
    // A parameter with the name of another column is refused.
    if let Err(error) = write_summary_of(&folder, &rows) {
        return drop(error.to_string());
    }
    let SampledRuns { statistics, runs } = rows.into_sampled();
    let (rows, reference_rows) = (summary_rows(&runs), summary_rows(&listing.references));
    let (shown, references) = (found_runs(&rows, &runs), found_runs(&reference_rows, &listing.references));
    let page = folder.join(names::REPORT);
    write_report_of(&page, &folder, (&shown, &statistics), &references, (&Pictured::Few, ShownBatch::default()))
        .expect("a report");
    assert_inert(&samples::text(&page));
    let _ = pareto_table(&rows.iter().map(Work::of).collect::<Vec<_>>(), WIDTH);
    let _ = (table(&rows, WIDTH), endings(&rows, true), overview(&statistics, &BTreeSet::new(), WIDTH));
    let _ = verdicts(&rows, ListedVerdicts::All, WIDTH);
    compare_with_itself(&folder);
    let (viewable, _) = ViewableRuns::find(&folder).expect("a folder");
    viewable.runs().iter().for_each(|run| drop(run.title()));
}

/// The results of claims: table and report, as `runner report` writes them.
fn claims(bytes: &[u8]) {
    let folder = scratch::empty_folder("claims");
    scratch::write(&folder.join(names::CLAIMS), bytes);
    let claims = match read_claims(&folder) {
        Ok((claims, _)) => claims,
        Err(error) => return drop(error.to_string()),
    };
    let _ = claim_table(&claims, WIDTH);
    let page = folder.join(names::REPORT);
    let batch = ShownBatch { claims: &claims, ..ShownBatch::default() };
    write_report_of(&page, &folder, (&[], &RunStatistics::default()), &[], (&Pictured::Few, batch)).expect("a report");
    assert_inert(&samples::text(&page));
}

/// The results of searches: table and report, as `runner report` writes them.
fn searches(bytes: &[u8]) {
    let folder = scratch::empty_folder("searches");
    scratch::write(&folder.join(names::SEARCHES), bytes);
    let searches = match read_searches(&folder) {
        Ok(searches) => searches,
        Err(error) => return drop(error.to_string()),
    };
    let _ = search_table(&searches, WIDTH);
    let page = folder.join(names::REPORT);
    let batch = ShownBatch { searches: &searches, ..ShownBatch::default() };
    write_report_of(&page, &folder, (&[], &RunStatistics::default()), &[], (&Pictured::Few, batch)).expect("a report");
    assert_inert(&samples::text(&page));
}

/// A history: compared with results, appended to, shown as by `runner report --history`.
fn history(bytes: &[u8]) {
    let folder = scratch::empty_folder("history");
    let path = folder.join(names::HISTORY);
    scratch::write(&path, bytes);
    let mut baseline = match Baseline::open(&path) {
        Ok(baseline) => baseline,
        Err(error) => return drop(error.to_string()),
    };
    let mut results = Results::open(&samples::results()).expect("results");
    if let Ok(compared) = baseline.compare(&mut results, &Limits::default(), TrendRule { last: 20, level: 0.01 }) {
        drop(compared.changes.to_string());
    }
    if let Baseline::History(history) = &baseline {
        let page = folder.join(names::REPORT);
        let shown = ShownHistory { history, changes: &[] };
        let batch = ShownBatch { history: Some(shown), ..ShownBatch::default() };
        let none = RunStatistics::default();
        write_report_of(&page, &folder, (&[], &none), &[], (&Pictured::Few, batch)).expect("a report");
        assert_inert(&samples::text(&page));
    }
    match append(&path, &mut results, Some("again"), KEPT_RESULTS.get()) {
        Ok(_) => drop(Baseline::open_history(&path).expect("what was written")),
        Err(error) => {
            drop(error.to_string());
            assert_eq!(std::fs::read(&path).expect("a file"), bytes, "a history that was not appended to is unchanged");
        }
    }
}

/// Asserts that no text of a record became an element that loads or executes anything.
fn assert_inert(page: &str) {
    let page = page.to_ascii_lowercase();
    for element in
        ["<script", "<img", "<iframe", "<object", "<embed", "<link", "<form", "<base", " onload=", "javascript:"]
    {
        let found = page.find(element);
        // Escaped text of a record may contain the last two.
        let inside = found.is_some_and(|at| !page[at..].starts_with('<'));
        assert!(found.is_none() || inside, "the report has {element}");
    }
}

fn summary_rows(runs: &[FoundRun]) -> Vec<SummaryRow> {
    runs.iter().map(|run| run.record.summary_row()).collect()
}

/// The list of a shard that has one of its runs: checked and merged.
fn shard_list(bytes: &[u8]) {
    let shard = scratch::folder("shard");
    let run = shard.join("slide").join(samples::run().file_name().expect("a name"));
    if !run.exists() {
        scratch::write(&run.join(names::RUN_RECORD), samples::record().as_bytes());
    }
    scratch::write(&shard.join(names::SHARD_LIST), bytes);
    if let Ok(list) = ShardList::open(&shard) {
        list.for_each(|run| drop(run.map_err(|error| error.to_string())));
    }
    let output = scratch::empty_folder("merged");
    if let Err(error) = merge(&shard, &output) {
        let _ = error.to_string();
    }
    assert!(run.join(names::RUN_RECORD).exists(), "merging removed an input");
}

fn merge(shard: &Path, output: &Path) -> Result<(), stiction::merge::MergeError> {
    let shards = Shards::open(&[shard.to_owned()])?;
    shards.check_output(output)?;
    let missing = shards.check()?;
    shards.write(output, &missing)?;
    Ok(())
}

/// `runs.jsonl`: read by `compare`, then by a batch that continues it.
fn runs_log(bytes: &[u8]) {
    let path = scratch::folder("runs").join(names::RUNS_LOG);
    scratch::write(&path, bytes);
    compare_with_itself(&path);
    let log = RunsLog::append(&path).expect("a file");
    let logged = log.logged().expect("a readable file");
    let again = log.logged().expect("a readable file");
    assert_eq!(logged.len(), again.len(), "damaged lines were kept");
}

fn summary(bytes: &[u8], name: &str) {
    let path = scratch::folder("summary").join(name);
    scratch::write(&path, bytes);
    compare_with_itself(&path);
}

/// Compares results with themselves and with those of a small batch.
fn compare_with_itself(path: &Path) {
    let limits = Limits::default();
    let open = |path: &Path| Results::open(path).map_err(|error| drop(error.to_string())).ok();
    let sample = samples::results();
    for (a, b) in [(path, path), (path, &sample), (&sample, path)] {
        let (Some(mut a), Some(mut b)) = (open(a), open(b)) else { return };
        if let Ok(changes) = compare(&mut a, &mut b, &limits) {
            let _ = (changes.to_string(), changes.is_within(), serde_json::to_string(&changes).expect("JSON"));
        }
    }
}

/// Valid files of each kind with their letters.
pub fn seeds() -> Vec<(u8, Vec<u8>)> {
    let file = |name: &str| -> PathBuf { samples::results().join(name) };
    vec![
        (b'r', samples::record().into()),
        (b'l', samples::shard_list().into()),
        (b'a', samples::CLAIMS.into()),
        (b's', samples::SEARCHES.into()),
        (b'j', samples::runs_log().into()),
        (b'c', std::fs::read(file(names::SUMMARY_CSV)).expect("a summary")),
        (b'p', std::fs::read(file(names::SUMMARY_PARQUET)).expect("a summary")),
        (b'h', samples::history()),
    ]
}
