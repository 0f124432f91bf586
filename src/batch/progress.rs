//! What a person sees while a batch runs, on standard error: a bar on a terminal, else a line per finished run.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{Finished, Job};
use crate::text::visible::visible;

/// How often a bar is drawn again while nothing ends.
const TICK: Duration = Duration::from_millis(200);

/// Where progress goes.
pub enum Progress {
    /// A bar, and a line for each run that was not accepted.
    Bar(ProgressBar),
    /// A line per finished run.
    Lines,
    /// Nowhere.
    Silent,
}

impl Progress {
    /// A bar if standard error is a terminal that can move back, else lines.
    pub fn on_stderr(runs: usize) -> Self {
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        if dumb || !std::io::stderr().is_terminal() {
            return Progress::Lines;
        }
        let bar = ProgressBar::with_draw_target(Some(runs as u64), ProgressDrawTarget::stderr());
        // A template without the keys it knows is refused; this one is fixed, and the default does as well.
        if let Ok(style) = ProgressStyle::with_template("{elapsed_precise} {wide_bar} {pos}/{len} runs  {msg}") {
            bar.set_style(style);
        }
        Progress::Bar(bar)
    }

    /// How long the dispatcher may sleep before it calls [`Progress::tick`].
    pub(super) fn tick_interval(&self) -> Option<Duration> {
        matches!(self, Progress::Bar(_)).then_some(TICK)
    }

    pub(super) fn tick(&self) {
        if let Progress::Bar(bar) = self {
            bar.tick();
        }
    }

    pub(super) fn started(&self, running: usize) {
        if let Progress::Bar(bar) = self {
            bar.set_message(format!("{running} running"));
        }
    }

    pub(super) fn finished(&self, job: &Job, finished: &Finished, done: usize, runs: usize) {
        let line = line(job, finished, done, runs);
        match self {
            Progress::Bar(bar) => {
                bar.inc(1);
                if !finished.accepted {
                    bar.println(line);
                }
            }
            Progress::Lines => say(&line),
            Progress::Silent => {}
        }
    }

    /// A run has been going for longer than that and is not at its end.
    pub(super) fn slow(&self, job: &Job, limit: Duration) {
        self.say(&format!("slow: {} has been running for {} s", named(job), limit.as_secs_f64()));
    }

    /// Runs that need not be made.
    pub(super) fn skipped(&self, runs: usize) {
        if let Progress::Bar(bar) = self {
            bar.inc(runs as u64);
        }
    }

    /// A round of repetitions for timing begins.
    pub(super) fn round(&self, round: u32, rounds: u32, runs: usize) {
        let line = format!("timing: repetition {round} of {rounds}, {runs} one at a time");
        match self {
            Progress::Bar(bar) => {
                bar.inc_length(runs as u64);
                bar.set_message(line);
            }
            Progress::Lines => say(&line),
            Progress::Silent => {}
        }
    }

    /// A repetition ended.
    pub(super) fn timed(&self) {
        if let Progress::Bar(bar) = self {
            bar.inc(1);
        }
    }

    /// Something else to say.
    pub(super) fn say(&self, line: &str) {
        match self {
            Progress::Bar(bar) => bar.println(line),
            Progress::Lines => say(line),
            Progress::Silent => {}
        }
    }

    pub(super) fn end(&self) {
        if let Progress::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Nobody listening is no reason to stop.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// `push contact.method=exact`
fn named(job: &Job) -> String {
    let label = if job.label.is_empty() { String::new() } else { format!(" {}", job.label) };
    visible(&format!("{}{label}", job.run.name)).into_owned()
}

/// `[ 3/25] push contact.method=exact: passed, 5.000 s in 0.812 s`
fn line(job: &Job, finished: &Finished, done: usize, runs: usize) -> String {
    let row = &finished.row;
    let width = runs.to_string().len();
    let name = format!("[{done:>width$}/{runs}] {}", named(job));
    let times = format!("{:.3} s in {:.3} s", row.metrics.duration_s, row.wall_s);
    let words = row.message.split_whitespace().collect::<Vec<_>>().join(" ");
    let words = visible(&words);
    let message = if words.is_empty() { String::new() } else { format!(": {words}") };
    format!("{name}: {}, {times}{message}", row.outcome.name())
}
