//! Folders for readers that open files, in memory if the system has an in-memory file system.

use std::path::PathBuf;

use tempfile::TempDir;

thread_local! {
    static FOLDER: TempDir = {
        let memory = PathBuf::from("/dev/shm");
        let base = if memory.is_dir() { memory } else { std::env::temp_dir() };
        tempfile::Builder::new().prefix("stiction-fuzz-").tempdir_in(base).expect("a folder")
    };
}

/// A folder of this thread, created if missing.
pub fn folder(name: &str) -> PathBuf {
    let folder = FOLDER.with(|folder| folder.path().join(name));
    std::fs::create_dir_all(&folder).expect("room for a folder");
    folder
}

/// An empty folder of this thread.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::remove_dir_all(&folder).expect("a removable folder");
    std::fs::create_dir_all(&folder).expect("room for a folder");
    folder
}

/// Writes a file, after creating its folders.
pub fn write(path: &std::path::Path, bytes: &[u8]) {
    let folder = path.parent().expect("a folder");
    std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, bytes)).expect("room for a file");
}
