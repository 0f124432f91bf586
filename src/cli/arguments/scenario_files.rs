//! Resolves command-line paths to scenario files; a folder stands for the scenarios in it.

use std::path::{Path, PathBuf};

use crate::cli::{Exit, terminal};

/// Command names, for suggestions on a misspelt one.
const COMMANDS: [&str; 16] = [
    "run",
    "check",
    "list",
    "inspect",
    "report",
    "merge",
    "motor-server",
    "console",
    "submit",
    "compare",
    "export",
    "replay",
    "view",
    "schema",
    "completions",
    "man",
];

/// Why there are no files.
pub enum Unusable {
    /// The errors in the arguments.
    Wrong(Vec<String>),
    /// The folders contain no scenario.
    Nothing(String),
}

/// Returns the files; those of a folder in alphabetical order.
pub fn scenario_files(typed: &[PathBuf]) -> Result<Vec<PathBuf>, Unusable> {
    let mut files = Vec::new();
    let mut wrong = Vec::new();
    for path in typed {
        if path.is_dir() {
            match scenarios_in(path) {
                Ok(found) => files.extend(found),
                Err(error) => wrong.push(format!("cannot read {}: {error}", path.display())),
            }
        } else if let Some(command) = misspelt(path) {
            let typed = path.display();
            wrong.push(match path.as_os_str() == command {
                true => format!("put the command before options and files: `runner {command} ...`"),
                false => format!("there is no file or command `{typed}`; did you mean `runner {command}`?"),
            });
        } else {
            files.push(path.clone());
        }
    }
    match (wrong.is_empty(), files.is_empty()) {
        (false, _) => Err(Unusable::Wrong(wrong)),
        (true, true) => {
            let folders: Vec<String> = typed.iter().map(|p| p.display().to_string()).collect();
            Err(Unusable::Nothing(format!("no .toml file in {}", folders.join(", "))))
        }
        (true, false) => Ok(files),
    }
}

/// The absolute path of a file as text, for a command on another machine.
pub fn absolute_text(path: &Path) -> Result<String, Exit> {
    let refused = |why: &str| {
        terminal::complain_of(format!("{}: {why}", path.display()));
        Exit::Invalid
    };
    let whole = std::path::absolute(path).map_err(|error| refused(&error.to_string()))?;
    whole.into_os_string().into_string().map_err(|_| refused("a path with bytes that are no UTF-8 cannot be submitted"))
}

/// Scenario files directly in a folder.
fn scenarios_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        // A dangling link counts as a scenario, so that loading it reports the error.
        let lost = path.is_symlink() && !path.exists();
        if path.extension().is_some_and(|e| e == "toml") && (path.is_file() || lost) {
            found.push(path);
        }
    }
    // Directory order depends on the file system.
    found.sort();
    Ok(found)
}

/// The command that a nonexistent path resembles.
fn misspelt(path: &Path) -> Option<&'static str> {
    let word = path.to_str().filter(|w| !w.contains(['.', '/', '\\']) && !path.exists())?;
    COMMANDS.into_iter().find(|command| strsim::damerau_levenshtein(word, command) <= 2)
}
