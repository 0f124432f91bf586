//! Repeats finished runs for timing, one at a time with no other work.
//!
//! Rounds are interleaved: every run once, then every run again, so that a slow period of the
//! machine affects all of them. The measured time covers the simulation from its first decision to
//! its last step, without setup, logs, comparisons and files.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use crate::assemble::setup_with;
use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::event::{Event, Work};
use crate::batch::dispatch::workers::Drained;
use crate::batch::run::run_timer::{Clock, Lap};
use crate::batch::{Cancellation, Job, Plan, Reason};
use crate::files::catch_panic;
use crate::script::interruptible;
use crate::sim::{NullObserver, Outcome, RunError, Setup, Simulation};

/// Repeats each of these runs as often as its scenario requires and sends the times to `events`.
pub(in crate::batch) fn repeat(plan: &Plan, runs: &[usize], gate: &Gate, events: &Sender<Event>) {
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
            let lap = catch_panic(|| time(&job, &cancellation)).unwrap_or_else(|panic| Err(RunError::internal(panic)));
            let _ = events.send(Event::Timed { index, lap });
        }
    }
}

/// Times one repetition; an error if it did not reach its end.
fn time(job: &Job, cancellation: &Cancellation) -> Result<Lap, RunError> {
    let done = interruptible(cancellation.shared(), || advance(job, cancellation));
    // A cancelled run may fail with any error.
    done.map_err(|error| match cancellation.reason() {
        Some(Reason::TimedOut) => RunError::new(Outcome::TimedOut, "it exceeded its wall-clock limit"),
        Some(Reason::Interrupted) => RunError::new(Outcome::Cancelled, "interrupted"),
        None => error,
    })
}

fn advance(job: &Job, cancellation: &Cancellation) -> Result<Lap, RunError> {
    let setup = setup_with(&job.run, &job.robot, &job.objects).map_err(RunError::internal)?;
    let mut simulation = Simulation::new(Setup { log_rate: 0.0, ..setup })?;
    simulation.cancel_on(cancellation.shared());
    let clock = Clock::start();
    let (outcome, message) = simulation.run(&mut NullObserver, cancellation.flag());
    let lap = clock.lap();
    match outcome {
        Outcome::Passed | Outcome::Fallen => Ok(lap),
        _ => Err(RunError::new(outcome, message)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::prepare;

    /// A block whose script uses nine tenths of its budget while it is loaded.
    fn slow_to_load(folder: &std::path::Path) -> Plan {
        let robots = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/block/block.toml");
        let scenario = format!(
            "duration = 0.01\n[robot]\nmodel = {robots:?}\n[[force]]\ntype = \"script\"\nfile = \"slow.luau\"\n"
        );
        std::fs::write(folder.join("slow.luau"), "for i = 1, 9e5 do end\nfunction run() return {} end\n").unwrap();
        std::fs::write(folder.join("s.toml"), &scenario).unwrap();
        let Ok((plan, _)) = prepare(&[folder.join("s.toml")], &[], 10) else { panic!("refused:\n{scenario}") };
        plan
    }

    #[test]
    fn cancelling_a_repetition_cancels_its_scripts() {
        let folder = tempfile::tempdir().unwrap();
        let job = slow_to_load(folder.path()).job(0);
        let cost = |cancellation: &Cancellation| {
            let clock = Clock::start();
            let result = time(&job, cancellation);
            (result.map(|_| ()), clock.lap().cpu_s)
        };
        let (whole, full) = cost(&Cancellation::default());
        assert_eq!(whole, Ok(()));
        for (reason, message) in [
            (Reason::TimedOut, "timed-out: it exceeded its wall-clock limit"),
            (Reason::Interrupted, "cancelled: interrupted"),
        ] {
            let cancellation = Cancellation::default();
            cancellation.cancel(reason);
            let (ended, cpu) = cost(&cancellation);
            assert_eq!(ended.map_err(|error| error.with_outcome()), Err(message.to_owned()));
            // Without the flag the script would take most of `full` before the first step.
            assert!(cpu < 0.5 * full, "{cpu} s of processor time, {full} s when it is not cancelled");
        }
    }
}
