//! Scenario files from what was typed: files, and folders standing for the scenarios in them.

use std::path::{Path, PathBuf};

use super::{Exit, terminal};

/// Commands, for those who misspell one.
const COMMANDS: [&str; 14] = [
    "run",
    "check",
    "list",
    "inspect",
    "report",
    "merge",
    "submit",
    "compare",
    "export",
    "replay",
    "view",
    "schema",
    "completions",
    "man",
];

/// The files, those of a folder in alphabetical order.
pub fn scenario_files(typed: &[PathBuf]) -> Result<Vec<PathBuf>, Exit> {
    let mut files = Vec::new();
    let mut wrong = false;
    for path in typed {
        if path.is_dir() {
            match scenarios_in(path) {
                Ok(found) => files.extend(found),
                Err(error) => {
                    terminal::complain(&format!("error: cannot read {}: {error}", path.display()));
                    wrong = true;
                }
            }
        } else if let Some(command) = misspelt(path) {
            let typed = path.display();
            terminal::complain(&match path.as_os_str() == command {
                true => format!("error: a command stands before options and files: `runner {command} ...`"),
                false => format!("error: there is no file or command `{typed}`; did you mean `runner {command}`?"),
            });
            wrong = true;
        } else {
            files.push(path.clone());
        }
    }
    match (wrong, files.is_empty()) {
        (true, _) => Err(Exit::Invalid),
        (false, true) => {
            let folders: Vec<String> = typed.iter().map(|p| p.display().to_string()).collect();
            terminal::complain(&format!("nothing selected: no .toml file in {}", folders.join(", ")));
            Err(Exit::Nothing)
        }
        (false, false) => Ok(files),
    }
}

/// The absolute path of a file as text, for a command that is run elsewhere.
pub fn absolute_text(path: &Path) -> Result<String, Exit> {
    let refused = |why: &str| {
        terminal::complain(&format!("error: {}: {why}", path.display()));
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
        if path.extension().is_some_and(|e| e == "toml") && path.is_file() {
            found.push(path);
        }
    }
    // The file system has an order of its own.
    found.sort();
    Ok(found)
}

/// The command that a path which leads nowhere resembles.
fn misspelt(path: &Path) -> Option<&'static str> {
    let word = path.to_str().filter(|w| !w.contains(['.', '/', '\\']) && !path.exists())?;
    COMMANDS.into_iter().find(|command| strsim::damerau_levenshtein(word, command) <= 2)
}
