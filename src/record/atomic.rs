//! Files that appear whole: written beside their final name in the same folder, then renamed onto it.

use super::RecordError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use tempfile::{NamedTempFile, TempPath};

/// Creates the folder of `path` if need be, and in it a file that vanishes unless [`publish`] renames it.
pub(super) fn beside(path: &Path) -> Result<(File, TempPath), RecordError> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    builder(&format!(".{name}.")).tempfile_in(folder).map(NamedTempFile::into_parts).map_err(RecordError::io(path))
}

fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(".partial");
    // Temporary files default to owner-only; results are ordinary files, so leave it to the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Renames a finished file onto `path`.
pub(super) fn publish(temporary: TempPath, path: &Path) -> Result<(), RecordError> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
