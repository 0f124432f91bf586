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
//! The result names states to be tested; the accuracy of their forces is that of the candidate
//! solve. A vertex in motion has mu_k. One at rest has mu_s, and mu_k once it slips.

use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::wrench_at;
use crate::contact::model::state::{MAX_SOLES, Mode, Pattern, SoleState, States};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};

/// Most iterations of one solve.
const ITERATIONS: usize = 2000;
/// Residuals at which the states are read, relative to load and motion: far below the forces and
/// motions by which states differ, far above rounding.
const ACCURATE: f64 = 1e-9;
/// Tangential motion of a vertex that slips, relative to the motion without contact.
const SLIPS: f64 = 1e-6;
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
        }
    }

    /// Solves for the vertices for which `touches` holds. Returns the greatest residual, relative.
    pub fn solve(&mut self, p: &Problem, touches: impl Fn(usize, usize) -> bool) -> f64 {
        self.points.clear();
        for (s, i) in p.vertex_indices().filter(|&(s, i)| touches(s, i)).take(MAX_POINTS) {
            let v = &p.soles[s].vertices[i];
            let mut free = p.vertex_motion(&p.b, s, i);
            if p.level == Level::Velocity {
                free.z -= p.soles[s].vertex_target(i);
            }
            let (mu, direction) = if v.moving { (v.mu_k, Some(v.direction)) } else { (v.mu_s, None) };
            let zero = Vector3::zeros();
            self.points.push(Point {
                sole: s,
                vertex: i,
                r: v.r,
                free,
                mu,
                direction,
                force: zero,
                split: zero,
                dual: zero,
            });
        }
        if self.points.is_empty() {
            return 0.0;
        }
        let mut residual = self.iterate(p);
        // What slips does so with mu_k.
        let mut changed = false;
        let drive = self.drive();
        for point in self.points.iter_mut().filter(|point| point.direction.is_none()) {
            let v = &p.soles[point.sole].vertices[point.vertex];
            if v.mu_k != v.mu_s && point.dual.xy().norm() > SLIPS * drive && point.split.z > 0.0 {
                point.mu = v.mu_k;
                changed = true;
            }
        }
        if changed {
            residual = self.iterate(p);
        }
        residual
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

    /// Iterates from the present forces; returns the relative residual.
    fn iterate(&mut self, p: &Problem) -> f64 {
        let n = p.dim();
        let drive = self.drive().max(f64::MIN_POSITIVE);
        let trace: f64 = (0..n).map(|i| p.w[i * n + i]).sum();
        // Response of a point to its own force, roughly: the scale of H.
        let mut rho = trace / n as f64;
        self.factorize(p, rho);
        let mut residual = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            let (mut primal, mut dual, mut load): (f64, f64, f64) = (0.0, 0.0, f64::MIN_POSITIVE);
            for point in &mut self.points {
                let shift = match point.direction {
                    None => point.mu * point.dual.xy().norm(),
                    Some(u) => -point.mu * u.dot(&point.dual.xy()),
                };
                point.force = point.split * rho - point.dual - point.free - Vector3::new(0.0, 0.0, shift);
            }
            self.apply_inverse(p, rho);
            for point in &mut self.points {
                let before = point.split;
                point.split = project(point.force + point.dual / rho, point.mu, point.direction);
                let gap = point.force - point.split;
                point.dual += gap * rho;
                primal = primal.max(gap.norm());
                dual = dual.max((point.split - before).norm() * rho);
                load = load.max(point.split.norm());
            }
            let (primal, dual) = (primal / load, dual / drive);
            residual = primal.max(dual);
            if residual < ACCURATE {
                break;
            }
            // Balances the two residuals.
            if iteration % 20 == 19 {
                let ratio = (primal / dual).sqrt();
                if !(0.3..3.0).contains(&ratio) && ratio.is_finite() && ratio > 0.0 {
                    rho *= ratio.clamp(0.1, 10.0);
                    self.factorize(p, rho);
                }
            }
        }
        residual
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
    /// with more than `least` of the greatest force. It slides if they slip, about the only one that
    /// does not.
    pub fn states(&self, p: &Problem, least: f64) -> States {
        let mut states = States::default();
        let load = self.points.iter().map(|point| point.split.z).fold(0.0, f64::max);
        let drive = self.drive();
        for s in 0..p.soles.len().min(MAX_SOLES) {
            let k = p.soles[s].vertices.len();
            let (mut carrying, mut slipping) = (0u64, 0u64);
            for point in self.points.iter().filter(|point| point.sole == s && point.split.z > least * load) {
                carrying |= 1 << point.vertex;
                let slips = point.direction.is_some() || point.dual.xy().norm() > SLIPS * drive;
                slipping |= u64::from(slips) << point.vertex;
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
