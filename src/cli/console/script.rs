//! Lines from a file, a pipe or the command line: one is done before the next is read.

use std::io::{self, BufRead};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use stiction::console::{ConsoleError, Session};

use super::super::terminal::{complain, complain_drawn, complain_of, print};
use super::super::{Exit, colour};
use super::{Interruption, exit_of};

/// Lines as they come, read on a thread of their own: whoever waits for one can still be asked to end.
pub struct Coming<'a> {
    lines: Receiver<io::Result<String>>,
    stop: &'a Interruption,
}

impl<'a> Coming<'a> {
    /// Of what `open` opens, which may be a pipe that nobody writes to yet. A line is read when it is wanted.
    ///
    /// # Errors
    /// There is no room for a thread.
    pub fn of<R: BufRead>(
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
            // Nobody listens any more once the session has ended.
            let _ = wrong.into_iter().chain(lines.into_iter().flatten()).try_for_each(|line| to.send(line));
        };
        std::thread::Builder::new().name("lines".into()).spawn(read)?;
        Ok(Coming { lines, stop })
    }
}

impl Iterator for Coming<'_> {
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

/// Does all lines. An expectation that does not hold is told and kept in mind; any other mistake is the end.
pub fn lines(
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
        if let Err(error) = obey(session, &line, stop)? {
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

/// Does a line to its end.
fn obey(session: &mut Session, line: &str, stop: &Interruption) -> Result<Result<(), ConsoleError>, Exit> {
    match session.execute(line) {
        Ok(shown) => print(&shown)?,
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
        let mut shown = String::new();
        let worked = session.work(&mut |text| shown += text);
        print(&shown)?;
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
