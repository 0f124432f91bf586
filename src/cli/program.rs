//! Path of the running program, which the jobs of a cluster start too.

use std::path::PathBuf;
use std::sync::OnceLock;

/// Path given by a launcher; none: that of this process.
static LAUNCHER: OnceLock<PathBuf> = OnceLock::new();

/// Sets the path that starts this program where the process is another program's.
pub(super) fn set(launcher: PathBuf) {
    // A process executes one command line.
    let _ = LAUNCHER.set(launcher);
}

/// Path of the program.
///
/// # Errors
/// There is no such file, for example because it was replaced after its start.
pub(super) fn path() -> std::io::Result<PathBuf> {
    let path = LAUNCHER.get().cloned().map_or_else(std::env::current_exe, Ok)?;
    path.metadata().map(|_| path)
}
