//! Timing: finished runs once more, one at a time, nothing else at work.
//!
//! Rounds are interleaved: every run once, then every run again, so that a slow minute of the machine falls on all of them.
//! Timed is the simulation from its first decision to its last step. Building it, logs, comparisons and files are not.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;
use std::time::Instant;

use super::cancel::Gate;
use super::clock::{Clock, Lap};
use super::event::{Event, Work};
use super::execute::Drained;
use super::{Cancellation, Job, Plan, guard};
use crate::sim::build::setup;
use crate::sim::{Blind, Outcome, Setup, Simulation};

/// Repeats each of these runs as often as it asks for and tells `events` of it.
pub(super) fn repeat(plan: &Plan, runs: &[usize], gate: &Gate, events: &Sender<Event>) {
    let _drained = Drained(events);
    let rounds = runs.iter().map(|run| plan.repetitions_of(*run)).max().unwrap_or(0);
    for round in 1..=rounds {
        let due = || runs.iter().filter(|run| plan.repetitions_of(**run) >= round);
        let _ = events.send(Event::Round { round, rounds, runs: due().count() });
        for &index in due() {
            if gate.is_closed() {
                return;
            }
            let cancellation = Arc::new(Cancellation::default());
            let (work, job) = (Work::Repetition(index), plan.job(index));
            let at = Instant::now();
            let _ = events.send(Event::Started { work, job: None, at, cancellation: cancellation.clone() });
            let lap = guard::catch(|| time(&job, cancellation.flag())).unwrap_or_else(Err);
            let _ = events.send(Event::Timed { index, lap });
        }
    }
}

/// The times of one repetition.
fn time(job: &Job, cancel: &AtomicBool) -> Result<Lap, String> {
    let setup = setup(&job.run, &job.robot).map_err(|errors| errors.to_string())?;
    let mut simulation = Simulation::new(Setup { log_rate: 0.0, ..setup }).map_err(|stop| stop.message)?;
    let clock = Clock::start();
    let (outcome, message) = simulation.run(&mut Blind, cancel);
    let lap = clock.lap();
    match outcome {
        Outcome::Passed | Outcome::Fallen => Ok(lap),
        _ => Err(format!("{}: {message}", outcome.name())),
    }
}
