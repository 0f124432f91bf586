//! A person at a terminal: lines are edited, completed and remembered, and what runs goes on meanwhile.

use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{Config, Context, Editor, ExternalPrinter, Helper};
use stiction::console::{Names, Session, complete};

use super::super::terminal::{complain, complain_of};
use super::super::{Exit, colour};
use super::{Interruption, exit_of, worse};

/// What the person does.
enum Typed {
    Line(String),
    /// Ctrl-C.
    Hold,
    /// Ctrl-D.
    End,
}

/// What both threads know: names for completion, and the prompt.
#[derive(Default)]
struct Known {
    names: Names,
    prompt: String,
}

struct Assistant {
    known: Arc<Mutex<Known>>,
    files: FilenameCompleter,
}

impl Helper for Assistant {}
impl rustyline::highlight::Highlighter for Assistant {}
impl rustyline::hint::Hinter for Assistant {
    type Hint = String;
}
impl rustyline::validate::Validator for Assistant {}

impl Completer for Assistant {
    type Candidate = Pair;

    fn complete(&self, line: &str, end: usize, context: &Context) -> rustyline::Result<(usize, Vec<Pair>)> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let (begin, found) = complete(&known.names, line, end);
        let Some(found) = found else { return self.files.complete(line, end, context) };
        Ok((begin, found.into_iter().map(|word| Pair { display: word.clone(), replacement: word }).collect()))
    }
}

/// Where lines are remembered, where the system says that such things are kept.
fn history() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state"));
    Some(state.filter(|path| path.is_absolute()).or_else(home)?.join("stiction").join("console-history"))
}

/// Reads lines until the person has enough.
pub fn talk(session: &mut Session, stop: &Interruption) -> Result<Exit, Exit> {
    let cannot = |error: ReadlineError| {
        complain_of(format!("the terminal cannot be used: {error}"));
        Exit::Unfinished
    };
    let config = Config::builder().auto_add_history(true).build();
    let mut editor: Editor<Assistant, FileHistory> = Editor::with_config(config).map_err(cannot)?;
    let known = Arc::new(Mutex::new(Known { names: session.names(), prompt: session.prompt() }));
    editor.set_helper(Some(Assistant { known: known.clone(), files: FilenameCompleter::new() }));
    let mut printer = editor.create_external_printer().map_err(cannot)?;
    let (lines, typed) = mpsc::channel();
    // One line at a time: the next prompt comes when this one has been done or has begun.
    let (go, may_go) = mpsc::channel();
    let shared = known.clone();
    let reader = std::thread::Builder::new().name("lines".into()).spawn(move || read(editor, &shared, &lines, &may_go));
    reader.map_err(|error| cannot(ReadlineError::Io(error)))?;
    complain("`help` lists the commands; Ctrl-C holds, Ctrl-D ends");
    let mut end = Exit::Success;
    let mut say = |text: &str| {
        if !text.is_empty() && printer.print(text.to_owned()).is_err() {
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
            // The reader is gone.
            Err(()) => break,
        };
        let typed_something = word.is_some();
        let done = match word {
            Some(Typed::Line(line)) => session.execute(&line).map(|shown| say(&shown)),
            Some(Typed::Hold) => {
                say(&session.hold());
                Ok(())
            }
            Some(Typed::End) => break,
            None => session.show_again().and_then(|()| session.work(&mut say)),
        };
        if let Err(error) = done {
            say(&(error.render(colour::on_stderr()) + "\n"));
            // A person sees what is wrong and goes on.
            if exit_of(&error) == Exit::Failed {
                end = worse(end, Exit::Failed);
            }
        }
        if typed_something {
            let now = Known { names: session.names(), prompt: session.prompt() };
            *known.lock().unwrap_or_else(PoisonError::into_inner) = now;
            let _ = go.send(());
        }
    }
    Ok(end)
}

/// What was typed, or none when there is something to do.
fn next(typed: &Receiver<Typed>, due: Option<Duration>) -> Result<Option<Typed>, ()> {
    // Signals are looked for now and then.
    let wait = due.unwrap_or(Duration::from_millis(200)).min(Duration::from_millis(200));
    match typed.recv_timeout(wait) {
        Ok(word) => Ok(Some(word)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => Err(()),
    }
}

/// The thread that has the terminal.
fn read(mut editor: Editor<Assistant, FileHistory>, known: &Mutex<Known>, to: &Sender<Typed>, may_go: &Receiver<()>) {
    let history = history();
    if let Some(path) = &history {
        // The first session has none.
        let _ = editor.load_history(path);
    }
    while may_go.recv().is_ok() {
        let prompt = known.lock().unwrap_or_else(PoisonError::into_inner).prompt.clone();
        let word = match editor.readline(&prompt) {
            Ok(line) => Typed::Line(line),
            Err(ReadlineError::Interrupted) => Typed::Hold,
            Err(_) => Typed::End,
        };
        if let (Some(path), Typed::Line(_)) = (&history, &word) {
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
