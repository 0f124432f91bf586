//! Nothing is written outside a folder of results, whatever its names and links say.
//!
//! The folder itself is where the user says, be it through a link. Below it only folders are walked into, for a link may lead
//! anywhere, and results of others are written over or removed with the runs that they belong to. Files are renamed onto
//! their names ([`crate::files::atomic`]), which replaces a link and leaves alone what it leads to.

use crate::files::RecordError;
use std::io::ErrorKind;
use std::path::{Component, Path};

/// May `path`, below `root`, be written or removed?
///
/// # Errors
/// It leads out of `root` by its name, or it or a folder on the way to it is a link.
pub(crate) fn check(root: &Path, path: &Path) -> Result<(), RecordError> {
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
            // Below what is not there nothing is.
            None => break,
        }
    }
    Ok(())
}

/// Is it a name of one folder, and not a way to another?
pub(crate) fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(only)), None) if only == name)
        && !name.contains('\0')
}

fn is_link(path: &Path) -> Result<Option<bool>, RecordError> {
    match std::fs::symlink_metadata(path) {
        Ok(about) => Ok(Some(about.is_symlink())),
        // A file in the way of a folder is told by whoever makes it.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(error) => Err(RecordError::io(path)(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_elsewhere_are_no_plain_ones() {
        for name in ["a", "a.b", "...", "a b", "ä", "-", "~"] {
            assert!(is_plain(name), "{name}");
        }
        for name in ["", ".", "..", "a/b", "/a", "a/", "./a", "a/..", "a\0b"] {
            assert!(!is_plain(name), "{name:?}");
        }
    }

    #[test]
    fn what_is_named_outside_is_refused() {
        let root = Path::new("results");
        for path in ["results/../a", "results/a/../../b", "elsewhere", "/results/a"] {
            assert!(matches!(check(root, Path::new(path)), Err(RecordError::Outside { .. })), "{path}");
        }
        assert!(check(root, &root.join("none/such")).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_found_wherever_it_stands_on_the_way() {
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
