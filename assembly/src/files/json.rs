//! Reads and writes JSON files with a format version.

use crate::files::checksum::{self, Layout};
use crate::files::{RecordError, atomic};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::io::Write;
use std::path::Path;

/// Parses JSON of a format version. The version is read first, since other versions may have other
/// fields.
///
/// # Errors
/// The text is invalid, a field is missing, or the version differs from `expected`.
pub fn parse<T: DeserializeOwned>(bytes: &[u8], path: &Path, expected: u32) -> Result<T, RecordError> {
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

/// Like [`parse`], for an object that [`write_checked`] wrote.
///
/// # Errors
/// See [`parse`]; also, the object does not match its checksum.
pub fn parse_checked<T: DeserializeOwned>(bytes: &[u8], path: &Path, expected: u32) -> Result<T, RecordError> {
    let parsed = parse(bytes, path, expected)?;
    if checksum::is_intact(bytes, Layout::Pretty) {
        Ok(parsed)
    } else {
        Err(RecordError::Checksum { path: path.to_owned() })
    }
}

/// A value as JSON on one line. The serializer is compiled here once, for all types.
///
/// # Errors
/// A map key is not a string, or a `Serialize` implementation fails.
pub fn compact(value: &dyn erased_serde::Serialize) -> serde_json::Result<Vec<u8>> {
    serde_json::to_vec(value)
}

/// A value as indented JSON; see [`compact`].
///
/// # Errors
/// See [`compact`].
fn pretty(value: &dyn erased_serde::Serialize) -> serde_json::Result<Vec<u8>> {
    serde_json::to_vec_pretty(value)
}

/// Writes an object as indented JSON with its checksum, as [`atomic::write`].
///
/// # Errors
/// The folder or file cannot be written.
pub fn write_checked(path: &Path, value: &dyn erased_serde::Serialize) -> Result<(), RecordError> {
    let mut text = pretty(value).map_err(|source| RecordError::Json { path: path.to_owned(), source })?;
    checksum::append(&mut text, Layout::Pretty);
    text.push(b'\n');
    atomic::write(path, |out| out.write_all(&text).map_err(RecordError::io(path)))
}

/// Writes indented JSON with a final line break, as [`atomic::write`].
///
/// # Errors
/// The folder or file cannot be written.
pub fn write_pretty(path: &Path, value: &dyn erased_serde::Serialize) -> Result<(), RecordError> {
    let mut text = pretty(value).map_err(|source| RecordError::Json { path: path.to_owned(), source })?;
    text.push(b'\n');
    atomic::write(path, |out| out.write_all(&text).map_err(RecordError::io(path)))
}
