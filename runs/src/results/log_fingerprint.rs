//! Length and hash of a run's log, kept in its record to detect logs of other runs.

use crate::files::RecordError;
use crate::input;
use crate::results::RunRecord;
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Length and hash of a log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogFingerprint {
    /// Length, bytes.
    pub bytes: u64,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

impl LogFingerprint {
    /// Computes the fingerprint of a file.
    ///
    /// # Errors
    /// The file is missing or cannot be read.
    pub fn of(path: &Path) -> Result<Self, RecordError> {
        let (mut file, _) = input::open(path).map_err(RecordError::io(path))?;
        let (mut hasher, mut block) = (blake3::Hasher::new(), vec![0; 1 << 16]);
        loop {
            match file.read(&mut block) {
                Ok(0) => break,
                Ok(length) => _ = hasher.update(&block[..length]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(RecordError::io(path)(error)),
            }
        }
        Ok(LogFingerprint { bytes: hasher.count(), blake3: hasher.finalize().to_hex().to_string() })
    }
}

/// Why a log does not belong to a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogMismatch {
    /// It is not a regular file.
    NotAFile,
    /// The record has a fingerprint, but there is no log.
    Missing,
    /// It is shorter than the recorded length.
    Shorter,
    /// Its length or hash differs from the recorded one.
    Different,
    /// It has no end.
    Incomplete,
}

impl LogMismatch {
    /// The reason as text.
    pub fn reason(self) -> &'static str {
        match self {
            Self::NotAFile => "its log is not a file",
            Self::Missing => "its log is missing",
            Self::Shorter => "its log is shorter than the recorded one",
            Self::Different => "its log is not the recorded one",
            Self::Incomplete => "its log is incomplete",
        }
    }
}

/// Compares the log next to a record with the record's fingerprint. Records of earlier versions
/// have none; their log, if there is one, must be complete.
pub fn log_mismatch(record: &RunRecord, path: &Path) -> Option<LogMismatch> {
    let length = match path.metadata() {
        Ok(data) if !data.is_file() => return Some(LogMismatch::NotAFile),
        Ok(data) => data.len(),
        Err(_) if record.log.is_some() => return Some(LogMismatch::Missing),
        Err(_) => return None,
    };
    match &record.log {
        Some(recorded) if recorded.bytes > length => Some(LogMismatch::Shorter),
        Some(recorded)
            if recorded.bytes != length || !LogFingerprint::of(path).is_ok_and(|found| found == *recorded) =>
        {
            Some(LogMismatch::Different)
        }
        None if !is_complete(path) => Some(LogMismatch::Incomplete),
        _ => None,
    }
}

/// True if the file ends with the magic bytes of MCAP, as a complete log does.
fn is_complete(path: &Path) -> bool {
    let read_end = || {
        let (mut file, _) = input::open(path)?;
        let mut end = [0; mcap::MAGIC.len()];
        file.seek(SeekFrom::End(-(end.len() as i64)))?;
        file.read_exact(&mut end).map(|()| end)
    };
    read_end().is_ok_and(|end: [u8; mcap::MAGIC.len()]| end == mcap::MAGIC)
}
