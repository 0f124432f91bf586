//! Order of runs that are found in a folder of results: as in the last summary, then by content.

use crate::results::record::compare_values;
use crate::results::{ParamValue, RunRecord};
use polars::prelude::{DataFrame, PlSmallStr};
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// A hash that identifies a run in a small space, since there may be millions.
pub(super) type Digest = [u8; 16];

/// The digest of a run, or of the reference run with this key.
pub(super) fn digest(is_reference: bool, scenario: &str, key: &str) -> Digest {
    let mut hasher = blake3::Hasher::new();
    // Names contain no zero byte.
    hasher.update(&[u8::from(is_reference)]).update(scenario.as_bytes()).update(&[0]).update(key.as_bytes());
    let mut digest = [0; 16];
    hasher.finalize_xof().fill(&mut digest);
    digest
}

/// Row numbers of the runs in the last summary; empty if there is none, or it cannot be read.
pub(super) fn summary_order(summary: &Path) -> HashMap<Digest, u32> {
    let read = || {
        if !summary.is_file() {
            return Ok(DataFrame::empty());
        }
        let columns: Arc<[PlSmallStr]> = ["scenario".into(), "key".into()].into();
        let options = CsvReadOptions::default().with_infer_schema_length(Some(0)).with_columns(Some(columns));
        // In memory: a program that shortens a mapped file would end this one.
        options.into_reader_with_file_handle(Cursor::new(std::fs::read(summary)?)).finish()
    };
    let pairs = |frame: &DataFrame| -> Option<HashMap<Digest, u32>> {
        let (scenarios, keys) = (frame.column("scenario").ok()?.str().ok()?, frame.column("key").ok()?.str().ok()?);
        let rows = scenarios.iter().zip(keys.iter()).zip(0..);
        Some(rows.filter_map(|((scenario, key), row)| Some((digest(false, scenario?, key?), row))).collect())
    };
    read().ok().as_ref().and_then(pairs).unwrap_or_default()
}

/// Sort key of a run: its row in the last summary, else its content.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SortKey {
    Row(u32),
    Content(Box<RunContent>),
}

impl SortKey {
    pub fn of(record: &RunRecord, order: &HashMap<Digest, u32>) -> Self {
        match order.get(&digest(false, &record.scenario, &record.key)) {
            Some(row) => SortKey::Row(*row),
            None => SortKey::Content(Box::new(RunContent::of(record))),
        }
    }
}

/// Scenario, parameters and seed of a run, ordered in this sequence; the key decides between
/// equals.
#[derive(PartialEq)]
pub(super) struct RunContent {
    scenario: String,
    parameters: Vec<(String, ParamValue)>,
    seed: u64,
    key: String,
}

impl RunContent {
    fn of(record: &RunRecord) -> Self {
        let RunRecord { scenario, parameters, seed, key, .. } = record.clone();
        RunContent { scenario, parameters, seed, key }
    }
}

impl Eq for RunContent {}

impl Ord for RunContent {
    fn cmp(&self, other: &Self) -> Ordering {
        let parameters = || compare_parameters(&self.parameters, &other.parameters);
        let rest = || self.seed.cmp(&other.seed).then_with(|| self.key.cmp(&other.key));
        self.scenario.cmp(&other.scenario).then_with(parameters).then_with(rest)
    }
}

impl PartialOrd for RunContent {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn compare_parameters(a: &[(String, ParamValue)], b: &[(String, ParamValue)]) -> Ordering {
    let mut orders = a.iter().zip(b).map(|((n, v), (m, w))| n.cmp(m).then_with(|| compare_values(Some(v), Some(w))));
    orders.find(|o| o.is_ne()).unwrap_or_else(|| a.len().cmp(&b.len()))
}
