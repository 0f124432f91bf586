//! Letting time go on: for a while, for ticks, until something happens; at a rate, and held.

use std::fmt::{Display, Formatter, Result as Written};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::console::commands::EVENTS;
use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::console::words::Words;
use crate::sim::{Outcome, RunError, SimEvent};
use crate::text::suggest;

/// How long a piece of work lasts before somebody else may have a word.
const SLICE: Duration = Duration::from_millis(10);
/// Events shown after a run.
const SHOWN: usize = 20;

/// How far to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Number of the last tick.
    tick: u64,
    rate: f64,
    /// An event that ends it before: kind, and what it is of.
    event: Option<(String, Option<String>)>,
    /// Events there were before.
    since: u64,
}

impl Display for Goal {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        match &self.event {
            Some((kind, Some(subject))) => write!(f, "{kind} {subject}"),
            Some((kind, None)) => write!(f, "{kind}"),
            None => write!(f, "{} s", self.tick as f64 / self.rate),
        }
    }
}

impl Session {
    fn tick_number(&self) -> u64 {
        (self.time() * self.rate()).round() as u64
    }

    fn rate(&self) -> f64 {
        self.run.scenario.control.rate
    }

    /// The last tick there can be.
    fn last_tick(&self) -> u64 {
        (self.simulation.end() * self.rate() + 1e-6).floor() as u64
    }

    fn go(&mut self, tick: u64, event: Option<(String, Option<String>)>) -> Result<(), ConsoleError> {
        self.alive()?;
        let last = self.last_tick();
        if self.tick_number() >= last {
            let end = self.simulation.end();
            return Err(ConsoleError::usage(format!("the session's last instant, {end} s, is reached (`--duration`)")));
        }
        if tick > last {
            let (asked, end) = (tick as f64 / self.rate(), self.simulation.end());
            return Err(ConsoleError::usage(format!("{asked} s is beyond the session's end, {end} s (`--duration`)")));
        }
        (self.player, self.cursor) = (None, None);
        self.goal = Some(Goal { tick, rate: self.rate(), event, since: self.tap.count });
        self.clock = Some((Instant::now(), self.time()));
        Ok(())
    }

    pub(super) fn run_on(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let now = self.tick_number();
        if words.take("until") {
            if let Some(time) = words.some_number() {
                words.done()?;
                let tick = (time * self.rate()).round().max(0.0) as u64;
                if tick <= now {
                    return Err(ConsoleError::usage(format!(
                        "{time} s is not after the present time, {} s",
                        self.time()
                    )));
                }
                self.go(tick, None)?;
            } else {
                let kind = words.need("a time or the kind of an event")?.to_owned();
                let subject = words.next().map(str::to_owned);
                words.done()?;
                self.can_happen(&kind, subject.as_deref())?;
                self.go(self.last_tick(), Some((kind, subject)))?;
            }
            return Ok(String::new());
        }
        match words.next() {
            Some(word) => {
                let seconds = word.parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0);
                let Some(seconds) = seconds else {
                    return Err(ConsoleError::usage(format!("a number of seconds above 0 is wanted, not `{word}`")));
                };
                words.done()?;
                let ticks = (seconds * self.rate()).round().max(1.0) as u64;
                self.go(now.saturating_add(ticks), None)?;
            }
            None => self.go(self.last_tick(), None)?,
        }
        Ok(String::new())
    }

    /// Nobody waits for what never comes.
    fn can_happen(&self, kind: &str, subject: Option<&str>) -> Result<(), ConsoleError> {
        if kind.parse::<f64>().is_ok() {
            return Err(ConsoleError::usage(format!("`{kind}` is no time")));
        }
        if !EVENTS.contains(&kind) {
            let help = suggest(kind, EVENTS.iter().copied());
            return Err(ConsoleError::usage(format!("there is no kind of event `{kind}`; {help}")));
        }
        let of_soles = ["touchdown", "liftoff", "slip", "stick", "state", "border", "forced"];
        let soles = self.model().soles.iter().map(|sole| sole.name.as_str());
        match subject.filter(|name| of_soles.contains(&kind) && !soles.clone().any(|sole| sole == *name)) {
            Some(name) => Err(ConsoleError::usage(format!("there is no sole `{name}`; {}", suggest(name, soles)))),
            None => Ok(()),
        }
    }

    pub(super) fn step_on(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let ticks = match words.next() {
            None => 1,
            Some(word) => match word.parse::<u32>() {
                Ok(ticks) if ticks > 0 => u64::from(ticks),
                _ => return Err(ConsoleError::usage(format!("a number of ticks is wanted, not `{word}`"))),
            },
        };
        words.done()?;
        self.go(self.tick_number() + ticks, None)?;
        Ok(String::new())
    }

    /// Holds what runs or is played. Gives what there is to show.
    pub fn hold(&mut self) -> String {
        self.player = None;
        match self.goal.take() {
            Some(goal) => self.arrived(goal.since),
            None => String::new(),
        }
    }

    pub(super) fn set_rate(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let word = words.need("a factor or `free`")?.to_owned();
        words.done()?;
        self.pace = match word.as_str() {
            "free" => None,
            "realtime" => Some(1.0),
            other => match other.parse().ok().filter(|times: &f64| times.is_finite() && *times > 0.0) {
                Some(times) => Some(times),
                None => {
                    let why = format!("`free`, `realtime` or a number above 0 is wanted, not `{other}`");
                    return Err(ConsoleError::usage(why));
                }
            },
        };
        self.clock = Some((Instant::now(), self.time()));
        Ok(String::new())
    }

    /// Where the simulation stands, and what has happened on the way.
    fn arrived(&self, since: u64) -> String {
        let events: Vec<&SimEvent> = self.tap.since(since).collect();
        let hidden = (self.tap.count - since).saturating_sub(SHOWN as u64);
        let shown = &events[events.len().saturating_sub(SHOWN)..];
        let before = if hidden > 0 { format!("... {hidden} events before (`events`)\n") } else { String::new() };
        format!("{before}{}{} s\n", Session::told(shown), self.time())
    }

    /// How long until there is something to do; none when nothing goes on.
    pub fn due(&self) -> Option<Duration> {
        if let Some(player) = &self.player {
            return Some(player.due());
        }
        self.goal.as_ref()?;
        let (Some(pace), Some((moment, time))) = (self.pace, self.clock) else { return Some(Duration::ZERO) };
        // The next tick is shown when its time has come.
        let ahead = (self.time() - time) / pace;
        let at = Duration::try_from_secs_f64(ahead).unwrap_or(Duration::MAX);
        Some(at.saturating_sub(moment.elapsed()))
    }

    /// Does a piece of what goes on, and shows what there is to show.
    ///
    /// # Errors
    /// The run has ended, or what it leaves cannot be written.
    pub fn work(&mut self, show: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        if self.player.is_some() {
            return self.play_on(show);
        }
        let Some(goal) = self.goal.clone() else { return Ok(()) };
        let begun = Instant::now();
        while begun.elapsed() < SLICE && self.due() == Some(Duration::ZERO) {
            let before = self.tap.count;
            if let Err(stop) = self.tick() {
                show(&self.arrived(goal.since));
                return Err(self.end(stop));
            }
            let happened = goal.event.as_ref().is_some_and(|(kind, subject)| {
                let meant = |e: &SimEvent| e.kind == kind.as_str() && subject.as_ref().is_none_or(|s| *s == e.subject);
                self.tap.since(before).any(meant)
            });
            if happened || self.tick_number() >= goal.tick {
                self.goal = None;
                show(&self.arrived(goal.since));
                if goal.event.is_some() && !happened {
                    return Err(ConsoleError::Expectation(format!("no {goal} until {} s", self.time())));
                }
                return Ok(());
            }
        }
        Ok(())
    }

    /// Simulates to the next control tick.
    pub(super) fn tick(&mut self) -> Result<(), RunError> {
        if !self.simulation.has_begun() {
            self.simulation.begin(&mut self.tap)?;
        }
        let next = (self.tick_number() + 1) as f64 / self.rate();
        let next = next.min(self.simulation.end());
        while self.time() < next {
            // A tick may be long.
            if self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return Err(RunError::new(Outcome::Cancelled, "interrupted"));
            }
            self.simulation.step(&mut self.tap)?;
        }
        Ok(())
    }
}
