//! Worker threads: each takes the next ready work until none is left or the gate is closed.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use crate::results::{ReferenceMotion, RunsLog};
use crate::sim::RunError;

use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::claim_watch::ClaimWatch;
use crate::batch::dispatch::event::{Event, Work};
use crate::batch::dispatch::schedule::Schedule;
use crate::batch::dispatch::search_watch::SearchWatch;
use crate::batch::run::awaited_reference::AwaitedReference;
use crate::batch::run::job_run;
use crate::batch::{Body, Cancellation, Options, Plan, Reason};

/// What the worker threads share.
pub(in crate::batch) struct Workers<'a, 'p> {
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub schedule: &'a Schedule<'p>,
    pub claims: &'a ClaimWatch<'p>,
    pub searches: &'a SearchWatch,
    pub runs_log: &'a RunsLog,
    pub gate: &'a Gate,
    pub body: &'a Body<'a>,
}

impl Workers<'_, '_> {
    /// Executes the remaining work on all threads of the pool and sends events until all are done.
    pub fn work(&self, pool: &rayon::ThreadPool, events: &Sender<Event>) {
        let _drained = Drained(events);
        // A parallel iterator would start in the middle of the plan.
        pool.broadcast(|_| {
            while let Some((work, against)) = self.schedule.take(self.gate) {
                self.execute(work, against.as_ref(), events);
            }
        });
    }

    fn execute(&self, work: Work, against: Option<&AwaitedReference>, events: &Sender<Event>) {
        let Self { plan, options, schedule, gate, .. } = *self;
        let _probe = ProbeGuard { schedule, work };
        let job = match work {
            Work::Reference(index) => plan.reference(index),
            Work::Run(index) | Work::Repetition(index) => plan.job(index),
        };
        let job = Arc::new(job);
        let cancellation = Arc::new(Cancellation::default());
        let at = Instant::now();
        // The dispatcher receives until `Drained`.
        let _ = events.send(Event::Started { work, job: Some(job.clone()), at, cancellation: cancellation.clone() });
        let mut guard = ReferenceGuard { schedule, work, result: None };
        if options.timeout.is_some_and(|limit| at.elapsed() >= limit) {
            // A short run could end before the dispatcher sees it.
            cancellation.cancel(Reason::TimedOut);
        }
        let (finished, trajectory) = job_run::run(&job, options, &cancellation, self.body, against);
        guard.result = Some(trajectory);
        drop(guard);
        if finished.storage_full {
            // Closed here: the dispatcher would be too late for this thread's next job.
            gate.close();
        }
        if !finished.accepted {
            // Counted here for the same reason.
            gate.count_failure(options.max_fail);
        }
        let mut unlisted = None;
        if let Work::Run(_) = work
            && let Err(error) = self.runs_log.push(&finished.row)
        {
            // Further results could not be listed either.
            gate.close();
            unlisted = Some(error);
        }
        // Also here, so that this thread starts no run that is not needed.
        self.claims.finished(work, &finished.row, schedule);
        if let Work::Run(index) = work {
            schedule.add_runs(&self.searches.finished(plan, index, &finished.row));
        }
        let _ = events.send(Event::Finished { work, finished: Box::new(finished), unlisted });
    }
}

/// Reports the end of a reference even if this thread panics, so that no run waits forever.
struct ReferenceGuard<'a, 'p> {
    schedule: &'a Schedule<'p>,
    work: Work,
    result: Option<Result<ReferenceMotion, RunError>>,
}

impl Drop for ReferenceGuard<'_, '_> {
    fn drop(&mut self) {
        if let Work::Reference(index) = self.work {
            self.schedule.end_reference(
                index,
                self.result.take().unwrap_or_else(|| Err(RunError::internal("its thread panicked"))),
            );
        }
    }
}

/// Reports the end of a run of a search even if this thread panics, so that no thread waits for the
/// runs that it would have chosen.
struct ProbeGuard<'a, 'p> {
    schedule: &'a Schedule<'p>,
    work: Work,
}

impl Drop for ProbeGuard<'_, '_> {
    fn drop(&mut self) {
        self.schedule.end_probe(self.work);
    }
}

/// Sends `Drained` even on a panic, so that the dispatcher does not wait forever.
pub(in crate::batch) struct Drained<'a>(pub &'a Sender<Event>);

impl Drop for Drained<'_> {
    fn drop(&mut self) {
        let _ = self.0.send(Event::Drained);
    }
}
