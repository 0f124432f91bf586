//! Opens and verifies the MCAP file of a log, and reads what its index names.

use crate::input;
use crate::log::read::log_error::{LogDamage, LogError};
use crate::log::read::trajectory::{Attachment, RunInfo};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Message, MessageStream, Summary};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Reads the bytes of a log.
///
/// # Errors
/// The file cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, LogError> {
    input::read(path, input::UNLIMITED).map_err(|source| LogError::Io { path: path.to_owned(), source })
}

/// A verified log with its index.
pub(in crate::log) struct LogFile<'a> {
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
        verify(bytes).map_err(|damage| LogError::damaged(path, damage))?;
        let summary = Summary::read(bytes).map_err(|e| LogError::damaged(path, e))?;
        let summary = summary.ok_or_else(|| LogError::Foreign { path: path.to_owned(), reason: "it has no index" })?;
        // The library adds offset and length without a check.
        let metadata = summary.metadata_indexes.iter().map(|index| (index.offset, index.length));
        let attachments = summary.attachment_indexes.iter().map(|index| (index.offset, index.length));
        let within = |(from, length): (u64, u64)| from.checked_add(length).is_some_and(|to| to <= bytes.len() as u64);
        if !metadata.chain(attachments).all(within) {
            return Err(LogError::damaged(path, LogDamage::IndexRange));
        }
        Ok(Self { path, bytes, summary })
    }

    /// Identifies the run.
    pub fn info(&self) -> Result<RunInfo, LogError> {
        let Some(mut run) = self.table("run")? else {
            return Err(LogError::Foreign { path: self.path.to_owned(), reason: "it has no metadata table `run`" });
        };
        let entry = |key: &'static str| run.remove(key).ok_or_else(|| self.damage(LogDamage::RunEntry(key)));
        let [scenario, key, method, program, robot] = RUN_ENTRIES.map(entry);
        let (scenario, key, method, program, robot) = (scenario?, key?, method?, program?, robot?);
        // Logs of earlier versions lack it.
        let world_frame = run.remove("world_frame").unwrap_or_else(|| "world".to_owned());
        Ok(RunInfo { scenario, key, method, program, robot, world_frame })
    }

    /// True if the run ended by itself and the log was closed then.
    pub fn is_complete(&self) -> Result<bool, LogError> {
        let end = self.table("end")?;
        Ok(end.and_then(|e| e.get("complete").map(|c| c == "true")).unwrap_or(false))
    }

    /// The attached texts, in file order.
    pub fn attachments(&self) -> Result<Vec<Attachment>, LogError> {
        let read = |index| {
            let found = mcap::read::attachment(self.bytes, index).map_err(|e| self.damage(e))?;
            let text = String::from_utf8(found.data.into_owned())
                .map_err(|_| self.damage(LogDamage::AttachmentText(found.name.clone())))?;
            Ok(Attachment { name: found.name, media_type: found.media_type, text })
        };
        self.summary.attachment_indexes.iter().map(read).collect()
    }

    /// Topics and the metadata of their channels, in the order they were opened.
    pub fn channels(&self) -> impl Iterator<Item = (&str, &BTreeMap<String, String>)> {
        let ordered: BTreeMap<_, _> = self.summary.channels.iter().collect();
        ordered.into_values().map(|c| (c.topic.as_str(), &c.metadata))
    }

    /// Every message in file order.
    pub fn messages(&self) -> Result<impl Iterator<Item = Result<Message<'a>, LogError>>, LogError> {
        let path = self.path;
        let stream = MessageStream::new(self.bytes).map_err(|e| self.damage(e))?;
        Ok(stream.map(move |m| m.map_err(|e| LogError::damaged(path, e))))
    }

    /// An error of this file as damaged.
    pub fn damage(&self, damage: impl Into<LogDamage>) -> LogError {
        LogError::damaged(self.path, damage)
    }

    /// A metadata table by its name.
    fn table(&self, name: &str) -> Result<Option<BTreeMap<String, String>>, LogError> {
        let index = self.summary.metadata_indexes.iter().find(|i| i.name == name);
        let read = |index| mcap::read::metadata(self.bytes, index).map(|m| m.metadata).map_err(|e| self.damage(e));
        index.map(read).transpose()
    }
}

/// Entries of the metadata table `run`.
pub(in crate::log) const RUN_ENTRIES: [&str; 5] = ["scenario", "key", "method", "program", "robot"];

/// Longest record of a log, bytes, unless the file itself is longer. In a compressed chunk only the
/// record itself states its length.
pub(in crate::log) const MAX_RECORD: usize = 256 << 20;
/// Largest ratio of the length of all records to that of the file.
pub(in crate::log) const MAX_GROWTH: usize = 1000;

/// Reads all records once, those in chunks included, and verifies their checksums, with those of
/// index and metadata: the checksums of messages alone do not protect names and offsets. The limits
/// on the length of one record and of all records keep a small file from filling the memory.
fn verify(bytes: &[u8]) -> Result<(), LogDamage> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(bytes.len().max(MAX_RECORD))
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let (mut reader, mut rest) = (LinearReader::new_with_options(options), bytes);
    let mut budget = bytes.len().saturating_mul(MAX_GROWTH).saturating_add(MAX_RECORD);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(length) => {
                let read = rest.read(reader.insert(length.min(bytes.len())))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, .. } => {
                budget = budget.checked_sub(data.len()).ok_or(LogDamage::Inflated(MAX_GROWTH))?;
            }
        }
    }
    Ok(())
}
