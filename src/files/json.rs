//! Reads and writes JSON files with a format version.

use crate::files::{RecordError, atomic};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::Path;

/// Parses JSON of a format version. The version is read first, since other versions may have other
/// fields.
///
/// # Errors
/// The text is invalid, a field is missing, or the version differs from `expected`.
pub(crate) fn parse<T: DeserializeOwned>(bytes: &[u8], path: &Path, expected: u32) -> Result<T, RecordError> {
    #[derive(Deserialize)]
    struct Version {
        schema: u64,
    }
    let json = |source| RecordError::Json { path: path.to_owned(), source };
    let Version { schema } = serde_json::from_slice(bytes).map_err(json)?;
    if schema != u64::from(expected) {
        return Err(RecordError::Version { path: path.to_owned(), found: schema, expected });
    }
    serde_json::from_slice(bytes).map_err(json)
}

/// Writes indented JSON with a final line break, as [`atomic::write`].
///
/// # Errors
/// The folder or file cannot be written.
pub(crate) fn write_pretty(path: &Path, value: &impl Serialize) -> Result<(), RecordError> {
    atomic::write(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)
            .map_err(|source| RecordError::Json { path: path.to_owned(), source })?;
        out.write_all(b"\n").map_err(RecordError::io(path))
    })
}
