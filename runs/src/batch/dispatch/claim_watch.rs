//! Judges the claims of a batch while it runs, and finds the runs that they no longer need.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::batch::Plan;
use crate::batch::dispatch::event::Work;
use crate::batch::dispatch::finished_runs::Store;
use crate::batch::dispatch::schedule::Schedule;
use crate::files::RecordError;
use crate::results::SummaryRow;
use crate::results::claims::{ChangeClaim, ClaimVerdict, Tally};

use std::path::Path;

/// The claims of a batch. A part of a batch judges none: it does not know the runs of the others.
pub(in crate::batch) struct ClaimWatch<'a> {
    plan: &'a Plan,
    tally: Mutex<Tally>,
}

impl<'a> ClaimWatch<'a> {
    /// Begins with the runs that are finished already.
    ///
    /// # Errors
    /// A record cannot be read.
    pub fn new(plan: &'a Plan, finished: &Store, output: &Path) -> Result<Self, RecordError> {
        let heads = if plan.is_part() { Vec::new() } else { plan.claims.heads.clone() };
        let watch = ClaimWatch { plan, tally: Mutex::new(Tally::new(heads)) };
        if !watch.lock().is_empty() {
            for index in finished.positions() {
                watch.add(index, &*finished.row(index, plan, output)?);
            }
        }
        Ok(watch)
    }

    /// Adds a finished run; true if it decides a claim that is judged early.
    fn add(&self, index: usize, row: &SummaryRow) -> bool {
        let mut tally = self.lock();
        // Every part counts, also after a decision.
        self.plan.claims_of(index).filter(|part| tally.add(*part, row)).count() > 0
    }

    /// Adds a finished run, and drops the runs that are no longer needed from the schedule. Called
    /// by the thread of the run, before it takes its next one.
    pub fn finished(&self, work: Work, row: &SummaryRow, schedule: &Schedule<'_>) {
        if let Work::Run(index) = work
            && self.add(index, row)
        {
            schedule.drop_runs(&|index| !self.needs(index));
        }
    }

    /// True unless all claims about a run are decided without it, and there is one.
    pub fn needs(&self, index: usize) -> bool {
        let tally = self.lock();
        let mut parts = self.plan.claims_of(index).peekable();
        tally.is_empty() || parts.peek().is_none() || parts.any(|part| tally.needs(part))
    }

    /// The claims that need a baseline.
    pub fn changes(&self) -> Vec<ChangeClaim> {
        self.lock().changes()
    }

    /// The verdicts so far.
    pub fn verdicts(&self) -> Vec<ClaimVerdict> {
        self.lock().verdicts()
    }

    /// Locks the tally; a panic of another thread never leaves it inconsistent.
    fn lock(&self) -> MutexGuard<'_, Tally> {
        self.tally.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
