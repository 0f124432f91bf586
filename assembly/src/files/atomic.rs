//! Atomic writes: a temporary file in the same folder, renamed to its final name when complete.

use crate::files::{RecordError, durability, names};
use std::fs::{File, TryLockError};
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::Path;
use std::time::SystemTime;
use tempfile::{NamedTempFile, TempPath};

/// Creates a temporary file in the folder of `path`, which is created if needed; it vanishes unless
/// [`publish`] renames it. While it is open it is locked, where the file system has locks, so that
/// [`remove_partial`] keeps it.
pub fn temporary(path: &Path) -> Result<(File, TempPath), RecordError> {
    let folder = durability::folder_of(path);
    durability::create_folder(folder).map_err(RecordError::io(folder))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    loop {
        let created = builder(&format!(".{name}.")).tempfile_in(folder);
        let (file, temporary) = created.map(NamedTempFile::into_parts).map_err(RecordError::io(path))?;
        // Another program that found the file before it was locked holds the lock for a moment, and may remove it.
        let _ = file.lock();
        if !matches!(temporary.try_exists(), Ok(false)) {
            return Ok((file, temporary));
        }
    }
}

/// Suffix of incomplete files.
const PARTIAL: &str = ".partial";

/// Removes incomplete files of killed programs from a folder. Files that another program is writing
/// stay, and files that cannot be removed.
pub fn remove_partial(folder: &Path) {
    remove_partial_of(folder, "");
}

/// Like [`remove_partial`], for incomplete versions of files whose names begin with `name`.
fn remove_partial_of(folder: &Path, name: &str) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_file()) && is_partial(&entry.path(), name) {
            // A file that cannot be opened may belong to another user, who is writing it.
            let Ok(file) = open_to_lock(&entry.path()) else { continue };
            if !is_locked(&file) {
                // The lock is held until the file is gone.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// True for an incomplete version of a file whose name begins with `name`, unless another program
/// is writing it.
pub fn is_abandoned(path: &Path, name: &str) -> bool {
    let is_free = |file: File| {
        let is_free = !is_locked(&file);
        let _ = file.unlock();
        is_free
    };
    is_partial(path, name) && open_to_lock(path).is_ok_and(is_free)
}

fn is_partial(path: &Path, name: &str) -> bool {
    let found = path.file_name().unwrap_or_default().to_string_lossy();
    found.strip_prefix('.').is_some_and(|rest| rest.starts_with(name)) && found.ends_with(PARTIAL)
}

/// Opens a file for writing, as network file systems lock no others.
fn open_to_lock(path: &Path) -> std::io::Result<File> {
    File::options().read(true).write(true).open(path).or_else(|_| File::open(path))
}

/// True if another open file has the lock of this one, which else gets it, until it is closed.
fn is_locked(file: &File) -> bool {
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(PARTIAL);
    // Temporary files default to owner-only permissions; results are ordinary files under the
    // umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Accepts a missing file as removed.
pub fn if_present(removed: std::io::Result<()>) -> std::io::Result<()> {
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

/// Renames a finished file onto `path`.
pub fn publish(temporary: TempPath, path: &Path) -> Result<(), RecordError> {
    durability::sync_path(&temporary).map_err(RecordError::io(path))?;
    temporary.persist(path).map_err(|e| RecordError::Io { path: path.to_owned(), source: e.error })?;
    durability::sync_folder_of(path).map_err(RecordError::io(path))
}

/// When a file was last written, if that is known.
pub fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().ok()?.modified().ok()
}

/// Writes a file through `fill` and publishes it. On error, an older file stays unchanged and no
/// temporary file remains.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let (file, partial) = temporary(path)?;
    let mut out = BufWriter::new(file);
    fill(&mut out)?;
    out.flush().map_err(RecordError::io(path))?;
    // Still open, and so locked.
    publish(partial, path)
}

/// Kind of an output file named by the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// A page for the browser.
    Page,
    /// Test results.
    Junit,
    /// A session at the console.
    Session,
    /// A log.
    Log,
    /// A table, in any format.
    Table,
    /// A history of results.
    History,
}

impl OutputKind {
    /// First bytes of such files.
    fn beginning(self) -> &'static [u8] {
        match self {
            OutputKind::Page => b"<!DOCTYPE html",
            OutputKind::Junit => b"<?xml",
            OutputKind::Session => SESSION.as_bytes(),
            OutputKind::Log => mcap::MAGIC,
            OutputKind::Table => b"",
            OutputKind::History => b"PAR1",
        }
    }

    fn name(self) -> &'static str {
        match self {
            OutputKind::Page => "page",
            OutputKind::Junit => "file of test results",
            OutputKind::Session => "saved session",
            OutputKind::Log => "log",
            OutputKind::Table => "table",
            OutputKind::History => "history",
        }
    }
}

/// First line of a saved session.
pub const SESSION: &str = "# A session at the console";

/// Extensions of inputs and logs, which a table must not replace.
const INPUTS: [&str; 3] = ["toml", "urdf", "mcap"];

/// Checks that an output replaces no other kind of file, such as a scenario or a record. An
/// existing file must be empty, not a regular file (a pipe, a device), or of the kind to be
/// written.
///
/// # Errors
/// The file exists and is of another kind.
pub fn check_replaceable(path: &Path, kind: OutputKind) -> Result<(), RecordError> {
    if !path.is_file() {
        return Ok(());
    }
    let mut begins = Vec::new();
    let expected = kind.beginning();
    let read = File::open(path).and_then(|file| file.take(expected.len().max(1) as u64).read_to_end(&mut begins));
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let named =
        |names: &[&str], part: Option<&std::ffi::OsStr>| part.is_some_and(|part| names.iter().any(|n| part == *n));
    let other = match kind {
        OutputKind::Table => named(&names::PROTECTED, target.file_name()) || named(&INPUTS, target.extension()),
        // An unreadable file fails later, when it is written.
        _ => read.is_ok() && !begins.starts_with(expected),
    };
    if begins.is_empty() || !other {
        return Ok(());
    }
    let reason = format!("exists and is not a {}: choose another file to write, or remove it", kind.name());
    Err(RecordError::io(path)(std::io::Error::new(ErrorKind::AlreadyExists, reason)))
}

/// Like [`write()`], for a file named by the user. Follows links; writes in place to a pipe, a device
/// or `/dev/stdout`. Checks [`check_replaceable`].
pub fn write_named(
    path: &Path,
    kind: OutputKind,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    check_replaceable(path, kind)?;
    // A dangling link is replaced.
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() => {
            let target = path.canonicalize().map_err(RecordError::io(path))?;
            remove_interrupted(&target);
            write(&target, fill)
        }
        Ok(about) if !about.is_dir() => {
            let file = File::options().write(true).open(path).map_err(RecordError::io(path))?;
            let mut out = BufWriter::new(file);
            fill(&mut out)?;
            out.flush().map_err(RecordError::io(path))
        }
        // Other errors may be temporary, as on a network drive: the file may exist.
        Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            Err(RecordError::io(path)(error))
        }
        _ => {
            remove_interrupted(path);
            write(path, fill)
        }
    }
}

/// Removes what killed programs left of this file.
fn remove_interrupted(path: &Path) {
    if let Some(name) = path.file_name() {
        remove_partial_of(durability::folder_of(path), &format!("{}.", name.to_string_lossy()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[cfg(unix)]
    #[test]
    fn named_outputs_keep_links_and_devices() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link, away) = (folder.path().join("file"), folder.path().join("link"), folder.path().join("away"));
        std::fs::write(&file, "<?xml old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        std::os::unix::fs::symlink("/dev/null", &away).unwrap();
        let fill = |out: &mut BufWriter<File>| out.write_all(b"<?xml new").map_err(RecordError::io(Path::new("x")));
        write_named(&link, OutputKind::Junit, fill).unwrap();
        assert!(link.is_symlink() && std::fs::read(&file).unwrap() == b"<?xml new");
        write_named(&away, OutputKind::Junit, fill).unwrap();
        assert_eq!(std::fs::read_link(&away).unwrap(), Path::new("/dev/null"));
        let full = folder.path().join("full");
        std::os::unix::fs::symlink("/dev/full", &full).unwrap();
        assert!(matches!(write_named(&full, OutputKind::Junit, fill), Err(RecordError::Io { .. })));
        let new = folder.path().join("deep/new");
        write_named(&new, OutputKind::Junit, fill).unwrap();
        assert_eq!(std::fs::read(new).unwrap(), b"<?xml new");
    }

    #[test]
    fn files_of_another_kind_are_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let put = |name: &str, text: &[u8]| std::fs::write(path(name), text).unwrap();
        put("page.html", b"<!DOCTYPE html>\n");
        put("b.toml", b"duration = 1\n");
        put("s.toml", b"# A session at the console that began with b.toml.\n");
        put("run.json", b"{}");
        put("empty", b"");
        put("a.csv", b"whatever");
        put("log.mcap", mcap::MAGIC);
        let may = |name: &str, kind| check_replaceable(&path(name), kind).is_ok();
        let all = [OutputKind::Page, OutputKind::Junit, OutputKind::Session, OutputKind::Log, OutputKind::Table];
        assert!(all.iter().all(|kind| may("empty", *kind) && may("none", *kind)));
        assert!(all.iter().all(|kind| !may("b.toml", *kind) && !may("run.json", *kind)));
        for (name, kind) in
            [("page.html", OutputKind::Page), ("s.toml", OutputKind::Session), ("log.mcap", OutputKind::Log)]
        {
            assert!(may(name, kind), "{name}");
            assert!(
                all.iter()
                    .filter(|other| **other != kind && **other != OutputKind::Table)
                    .all(|other| !may(name, *other)),
                "{name}"
            );
        }
        assert!(
            may("a.csv", OutputKind::Table) && !may("log.mcap", OutputKind::Table) && !may("a.csv", OutputKind::Junit)
        );
        let error = check_replaceable(&path("b.toml"), OutputKind::Junit).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "b.toml: exists and is not a file of test results: choose another file to write, or remove it"
            )
        );
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_no_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/er/file.txt");
        write(&path, |out| out.write_all(b"old").map_err(RecordError::io(Path::new("x")))).unwrap();
        let failed = write(&path, |out| {
            out.write_all(b"half").map_err(RecordError::io(Path::new("x")))?;
            Err(RecordError::Encode { topic: "t", reason: "no".into() })
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn only_incomplete_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file.txt");
        write(&path, |_| Ok(())).unwrap();
        let (open, unfinished) = temporary(&path).unwrap();
        let unfinished = unfinished.keep().unwrap();
        std::fs::write(folder.path().join(".hidden"), "").unwrap();
        remove_partial(folder.path());
        assert!(unfinished.exists(), "another program is writing it");
        // A killed program leaves such a file.
        drop(open);
        remove_partial(folder.path());
        assert!(!unfinished.exists() && path.exists() && folder.path().join(".hidden").exists());
    }

    /// Threads stand for programs: each has its own open files, and so its own locks.
    #[test]
    fn files_being_written_survive_those_who_remove_incomplete_ones() {
        let folder = tempfile::tempdir().unwrap();
        let path = |i: usize| folder.path().join(format!("{i}.txt"));
        let is_done = AtomicBool::new(false);
        let written = std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    while !is_done.load(Ordering::Relaxed) {
                        remove_partial(folder.path());
                    }
                });
            }
            let fill = |out: &mut BufWriter<File>| out.write_all(b"whole").map_err(RecordError::io(Path::new("x")));
            let written = (0..2000).map(|i| write(&path(i % 4), fill)).filter(Result::is_err).count();
            is_done.store(true, Ordering::Relaxed);
            written
        });
        assert_eq!(written, 0, "writes that failed");
        assert!((0..4).all(|i| std::fs::read(path(i)).unwrap() == b"whole"));
    }

    #[test]
    fn a_named_output_replaces_its_interrupted_versions() {
        let folder = tempfile::tempdir().unwrap();
        let (page, table) = (folder.path().join("page.html"), folder.path().join("table.csv"));
        let abandoned = |path: &Path| temporary(path).unwrap().1.keep().unwrap();
        let (old, other) = (abandoned(&page), abandoned(&table));
        write_named(&page, OutputKind::Page, |_| Ok(())).unwrap();
        assert!(!old.exists() && other.exists() && page.exists());
    }

    #[cfg(unix)]
    #[test]
    fn results_have_the_permissions_of_new_files() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write(&ours, |_| Ok(())).unwrap();
        std::fs::write(&plain, "").unwrap();
        let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
