//! Commands for recordings, which are ordinary logs: `record`, `save`, `load`, `export`.

use crate::files::names;
use std::io::Write;
use std::path::Path;

use crate::batch::{Scene, open_log_of};
use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::recording::Recording;
use crate::console::session::Session;
use crate::export::{self, Selection, TableFormat, TextFormat};
use crate::files::{OutputKind, RecordError, write_named};
use crate::log::{LogWriter, MessageSink, TopicGroups, read_bytes};
use crate::scenario;
use crate::sim::Observer;
use crate::sim::plant::objects::named_links;

impl Session {
    /// Opens a log file for this session.
    pub(in crate::console) fn log_writer(&self, path: &Path, topics: TopicGroups) -> Result<LogWriter, ConsoleError> {
        self.log_to((Some(path), None), topics)
    }

    /// Opens a log for this session that writes to a file, to live clients, or both.
    pub(in crate::console) fn log_to(
        &self,
        to: (Option<&Path>, Option<Box<dyn MessageSink>>),
        topics: TopicGroups,
    ) -> Result<LogWriter, ConsoleError> {
        let key = scenario::key(&[("session", self.run.resolved_toml.as_bytes())]);
        let plant = self.simulation.plant();
        let method = self.run.scenario.contact.method.name();
        let objects = named_links(plant.objects.list.iter().map(|o| (o.name.as_str(), &*o.model)));
        let scene = Scene { model: &plant.model, floor: &plant.floor, objects, terrain: &plant.terrain };
        Ok(open_log_of(to, &self.run, &key, &self.robot, &scene, method, topics)?)
    }

    pub(in crate::console) fn record(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
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
            return Err(ConsoleError::usage("a recording is active: `record stop` ends it"));
        }
        if self.run.scenario.log.rate == 0.0 {
            return Err(ConsoleError::usage("`log.rate` is 0, so the recording would be empty"));
        }
        self.recordings += 1;
        let path = self.folder.path().join(format!("{}.mcap", self.recordings));
        self.observer.log = Some(self.log_writer(&path, crate::batch::topics(&self.run.scenario.log.topics))?);
        (self.observer.instants, self.observer.last) = (0, None);
        // If an instant of the log rate is due now, the next step records it.
        if self.simulation.has_begun() && !self.simulation.snapshot_due() {
            let first = self.simulation.snapshot();
            let log = self.observer.log.as_mut().map_or(Ok(()), |log| log.snapshot(&first));
            log.map_err(ConsoleError::usage)?;
            (self.observer.instants, self.observer.last) = (1, Some(first.time));
        }
        Ok(format!("recording from {} s at {} Hz\n", self.time(), self.run.scenario.log.rate))
    }

    /// Ends the active recording; returns whether there is one with content.
    pub(in crate::console) fn stop_recording(&mut self) -> Result<bool, ConsoleError> {
        if self.observer.log.is_none() {
            return Ok(false);
        }
        // As in every run, the last instant of the log is the present.
        if self.termination.is_none() && self.observer.last != Some(self.time()) {
            let last = self.present_snapshot()?;
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
    pub(in crate::console) fn finished_recording(&mut self) -> Result<&Recording, ConsoleError> {
        self.stop_recording()?;
        let none = "there is no recording: `record` starts one, `load FILE` reads one";
        self.recording.as_ref().ok_or_else(|| ConsoleError::usage(none))
    }

    /// Status lines of the active and of the last recording.
    pub(in crate::console) fn recording_status(&self) -> String {
        let mut out = String::new();
        if self.observer.log.is_some() {
            out += &format!("recording, {} instants so far\n", self.observer.instants);
        }
        if let Some(recording) = &self.recording {
            let (from, to) = recording.span();
            let (instants, events) = (recording.log.times.len(), recording.log.events.len());
            let scenario = &recording.log.info.scenario;
            out += &format!("recording of {scenario}: {from} s to {to} s, {instants} instants, {events} events\n");
        }
        out
    }

    pub(in crate::console) fn save(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let what = args.need("`session` or `recording`")?.to_owned();
        let path = Session::path(args.need("a file")?);
        args.done()?;
        match what.as_str() {
            "session" => self.save_session(&path),
            "recording" => {
                let recording = self.finished_recording()?;
                let bytes = read_bytes(&recording.path)?;
                write_named(&path, OutputKind::Log, |out| out.write_all(&bytes).map_err(RecordError::io(&path)))?;
                Ok(format!("{}: {} instants\n", path.display(), recording.log.times.len()))
            }
            other => Err(ConsoleError::usage(format!("expected `session` or `recording`, found `{other}`"))),
        }
    }

    /// Writes the session as a scenario that ends at the present time.
    ///
    /// # Errors
    /// The session is at 0 s, or the file cannot be written.
    pub fn save_session(&mut self, path: &Path) -> Result<String, ConsoleError> {
        if self.time() == 0.0 {
            return Err(ConsoleError::usage("the session is at 0 s: there is no run to save"));
        }
        self.document.save(path, self.time())?;
        Ok(format!("{}: {} s, {} events\n", path.display(), self.time(), self.run.events.len()))
    }

    pub(in crate::console) fn load(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let path = Session::path(args.need("a log")?);
        args.done()?;
        let path = if path.is_dir() { path.join(names::LOG) } else { path };
        let recording = Recording::read(&path)?;
        self.stop_recording()?;
        (self.recording, self.cursor, self.player) = (Some(recording), None, None);
        Ok(self.recording_status())
    }

    /// `export FILE [COLUMN ...] [OPTION=VALUE ...]`
    pub(in crate::console) fn export(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let path = Session::path(args.need("a file")?);
        let mut selection = Selection::default();
        let mut text = TextFormat::default();
        let (mut has_text_options, mut kind, mut events) = (false, None, false);
        for argument in args.rest() {
            let Some((key, value)) = argument.split_once('=') else {
                selection.columns.push(argument);
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
                    has_text_options = true;
                }
            }
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let format = match kind.as_deref().unwrap_or(&extension) {
            "csv" => TableFormat::Csv,
            "parquet" => TableFormat::Parquet,
            "dat" | "txt" | "gnuplot" => TableFormat::Text(text),
            other => {
                let why = format!("unknown format `{other}`: expected csv, parquet or gnuplot (.dat, .txt)");
                return Err(ConsoleError::usage(why));
            }
        };
        if has_text_options && !matches!(format, TableFormat::Text(_)) {
            return Err(ConsoleError::usage("options of text apply to the format gnuplot (.dat, .txt) only"));
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
    let positive = number(key, value).ok().filter(|x| *x > 0.0);
    positive.ok_or_else(|| ConsoleError::usage(format!("`{key}` must be a number above 0, not `{value}`")))
}
