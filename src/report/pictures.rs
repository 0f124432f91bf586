//! The section on selected runs over time, from their logs.

use crate::files::RecordError;
use crate::files::names;
use crate::log::Trajectory;
use crate::report::labels::name;
use crate::report::run_history::History;
use crate::report::run_plot::{legend, run_over_time};
use crate::report::{Pictured, ReportRun};
use crate::text::plural::plural;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;

/// Number of runs drawn by default: failed ones first, then others.
const FEW: usize = 6;
/// Largest number of failed runs drawn by default.
const MAX_REFUSED: usize = 8;
/// Longer logs are read on request only, bytes.
const LONG: u64 = 32 << 20;

/// The section.
#[derive(Debug, Serialize)]
pub(super) struct Section {
    pub runs: Vec<Picture>,
    /// Note on omitted runs.
    pub more: String,
}

/// A run over time.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub name: String,
    pub key: String,
    pub outcome: &'static str,
    pub refused: bool,
    /// Name and swatch of each sole's force.
    pub legend: Vec<(String, String)>,
    /// Empty when there is nothing to draw; `note` gives the reason.
    pub svg: String,
    pub note: String,
}

pub(super) fn pictures(runs: &[ReportRun], pictured: &Pictured) -> Result<Section, RecordError> {
    let (chosen, more) = choose(runs, pictured);
    let runs = chosen.into_iter().map(|(run, log)| picture(run, log)).collect::<Result<_, _>>()?;
    Ok(Section { runs, more })
}

/// Runs with their logs.
fn choose<'a>(runs: &'a [ReportRun<'a>], pictured: &Pictured) -> (Vec<(&'a ReportRun<'a>, &'a Path)>, String) {
    let logged: Vec<_> = runs.iter().filter_map(|run| Some((run, run.file(names::LOG)?))).collect();
    if let Pictured::Keys(keys) = pictured {
        return (logged.into_iter().filter(|(run, _)| keys.contains(&run.row.key)).collect(), String::new());
    }
    let is_short = |log: &Path| log.metadata().is_ok_and(|m| m.len() <= LONG);
    let (refused, good): (Vec<usize>, Vec<usize>) =
        (0..logged.len()).filter(|&i| is_short(logged[i].1)).partition(|&i| logged[i].0.is_refused());
    let mut chosen: Vec<usize> = refused.into_iter().take(MAX_REFUSED).collect();
    // One run of each scenario first.
    let mut scenarios = BTreeSet::new();
    let (first, further): (Vec<usize>, Vec<usize>) =
        good.into_iter().partition(|&i| scenarios.insert(&logged[i].0.row.scenario));
    let room = FEW.saturating_sub(chosen.len());
    chosen.extend(first.into_iter().chain(further).take(room));
    chosen.sort_unstable();
    let more = match logged.len() - chosen.len() {
        0 => String::new(),
        omitted => {
            format!("{} more with logs; `runner report RESULTS --runs KEY...` shows them", plural(omitted, "run"))
        }
    };
    (chosen.into_iter().map(|i| logged[i]).collect(), more)
}

fn picture(run: &ReportRun, log: &Path) -> Result<Picture, RecordError> {
    let mut picture = Picture {
        name: name(run.row),
        key: run.row.key.clone(),
        outcome: run.row.outcome.name(),
        refused: run.is_refused(),
        legend: Vec::new(),
        svg: String::new(),
        note: run.row.message.clone(),
    };
    let history = match Trajectory::read(log) {
        Ok(log) => History::of(&log),
        Err(error) => {
            picture.note = error.to_string();
            return Ok(picture);
        }
    };
    match history {
        Some(history) if !history.height.is_empty() || !history.soles.is_empty() => {
            picture.svg = run_over_time(&picture.name, &history)?;
            picture.legend = legend(&history);
            picture.note =
                [picture.note, extremes(&history)].into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join("; ");
        }
        _ => picture.note = "its log has no instants, or neither of the topics `state` and `contact`".into(),
    }
    Ok(picture)
}

/// Such as `base height 0.28 to 0.31 m; left: 12 changes of state`.
fn extremes(history: &History) -> String {
    let heights = history.height.iter().map(|p| p.1);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let height = (low <= high).then(|| format!("base height {low:.4} to {high:.4} m"));
    let soles = history.soles.iter().map(|s| format!("{}: {} of state", s.name, plural(s.changes, "change")));
    height.into_iter().chain(soles).collect::<Vec<_>>().join("; ")
}
