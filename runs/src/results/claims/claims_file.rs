//! `claims.json`: the results of the claims of a batch, and its claims about changes.

use crate::files::{RecordError, json, names};
use crate::input;
use crate::results::PROGRAM;
use crate::results::claims::change_claim::ChangeClaim;
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
    /// Claims that need a baseline.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    changes: Vec<ChangeClaim>,
}

/// Writes the results of claims into a folder of results; no file without claims.
///
/// # Errors
/// The file cannot be written.
pub fn write_claims(
    results: &Path,
    claims: &[ClaimVerdict],
    changes: Vec<ChangeClaim>,
) -> Result<Option<PathBuf>, RecordError> {
    if claims.is_empty() && changes.is_empty() {
        return Ok(None);
    }
    let path = results.join(names::CLAIMS);
    let (program, claims) = (PROGRAM.to_owned(), claims.to_vec());
    let file = ClaimsFile { schema: CLAIMS_SCHEMA, program, claims, changes };
    json::write_pretty(&path, &file)?;
    Ok(Some(path))
}

/// Reads the results of claims, and the claims about changes, in a folder of results; none without a file.
///
/// # Errors
/// The file cannot be read, or is of another version.
pub fn read_claims(results: &Path) -> Result<(Vec<ClaimVerdict>, Vec<ChangeClaim>), RecordError> {
    Ok(read_file(results)?.map_or_else(Default::default, |file| (file.claims, file.changes)))
}

fn read_file(results: &Path) -> Result<Option<ClaimsFile>, RecordError> {
    let path = results.join(names::CLAIMS);
    match input::read(&path, input::MOST_DATA) {
        Ok(bytes) => json::parse(&bytes, &path, CLAIMS_SCHEMA).map(Some),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(RecordError::io(&path)(error)),
    }
}
