//! Standard output and standard error, which may be pipes that nobody reads any more.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use stiction::batch::{Findings, Severity};
use stiction::scenario::Diagnostic;
use stiction::text::visible::visible_lines;

use super::{Exit, colour};

/// Width of tables where there is no terminal, in characters.
const WIDTH: usize = 1000;

/// Has standard output failed to take something? What comes after a gap would mislead whoever reads it.
static GAP: AtomicBool = AtomicBool::new(false);

/// Writes results to standard output. A pipe that was closed has had all it wanted; any other trouble is an error, which is
/// told once and stays.
pub fn print(text: &str) -> Result<(), Exit> {
    if GAP.load(Ordering::Relaxed) {
        return Err(Exit::Unfinished);
    }
    let mut out = std::io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What became of something written to standard output, told if it is trouble.
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

/// Says something on standard error; if nobody listens, so be it. Names in it may have control characters, which are shown
/// and not obeyed.
pub fn complain(text: &str) {
    complain_drawn(&visible_lines(text));
}

/// The same of what is drawn already, with colours.
pub fn complain_drawn(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Says what went wrong, as a diagnostic without a place is said.
pub fn complain_of(wrong: impl Display) {
    complain_drawn(&Diagnostic::bare(&visible_lines(&wrong.to_string()), colour::on_stderr()));
}

/// Writes findings of at least this severity, of notes at most so many, then the numbers of errors and warnings.
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
    let words: Vec<String> = counts.iter().filter(|(n, _)| *n > 0).map(|(n, word)| plural(*n, word)).collect();
    if !words.is_empty() {
        complain(&words.join(", "));
    }
}

/// Columns that a table may take: of the variable COLUMNS, else of the terminal, else enough for a wide table in a file.
pub fn width() -> usize {
    let set = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok()).filter(|columns| *columns > 0);
    set.or_else(|| terminal_size::terminal_size().map(|(width, _)| usize::from(width.0))).unwrap_or(WIDTH)
}

/// `1 run`, `2 runs`
pub fn plural(n: usize, word: &str) -> String {
    if n == 1 { format!("1 {word}") } else { format!("{n} {word}s") }
}

/// `3 runs`, `3 runs and 1 reference run`
pub fn counted(runs: usize, references: usize) -> String {
    let runs = plural(runs, "run");
    if references == 0 { runs } else { format!("{runs} and {}", plural(references, "reference run")) }
}
