//! Encodes messages and writes them to the MCAP file, to a [`MessageSink`], or to both.

use crate::files::{RecordError, atomic};
use crate::log::write::message_sink::{ChannelInfo, MessageSink};
use crate::log::write::proto_writer::ProtoWriter;
use foxglove::Encode;
use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// An open log. Encoding buffers are reused between messages.
pub(super) struct LogOutput {
    file: Option<LogFile>,
    sink: Option<Box<dyn MessageSink>>,
    /// True once the description of the run is complete.
    described: bool,
    bytes: Vec<u8>,
}

struct LogFile {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    temporary: TempPath,
}

/// One topic of an open log.
pub(super) struct Channel {
    topic: &'static str,
    /// Its numbers in the file and at the sink.
    id: u16,
    sink: u32,
    sequence: u32,
}

/// Level of zstd. Numbers hardly compress: the levels below 0 try less and leave 1 to 17 % more than
/// level 1. The library passes the level on as a signed number. Compression alone, HOAP-2 at 200 Hz:
///
/// | level | 1 | -1 | -2 | -3 | -5 | LZ4 |
/// |---|---|---|---|---|---|---|
/// | us a frame | 7.5 | 5.6 | 4.9 | 4.4 | 3.5 | 4.4 |
/// | kB a frame | 1.72 | 1.74 | 1.79 | 1.89 | 2.01 | 2.08 |
const LEVEL: i32 = -2;

/// Bytes of a chunk before compression. The window of zstd has as many at these levels, so it never wraps
/// within a chunk, which would be slower.
const CHUNK: u64 = 512 << 10;

/// Options of all logs.
pub(in crate::log) fn log_options() -> WriteOptions {
    // Runs already occupy every core, so the log has no threads.
    WriteOptions::new()
        .library(concat!("stiction ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_level(LEVEL.cast_unsigned())
        .chunk_size(Some(CHUNK))
        .compression_threads(0)
}

impl LogFile {
    fn create(path: &Path) -> Result<Self, RecordError> {
        let (file, temporary) = atomic::temporary(path)?;
        let writer = log_options()
            .create(BufWriter::new(file))
            .map_err(|source| RecordError::Log { path: path.to_owned(), source })?;
        Ok(Self { path: path.to_owned(), writer, temporary })
    }

    fn channel(&mut self, c: &ChannelInfo) -> Result<u16, RecordError> {
        let schema = self.writer.add_schema(&c.schema_name, &c.schema_encoding, &c.schema);
        let schema = schema.map_err(failure(&self.path))?;
        self.writer.add_channel(schema, &c.topic, &c.encoding, &c.metadata).map_err(failure(&self.path))
    }
}

impl LogOutput {
    /// Opens a log with a file, a sink, both or none.
    pub fn open(path: Option<&Path>, sink: Option<Box<dyn MessageSink>>) -> Result<Self, RecordError> {
        let file = path.map(LogFile::create).transpose()?;
        Ok(Self { file, sink, described: false, bytes: Vec::new() })
    }

    /// Ends the description; the ticks of the run follow.
    pub fn end_description(&mut self) {
        self.described = true;
        self.sink.iter_mut().for_each(|sink| sink.end_description());
    }

    /// True if there is a file or a subscriber.
    pub fn has_receiver(&self) -> bool {
        self.file.is_some() || self.sink.as_ref().is_some_and(|sink| sink.has_subscribers())
    }

    /// Ends the messages of a tick.
    pub fn end_tick(&mut self, time: u64) {
        self.sink.iter_mut().for_each(|sink| sink.end_tick(time));
    }

    /// Opens a channel for a Foxglove message.
    pub fn foxglove<M: Encode>(&mut self, topic: &'static str) -> Result<Channel, RecordError> {
        let schema = M::get_schema()
            .ok_or_else(|| RecordError::Encode { topic, reason: "the message type has no schema".into() })?;
        self.channel(topic, &schema.name, &schema.encoding, &schema.data, "protobuf", BTreeMap::new())
    }

    /// Opens a channel for a message of [`crate::log::messages`], by its name without the package.
    pub fn stiction(
        &mut self,
        topic: &'static str,
        message: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<Channel, RecordError> {
        let schema = crate::log::message_descriptor::file_descriptor_set();
        self.channel(topic, &format!("stiction.{message}"), "protobuf", &schema, "protobuf", metadata)
    }

    /// Opens a channel for a ROS 2 message in CDR.
    pub fn ros(&mut self, topic: &'static str, name: &str, definition: &str) -> Result<Channel, RecordError> {
        self.channel(topic, name, "ros2msg", definition.as_bytes(), "cdr", BTreeMap::new())
    }

    fn channel(
        &mut self,
        topic: &'static str,
        schema: &str,
        schema_encoding: &str,
        schema_data: &[u8],
        message_encoding: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<Channel, RecordError> {
        let info = ChannelInfo {
            topic: topic.to_owned(),
            encoding: message_encoding.to_owned(),
            schema_name: schema.to_owned(),
            schema_encoding: schema_encoding.to_owned(),
            schema: schema_data.to_owned(),
            metadata,
        };
        let id = self.file.as_mut().map_or(Ok(0), |file| file.channel(&info))?;
        let sink = self.sink.as_mut().map_or(0, |sink| sink.open_channel(&info));
        Ok(Channel { topic, id, sink, sequence: 0 })
    }

    /// Writes a protobuf message at `time` nanoseconds.
    pub fn send(&mut self, to: &mut Channel, time: u64, message: &impl prost::Message) -> Result<(), RecordError> {
        if !self.is_received(to) {
            return Ok(());
        }
        self.bytes.clear();
        message.encode(&mut self.bytes).map_err(|e| RecordError::Encode { topic: to.topic, reason: e.to_string() })?;
        self.write(to, time)
    }

    /// Writes a protobuf message at `time` nanoseconds, whose fields `write` encodes.
    #[inline]
    pub fn send_fields(
        &mut self,
        to: &mut Channel,
        time: u64,
        write: impl FnOnce(&mut ProtoWriter),
    ) -> Result<(), RecordError> {
        if !self.is_received(to) {
            return Ok(());
        }
        self.bytes.clear();
        write(&mut ProtoWriter::new(&mut self.bytes));
        self.write(to, time)
    }

    /// Writes an encoded message at `time` nanoseconds.
    pub fn send_bytes(&mut self, to: &mut Channel, time: u64, bytes: &[u8]) -> Result<(), RecordError> {
        if !self.is_received(to) {
            return Ok(());
        }
        self.bytes.clear();
        self.bytes.extend_from_slice(bytes);
        self.write(to, time)
    }

    /// Writes a CDR message at `time` nanoseconds.
    pub fn send_cdr(
        &mut self,
        to: &mut Channel,
        time: u64,
        message: &impl serde::Serialize,
    ) -> Result<(), RecordError> {
        if !self.is_received(to) {
            return Ok(());
        }
        self.bytes.clear();
        cdr::serialize_into::<_, _, _, cdr::CdrLe>(&mut self.bytes, message, cdr::Infinite)
            .map_err(|e| RecordError::Encode { topic: to.topic, reason: e.to_string() })?;
        self.write(to, time)
    }

    /// True if a message of this topic has a receiver.
    fn is_received(&self, to: &Channel) -> bool {
        self.file.is_some() || self.sink_receives(to)
    }

    fn sink_receives(&self, to: &Channel) -> bool {
        self.sink.as_ref().is_some_and(|sink| !self.described || sink.is_subscribed(to.sink))
    }

    fn write(&mut self, to: &mut Channel, time: u64) -> Result<(), RecordError> {
        if self.sink_receives(to)
            && let Some(sink) = &mut self.sink
        {
            sink.message(to.sink, time, &self.bytes);
        }
        if let Some(file) = &mut self.file {
            let header = MessageHeader { channel_id: to.id, sequence: to.sequence, log_time: time, publish_time: time };
            file.writer.write_to_known_channel(&header, &self.bytes).map_err(failure(&file.path))?;
        }
        to.sequence = to.sequence.wrapping_add(1);
        Ok(())
    }

    /// Attaches a text to the file. Its times are 0: the file depends on the run only.
    pub fn attach(&mut self, name: &str, media_type: &str, text: &str) -> Result<(), RecordError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(text.as_bytes()),
        };
        file.writer.attach(&attachment).map_err(failure(&file.path))
    }

    /// Writes a named table of strings into the file.
    pub fn metadata(&mut self, name: &str, entries: &[(&str, &str)]) -> Result<(), RecordError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let metadata = entries.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
        let metadata = mcap::records::Metadata { name: name.to_owned(), metadata };
        file.writer.write_metadata(&metadata).map_err(failure(&file.path))
    }

    /// Writes indices and summary, and renames the file to its final name.
    pub fn finish(self) -> Result<(), RecordError> {
        let Some(mut file) = self.file else { return Ok(()) };
        file.writer.finish().map_err(failure(&file.path))?;
        let mut written = file.writer.into_inner();
        written.flush().map_err(RecordError::io(&file.path))?;
        // Still open, and so locked.
        atomic::publish(file.temporary, &file.path)
    }
}

fn failure(path: &Path) -> impl FnOnce(mcap::McapError) -> RecordError {
    move |source| match source {
        // A full disk is the same error as for every other file.
        mcap::McapError::Io(source) => RecordError::Io { path: path.to_owned(), source },
        source => RecordError::Log { path: path.to_owned(), source },
    }
}
