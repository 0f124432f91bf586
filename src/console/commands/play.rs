//! Command `play`: prints columns of a recording line by line, at a chosen speed.

use std::time::{Duration, Instant};

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::cursor::Cursor;
use crate::console::displayed_log::columns_at;
use crate::console::player::Player;
use crate::console::session::Session;

/// Columns shown by default.
const DEFAULT_COLUMNS: [&str; 4] = ["base_x_m", "base_z_m", "base_pitch_rad", "sole.*.state"];

impl Session {
    /// `play [SPEED|free] [COLUMN ...] [rate=HZ] [from=S] [to=S]`
    pub(in crate::console) fn play(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        self.hold();
        let mut speed = Some(1.0);
        if args.take("free") {
            speed = None;
        } else if let Some(number) = args.some_number() {
            if number == 0.0 {
                return Err(ConsoleError::usage("the speed must not be 0: `jump` shows an instant"));
            }
            speed = Some(number);
        }
        let (mut columns, mut rate, mut from, mut to) = (Vec::new(), 10.0, None, None);
        for word in args.rest() {
            let Some((key, value)) = word.split_once('=') else {
                columns.push(word);
                continue;
            };
            let number = value.parse().ok().filter(|x: &f64| x.is_finite());
            let number =
                number.ok_or_else(|| ConsoleError::usage(format!("`{key}` must be a number, not `{value}`")))?;
            match key {
                "rate" if number > 0.0 => rate = number,
                "rate" => return Err(ConsoleError::usage("`rate` must be above 0")),
                "from" => from = Some(number),
                "to" => to = Some(number),
                _ => return Err(ConsoleError::usage(format!("`{key}` is none of rate, from, to"))),
            }
        }
        let backwards = speed.is_some_and(|speed| speed < 0.0);
        let at = self.cursor.map(|cursor| cursor.time);
        let recording = self.finished_recording()?;
        let (first, last) = recording.span();
        let (start, end) = if backwards { (last, first) } else { (first, last) };
        // Start at the cursor, unless playback would end there immediately.
        let from = from.or(at.filter(|at| (at - end).abs() > 1e-9)).unwrap_or(start).clamp(first, last);
        let to = to.unwrap_or(end).clamp(first, last);
        if columns.is_empty() {
            columns = DEFAULT_COLUMNS.map(str::to_owned).to_vec();
        }
        // Check the column names before any output.
        let names: Vec<String> = columns_at(&recording.log, 0, &columns)?.into_iter().map(|(name, _)| name).collect();
        if backwards && to > from || !backwards && to < from {
            return Err(ConsoleError::usage(format!("from {from} s to {to} s is against the direction of playback")));
        }
        self.player = Some(Player { columns, speed, period: 1.0 / rate, start: (from, Instant::now()), to, lines: 0 });
        Ok(names.join(" ") + "\n")
    }

    /// Shows the lines that are due.
    pub(in crate::console) fn continue_playback(&mut self, show: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let start = Instant::now();
        while let (Some(player), Some(recording)) = (&mut self.player, &self.recording) {
            if player.finished() {
                self.player = None;
                break;
            }
            if !player.due().is_zero() || start.elapsed() > Duration::from_millis(20) {
                break;
            }
            let cursor = Cursor::at(&recording.log, player.next());
            player.lines += 1;
            let values = columns_at(&recording.log, cursor.tick, &player.columns)?;
            show(&(values.into_iter().map(|(_, value)| value).collect::<Vec<_>>().join(" ") + "\n"));
            self.cursor = Some(cursor);
        }
        Ok(())
    }
}
