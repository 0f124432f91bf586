//! Locks of files that are replaced: programs that change such a file take turns.

use crate::files::{RecordError, durability};
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

/// A lock, held until it is dropped or the process ends.
pub struct FileLock {
    file: File,
}

impl FileLock {
    /// Waits for the lock of the file at `path`. It is that of an empty hidden file next to it, which
    /// stays: the file itself is another one after each change. File systems without locks grant it.
    ///
    /// # Errors
    /// The folder or the hidden file cannot be written.
    pub fn wait(path: &Path) -> Result<Self, RecordError> {
        let folder = durability::folder_of(path);
        durability::create_folder(folder).map_err(RecordError::io(folder))?;
        let at = lock_path(path);
        let open = OpenOptions::new().create(true).append(true).open(&at);
        let file = open.map_err(RecordError::io(&at))?;
        let _ = file.lock();
        Ok(FileLock { file })
    }
}

impl Drop for FileLock {
    /// Closing the file is not enough: a process that was forked and has not started its program has it open too.
    fn drop(&mut self) {
        let _ = self.file.unlock();
    }
}

fn lock_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    durability::folder_of(path).join(format!(".{name}.lock"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_take_turns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/count");
        let add = || {
            for _ in 0..50 {
                let _lock = FileLock::wait(&path).unwrap();
                let count: u32 = std::fs::read_to_string(&path).map_or(0, |text| text.parse().unwrap());
                std::fs::write(&path, (count + 1).to_string()).unwrap();
            }
        };
        std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(add))));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "200");
        assert!(folder.path().join("new/.count.lock").exists());
    }

    #[test]
    fn a_copy_of_the_open_file_does_not_keep_the_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("count");
        let lock = FileLock::wait(&path).unwrap();
        let _forked = lock.file.try_clone().unwrap();
        let again = File::open(lock_path(&path)).unwrap();
        assert!(again.try_lock().is_err());
        drop(lock);
        again.try_lock().unwrap();
    }
}
