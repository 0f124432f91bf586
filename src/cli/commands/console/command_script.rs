//! Executes lines from a file, a pipe or the command line, each before the next is read.

use std::io::{self, BufRead};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use crate::console::{ConsoleError, Session};
use crate::text::visible::visible_lines;

use super::{Interruption, exit_of};
use crate::cli::terminal::{complain, complain_drawn, complain_of, print};
use crate::cli::{Exit, colour};

/// Reads lines on a thread of its own, so that waiting for a line can be interrupted.
pub struct LineReader<'a> {
    lines: Receiver<io::Result<String>>,
    stop: &'a Interruption,
}

impl<'a> LineReader<'a> {
    /// Reads from the result of `open`, which may block on a pipe without a writer. The reader is
    /// at most one line ahead.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn new<R: BufRead>(
        open: impl FnOnce() -> io::Result<R> + Send + 'static,
        stop: &'a Interruption,
    ) -> io::Result<Self> {
        let (to, lines) = sync_channel(0);
        let read = move || {
            let all = open().map(BufRead::lines);
            let (lines, wrong) = match all {
                Ok(lines) => (Some(lines), None),
                Err(error) => (None, Some(Err(error))),
            };
            // Sending fails once the session has ended.
            let _ = wrong.into_iter().chain(lines.into_iter().flatten()).try_for_each(|line| to.send(line));
        };
        std::thread::Builder::new().name("lines".into()).spawn(read)?;
        Ok(LineReader { lines, stop })
    }
}

impl Iterator for LineReader<'_> {
    type Item = io::Result<String>;

    fn next(&mut self) -> Option<io::Result<String>> {
        while self.stop.exit().is_none() {
            match self.lines.recv_timeout(Duration::from_millis(100)) {
                Ok(line) => return Some(line),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
        }
        None
    }
}

/// Executes all lines. A failed expectation is reported and sets the exit code; any other error
/// ends the script.
pub fn execute_lines(
    session: &mut Session,
    from: &str,
    lines: impl Iterator<Item = io::Result<String>>,
    stop: &Interruption,
) -> Result<Exit, Exit> {
    let mut end = Exit::Success;
    for (i, line) in lines.enumerate() {
        let line = line.map_err(|error| {
            complain_of(format!("cannot read {from}: {error}"));
            Exit::Invalid
        })?;
        if let Err(error) = execute_line(session, &line, stop)? {
            complain_drawn(&format!("{from}:{}: {}", i + 1, error.render(colour::on_stderr())));
            end = exit_of(&error);
            if end != Exit::Failed {
                return Err(end);
            }
        }
        if session.has_ended() {
            return Ok(end);
        }
    }
    if let Some(exit) = stop.exit() {
        complain("interrupted");
        return Err(exit);
    }
    Ok(end)
}

/// Executes a line and waits for its end.
fn execute_line(session: &mut Session, line: &str, stop: &Interruption) -> Result<Result<(), ConsoleError>, Exit> {
    match session.execute(line) {
        Ok(output) => print(&visible_lines(&output))?,
        Err(error) => return Ok(Err(error)),
    }
    while let Some(due) = session.due() {
        if let Some(exit) = stop.exit() {
            complain("interrupted");
            return Err(exit);
        }
        if !due.is_zero() {
            std::thread::sleep(due.min(Duration::from_millis(100)));
        }
        let mut output = String::new();
        let worked = session.work(&mut |text| output += text);
        print(&visible_lines(&output))?;
        if let Err(error) = worked {
            if let Some(exit) = stop.exit() {
                complain("interrupted");
                return Err(exit);
            }
            return Ok(Err(error));
        }
    }
    Ok(Ok(()))
}
