//! `runner completions`: prints shell completion scripts.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::terminal::print;
use super::{Arguments, Exit};

/// Arguments of `completions`.
#[derive(Args, Debug)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints a script that the shell reads.
    pub fn execute(self) -> Result<Exit, Exit> {
        // Into memory first: the generator panics on a closed pipe.
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "runner", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(Exit::Success)
    }
}
