//! Checks the folder of a sweep: parts of the same plan are completed, other results are refused.

use std::path::Path;

use super::{Jobs, SubmitError, Sweep};
use crate::files::names::BATCH_MARKERS;
use crate::files::{RecordError, confined};
use crate::results::{ShardHead, ShardList};

/// Prefix of the folders of parts.
const PART: &str = "part-";

/// Refuses a folder with results of another plan.
pub(super) fn check(sweep: &Sweep) -> Result<(), SubmitError> {
    for path in [sweep.scripts(), sweep.results()] {
        confined::check(&sweep.folder, &path)?;
    }
    let other = |what: String| Err(SubmitError::OtherResults { folder: sweep.folder.clone(), what });
    let earlier = Jobs::read(&sweep.scripts())?;
    if let Some(jobs) = &earlier {
        if jobs.parts != sweep.parts.get() {
            return other(format!("it was submitted in {} parts, not {}", jobs.parts, sweep.parts));
        }
        if jobs.plan != sweep.plan || jobs.files != sweep.files {
            return other(difference(jobs.runs, sweep));
        }
    }
    if !sweep.scripts().exists() && sweep.results().exists() {
        return other("it has a folder `results` that no earlier submission wrote".into());
    }
    if let Some(name) = BATCH_MARKERS.into_iter().find(|name| sweep.folder.join(name).symlink_metadata().is_ok()) {
        return other(format!("it is a folder of results: it has a {name}"));
    }
    for (name, path) in parts(&sweep.folder)? {
        let Ok(number) = name[PART.len()..].parse::<u64>() else { continue };
        confined::check(&sweep.folder, &path)?;
        let Some(head) = head(&path)? else { continue };
        let expected = number.checked_add(1).filter(|shard| *shard <= sweep.parts.get());
        if (Some(head.shard), head.of) != (expected, sweep.parts.get()) {
            return other(format!("its {name} is part {} of {}, not of {}", head.shard, head.of, sweep.parts));
        }
        let is_other = (head.runs, &head.plan) != (sweep.runs, &sweep.plan);
        if is_other || head.changed_file(&sweep.files).is_some() {
            return other(format!("its {name} is of another plan: {}", difference(head.runs, sweep)));
        }
    }
    Ok(())
}

fn difference(runs: usize, sweep: &Sweep) -> String {
    match runs == sweep.runs {
        true => "the submission there has other scenarios, values, robots, files or --filter".into(),
        false => format!("the submission there has {runs} runs, this one has {}", sweep.runs),
    }
}

/// Names and paths of the folders of parts, sorted.
fn parts(folder: &Path) -> Result<Vec<(String, std::path::PathBuf)>, RecordError> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(RecordError::io(folder))?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry.map_err(RecordError::io(folder))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(PART) {
            found.push((name, entry.path()));
        }
    }
    found.sort();
    Ok(found)
}

/// Reads the part and plan that a folder belongs to; none if they are missing, as after a task that
/// terminated early.
fn head(folder: &Path) -> Result<Option<ShardHead>, RecordError> {
    match ShardList::open(folder) {
        Ok(list) => Ok(Some(list.head)),
        Err(RecordError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}
