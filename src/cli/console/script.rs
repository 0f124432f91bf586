//! Lines from a file, a pipe or the command line: one is done before the next is read.

use std::io;
use std::time::Duration;

use stiction::link::console::{ConsoleError, Session};

use super::super::terminal::{complain, print};
use super::super::{Exit, colour};
use super::{Interruption, exit_of};

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
            complain(&format!("error: cannot read {from}: {error}"));
            Exit::Invalid
        })?;
        if let Err(error) = obey(session, &line, stop)? {
            complain(&format!("{from}:{}: {}", i + 1, error.render(colour::on_stderr())));
            end = exit_of(&error);
            if end != Exit::Failed {
                return Err(end);
            }
        }
        if session.has_ended() {
            break;
        }
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
