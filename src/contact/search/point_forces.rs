//! Solves the contact problem with every vertex as a point, to find which vertices carry and which
//! slip.
//!
//! For the points c that may touch, with forces `f_c = (t_c, N_c)` and motions
//! `m_c = g_c + sum_d H_cd f_d`, `H = A^T W A`, where A collects the wrenches of the points:
//!
//! ```text
//! at rest   0 <= N  _|_  m_n - target >= 0,   |t| <= mu N,   t opposes m_t where it slips       (1)
//! moving    0 <= N  _|_  m_n - target >= 0,   t = -mu_k N u                                     (2)
//! ```
//!
//! With `s = (0, 0, mu |m_t|)` in (1) and `s = (0, 0, mu_k u . m_t)` in (2), z = m - target + s and
//! K the friction cone of (1) or the ray of (2), both are the complementarity of f in K and z in
//! its dual cone [De Saxce 1998]. The alternating direction method of multipliers solves it with s
//! from the last iteration [Carpentier 2024]:
//!
//! ```text
//! f <- (H + rho)^-1 (rho y - l - g + target - s)     y <- P_K(f + l / rho)     l <- l + rho (f - y)
//! (H + rho)^-1 x = (x - A^T W (rho + A A^T W)^-1 A x) / rho
//! ```
//!
//! so an iteration costs products with A and one solve of size 6F. z = -l at the solution.
//!
//! The iteration is a map of `x = f + l / rho`, from which y = P_K(x) and l = rho (x - y) follow.
//! Alone it needs thousands of iterations where many vertices of a sole share a load. Anderson's
//! acceleration [Walker 2011] combines the last 20 of them: of all combinations of their
//! results it takes that with the least change, which ends in a few iterations once the set of
//! carrying and slipping vertices is found, as the map is then smooth. It starts anew where the
//! change grows.
//!
//! The result names states to be tested; the accuracy of their forces is that of the candidate
//! solve. A vertex in motion has mu_k. One at rest has mu_s, and mu_k once it slips.

use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{MAX_SOLES, Mode, Pattern, SoleState, States};
use crate::linalg::cholesky::Symmetric;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};

/// Most iterations of one solve.
const ITERATIONS: usize = 2000;
/// Iterations that the acceleration combines.
const MEMORY: usize = 20;
/// Growth of the change per iteration at which the acceleration starts anew.
const GROWS: f64 = 2.0;
/// Regularization of its least squares, relative: changes are nearly dependent near the solution.
const DEPENDENT: f64 = 1e-12;
/// Residuals at which the states are read, relative to load and motion: far below the forces and
/// motions by which states differ, far above rounding.
const ACCURATE: f64 = 1e-9;
/// Tangential motion of a vertex that slips, relative to the motion without contact.
pub const SLIPS: f64 = 1e-6;
/// The same as far as the solution is accurate.
pub const LEAST_SLIPS: f64 = 1e-8;
/// Most points.
const MAX_POINTS: usize = 128;

#[derive(Clone, Copy, Debug)]
struct Point {
    sole: usize,
    vertex: usize,
    r: Vector3<f64>,
    /// Motion without contact less the target.
    free: Vector3<f64>,
    mu: f64,
    /// Direction of a vertex in motion.
    direction: Option<Vector2<f64>>,
    /// f, y, l of the method.
    force: Vector3<f64>,
    split: Vector3<f64>,
    dual: Vector3<f64>,
    /// x before the iteration.
    before: Vector3<f64>,
}

impl Point {
    /// Sets y and l from x.
    fn set(&mut self, x: Vector3<f64>, rho: f64) {
        self.split = project(x, self.mu, self.direction);
        self.dual = (x - self.split) * rho;
    }

    /// The normal part of s.
    fn shift(&self) -> f64 {
        match self.direction {
            None => self.mu * self.dual.xy().norm(),
            Some(u) => -self.mu * u.dot(&self.dual.xy()),
        }
    }
}

/// Points of a problem and the scratch of their solution.
#[derive(Clone, Debug)]
pub struct PointForces {
    points: Vec<Point>,
    /// `rho + A A^T W`, factorised in place.
    matrix: DMatrix<f64>,
    pivots: Vec<usize>,
    wrench: DVector<f64>,
    motion: DVector<f64>,
    /// Penalty of the method, iterations so far, and the residual after the last.
    rho: f64,
    acceleration: Acceleration,
    iterations: usize,
    residual: f64,
    /// Whether slipping vertices have got mu_k.
    has_slips: bool,
    is_done: bool,
}

impl PointForces {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        let n = p.dim();
        PointForces {
            points: Vec::with_capacity(MAX_POINTS),
            matrix: DMatrix::zeros(n, n),
            pivots: vec![0; n],
            wrench: DVector::zeros(n),
            motion: DVector::zeros(n),
            rho: 1.0,
            acceleration: Acceleration::new(3 * p.vertex_indices().count().min(MAX_POINTS)),
            iterations: 0,
            residual: 0.0,
            has_slips: false,
            is_done: true,
        }
    }

    /// Solves for the vertices for which `touches` holds. Returns the greatest residual, relative.
    pub fn solve(&mut self, p: &Problem, touches: impl Fn(usize, usize) -> bool) -> f64 {
        self.begin(p, touches, None);
        while !self.is_done {
            self.advance(p, ITERATIONS);
        }
        self.residual
    }

    /// Poses the problem of the vertices for which `touches` holds. Iterations start from no forces,
    /// or from those of a solution times a factor.
    pub fn begin(&mut self, p: &Problem, touches: impl Fn(usize, usize) -> bool, start: Option<(&Solution, f64)>) {
        self.points.clear();
        for (s, i) in p.vertex_indices().filter(|&(s, i)| touches(s, i)).take(MAX_POINTS) {
            let v = &p.soles[s].vertices[i];
            let mut free = p.vertex_motion(&p.b, s, i);
            if p.level == Level::Velocity {
                free.z -= p.soles[s].vertex_target(i);
            }
            let (mu, direction) = if v.moving { (v.mu_k, Some(v.direction)) } else { (v.mu_s, None) };
            let split = start.map_or(Vector3::zeros(), |(solution, factor)| {
                let t = solution.tangent[s][i];
                project(Vector3::new(t.x, t.y, solution.normal[s][i]) * factor, mu, direction)
            });
            let zero = Vector3::zeros();
            self.points.push(Point {
                sole: s,
                vertex: i,
                r: v.r,
                free,
                mu,
                direction,
                force: split,
                split,
                dual: zero,
                before: zero,
            });
        }
        self.iterations = 0;
        self.has_slips = false;
        self.is_done = self.points.is_empty();
        self.residual = if self.is_done { 0.0 } else { f64::INFINITY };
        if self.is_done {
            return;
        }
        if start.is_some() {
            // l = -z with the motions of the starting forces.
            self.motion(p);
            for point in &mut self.points {
                let m = &self.motion.as_slice()[6 * point.sole..6 * point.sole + 6];
                let free = &p.b[6 * point.sole..6 * point.sole + 6];
                let change = |r: usize| m[r] - free[r];
                let linear = Vector3::new(change(0), change(1), change(2));
                let turn = Vector3::new(change(3), change(4), change(5));
                let z = point.free + linear + turn.cross(&point.r);
                point.dual = -z;
                point.dual.z -= point.shift();
            }
        }
        let n = p.dim();
        let trace: f64 = (0..n).map(|i| p.w[i * n + i]).sum();
        // Response of a point to its own force, roughly: the scale of H.
        self.rho = trace / n as f64;
        self.factorize(p, self.rho);
        self.acceleration.restart();
    }

    /// Takes at most `count` iterations.
    pub fn advance(&mut self, p: &Problem, count: usize) {
        for _ in 0..count {
            if self.is_done {
                return;
            }
            self.iterate(p);
            if self.residual >= ACCURATE && self.iterations < ITERATIONS {
                continue;
            }
            // What slips does so with mu_k.
            let drive = self.drive();
            let mut changed = false;
            if !std::mem::replace(&mut self.has_slips, true) {
                for point in self.points.iter_mut().filter(|point| point.direction.is_none()) {
                    let v = &p.soles[point.sole].vertices[point.vertex];
                    if v.mu_k != v.mu_s && point.dual.xy().norm() > SLIPS * drive && point.split.z > 0.0 {
                        point.mu = v.mu_k;
                        changed = true;
                    }
                }
            }
            self.is_done = !changed;
            self.iterations = 0;
            self.acceleration.restart();
        }
    }

    /// Whether the iterations have ended.
    pub fn is_done(&self) -> bool {
        self.is_done
    }

    /// Residual after the last iteration, relative.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Motions of the soles with the forces of the last solve, 6F.
    pub fn motion(&mut self, p: &Problem) -> &[f64] {
        let n = p.dim();
        self.wrench.fill(0.0);
        for point in &self.points {
            let one = wrench_at(&point.r, &point.split);
            let rows = self.wrench.as_mut_slice()[6 * point.sole..6 * point.sole + 6].iter_mut();
            rows.zip(one).for_each(|(sum, x)| *sum += x);
        }
        for (i, m) in self.motion.iter_mut().enumerate() {
            *m = p.b[i] + p.w[i * n..(i + 1) * n].iter().zip(self.wrench.iter()).map(|(w, x)| w * x).sum::<f64>();
        }
        self.motion.as_slice()
    }

    /// Forces of the last solve, by sole and vertex, floor axes.
    pub fn forces(&self) -> impl Iterator<Item = (usize, usize, Vector3<f64>)> + '_ {
        self.points.iter().map(|point| (point.sole, point.vertex, point.split))
    }

    /// Scale of motions: the greatest without contact.
    fn drive(&self) -> f64 {
        self.points.iter().map(|point| point.free.norm()).fold(0.0, f64::max)
    }

    /// One iteration.
    fn iterate(&mut self, p: &Problem) {
        let drive = self.drive().max(f64::MIN_POSITIVE);
        let rho = self.rho;
        let (mut primal, mut dual, mut load): (f64, f64, f64) = (0.0, 0.0, f64::MIN_POSITIVE);
        for point in &mut self.points {
            let shift = Vector3::new(0.0, 0.0, point.shift());
            point.before = point.split + point.dual / rho;
            point.force = point.split * rho - point.dual - point.free - shift;
        }
        self.apply_inverse(p, rho);
        for point in &mut self.points {
            let (force, split) = (point.force, point.split);
            point.set(force + point.dual / rho, rho);
            primal = primal.max((force - point.split).norm());
            dual = dual.max((point.split - split).norm() * rho);
            load = load.max(point.split.norm());
        }
        let (primal, dual) = (primal / load, dual / drive);
        self.residual = primal.max(dual);
        self.iterations += 1;
        if self.residual < ACCURATE {
            return;
        }
        // Balances the two residuals.
        let ratio = (primal / dual).sqrt();
        let unbalanced = !(0.3..3.0).contains(&ratio) && ratio.is_finite() && ratio > 0.0;
        if self.iterations.is_multiple_of(20) && unbalanced {
            self.rho *= ratio.clamp(0.1, 10.0);
            self.factorize(p, self.rho);
            self.acceleration.restart();
            return;
        }
        let points = &mut self.points;
        let sequence = points.iter().map(|point| (point.before, point.split + point.dual / rho));
        if let Some(next) = self.acceleration.combine(sequence) {
            for (point, x) in points.iter_mut().zip(next.chunks_exact(3)) {
                point.set(Vector3::from_column_slice(x), rho);
            }
        }
    }

    /// Replaces the forces x by `(H + rho)^-1 x`.
    fn apply_inverse(&mut self, p: &Problem, rho: f64) {
        let n = p.dim();
        self.wrench.fill(0.0);
        for point in &self.points {
            let one = wrench_at(&point.r, &point.force);
            let rows = self.wrench.as_mut_slice()[6 * point.sole..6 * point.sole + 6].iter_mut();
            rows.zip(one).for_each(|(sum, x)| *sum += x);
        }
        self.back_substitute();
        for (i, m) in self.motion.iter_mut().enumerate() {
            *m = p.w[i * n..(i + 1) * n].iter().zip(self.wrench.iter()).map(|(w, x)| w * x).sum();
        }
        for point in &mut self.points {
            let m = &self.motion.as_slice()[6 * point.sole..6 * point.sole + 6];
            let motion = Vector3::new(m[0], m[1], m[2]) + Vector3::new(m[3], m[4], m[5]).cross(&point.r);
            point.force = (point.force - motion) / rho;
        }
    }

    /// Factorises `rho + A A^T W` with row pivoting.
    fn factorize(&mut self, p: &Problem, rho: f64) {
        let n = p.dim();
        self.matrix.fill(0.0);
        for s in 0..p.soles.len() {
            // A A^T is block diagonal: sum over the points of a sole of [1; r x] [1; r x]^T.
            let mut block = [[0.0; 6]; 6];
            for point in self.points.iter().filter(|point| point.sole == s) {
                for axis in 0..3 {
                    let column = wrench_at(&point.r, &Vector3::ith(axis, 1.0));
                    for (row, a) in block.iter_mut().zip(column) {
                        row.iter_mut().zip(column).for_each(|(x, b)| *x += a * b);
                    }
                }
            }
            for (r, row) in block.iter().enumerate() {
                for c in 0..n {
                    let product = row.iter().enumerate().map(|(k, b)| b * p.w[(6 * s + k) * n + c]).sum::<f64>();
                    self.matrix[(6 * s + r, c)] = product;
                }
            }
        }
        (0..n).for_each(|i| self.matrix[(i, i)] += rho);
        for c in 0..n {
            let pivot = (c..n).max_by(|a, b| self.matrix[(*a, c)].abs().total_cmp(&self.matrix[(*b, c)].abs()));
            let pivot = pivot.unwrap_or(c);
            self.pivots[c] = pivot;
            self.matrix.swap_rows(c, pivot);
            let divisor = self.matrix[(c, c)];
            for r in c + 1..n {
                let factor = self.matrix[(r, c)] / divisor;
                self.matrix[(r, c)] = factor;
                for j in c + 1..n {
                    let term = factor * self.matrix[(c, j)];
                    self.matrix[(r, j)] -= term;
                }
            }
        }
    }

    fn back_substitute(&mut self) {
        let n = self.pivots.len();
        let x = self.wrench.as_mut_slice();
        for c in 0..n {
            x.swap(c, self.pivots[c]);
        }
        for c in 0..n {
            let top = x[c];
            for (r, x) in x.iter_mut().enumerate().skip(c + 1) {
                *x -= self.matrix[(r, c)] * top;
            }
        }
        for c in (0..n).rev() {
            x[c] /= self.matrix[(c, c)];
            let top = x[c];
            for (r, x) in x.iter_mut().enumerate().take(c) {
                *x -= self.matrix[(r, c)] * top;
            }
        }
    }

    /// The states that the solution indicates: the smallest pattern over the carrying vertices, those
    /// with more than `least` of the greatest force. It slides if they slip by more than `slips` of
    /// the motion without contact, about the only one that does not.
    pub fn states(&self, p: &Problem, least: f64, slips: f64) -> States {
        let mut states = States::default();
        let load = self.points.iter().map(|point| point.split.z).fold(0.0, f64::max);
        let drive = self.drive();
        for s in 0..p.soles.len().min(MAX_SOLES) {
            let k = p.soles[s].vertices.len();
            let (mut carrying, mut slipping) = (0u64, 0u64);
            for point in self.points.iter().filter(|point| point.sole == s && point.split.z > least * load) {
                carrying |= 1 << point.vertex;
                let moves = point.direction.is_some() || point.dual.xy().norm() > slips * drive;
                slipping |= u64::from(moves) << point.vertex;
            }
            let pattern = Pattern::covering(k, |i| carrying >> i & 1 == 1);
            if pattern == Pattern::Free {
                continue;
            }
            let sticking = carrying & !slipping;
            let mode = match (slipping, sticking.count_ones()) {
                (0, _) => Mode::Static,
                (_, 0) => Mode::Sliding,
                (_, 1) => Mode::Pivoting(sticking.trailing_zeros() as u8),
                _ => Mode::Static,
            };
            states[s] = SoleState { pattern, mode };
        }
        states
    }
}

/// Anderson's acceleration of a fixed-point iteration `x <- G(x)`.
///
/// With the changes dG and dr of the last results and of r = G(x) - x, the next point is
/// `G - dG c` with the c that minimizes |r - dr c|.
#[derive(Clone, Debug)]
struct Acceleration {
    /// Changes of G and r, one after the other; the oldest is replaced.
    results: Vec<f64>,
    residuals: Vec<f64>,
    count: usize,
    next: usize,
    /// The last G and r, and the size of r; none after a restart.
    last: Vec<f64>,
    last_residual: Vec<f64>,
    last_size: Option<f64>,
    point: Vec<f64>,
    /// Products of the changes of r, and their factor.
    gram: Vec<f64>,
    factor: Symmetric,
    coefficients: Vec<f64>,
}

impl Acceleration {
    /// For points of at most `n` numbers.
    fn new(n: usize) -> Self {
        Acceleration {
            results: vec![0.0; MEMORY * n],
            residuals: vec![0.0; MEMORY * n],
            count: 0,
            next: 0,
            last: Vec::with_capacity(n),
            last_residual: Vec::with_capacity(n),
            last_size: None,
            point: Vec::with_capacity(n),
            gram: vec![0.0; MEMORY * MEMORY],
            factor: Symmetric::zeros(MEMORY),
            coefficients: vec![0.0; MEMORY],
        }
    }

    fn restart(&mut self) {
        (self.count, self.next, self.last_size) = (0, 0, None);
    }

    /// The next point after an iteration from x to G(x), given as pairs of three numbers each; none
    /// if it is G(x) itself.
    fn combine(&mut self, sequence: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + Clone) -> Option<&[f64]> {
        let size = sequence.clone().map(|(x, g)| (g - x).norm_squared()).sum::<f64>().sqrt();
        let n = 3 * sequence.clone().count();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        match self.last_size {
            Some(last) if size <= GROWS * last => {
                let at = self.next * n..(self.next + 1) * n;
                let results = self.results[at.clone()].chunks_exact_mut(3).zip(self.last.chunks_exact(3));
                let residuals = self.residuals[at].chunks_exact_mut(3).zip(self.last_residual.chunks_exact(3));
                for (((x, g), (dg, before)), (dr, residual)) in sequence.clone().zip(results).zip(residuals) {
                    for axis in 0..3 {
                        dg[axis] = g[axis] - before[axis];
                        dr[axis] = g[axis] - x[axis] - residual[axis];
                    }
                }
                self.count = (self.count + 1).min(MEMORY);
                let changes = self.residuals.chunks_exact(n).take(self.count);
                for (i, change) in changes.enumerate() {
                    let product = dot(change, &self.residuals[self.next * n..(self.next + 1) * n]);
                    self.gram[i * MEMORY + self.next] = product;
                    self.gram[self.next * MEMORY + i] = product;
                }
                self.next = (self.next + 1) % MEMORY;
            }
            Some(_) => self.restart(),
            None => {}
        }
        self.last_size = Some(size);
        self.last.clear();
        self.last_residual.clear();
        for (x, g) in sequence {
            self.last.extend_from_slice(g.as_slice());
            self.last_residual.extend_from_slice((g - x).as_slice());
        }
        let m = self.count;
        if m == 0 {
            return None;
        }
        self.factor.set_order(m);
        let trace: f64 = (0..m).map(|i| self.gram[i * MEMORY + i]).sum();
        for (i, row) in self.factor.entries.chunks_exact_mut(m).enumerate() {
            row.copy_from_slice(&self.gram[i * MEMORY..i * MEMORY + m]);
            row[i] += DEPENDENT * trace;
        }
        for (c, change) in self.coefficients.iter_mut().zip(self.residuals.chunks_exact(n)).take(m) {
            *c = dot(change, &self.last_residual);
        }
        if !self.factor.factorize() {
            self.restart();
            return None;
        }
        self.factor.solve(&mut self.coefficients[..m]);
        self.point.clear();
        self.point.extend_from_slice(&self.last);
        for (c, dg) in self.coefficients[..m].iter().zip(self.results.chunks_exact(n)) {
            self.point.iter_mut().zip(dg).for_each(|(x, dg)| *x -= c * dg);
        }
        Some(&self.point)
    }
}

/// Projection onto the friction cone of coefficient `mu`, or onto the ray of a moving vertex.
fn project(f: Vector3<f64>, mu: f64, direction: Option<Vector2<f64>>) -> Vector3<f64> {
    if let Some(u) = direction {
        let ray = Vector3::new(-mu * u.x, -mu * u.y, 1.0);
        return ray * (ray.dot(&f).max(0.0) / ray.norm_squared());
    }
    let (size, normal) = (f.xy().norm(), f.z);
    if size <= mu * normal {
        return f;
    }
    if mu * size <= -normal {
        return Vector3::zeros();
    }
    let n = (mu * size + normal) / (1.0 + mu * mu);
    let t = f.xy() * (mu * n / size);
    Vector3::new(t.x, t.y, n)
}
