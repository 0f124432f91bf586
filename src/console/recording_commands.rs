//! Commands for recordings, which are ordinary logs: `record`, `save`, `load`, `export`.

use crate::files::names;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::batch::open_log_of;
use crate::console::arguments::Arguments;
use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::export::{self, Selection, TableFormat, TextFormat};
use crate::files::input;
use crate::files::{Made, RecordError, write_named};
use crate::log::{LogWriter, MessageSink, TopicGroups, Trajectory};
use crate::scenario;
use crate::sim::Observer;

/// A finished recording.
pub struct Recording {
    /// Log file.
    pub path: PathBuf,
    /// Content of the log.
    pub log: Trajectory,
}

impl Recording {
    /// Reads a log that has at least one instant.
    pub fn read(path: &Path) -> Result<Self, ConsoleError> {
        let log = Trajectory::read(path)?;
        if log.times.is_empty() {
            return Err(ConsoleError::usage(format!("{}: it holds no instant", path.display())));
        }
        Ok(Recording { path: path.to_owned(), log })
    }

    /// First and last time, s.
    pub fn span(&self) -> (f64, f64) {
        (self.log.times[0], self.log.times[self.log.times.len() - 1])
    }
}

impl Session {
    /// Opens a log file for this session.
    pub(super) fn log_writer(&self, path: &Path, topics: TopicGroups) -> Result<LogWriter, ConsoleError> {
        self.log_to((Some(path), None), topics)
    }

    /// Opens a log for this session that writes to a file, to live clients, or both.
    pub(super) fn log_to(
        &self,
        to: (Option<&Path>, Option<Box<dyn MessageSink>>),
        topics: TopicGroups,
    ) -> Result<LogWriter, ConsoleError> {
        let key = scenario::key(&[("session", self.run.resolved_toml.as_bytes())]);
        let plant = self.simulation.plant();
        let method = self.run.scenario.contact.method.name();
        Ok(open_log_of(to, &self.run, &key, &self.robot, (&plant.model, &plant.floor), method, topics)?)
    }

    pub(super) fn record(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        if args.take("stop") {
            args.done()?;
            return match self.stop_recording()? {
                true => Ok(self.recording_status()),
                false => Err(ConsoleError::usage("nothing is being recorded")),
            };
        }
        args.done()?;
        self.check_running()?;
        if self.observer.log.is_some() {
            return Err(ConsoleError::usage("a recording is being made: `record stop` ends it"));
        }
        if self.run.scenario.log.rate == 0.0 {
            return Err(ConsoleError::usage("`log.rate` is 0, so there would be nothing in it"));
        }
        self.recordings += 1;
        let path = self.folder.path().join(format!("{}.mcap", self.recordings));
        self.observer.log = Some(self.log_writer(&path, crate::batch::topics(&self.run.scenario.log.topics))?);
        (self.observer.instants, self.observer.last) = (0, None);
        // If an instant of the log rate is due now, the next step records it.
        if self.simulation.has_begun() && !self.simulation.snapshot_due() {
            let first = self.simulation.inspect();
            let log = self.observer.log.as_mut().map_or(Ok(()), |log| log.snapshot(&first));
            log.map_err(ConsoleError::usage)?;
            (self.observer.instants, self.observer.last) = (1, Some(first.time));
        }
        Ok(format!("recording from {} s at {} Hz\n", self.time(), self.run.scenario.log.rate))
    }

    /// Ends the active recording; returns whether there is one with content.
    pub(super) fn stop_recording(&mut self) -> Result<bool, ConsoleError> {
        if self.observer.log.is_none() {
            return Ok(false);
        }
        // As in every run, the last instant of the log is the present.
        if self.termination.is_none() && self.observer.last != Some(self.time()) {
            let last =
                if self.simulation.has_begun() { self.simulation.inspect_end() } else { self.present_snapshot()? };
            self.observer.snapshot(&last).map_err(ConsoleError::usage)?;
        }
        let Some(log) = self.observer.log.take().filter(|_| self.observer.instants > 0) else { return Ok(false) };
        log.finish()?;
        let path = self.folder.path().join(format!("{}.mcap", self.recordings));
        let recording = Recording::read(&path)?;
        (self.recording, self.cursor, self.player) = (Some(recording), None, None);
        Ok(true)
    }

    /// The last recording; an active one is ended first.
    pub(super) fn finished_recording(&mut self) -> Result<&Recording, ConsoleError> {
        self.stop_recording()?;
        let none = "there is no recording: `record` makes one, `load FILE` reads one";
        self.recording.as_ref().ok_or_else(|| ConsoleError::usage(none))
    }

    /// Status lines of the active and of the last recording.
    pub(super) fn recording_status(&self) -> String {
        let mut out = String::new();
        if self.observer.log.is_some() {
            out += &format!("recording, {} instants so far\n", self.observer.instants);
        }
        if let Some(recording) = &self.recording {
            let (from, to) = recording.span();
            let (instants, events) = (recording.log.times.len(), recording.log.events.len());
            let whose = &recording.log.info.scenario;
            out += &format!("recording of {whose}: {from} s to {to} s, {instants} instants, {events} events\n");
        }
        out
    }

    pub(super) fn save(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let what = args.need("`session` or `recording`")?.to_owned();
        let path = Session::path(args.need("a file")?);
        args.done()?;
        match what.as_str() {
            "session" => self.save_session(&path),
            "recording" => {
                let recording = self.finished_recording()?;
                let bytes = input::read(&recording.path, input::UNLIMITED);
                let bytes = bytes.map_err(|source| ConsoleError::Io { path: recording.path.clone(), source })?;
                write_named(&path, Made::Log, |out| out.write_all(&bytes).map_err(RecordError::io(&path)))?;
                Ok(format!("{}: {} instants\n", path.display(), recording.log.times.len()))
            }
            other => Err(ConsoleError::usage(format!("`session` or `recording` is wanted, not `{other}`"))),
        }
    }

    /// Writes the session as a scenario that ends at the present time.
    ///
    /// # Errors
    /// The session is at 0 s, or the file cannot be written.
    pub fn save_session(&mut self, path: &Path) -> Result<String, ConsoleError> {
        if self.time() == 0.0 {
            return Err(ConsoleError::usage("the session stands at 0 s: there is no run to be saved"));
        }
        self.document.save(path, self.time())?;
        Ok(format!("{}: {} s, {} events\n", path.display(), self.time(), self.run.events.len()))
    }

    pub(super) fn load(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let path = Session::path(args.need("a log")?);
        args.done()?;
        let path = if path.is_dir() { path.join(names::LOG) } else { path };
        let recording = Recording::read(&path)?;
        self.stop_recording()?;
        (self.recording, self.cursor, self.player) = (Some(recording), None, None);
        Ok(self.recording_status())
    }

    /// `export FILE [COLUMN ...] [OPTION=VALUE ...]`
    pub(super) fn export(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let path = Session::path(args.need("a file")?);
        let mut selection = Selection::default();
        let mut text = TextFormat::default();
        let (mut styled, mut kind, mut events) = (false, None, false);
        for word in args.rest() {
            let Some((key, value)) = word.split_once('=') else {
                selection.columns.push(word);
                continue;
            };
            let value = value.trim_matches(['"', '\'']);
            match key {
                "rate" => selection.rate = Some(positive(key, value)?),
                "from" => selection.from = Some(number(key, value)?),
                "to" => selection.to = Some(number(key, value)?),
                "format" => kind = Some(value.to_owned()),
                "events" => events = value == "true",
                _ => {
                    text.set(key, value).map_err(|error| ConsoleError::usage(error.to_string()))?;
                    styled = true;
                }
            }
        }
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let format = match kind.as_deref().unwrap_or(&ending) {
            "csv" => TableFormat::Csv,
            "parquet" => TableFormat::Parquet,
            "dat" | "txt" | "gnuplot" => TableFormat::Text(text),
            other => {
                let why = format!("`{other}` is no format: csv, parquet and gnuplot (.dat, .txt) are");
                return Err(ConsoleError::usage(why));
            }
        };
        if styled && !matches!(format, TableFormat::Text(_)) {
            return Err(ConsoleError::usage("how text looks is of format gnuplot (.dat, .txt)"));
        }
        let recording = self.finished_recording()?;
        let log = &recording.log;
        let table = if events { export::events(log, &selection) } else { export::series(log, &selection)? };
        export::write(&table, &format, &path)?;
        Ok(format!("{}: {} columns, {} rows\n", path.display(), table.columns().len(), table.rows()))
    }
}

fn number(key: &str, value: &str) -> Result<f64, ConsoleError> {
    let number = value.parse().ok().filter(|x: &f64| x.is_finite());
    number.ok_or_else(|| ConsoleError::usage(format!("`{key}` must be a number, not `{value}`")))
}

fn positive(key: &str, value: &str) -> Result<f64, ConsoleError> {
    let above = number(key, value).ok().filter(|x| *x > 0.0);
    above.ok_or_else(|| ConsoleError::usage(format!("`{key}` must be a number above 0, not `{value}`")))
}
