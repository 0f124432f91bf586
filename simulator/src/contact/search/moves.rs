//! Local moves of the state search: neighbours of a candidate that its faults suggest.

use crate::contact::model::problem::Problem;
use crate::contact::model::state::{Mode, Pattern, SoleState};
use crate::contact::search::judge::Faults;

/// First mode to try for a pattern: sliding if one of its vertices moves, else static.
pub fn first_mode(p: &Problem, s: usize, pattern: Pattern) -> SoleState {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let state = SoleState::fixed(pattern);
    let slides = (0..k).any(|i| state.clamps(i, k) && sole.vertices[i].moving);
    if slides { SoleState::sliding(pattern) } else { state }
}

/// Local moves of one sole, on the stack. At most 64 vertices give at most 64 + 64 + 1 patterns.
pub struct Moves {
    list: [SoleState; 200],
    count: usize,
}

impl Default for Moves {
    fn default() -> Self {
        Moves { list: [SoleState::FREE; 200], count: 0 }
    }
}

impl Moves {
    /// The states suggested.
    pub fn states(&self) -> &[SoleState] {
        &self.list[..self.count]
    }

    /// Keeps the states for which `keep` holds.
    pub fn retain(&mut self, mut keep: impl FnMut(SoleState) -> bool) {
        let mut kept = 0;
        for i in 0..self.count {
            if keep(self.list[i]) {
                self.list[kept] = self.list[i];
                kept += 1;
            }
        }
        self.count = kept;
    }

    fn add(&mut self, state: SoleState) {
        if self.count < self.list.len() {
            self.list[self.count] = state;
            self.count += 1;
        }
    }

    /// Moves of sole `s` from `state` with `faults`. From a valid candidate, to smaller patterns.
    pub fn suggest(&mut self, p: &Problem, s: usize, state: SoleState, faults: Faults, valid: bool) {
        let k = p.soles[s].vertices.len();
        let rows = state.normal_rows();
        for pattern in SoleState::patterns(k) {
            let next = SoleState::fixed(pattern);
            let to_clamp = faults.penetrating | if valid { faults.resting } else { 0 };
            let clamps_fault = (0..k).any(|i| to_clamp >> i & 1 == 1 && next.clamps(i, k));
            let nested = |a: SoleState, b: SoleState| (0..k).all(|i| !a.clamps(i, k) || b.clamps(i, k));
            // Clamp a vertex that enters the floor, keeping or replacing clamped vertices.
            let clamp = clamps_fault && next.normal_rows() >= rows;
            // Release a pulling vertex; for a valid candidate, try smaller patterns.
            let release = (faults.pulling || valid) && next.normal_rows() < rows && nested(next, state);
            // A pulling edge may have to be replaced by its neighbour.
            let shift = faults.pulling && faults.penetrating != 0 && clamps_fault;
            if pattern != state.pattern && (clamp || release || shift) {
                self.add(first_mode(p, s, pattern));
                if valid && state.is_dynamic() {
                    self.add(SoleState::sliding(pattern));
                }
            }
        }
        if state.pattern == Pattern::Free {
            return;
        }
        if faults.pulling || valid {
            self.add(SoleState::FREE);
        }
        if faults.friction {
            let with = |mode| SoleState { pattern: state.pattern, mode };
            match state.mode {
                Mode::Static => self.add(with(Mode::Sliding)),
                Mode::Sliding | Mode::Pivoting(_) => {
                    self.add(with(Mode::Static));
                    self.add(with(Mode::Sliding));
                    for i in (0..k).filter(|&i| rows > 1 && state.clamps(i, k) && !p.soles[s].vertices[i].moving) {
                        self.add(with(Mode::Pivoting(i as u8)));
                    }
                }
            }
        }
    }
}
