//! A fake Slurm: shell scripts with the names of its programs, in the folder `slurm`. Each appends its
//! arguments to `calls`, one per line, with an empty line after the last. Files next to `calls` control how
//! they behave.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the fake programs.
pub struct Slurm {
    folder: PathBuf,
}

impl Slurm {
    pub fn new(folder: &Path) -> Self {
        let slurm = Slurm { folder: folder.to_owned() };
        fs::create_dir_all(slurm.programs()).unwrap();
        // Links, as a file that was just written may still be open in a process that is being started, and then
        // cannot be executed.
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/submit/slurm");
        for name in ["scontrol", "sbatch", "squeue", "scancel"] {
            symlink(scripts.join(name), slurm.programs().join(name)).unwrap();
        }
        slurm
    }

    fn programs(&self) -> PathBuf {
        self.folder.join("bin")
    }

    /// Puts the programs first on PATH.
    pub fn put_on_path(&self, command: &mut Command) {
        let path = std::env::var("PATH").unwrap();
        command.env("PATH", format!("{}:{path}", self.programs().display()));
    }

    /// Removes a program. No other program of this name may be on PATH.
    pub fn without(&self, name: &str) -> &Self {
        fs::remove_file(self.programs().join(name)).unwrap();
        self
    }

    /// Writes a file that controls the programs.
    pub fn set(&self, name: &str, text: &str) -> &Self {
        fs::write(self.folder.join(name), text).unwrap();
        self
    }

    pub fn unset(&self, name: &str) -> &Self {
        fs::remove_file(self.folder.join(name)).unwrap();
        self
    }

    /// Recorded calls, each with the program's name first.
    pub fn calls(&self) -> Vec<Vec<String>> {
        let text = fs::read_to_string(self.folder.join("calls")).unwrap_or_default();
        let calls = text.split("\n\n").filter(|call| !call.is_empty());
        calls.map(|call| call.lines().map(str::to_owned).collect()).collect()
    }

    /// Names of the called programs, in order.
    pub fn called(&self) -> Vec<String> {
        self.calls().into_iter().map(|call| call[0].clone()).collect()
    }

    /// Deletes the recorded calls.
    pub fn clear_calls(&self) {
        let _ = fs::remove_file(self.folder.join("calls"));
    }
}
