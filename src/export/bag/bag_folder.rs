//! The folder of a bag: `NAME_0.mcap` and `metadata.yaml`. Both are written to temporary files and
//! then renamed; a bag of this program is replaced, any other content is refused.

use crate::export::bag::bag_writer::{OWN_BYTES, is_own};
use crate::export::bag::metadata::HEAD;
use crate::export::export_error::ExportError;
use crate::files::{RecordError, atomic, is_abandoned};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

const METADATA: &str = "metadata.yaml";

pub(super) struct BagFolder {
    path: PathBuf,
    /// Name of the MCAP file.
    pub storage: String,
    is_new: bool,
}

impl BagFolder {
    /// Checks that a bag may be written to this folder.
    ///
    /// # Errors
    /// The path is a file, or a folder with other content than a bag of this program.
    pub fn check(path: &Path) -> Result<Self, RecordError> {
        let io = |source| RecordError::Io { path: path.to_owned(), source };
        let refuse = |reason: String| Err(io(std::io::Error::new(ErrorKind::AlreadyExists, reason)));
        let about = match std::fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            other => Some(other.map_err(io)?),
        };
        let name = match path.file_name() {
            Some(name) => name.to_owned(),
            None => path.canonicalize().map_err(io)?.file_name().unwrap_or("bag".as_ref()).to_owned(),
        };
        let storage = format!("{}_0.mcap", name.to_string_lossy());
        let folder = Self { path: path.to_owned(), storage, is_new: about.is_none() };
        if about.is_some_and(|about| !about.is_dir()) {
            return refuse("exists and is not a folder: choose another folder to write, or remove it".to_owned());
        }
        if !folder.is_new {
            for entry in std::fs::read_dir(path).map_err(io)? {
                let entry = entry.map_err(io)?;
                if !folder.is_replaceable(&entry.path()) {
                    return refuse(format!(
                        "exists and is not a bag of this program, since it contains `{}`: choose another folder to \
                         write, or remove it",
                        entry.file_name().to_string_lossy()
                    ));
                }
            }
        }
        Ok(folder)
    }

    /// True for a file of a bag that this program wrote to this folder, complete or not.
    fn is_replaceable(&self, path: &Path) -> bool {
        // Opening a pipe would wait for its writer.
        if !path.symlink_metadata().is_ok_and(|about| about.is_file()) {
            return false;
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mut begins = Vec::new();
        let read = File::open(path).and_then(|file| file.take(OWN_BYTES).read_to_end(&mut begins));
        let is_own = match &*name {
            METADATA => begins.starts_with(HEAD.as_bytes()),
            name if name == self.storage => is_own(&begins),
            _ => [METADATA, &self.storage].iter().any(|file| is_abandoned(path, &format!("{file}."))),
        };
        read.is_ok() && is_own
    }

    /// Writes the MCAP file by `fill`, which returns the text of `metadata.yaml` and a result. On an
    /// error, an older bag stays unchanged.
    pub fn write<T>(
        &self,
        fill: impl FnOnce(&Path, &mut BufWriter<File>) -> Result<(String, T), ExportError>,
    ) -> Result<T, ExportError> {
        let (storage, metadata) = (self.path.join(&self.storage), self.path.join(METADATA));
        let written = self.write_files(&storage, &metadata, fill);
        if written.is_err() && self.is_new {
            // Another program may have a bag there by now. An error here would hide the first one.
            let _ = std::fs::remove_dir(&self.path);
        }
        written
    }

    fn write_files<T>(
        &self,
        storage: &Path,
        metadata: &Path,
        fill: impl FnOnce(&Path, &mut BufWriter<File>) -> Result<(String, T), ExportError>,
    ) -> Result<T, ExportError> {
        atomic::remove_partial(&self.path);
        let (file, partial_storage) = atomic::temporary(storage)?;
        let mut out = BufWriter::new(file);
        let (text, result) = fill(storage, &mut out)?;
        out.flush().map_err(RecordError::io(storage))?;
        let (mut file, partial_metadata) = atomic::temporary(metadata)?;
        file.write_all(text.as_bytes()).map_err(RecordError::io(metadata))?;
        // Both are complete; readers look for the metadata first.
        atomic::publish(partial_storage, storage)?;
        let published = atomic::publish(partial_metadata, metadata);
        if published.is_err() && self.is_new {
            let _ = std::fs::remove_file(storage);
        }
        published?;
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, text: &str) -> Result<(), ExportError> {
        BagFolder::check(folder)?.write(|path, out| {
            let begin = [mcap::MAGIC, &[1; 9], b"\x04\0\0\0ros2\x0e\0\0\0stiction 0.1.0", text.as_bytes()].concat();
            out.write_all(&begin).map_err(RecordError::io(path))?;
            match text {
                "fails" => Err(ExportError::NoTopics),
                _ => Ok((format!("{HEAD}\n"), ())),
            }
        })
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_bag_is_replaced_and_other_content_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let bag = place.path().join("a/b");
        write(&bag, "old").unwrap();
        assert_eq!(names(&bag), ["b_0.mcap", METADATA]);
        write(&bag, "new").unwrap();
        assert!(std::fs::read(bag.join("b_0.mcap")).unwrap().ends_with(b"new"));
        // A killed program leaves such a file.
        let (open, unfinished) = atomic::temporary(&bag.join("b_0.mcap")).unwrap();
        let unfinished = unfinished.keep().unwrap();
        // Closing is not enough if another test starts a process at this moment.
        open.unlock().unwrap();
        write(&bag, "third").unwrap();
        assert!(!unfinished.exists());
        for (name, content) in [("notes.txt", "x"), ("b_1.mcap", ""), (".hidden", "")] {
            std::fs::write(bag.join(name), content).unwrap();
            let error = write(&bag, "fourth").unwrap_err().to_string();
            assert!(error.contains(&format!("since it contains `{name}`: choose another folder")), "{error}");
            std::fs::remove_file(bag.join(name)).unwrap();
        }
        // A recorded bag of the same name.
        std::fs::write(bag.join("b_0.mcap"), [mcap::MAGIC, &[1; 9], b"\x04\0\0\0ros2\x07\0\0\0libmcap"].concat())
            .unwrap();
        assert!(write(&bag, "fifth").unwrap_err().to_string().contains("`b_0.mcap`"));
        let file = place.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(write(&file, "x").unwrap_err().to_string().contains("exists and is not a folder"));
    }

    #[test]
    fn a_failed_write_leaves_the_bag_of_another_program() {
        let place = tempfile::tempdir().unwrap();
        let bag = place.path().join("b");
        let ours = BagFolder::check(&bag).unwrap();
        write(&bag, "theirs").unwrap();
        ours.write::<()>(|_, _| Err(ExportError::NoTopics)).unwrap_err();
        assert_eq!(names(&bag), ["b_0.mcap", METADATA]);
        assert!(std::fs::read(bag.join("b_0.mcap")).unwrap().ends_with(b"theirs"));
    }

    #[test]
    fn a_failed_write_leaves_what_was_there() {
        let place = tempfile::tempdir().unwrap();
        let bag = place.path().join("b");
        write(&bag, "fails").unwrap_err();
        assert!(!bag.exists());
        write(&bag, "old").unwrap();
        write(&bag, "fails").unwrap_err();
        assert_eq!(names(&bag), ["b_0.mcap", METADATA]);
        assert!(std::fs::read(bag.join("b_0.mcap")).unwrap().ends_with(b"old"));
        let empty = place.path().join("empty");
        std::fs::create_dir(&empty).unwrap();
        write(&empty, "x").unwrap();
    }
}
