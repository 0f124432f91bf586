//! Copies the files of a run to another folder, by hard links where the file system has them.
//! Results are never modified in place, so a linked file keeps its content when the file of the
//! other name is replaced.

use crate::files::{RecordError, atomic, durability, if_present, names};
use std::path::{Path, PathBuf};

/// Replaces `to` by a copy of the folder of a run; copies the record last.
pub(super) fn copy_run(from: &Path, to: &Path) -> Result<(), RecordError> {
    if_present(std::fs::remove_dir_all(to)).map_err(RecordError::io(to))?;
    let mut files = Vec::new();
    list(from, from, &mut files)?;
    // An existing record states that the other files of its run are complete.
    files.sort_by_key(|file| file.file_name().is_some_and(|name| name == names::RUN_RECORD));
    for file in files {
        let below = file.strip_prefix(from).unwrap_or(&file);
        copy_file(&file, &to.join(below))?;
    }
    Ok(())
}

/// Lists the files of the run `run` in `folder`.
fn list(run: &Path, folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), RecordError> {
    for entry in std::fs::read_dir(folder).map_err(RecordError::io(folder))? {
        let entry = entry.map_err(RecordError::io(folder))?;
        let kind = entry.file_type().map_err(RecordError::io(&entry.path()))?;
        match () {
            () if entry.file_name().to_string_lossy().starts_with('.') => {}
            () if kind.is_dir() => list(run, &entry.path(), files)?,
            () if kind.is_file() => files.push(entry.path()),
            // A log may be moved and linked; the check has read it. Other links may lead to any file.
            () if kind.is_symlink()
                && folder == run
                && names::LINKABLE.iter().any(|name| entry.file_name() == *name) =>
            {
                files.push(entry.path())
            }
            // Runs write no other kinds of files; a pipe has no end.
            () => {}
        }
    }
    Ok(())
}

fn copy_file(from: &Path, to: &Path) -> Result<(), RecordError> {
    let folder = durability::folder_of(to);
    durability::create_folder(folder).map_err(RecordError::io(folder))?;
    // Link and copy the file itself, not a symbolic link to it.
    let from = &from.canonicalize().map_err(RecordError::io(from))?;
    if std::fs::hard_link(from, to).is_ok() {
        return durability::sync_path(to).and_then(|()| durability::sync_folder_of(to)).map_err(RecordError::io(to));
    }
    atomic::write(to, |out| {
        let (mut file, _) = crate::input::open(from).map_err(RecordError::io(from))?;
        std::io::copy(&mut file, out).map(|_| ()).map_err(RecordError::io(to))
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn only_links_to_the_run_s_own_record_and_log_are_copied() {
        let folder = tempfile::tempdir().unwrap();
        let (from, to, secret) = (folder.path().join("from"), folder.path().join("to"), folder.path().join("secret"));
        std::fs::create_dir_all(from.join("problems")).unwrap();
        std::fs::write(&secret, "secret").unwrap();
        std::fs::write(from.join("problems/0.json"), "{}").unwrap();
        for name in ["log.mcap", "other.txt", "problems/log.mcap", "problems/run.json"] {
            symlink(&secret, from.join(name)).unwrap();
        }
        copy_run(&from, &to).unwrap();
        assert!(to.join("log.mcap").is_file() && to.join("problems/0.json").is_file());
        for name in ["other.txt", "problems/log.mcap", "problems/run.json"] {
            assert!(to.join(name).symlink_metadata().is_err(), "{name}");
        }
    }
}
