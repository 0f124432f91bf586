//! Recovers the readable part of a log that is damaged, or that a killed program left unfinished.
//!
//! An MCAP file is a sequence of records: one byte of kind, eight of length, the content. Messages
//! are inside chunks, compressed, with a checksum for each chunk. Records are read in order up to
//! the first whose length does not fit. A chunk that does not match its checksum is left out; of
//! one that was being written, the messages so far are taken. Next to a gap, messages of an
//! incomplete tick are left out too, so that every tick has all topics.

use crate::files::{OutputKind, RecordError, write_named};
use crate::log::read::{LogError, LogFile, MAX_GROWTH, MAX_RECORD, RUN_ENTRIES, read_bytes};
use crate::log::write::log_options;
use mcap::records::{Channel, MessageHeader, Metadata, Record, SchemaHeader, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Attachment, McapError};
use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};
use std::path::Path;

/// What was recovered of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Salvaged {
    /// Messages written.
    pub messages: usize,
    /// Time of the last message, s.
    pub until_s: f64,
    /// Chunks left out: they do not match their checksums.
    pub damaged_chunks: usize,
    /// Other records left out: they cannot be read, or their channel is missing.
    pub damaged_records: usize,
    /// Messages left out, since their ticks are incomplete.
    pub incomplete: usize,
    /// Bytes at the end that hold no whole record.
    pub unread_bytes: usize,
    /// True if nothing is missing: the log matches all its checksums.
    pub whole: bool,
}

/// Why a log cannot be salvaged.
#[derive(Debug, thiserror::Error)]
pub enum SalvageError {
    /// The log cannot be read, or is of another kind.
    #[error(transparent)]
    Read(#[from] LogError),
    /// The recovered log cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

/// Writes what can be read of the log `from` to the log `to`.
///
/// # Errors
/// `from` cannot be read, is not an MCAP file or has no whole message; `to` cannot be written, or
/// is a file of another kind.
pub fn salvage(from: &Path, to: &Path) -> Result<Salvaged, SalvageError> {
    let bytes = read_bytes(from)?;
    if !bytes.starts_with(mcap::MAGIC) {
        let reason = if bytes.is_empty() { "it is empty" } else { "it does not begin as an MCAP file does" };
        return Err(LogError::Foreign { path: from.to_owned(), reason }.into());
    }
    let mut contents = Contents::read(&bytes);
    contents.salvaged.whole = LogFile::open(from, &bytes).is_ok();
    let missing = match contents.salvaged.messages {
        0 => Some("it has no whole message"),
        _ if !contents.has_identity() => Some("it has no complete metadata table `run`"),
        _ => None,
    };
    if let Some(reason) = missing {
        return Err(LogError::Foreign { path: from.to_owned(), reason }.into());
    }
    contents.mark_incomplete();
    let failed = |source| RecordError::Log { path: to.to_owned(), source };
    write_named(to, OutputKind::Log, |out| contents.write(out).map_err(failed))?;
    Ok(contents.salvaged)
}

/// Records that are written again, in order.
enum Item<'a> {
    Message(MessageHeader, Vec<u8>),
    Attachment(Attachment<'a>),
    Metadata(Metadata),
}

impl Item<'_> {
    fn is_table(&self, name: &str) -> bool {
        matches!(self, Item::Metadata(metadata) if metadata.name == name)
    }
}

/// The readable records of a log.
#[derive(Default)]
struct Contents<'a> {
    schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    channels: BTreeMap<u16, Channel>,
    items: Vec<Item<'a>>,
    /// Position among the items at which the last tick begins, and its time.
    tick: (usize, u64),
    /// True behind a gap, until the time of messages changes.
    after_gap: Option<Option<u64>>,
    salvaged: Salvaged,
}

impl<'a> Contents<'a> {
    fn read(bytes: &'a [u8]) -> Self {
        let mut contents = Self::default();
        let mut budget = bytes.len().saturating_mul(MAX_GROWTH).saturating_add(MAX_RECORD);
        let mut at = mcap::MAGIC.len();
        let mut ended = false;
        while let Some((kind, length)) = frame(&bytes[at..]) {
            let body = &bytes[at + FRAME..];
            let Some(content) = usize::try_from(length).ok().and_then(|length| body.get(..length)) else {
                if kind == op::CHUNK {
                    contents.unfinished_chunk(body, &mut budget);
                }
                break;
            };
            let next = at + FRAME + content.len();
            match kind {
                op::CHUNK => contents.chunk(&bytes[at..next], &mut budget),
                op::DATA_END => ended = true,
                // Behind the data the index repeats schemas and channels.
                op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT | op::METADATA => match parse(kind, content) {
                    Some(record) => contents.record(record),
                    None => contents.salvaged.damaged_records += 1,
                },
                _ => {}
            }
            at = next;
            if kind == op::FOOTER {
                break;
            }
        }
        let unread = bytes.len() - at;
        contents.salvaged.unread_bytes = if bytes[at..] == *mcap::MAGIC { 0 } else { unread };
        if !ended {
            contents.gap();
        }
        let before = contents.items.len();
        contents.items.retain(|item| match item {
            Item::Message(header, _) => contents.channels.contains_key(&header.channel_id),
            _ => true,
        });
        contents.salvaged.damaged_records += before - contents.items.len();
        contents.count();
        contents
    }

    /// Adds a chunk if all of it can be read.
    fn chunk(&mut self, record: &[u8], budget: &mut usize) {
        let mut records = Vec::new();
        if read_chunk(record, budget, |record| records.push(record)).is_ok() {
            records.into_iter().for_each(|record| self.record(record));
        } else {
            self.salvaged.damaged_chunks += 1;
            self.gap();
        }
    }

    /// Adds the records of a chunk whose length and checksum were never written.
    fn unfinished_chunk(&mut self, body: &[u8], budget: &mut usize) {
        let Some(record) = closed_chunk(body) else { return };
        // The end of the file is inside the compressed data, so reading ends with an error.
        let _ = read_chunk(&record, budget, |record| self.record(record));
    }

    fn record(&mut self, record: Record<'a>) {
        match record {
            Record::Schema { header, data } => {
                self.schemas.entry(header.id).or_insert((header, data.into_owned()));
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert(channel);
            }
            Record::Message { header, data } => self.message(header, data.into_owned()),
            Record::Attachment { header, data, .. } => self.items.push(Item::Attachment(Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data,
            })),
            Record::Metadata(metadata) => self.items.push(Item::Metadata(metadata)),
            _ => {}
        }
    }

    fn message(&mut self, header: MessageHeader, data: Vec<u8>) {
        let time = header.log_time;
        if let Some(skipped) = self.after_gap {
            if skipped.is_none_or(|skipped| skipped == time) {
                self.after_gap = Some(Some(time));
                self.salvaged.incomplete += 1;
                return;
            }
            self.after_gap = None;
        }
        if time != self.tick.1 || self.items.is_empty() {
            self.tick = (self.items.len(), time);
        }
        self.items.push(Item::Message(header, data));
    }

    /// Leaves out the tick before a gap and the one behind it: both may lack topics.
    fn gap(&mut self) {
        let (begin, time) = self.tick;
        let before = self.items.len();
        let mut index = 0;
        self.items.retain(|item| {
            index += 1;
            index <= begin || !matches!(item, Item::Message(header, _) if header.log_time == time)
        });
        self.salvaged.incomplete += before - self.items.len();
        self.after_gap = Some(None);
    }

    fn count(&mut self) {
        let times = self.items.iter().filter_map(|item| match item {
            Item::Message(header, _) => Some(header.log_time),
            _ => None,
        });
        self.salvaged.messages = times.clone().count();
        self.salvaged.until_s = times.max().unwrap_or(0) as f64 / 1e9;
    }

    /// True if the log says which run it is of.
    fn has_identity(&self) -> bool {
        self.items.iter().any(|item| match item {
            Item::Metadata(table) if table.name == "run" => RUN_ENTRIES.iter().all(|e| table.metadata.contains_key(*e)),
            _ => false,
        })
    }

    /// True if there is a metadata table of this name.
    fn has_table(&self, name: &str) -> bool {
        self.items.iter().any(|item| item.is_table(name))
    }

    /// Marks a log with missing parts as that of a run that did not end.
    fn mark_incomplete(&mut self) {
        if self.salvaged.whole && self.has_table("end") {
            return;
        }
        self.items.retain(|item| !item.is_table("end"));
        let metadata = BTreeMap::from([("complete".to_owned(), "false".to_owned())]);
        self.items.push(Item::Metadata(Metadata { name: "end".into(), metadata }));
    }

    fn write(&self, out: impl Write + Seek) -> Result<(), McapError> {
        let mut writer = log_options().create(out)?;
        for (id, (header, data)) in &self.schemas {
            writer.add_schema_with_id(*id, &header.name, &header.encoding, data)?;
        }
        for (id, channel) in &self.channels {
            let Channel { schema_id, topic, message_encoding, metadata, .. } = channel;
            writer.add_channel_with_id(*id, *schema_id, topic, message_encoding, metadata)?;
        }
        for item in &self.items {
            match item {
                Item::Message(header, data) => writer.write_to_known_channel(header, data)?,
                Item::Attachment(attachment) => writer.attach(attachment)?,
                Item::Metadata(metadata) => writer.write_metadata(metadata)?,
            }
        }
        writer.finish().map(|_| ())
    }
}

/// Bytes before the content of a record: its kind and its length.
const FRAME: usize = 9;

/// Kind and length of the record at the beginning of these bytes.
fn frame(bytes: &[u8]) -> Option<(u8, u64)> {
    let (kind, rest) = bytes.split_first()?;
    Some((*kind, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// Parses the content of a record.
fn parse(kind: u8, content: &[u8]) -> Option<Record<'_>> {
    // The library takes the end of an attachment's header to be within its content.
    let fits = kind != op::ATTACHMENT || attachment_header(content).is_some_and(|end| end + 4 <= content.len());
    fits.then(|| mcap::parse_record(kind, content).ok()).flatten()
}

/// Length of the header of an attachment: times 2 x 8 bytes, name and media type with their lengths
/// of 4, length of the data 8. Behind the data is a checksum of 4 bytes.
fn attachment_header(content: &[u8]) -> Option<usize> {
    let mut at: usize = 16;
    for _ in 0..2 {
        let length = u32::from_le_bytes(*content.get(at..)?.first_chunk()?) as usize;
        at = at.checked_add(4)?.checked_add(length)?;
    }
    at.checked_add(8)
}

/// The record of a chunk that was being written, with the lengths that it would have if it ended
/// here, and no checksum. Layout of the header: times 2 x 8 bytes, length 8, checksum 4, name of
/// the compression with its length 4, length of the compressed data 8.
fn closed_chunk(body: &[u8]) -> Option<Vec<u8>> {
    const CHECKSUM: usize = 24;
    const NAME: usize = 28;
    let name = u32::from_le_bytes(*body.get(NAME..)?.first_chunk()?) as usize;
    let data = NAME.checked_add(4 + 8)?.checked_add(name)?;
    let compressed = body.len().checked_sub(data)? as u64;
    let mut record = vec![op::CHUNK];
    record.extend_from_slice(&(body.len() as u64).to_le_bytes());
    record.extend_from_slice(body);
    let content = &mut record[FRAME..];
    content[CHECKSUM..CHECKSUM + 4].fill(0);
    content[data - 8..data].copy_from_slice(&compressed.to_le_bytes());
    Some(record)
}

/// Reads the records of a chunk up to an error.
fn read_chunk<'a>(record: &[u8], budget: &mut usize, mut each: impl FnMut(Record<'a>)) -> Result<(), McapError> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(record.len().max(MAX_RECORD));
    let (mut reader, mut rest) = (LinearReader::new_with_options(options), record);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(length) => {
                let read = rest.read(reader.insert(length.min(record.len())))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => {
                *budget = budget.checked_sub(data.len()).ok_or(McapError::UnexpectedEof)?;
                // Chunks have no other records.
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    each(mcap::parse_record(opcode, data)?.into_owned());
                }
            }
        }
    }
    Ok(())
}
