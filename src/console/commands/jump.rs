//! Commands `jump` and `now`: select an instant of the recording, or return to the simulation.

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::cursor::Cursor;
use crate::console::recording::Recording;
use crate::console::session::Session;
use crate::export::{self, Selection, Values};
use crate::log::LoggedEvent;

impl Session {
    pub(in crate::console) fn jump(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let was = self.cursor.map(|cursor| cursor.time);
        let recording = self.finished_recording()?;
        let (first, last) = recording.span();
        let now = was.unwrap_or(first);
        let mut output = String::new();
        let target = args.need("a time, `start`, `end`, `next`, `previous`, `event` or `when`")?.to_owned();
        let time = match target.as_str() {
            "start" => first,
            "end" => last,
            "next" | "previous" => {
                let event = seek(recording, now, target == "next", was.is_none(), args)?;
                output = event_line(event);
                event.time
            }
            "event" => {
                let number = args.number("the number of an event")?;
                let events = &recording.log.events;
                let event = Some(number).filter(|n| n.fract() == 0.0 && *n >= 0.0).and_then(|n| events.get(n as usize));
                let event = event.ok_or_else(|| {
                    ConsoleError::usage(format!(
                        "there is no event {number}; the recording has {} from 0",
                        events.len()
                    ))
                })?;
                output = event_line(event);
                event.time
            }
            "when" => when(recording, now, was.is_none(), args)?,
            text => relative(text, now)?,
        };
        args.done()?;
        if !(first - 1e-9..=last + 1e-9).contains(&time) {
            return Err(ConsoleError::usage(format!("{time} s is outside of the recording, {first} s to {last} s")));
        }
        let cursor = Cursor::at(&recording.log, time);
        output += &format!("recording at {} s", recording.log.times[cursor.tick]);
        self.player = None;
        self.cursor = Some(cursor);
        Ok(output + "\n")
    }

    pub(in crate::console) fn now(&mut self) -> String {
        (self.cursor, self.player) = (None, None);
        format!("simulation at {} s\n", self.time())
    }
}

/// `2.5`, `+0.1` or `-0.1`.
fn relative(text: &str, now: f64) -> Result<f64, ConsoleError> {
    let number = text.parse().ok().filter(|time: &f64| time.is_finite());
    let number = number.ok_or_else(|| ConsoleError::usage(format!("`{text}` is not a time")))?;
    Ok(if text.starts_with(['+', '-']) { now + number } else { number })
}

fn event_line(event: &LoggedEvent) -> String {
    let parts = [event.kind.as_str(), &event.subject, &event.message];
    let parts: Vec<_> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    format!("{} {}\n", event.time, parts.join(" "))
}

/// `next|previous [KIND [SUBJECT]]`: the next or previous event of a kind; of any kind if not
/// given.
fn seek<'a>(
    recording: &'a Recording,
    now: f64,
    forward: bool,
    at_start: bool,
    args: &mut Arguments,
) -> Result<&'a LoggedEvent, ConsoleError> {
    let kind = args.next().map(str::to_owned);
    let subject = args.next().map(str::to_owned);
    let matching = |e: &&LoggedEvent| {
        kind.as_ref().is_none_or(|kind| *kind == e.kind) && subject.as_ref().is_none_or(|s| *s == e.subject)
    };
    let mut all = recording.log.events.iter();
    let beyond = |time: f64| time > now + 1e-9 || at_start && time >= now;
    let found = if forward {
        all.find(|e| beyond(e.time) && matching(e))
    } else {
        all.rfind(|e| e.time < now - 1e-9 && matching(e))
    };
    let what = [kind.as_deref().unwrap_or("event"), subject.as_deref().unwrap_or("")].join(" ");
    let side = if forward { "after" } else { "before" };
    found.ok_or_else(|| ConsoleError::usage(format!("no {} {side} {now} s", what.trim())))
}

/// `when COLUMN < VALUE`: the next instant at which the condition becomes true.
fn when(recording: &Recording, now: f64, at_start: bool, args: &mut Arguments) -> Result<f64, ConsoleError> {
    let column = args.need("a column")?.to_owned();
    let sign = args.need("`<`, `>` or `=`")?.to_owned();
    let value = args.need("a value")?.to_owned();
    let log = &recording.log;
    let table = export::series(log, &Selection { columns: vec![column.clone()], ..Selection::default() })?;
    let values = table.column(&column).ok_or_else(|| ConsoleError::usage(format!("`{column}` is a pattern")))?;
    let number = value.parse::<f64>().ok();
    let holds = |i: usize| -> Result<bool, ConsoleError> {
        let real = match values {
            Values::Real(values) => values[i],
            Values::Flag(values) => Some(f64::from(u8::from(values[i]))),
            Values::Text(values) if sign == "=" => return Ok(values[i] == value),
            Values::Text(_) => {
                return Err(ConsoleError::usage(format!("`{column}` is text and can only be compared with `=`")));
            }
        };
        let Some(limit) = number else {
            return Err(ConsoleError::usage(format!("expected a number, found `{value}`")));
        };
        match sign.as_str() {
            "<" => Ok(real.is_some_and(|x| x < limit)),
            ">" => Ok(real.is_some_and(|x| x > limit)),
            "=" => Ok(real == Some(limit)),
            _ => Err(ConsoleError::usage(format!("expected `<`, `>` or `=`, found `{sign}`"))),
        }
    };
    let here = Cursor::at(log, now).tick;
    let mut before = !at_start && holds(here)?;
    for i in if at_start { here } else { here + 1 }..log.times.len() {
        let now_holds = holds(i)?;
        if now_holds && !before {
            return Ok(log.times[i]);
        }
        before = now_holds;
    }
    Err(ConsoleError::usage(format!("`{column} {sign} {value}` does not hold after {now} s")))
}
