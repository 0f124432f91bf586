//! Interactive terminal: line editing, completion and history, while the run continues.

use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::console::{Names, Session, complete};
use crate::text::visible::visible_lines;
use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{Config, Context, Editor, ExternalPrinter, Helper};

use super::{Interruption, exit_of, worse};
use crate::cli::terminal::{complain, complain_of};
use crate::cli::{Exit, colour};

/// Input at the terminal.
enum Input {
    Line(String),
    /// Ctrl-C.
    Hold,
    /// Ctrl-D.
    End,
}

/// State shared by the two threads: names for completion, and the prompt.
#[derive(Default)]
struct Shared {
    names: Names,
    prompt: String,
}

struct LineHelper {
    known: Arc<Mutex<Shared>>,
    files: FilenameCompleter,
}

impl Helper for LineHelper {}
impl rustyline::highlight::Highlighter for LineHelper {}
impl rustyline::hint::Hinter for LineHelper {
    type Hint = String;
}
impl rustyline::validate::Validator for LineHelper {}

impl Completer for LineHelper {
    type Candidate = Pair;

    fn complete(&self, line: &str, end: usize, context: &Context) -> rustyline::Result<(usize, Vec<Pair>)> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let (begin, found) = complete(&known.names, line, end);
        let Some(found) = found else { return self.files.complete(line, end, context) };
        Ok((begin, found.into_iter().map(|word| Pair { display: word.clone(), replacement: word }).collect()))
    }
}

/// History file, in the state folder of the XDG base directory specification.
fn history_file() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state"));
    Some(state.filter(|path| path.is_absolute()).or_else(home)?.join("stiction").join("console-history"))
}

/// Executes lines from the terminal until the session ends.
pub fn execute_lines(session: &mut Session, stop: &Interruption) -> Result<Exit, Exit> {
    let cannot = |error: ReadlineError| {
        complain_of(format!("the terminal cannot be used: {error}"));
        Exit::Unfinished
    };
    let config = Config::builder().auto_add_history(true).build();
    let mut editor: Editor<LineHelper, FileHistory> = Editor::with_config(config).map_err(cannot)?;
    let known = Arc::new(Mutex::new(Shared { names: session.names(), prompt: session.prompt() }));
    editor.set_helper(Some(LineHelper { known: known.clone(), files: FilenameCompleter::new() }));
    let mut printer = editor.create_external_printer().map_err(cannot)?;
    let (lines, typed) = mpsc::channel();
    // The next prompt appears when the command has finished, or its run has started.
    let (go, may_go) = mpsc::channel();
    let shared = known.clone();
    let reader = std::thread::Builder::new().name("lines".into()).spawn(move || read(editor, &shared, &lines, &may_go));
    reader.map_err(|error| cannot(ReadlineError::Io(error)))?;
    complain("`help` lists the commands; Ctrl-C holds, Ctrl-D ends");
    let mut end = Exit::Success;
    let mut show = |text: &str| {
        if !text.is_empty() && printer.print(visible_lines(text)).is_err() {
            complain(text.trim_end());
        }
    };
    let _ = go.send(());
    while !session.has_ended() {
        if let Some(exit) = stop.exit() {
            return Err(exit);
        }
        let word = match next(&typed, session.due()) {
            Ok(word) => word,
            // The reader thread has ended.
            Err(()) => break,
        };
        let has_input = word.is_some();
        let done = match word {
            Some(Input::Line(line)) => session.execute(&line).map(|output| show(&output)),
            Some(Input::Hold) => {
                show(&session.hold());
                Ok(())
            }
            Some(Input::End) => break,
            None => session.refresh_stream().and_then(|()| session.work(&mut show)),
        };
        if let Err(error) = done {
            show(&(error.render(colour::on_stderr()) + "\n"));
            // The session continues after an error.
            if exit_of(&error) == Exit::Failed {
                end = worse(end, Exit::Failed);
            }
        }
        if has_input {
            let now = Shared { names: session.names(), prompt: session.prompt() };
            *known.lock().unwrap_or_else(PoisonError::into_inner) = now;
            let _ = go.send(());
        }
    }
    Ok(end)
}

/// The next input, or `None` when work is due.
fn next(typed: &Receiver<Input>, due: Option<Duration>) -> Result<Option<Input>, ()> {
    // Wake up regularly to check for signals.
    let wait = due.unwrap_or(Duration::from_millis(200)).min(Duration::from_millis(200));
    match typed.recv_timeout(wait) {
        Ok(word) => Ok(Some(word)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => Err(()),
    }
}

/// Reads the terminal; runs on a thread of its own.
fn read(mut editor: Editor<LineHelper, FileHistory>, known: &Mutex<Shared>, to: &Sender<Input>, may_go: &Receiver<()>) {
    let history = history_file();
    if let Some(path) = &history {
        // The first session has no history.
        let _ = editor.load_history(path);
    }
    while may_go.recv().is_ok() {
        let prompt = known.lock().unwrap_or_else(PoisonError::into_inner).prompt.clone();
        let word = match editor.readline(&prompt) {
            Ok(line) => Input::Line(line),
            Err(ReadlineError::Interrupted) => Input::Hold,
            Err(_) => Input::End,
        };
        if let (Some(path), Input::Line(_)) = (&history, &word) {
            let kept = path.parent().map_or(Ok(()), std::fs::create_dir_all);
            if kept.is_ok() {
                let _ = editor.append_history(path);
            }
        }
        if to.send(word).is_err() {
            return;
        }
    }
}
