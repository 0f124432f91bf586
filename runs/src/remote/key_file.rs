//! Reads the secret that both sides of a link share.

use std::fs::Metadata;
use std::io::Read;
use std::path::Path;

use crate::input;
use crate::remote::link_error::LinkError;
use crate::remote::wire::Key;

/// Largest length of a key file, bytes.
pub const MAX_KEY_FILE: usize = 4096;

/// Content of a key file.
#[derive(Clone, Debug)]
pub struct KeyFile {
    /// The key.
    pub key: Key,
    /// Text of a warning if other users have access to the file.
    pub warning: Option<String>,
}

impl KeyFile {
    /// Reads the secret in a regular file, without trailing line ends.
    ///
    /// # Errors
    /// The file cannot be read, or is too short or too long.
    pub fn read(path: &Path) -> Result<Self, LinkError> {
        let failed = |source| LinkError::KeyFile { path: path.to_owned(), source };
        let (file, about) = input::open(path).map_err(failed)?;
        let mut secret = Vec::new();
        // The file may grow meanwhile, and some system files report a wrong length.
        file.take(MAX_KEY_FILE as u64 + 1).read_to_end(&mut secret).map_err(failed)?;
        if secret.len() > MAX_KEY_FILE {
            return Err(LinkError::LongKey { path: path.to_owned(), length: about.len().max(secret.len() as u64) });
        }
        let end = secret.iter().rposition(|byte| !b"\r\n".contains(byte)).map_or(0, |last| last + 1);
        let key = Key::of(&secret[..end]).ok_or_else(|| LinkError::ShortKey { path: path.to_owned(), length: end })?;
        Ok(KeyFile { key, warning: access_warning(path, &about) })
    }
}

#[cfg(unix)]
fn access_warning(path: &Path, about: &Metadata) -> Option<String> {
    use std::os::unix::fs::PermissionsExt;
    let mode = about.permissions().mode() & 0o7777;
    let path = path.display();
    (mode & 0o066 != 0)
        .then(|| format!("other users have access to the key in {path} (mode {mode:04o}): use `chmod 600 {path}`"))
}

#[cfg(not(unix))]
fn access_warning(_: &Path, _: &Metadata) -> Option<String> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs::{Permissions, set_permissions, write};
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn keys_that_others_may_read_or_write_have_a_warning() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        write(&path, "a secret of both sides\n").unwrap();
        for (mode, warns) in
            [(0o600, false), (0o400, false), (0o700, false), (0o640, true), (0o604, true), (0o620, true)]
        {
            set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            let warning = KeyFile::read(&path).unwrap().warning;
            assert_eq!(warning.is_some(), warns, "{mode:o}: {warning:?}");
            let (mode, command) = (format!("(mode {mode:04o})"), format!("`chmod 600 {}`", path.display()));
            assert!(warning.is_none_or(|text| text.contains(&mode) && text.contains(&command)));
        }
    }

    #[test]
    fn only_regular_files_of_limited_length_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        write(&path, [b'k'; MAX_KEY_FILE]).unwrap();
        assert!(KeyFile::read(&path).is_ok());
        write(&path, [b'k'; 5000]).unwrap();
        let error = KeyFile::read(&path).unwrap_err().to_string();
        assert!(error.ends_with("has 5000 bytes, expected at most 4096"), "{error}");
        write(&path, "fifteen bytes..\r\n").unwrap();
        let error = KeyFile::read(&path).unwrap_err().to_string();
        assert!(error.ends_with("has 15 bytes, expected at least 16"), "{error}");
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for other in [pipe.as_path(), Path::new("/dev/zero"), folder.path()] {
            let error = KeyFile::read(other).unwrap_err().to_string();
            assert!(error.contains("cannot read the key in ") && error.contains(", not a file"), "{error}");
        }
    }
}
