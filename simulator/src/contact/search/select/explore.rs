//! Expands candidates of the state search: tests their neighbours.

use super::{SearchOrder, Selector, Task, order};
use crate::contact::model::state::{Mode, SoleState};
use crate::contact::search::moves::Moves;

impl Selector {
    /// Expands the best candidates until one is valid and none of its smaller neighbours beats it,
    /// or until `limit` candidates were tested without success.
    pub(super) fn explore(&mut self, task: &mut Task, unchanged: bool, completing: bool, limit: usize) {
        loop {
            if task.is_ended() || task.tested >= limit && !self.is_found() {
                break;
            }
            let best = (0..self.queue.len())
                .filter(|&i| !self.queue[i].expanded)
                .min_by(|&a, &b| order(&self.queue[a], &self.queue[b]));
            let Some(best) = best else { break };
            let entry = self.queue[best].clone();
            if self.queue.iter().any(|e| e.expanded && e.assessment.valid() && order(e, &entry).is_le()) {
                break;
            }
            self.queue[best].expanded = true;
            if entry.assessment.valid() && unchanged {
                break;
            }
            let soles = task.p.soles.len();
            let screens = self.order == SearchOrder::Direct && entry.assessment.valid() && !completing;
            for s in 0..soles {
                let faults = entry.assessment.faults[s];
                let mut moves = Moves::default();
                moves.suggest(task.p, s, entry.states[s], faults, entry.assessment.valid());
                if screens && !moves.states().is_empty() {
                    self.restore(task, &entry);
                    self.screen.condense(&mut self.solver, task.p, &entry.states, s);
                    let (screen, solver) = (&mut self.screen, &mut self.solver);
                    moves.retain(|state| !screen.excludes(solver, task.p, state, &task.rules));
                }
                for &state in moves.states() {
                    if task.is_ended() || task.tested >= limit && !self.is_found() {
                        return;
                    }
                    let mut next = entry.states.clone();
                    next[s] = state;
                    if completing {
                        self.complete(task, &next);
                    } else if (task.allowed)(s, state) {
                        self.push(task, &next);
                    }
                }
                // Soles of one body start and stop slipping together.
                let body = task.p.soles[s].body;
                let clamped = |t: usize| entry.states[t] != SoleState::FREE;
                let group = |t: &usize| task.p.soles[*t].body == body;
                if faults.friction && !completing && (0..soles).filter(group).any(|t| t != s && clamped(t)) {
                    let mut next = entry.states.clone();
                    let mode = if entry.states[s].is_static() { Mode::Sliding } else { Mode::Static };
                    for t in (0..soles).filter(group).filter(|&t| clamped(t)) {
                        next[t].mode = mode;
                    }
                    if (0..soles).all(|t| (task.allowed)(t, next[t])) {
                        self.push(task, &next);
                    }
                }
            }
        }
    }
}
