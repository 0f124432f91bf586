//! `claims.json`: the results of the claims of a batch.

use crate::files::{RecordError, input, json, names};
use crate::results::PROGRAM;
use crate::results::claims::verdict::ClaimVerdict;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Format version of `claims.json`.
pub const CLAIMS_SCHEMA: u32 = 1;

/// The file.
#[derive(Serialize, Deserialize)]
struct ClaimsFile {
    schema: u32,
    program: String,
    claims: Vec<ClaimVerdict>,
}

/// Writes the results of claims into a folder of results; no file without claims.
///
/// # Errors
/// The file cannot be written.
pub fn write_claims(results: &Path, claims: &[ClaimVerdict]) -> Result<Option<PathBuf>, RecordError> {
    if claims.is_empty() {
        return Ok(None);
    }
    let path = results.join(names::CLAIMS);
    let file = ClaimsFile { schema: CLAIMS_SCHEMA, program: PROGRAM.to_owned(), claims: claims.to_vec() };
    json::write_pretty(&path, &file)?;
    Ok(Some(path))
}

/// Reads the results of claims in a folder of results; none without a file.
///
/// # Errors
/// The file cannot be read, or is of another version.
pub fn read_claims(results: &Path) -> Result<Vec<ClaimVerdict>, RecordError> {
    let path = results.join(names::CLAIMS);
    match input::read(&path, input::MOST_DATA) {
        Ok(bytes) => json::parse::<ClaimsFile>(&bytes, &path, CLAIMS_SCHEMA).map(|file| file.claims),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(RecordError::io(&path)(error)),
    }
}
