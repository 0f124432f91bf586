//! Session: keeps a scenario document and its simulation consistent under edits, `undo` and
//! `reset`.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use tempfile::TempDir;

use crate::assemble::setup_with;
use crate::batch::{Job, LiveClients};
use crate::console::console_error::ConsoleError;
use crate::console::cursor::Cursor;
use crate::console::player::Player;
use crate::console::recording::Recording;
use crate::console::run_goal::RunGoal;
use crate::console::scenario_document::ScenarioDocument;
use crate::console::session_observer::SessionObserver;
use crate::robot::{Model, Robot};
use crate::scenario::{Run, Scenario};
use crate::sim::{Observer, Outcome, RunError, SimEvent, Simulation};

/// A console session.
///
/// [`execute`](Self::execute) executes a line. Runs and playback then advance by
/// [`work`](Self::work), which the caller calls as long as [`due`](Self::due) returns a waiting
/// time.
pub struct Session {
    pub(super) document: ScenarioDocument,
    /// Initial document, for `reset`.
    initial: ScenarioDocument,
    /// Document before each edit, and the time of the edit, s; for `undo`.
    history: Vec<(ScenarioDocument, f64)>,
    pub(super) robot: Arc<Robot>,
    /// Models of the objects.
    pub(super) objects: Vec<Arc<Robot>>,
    pub(super) run: Run,
    pub(super) simulation: Simulation,
    pub(super) observer: SessionObserver,
    /// Cause of the run's early termination.
    pub(super) termination: Option<RunError>,
    /// Target of the active run.
    pub(super) goal: Option<RunGoal>,
    /// Simulated seconds per second; `None`: as fast as possible.
    pub(super) pace: Option<f64>,
    /// Wall time and simulated time, s, when the pace was set or the run started.
    pub(super) clock: Option<(Instant, f64)>,
    pub(super) player: Option<Player>,
    /// Last recording, recorded or loaded, and its instant that queries show.
    pub(super) recording: Option<Recording>,
    pub(super) cursor: Option<Cursor>,
    /// Temporary folder of recordings that are not saved.
    pub(super) folder: TempDir,
    pub(super) recordings: usize,
    /// Set by the caller to cancel the run between two steps.
    pub(super) cancel: Option<Arc<AtomicBool>>,
    /// Live clients, and the number of connections so far.
    live_clients: Option<Box<dyn LiveClients>>,
    arrivals: u64,
    /// Notes already shown.
    shown_notes: BTreeSet<String>,
    /// True once `quit` is executed.
    quit: bool,
}

impl Session {
    /// Starts a session, held at the start of the run, with the longest duration `end`, s. Without
    /// `pace` it runs as fast as possible.
    ///
    /// # Errors
    /// The robot is that of a backend, or the simulation cannot be built.
    pub fn new(job: Job, end: f64, pace: Option<f64>) -> Result<Self, ConsoleError> {
        if job.run.scenario.robot.backend.is_some() {
            let why = "the scenario's robot is remote (`robot.backend`): the console needs a simulated robot";
            return Err(ConsoleError::usage(why));
        }
        let document = ScenarioDocument::of(&job.run, end);
        let run = document.run()?;
        let simulation = simulation(&document, &run, (&job.robot, &job.objects))?;
        let io = |source| ConsoleError::Io { path: std::env::temp_dir(), source };
        let folder = tempfile::Builder::new().prefix("stiction-console-").tempdir().map_err(io)?;
        Ok(Session {
            initial: document.clone(),
            history: Vec::new(),
            document,
            robot: job.robot,
            objects: job.objects,
            run,
            simulation,
            observer: SessionObserver::default(),
            termination: None,
            goal: None,
            pace,
            clock: None,
            player: None,
            recording: None,
            cursor: None,
            folder,
            recordings: 0,
            cancel: None,
            live_clients: None,
            arrivals: 0,
            shown_notes: BTreeSet::new(),
            quit: false,
        })
    }

    /// Cancels the run between two steps, also within a tick, when `flag` is set.
    pub fn cancel_on(&mut self, flag: Arc<AtomicBool>) {
        self.cancel = Some(flag);
    }

    /// Streams the session to live clients, at the rate and with the topics of `[log]`.
    ///
    /// # Errors
    /// The stream cannot be opened.
    pub fn stream_to(&mut self, clients: Box<dyn LiveClients>, cancel: &AtomicBool) -> Result<(), ConsoleError> {
        self.live_clients = Some(clients);
        self.open_stream()?;
        self.live_clients.iter().for_each(|clients| clients.wait(cancel));
        self.refresh_stream()
    }

    /// Sends the present to clients that have connected while the run was held.
    ///
    /// # Errors
    /// The present cannot be computed.
    pub fn refresh_stream(&mut self) -> Result<(), ConsoleError> {
        let arrivals = self.live_clients.as_ref().map_or(0, |clients| clients.arrivals());
        if arrivals == self.arrivals || self.observer.live_log.is_none() || self.termination.is_some() {
            return Ok(());
        }
        self.arrivals = arrivals;
        let present = self.present_snapshot()?;
        self.observer.live_log.as_mut().map_or(Ok(()), |live| live.snapshot(&present)).map_err(ConsoleError::usage)
    }

    /// Ends the stream; returns messages for the user.
    pub fn end_stream(&mut self) -> Vec<String> {
        self.observer.live_log = None;
        let clients = self.live_clients.take();
        clients.iter().for_each(|clients| clients.finish());
        clients.iter().flat_map(|clients| clients.notes()).collect()
    }

    fn open_stream(&mut self) -> Result<(), ConsoleError> {
        if let Some(clients) = &self.live_clients {
            let topics = crate::batch::topics(&self.run.scenario.log.topics);
            self.observer.live_log = Some(self.log_to((None, Some(clients.sink())), topics)?);
        }
        Ok(())
    }

    /// True once `quit` is executed.
    pub fn has_ended(&self) -> bool {
        self.quit
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.simulation.plant().state.time
    }

    /// Prompt: time of the simulation or of the displayed recording.
    pub fn prompt(&self) -> String {
        match &self.cursor {
            Some(cursor) => format!("recording {} s> ", cursor.time),
            None => format!("{} s> ", self.time()),
        }
    }

    /// Robot model of the simulation.
    pub(super) fn model(&self) -> &Model {
        &self.simulation.plant().model
    }

    /// Scenario after the events up to now.
    pub(super) fn present(&self) -> &Scenario {
        let past = self.run.events.iter().take_while(|event| event.at <= self.time());
        past.last().map_or(&self.run.scenario, |event| &event.after.scenario)
    }

    /// Edits the scenario and continues the simulation with it; on an error nothing changes.
    pub(super) fn edit(
        &mut self,
        change: impl FnOnce(&mut ScenarioDocument) -> Result<(), ConsoleError>,
    ) -> Result<String, ConsoleError> {
        self.check_running()?;
        let mut document = self.document.clone();
        change(&mut document)?;
        let run = document.run()?;
        if self.simulation.has_begun() {
            let built = setup_with(&run, &self.robot, &self.objects);
            let mut setup = built.map_err(|found| document.scenario_error(found))?;
            let notes = std::mem::take(&mut setup.notes);
            if let Err(error) = self.simulation.continue_as(setup) {
                return Err(self.terminate(error));
            }
            self.adopt(document, run);
            Ok(self.new_notes(notes))
        } else {
            self.check_fixed_keys(&run)?;
            let simulation = simulation(&document, &run, (&self.robot, &self.objects))?;
            self.adopt(document, run);
            self.simulation = simulation;
            Ok(String::new())
        }
    }

    /// Rejects a run that changes a key which is fixed for a session.
    fn check_fixed_keys(&self, run: &Run) -> Result<(), ConsoleError> {
        let (new, old) = (&run.scenario, &self.run.scenario);
        let same = [
            ("robot.model", new.robot.model == old.robot.model),
            ("object.N.model", run.object_models().eq(self.run.object_models())),
            ("robot.inertia", new.robot.inertia == old.robot.inertia),
            ("robot.backend", new.robot.backend.is_none() && new.robot.backend_key.is_none()),
            ("control.idle_ticks", new.control.idle_ticks),
            ("duration", new.duration == old.duration),
            ("stop", new.stop == old.stop),
            ("sweep", new.sweep == old.sweep),
            ("compare", new.compare == old.compare),
            ("expect", new.expect == old.expect),
        ];
        match same.iter().find(|(_, same)| !same) {
            Some((key, _)) => Err(ConsoleError::usage(format!("`{key}` cannot be set in a session"))),
            None => Ok(()),
        }
    }

    /// Adopts an edited document and its run; keeps the former for `undo`.
    fn adopt(&mut self, document: ScenarioDocument, run: Run) {
        let time = self.time();
        self.history.push((std::mem::replace(&mut self.document, document), time));
        self.run = run;
    }

    /// Reverts the last edit: re-simulates the former document up to the time of the edit.
    pub(super) fn undo(&mut self) -> Result<String, ConsoleError> {
        let Some((document, time)) = self.history.last().cloned() else {
            return Err(ConsoleError::usage("there is no change to undo"));
        };
        self.hold();
        self.stop_recording()?;
        let run = document.run()?;
        self.simulation = simulation(&document, &run, (&self.robot, &self.objects))?;
        (self.document, self.run) = (document, run);
        (self.observer, self.termination, self.cursor) = (SessionObserver::default(), None, None);
        self.history.pop();
        self.open_stream()?;
        while self.time() < time {
            self.tick().map_err(|error| self.terminate(error))?;
        }
        Ok(format!("{} s\n", self.time()))
    }

    /// Restarts the session from its initial document.
    pub(super) fn reset(&mut self) -> Result<String, ConsoleError> {
        self.hold();
        self.stop_recording()?;
        let run = self.initial.run()?;
        self.simulation = simulation(&self.initial, &run, (&self.robot, &self.objects))?;
        (self.document, self.run) = (self.initial.clone(), run);
        self.history.clear();
        (self.observer, self.termination, self.clock, self.cursor) = (SessionObserver::default(), None, None, None);
        self.open_stream()?;
        Ok(String::new())
    }

    pub(super) fn quit(&mut self) {
        self.quit = true;
    }

    /// Error if the run has terminated.
    pub(super) fn check_running(&self) -> Result<(), ConsoleError> {
        match &self.termination {
            Some(error) => Err(ConsoleError::Terminated { time: self.time(), error: error.clone() }),
            None => Ok(()),
        }
    }

    /// Records the termination of the run; returns its error.
    pub(super) fn terminate(&mut self, error: RunError) -> ConsoleError {
        self.goal = None;
        self.termination = Some(error.clone());
        ConsoleError::Terminated { time: self.time(), error }
    }

    /// Text of notes that have not been shown yet.
    fn new_notes(&mut self, notes: Vec<String>) -> String {
        let new = notes.into_iter().filter(|note| self.shown_notes.insert(note.clone()));
        new.map(|note| format!("note: {note}\n")).collect()
    }

    pub(super) fn status(&self) -> String {
        let scenario = self.present();
        let mut out = String::new();
        let ticks = (self.time() * scenario.control.rate).round();
        let what = match (&self.termination, &self.goal) {
            (Some(error), _) => format!("ended: {}", error.message),
            (None, Some(goal)) => format!("running until {goal}"),
            (None, None) => "held".to_owned(),
        };
        let rate = self.pace.map_or("as fast as possible".to_owned(), |pace| format!("at {pace} times real time"));
        let _ = writeln!(out, "{} s of {} s, tick {ticks}, {what}, {rate}", self.time(), self.simulation.end());
        let method = (scenario.contact.method.name(), scenario.integrator.method.name());
        let _ = writeln!(out, "robot {}, contact {}, integrator {}", self.model().name, method.0, method.1);
        let entries =
            [("tasks", scenario.task.len()), ("forces", scenario.force.len()), ("events", self.run.events.len())];
        let counts: Vec<_> = entries.iter().map(|(what, count)| format!("{what} {count}")).collect();
        let _ = writeln!(out, "{}", counts.join(", "));
        out + &self.recording_status()
    }

    /// Text of events, one per line.
    pub(super) fn event_lines(events: &[&SimEvent]) -> String {
        let line = |e: &&SimEvent| format!("{:.6} {} {} {}", e.time, e.kind, e.subject, e.message);
        events.iter().map(|e| line(e).split_whitespace().collect::<Vec<_>>().join(" ") + "\n").collect()
    }

    /// Path of a file argument, relative to the working directory.
    pub(super) fn path(argument: &str) -> PathBuf {
        PathBuf::from(argument)
    }
}

/// Builds the simulation of a run.
pub(super) fn simulation(
    document: &ScenarioDocument,
    run: &Run,
    (robot, objects): (&Robot, &[Arc<Robot>]),
) -> Result<Simulation, ConsoleError> {
    let setup = setup_with(run, robot, objects).map_err(|found| document.scenario_error(found))?;
    Simulation::new(setup).map_err(|error| match error.outcome {
        Outcome::Error => ConsoleError::usage(error.message),
        _ => ConsoleError::Terminated { time: 0.0, error },
    })
}
