//! The penalty method at the velocity level: implicit springs, dampers and friction of a fixed
//! step.
//!
//! ```text
//! N = max(0, k (delta - dt u_n) - c u_n)        t = -mu_k N u_t / sqrt(|u_t|^2 + s^2)        m = b + dt W J^T (t, N)
//! ```
//!
//! with u the velocities of the vertices at the end of the step, m those of the soles, b the latter
//! without contact, and delta the depth at the start (c applies only where it is positive). Like
//! backward Euler this has no stability limit. For k to infinity it becomes the rigid condition
//! `u_n >= -gap / dt`. It is solved by damped Newton steps,
//!
//! ```text
//! F(m) = m - b - dt W J^T f(m) = 0        (1 + W A) dm = -F        A = -dt J^T f'(u) J
//! ```
//!
//! whose A is not symmetric, as friction follows the normal force. The steps begin at the motions at
//! the end of the last step.

use crate::contact::methods::penalty::PenaltyParameters;
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::linalg::linear::Linear;
use nalgebra::{Matrix3, Vector3};

/// Most Newton steps of one iteration.
const ROUNDS: usize = 15;
/// A Newton step that does not reduce F is halved, down to this fraction.
const SHORTEST: f64 = 1.0 / 1024.0;
/// If the Newton steps do not converge (a slide that stops within the step overshoots by
/// mu g dt / s), the slip velocity is reduced by this factor at a time, from the greatest speed to
/// its true value.
const SHARPENING: f64 = 0.2;
/// The iteration ends with a Newton step that changes no velocity by more than this fraction of the
/// velocity or of the slip velocity.
const CONVERGED: f64 = 1e-10;

/// Scratch of the solve, allocated once.
#[derive(Clone)]
pub struct Step {
    law: PenaltyParameters,
    linear: Linear,
    matrix: Vec<f64>,
    motion: Vec<f64>,
    change: Vec<f64>,
    trial: Vec<f64>,
    residual: Vec<f64>,
    wrench: Vec<f64>,
}

impl Step {
    /// For problems of this size.
    pub fn new(p: &Problem, law: PenaltyParameters) -> Self {
        let n = p.dim();
        let zeros = || vec![0.0; n];
        Step {
            law,
            linear: Linear::new(n),
            matrix: vec![0.0; n * n],
            motion: zeros(),
            change: zeros(),
            trial: zeros(),
            residual: zeros(),
            wrench: zeros(),
        }
    }

    /// Writes the impulses of the vertices over `dt` to `out`, which contains the last solution.
    pub fn solve(&mut self, p: &Problem, dt: f64, out: &mut Solution) {
        let target = self.law.slip_velocity;
        self.motion.copy_from_slice(&out.motion);
        if !self.iterate(p, dt) {
            let fastest = p.vertex_indices().map(|(s, i)| p.vertex_motion(&p.b, s, i).norm()).fold(0.0, f64::max);
            self.motion.copy_from_slice(&p.b);
            let mut slip = fastest;
            while slip > target {
                self.law.slip_velocity = slip;
                self.iterate(p, dt);
                slip *= SHARPENING;
            }
            self.law.slip_velocity = target;
            self.iterate(p, dt);
        }
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let f = self.impulse(v, &p.vertex_motion(&self.motion, s, i), dt);
                (out.normal[s][i], out.tangent[s][i]) = (f.z, f.xy());
            }
        }
    }

    /// Damped Newton steps from `motion`. Returns whether they have converged.
    fn iterate(&mut self, p: &Problem, dt: f64) -> bool {
        self.change.fill(0.0);
        let mut size = self.advance(p, dt, 0.0);
        for _ in 0..ROUNDS {
            self.newton(p, dt);
            let before = size;
            let mut part = 1.0;
            size = self.advance(p, dt, part);
            let converged = self.has_converged(p);
            while !converged && !(size <= before * (1.0 - 1e-4 * part)) && part > SHORTEST {
                part *= 0.5;
                size = self.advance(p, dt, part);
            }
            std::mem::swap(&mut self.motion, &mut self.trial);
            if converged {
                return true;
            }
        }
        false
    }

    /// Impulse of the floor on a vertex that ends the step with velocity `u`, N s.
    fn impulse(&self, v: &Vertex, u: &Vector3<f64>, dt: f64) -> Vector3<f64> {
        let n = (-self.law.stiffness * v.height * dt - self.damping(v, dt) * u.z).max(0.0);
        let t = self.law.slip(&u.xy()) * (-v.slip_mu() * n);
        Vector3::new(t.x, t.y, n)
    }

    /// Decrease of the normal impulse per increase of `u_n`, kg.
    fn damping(&self, v: &Vertex, dt: f64) -> f64 {
        let damping = if v.height < 0.0 { self.law.damping } else { 0.0 };
        (damping + self.law.stiffness * dt) * dt
    }

    /// Negative derivative of the impulse with respect to `u`, kg.
    fn stiffening(&self, v: &Vertex, u: &Vector3<f64>, dt: f64) -> Matrix3<f64> {
        let n = self.impulse(v, u, dt).z;
        let mut k = Matrix3::zeros();
        if n > 0.0 {
            let slip = self.law.slip(&u.xy());
            let turn = self.law.turn(&u.xy());
            let normal = self.damping(v, dt);
            k.fixed_view_mut::<2, 2>(0, 0).copy_from(&(turn * (v.slip_mu() * n)));
            k.fixed_view_mut::<2, 1>(0, 2).copy_from(&(slip * (-v.slip_mu() * normal)));
            k[(2, 2)] = normal;
        }
        k
    }

    /// Tries the fraction `part` of the Newton step. Returns the size of F there.
    fn advance(&mut self, p: &Problem, dt: f64, part: f64) -> f64 {
        for ((x, m), d) in self.trial.iter_mut().zip(&self.motion).zip(&self.change) {
            *x = m + part * d;
        }
        self.evaluate(p, dt)
    }

    /// Evaluates F at the trial motions. Returns its size, with angles times the radii of the
    /// soles.
    fn evaluate(&mut self, p: &Problem, dt: f64) -> f64 {
        let n = p.dim();
        self.wrench.fill(0.0);
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let f = self.impulse(v, &p.vertex_motion(&self.trial, s, i), dt);
                let one = wrench_at(&v.r, &f);
                self.wrench[6 * s..6 * s + 6].iter_mut().zip(one).for_each(|(a, b)| *a += b);
            }
        }
        let mut size = 0.0;
        for (i, f) in self.residual.iter_mut().enumerate() {
            let response: f64 = p.w[i * n..(i + 1) * n].iter().zip(&self.wrench).map(|(w, x)| w * x).sum();
            *f = self.trial[i] - p.b[i] - response;
            let length = if i % 6 < 3 { 1.0 } else { p.soles[i / 6].radius };
            size += (*f * length) * (*f * length);
        }
        f64::sqrt(size)
    }

    /// The Newton step from `motion`, where F is `residual`.
    fn newton(&mut self, p: &Problem, dt: f64) {
        let n = p.dim();
        self.matrix.fill(0.0);
        for (s, sole) in p.soles.iter().enumerate() {
            let mut block = [[0.0; 6]; 6];
            for (i, v) in sole.vertices.iter().enumerate() {
                let k = self.stiffening(v, &p.vertex_motion(&self.motion, s, i), dt);
                if k[(2, 2)] == 0.0 {
                    continue;
                }
                // J^T (k J), J the motion of the vertex: its rows, and its columns, are wrenches.
                let rows = [0, 1, 2].map(|a| wrench_at(&v.r, &k.row(a).transpose()));
                for (c, column) in block.iter_mut().enumerate() {
                    let one = wrench_at(&v.r, &Vector3::new(rows[0][c], rows[1][c], rows[2][c]));
                    column.iter_mut().zip(one).for_each(|(sum, x)| *sum += x);
                }
            }
            for (w, row) in p.w.chunks_exact(n).zip(self.matrix.chunks_exact_mut(n)) {
                let w = &w[6 * s..6 * s + 6];
                for (entry, column) in row[6 * s..].iter_mut().zip(&block) {
                    *entry = w.iter().zip(column).map(|(w, a)| w * a).sum();
                }
            }
        }
        for (i, f) in self.residual.iter().enumerate() {
            self.matrix[i * n + i] += 1.0;
            self.change[i] = -f;
        }
        self.linear.solve_regular(&mut self.matrix, &mut self.change);
    }

    /// Is the change from `motion` to the trial motions negligible?
    fn has_converged(&self, p: &Problem) -> bool {
        p.soles.iter().enumerate().all(|(s, sole)| {
            (0..sole.vertices.len()).all(|i| {
                let (a, b) = (p.vertex_motion(&self.motion, s, i), p.vertex_motion(&self.trial, s, i));
                let (change, slip) = (a - b, self.law.slip_velocity);
                change.xy().norm() <= CONVERGED * (slip + b.xy().norm())
                    && change.z.abs() <= CONVERGED * (slip + b.norm())
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::state::States;

    /// A point of mass `m` with velocity `b` at the end of the step without contact, and `depth`
    /// before it.
    fn point(m: f64, b: Vector3<f64>, depth: f64) -> Problem {
        let mut p = Problem::new(&[1]);
        (0..3).for_each(|i| p.w[7 * i] = 1.0 / m);
        (p.b[0], p.b[1], p.b[2], p.step) = (b.x, b.y, b.z, 1e-3);
        let v = &mut p.soles[0].vertices[0];
        (v.height, v.mu_s, v.mu_k) = (-depth, 0.7, 0.5);
        p
    }

    fn solved(p: &Problem, law: PenaltyParameters) -> Vector3<f64> {
        let mut out = Solution::new(p);
        Step::new(p, law).solve(p, p.step, &mut out);
        Vector3::new(out.tangent[0][0].x, out.tangent[0][0].y, out.normal[0][0])
    }

    #[test]
    fn a_point_satisfies_its_law_at_the_end_of_the_step() {
        let law = PenaltyParameters { stiffness: 1e5, damping: 50.0, slip_velocity: 1e-4 };
        let m = 0.7;
        // Fast, slow and next to the limit; deep, just above the floor and well above it.
        for vx in [2.0, 1e-2, 4.99e-3, 1e-5, 0.0] {
            for (depth, vz) in [(1e-4, -0.01), (1e-4, 0.5), (-1e-4, -0.5), (-1e-2, -0.5), (0.0, -0.01)] {
                let p = point(m, Vector3::new(0.6 * vx, -0.8 * vx, vz), depth);
                let (f, dt) = (solved(&p, law), p.step);
                let u = Vector3::new(p.b[0], p.b[1], p.b[2]) + f / m;
                let c = if depth > 0.0 { law.damping } else { 0.0 };
                let n = dt * (law.stiffness * (depth - dt * u.z) - c * u.z).max(0.0);
                let slip = u.xy();
                let t = -slip / slip.norm().hypot(law.slip_velocity) * (0.5 * n);
                // A Newton step of 1e-10 of the slip velocity, times mu N / s.
                let size = 1e-9 * (n + 1e-12);
                assert!((f.z - n).abs() < size && (f.xy() - t).norm() < size, "{vx} {depth} {vz}: {f} {n} {t}");
            }
        }
    }

    #[test]
    fn stiff_springs_and_a_small_slip_velocity_are_the_rigid_step() {
        let (m, h) = (0.7, 1e-4);
        for vx in [2.0, 1e-3] {
            let p = point(m, Vector3::new(vx, 0.0, -0.5), -h);
            let f = solved(&p, PenaltyParameters { stiffness: 1e11, damping: 0.0, slip_velocity: 1e-9 });
            // v_n = -h / dt, and friction is mu N or stops the slip. The mass is 1e-5 of k dt^2:
            // the deviation from rigid.
            let n = m * (0.5 - h / p.step);
            let t = (0.5 * n).min(m * vx);
            assert!((f.z - n).abs() < 1e-5 * n && (f.x + t).abs() < 1e-5 * t, "{f} {n} {t}");
        }
    }

    #[test]
    fn without_a_step_there_is_no_impulse() {
        use crate::contact::methods::contact_method::{ContactSolver, SelectionInput};
        use crate::contact::methods::penalty::Penalty;
        use crate::contact::model::problem::Tolerances;
        use crate::contact::search::judge::Rules;
        let mut p = point(1.0, Vector3::new(1.0, 0.0, -1.0), 1e-3);
        p.step = 0.0;
        let mut out = Solution::new(&p);
        let previous = States::default();
        let rules = Rules::new(Tolerances::default(), previous);
        let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true, cancel: None };
        Penalty::new(&p, PenaltyParameters::default()).impulse(&mut p, &input, &mut out);
        assert!(out.wrench.iter().all(|w| *w == 0.0) && out.motion == p.b);
    }
}
