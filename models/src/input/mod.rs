//! Bounded reads of regular files, and the grey values of pictures.
//!
//! A pipe may block and a device may never end; both are refused before opening.
//!
//! Imports: nothing of this crate. Used by: `sdf`, `robot`, `terrain`, `scenario`, `log`,
//! `results`, `remote`, `batch`, `merge`, `view`, `cli`, `submit`, `fit`, `history`.

pub mod png;

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Limit for files written by hand, bytes: scenarios, robot files, URDFs, scripts, packages'
/// manifests.
pub const MOST_TEXT: u64 = 16 << 20;
/// Limit for inputs written by programs, bytes: meshes, motions, logs.
pub const MOST_DATA: u64 = 1 << 30;
/// No limit, for files named on the command line: a log may be longer than an input.
pub const UNLIMITED: u64 = u64::MAX;

/// The bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// System errors; a folder, pipe, device or socket; a larger file.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (file, about) = open(path)?;
    let mut bytes = Vec::new();
    if about.len() <= limit {
        let room = usize::try_from(about.len()).unwrap_or(usize::MAX).saturating_add(1);
        bytes.try_reserve_exact(room).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
        // The file may grow meanwhile, and some system files report a wrong length.
        file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 <= limit {
            return Ok(bytes);
        }
    }
    Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than the limit of {} MiB", limit >> 20)))
}

/// Opens a regular file.
///
/// # Errors
/// System errors; a folder, pipe, device or socket.
pub fn open(path: &Path) -> io::Result<(File, Metadata)> {
    regular(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // Check the opened file: the name may belong to another one by now.
    let about = file.metadata()?;
    regular(&about)?;
    Ok((file, about))
}

/// Like [`read`], for text.
///
/// # Errors
/// As [`read`], and bytes that are not UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(read(path, limit)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        io::Error::new(io::ErrorKind::InvalidData, format!("it is not UTF-8 at byte {at}"))
    })
}

/// The target of `path`, as named by a file in the folder `home`, if a symbolic link leads out of
/// their common folder. Links on the way to `home` are the user's choice.
pub fn outside_target(home: &Path, path: &Path) -> Option<PathBuf> {
    let (from, to) = (normalized(home)?, normalized(path)?);
    let common: PathBuf = from.components().zip(to.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
    let mut below = to.strip_prefix(&common).ok()?.ancestors().map(|part| common.join(part));
    let linked = below.any(|part| part != common && part.is_symlink());
    let real = path.canonicalize().ok().filter(|_| linked)?;
    (!real.starts_with(common.canonicalize().ok()?)).then_some(real)
}

/// An absolute path without `.` and `..`, by name alone.
fn normalized(path: &Path) -> Option<PathBuf> {
    let mut normalized = PathBuf::new();
    for part in std::path::absolute(path).ok()?.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(normalized.pop()),
            part => normalized.push(part),
        }
    }
    Some(normalized)
}

fn regular(about: &Metadata) -> io::Result<()> {
    match about {
        file if file.is_file() => Ok(()),
        folder if folder.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, not a file")),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a pipe or a device, not a file")),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn only_targets_outside_the_folder_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        // The folder of temporary files may itself be behind a link.
        let root = folder.path().canonicalize().unwrap();
        let at = |name: &str| root.join(name);
        for name in ["robots/a/meshes", "elsewhere"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for file in ["robots/a/meshes/m.stl", "elsewhere/e.stl", "robots/shared.stl"] {
            std::fs::write(at(file), "x").unwrap();
        }
        symlink(at("robots/a/meshes/m.stl"), at("robots/a/inside.stl")).unwrap();
        symlink(at("elsewhere/e.stl"), at("robots/a/out.stl")).unwrap();
        symlink(at("elsewhere"), at("robots/a/folder")).unwrap();
        symlink(at("robots"), at("link")).unwrap();
        let home = at("robots/a");
        for (name, real) in [
            ("meshes/m.stl", None),
            ("../shared.stl", None),
            ("../../elsewhere/e.stl", None),
            ("inside.stl", None),
            ("none.stl", None),
            ("out.stl", Some("elsewhere/e.stl")),
            ("folder/e.stl", Some("elsewhere/e.stl")),
            ("meshes/../out.stl", Some("elsewhere/e.stl")),
        ] {
            assert_eq!(outside_target(&home, &home.join(name)), real.map(at), "{name}");
        }
        // The user chose this link.
        assert_eq!(outside_target(&at("link/a"), &at("link/a/meshes/m.stl")), None);
        assert_eq!(outside_target(&at("link/a"), &at("link/a/out.stl")), Some(at("elsewhere/e.stl")));
    }

    #[test]
    fn files_beyond_the_limit_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, [b'x'; 10]).unwrap();
        assert_eq!(read(&path, 10).unwrap().len(), 10);
        assert_eq!(read(&path, 9).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read(folder.path(), 9).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        // Its reported length is 0, its content is not empty.
        assert!(!read(Path::new("/proc/self/status"), MOST_TEXT).unwrap().is_empty());
        assert_eq!(read(Path::new("/proc/self/status"), 9).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read(Path::new("/dev/zero"), UNLIMITED).unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }
}
