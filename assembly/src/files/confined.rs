//! Confines writes to a folder of results, for any names and links in it.
//!
//! The folder itself may be a link. Links below it are refused as parts of a path, since they may
//! lead to the results of others, which a batch would overwrite or remove. Files are renamed to
//! their names ([`crate::files::atomic`]), which replaces a link and leaves its target unchanged.
//! A program that exchanges folders for links during a batch is not detected.

use crate::files::RecordError;
use std::io::ErrorKind;
use std::path::{Component, Path};

/// Checks that `path`, below `root`, may be written or removed.
///
/// # Errors
/// Its name leads out of `root`, or it or one of its folders is a link.
pub fn check(root: &Path, path: &Path) -> Result<(), RecordError> {
    let below =
        path.strip_prefix(root).ok().filter(|below| below.components().all(|c| matches!(c, Component::Normal(_))));
    let Some(below) = below else {
        return Err(RecordError::Outside { path: path.to_owned(), root: root.to_owned() });
    };
    let mut here = root.to_owned();
    for part in below.components() {
        here.push(part);
        match is_link(&here)? {
            Some(false) => {}
            Some(true) => {
                let target = std::fs::read_link(&here).map_err(RecordError::io(&here))?;
                return Err(RecordError::Link { path: here, target });
            }
            // Nothing exists below a missing folder.
            None => break,
        }
    }
    Ok(())
}

/// True if the name is a single path component.
pub fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(only)), None) if only == name)
        && !name.contains('\0')
}

fn is_link(path: &Path) -> Result<Option<bool>, RecordError> {
    match std::fs::symlink_metadata(path) {
        Ok(about) => Ok(Some(about.is_symlink())),
        // Creating the folder reports a file at its path.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(error) => Err(RecordError::io(path)(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_names_are_single_components() {
        for name in ["a", "a.b", "...", "a b", "ä", "-", "~"] {
            assert!(is_plain(name), "{name}");
        }
        for name in ["", ".", "..", "a/b", "/a", "a/", "./a", "a/..", "a\0b"] {
            assert!(!is_plain(name), "{name:?}");
        }
    }

    #[test]
    fn paths_outside_are_refused() {
        let root = Path::new("results");
        for path in ["results/../a", "results/a/../../b", "elsewhere", "/results/a"] {
            assert!(matches!(check(root, Path::new(path)), Err(RecordError::Outside { .. })), "{path}");
        }
        assert!(check(root, &root.join("none/such")).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_found_anywhere_on_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let (root, elsewhere) = (folder.path().join("root"), folder.path().join("elsewhere"));
        std::fs::create_dir_all(root.join("plain/deep")).unwrap();
        std::fs::create_dir_all(elsewhere.join("deep")).unwrap();
        std::os::unix::fs::symlink(&elsewhere, root.join("link")).unwrap();
        std::os::unix::fs::symlink("nowhere", root.join("plain/dangling")).unwrap();
        assert!(check(&root, &root.join("plain/deep/er")).is_ok());
        for path in ["link", "link/deep", "link/none", "plain/dangling"] {
            let link = match check(&root, &root.join(path)) {
                Err(RecordError::Link { path, .. }) => path,
                other => panic!("{path}: {other:?}"),
            };
            assert!(link.is_symlink());
        }
        // The root may be one.
        let other = folder.path().join("other");
        std::os::unix::fs::symlink(&root, &other).unwrap();
        assert!(check(&other, &other.join("plain/deep")).is_ok());
    }
}
