//! The scenario, its simulation, and how they stay one.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use tempfile::TempDir;

use crate::assemble::setup;
use crate::batch::{Job, LiveClients};
use crate::console::commands::{COMMANDS, find};
use crate::console::cursor::Cursor;
use crate::console::document::Document;
use crate::console::error::ConsoleError;
use crate::console::motion::Goal;
use crate::console::player::Player;
use crate::console::recording::Recording;
use crate::console::tap::Tap;
use crate::console::words::Words;
use crate::robot::{Model, Robot};
use crate::scenario::{Run, Scenario};
use crate::sim::{Observer, Outcome, RunError, SimEvent, Simulation};

/// A session at the console.
///
/// [`execute`](Self::execute) takes a line. What takes time is then done piece by piece: while [`due`](Self::due) says when,
/// [`work`](Self::work) is called.
pub struct Session {
    pub(super) document: Document,
    /// What `reset` returns to.
    first: Document,
    /// What `undo` returns to: the scenarios before each change, and when it was made, s.
    earlier: Vec<(Document, f64)>,
    pub(super) robot: Arc<Robot>,
    pub(super) run: Run,
    pub(super) simulation: Simulation,
    pub(super) tap: Tap,
    /// Why it goes on no more.
    pub(super) over: Option<RunError>,
    /// How far it is to run.
    pub(super) goal: Option<Goal>,
    /// Simulated seconds per second; none: as fast as it goes.
    pub(super) pace: Option<f64>,
    /// A moment and the simulated time it had, s, since the pace was set or the run went on.
    pub(super) clock: Option<(Instant, f64)>,
    pub(super) player: Option<Player>,
    /// What was recorded or loaded, and where in it queries look.
    pub(super) recording: Option<Recording>,
    pub(super) cursor: Option<Cursor>,
    /// Recordings that nobody has saved yet.
    pub(super) folder: TempDir,
    pub(super) recordings: usize,
    /// Raised to end the run between two steps.
    pub(super) cancel: Option<Arc<AtomicBool>>,
    /// People who look on, and how many have come.
    audience: Option<Box<dyn LiveClients>>,
    arrivals: u64,
    /// Notes told so far.
    told: BTreeSet<String>,
    left: bool,
}

impl Session {
    /// Begins with a run, which may be as long as `end` seconds and is paused at its start. Without `pace` it runs as fast as it
    /// goes.
    ///
    /// # Errors
    /// The run's robot is somewhere else; what the run needs is not there.
    pub fn new(job: Job, end: f64, pace: Option<f64>) -> Result<Self, ConsoleError> {
        if job.run.scenario.robot.backend.is_some() {
            let why = "the scenario's robot is somewhere else (`robot.backend`): the console is where it is simulated";
            return Err(ConsoleError::usage(why));
        }
        let document = Document::of(&job.run, end);
        let run = document.run()?;
        let simulation = simulation(&document, &run, &job.robot)?;
        let io = |source| ConsoleError::Io { path: std::env::temp_dir(), source };
        let folder = tempfile::Builder::new().prefix("stiction-console-").tempdir().map_err(io)?;
        Ok(Session {
            first: document.clone(),
            earlier: Vec::new(),
            document,
            robot: job.robot,
            run,
            simulation,
            tap: Tap::default(),
            over: None,
            goal: None,
            pace,
            clock: None,
            player: None,
            recording: None,
            cursor: None,
            folder,
            recordings: 0,
            cancel: None,
            audience: None,
            arrivals: 0,
            told: BTreeSet::new(),
            left: false,
        })
    }

    /// Ends the run between two steps when the flag is raised, wherever in a tick that is: it goes on no more then.
    pub fn end_by(&mut self, flag: Arc<AtomicBool>) {
        self.cancel = Some(flag);
    }

    /// Shows the session to people who look on, at the rate and with the topics of `[log]`.
    ///
    /// # Errors
    /// What is shown cannot be opened.
    pub fn show_to(&mut self, audience: Box<dyn LiveClients>, cancel: &AtomicBool) -> Result<(), ConsoleError> {
        self.audience = Some(audience);
        self.open_stage()?;
        self.audience.iter().for_each(|audience| audience.wait(cancel));
        self.show_again()
    }

    /// Shows the present to those who have come while nothing moved.
    ///
    /// # Errors
    /// The present cannot be computed.
    pub fn show_again(&mut self) -> Result<(), ConsoleError> {
        let arrivals = self.audience.as_ref().map_or(0, |audience| audience.arrivals());
        if arrivals == self.arrivals || self.tap.shown.is_none() || self.over.is_some() {
            return Ok(());
        }
        self.arrivals = arrivals;
        let present = self.begun_look()?;
        self.tap.shown.as_mut().map_or(Ok(()), |shown| shown.snapshot(&present)).map_err(ConsoleError::usage)
    }

    /// Ends what is shown; gives what there is to tell a person of it.
    pub fn end_show(&mut self) -> Vec<String> {
        self.tap.shown = None;
        let audience = self.audience.take();
        audience.iter().for_each(|audience| audience.farewell());
        audience.iter().flat_map(|audience| audience.told()).collect()
    }

    fn open_stage(&mut self) -> Result<(), ConsoleError> {
        if let Some(audience) = &self.audience {
            let topics = crate::batch::topics(&self.run.scenario.log.topics);
            self.tap.shown = Some(self.log_to((None, Some(audience.outlet())), topics)?);
        }
        Ok(())
    }

    /// Does what a line says, or begins to. Gives what there is to show, with its line end; an empty line does nothing.
    ///
    /// # Errors
    /// The session is then as it was.
    pub fn execute(&mut self, line: &str) -> Result<String, ConsoleError> {
        let mut words = Words::of(line)?;
        let Some(name) = words.next().map(str::to_owned) else { return Ok(String::new()) };
        let command = find(&name)?;
        (command.act)(self, &mut words).map_err(|error| match error {
            ConsoleError::Usage(why) => {
                ConsoleError::Usage(format!("{}: {why}; it is `{}`", command.name, command.usage))
            }
            other => other,
        })
    }

    /// Has `quit` been said?
    pub fn has_ended(&self) -> bool {
        self.left
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.simulation.plant().state.time
    }

    /// For the prompt: the time, and what queries look at.
    pub fn prompt(&self) -> String {
        match &self.cursor {
            Some(cursor) => format!("recording {} s> ", cursor.time),
            None => format!("{} s> ", self.time()),
        }
    }

    /// The robot.
    pub(super) fn model(&self) -> &Model {
        &self.simulation.plant().model
    }

    /// The scenario with what its events have changed until now.
    pub(super) fn present(&self) -> &Scenario {
        let past = self.run.events.iter().take_while(|event| event.at <= self.time());
        past.last().map_or(&self.run.scenario, |event| &event.after.scenario)
    }

    /// Changes the scenario; the simulation goes on as the new one's, or nothing is changed.
    pub(super) fn edit(
        &mut self,
        change: impl FnOnce(&mut Document) -> Result<(), ConsoleError>,
    ) -> Result<String, ConsoleError> {
        self.alive()?;
        let mut document = self.document.clone();
        change(&mut document)?;
        let run = document.run()?;
        if self.simulation.has_begun() {
            let mut setup = setup(&run, &self.robot).map_err(|found| document.wrong(found))?;
            let notes = std::mem::take(&mut setup.notes);
            if let Err(stop) = self.simulation.continue_as(setup) {
                return Err(self.end(stop));
            }
            self.remember(document, run);
            Ok(self.news(notes))
        } else {
            self.is_of_a_session(&run)?;
            let simulation = simulation(&document, &run, &self.robot)?;
            self.remember(document, run);
            self.simulation = simulation;
            Ok(String::new())
        }
    }

    /// What was loaded or decided when the session began stays.
    fn is_of_a_session(&self, run: &Run) -> Result<(), ConsoleError> {
        let (new, old) = (&run.scenario, &self.run.scenario);
        let same = [
            ("robot.model", new.robot.model == old.robot.model),
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

    fn remember(&mut self, document: Document, run: Run) {
        let time = self.time();
        self.earlier.push((std::mem::replace(&mut self.document, document), time));
        self.run = run;
    }

    /// Takes the last change back: what was before it is simulated again, up to where it was made.
    pub(super) fn undo(&mut self) -> Result<String, ConsoleError> {
        let Some((document, time)) = self.earlier.last().cloned() else {
            return Err(ConsoleError::usage("nothing has been changed"));
        };
        self.hold();
        self.stop_recording()?;
        let run = document.run()?;
        self.simulation = simulation(&document, &run, &self.robot)?;
        (self.document, self.run) = (document, run);
        (self.tap, self.over, self.cursor) = (Tap::default(), None, None);
        self.earlier.pop();
        self.open_stage()?;
        while self.time() < time {
            self.tick().map_err(|stop| self.end(stop))?;
        }
        Ok(format!("{} s\n", self.time()))
    }

    /// Begins anew.
    pub(super) fn reset(&mut self) -> Result<String, ConsoleError> {
        self.hold();
        self.stop_recording()?;
        let run = self.first.run()?;
        self.simulation = simulation(&self.first, &run, &self.robot)?;
        (self.document, self.run) = (self.first.clone(), run);
        self.earlier.clear();
        (self.tap, self.over, self.clock, self.cursor) = (Tap::default(), None, None, None);
        self.open_stage()?;
        Ok(String::new())
    }

    pub(super) fn leave(&mut self) {
        self.left = true;
    }

    /// Complains if the run goes on no more.
    pub(super) fn alive(&self) -> Result<(), ConsoleError> {
        match &self.over {
            Some(stop) => Err(ConsoleError::Over { time: self.time(), stop: stop.clone() }),
            None => Ok(()),
        }
    }

    /// Remembers that the run goes on no more.
    pub(super) fn end(&mut self, stop: RunError) -> ConsoleError {
        self.goal = None;
        self.over = Some(stop.clone());
        ConsoleError::Over { time: self.time(), stop }
    }

    /// Notes that nobody has seen.
    fn news(&mut self, notes: Vec<String>) -> String {
        let fresh = notes.into_iter().filter(|note| self.told.insert(note.clone()));
        fresh.map(|note| format!("note: {note}\n")).collect()
    }

    pub(super) fn status(&self) -> String {
        let scenario = self.present();
        let mut out = String::new();
        let ticks = (self.time() * scenario.control.rate).round();
        let what = match (&self.over, &self.goal) {
            (Some(stop), _) => format!("ended: {}", stop.message),
            (None, Some(goal)) => format!("running until {goal}"),
            (None, None) => "held".to_owned(),
        };
        let rate = self.pace.map_or("as fast as it goes".to_owned(), |pace| format!("at {pace} times real time"));
        let _ = writeln!(out, "{} s of {} s, tick {ticks}, {what}, {rate}", self.time(), self.simulation.end());
        let method = (scenario.contact.method.name(), scenario.integrator.method.name());
        let _ = writeln!(out, "robot {}, contact {}, integrator {}", self.model().name, method.0, method.1);
        let entries =
            [("tasks", scenario.task.len()), ("forces", scenario.force.len()), ("events", self.run.events.len())];
        let counts: Vec<_> = entries.iter().map(|(what, count)| format!("{what} {count}")).collect();
        let _ = writeln!(out, "{}", counts.join(", "));
        out + &self.recording_status()
    }

    /// The words of events, one a line.
    pub(super) fn told(events: &[&SimEvent]) -> String {
        let line = |e: &&SimEvent| format!("{:.6} {} {} {}", e.time, e.kind, e.subject, e.message);
        events.iter().map(|e| line(e).split_whitespace().collect::<Vec<_>>().join(" ") + "\n").collect()
    }

    /// Files begin where the program was started.
    pub(super) fn path(word: &str) -> PathBuf {
        PathBuf::from(word)
    }

    pub(super) fn help(word: Option<&str>) -> Result<String, ConsoleError> {
        let Some(word) = word else {
            let width = COMMANDS.iter().map(|c| c.name.len()).max().unwrap_or(0);
            let line = |c: &crate::console::Command| format!("  {:width$}  {}\n", c.name, c.short);
            let list: String = COMMANDS.iter().map(line).collect();
            return Ok(format!("{list}`help COMMAND` says more.\n"));
        };
        let command = find(word)?;
        Ok(format!("{}\n  {}.\n{}", command.usage, command.short, command.more()))
    }
}

/// The run, ready to begin.
pub(super) fn simulation(document: &Document, run: &Run, robot: &Robot) -> Result<Simulation, ConsoleError> {
    let setup = setup(run, robot).map_err(|found| document.wrong(found))?;
    Simulation::new(setup).map_err(|stop| match stop.outcome {
        Outcome::Error => ConsoleError::usage(stop.message),
        _ => ConsoleError::Over { time: 0.0, stop },
    })
}
