//! Commands that advance the simulation: `run`, `step`, `hold`, `rate`.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::run_goal::{EVENT_KINDS, RunGoal};
use crate::console::session::Session;
use crate::sim::{Outcome, RunError, SimEvent};
use crate::text::suggest;

/// Longest wall time of one call of [`Session::work`], so that input stays responsive.
const SLICE: Duration = Duration::from_millis(10);
/// Largest number of events listed after a run.
const MAX_LISTED: usize = 20;

impl Session {
    fn tick_number(&self) -> u64 {
        (self.time() * self.rate()).round() as u64
    }

    fn rate(&self) -> f64 {
        self.run.scenario.control.rate
    }

    /// Last tick of the session.
    fn last_tick(&self) -> u64 {
        (self.simulation.end() * self.rate() + 1e-6).floor() as u64
    }

    /// Starts a run to a tick or to an earlier event.
    fn start_run(&mut self, tick: u64, event: Option<(String, Option<String>)>) -> Result<(), ConsoleError> {
        self.check_running()?;
        let last = self.last_tick();
        if self.tick_number() >= last {
            let end = self.simulation.end();
            return Err(ConsoleError::usage(format!("the session's last instant, {end} s, is reached (`--duration`)")));
        }
        if tick > last {
            let (target, end) = (tick as f64 / self.rate(), self.simulation.end());
            return Err(ConsoleError::usage(format!("{target} s is beyond the session's end, {end} s (`--duration`)")));
        }
        (self.player, self.cursor) = (None, None);
        self.goal = Some(RunGoal { tick, rate: self.rate(), event, since: self.observer.count });
        self.clock = Some((Instant::now(), self.time()));
        Ok(())
    }

    pub(in crate::console) fn run(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let now = self.tick_number();
        if args.take("until") {
            if let Some(time) = args.some_number() {
                args.done()?;
                let tick = (time * self.rate()).round().max(0.0) as u64;
                if tick <= now {
                    return Err(ConsoleError::usage(format!(
                        "{time} s is not after the present time, {} s",
                        self.time()
                    )));
                }
                self.start_run(tick, None)?;
            } else {
                let kind = args.need("a time or the kind of an event")?.to_owned();
                let subject = args.next().map(str::to_owned);
                args.done()?;
                self.check_event(&kind, subject.as_deref())?;
                self.start_run(self.last_tick(), Some((kind, subject)))?;
            }
            return Ok(String::new());
        }
        match args.next() {
            Some(text) => {
                let seconds = text.parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0);
                let Some(seconds) = seconds else {
                    return Err(ConsoleError::usage(format!(
                        "expected a number of seconds greater than 0, found `{text}`"
                    )));
                };
                args.done()?;
                let ticks = (seconds * self.rate()).round().max(1.0) as u64;
                self.start_run(now.saturating_add(ticks), None)?;
            }
            None => self.start_run(self.last_tick(), None)?,
        }
        Ok(String::new())
    }

    /// Rejects unknown event kinds and soles, which would never occur.
    fn check_event(&self, kind: &str, subject: Option<&str>) -> Result<(), ConsoleError> {
        if kind.parse::<f64>().is_ok() {
            return Err(ConsoleError::usage(format!("`{kind}` is not a time")));
        }
        if !EVENT_KINDS.contains(&kind) {
            let help = suggest(kind, EVENT_KINDS.iter().copied());
            return Err(ConsoleError::usage(format!("there is no kind of event `{kind}`; {help}")));
        }
        let of_soles = ["touchdown", "liftoff", "slip", "stick", "state", "border", "forced"];
        let soles = self.model().soles.iter().map(|sole| sole.name.as_str());
        match subject.filter(|name| of_soles.contains(&kind) && !soles.clone().any(|sole| sole == *name)) {
            Some(name) => Err(ConsoleError::usage(format!("there is no sole `{name}`; {}", suggest(name, soles)))),
            None => Ok(()),
        }
    }

    pub(in crate::console) fn step(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let ticks = match args.next() {
            None => 1,
            Some(text) => match text.parse::<u32>() {
                Ok(ticks) if ticks > 0 => u64::from(ticks),
                _ => return Err(ConsoleError::usage(format!("expected a number of ticks, found `{text}`"))),
            },
        };
        args.done()?;
        self.start_run(self.tick_number() + ticks, None)?;
        Ok(String::new())
    }

    /// Holds the run or the playback. Returns the report of the run.
    pub fn hold(&mut self) -> String {
        self.player = None;
        match self.goal.take() {
            Some(goal) => self.run_report(goal.since),
            None => String::new(),
        }
    }

    pub(in crate::console) fn set_rate(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let factor = args.need("a factor or `free`")?.to_owned();
        args.done()?;
        self.pace = match factor.as_str() {
            "free" => None,
            "realtime" => Some(1.0),
            other => match other.parse().ok().filter(|times: &f64| times.is_finite() && *times > 0.0) {
                Some(times) => Some(times),
                None => {
                    let why = format!("expected `free`, `realtime` or a number greater than 0, found `{other}`");
                    return Err(ConsoleError::usage(why));
                }
            },
        };
        self.clock = Some((Instant::now(), self.time()));
        Ok(String::new())
    }

    /// Report of a run: its newest events and the present time.
    fn run_report(&self, since: u64) -> String {
        let events: Vec<&SimEvent> = self.observer.since(since).collect();
        let hidden = (self.observer.count - since).saturating_sub(MAX_LISTED as u64);
        let shown = &events[events.len().saturating_sub(MAX_LISTED)..];
        let before = if hidden > 0 { format!("... {hidden} events before (`events`)\n") } else { String::new() };
        format!("{before}{}{} s\n", Session::event_lines(shown), self.time())
    }

    /// Time until [`work`](Self::work) is due; `None` if nothing runs or is played.
    pub fn due(&self) -> Option<Duration> {
        if let Some(player) = &self.player {
            return Some(player.due());
        }
        self.goal.as_ref()?;
        let (Some(pace), Some((moment, time))) = (self.pace, self.clock) else { return Some(Duration::ZERO) };
        // Wait until wall time has reached the simulated time.
        let ahead = (self.time() - time) / pace;
        let at = Duration::try_from_secs_f64(ahead).unwrap_or(Duration::MAX);
        Some(at.saturating_sub(moment.elapsed()))
    }

    /// Advances the run or the playback for a short time slice and passes output to `show`.
    ///
    /// # Errors
    /// The run has terminated early, an expected event did not occur, or a file cannot be written.
    pub fn work(&mut self, show: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        if self.player.is_some() {
            return self.continue_playback(show);
        }
        let Some(goal) = self.goal.clone() else { return Ok(()) };
        let start = Instant::now();
        while start.elapsed() < SLICE && self.due() == Some(Duration::ZERO) {
            let before = self.observer.count;
            if let Err(error) = self.tick() {
                show(&self.run_report(goal.since));
                return Err(self.terminate(error));
            }
            let occurred = goal.event.as_ref().is_some_and(|(kind, subject)| {
                let matching =
                    |e: &SimEvent| e.kind == kind.as_str() && subject.as_ref().is_none_or(|s| *s == e.subject);
                self.observer.since(before).any(matching)
            });
            if occurred || self.tick_number() >= goal.tick {
                self.goal = None;
                show(&self.run_report(goal.since));
                if goal.event.is_some() && !occurred {
                    return Err(ConsoleError::Expectation(format!("no {goal} until {} s", self.time())));
                }
                return Ok(());
            }
        }
        Ok(())
    }

    /// Simulates to the next control tick.
    pub(in crate::console) fn tick(&mut self) -> Result<(), RunError> {
        if !self.simulation.has_begun() {
            self.cancel.iter().for_each(|flag| self.simulation.cancel_on(flag.clone()));
            self.simulation.begin(&mut self.observer)?;
        }
        let next = (self.tick_number() + 1) as f64 / self.rate();
        let next = next.min(self.simulation.end());
        while self.time() < next {
            // Check between steps: a tick may take long.
            if self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return Err(RunError::new(Outcome::Cancelled, "interrupted"));
            }
            self.simulation.step(&mut self.observer)?;
        }
        Ok(())
    }
}
