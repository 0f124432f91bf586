//! The lock of a folder of results, which is that of its `runs.jsonl`. A batch has it alone, from before
//! it changes anything until its report is written. Readers share it while they open files that belong
//! together. File systems without locks grant it.

use crate::files::{RecordError, names};
use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;
use std::time::Duration;

/// Attempts to lock before the lock counts as held: readers release it within moments.
const ATTEMPTS: u32 = 60;

/// Time between two attempts.
const PAUSE: Duration = Duration::from_millis(5);

/// How a lock is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hold {
    Alone,
    Shared,
}

/// A lock, held until it is dropped or the process ends.
#[derive(Debug)]
pub struct ResultsLock {
    file: Option<File>,
}

impl ResultsLock {
    /// The lock of those who write summary and report again.
    ///
    /// # Errors
    /// Another program writes or reads these results.
    pub fn alone(folder: &Path) -> Result<Self, RecordError> {
        Self::of(folder, Hold::Alone)
    }

    /// The lock of those who read.
    ///
    /// # Errors
    /// Another program writes these results.
    pub fn shared(folder: &Path) -> Result<Self, RecordError> {
        Self::of(folder, Hold::Shared)
    }

    fn of(folder: &Path, hold: Hold) -> Result<Self, RecordError> {
        let path = folder.join(names::RUNS_LOG);
        // Without the file no batch runs there.
        if !path.is_file() {
            return Ok(ResultsLock { file: None });
        }
        // Network file systems lock only files that are open for writing alone.
        let open = || File::options().read(true).append(true).open(&path).or_else(|_| File::open(&path));
        let file = locked(&path, hold, open)?;
        Ok(ResultsLock { file: Some(file) })
    }
}

impl Drop for ResultsLock {
    /// Closing the file is not enough: a process that was forked and has not started its program has it open too.
    fn drop(&mut self) {
        let _ = self.file.as_ref().map(File::unlock);
    }
}

/// Opens `runs.jsonl` and locks it.
pub(super) fn locked(path: &Path, hold: Hold, open: impl Fn() -> io::Result<File>) -> Result<File, RecordError> {
    let mut file = open().map_err(RecordError::io(path))?;
    for attempt in 0..ATTEMPTS {
        if attempt > 0 {
            std::thread::sleep(PAUSE);
        }
        let locked = match hold {
            Hold::Alone => file.try_lock(),
            Hold::Shared => file.try_lock_shared(),
        };
        match locked {
            Err(TryLockError::WouldBlock) => {}
            Ok(()) | Err(TryLockError::Error(_)) if is_at(&file, path) => return Ok(file),
            // A batch that removed damaged lines has replaced the file.
            Ok(()) | Err(TryLockError::Error(_)) => file = open().map_err(RecordError::io(path))?,
        }
    }
    Err(RecordError::InUse { path: path.to_owned() })
}

/// True if the path leads to this open file. An error shows at the next write.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |about: std::fs::Metadata| (about.dev(), about.ino());
    file.metadata().map(place).ok() == std::fs::metadata(path).map(place).ok()
}

/// Other systems do not replace open files.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_share_what_a_batch_has_alone() {
        let folder = tempfile::tempdir().unwrap();
        let in_use = |lock: Result<ResultsLock, RecordError>| matches!(lock, Err(RecordError::InUse { .. }));
        assert!(ResultsLock::alone(folder.path()).unwrap().file.is_none(), "there are no results");
        std::fs::write(folder.path().join(names::RUNS_LOG), "").unwrap();
        let readers = [0, 1].map(|_| ResultsLock::shared(folder.path()).unwrap());
        assert!(in_use(ResultsLock::alone(folder.path())));
        // As in a process that was forked.
        let _forked = readers[0].file.as_ref().unwrap().try_clone().unwrap();
        drop(readers);
        let batch = ResultsLock::alone(folder.path()).unwrap();
        assert!(in_use(ResultsLock::shared(folder.path())) && in_use(ResultsLock::alone(folder.path())));
        drop(batch);
        ResultsLock::shared(folder.path()).unwrap();
    }
}
