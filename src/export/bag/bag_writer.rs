//! Writes the MCAP file of a bag: profile `ros2`, every message in CDR.

use crate::export::bag::definitions::definition;
use crate::export::bag::messages::RosMessage;
use crate::export::bag::metadata::{BagInfo, Durability, TopicInfo, qos_profiles};
use crate::export::export_error::ExportError;
use crate::files::RecordError;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

/// Program that wrote a file, in its header.
const LIBRARY: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// Bytes of a chunk before compression. Larger ones are hardly smaller together, and readers
/// decompress one for each jump.
const CHUNK: u64 = 1 << 20;

/// An open bag.
pub(super) struct BagWriter<'a, W: Write + Seek> {
    /// The file, for errors.
    path: &'a Path,
    writer: Writer<W>,
    topics: Vec<(u16, TopicInfo)>,
    span: Option<(u64, u64)>,
    bytes: Vec<u8>,
}

/// A topic with messages of one type.
pub(super) struct Topic<M> {
    index: usize,
    message: PhantomData<M>,
}

impl<'a, W: Write + Seek> BagWriter<'a, W> {
    pub fn new(path: &'a Path, out: W) -> Result<Self, ExportError> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(LIBRARY)
            .compression(Some(Compression::Zstd))
            .chunk_size(Some(CHUNK))
            .compression_threads(0);
        let writer = options.create(out).map_err(failure(path))?;
        Ok(Self { path, writer, topics: Vec::new(), span: None, bytes: Vec::new() })
    }

    /// Opens a topic.
    pub fn open<M: RosMessage>(&mut self, name: &str, durability: Durability) -> Result<Topic<M>, ExportError> {
        let schema = definition(M::TYPE);
        let schema = self.writer.add_schema(M::TYPE, "ros2msg", schema.as_bytes()).map_err(failure(self.path))?;
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), qos_profiles(durability))]);
        let id = self.writer.add_channel(schema, name, "cdr", &metadata).map_err(failure(self.path))?;
        self.topics.push((id, TopicInfo { name: name.to_owned(), message: M::TYPE, durability, count: 0 }));
        Ok(Topic { index: self.topics.len() - 1, message: PhantomData })
    }

    /// Writes a message at `time` nanoseconds. Times do not decrease.
    pub fn send<M: RosMessage>(&mut self, topic: &Topic<M>, time: u64, message: &M) -> Result<(), ExportError> {
        let (channel_id, info) = &mut self.topics[topic.index];
        self.bytes.clear();
        cdr::serialize_into::<_, _, _, cdr::CdrLe>(&mut self.bytes, message, cdr::Infinite)
            .map_err(|error| ExportError::Message { topic: info.name.clone(), reason: error.to_string() })?;
        let header =
            MessageHeader { channel_id: *channel_id, sequence: info.count as u32, log_time: time, publish_time: time };
        info.count += 1;
        self.span = Some((self.span.map_or(time, |(first, _)| first), time));
        self.writer.write_to_known_channel(&header, &self.bytes).map_err(failure(self.path))
    }

    /// Writes the metadata that rosbag2 keeps in the file, then index and statistics.
    pub fn finish(mut self, storage: String) -> Result<BagInfo, ExportError> {
        let (first, last) = self.span.unwrap_or_default();
        let topics = std::mem::take(&mut self.topics).into_iter().map(|(_, info)| info).collect();
        let info = BagInfo { storage, first, last, topics };
        // Without it, later versions take the numbers of the quality of service for their own names.
        let entries = [("serialized_metadata", info.entries()), ("ROS_DISTRO", String::new())];
        let metadata = entries.map(|(key, value)| (key.to_owned(), value)).into();
        self.writer
            .write_metadata(&Metadata { name: "rosbag2".to_owned(), metadata })
            .and_then(|()| self.writer.finish())
            .map_err(failure(self.path))?;
        Ok(info)
    }
}

/// True if these first bytes of a file are those of a bag that this program wrote.
pub(super) fn is_own(bytes: &[u8]) -> bool {
    /// Opcode and length of the header.
    const RECORD: usize = 1 + 8;
    const PROFILE: &[u8] = b"\x04\0\0\0ros2";
    let header = bytes.strip_prefix(mcap::MAGIC).and_then(|rest| rest.get(RECORD..));
    let library = header.and_then(|header| header.strip_prefix(PROFILE)).and_then(|rest| rest.get(4..));
    library.is_some_and(|library| library.starts_with(b"stiction "))
}

/// Bytes that [`is_own`] reads.
pub(super) const OWN_BYTES: u64 = 64;

fn failure(path: &Path) -> impl FnOnce(McapError) -> ExportError {
    let path: PathBuf = path.to_owned();
    move |source| match source {
        McapError::Io(source) => RecordError::Io { path, source }.into(),
        source => ExportError::Bag { path, source },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::ros::Text;
    use std::io::Cursor;

    #[test]
    fn a_bag_of_this_program_is_recognized() {
        let mut bytes = Cursor::new(Vec::new());
        let mut bag = BagWriter::new(Path::new("x"), &mut bytes).unwrap();
        let topic = bag.open::<Text>("/a", Durability::Volatile).unwrap();
        bag.send(&topic, 7, &Text { data: "b".into() }).unwrap();
        let info = bag.finish("x_0.mcap".into()).unwrap();
        assert_eq!((info.first, info.last, info.count()), (7, 7, 1));
        let bytes = bytes.into_inner();
        assert!(is_own(&bytes[..OWN_BYTES as usize]));
        let mut other = Cursor::new(Vec::new());
        WriteOptions::new().profile("ros2").library("libmcap 1").create(&mut other).unwrap().finish().unwrap();
        assert!(!is_own(&other.into_inner()) && !is_own(b"") && !is_own(&bytes[..20]));
    }
}
