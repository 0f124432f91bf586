//! Finds the logs that killed programs left unfinished below a folder.

use crate::files::{RecordError, is_abandoned, names};
use std::path::{Path, PathBuf};

/// Unfinished logs below a folder, sorted. Links are not followed. Logs that another program is
/// writing are left out.
///
/// # Errors
/// A folder cannot be read.
pub fn unfinished_logs(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let (mut found, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(RecordError::io(&folder))? {
            let entry = entry.map_err(RecordError::io(&folder))?;
            let kind = entry.file_type().map_err(RecordError::io(&folder))?;
            if kind.is_dir() {
                folders.push(entry.path());
            } else if kind.is_file() && is_abandoned(&entry.path(), names::LOG) {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    Ok(found)
}
