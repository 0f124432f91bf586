//! The log that a run left, as its record knows it: what lies beside a record is its log only if it is this one.

use crate::files::RecordError;
use crate::files::input;
use crate::results::RunRecord;
use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// A log's length and hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogFingerprint {
    /// Length, bytes.
    pub bytes: u64,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

impl LogFingerprint {
    /// Reads a log.
    ///
    /// # Errors
    /// It is not there or cannot be read.
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

/// What is wrong with the log beside a record, in words; none when it is the one that the run left, or it left none. Records
/// of earlier versions do not say what they left: of these a log that is there must be whole.
pub fn log_fault(record: &RunRecord, path: &Path) -> Option<&'static str> {
    let length = match path.metadata() {
        Ok(data) if !data.is_file() => return Some("its log is no file"),
        Ok(data) => data.len(),
        Err(_) if record.log.is_some() => return Some("its log is missing"),
        Err(_) => return None,
    };
    match &record.log {
        Some(left) if left.bytes > length => Some("its log is shorter than the one that it left"),
        Some(left) if left.bytes != length || !LogFingerprint::of(path).is_ok_and(|found| found == *left) => {
            Some("its log is not the one that it left")
        }
        None if !is_whole_log(path) => Some("its log is not whole"),
        _ => None,
    }
}

/// A log ends with the word it begins with.
fn is_whole_log(path: &Path) -> bool {
    let end = || {
        let (mut file, _) = input::open(path)?;
        let mut end = [0; mcap::MAGIC.len()];
        file.seek(SeekFrom::End(-(end.len() as i64)))?;
        file.read_exact(&mut end).map(|()| end)
    };
    end().is_ok_and(|end: [u8; mcap::MAGIC.len()]| end == mcap::MAGIC)
}
