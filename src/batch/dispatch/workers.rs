//! The threads: each takes the next work that is ready until there is none or the gate is closed.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Instant;

use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::event::{Event, Work};
use crate::batch::dispatch::schedule::Schedule;
use crate::batch::run::job_run;
use crate::batch::{Body, Cancellation, Options, Plan};

/// Does what is left of the plan's work on every thread of the pool and tells `events` of it; returns when no thread works any more.
pub(in crate::batch) fn work(
    pool: &rayon::ThreadPool,
    plan: &Plan,
    options: &Options,
    schedule: &Schedule<'_>,
    gate: &Gate,
    events: &Sender<Event>,
    body: &Body<'_>,
) {
    let _drained = Drained(events);
    // Not a parallel iterator, which would begin in the middle of the plan.
    pool.broadcast(|_| {
        while let Some((work, against)) = schedule.take(gate) {
            let job = match work {
                Work::Reference(index) => plan.reference(index),
                Work::Run(index) | Work::Repetition(index) => plan.job(index),
            };
            let job = Arc::new(job);
            let cancellation = Arc::new(Cancellation::default());
            // The dispatcher listens until `Drained`.
            let _ = events.send(Event::Started {
                work,
                job: Some(job.clone()),
                at: Instant::now(),
                cancellation: cancellation.clone(),
            });
            let mut waited_for = ReferenceGuard { schedule, work, result: None };
            let (finished, trajectory) = job_run::run(&job, options, &cancellation, body, against.as_ref());
            waited_for.result = Some(trajectory);
            drop(waited_for);
            if !finished.accepted {
                // Here and not by the dispatcher, which would hear of it when this thread has long taken its next job.
                gate.count_failure(options.max_fail);
            }
            let _ = events.send(Event::Finished { work, finished: Box::new(finished) });
        }
    });
}

/// A reference that runs may wait for: whatever happens to this thread, they hear of its end.
struct ReferenceGuard<'a, 'p> {
    schedule: &'a Schedule<'p>,
    work: Work,
    result: Option<Result<crate::results::ReferenceMotion, String>>,
}

impl Drop for ReferenceGuard<'_, '_> {
    fn drop(&mut self) {
        if let Work::Reference(index) = self.work {
            self.schedule.ended(index, self.result.take().unwrap_or_else(|| Err("it broke off".into())));
        }
    }
}

/// Whatever happens here, the dispatcher must not wait for ever.
pub(in crate::batch) struct Drained<'a>(pub &'a Sender<Event>);

impl Drop for Drained<'_> {
    fn drop(&mut self) {
        let _ = self.0.send(Event::Drained);
    }
}
