//! Files of a run brought to another folder: linked where the file system can, else copied. Results are never written in
//! place, so a linked file stays as it is whatever becomes of the other name.

use crate::files::{RecordError, atomic};
use std::path::{Path, PathBuf};

/// Makes `to` a copy of the folder of a run; its record comes last, and what was there is gone.
pub(super) fn place(from: &Path, to: &Path) -> Result<(), RecordError> {
    match std::fs::remove_dir_all(to) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(RecordError::io(to)(error)),
        _ => {}
    }
    let mut files = Vec::new();
    list(from, &mut files)?;
    // A record tells of the files that lie beside it.
    files.sort_by_key(|file| file.file_name().is_some_and(|name| name == "run.json"));
    for file in files {
        let below = file.strip_prefix(from).unwrap_or(&file);
        bring(&file, &to.join(below))?;
    }
    Ok(())
}

/// Files of a run that may be links.
const LINKED: [&str; 2] = ["run.json", "log.mcap"];

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), RecordError> {
    for entry in std::fs::read_dir(folder).map_err(RecordError::io(folder))? {
        let entry = entry.map_err(RecordError::io(folder))?;
        let kind = entry.file_type().map_err(RecordError::io(&entry.path()))?;
        match () {
            () if entry.file_name().to_string_lossy().starts_with('.') => {}
            () if kind.is_dir() => list(&entry.path(), files)?,
            () if kind.is_file() => files.push(entry.path()),
            // A log that was moved and linked to is still the one that the run left: that was looked at.
            () if kind.is_symlink() && LINKED.iter().any(|name| entry.file_name() == *name) => files.push(entry.path()),
            // Nothing that a run leaves; a pipe has no end.
            () => {}
        }
    }
    Ok(())
}

fn bring(from: &Path, to: &Path) -> Result<(), RecordError> {
    let folder = to.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
    // Where a link leads to: what is linked and copied is the file itself.
    let from = &from.canonicalize().map_err(RecordError::io(from))?;
    if std::fs::hard_link(from, to).is_ok() {
        return Ok(());
    }
    atomic::write(to, |out| {
        let (mut file, _) = crate::files::input::open(from).map_err(RecordError::io(from))?;
        std::io::copy(&mut file, out).map(|_| ()).map_err(RecordError::io(to))
    })
}
