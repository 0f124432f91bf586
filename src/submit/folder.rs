//! What is in the folder already: parts of the same plan are completed, anything else is left alone.

use std::path::Path;

use super::{Jobs, SubmitError, Sweep};
use crate::files::names::BATCH_MARKERS;
use crate::files::{RecordError, confined};
use crate::results::{ShardHead, ShardList};

/// The beginning of the names of the parts' folders.
const PART: &str = "part-";

/// See [`Sweep::check_folder`].
pub(super) fn check(sweep: &Sweep) -> Result<(), SubmitError> {
    for path in [sweep.scripts(), sweep.results()] {
        confined::check(&sweep.folder, &path)?;
    }
    let other = |what: String| Err(SubmitError::Other { folder: sweep.folder.clone(), what });
    let earlier = Jobs::read(&sweep.scripts())?;
    if let Some(jobs) = &earlier {
        if jobs.parts != sweep.parts.get() {
            return other(format!("it was submitted in {} parts, not {}", jobs.parts, sweep.parts));
        }
        if jobs.plan != sweep.plan {
            return other(different(jobs.runs, sweep));
        }
    }
    if !sweep.scripts().exists() && sweep.results().exists() {
        return other("it has a folder `results` that no earlier submission left".into());
    }
    if let Some(name) = BATCH_MARKERS.into_iter().find(|name| sweep.folder.join(name).symlink_metadata().is_ok()) {
        return other(format!("it is a folder of results: it has a {name}"));
    }
    for (name, path) in parts(&sweep.folder)? {
        let Ok(number) = name[PART.len()..].parse::<u64>() else { continue };
        confined::check(&sweep.folder, &path)?;
        let Some(head) = head(&path)? else { continue };
        let wanted = number.checked_add(1).filter(|shard| *shard <= sweep.parts.get());
        if (Some(head.shard), head.of) != (wanted, sweep.parts.get()) {
            return other(format!("its {name} is part {} of {}, not of {}", head.shard, head.of, sweep.parts));
        }
        if (head.runs, &head.plan) != (sweep.runs, &sweep.plan) {
            return other(format!("its {name} is of another plan: {}", different(head.runs, sweep)));
        }
    }
    Ok(())
}

fn different(runs: usize, sweep: &Sweep) -> String {
    match runs == sweep.runs {
        true => "scenarios, values, robots, files or --filter of what was submitted there differ".into(),
        false => format!("what was submitted there has {runs} runs, this has {}", sweep.runs),
    }
}

/// Folders of parts.
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

/// What a folder says it is a part of; none if it does not: a task that ended early leaves such a one.
fn head(folder: &Path) -> Result<Option<ShardHead>, RecordError> {
    match ShardList::open(folder) {
        Ok(list) => Ok(Some(list.head)),
        Err(RecordError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}
