//! Where messages go: into the MCAP file (channels, messages, attachments, its atomic appearance), to an outlet, or both.

use crate::files::{RecordError, atomic};
use crate::log::outlet::{ChannelInfo, Outlet};
use foxglove::Encode;
use mcap::records::MessageHeader;
use mcap::{Attachment, Compression, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// An open log. Encoding buffers are kept between messages.
pub(super) struct Sink {
    file: Option<LogFile>,
    outlet: Option<Box<dyn Outlet>>,
    /// Is the description over?
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
    /// Its numbers in the file and at the outlet.
    id: u16,
    outlet: u32,
    sequence: u32,
}

impl LogFile {
    fn create(path: &Path) -> Result<Self, RecordError> {
        let (file, temporary) = atomic::beside(path)?;
        let writer = WriteOptions::new()
            .library(concat!("stiction ", env!("CARGO_PKG_VERSION")))
            // For a 25-joint robot level 1 leaves 3.4 kB a tick (LZ4 4.0, none 9.0) for 3 us more than LZ4.
            // Runs already occupy every core, so no threads of its own.
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
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

impl Sink {
    /// A file, an outlet, both or none.
    pub fn open(path: Option<&Path>, outlet: Option<Box<dyn Outlet>>) -> Result<Self, RecordError> {
        let file = path.map(LogFile::create).transpose()?;
        Ok(Self { file, outlet, described: false, bytes: Vec::new() })
    }

    /// What follows are the instants of the run.
    pub fn described(&mut self) {
        self.described = true;
        self.outlet.iter_mut().for_each(|outlet| outlet.described());
    }

    /// Is there anybody to write for?
    pub fn is_wanted(&self) -> bool {
        self.file.is_some() || self.outlet.as_ref().is_some_and(|outlet| outlet.is_wanted())
    }

    /// Tells that all of an instant was sent.
    pub fn instant(&mut self, time: u64) {
        self.outlet.iter_mut().for_each(|outlet| outlet.instant(time));
    }

    /// A channel for a Foxglove message.
    pub fn foxglove<M: Encode>(&mut self, topic: &'static str) -> Result<Channel, RecordError> {
        let schema = M::get_schema()
            .ok_or_else(|| RecordError::Encode { topic, reason: "the message type has no schema".into() })?;
        self.channel(topic, &schema.name, &schema.encoding, &schema.data, "protobuf", BTreeMap::new())
    }

    /// A channel for a message of [`crate::log::messages`], by its name without the package.
    pub fn own(
        &mut self,
        topic: &'static str,
        message: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<Channel, RecordError> {
        let schema = crate::log::descriptor::file_descriptor_set();
        self.channel(topic, &format!("stiction.{message}"), "protobuf", &schema, "protobuf", metadata)
    }

    /// A channel for a ROS 2 message in CDR.
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
        let outlet = self.outlet.as_mut().map_or(0, |outlet| outlet.channel(&info));
        Ok(Channel { topic, id, outlet, sequence: 0 })
    }

    /// Writes a protobuf message at `time` nanoseconds.
    pub fn send(&mut self, to: &mut Channel, time: u64, message: &impl prost::Message) -> Result<(), RecordError> {
        if !self.goes_anywhere(to) {
            return Ok(());
        }
        self.bytes.clear();
        message.encode(&mut self.bytes).map_err(|e| RecordError::Encode { topic: to.topic, reason: e.to_string() })?;
        self.write(to, time)
    }

    /// Writes a CDR message at `time` nanoseconds.
    pub fn send_cdr(
        &mut self,
        to: &mut Channel,
        time: u64,
        message: &impl serde::Serialize,
    ) -> Result<(), RecordError> {
        if !self.goes_anywhere(to) {
            return Ok(());
        }
        self.bytes.clear();
        cdr::serialize_into::<_, _, _, cdr::CdrLe>(&mut self.bytes, message, cdr::Infinite)
            .map_err(|e| RecordError::Encode { topic: to.topic, reason: e.to_string() })?;
        self.write(to, time)
    }

    /// Is a message of this topic worth encoding?
    fn goes_anywhere(&self, to: &Channel) -> bool {
        self.file.is_some() || self.outlet_wants(to)
    }

    fn outlet_wants(&self, to: &Channel) -> bool {
        self.outlet.as_ref().is_some_and(|outlet| !self.described || outlet.wants(to.outlet))
    }

    fn write(&mut self, to: &mut Channel, time: u64) -> Result<(), RecordError> {
        if self.outlet_wants(to)
            && let Some(outlet) = &mut self.outlet
        {
            outlet.message(to.outlet, time, &self.bytes);
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

    /// Writes a named table of words into the file.
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
        drop(written);
        atomic::publish(file.temporary, &file.path)
    }
}

fn failure(path: &Path) -> impl FnOnce(mcap::McapError) -> RecordError {
    move |source| match source {
        // A disk that is full is told as for every other file.
        mcap::McapError::Io(source) => RecordError::Io { path: path.to_owned(), source },
        source => RecordError::Log { path: path.to_owned(), source },
    }
}
