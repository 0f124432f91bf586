//! Schedules work: each reference just before the first run that needs it.
//!
//! A thread takes the first ready work. It waits only if all remaining runs need references that
//! other threads are computing. References need nothing, so a single thread never waits for itself.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::event::Work;
use crate::batch::run::awaited_reference::AwaitedReference;
use crate::batch::{Plan, Resumed};
use crate::results::ReferenceMotion;
use crate::sim::RunError;

/// The work of a batch, taken by several threads.
pub(in crate::batch) struct Schedule<'a> {
    plan: &'a Plan,
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    waiting: VecDeque<Work>,
    references: Vec<Reference>,
    /// Number of active runs of searches, which may choose further runs.
    probes: usize,
}

/// A reference run.
struct Reference {
    /// None until it ends, and once no run needs it.
    result: Option<Result<Arc<ReferenceMotion>, RunError>>,
    /// Runs that still need it.
    needed: usize,
}

impl<'a> Schedule<'a> {
    /// Schedules all unfinished work of a plan.
    pub fn new(plan: &'a Plan, resumed: &Resumed) -> Self {
        let mut waiting = VecDeque::with_capacity(plan.runs() + plan.references());
        let mut references: Vec<Reference> =
            (0..plan.references()).map(|_| Reference { result: None, needed: 0 }).collect();
        for index in (0..plan.runs()).filter(|index| plan.is_known(*index) && !resumed.finished.is_done(*index)) {
            if let Some(i) = plan.reference_of(index) {
                if references[i].needed == 0 {
                    waiting.push_back(Work::Reference(i));
                }
                references[i].needed += 1;
            }
            waiting.push_back(Work::Run(index));
        }
        // References of finished runs exist unless their records were removed.
        let missing = (0..references.len()).filter(|i| references[*i].needed == 0 && !resumed.references.is_done(*i));
        waiting.extend(missing.map(Work::Reference));
        Schedule { plan, state: Mutex::new(State { waiting, references, probes: 0 }), changed: Condvar::new() }
    }

    /// Takes the next ready work and its reference; none if none is left or the gate is closed.
    pub fn take(&self, gate: &Gate) -> Option<(Work, Option<AwaitedReference>)> {
        let mut state = self.lock();
        loop {
            if gate.is_closed() {
                return None;
            }
            let ready =
                state.waiting.iter().position(|work| self.reference_of(*work).is_none_or(|i| state.has_ended(i)));
            if let Some(work) = ready.and_then(|at| state.waiting.remove(at)) {
                let against = self.reference_of(work).and_then(|i| {
                    let key = self.plan.reference_key(i);
                    state.take_reference(i).map(|result| AwaitedReference { key, result })
                });
                state.probes += usize::from(self.is_probe(work));
                return Some((work, against));
            }
            if state.waiting.is_empty() && state.probes == 0 {
                return None;
            }
            // A reference or a run of a search is being computed; its end notifies `changed`.
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Removes waiting runs, and the references that only they need.
    pub fn drop_runs(&self, is_dropped: &dyn Fn(usize) -> bool) {
        let mut state = self.lock();
        let State { waiting, references, .. } = &mut *state;
        let mut dropped = vec![false; references.len()];
        waiting.retain(|work| match work {
            Work::Run(index) if is_dropped(*index) => {
                if let Some(i) = self.plan.reference_of(*index) {
                    references[i].needed -= 1;
                    dropped[i] = true;
                }
                false
            }
            _ => true,
        });
        for (i, reference) in references.iter_mut().enumerate().filter(|(i, r)| dropped[*i] && r.needed == 0) {
            reference.result = None;
            waiting.retain(|work| *work != Work::Reference(i));
        }
        self.changed.notify_all();
    }

    /// Adds runs that a search has chosen. They precede all others: further runs depend on them.
    pub fn add_runs(&self, runs: &[usize]) {
        let mut state = self.lock();
        runs.iter().rev().for_each(|index| state.waiting.push_front(Work::Run(*index)));
        self.changed.notify_all();
    }

    /// Records that a run of a search has ended, after the runs that it chooses are added.
    pub fn end_probe(&self, work: Work) {
        if self.is_probe(work) {
            self.lock().probes -= 1;
            self.changed.notify_all();
        }
    }

    fn is_probe(&self, work: Work) -> bool {
        matches!(work, Work::Run(index) if self.plan.probe_place(index).is_some())
    }

    /// Records the end of a reference and wakes waiting threads.
    pub fn end_reference(&self, reference: usize, result: Result<ReferenceMotion, RunError>) {
        let mut state = self.lock();
        let entry = &mut state.references[reference];
        if entry.result.is_none() && entry.needed > 0 {
            entry.result = Some(result.map(Arc::new));
        }
        self.changed.notify_all();
    }

    /// Position of the reference that this work needs.
    fn reference_of(&self, work: Work) -> Option<usize> {
        match work {
            Work::Run(index) => self.plan.reference_of(index),
            Work::Reference(_) | Work::Repetition(_) => None,
        }
    }

    /// Locks the state; a panic of another thread never leaves it inconsistent.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn has_ended(&self, reference: usize) -> bool {
        self.references[reference].result.is_some()
    }

    /// Returns a reference's trajectory and drops it after the last run that needs it.
    fn take_reference(&mut self, reference: usize) -> Option<Result<Arc<ReferenceMotion>, RunError>> {
        let entry = &mut self.references[reference];
        entry.needed -= 1;
        if entry.needed == 0 { entry.result.take() } else { entry.result.clone() }
    }
}
