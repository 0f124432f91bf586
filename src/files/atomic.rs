//! Files that appear whole: written beside their final name in the same folder, then renamed onto it.

use crate::files::{RecordError, names};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::Path;
use tempfile::{NamedTempFile, TempPath};

/// Creates the folder of `path` if need be, and in it a file that vanishes unless [`publish`] renames it.
pub(crate) fn beside(path: &Path) -> Result<(File, TempPath), RecordError> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    builder(&format!(".{name}.")).tempfile_in(folder).map(NamedTempFile::into_parts).map_err(RecordError::io(path))
}

/// What follows the name of a file that is not complete.
const PARTIAL: &str = ".partial";

/// Removes what programs that were killed left unfinished in a folder. Nobody else may be writing there; what cannot be
/// removed stays.
pub(crate) fn remove_partial(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') && name.ends_with(PARTIAL) && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(PARTIAL);
    // Temporary files default to owner-only; results are ordinary files, so leave it to the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Renames a finished file onto `path`.
pub(crate) fn publish(temporary: TempPath, path: &Path) -> Result<(), RecordError> {
    temporary.persist(path).map_err(|e| RecordError::Io { path: path.to_owned(), source: e.error })
}

/// Writes a whole file through `fill` and publishes it; on error nothing is left and an older file stays as it was.
pub(crate) fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let (file, temporary) = beside(path)?;
    let mut out = BufWriter::new(file);
    fill(&mut out)?;
    out.flush().map_err(RecordError::io(path))?;
    drop(out);
    publish(temporary, path)
}

/// What a file holds whose name a user gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Made {
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
}

impl Made {
    /// How such files begin.
    fn beginning(self) -> &'static [u8] {
        match self {
            Made::Page => b"<!DOCTYPE html",
            Made::Junit => b"<?xml",
            Made::Session => SESSION.as_bytes(),
            Made::Log => mcap::MAGIC,
            Made::Table => b"",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Made::Page => "page",
            Made::Junit => "file of test results",
            Made::Session => "saved session",
            Made::Log => "log",
            Made::Table => "table",
        }
    }
}

/// How a saved session begins.
pub(crate) const SESSION: &str = "# A session at the console";

/// Extensions of inputs and logs, which a user never means to replace by a table.
const INPUTS: [&str; 3] = ["toml", "urdf", "mcap"];

/// Makes sure that what is written does not replace something else: a scenario, a record. What is there must be empty, no file
/// (a pipe, a device), or such a file as will be written.
///
/// # Errors
/// It would.
pub fn may_replace(path: &Path, made: Made) -> Result<(), RecordError> {
    if !path.is_file() {
        return Ok(());
    }
    let mut begins = Vec::new();
    let wanted = made.beginning();
    let read = File::open(path).and_then(|file| file.take(wanted.len().max(1) as u64).read_to_end(&mut begins));
    let meant = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let named =
        |names: &[&str], part: Option<&std::ffi::OsStr>| part.is_some_and(|part| names.iter().any(|n| part == *n));
    let other = match made {
        Made::Table => named(&names::PROTECTED, meant.file_name()) || named(&INPUTS, meant.extension()),
        // What cannot be read cannot be written either, or is of no concern.
        _ => read.is_ok() && !begins.starts_with(wanted),
    };
    if begins.is_empty() || !other {
        return Ok(());
    }
    let words = format!("is there and is no {}: choose another file to write, or remove it", made.name());
    Err(RecordError::io(path)(std::io::Error::new(ErrorKind::AlreadyExists, words)))
}

/// The same for a file that the user names: a link leads to the file that is meant, and what is no file, such as a pipe, a device or
/// `/dev/stdout`, takes what is written to it and stays what it is. See [`may_replace`].
pub(crate) fn write_named(
    path: &Path,
    made: Made,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    may_replace(path, made)?;
    // Only now is anything followed; a dangling link is replaced.
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() => {
            let meant = path.canonicalize().map_err(RecordError::io(path))?;
            write(&meant, fill)
        }
        Ok(about) if !about.is_dir() => {
            let file = File::options().write(true).open(path).map_err(RecordError::io(path))?;
            let mut out = BufWriter::new(file);
            fill(&mut out)?;
            out.flush().map_err(RecordError::io(path))
        }
        _ => write(path, fill),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_a_user_names_stays_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link, away) = (folder.path().join("file"), folder.path().join("link"), folder.path().join("away"));
        std::fs::write(&file, "<?xml old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        std::os::unix::fs::symlink("/dev/null", &away).unwrap();
        let fill = |out: &mut BufWriter<File>| out.write_all(b"<?xml new").map_err(RecordError::io(Path::new("x")));
        write_named(&link, Made::Junit, fill).unwrap();
        assert!(link.is_symlink() && std::fs::read(&file).unwrap() == b"<?xml new");
        write_named(&away, Made::Junit, fill).unwrap();
        assert_eq!(std::fs::read_link(&away).unwrap(), Path::new("/dev/null"));
        let full = folder.path().join("full");
        std::os::unix::fs::symlink("/dev/full", &full).unwrap();
        assert!(matches!(write_named(&full, Made::Junit, fill), Err(RecordError::Io { .. })));
        let new = folder.path().join("deep/new");
        write_named(&new, Made::Junit, fill).unwrap();
        assert_eq!(std::fs::read(new).unwrap(), b"<?xml new");
    }

    #[test]
    fn what_is_no_such_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let holds = |name: &str, text: &[u8]| std::fs::write(path(name), text).unwrap();
        holds("page.html", b"<!DOCTYPE html>\n");
        holds("b.toml", b"duration = 1\n");
        holds("s.toml", b"# A session at the console that began with b.toml.\n");
        holds("run.json", b"{}");
        holds("empty", b"");
        holds("a.csv", b"whatever");
        holds("log.mcap", mcap::MAGIC);
        let may = |name: &str, made| may_replace(&path(name), made).is_ok();
        let all = [Made::Page, Made::Junit, Made::Session, Made::Log, Made::Table];
        assert!(all.iter().all(|made| may("empty", *made) && may("none", *made)));
        assert!(all.iter().all(|made| !may("b.toml", *made) && !may("run.json", *made)));
        for (name, wanted) in [("page.html", Made::Page), ("s.toml", Made::Session), ("log.mcap", Made::Log)] {
            assert!(may(name, wanted), "{name}");
            assert!(
                all.iter().filter(|made| **made != wanted && **made != Made::Table).all(|made| !may(name, *made)),
                "{name}"
            );
        }
        assert!(may("a.csv", Made::Table) && !may("log.mcap", Made::Table) && !may("a.csv", Made::Junit));
        let error = may_replace(&path("b.toml"), Made::Junit).unwrap_err().to_string();
        assert!(
            error.ends_with(
                "b.toml: is there and is no file of test results: choose another file to write, or remove it"
            )
        );
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_beside_it() {
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
    fn what_was_left_unfinished_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file.txt");
        write(&path, |_| Ok(())).unwrap();
        let (_, unfinished) = beside(&path).unwrap();
        // As a program does that is killed.
        let unfinished = unfinished.keep().unwrap();
        std::fs::write(folder.path().join(".hidden"), "").unwrap();
        remove_partial(folder.path());
        assert!(!unfinished.exists() && path.exists() && folder.path().join(".hidden").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_result_is_readable_as_any_new_file_is() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write(&ours, |_| Ok(())).unwrap();
        std::fs::write(&plain, "").unwrap();
        let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
