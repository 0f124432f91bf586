//! Solves one candidate: wrenches and motions for a given contact state of every sole.
//!
//! Each clamped sole adds unknowns x (columns B, a wrench each) and as many conditions (rows R) on
//! its motion. With `m = b + W w`, `w = B x` (see [`crate::contact::model::problem`])
//!
//! ```text
//! R W B x = target - R (b + c)
//! ```
//!
//! | state | unknowns | conditions |
//! |---|---|---|
//! | vertex static | force at the vertex | its motion is zero |
//! | edge static | force at one end; normal and crosswise force at the other | no motion but rotation about the edge |
//! | face static | the whole wrench | no motion |
//! | sliding | normal forces, each with Coulomb friction `-mu_k N_i u_i` | no normal motion of the pattern |
//! | pivoting | as sliding, and a free tangential force at the pivot | as sliding, and no tangential motion there |
//!
//! All soles are solved together. Friction makes the sliding systems unsymmetric, and they are
//! solved so: without friction in the normal equations a sliding block would hop. Without sliding
//! soles R = B^T and the system is symmetric. Redundant rows (two feet of one body, straight legs)
//! give the solution of least norm ([`crate::linalg::linear`]), or the one nearest to a split of the
//! loads ([`super::load_split`]). A sliding face follows the pressure rule of
//! [`crate::contact::model::pressure`]: `N_i = max(0, A_i . y)`. Its unknowns are y; the set of
//! loaded vertices is iterated.

use crate::contact::model::per_sole::PerSole;
use crate::contact::model::pressure;
use crate::contact::model::problem::{Level, Problem, SoleProblem};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::model::turning::Turning;
use crate::contact::search::load_split::LoadSplit;
use crate::contact::search::static_loads::across;
use crate::linalg::linear::Linear;
use nalgebra::{Vector2, Vector3};

/// What conditions that are left out as nearly redundant may leave of the motion without contact.
const LOOSE: f64 = 1e-8;

/// Scale of the unknowns of sliding soles, for which no split is known, in N, where least departure from one is sought.
const FREELY: f64 = 100.0;

/// Least unit of held moments over that of forces, m: shorter ones would make their conditions appear redundant.
const SHORTEST_LEVER: f64 = 1e-3;

/// Six numbers: a wrench or a row over a sole's motion.
type Six = [f64; 6];

/// A unit of wrench, or a row over a sole's motion.
#[derive(Clone, Copy, Debug)]
pub(super) enum Direction {
    /// This number at this position, zero elsewhere.
    Axis(usize, f64),
    General(Six),
}

impl Direction {
    /// Product with six numbers.
    pub(super) fn dot(&self, x: &[f64]) -> f64 {
        match self {
            Direction::Axis(axis, size) => x[*axis] * size,
            Direction::General(six) => dot(x, six),
        }
    }

    /// Adds the direction times `size`.
    pub(super) fn add_to(&self, size: f64, sum: &mut [f64]) {
        match self {
            Direction::Axis(axis, unit) => sum[*axis] += unit * size,
            Direction::General(six) => sum.iter_mut().zip(six).for_each(|(sum, x)| *sum += x * size),
        }
    }

    /// Response of the motions to this wrench on sole `s`: `out = W_s six`, of length 6F.
    fn response(&self, p: &Problem, s: usize, out: &mut [f64]) {
        let dim = p.dim();
        match self {
            // W is symmetric: its rows are its columns.
            Direction::Axis(axis, size) => {
                let column = &p.w[(6 * s + axis) * dim..][..dim];
                out.iter_mut().zip(column).for_each(|(y, w)| *y = w * size);
            }
            Direction::General(six) => {
                out.iter_mut().zip(p.w.chunks_exact(dim)).for_each(|(y, row)| *y = dot(&row[6 * s..], six));
            }
        }
    }
}

/// Unknowns and conditions of one sole: its index, a wrench or a row, and the right-hand side.
pub(super) type Terms<'a> = (&'a [(usize, Direction)], &'a [(usize, Direction, f64)]);

/// Scratch of the candidate solve, allocated once.
#[derive(Clone, Debug)]
pub struct CandidateSolver {
    columns: Vec<(usize, Direction)>,
    rows: Vec<(usize, Direction, f64)>,
    /// W B, one column after the other, each 6F long.
    wb: Vec<f64>,
    /// R W B of order `size`, or its factors after a solve.
    a: Vec<f64>,
    size: usize,
    x: Vec<f64>,
    linear: Linear,
    /// First unknown of each sole.
    first: Vec<usize>,
    /// Loaded vertices of each sliding face, one bit each.
    loaded: PerSole<u64>,
    /// Whether all sets of loaded vertices are tried where their iteration fails.
    pub(super) thorough: bool,
    /// Split of loads that several static soles share.
    pub(super) split: LoadSplit,
}

fn dot(a: &[f64], b: &Six) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}

/// Wrench of a normal force of one newton at vertex `i` with its sliding friction.
fn sliding_wrench(sole: &SoleProblem, i: usize, mode: Mode) -> Six {
    let v = &sole.vertices[i];
    let slides = mode != Mode::Pivoting(i as u8);
    let t = if slides { -v.direction * v.slip_mu() } else { Vector2::zeros() };
    wrench_at(&v.r, &Vector3::new(t.x, t.y, 1.0))
}

impl CandidateSolver {
    /// Scratch for problems of this size.
    pub fn new(p: &Problem) -> Self {
        let n = p.dim();
        CandidateSolver {
            columns: Vec::with_capacity(n),
            rows: Vec::with_capacity(n),
            wb: vec![0.0; n * n],
            a: vec![0.0; n * n],
            size: 0,
            x: vec![0.0; n],
            linear: Linear::new(n),
            first: vec![0; p.soles.len()],
            loaded: PerSole::filled(u64::MAX),
            thorough: true,
            split: LoadSplit::new(p),
        }
    }

    /// Solves a candidate for wrenches and motions, with the sliding directions in the problem.
    /// Normal forces of sliding soles are filled in; [`share_static`](super::static_loads::share_static) fills in those of static
    /// soles.
    pub fn solve(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.loaded.fill(u64::MAX);
        out.inside.fill(true);
        for round in 0.. {
            self.solve_linear(p, states, out);
            if !self.update_loaded(p, states, out, round >= 12) {
                break;
            }
        }
        for s in 0..p.soles.len() {
            if !out.inside[s] && self.thorough {
                self.try_arcs(p, states, s, out);
            }
        }
    }

    /// Tries every run of neighbouring vertices as the loaded set of a sliding face, the longest
    /// first.
    ///
    /// Friction feeds back on the loaded set, so the iteration may miss a consistent set. Linear
    /// pressure is positive on one side of a line, hence the sets are runs of neighbours. Without
    /// success the last solution is restored.
    fn try_arcs(&mut self, p: &Problem, states: &States, s: usize, out: &mut Solution) {
        let k = p.soles[s].vertices.len();
        let saved = (self.loaded.clone(), out.inside.clone());
        for length in (3..k).rev() {
            for first in 0..k {
                self.loaded.clone_from(&saved.0);
                self.loaded[s] = (0..length).fold(0, |set, i| set | 1 << ((first + i) % k));
                out.inside[s] = true;
                self.solve_linear(p, states, out);
                if !self.update_loaded(p, states, out, true)
                    && (0..p.soles.len()).all(|t| out.inside[t] >= saved.1[t])
                    && out.inside[s]
                {
                    return;
                }
            }
        }
        (self.loaded, out.inside) = saved;
        self.solve_linear(p, states, out);
        self.update_loaded(p, states, out, true);
    }

    fn solve_linear(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.columns.clear();
        self.rows.clear();
        for (s, sole) in p.soles.iter().enumerate() {
            self.first[s] = self.columns.len();
            self.build(s, sole, states[s]);
        }
        let dim = p.dim().max(1);
        let n = self.columns.len();
        let is_split = p.level == Level::Acceleration && self.split.is_of(states);
        // With a split, x is scaled where it is no departure from it.
        let scale = |s: usize| if is_split && states[s].is_dynamic() { FREELY } else { 1.0 };
        for ((s, b), wb) in self.columns.iter().zip(self.wb.chunks_exact_mut(dim)) {
            b.response(p, *s, wb);
            if scale(*s) != 1.0 {
                wb.iter_mut().for_each(|y| *y *= scale(*s));
            }
        }
        for (x, (s, row, target)) in self.x.iter_mut().zip(&self.rows) {
            *x = target - row.dot(&p.b[6 * s..]);
        }
        if is_split {
            self.split.update(p);
            for (x, (s, row, _)) in self.x.iter_mut().zip(&self.rows) {
                *x -= row.dot(&self.split.loads().1[6 * s..]);
            }
        }
        let turns = |s: usize| p.soles[s].turning().is_some_and(|turning| turning.slip_moment() != Vector3::zeros());
        let is_skew = |s: usize| states[s].is_dynamic() || states[s].is_static() && turns(s);
        let symmetric = !(0..p.soles.len()).any(is_skew);
        let (a, x) = (&mut self.a[..n * n], &mut self.x[..n]);
        for (c, wb) in self.wb.chunks_exact(dim).take(n).enumerate() {
            let first = if symmetric { c } else { 0 };
            for (r, (s, row, _)) in self.rows.iter().enumerate().skip(first) {
                let entry = row.dot(&wb[6 * s..]);
                a[r * n + c] = entry;
                if symmetric {
                    a[c * n + r] = entry;
                }
            }
        }
        self.linear.drop_nearly_redundant(is_split && self.split.is_loose);
        if symmetric {
            self.linear.solve_symmetric(a, x)
        } else {
            self.linear.solve(a, x)
        };
        self.size = n;
        out.wrench.fill(0.0);
        out.motion.copy_from_slice(&p.b);
        if is_split {
            let (wrench, motion) = self.split.loads();
            out.wrench.copy_from_slice(wrench);
            out.motion.iter_mut().zip(motion).for_each(|(m, x)| *m += x);
        }
        for (c, (s, b)) in self.columns.iter().enumerate() {
            let x = self.x[c];
            for (m, y) in out.motion.iter_mut().zip(&self.wb[c * dim..(c + 1) * dim]) {
                *m += y * x;
            }
            self.x[c] *= scale(*s);
            b.add_to(self.x[c], &mut out.wrench[6 * s..6 * s + 6]);
        }
        if is_split && self.split.is_loose && !self.holds(p, out) {
            self.split.is_loose = false;
            self.solve_linear(p, states, out);
        }
    }

    /// Whether the motions obey all conditions, as far as [`LOOSE`] allows.
    fn holds(&self, p: &Problem, out: &Solution) -> bool {
        let left = |motion: &[f64]| {
            let each = self.rows.iter().map(|(s, row, target)| (target - row.dot(&motion[6 * s..])).abs());
            each.fold(0.0, f64::max)
        };
        left(&out.motion) <= LOOSE * left(&p.b)
    }

    /// Whether conditions of the last solve were nearly redundant.
    pub fn is_nearly_indeterminate(&self) -> bool {
        self.linear.has_nearly_redundant()
    }

    /// Whether the loads of the last solve are not unique, or only by the last digits of the robot file.
    pub fn is_indeterminate(&self) -> bool {
        self.linear.rank() < self.size || self.is_nearly_indeterminate()
    }

    /// Response of the motions to a small wrench `six` (e) on sole `s` under the conditions of the
    /// last solve: `motion` (6F) = W e + W B x' with R W (e + B x') = 0.
    pub fn response(&mut self, p: &Problem, s: usize, six: &[f64; 6], motion: &mut [f64]) {
        let (dim, n) = (p.dim(), self.size);
        Direction::General(*six).response(p, s, motion);
        for (x, (t, row, _)) in self.x.iter_mut().zip(&self.rows) {
            *x = -row.dot(&motion[6 * t..]);
        }
        self.linear.apply(&self.a[..n * n], &mut self.x[..n]);
        for (c, x) in self.x[..n].iter().enumerate() {
            motion.iter_mut().zip(&self.wb[c * dim..(c + 1) * dim]).for_each(|(m, y)| *m += y * x);
        }
    }

    /// Unknowns (a wrench each) and conditions (row and right-hand side) of sole `s` alone in `state`.
    /// Ends the validity of [`response`](Self::response).
    pub(super) fn terms(&mut self, p: &Problem, s: usize, state: SoleState) -> Terms<'_> {
        self.columns.clear();
        self.rows.clear();
        self.first[s] = 0;
        self.build(s, &p.soles[s], state);
        (&self.columns, &self.rows)
    }

    /// Appends the unknowns and conditions of one sole.
    fn build(&mut self, s: usize, sole: &SoleProblem, state: SoleState) {
        let k = sole.vertices.len();
        let (ex, ey, ez) = (Vector3::x(), Vector3::y(), Vector3::z());
        match (state.pattern, state.mode) {
            (Pattern::Free, _) => {}
            (Pattern::Vertex(i), Mode::Static) => {
                [ex, ey, ez].iter().for_each(|d| self.tie(s, sole, i as usize, d));
            }
            (Pattern::Edge(i), Mode::Static) => {
                let (i, j) = (i as usize, (i as usize + 1) % k);
                [ex, ey, ez].iter().for_each(|d| self.tie(s, sole, i, d));
                [across(sole, i, j), ez].iter().for_each(|d| self.tie(s, sole, j, d));
            }
            (Pattern::Face, Mode::Static) => {
                let rho = sole.radius;
                let t = &sole.target;
                let targets = [0.0, 0.0, t.x, rho * t.y, rho * t.z, 0.0];
                for (axis, target) in targets.into_iter().enumerate() {
                    let e = Direction::Axis(axis, if axis < 3 { 1.0 } else { rho });
                    self.columns.push((s, e));
                    self.rows.push((s, e, target));
                }
            }
            (Pattern::Vertex(i), _) => self.slide(s, sole, i as usize, state.mode),
            (Pattern::Edge(i), mode) => {
                self.slide(s, sole, i as usize, mode);
                self.slide(s, sole, (i as usize + 1) % k, mode);
            }
            (Pattern::Face, mode) => {
                let rho = sole.radius;
                let mut columns = [[0.0; 6]; 3];
                for i in (0..k).filter(|i| self.loaded[s] >> i & 1 == 1) {
                    let w = sliding_wrench(sole, i, mode);
                    let a = pressure::basis(sole, i);
                    for (c, column) in columns.iter_mut().enumerate() {
                        column.iter_mut().zip(&w).for_each(|(x, w)| *x += a[c] * w);
                    }
                }
                let t = &sole.target;
                let rows = [Direction::Axis(2, 1.0), Direction::Axis(3, rho), Direction::Axis(4, rho)];
                for ((column, row), target) in columns.into_iter().zip(rows).zip([t.x, rho * t.y, rho * t.z]) {
                    self.columns.push((s, Direction::General(column)));
                    self.rows.push((s, row, target));
                }
            }
        }
        if let (Mode::Pivoting(j), true) = (state.mode, state.is_dynamic()) {
            [ex, ey].iter().for_each(|d| self.tie(s, sole, j as usize, d));
        }
        if let Some(turning) = sole.turning().filter(|_| state.pattern != Pattern::Free) {
            self.turn(s, turning, if state.is_static() { 2 } else { 0 });
        }
    }

    /// Adds the moments of a point contact: those that turning components have are in proportion to the normal
    /// force, the unknown `normal` of the sole, and held ones are unknowns.
    fn turn(&mut self, s: usize, turning: &Turning, normal: usize) {
        let moment = turning.slip_moment();
        if moment != Vector3::zeros() {
            let column = &mut self.columns[self.first[s] + normal].1;
            let mut six = [0.0; 6];
            column.add_to(1.0, &mut six);
            six[3..].iter_mut().zip(moment.iter()).for_each(|(x, m)| *x += m);
            *column = Direction::General(six);
        }
        let held = [turning.holds_roll(), turning.holds_roll(), turning.holds_spin()];
        // Where forces on other points of the body hold it too, moments of least norm in this unit are small.
        let unit = [turning.rolling, turning.rolling, turning.torsional].map(|limit| limit.clamp(SHORTEST_LEVER, 1.0));
        for axis in (0..3).filter(|axis| held[*axis]) {
            let e = Direction::Axis(3 + axis, unit[axis]);
            self.columns.push((s, e));
            self.rows.push((s, e, -unit[axis] * turning.bias[axis]));
        }
    }

    /// Adds an unknown force at a vertex along `d`, and the condition of no motion along `d`.
    fn tie(&mut self, s: usize, sole: &SoleProblem, i: usize, d: &Vector3<f64>) {
        let v = &sole.vertices[i];
        let six = Direction::General(wrench_at(&v.r, d));
        self.columns.push((s, six));
        self.rows.push((s, six, d.z * sole.vertex_target(i) - d.dot(&v.bias)));
    }

    /// Adds a normal force with its friction at a vertex, and the condition on its normal motion.
    fn slide(&mut self, s: usize, sole: &SoleProblem, i: usize, mode: Mode) {
        let v = &sole.vertices[i];
        self.columns.push((s, Direction::General(sliding_wrench(sole, i, mode))));
        let row = Direction::General(wrench_at(&v.r, &Vector3::z()));
        self.rows.push((s, row, sole.vertex_target(i) - v.bias.z));
    }

    /// Reads the forces of sliding soles and updates the loaded sets of their faces. Returns true
    /// if a set changed, so that the candidate must be solved again; `give_up` keeps the sets.
    fn update_loaded(&mut self, p: &Problem, states: &States, out: &mut Solution, give_up: bool) -> bool {
        let mut changed = false;
        for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| states[*s].is_dynamic()) {
            let k = sole.vertices.len();
            let x = &self.x[self.first[s]..];
            out.normal[s].fill(0.0);
            match states[s].pattern {
                Pattern::Free => {}
                Pattern::Vertex(i) => out.normal[s][i as usize] = x[0],
                Pattern::Edge(i) => {
                    out.normal[s][i as usize] = x[0];
                    out.normal[s][(i as usize + 1) % k] = x[1];
                }
                Pattern::Face => {
                    let y = Vector3::new(x[0], x[1], x[2]);
                    let mut positive = 0u64;
                    for i in 0..k {
                        let n = pressure::basis(sole, i).dot(&y);
                        positive |= u64::from(n > 0.0) << i;
                        out.normal[s][i] = if self.loaded[s] >> i & 1 == 1 { n } else { 0.0 };
                    }
                    let all = u64::MAX >> (64 - k);
                    let unchanged = positive == self.loaded[s] & all || out.normal[s].iter().all(|&n| n == 0.0);
                    if !unchanged && out.inside[s] {
                        // With fewer than three loaded vertices the centre of pressure has left the
                        // polygon. The forces of the last set continue smoothly, one of them
                        // negative, so that the event can be located.
                        out.inside[s] = !give_up && positive.count_ones() >= 3;
                        if out.inside[s] {
                            self.loaded[s] = positive;
                            changed = true;
                        }
                    }
                }
            }
            for i in 0..k {
                let v = &sole.vertices[i];
                let pivot = states[s].mode == Mode::Pivoting(i as u8);
                out.tangent[s][i] =
                    if pivot { Vector2::zeros() } else { -v.direction * (v.slip_mu() * out.normal[s][i]) };
            }
            if let Mode::Pivoting(j) = states[s].mode {
                let at = self.first[s] + states[s].normal_rows();
                out.tangent[s][j as usize] = Vector2::new(self.x[at], self.x[at + 1]);
            }
        }
        changed
    }
}
