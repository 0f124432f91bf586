//! Solves apart what does not act on each other.
//!
//! The soles of an island are joined by blocks of W that are not zero: those of one robot, those of a
//! stack of boxes. W is block diagonal over the islands, so each is a contact problem by itself, with
//! the scale and the tolerances of the whole. A search then tries the states of one island at a time,
//! and the cost grows linearly with their number.
//!
//! The first problem makes the islands, which allocates. They only grow, by blocks that were zero before,
//! until the solver is replaced. A problem of one island is passed on as it is.

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput, StoredEnergy};
use crate::contact::model::problem::{Problem, SoleProblem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::judge::{Assessment, Rules};
use crate::contact::search::select::Selection;
use std::sync::Arc;

/// Makes a solver for problems of the size of its argument.
type Factory = Arc<dyn Fn(&Problem) -> Box<dyn ContactSolver> + Send + Sync>;

/// A solver of a method that solves each island by itself.
pub struct Islands {
    /// Solves all soles together.
    whole: Box<dyn ContactSolver>,
    make: Factory,
    /// First sole of the island of each sole.
    roots: Vec<usize>,
    /// Whether all soles have been found to be one island.
    is_one: bool,
    /// The islands; none if all soles are one.
    parts: Vec<Island>,
}

/// Soles that act on each other.
struct Island {
    /// Their indices in the whole problem.
    soles: Vec<usize>,
    problem: Problem,
    solution: Solution,
    /// Rules of its last selection.
    rules: Rules,
    solver: Box<dyn ContactSolver>,
}

impl Islands {
    /// For problems of the size of `p`, which `whole` solves. `make` makes the solvers of islands.
    pub fn new(p: &Problem, whole: Box<dyn ContactSolver>, make: Factory) -> Self {
        Islands { whole, make, roots: (0..p.soles.len()).collect(), is_one: false, parts: Vec::new() }
    }

    /// Joins the islands between which W is not zero. Allocates only if there are any.
    fn update(&mut self, p: &Problem) {
        if self.is_one {
            return;
        }
        let count = p.soles.len();
        let mut is_changed = self.parts.is_empty();
        for s in 0..count {
            for t in s + 1..count {
                let (a, b) = (self.roots[s], self.roots[t]);
                if a != b && acts(p, s, t) {
                    self.roots.iter_mut().filter(|root| **root == a.max(b)).for_each(|root| *root = a.min(b));
                    is_changed = true;
                }
            }
        }
        if is_changed {
            self.part(p);
        }
    }

    /// Makes the islands of the present roots.
    fn part(&mut self, p: &Problem) {
        self.parts.clear();
        self.is_one = self.roots.iter().all(|root| *root == 0);
        if self.is_one {
            return;
        }
        for root in 0..self.roots.len() {
            let soles: Vec<usize> = (0..self.roots.len()).filter(|&s| self.roots[s] == root).collect();
            if !soles.is_empty() {
                let counts: Vec<usize> = soles.iter().map(|&s| p.soles[s].vertices.len()).collect();
                let problem = Problem::new(&counts);
                let (solution, solver) = (Solution::new(&problem), (self.make)(&problem));
                let rules = Rules::new(Default::default(), States::default());
                self.parts.push(Island { soles, problem, solution, rules, solver });
            }
        }
    }

    /// Selects the states of each island with `solve`.
    fn select_each(
        &mut self,
        p: &mut Problem,
        input: &SelectionInput,
        out: &mut Solution,
        solve: impl Fn(&mut dyn ContactSolver, &mut Problem, &SelectionInput, &mut Solution) -> Selection,
    ) -> Selection {
        self.update(p);
        if self.parts.is_empty() {
            return solve(&mut *self.whole, p, input, out);
        }
        let mut all = Selection::unchecked(input.rules.previous.clone());
        for island in &mut self.parts {
            island.gather(p, out);
            island.follow(input.rules);
            let soles = &island.soles;
            let allowed = |s: usize, state: SoleState| (input.allowed)(soles[s], state);
            let of_island = SelectionInput { rules: &island.rules, allowed: &allowed, ..*input };
            let found = solve(&mut *island.solver, &mut island.problem, &of_island, &mut island.solution);
            add(&mut all, &found, soles);
            island.scatter(out);
            for (&s, sole) in island.soles.iter().zip(&island.problem.soles) {
                copy_sole(sole, &mut p.soles[s]);
            }
        }
        all
    }
}

impl Island {
    fn copy(&self) -> Option<Island> {
        Some(Island {
            soles: self.soles.clone(),
            problem: self.problem.clone(),
            solution: self.solution.clone(),
            rules: self.rules.clone(),
            solver: self.solver.copy()?,
        })
    }

    /// Copies its part of the problem and of the last solution.
    fn gather(&mut self, p: &Problem, out: &Solution) {
        let (dim, own) = (p.dim(), self.problem.dim());
        (self.problem.level, self.problem.scale, self.problem.step) = (p.level, p.scale, p.step);
        for (i, &s) in self.soles.iter().enumerate() {
            self.problem.b[6 * i..6 * i + 6].copy_from_slice(&p.b[6 * s..6 * s + 6]);
            copy_sole(&p.soles[s], &mut self.problem.soles[i]);
            for axis in 0..6 {
                let row = &p.w[(6 * s + axis) * dim..][..dim];
                let to = &mut self.problem.w[(6 * i + axis) * own..][..own];
                to.as_chunks_mut().0.iter_mut().zip(&self.soles).for_each(|(to, &t)| *to = six(row, t));
            }
            self.solution.wrench[6 * i..6 * i + 6].copy_from_slice(&out.wrench[6 * s..6 * s + 6]);
            self.solution.motion[6 * i..6 * i + 6].copy_from_slice(&out.motion[6 * s..6 * s + 6]);
            self.solution.normal[i].copy_from_slice(&out.normal[s]);
            self.solution.tangent[i].copy_from_slice(&out.tangent[s]);
            self.solution.inside.set(i, out.inside[s]);
        }
    }

    /// Copies its solution to that of the whole problem.
    fn scatter(&self, out: &mut Solution) {
        for (i, &s) in self.soles.iter().enumerate() {
            out.wrench[6 * s..6 * s + 6].copy_from_slice(&self.solution.wrench[6 * i..6 * i + 6]);
            out.motion[6 * s..6 * s + 6].copy_from_slice(&self.solution.motion[6 * i..6 * i + 6]);
            out.normal[s].copy_from_slice(&self.solution.normal[i]);
            out.tangent[s].copy_from_slice(&self.solution.tangent[i]);
            out.inside.set(s, self.solution.inside[i]);
        }
    }

    fn states(&self, states: &States) -> States {
        let mut own = States::default();
        self.soles.iter().enumerate().for_each(|(i, &s)| own[i] = states[s]);
        own
    }

    /// Takes over the rules of the whole problem.
    fn follow(&mut self, rules: &Rules) {
        let own = &mut self.rules;
        (own.tolerances, own.hops, own.rounding, own.exhaustive, own.stops) =
            (rules.tolerances, rules.hops, rules.rounding, rules.exhaustive, rules.stops);
        for (i, &s) in self.soles.iter().enumerate() {
            own.previous.set(i, rules.previous[s]);
            own.suspect.set(i, rules.suspect[s]);
        }
    }
}

/// Whether a wrench on sole `t` moves sole `s`.
fn acts(p: &Problem, s: usize, t: usize) -> bool {
    let dim = p.dim();
    p.w[6 * s * dim..6 * (s + 1) * dim].chunks_exact(dim).any(|row| six(row, t) != [0.0; 6])
}

/// The entries of sole `s`.
fn six(row: &[f64], s: usize) -> [f64; 6] {
    row.as_chunks().0[s]
}

fn copy_sole(from: &SoleProblem, to: &mut SoleProblem) {
    to.vertices.copy_from_slice(&from.vertices);
    (to.radius, to.body, to.position, to.target) = (from.radius, from.body, from.position, from.target);
    to.turning = from.turning;
}

/// Adds the selection of an island with these soles to that of the whole.
fn add(all: &mut Selection, part: &Selection, soles: &[usize]) {
    all.tested += part.tested;
    all.full |= part.full;
    all.consistent &= part.consistent;
    all.exhausted &= part.exhausted;
    let Assessment { levels, rank, action, faults } = &mut all.assessment;
    levels.iter_mut().zip(part.assessment.levels).for_each(|(sum, x)| *sum += x);
    rank.iter_mut().zip(part.assessment.rank).for_each(|(sum, x)| *sum += x);
    *action += part.assessment.action;
    for (i, &s) in soles.iter().enumerate() {
        all.states.set(s, part.states[i]);
        faults.set(s, part.assessment.faults[i]);
    }
}

impl ContactSolver for Islands {
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        let parts = self.parts.iter().map(Island::copy).collect::<Option<_>>()?;
        let (roots, make) = (self.roots.clone(), self.make.clone());
        Some(Box::new(Islands { whole: self.whole.copy()?, make, roots, is_one: self.is_one, parts }))
    }

    fn scheme(&self) -> Scheme {
        self.whole.scheme()
    }

    fn locates_events(&self) -> bool {
        self.whole.locates_events()
    }

    fn gives_vertex_forces(&self) -> bool {
        self.whole.gives_vertex_forces()
    }

    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        self.select_each(p, input, out, |solver, p, input, out| solver.select(p, input, out))
    }

    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        self.select_each(p, input, out, |solver, p, input, out| solver.impulse(p, input, out))
    }

    fn point_impulse(&mut self, p: &Problem, out: &mut Solution) -> Option<States> {
        self.update(p);
        if self.parts.is_empty() {
            return self.whole.point_impulse(p, out);
        }
        let mut states = States::default();
        for island in &mut self.parts {
            island.gather(p, out);
            let found = island.solver.point_impulse(&island.problem, &mut island.solution)?;
            island.soles.iter().enumerate().for_each(|(i, &s)| states[s] = found[i]);
        }
        self.parts.iter().for_each(|island| island.scatter(out));
        Some(states)
    }

    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.update(p);
        if self.parts.is_empty() {
            return self.whole.respond(p, states, out);
        }
        for island in &mut self.parts {
            island.gather(p, out);
            let own = island.states(states);
            island.solver.respond(&island.problem, &own, &mut island.solution);
            island.scatter(out);
        }
    }

    fn stored(&self, p: &Problem) -> StoredEnergy {
        // Of all vertices, whatever acts on what.
        self.whole.stored(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::methods::registry::{METHODS, MethodParameters};
    use crate::contact::model::state::Pattern;
    use nalgebra::{DMatrix, Vector3};

    /// Three soles of which the first and the last act on each other, and all if `joined`.
    fn problem(joined: bool) -> Problem {
        let mut p = Problem::new(&[1, 3, 1]);
        for (i, v) in p.soles.iter_mut().flat_map(|sole| &mut sole.vertices).enumerate() {
            v.r = Vector3::new((i as f64).cos(), (2.0 * i as f64).sin(), 0.1);
            (v.mu_s, v.mu_k) = (0.5, 0.5);
        }
        let root = DMatrix::from_fn(18, 18, |i, j| ((3 * i + 7 * j) as f64).sin() + f64::from(u8::from(i == j)) * 4.0);
        let w = &root * root.transpose();
        let is_kept = |i: usize, j: usize| joined || (i / 6 == 1) == (j / 6 == 1);
        p.w = w.iter().enumerate().map(|(k, x)| if is_kept(k / 18, k % 18) { *x } else { 0.0 }).collect();
        (0..18).for_each(|i| p.b[i] = -1.0 - (i as f64).cos());
        p
    }

    #[test]
    fn islands_are_solved_as_the_whole_and_joined_when_they_meet() {
        let make = |p: &Problem| (METHODS[0].solver)(&MethodParameters::default(), p);
        let mut p = problem(false);
        let mut islands = Islands::new(&p, make(&p), Arc::new(make));
        let mut states = States::default();
        [Pattern::Vertex(0), Pattern::Face, Pattern::Vertex(0)].into_iter().enumerate().for_each(|(s, pattern)| {
            states[s] = SoleState::fixed(pattern);
        });
        for (joined, parts) in [(false, 2), (true, 0), (false, 0)] {
            p = problem(joined);
            let (mut found, mut expected) = (Solution::new(&p), Solution::new(&p));
            islands.respond(&p, &states, &mut found);
            make(&p).respond(&p, &states, &mut expected);
            assert_eq!(islands.parts.len(), parts);
            // Rounding of solves with another order of the pivots.
            let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(difference(&found.wrench, &expected.wrench) < 1e-12);
            assert!(difference(&found.motion, &expected.motion) < 1e-12);
        }
        let rules = Rules::new(Default::default(), states.clone());
        let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true, cancel: None };
        p = problem(false);
        let mut apart = Islands::new(&p, make(&p), Arc::new(make));
        let (mut found, mut expected) = (Solution::new(&p), Solution::new(&p));
        let chosen = apart.select(&mut p, &input, &mut found);
        let whole = make(&p).select(&mut problem(false), &input, &mut expected);
        assert_eq!((&chosen.states, apart.parts.len()), (&whole.states, 2));
        assert!(chosen.consistent && chosen.assessment.valid() && chosen.tested >= 2, "{chosen:?}");
        assert!(found.wrench.iter().zip(&expected.wrench).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
