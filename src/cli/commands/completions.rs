//! `runner completions`: prints shell completion scripts.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::cli::Exit;
use crate::cli::terminal::print;

/// Arguments of `completions`.
#[derive(Args, Debug)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints a script that completes command lines of `command`.
    pub fn execute(self, mut command: Command) -> Result<Exit, Exit> {
        // Into memory first: the generator panics on a closed pipe.
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "runner", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(Exit::Success)
    }
}
