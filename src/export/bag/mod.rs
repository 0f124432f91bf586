//! Exports a log as a ROS 2 bag: a folder with an MCAP file, whose messages are those of ROS 2 in
//! CDR, and `metadata.yaml`.
//!
//! ```text
//! BagLog -> BagInstant -> messages of each topic -> BagWriter -> BagFolder
//! ```

mod bag_folder;
mod bag_log;
mod bag_topics;
mod bag_writer;
mod definitions;
mod frame_messages;
mod markers;
pub mod messages;
mod metadata;
mod wrench_messages;

use crate::export::export_error::ExportError;
use crate::export::selection::Selection;
use bag_folder::BagFolder;
pub use bag_log::BagLog;
use bag_writer::BagWriter;
use metadata::BagInfo;
use std::io::{Seek, Write};
use std::path::Path;

/// What a bag contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BagSummary {
    /// Number of topics.
    pub topics: usize,
    /// Number of messages.
    pub messages: u64,
}

/// Writes a log as a bag to `folder`. Of the selection only the limits in time apply. A bag that
/// this program wrote there is replaced.
///
/// # Errors
/// The folder has other content or cannot be written, or the log has nothing at these times. Then
/// the folder is as before.
pub fn write(log: &BagLog, selection: &Selection, folder: &Path) -> Result<BagSummary, ExportError> {
    let folder = BagFolder::check(folder)?;
    folder.write(|path, out| {
        let info = record(log, selection, (path, &folder.storage), out)?;
        Ok((info.file_text(), BagSummary { topics: info.topics.len(), messages: info.count() }))
    })
}

/// The bytes of the MCAP file of a bag.
///
/// # Errors
/// The log has nothing at these times.
pub fn to_bytes(log: &BagLog, selection: &Selection) -> Result<Vec<u8>, ExportError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    record(log, selection, (Path::new("bag_0.mcap"), "bag_0.mcap"), &mut bytes)?;
    Ok(bytes.into_inner())
}

/// Writes the MCAP file, given its path and name.
fn record(
    log: &BagLog,
    selection: &Selection,
    (path, name): (&Path, &str),
    out: impl Write + Seek,
) -> Result<BagInfo, ExportError> {
    let instants = log.instants(selection)?;
    let mut writer = BagWriter::new(path, out)?;
    bag_topics::write(log, &instants, &mut writer)?;
    writer.finish(name.to_owned())
}
