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
//! so an iteration costs products with A and one solve of size 6F, or, of few points, one solve with the
//! symmetric matrix `H + rho` itself. z = -l at the solution.
//!
//! The iteration is a map of `x = f + l / rho`, from which y = P_K(x) and l = rho (x - y) follow.
//! Alone it needs thousands of iterations where many vertices of a sole share a load. With
//! Anderson's acceleration ([`crate::linalg::anderson`]) it ends in a few once the set of carrying
//! and slipping vertices is found, as the map is then smooth.
//!
//! s follows from the last iteration, so that friction close to a jam keeps the method from
//! converging. Then the points are visited in turn, as by the method `ncp` [Jean 1999]:
//!
//! ```text
//! N <- max(0, N - (m_n - target) / K)        t <- P(t - m_t / D)        or  t <- -mu_k N u
//! ```
//!
//! with D the greatest tangential response of the point to its own force and K its normal response,
//! for a moving one to `(-mu_k u, 1)`. The residual is that of f = P_K(f - z / rho). If the visits do not end
//! either, both are repeated once from the best of their forces.
//!
//! The result names states to be tested; the accuracy of their forces is that of the candidate
//! solve. A vertex in motion has mu_k. One at rest has mu_s, and mu_k once it slips.

mod readings;
mod visits;

use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::States;
use crate::contact::search::MANY;
use crate::linalg::anderson::Anderson;
use crate::linalg::cholesky::Symmetric;
use crate::linalg::dot;
use crate::linalg::linear::Linear;
use nalgebra::{Vector2, Vector3};

/// Most iterations of the alternating directions.
const ITERATIONS: usize = 400;
/// Most visits to all points.
const VISITS: usize = 1000;
/// The same for loads inside the cones, which are found soon if there are any.
const ITERATIONS_INSIDE: usize = 100;
/// Residuals at which the states are read, relative to load and motion: far below the forces and
/// motions by which states differ, far above rounding.
const ACCURATE: f64 = 1e-9;
/// Greatest force of a solution, relative to that which alone would stop the motion.
const DIVERGED: f64 = 1e9;
/// Tangential motion of a vertex that slips, relative to the motion without contact.
pub const SLIPS: f64 = 1e-6;
/// The same as far as the solution is accurate.
pub const LEAST_SLIPS: f64 = 1e-8;

#[derive(Clone, Copy, Debug)]
struct Point {
    sole: usize,
    vertex: usize,
    r: Vector3<f64>,
    /// Motion without contact less the target.
    free: Vector3<f64>,
    mu: f64,
    /// N0, zero but for [`PointForces::solve_inside`].
    least: f64,
    /// Direction of a vertex in motion.
    direction: Option<Vector2<f64>>,
    /// f, y, l of the method.
    force: Vector3<f64>,
    split: Vector3<f64>,
    dual: Vector3<f64>,
    /// x before the iteration.
    before: Vector3<f64>,
    /// y of the best visit.
    best: Vector3<f64>,
    /// K and D of the visits.
    normal: f64,
    tangential: f64,
}

impl Point {
    /// Sets y and l from x.
    fn set(&mut self, x: Vector3<f64>, rho: f64) {
        self.split = project(x, self.mu, self.direction);
        self.dual = (x - self.split) * rho;
    }

    /// Its motion less the target, for the motions of the soles.
    fn motion(&self, p: &Problem, motion: &[f64]) -> Vector3<f64> {
        let change: [f64; 6] = std::array::from_fn(|r| motion[6 * self.sole + r] - p.b[6 * self.sole + r]);
        self.free + motion_at(&change, &self.r)
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
    matrix: Vec<f64>,
    linear: Linear,
    /// H if there are few points, and the factor of `H + rho`.
    response: Vec<f64>,
    factor: Symmetric,
    forces: Vec<f64>,
    wrench: Vec<f64>,
    motion: Vec<f64>,
    /// Penalty of the method.
    rho: f64,
    acceleration: Anderson,
    /// Whether the points are visited in turn, iterations or visits so far, and the residual after
    /// the last.
    is_visiting: bool,
    iterations: usize,
    residual: f64,
    /// The least residual of all visits, and whether they have ended once.
    best: f64,
    has_visited: bool,
    is_done: bool,
}

impl PointForces {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        let (n, vertices) = (p.dim(), p.vertex_indices().count());
        PointForces {
            points: Vec::with_capacity(vertices),
            matrix: vec![0.0; n * n],
            linear: Linear::new(n),
            response: Vec::with_capacity(n * n),
            factor: Symmetric::zeros(n),
            forces: Vec::with_capacity(n),
            wrench: vec![0.0; n],
            motion: vec![0.0; n],
            rho: 1.0,
            acceleration: Anderson::new(3 * vertices),
            is_visiting: false,
            iterations: 0,
            residual: 0.0,
            best: f64::INFINITY,
            has_visited: false,
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

    /// As [`solve`](Self::solve) for forces inside the cones of the vertices of static soles of `states`, `|t| <= share
    /// mu (N - N0)`, with `N0 = (1 - share)` times the typical load of a vertex. Their dual condition is that of N - N0:
    /// it is a solution of the problem only if they stay at rest.
    pub fn solve_inside(&mut self, p: &Problem, states: &States, share: f64) -> f64 {
        let touches = |s: usize, i: usize| states[s].clamps(i, p.soles[s].vertices.len());
        self.begin(p, touches, None);
        let least = (1.0 - share) * p.scale / self.points.len().max(1) as f64;
        for point in self.points.iter_mut().filter(|point| states[point.sole].is_static()) {
            (point.mu, point.least) = (point.mu * share, least);
        }
        // The rest of the force obeys the problem with the motion that N0 causes.
        self.gather(|point| Vector3::z() * point.least);
        for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(p.dim())) {
            *m = dot(row, &self.wrench);
        }
        for point in &mut self.points {
            point.free += motion_at(&self.motion[6 * point.sole..6 * point.sole + 6], &point.r);
        }
        self.advance(p, ITERATIONS_INSIDE);
        self.residual
    }

    /// Poses the problem of the vertices for which `touches` holds. Iterations start from no forces,
    /// or from those of a solution times a factor.
    pub fn begin(&mut self, p: &Problem, touches: impl Fn(usize, usize) -> bool, start: Option<(&Solution, f64)>) {
        self.points.clear();
        for (s, i) in p.vertex_indices().filter(|&(s, i)| touches(s, i)) {
            let v = &p.soles[s].vertices[i];
            let mut free = p.vertex_motion(&p.b, s, i);
            if p.level == Level::Velocity {
                free.z -= p.soles[s].vertex_target(i);
            }
            let (mu, direction) = if v.moving { (v.slip_mu(), Some(v.direction)) } else { (v.stick_mu(p.level), None) };
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
                least: 0.0,
                direction,
                force: split,
                split,
                dual: zero,
                before: zero,
                best: zero,
                normal: 0.0,
                tangential: 0.0,
            });
        }
        (self.is_visiting, self.iterations, self.has_visited) = (false, 0, false);
        (self.best, self.is_done) = (f64::INFINITY, self.points.is_empty());
        self.residual = if self.is_done { 0.0 } else { f64::INFINITY };
        if self.is_done {
            return;
        }
        if start.is_some() {
            self.motion(p);
            self.set_duals(p);
        }
        let n = p.dim();
        let trace: f64 = (0..n).map(|i| p.w[i * n + i]).sum();
        // Response of a point to its own force, roughly: the scale of H.
        self.rho = trace / n as f64;
        if self.has_few_points(p) {
            self.respond(p);
        }
        self.factorize(p, self.rho);
        self.acceleration.restart();
    }

    /// Whether `H + rho` is smaller than a great matrix of the soles, in a step or an impact.
    fn has_few_points(&self, p: &Problem) -> bool {
        p.level == Level::Velocity && p.soles.len() > MANY && 3 * self.points.len() < p.dim()
    }

    /// Computes H.
    fn respond(&mut self, p: &Problem) {
        let (n, size) = (p.dim(), 3 * self.points.len());
        self.response.resize(size * size, 0.0);
        for (d, point) in self.points.iter().enumerate() {
            for axis in 0..3 {
                let wrench = wrench_at(&point.r, &Vector3::ith(axis, 1.0));
                for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(n)) {
                    *m = dot(&row[6 * point.sole..], &wrench);
                }
                // H is symmetric: its rows are its columns.
                let row = &mut self.response[(3 * d + axis) * size..][..size];
                for (entry, point) in row.chunks_exact_mut(3).zip(&self.points) {
                    let motion = motion_at(&self.motion[6 * point.sole..6 * point.sole + 6], &point.r);
                    entry.copy_from_slice(motion.as_slice());
                }
            }
        }
    }

    /// Sets l = -z from the motions of the soles.
    fn set_duals(&mut self, p: &Problem) {
        for point in &mut self.points {
            point.dual = -point.motion(p, &self.motion);
            point.dual.z -= point.shift();
        }
    }

    /// Takes at most `count` iterations.
    pub fn advance(&mut self, p: &Problem, count: usize) {
        for _ in 0..count {
            if self.is_done {
                return;
            }
            if self.is_visiting {
                self.visit(p)
            } else {
                self.iterate(p)
            }
            self.iterations += 1;
            if self.residual < ACCURATE {
                self.is_done = !self.let_slip(p);
            } else if self.is_visiting {
                self.keep_best();
                if self.iterations == VISITS {
                    self.restore_best(p);
                    self.is_done = self.has_visited;
                    (self.is_visiting, self.iterations, self.has_visited) = (self.is_done, 0, true);
                    self.acceleration.restart();
                }
            } else if self.iterations == ITERATIONS {
                // A jamming vertex has no solution to which visits could converge.
                self.is_done = !self.begin_visits(p);
            }
        }
    }

    /// What slips does so with mu_k. Returns whether a coefficient has changed; the iterations then begin
    /// again.
    pub fn let_slip(&mut self, p: &Problem) -> bool {
        let drive = self.drive();
        let mut changed = false;
        for point in self.points.iter_mut().filter(|point| point.direction.is_none()) {
            let mu_k = p.soles[point.sole].vertices[point.vertex].slip_mu();
            if point.mu != mu_k && point.dual.xy().norm() > SLIPS * drive && point.split.z > 0.0 {
                point.mu = mu_k;
                changed = true;
            }
        }
        if changed {
            (self.is_visiting, self.iterations, self.has_visited, self.is_done) = (false, 0, false, false);
            (self.residual, self.best) = (f64::INFINITY, f64::INFINITY);
        }
        self.acceleration.restart();
        changed
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
        self.gather(|point| point.split + Vector3::z() * point.least);
        let rows = p.w.chunks_exact(p.dim());
        for ((m, b), row) in self.motion.iter_mut().zip(&p.b).zip(rows) {
            *m = b + row.iter().zip(&self.wrench).map(|(w, x)| w * x).sum::<f64>();
        }
        &self.motion
    }

    /// Wrenches of the soles for a force of each point.
    fn gather(&mut self, force: impl Fn(&Point) -> Vector3<f64>) {
        self.wrench.fill(0.0);
        for point in &self.points {
            let one = wrench_at(&point.r, &force(point));
            self.wrench[6 * point.sole..6 * point.sole + 6].iter_mut().zip(one).for_each(|(sum, x)| *sum += x);
        }
    }

    /// Forces of the last solve, by sole and vertex, floor axes.
    pub fn forces(&self) -> impl Iterator<Item = (usize, usize, Vector3<f64>)> + '_ {
        self.points.iter().map(|point| (point.sole, point.vertex, point.split + Vector3::z() * point.least))
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
        if self.residual < ACCURATE {
            return;
        }
        // Balances the two residuals.
        let ratio = (primal / dual).sqrt();
        let unbalanced = !(0.3..3.0).contains(&ratio) && ratio.is_finite() && ratio > 0.0;
        if (self.iterations + 1).is_multiple_of(20) && unbalanced {
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
        if self.has_few_points(p) {
            self.forces.clear();
            self.points.iter().for_each(|point| self.forces.extend_from_slice(point.force.as_slice()));
            self.factor.solve(&mut self.forces);
            for (point, force) in self.points.iter_mut().zip(self.forces.chunks_exact(3)) {
                point.force = Vector3::from_column_slice(force);
            }
            return;
        }
        self.gather(|point| point.force);
        self.linear.apply(&self.matrix, &mut self.wrench);
        for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(p.dim())) {
            *m = row.iter().zip(&self.wrench).map(|(w, x)| w * x).sum();
        }
        for point in &mut self.points {
            let motion = motion_at(&self.motion[6 * point.sole..6 * point.sole + 6], &point.r);
            point.force = (point.force - motion) / rho;
        }
    }

    /// Factorises `H + rho` or `rho + A A^T W`.
    fn factorize(&mut self, p: &Problem, rho: f64) {
        let n = p.dim();
        if self.has_few_points(p) {
            let size = 3 * self.points.len();
            self.factor.set_order(size);
            self.factor.entries.copy_from_slice(&self.response);
            (0..size).for_each(|i| self.factor.entries[i * size + i] += rho);
            // H is positive semidefinite up to rounding, far below rho.
            self.factor.factorize();
            return;
        }
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
                    self.matrix[(6 * s + r) * n + c] = product;
                }
            }
        }
        (0..n).for_each(|i| self.matrix[i * n + i] += rho);
        self.linear.factor(&mut self.matrix, n);
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

/// Motion of a point at `r` of a sole that moves with `motion`, without centripetal term.
fn motion_at(motion: &[f64], r: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(motion[0], motion[1], motion[2]) + Vector3::new(motion[3], motion[4], motion[5]).cross(r)
}
