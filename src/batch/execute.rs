//! The threads: each takes the next job of the plan until there is none or the gate is closed.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::time::Instant;

use super::cancel::Gate;
use super::event::Event;
use super::{Body, Cancellation, Job, Options, run};

/// Runs jobs on every thread of the pool and tells `events` of each; returns when no thread works any more.
pub(super) fn execute(
    pool: &rayon::ThreadPool,
    jobs: &[Job],
    options: &Options,
    gate: &Gate,
    events: &Sender<Event>,
    body: &Body<'_>,
) {
    let _drained = Drained(events);
    // Jobs start in the order of the plan: a parallel iterator would begin in its middle.
    let next = AtomicUsize::new(0);
    let take = || jobs.get(next.fetch_add(1, Ordering::Relaxed)).filter(|_| !gate.is_closed());
    pool.broadcast(|_| {
        while let Some(job) = take() {
            let cancellation = Arc::new(Cancellation::default());
            let started = Event::Started { index: job.index, at: Instant::now(), cancellation: cancellation.clone() };
            // The dispatcher listens until `Drained`.
            let _ = events.send(started);
            let finished = Box::new(run::run(job, options, &cancellation, body));
            if options.fail_fast && !finished.accepted {
                // Here and not by the dispatcher, which would hear of it when this thread has long taken its next job.
                gate.close();
            }
            let _ = events.send(Event::Finished { index: job.index, finished });
        }
    });
}

/// Whatever happens here, the dispatcher must not wait for ever.
struct Drained<'a>(&'a Sender<Event>);

impl Drop for Drained<'_> {
    fn drop(&mut self) {
        let _ = self.0.send(Event::Drained);
    }
}
