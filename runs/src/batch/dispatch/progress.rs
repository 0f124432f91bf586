//! Shows the progress of a batch on standard error: a bar on a terminal, else lines.

use std::cell::Cell;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::batch::{Finished, Job};
use crate::text::text_table::limited;
use crate::text::visible::visible;

/// Interval between redraws of the bar while no run ends.
const TICK: Duration = Duration::from_millis(200);

/// Number of progress lines of a batch whose runs are all accepted and fast.
const LINES: usize = 10;
/// Time without a line after which the next finished run gets one.
const SILENCE: Duration = Duration::from_secs(10);

/// Output of progress.
pub enum Progress {
    /// A bar, and a line for each run that was not accepted.
    Bar(ProgressBar),
    /// Lines for some of the finished runs.
    Lines(Lines),
    /// No output.
    Silent,
}

/// Selects the finished runs that get a line: all, or those not accepted and a few others.
pub struct Lines {
    all: bool,
    /// Instant of the last line.
    last: Cell<Instant>,
}

impl Lines {
    fn selects(&self, accepted: bool, done: usize, runs: usize, now: Instant) -> bool {
        let tenth = done * LINES / runs.max(1) > done.saturating_sub(1) * LINES / runs.max(1);
        let selected = self.all || !accepted || tenth || now.duration_since(self.last.get()) >= SILENCE;
        if selected {
            self.last.set(now);
        }
        selected
    }
}

impl Progress {
    /// A bar on a terminal that can move its cursor, else lines; `all` writes a line for each run.
    pub fn on_stderr(runs: usize, all: bool) -> Self {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        if dumb || !std::io::stderr().is_terminal() {
            return Progress::Lines(Lines { all, last: Cell::new(Instant::now()) });
        }
        let bar = ProgressBar::with_draw_target(Some(runs as u64), ProgressDrawTarget::stderr());
        // The template is fixed and valid.
        if let Ok(style) = ProgressStyle::with_template("{elapsed_precise} {wide_bar} {pos}/{len} runs  {msg}") {
            bar.set_style(style);
        }
        Progress::Bar(bar)
    }

    /// Longest time between two calls of [`Progress::tick`].
    pub(in crate::batch) fn tick_interval(&self) -> Option<Duration> {
        matches!(self, Progress::Bar(_)).then_some(TICK)
    }

    pub(in crate::batch) fn tick(&self) {
        if let Progress::Bar(bar) = self {
            bar.tick();
        }
    }

    pub(in crate::batch) fn started(&self, running: usize) {
        if let Progress::Bar(bar) = self {
            bar.set_message(format!("{running} running"));
        }
    }

    pub(in crate::batch) fn finished(&self, job: &Job, finished: &Finished, done: usize, runs: usize) {
        let line = || finished_line(job, finished, done, runs);
        match self {
            Progress::Bar(bar) => {
                bar.inc(1);
                if !finished.accepted {
                    bar.println(line());
                }
            }
            Progress::Lines(lines) if lines.selects(finished.accepted, done, runs, Instant::now()) => {
                print_line(&line());
            }
            Progress::Lines(_) | Progress::Silent => {}
        }
    }

    /// Reports a run that has exceeded `limit`.
    pub(in crate::batch) fn slow(&self, job: &Job, limit: Duration) {
        self.print_line(&format!("slow: {} has been running for {} s", display_name(job), limit.as_secs_f64()));
    }

    /// Counts runs that are already recorded.
    pub(in crate::batch) fn skipped(&self, runs: usize) {
        if let Progress::Bar(bar) = self {
            bar.inc(runs as u64);
        }
    }

    /// A round of repetitions for timing begins.
    pub(in crate::batch) fn round(&self, round: u32, rounds: u32, runs: usize) {
        let line = format!("timing: repetition {round} of {rounds}, {runs} one at a time");
        match self {
            Progress::Bar(bar) => {
                bar.inc_length(runs as u64);
                bar.set_message(line);
            }
            Progress::Lines(_) => print_line(&line),
            Progress::Silent => {}
        }
    }

    /// A repetition ended.
    pub(in crate::batch) fn timed(&self) {
        if let Progress::Bar(bar) = self {
            bar.inc(1);
        }
    }

    /// Prints a line.
    pub(in crate::batch) fn print_line(&self, line: &str) {
        match self {
            Progress::Bar(bar) => bar.println(line),
            Progress::Lines(_) => print_line(line),
            Progress::Silent => {}
        }
    }

    pub(in crate::batch) fn end(&self) {
        if let Progress::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Prints a line on standard error. A closed standard error does not stop the batch.
fn print_line(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// `push contact.method=exact`
fn display_name(job: &Job) -> String {
    let label = if job.label.is_empty() { String::new() } else { format!(" {}", job.label) };
    limited(visible(&format!("{}{label}", job.run.name)).into_owned())
}

/// `[ 3/25] push contact.method=exact: passed, 5.000 s in 0.812 s`
fn finished_line(job: &Job, finished: &Finished, done: usize, runs: usize) -> String {
    let row = &finished.row;
    let width = runs.to_string().len();
    let name = format!("[{done:>width$}/{runs}] {}", display_name(job));
    let times = format!("{:.3} s in {:.3} s", row.metrics.duration_s, row.wall_s);
    let message = row.message.split_whitespace().collect::<Vec<_>>().join(" ");
    let message = if message.is_empty() { message } else { format!(": {}", visible(&message)) };
    format!("{name}: {}, {times}{message}", row.outcome.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_batch_has_few_lines_and_a_small_one_a_line_per_run() {
        let start = Instant::now();
        let lines = |all: bool, runs: usize, accepted: fn(usize) -> bool| {
            let lines = Lines { all, last: Cell::new(start) };
            (1..=runs).filter(|done| lines.selects(accepted(*done), *done, runs, start)).count()
        };
        for runs in 0..=10 {
            assert_eq!(lines(false, runs, |_| true), runs);
        }
        assert_eq!(lines(false, 421, |_| true), 10);
        assert_eq!(lines(true, 421, |_| true), 421);
        assert_eq!(lines(false, 1000, |done| done % 100 != 7), 20);
        let few = Lines { all: false, last: Cell::new(start) };
        assert!(!few.selects(true, 3, 100, start + SILENCE / 2) && few.selects(true, 4, 100, start + SILENCE));
        assert!(!few.selects(true, 5, 100, start + SILENCE * 3 / 2), "the time counts from the last line");
    }
}
