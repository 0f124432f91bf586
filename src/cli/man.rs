//! `runner man`: manual pages, made from the same definitions as `--help`.

use std::io;
use std::path::PathBuf;

use clap::{Args, CommandFactory, ValueHint};
use clap_mangen::Man;

use super::terminal::{complain, print};
use super::{Arguments, Exit};

/// Arguments of `man`.
#[derive(Args, Debug)]
pub struct Manual {
    /// Write a page per command into this folder, `runner.1`, `runner-run.1` and so on; without it the first is printed
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: Option<PathBuf>,
}

impl Manual {
    /// Prints or writes pages.
    pub fn execute(self) -> Result<Exit, Exit> {
        let refused = |what: String| {
            move |error: io::Error| {
                complain(&format!("error: cannot write {what}: {error}"));
                Exit::Invalid
            }
        };
        // `help` repeats the others and has no page.
        let command = Arguments::command().disable_help_subcommand(true);
        match self.folder {
            None => {
                let mut page = Vec::new();
                Man::new(command).render(&mut page).map_err(refused("the page".into()))?;
                print(&String::from_utf8_lossy(&page))?;
            }
            Some(folder) => {
                let named = folder.display().to_string();
                std::fs::create_dir_all(&folder).map_err(refused(named.clone()))?;
                clap_mangen::generate_to(command, &folder).map_err(refused(named))?;
            }
        }
        Ok(Exit::Success)
    }
}
