//! `runner man`: manual pages, made from the same definitions as `--help`.

use std::io;
use std::path::PathBuf;

use clap::builder::{Resettable, StyledStr};
use clap::{Args, Command, ValueHint};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

use crate::cli::terminal::{complain_of, print};
use crate::cli::{Exit, exit};

/// Arguments of `man`.
#[derive(Args, Debug)]
pub struct Manual {
    /// Write one page per command to this folder: `runner.1`, `runner-run.1`, ... [default: print
    /// the first]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: Option<PathBuf>,
}

impl Manual {
    /// Prints or writes pages of `command`.
    pub fn execute(self, command: Command) -> Result<Exit, Exit> {
        let refused = |what: String| {
            move |error: io::Error| {
                complain_of(format!("cannot write {what}: {error}"));
                Exit::of_writing(&error)
            }
        };
        // `help` repeats the others and has no page.
        let mut command = command.disable_help_subcommand(true);
        command.build();
        match self.folder {
            None => {
                let (_, page) = page(command).map_err(refused("the page".into()))?;
                print(&page)?;
            }
            Some(folder) => {
                let named = folder.display().to_string();
                std::fs::create_dir_all(&folder).map_err(refused(named.clone()))?;
                let all: Vec<Command> = command.get_subcommands().cloned().chain([command.clone()]).collect();
                for command in all {
                    let written = page(command).and_then(|(name, page)| std::fs::write(folder.join(name), page));
                    written.map_err(refused(named.clone()))?;
                }
            }
        }
        Ok(Exit::Success)
    }
}

/// Name and text of a command's page.
fn page(command: Command) -> io::Result<(String, String)> {
    let codes = exit::codes(command.get_name());
    let below = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let notes = below.strip_prefix(&exit::help(command.get_name())).unwrap_or_default().trim().to_owned();
    // Exit codes and other text below the help get sections of their own.
    let command = command.after_help(Resettable::<StyledStr>::Reset).mut_args(|argument| {
        let many = argument.get_num_args().is_some_and(|count| count.max_values() > 1);
        match argument.get_value_names() {
            Some([name]) if many && argument.is_positional() => {
                // clap requires a static name; each page is generated once.
                let name: &'static str = format!("{name}{MANY}").leak();
                argument.value_name(name)
            }
            _ => argument,
        }
    });
    let man = Man::new(command);
    let mut text = Vec::new();
    man.render(&mut text)?;
    let text = String::from_utf8_lossy(&text).into_owned();
    // Dots follow the bracket, as in help texts.
    let text = text.replace(&format!("{MANY}\\fR>"), "\\fR>...").replace(&format!("{MANY}\\fR]"), "\\fR]...");
    let mut status = Roff::default();
    status.control("SH", ["EXIT STATUS"]);
    for (exit, meaning) in codes {
        status.control("TP", []).text([bold((*exit as u8).to_string())]).text([roman(*meaning)]);
    }
    if !notes.is_empty() {
        status.control("SH", ["NOTES"]).text([roman(notes.replace('\n', " "))]);
    }
    let at = text.find(".SH VERSION").unwrap_or(text.len());
    Ok((man.get_filename(), format!("{}{}{}", &text[..at], status.to_roff(), &text[at..])))
}

/// Marks names of arguments that may be given more than once.
const MANY: &str = "@";
