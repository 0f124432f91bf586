//! Writes to standard output and standard error, which may be closed pipes.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::batch::{Findings, Severity};
use crate::scenario::Diagnostic;
pub use crate::text::plural::plural;
use crate::text::visible::visible_lines;

use crate::cli::{Exit, colour};

/// Width of tables where there is no terminal, in characters.
const WIDTH: usize = 1000;

/// Set once a write to standard output failed: output after a gap would mislead its reader.
static GAP: AtomicBool = AtomicBool::new(false);

/// Writes results to standard output. Only a closed pipe is no error; errors are reported once.
pub fn print(text: &str) -> Result<(), Exit> {
    if GAP.load(Ordering::Relaxed) {
        return Err(Exit::Unfinished);
    }
    let mut out = std::io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// Checks the result of a write to standard output and reports an error.
pub fn written(outcome: std::io::Result<()>) -> Result<(), Exit> {
    match outcome {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            GAP.store(true, Ordering::Relaxed);
            complain_of(format!("cannot write to standard output: {error}"));
            Err(Exit::Unfinished)
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error, ignoring failure; control characters are shown as escapes.
pub fn complain(text: &str) {
    complain_drawn(&visible_lines(text));
}

/// Like [`complain`], for text already rendered with colours.
pub fn complain_drawn(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Reports an error as a diagnostic without a position.
pub fn complain_of(wrong: impl Display) {
    complain_drawn(&Diagnostic::bare(&visible_lines(&wrong.to_string()), colour::on_stderr()));
}

/// Writes findings from this severity on, at most `notes` notes, and counts errors and warnings.
pub fn show(findings: &Findings, least: Severity, mut notes: usize) {
    let colour = colour::on_stderr();
    let hidden = if notes == 0 { 0 } else { findings.count(Severity::Note).saturating_sub(notes) };
    for finding in findings.iter().filter(|f| f.severity() >= least) {
        if finding.severity() == Severity::Note {
            if notes == 0 {
                continue;
            }
            notes -= 1;
        }
        // A blank line follows a diagnostic with an excerpt.
        let end = if finding.is_block() { "\n" } else { "" };
        complain_drawn(&format!("{}{end}", finding.render(colour)));
    }
    if hidden > 0 {
        complain(&format!("{}: `runner check` shows all", plural(hidden, "more note")));
    }
    let counts =
        [(Severity::Error, "error"), (Severity::Warning, "warning")].map(|(s, word)| (findings.count(s), word));
    let parts: Vec<String> = counts.iter().filter(|(n, _)| *n > 0).map(|(n, word)| plural(*n, word)).collect();
    if !parts.is_empty() {
        complain(&parts.join(", "));
    }
}

/// Width of tables, columns: the variable COLUMNS, else the terminal, else enough for a wide table.
pub fn width() -> usize {
    let set = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok()).filter(|columns| *columns > 0);
    set.or_else(|| terminal_size::terminal_size().map(|(width, _)| usize::from(width.0))).unwrap_or(WIDTH)
}

/// `3 runs`, `3 runs and 1 reference run`
pub fn counted(runs: usize, references: usize) -> String {
    let runs = plural(runs, "run");
    if references == 0 { runs } else { format!("{runs} and {}", plural(references, "reference run")) }
}
