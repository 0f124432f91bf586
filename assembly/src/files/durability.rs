//! Durable writes: the program waits until files, and their names in folders, are on the storage
//! device (`fsync`). Off by default: a power failure may then lose or break files of the last
//! seconds, which `--resume` detects.

use std::fs::File;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A setting of the process: files are written at the end of many paths through the program.
static DURABLE: AtomicBool = AtomicBool::new(false);

/// Makes the writes of this process durable. They stay durable until its end.
pub fn make_durable() {
    DURABLE.store(true, Ordering::Relaxed);
}

/// Waits until a file is on the device, if writes are durable.
pub fn sync_file(file: &File) -> std::io::Result<()> {
    if DURABLE.load(Ordering::Relaxed) { file.sync_all() } else { Ok(()) }
}

/// Like [`sync_file`], for a closed file.
pub fn sync_path(path: &Path) -> std::io::Result<()> {
    if DURABLE.load(Ordering::Relaxed) { File::open(path)?.sync_all() } else { Ok(()) }
}

/// Waits until the names in the folder of `path` are on the device, if writes are durable.
pub fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    // Other systems have no such operation.
    if cfg!(unix) { sync_path(folder_of(path)) } else { Ok(()) }
}

/// The folder of `path`, `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a folder with its ancestors; if writes are durable, waits until the new names are on the
/// device.
pub fn create_folder(folder: &Path) -> std::io::Result<()> {
    if !DURABLE.load(Ordering::Relaxed) {
        return std::fs::create_dir_all(folder);
    }
    let missing: Vec<&Path> =
        folder.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).collect();
    std::fs::create_dir_all(folder)?;
    missing.into_iter().try_for_each(sync_folder_of)
}
