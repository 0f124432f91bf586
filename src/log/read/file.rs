//! The MCAP file: is it one of ours, is it whole, and what its index names.

use crate::log::read::series::{Attachment, RunInfo};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, Message, MessageStream, Summary};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Why a log cannot be read. Each names the file.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// The log.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file of another kind, or of another program.
    #[error("{path}: no log of this program: {reason}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is missing.
        reason: &'static str,
    },
    /// It begins as a log and ends before its index.
    #[error("{path}: cut short: after {length} bytes the index at the end of a log is missing; was it copied whole?")]
    Truncated {
        /// The log.
        path: PathBuf,
        /// Bytes there are.
        length: usize,
    },
    /// A record that its own check sum, length or neighbours contradict.
    #[error("{path}: damaged: {reason}")]
    Damaged {
        /// The log.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
}

/// A log whose index has been read.
pub(super) struct LogFile<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    summary: Summary,
}

impl<'a> LogFile<'a> {
    pub fn open(path: &'a Path, bytes: &'a [u8]) -> Result<Self, LogError> {
        if !bytes.starts_with(mcap::MAGIC) {
            let reason = if bytes.is_empty() { "it is empty" } else { "it does not begin as an MCAP file does" };
            return Err(LogError::Foreign { path: path.to_owned(), reason });
        }
        if bytes.len() < 2 * mcap::MAGIC.len() || !bytes.ends_with(mcap::MAGIC) {
            return Err(LogError::Truncated { path: path.to_owned(), length: bytes.len() });
        }
        verify(bytes).map_err(|reason| LogError::Damaged { path: path.to_owned(), reason })?;
        let summary = Summary::read(bytes).map_err(damaged(path))?;
        let summary = summary.ok_or_else(|| LogError::Foreign { path: path.to_owned(), reason: "it has no index" })?;
        // The library adds offset and length without a look.
        let metadata = summary.metadata_indexes.iter().map(|index| (index.offset, index.length));
        let attachments = summary.attachment_indexes.iter().map(|index| (index.offset, index.length));
        let within = |(from, length): (u64, u64)| from.checked_add(length).is_some_and(|to| to <= bytes.len() as u64);
        if !metadata.chain(attachments).all(within) {
            let reason = "its index leads beyond its end".to_owned();
            return Err(LogError::Damaged { path: path.to_owned(), reason });
        }
        Ok(Self { path, bytes, summary })
    }

    /// Which run this is.
    pub fn info(&self) -> Result<RunInfo, LogError> {
        let Some(mut run) = self.table("run")? else {
            return Err(LogError::Foreign { path: self.path.to_owned(), reason: "its metadata have no table `run`" });
        };
        let mut word = |key: &str| {
            run.remove(key).ok_or_else(|| self.damage(format!("the metadata table `run` lacks the entry `{key}`")))
        };
        Ok(RunInfo {
            scenario: word("scenario")?,
            key: word("key")?,
            method: word("method")?,
            program: word("program")?,
            robot: word("robot")?,
        })
    }

    /// Did the run end by itself, and was the log closed then.
    pub fn is_complete(&self) -> Result<bool, LogError> {
        let end = self.table("end")?;
        Ok(end.and_then(|e| e.get("complete").map(|c| c == "true")).unwrap_or(false))
    }

    /// The texts attached, in file order.
    pub fn attachments(&self) -> Result<Vec<Attachment>, LogError> {
        let read = |index| {
            let found = mcap::read::attachment(self.bytes, index).map_err(damaged(self.path))?;
            let text = String::from_utf8(found.data.into_owned())
                .map_err(|_| self.damage(format!("the attachment `{}` is no UTF-8 text", found.name)))?;
            Ok(Attachment { name: found.name, media_type: found.media_type, text })
        };
        self.summary.attachment_indexes.iter().map(read).collect()
    }

    /// Topics and what their channels say about themselves, in the order they were opened.
    pub fn channels(&self) -> impl Iterator<Item = (&str, &BTreeMap<String, String>)> {
        let ordered: BTreeMap<_, _> = self.summary.channels.iter().collect();
        ordered.into_values().map(|c| (c.topic.as_str(), &c.metadata))
    }

    /// Every message in file order.
    pub fn messages(&self) -> Result<impl Iterator<Item = Result<Message<'a>, LogError>>, LogError> {
        let path = self.path;
        let stream = MessageStream::new(self.bytes).map_err(damaged(path))?;
        Ok(stream.map(move |m| m.map_err(damaged(path))))
    }

    /// A damage of this file.
    pub fn damage(&self, reason: String) -> LogError {
        LogError::Damaged { path: self.path.to_owned(), reason }
    }

    /// A table of words by its name.
    fn table(&self, name: &str) -> Result<Option<BTreeMap<String, String>>, LogError> {
        let index = self.summary.metadata_indexes.iter().find(|i| i.name == name);
        let read = |index| mcap::read::metadata(self.bytes, index).map(|m| m.metadata).map_err(damaged(self.path));
        index.map(read).transpose()
    }
}

/// Longest record of a log, bytes, unless the file itself is longer. Where a record stands in a compressed chunk nothing but its
/// own word says how long it is.
const MOST_RECORD: usize = 256 << 20;
/// How much longer than the file its records may be.
const MOST_GROWTH: usize = 1000;

/// Goes through the records once, those of chunks included, and compares the check sums over all of them, index and tables
/// included; those of the messages alone are not enough to trust a name or an offset by. No record is longer than what is
/// read, and all of them together are not much longer than the file, so that a few bytes do not fill the memory.
fn verify(bytes: &[u8]) -> Result<(), String> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(bytes.len().max(MOST_RECORD))
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let (mut reader, mut rest) = (LinearReader::new_with_options(options), bytes);
    let mut left = bytes.len().saturating_mul(MOST_GROWTH).saturating_add(MOST_RECORD);
    while let Some(event) = reader.next_event() {
        match event.map_err(|e| e.to_string())? {
            LinearReadEvent::ReadRequest(wanted) => {
                let read = rest.read(reader.insert(wanted.min(bytes.len()))).map_err(|e| e.to_string())?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, .. } => {
                let more = || format!("its records are more than {MOST_GROWTH} times as long as the file");
                left = left.checked_sub(data.len()).ok_or_else(more)?;
            }
        }
    }
    Ok(())
}

fn damaged(path: &Path) -> impl Fn(McapError) -> LogError {
    move |e| LogError::Damaged { path: path.to_owned(), reason: e.to_string() }
}
