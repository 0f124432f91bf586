//! The one-step method: no trial states (`contact.md` section 10, the paper's section III.B).
//!
//! Every vertex decides for itself from the current quantities, at the first level that has an opinion:
//!
//! | level | clamp | release | weight |
//! |---|---|---|---|
//! | position | below the floor by more than d | above it by more than d | (n + 1)^2 |
//! | force | clamped and pushed (N_i > 0) | clamped and pulled (N_i < 0) | n + 1 |
//! | velocity | moving towards the floor | moving away from it | 1 |
//!
//! with n the number of vertices of the sole, so that one vertex of a level outweighs all of those below. Each clamping
//! pattern costs the weights of the vertices that disagree with it; the cheapest is taken. A pattern that stuck goes on
//! sticking while its last friction load was inside its capacity; one that slid sticks when its sliding velocity has
//! turned round or vanished. Then one solve.

use super::candidate::{Kernel, Solution, share_static};
use super::judge::{Rules, carried, judge, margin};
use super::method::{Manner, Method, Question};
use super::problem::{Level, Problem, Tolerances};
use super::select::Selection;
use super::state::{MAX_SOLES, Pattern, SoleState, States};

/// See the module.
pub struct OneStep {
    kernel: Kernel,
}

impl OneStep {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        OneStep { kernel: Kernel::new(p) }
    }
}

/// What one vertex wants: clamped or not, and how much that weighs.
pub fn vote(height: f64, speed: f64, clamped: bool, normal: f64, n: usize, tol: &Tolerances) -> (bool, f64) {
    let n = n as f64;
    if height < -tol.distance {
        (true, (n + 1.0) * (n + 1.0))
    } else if height > tol.distance {
        (false, (n + 1.0) * (n + 1.0))
    } else if clamped && normal != 0.0 {
        (normal > 0.0, n + 1.0)
    } else {
        (speed <= 0.0, 1.0)
    }
}

/// The cheapest pattern for these votes; among equals the one in force, then the one that clamps most.
pub fn cheapest(votes: &[(bool, f64)], now: Pattern) -> Pattern {
    let k = votes.len();
    let cost = |pattern: Pattern| -> f64 {
        let state = SoleState::fixed(pattern);
        (0..k).filter(|&i| votes[i].0 != state.clamps(i, k)).map(|i| votes[i].1).sum()
    };
    let mut best = now;
    for pattern in SoleState::patterns(k).chain([Pattern::Free]) {
        let (a, b) = (cost(pattern), cost(best));
        let clamps_more = SoleState::fixed(pattern).normal_rows() > SoleState::fixed(best).normal_rows();
        if a < b || (a == b && best != now && clamps_more) {
            best = pattern;
        }
    }
    best
}

/// Sticking or sliding of a pattern, from the last load and the present velocity.
fn mode(p: &Problem, s: usize, pattern: Pattern, rules: &Rules, last: &Solution) -> SoleState {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let before = rules.previous[s];
    let stuck = SoleState::fixed(pattern);
    let clamped = || sole.vertices.iter().enumerate().filter(|(i, _)| stuck.clamps(*i, k)).map(|(_, v)| v);
    let moves = clamped().any(|v| v.velocity.xy().norm() > rules.tolerances.rest);
    let slides = if before.is_static() {
        !carried(p, &rules.previous, s, last) && {
            let load = margin(p, &rules.previous, s, last);
            load.normal >= 0.0 && load.friction < 0.0
        }
    } else if before.is_dynamic() {
        let turned = clamped().all(|v| v.velocity.xy().dot(&v.direction) <= 0.0);
        moves && !turned
    } else {
        clamped().any(|v| v.velocity.xy().norm() > rules.tolerances.velocity)
    };
    if slides { SoleState::sliding(pattern) } else { stuck }
}

impl OneStep {
    fn decide(&mut self, p: &Problem, question: &Question, last: &Solution) -> States {
        let rules = question.rules;
        let mut states = States::default();
        for (s, sole) in p.soles.iter().enumerate() {
            let k = sole.vertices.len();
            let before = rules.previous[s];
            let mut votes = [(false, 0.0); 64];
            for (i, v) in sole.vertices.iter().enumerate() {
                let clamped = before.clamps(i, k);
                votes[i] = vote(v.height, v.velocity.z, clamped, last.normal[s][i], k, &rules.tolerances);
            }
            states[s] = mode(p, s, cheapest(&votes[..k], before.pattern), rules, last);
            if !(question.allowed)(s, states[s]) {
                states[s] = SoleState::all(k).find(|&x| (question.allowed)(s, x)).unwrap_or(states[s]);
            }
        }
        states
    }

    /// Points the friction of every sliding vertex against its velocity; one that has none yet yields to its load.
    fn point(p: &mut Problem, states: &States, rules: &Rules, last: &Solution) {
        let slips: [_; MAX_SOLES] = std::array::from_fn(|s| {
            if states[s].is_dynamic() { margin(p, &rules.previous, s, last).slip } else { Default::default() }
        });
        for (s, sole) in p.soles.iter_mut().enumerate().filter(|(s, _)| states[*s].is_dynamic()) {
            let (slip, radius) = (slips[s], sole.radius);
            for v in &mut sole.vertices {
                let t = v.velocity.xy();
                let yields = slip.xy() + nalgebra::Vector2::new(-v.r.y, v.r.x) * (slip.z / radius);
                let toward = if t.norm() > rules.tolerances.rest { t } else { yields };
                v.direction = toward.try_normalize(0.0).unwrap_or_default();
            }
        }
    }

    fn answer(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        let states = self.decide(p, question, out);
        Self::point(p, &states, question.rules, out);
        self.kernel.solve(p, &states, out);
        share_static(p, &states, out);
        let verdict = judge(p, &states, out, true, question.rules);
        // It does not claim validity, so it is never inconsistent: its errors show in the residuals.
        Selection { states, tested: 1, consistent: true, verdict }
    }
}

impl Method for OneStep {
    fn manner(&self) -> Manner {
        Manner::Deciding
    }

    fn select(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        debug_assert_eq!(p.level, Level::Acceleration);
        self.answer(p, question, out)
    }

    fn impulse(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        self.answer(p, question, out)
    }

    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.kernel.solve(p, states, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tol() -> Tolerances {
        Tolerances::default()
    }

    #[test]
    fn position_outranks_force_outranks_velocity() {
        assert_eq!(vote(-0.002, 1.0, true, -5.0, 4, &tol()), (true, 25.0));
        assert_eq!(vote(0.002, -1.0, true, 5.0, 4, &tol()), (false, 25.0));
        assert_eq!(vote(0.0, 1.0, true, 5.0, 4, &tol()), (true, 5.0));
        assert_eq!(vote(0.0, -1.0, true, -5.0, 4, &tol()), (false, 5.0));
        assert_eq!(vote(0.0, -0.01, false, 0.0, 4, &tol()), (true, 1.0));
        assert_eq!(vote(0.0, 0.01, false, 0.0, 4, &tol()), (false, 1.0));
    }

    #[test]
    fn the_pattern_follows_the_heavier_votes() {
        let (f, v) = (5.0, 1.0);
        // Three pushed corners and one that moves away slowly: the face, at the cost of one light vote.
        assert_eq!(cheapest(&[(true, f), (true, f), (true, f), (false, v)], Pattern::Face), Pattern::Face);
        // Two neighbours pulled: the opposite edge.
        assert_eq!(cheapest(&[(true, f), (true, f), (false, f), (false, f)], Pattern::Face), Pattern::Edge(0));
        // A diagonal cannot be clamped alone: one of the two gives way.
        let diagonal = cheapest(&[(true, 25.0), (false, f), (true, f), (false, f)], Pattern::Free);
        assert_eq!(diagonal, Pattern::Vertex(0));
        assert_eq!(cheapest(&[(false, 25.0); 4], Pattern::Face), Pattern::Free);
    }

    #[test]
    fn one_vote_of_a_level_beats_all_of_the_level_below() {
        let votes = [(false, 25.0), (true, 5.0), (true, 5.0), (true, 5.0)];
        assert!(!SoleState::fixed(cheapest(&votes, Pattern::Face)).clamps(0, 4));
    }
}
