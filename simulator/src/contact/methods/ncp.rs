//! Time stepping on the true friction cone, by projected Gauss-Seidel.
//!
//! For the velocities at the end of a step, at every point c (a vertex that may meet the floor, see
//! [`crate::contact::methods::points`])
//!
//! ```text
//! 0 <= N_c  _|_  v_n - target >= 0
//! t_c in the disc of radius mu N_c,  and  v_t != 0  =>  t_c = -mu N_c v_t / |v_t|
//! ```
//!
//! with `target = -gap / dt`: Coulomb's law, isotropic, and sliding causes no lift. The points are
//! visited in turn. Each is relaxed by the projections whose fixed points are these conditions, and
//! `v` is updated after each projection:
//!
//! ```text
//! N <- max(0, N - (v_n - target) / D_nn)
//! t <- P(t - v_t / D_tt)                     P projects onto the disc of radius mu N
//! ```
//!
//! D_nn is the point's normal response to its own impulse, D_tt the greatest eigenvalue of the
//! tangential response, which makes both steps descents. The first is exact for its point. Within
//! one sole only its own motion is updated, by W_ss; the other soles follow when its points are done.
//! Successive points of a sole of more than four vertices are not neighbours, which work against
//! each other most.
//! The
//! error of a sweep is the greatest change of an impulse in it, as a velocity (times D_nn or D_tt),
//! m/s. Sweeps start from the impulses of the previous step and end at `tolerance` or after
//! `iterations`, whichever is first. The remaining error shows in the residuals.
//!
//! Known flaw: convergence is linear and slow where points work against each other (several on one
//! sole, heavy on light bodies). After too few sweeps soles creep and sink, and the solution
//! depends on the order of the points.
//!
//! Sources: [Moreau 1988], [Jean 1999]; [Erleben 2007] for the splitting.

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput};
use crate::contact::methods::points::{Point, Points};
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::States;
use crate::contact::search::judge::Assessment;
use crate::contact::search::select::Selection;
use crate::text::quantity::{count, json, positive};
use nalgebra::{Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A point whose friction is below its limit by more than this fraction sticks.
const SATURATED: f64 = 1e-6;

/// Descriptor for scenarios and reports.
pub const DESCRIPTOR: MethodDescriptor = MethodDescriptor {
    name: "ncp",
    doc: "Time stepping on the true friction cone, by projected Gauss-Seidel.",
    only_semi_implicit: Some("knows only impulses over a fixed step"),
    restitution: false,
    unforced: Some("chooses no states"),
    momentless: Some("gives vertices forces alone"),
    colour: "#8A6A00",
    is_configured: |parameters| parameters.ncp != NcpParameters::default(),
    unknowns: None,
    solver: |parameters, p| Box::new(Ncp::new(parameters.ncp, p)),
};

/// Parameters of method `ncp`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NcpParameters {
    /// Most sweeps over the contact points a step.
    #[serde(deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub iterations: u32,
    /// Change within a sweep at which sweeping ends, m/s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub tolerance: f64,
}

impl Default for NcpParameters {
    fn default() -> Self {
        NcpParameters { iterations: 200, tolerance: 1e-9 }
    }
}

/// Solver of the method.
#[derive(Clone)]
pub struct Ncp {
    parameters: NcpParameters,
    points: Points,
    sweeps: Sweeps,
}

impl Ncp {
    /// For problems of this size.
    pub fn new(parameters: NcpParameters, p: &Problem) -> Self {
        Ncp { parameters, points: Points::new(p), sweeps: Sweeps::new(p) }
    }

    fn solve(&mut self, p: &Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        let tol = &input.rules.tolerances;
        self.points.gather(p, tol.velocity);
        self.sweeps.start(p, &self.points, Some(out));
        let error = self.sweeps.run(p, &self.points, self.parameters.iterations, self.parameters.tolerance);
        let impulses = self.sweeps.impulses();
        self.points.write_solution(p, impulses, out);
        let states = self.points.states(p, out, |c| {
            let (mu, impulse) = (self.points.list()[c].mu, &impulses[c]);
            let saturated = impulse.xy().norm() >= (1.0 - SATURATED) * mu * impulse.z;
            saturated && self.points.velocity(c, &out.motion).xy().norm() > tol.rest
        });
        // The method claims no validity, so it is never inconsistent: its errors show in the
        // residuals.
        let levels = if error > self.parameters.tolerance { [0.0, error / tol.velocity, 0.0] } else { [0.0; 3] };
        Selection {
            states,
            tested: 1,
            full: false,
            consistent: true,
            exhausted: true,
            assessment: Assessment { levels, ..Assessment::default() },
        }
    }
}

impl ContactSolver for Ncp {
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        Some(Box::new(self.clone()))
    }

    fn scheme(&self) -> Scheme {
        Scheme::TimeStepping
    }

    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        self.solve(p, input, out)
    }

    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        self.solve(p, input, out)
    }

    fn respond(&mut self, _: &Problem, _: &States, _: &mut Solution) {}
}

/// Responses of one point and its sole to an impulse at the point.
#[derive(Clone, Copy, Debug, Default)]
struct Own {
    /// D_nn and D_tt, and their inverses.
    normal: f64,
    tangential: f64,
    inverse: [f64; 2],
    /// Tangential velocity of the point for a normal impulse.
    drift: Vector2<f64>,
    /// Motion of the sole for impulses along x, y and z.
    motion: [[f64; 6]; 3],
}

/// The relaxation and its scratch.
#[derive(Clone, Debug)]
pub(super) struct Sweeps {
    impulses: Vec<Vector3<f64>>,
    own: Vec<Own>,
    /// Points in the order of visits, sole by sole.
    order: Vec<usize>,
    motion: Vec<f64>,
    count: usize,
}

impl Sweeps {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        let most = p.soles.iter().map(|s| s.vertices.len()).sum();
        Sweeps {
            impulses: vec![Vector3::zeros(); most],
            own: vec![Own::default(); most],
            order: Vec::with_capacity(most),
            motion: vec![0.0; p.dim()],
            count: 0,
        }
    }

    /// Starts from the vertex forces of `last` over the problem's step, or from zero.
    pub fn start(&mut self, p: &Problem, points: &Points, last: Option<&Solution>) {
        self.count = points.list().len();
        self.motion.copy_from_slice(&p.b);
        self.order.clear();
        for of_sole in points.list().chunk_by(|a, b| a.sole == b.sole) {
            let (from, count) = (self.order.len(), of_sole.len());
            let stride = stride(count);
            self.order.extend((0..count).map(|i| from + i * stride % count));
        }
        for (c, point) in points.list().iter().enumerate() {
            let block = points.block(c, c);
            let (mean, half) = (0.5 * (block[(0, 0)] + block[(1, 1)]), 0.5 * (block[(0, 0)] - block[(1, 1)]));
            let (normal, tangential) = (block[(2, 2)], mean + (half * half + block[(0, 1)] * block[(0, 1)]).sqrt());
            self.own[c] = Own {
                normal,
                tangential,
                inverse: [1.0 / normal, 1.0 / tangential],
                drift: Vector2::new(block[(0, 2)], block[(1, 2)]),
                motion: std::array::from_fn(|axis| {
                    let column = &points.column(c, axis)[6 * point.sole..];
                    std::array::from_fn(|i| column[i])
                }),
            };
            self.impulses[c] = last.map_or(Vector3::zeros(), |last| {
                let normal = last.normal[point.sole][point.vertex].max(0.0) * p.step;
                let tangent = last.tangent[point.sole][point.vertex] * p.step;
                let tangent = tangent.cap_magnitude(point.mu * normal);
                Vector3::new(tangent.x, tangent.y, normal)
            });
            points.add_response(c, &self.impulses[c], &mut self.motion);
        }
    }

    /// Sweeps until the error is within `tolerance` (m/s), at most `iterations` times. Returns the
    /// error of the last sweep.
    pub fn run(&mut self, p: &Problem, points: &Points, iterations: u32, tolerance: f64) -> f64 {
        let mut error = 0.0;
        for _ in 0..iterations {
            error = self.sweep(p, points);
            if error <= tolerance {
                break;
            }
        }
        error
    }

    /// The present impulses, by point.
    pub fn impulses(&self) -> &[Vector3<f64>] {
        &self.impulses[..self.count]
    }

    fn sweep(&mut self, p: &Problem, points: &Points) -> f64 {
        let mut greatest: f64 = 0.0;
        let mut from = 0;
        for of_sole in points.list().chunk_by(|a, b| a.sole == b.sole) {
            let (s, to) = (of_sole[0].sole, from + of_sole.len());
            let mut motion: [f64; 6] = std::array::from_fn(|i| self.motion[6 * s + i]);
            let mut wrench = [0.0; 6];
            for &c in &self.order[from..to] {
                let point = &points.list()[c];
                let (change, square) = self.own[c].relax(point, &mut motion, &mut self.impulses[c]);
                greatest = greatest.max(square);
                wrench.iter_mut().zip(wrench_at(&point.r, &change)).for_each(|(sum, x)| *sum += x);
            }
            self.transmit(p, s, &wrench);
            self.motion[6 * s..6 * s + 6].copy_from_slice(&motion);
            from = to;
        }
        greatest.sqrt()
    }

    /// Adds the response of the motions of the other soles to a wrench on sole `s`.
    fn transmit(&mut self, p: &Problem, s: usize, wrench: &[f64; 6]) {
        let dim = p.dim();
        for (t, motion) in self.motion.as_chunks_mut::<6>().0.iter_mut().enumerate().filter(|(t, _)| *t != s) {
            let mut change = [0.0; 6];
            for (k, x) in wrench.iter().enumerate() {
                // W is symmetric: its rows are its columns.
                let column = &p.w[(6 * s + k) * dim + 6 * t..][..6];
                change.iter_mut().zip(column).for_each(|(sum, w)| *sum += w * x);
            }
            motion.iter_mut().zip(change).for_each(|(m, change)| *m += change);
        }
    }
}

/// Greatest stride up to n / 2 that reaches all of `n` points around a sole.
fn stride(n: usize) -> usize {
    let divisor = |a: usize, b: usize| (1..=a).rev().find(|d| a.is_multiple_of(*d) && b.is_multiple_of(*d));
    (1..=n / 2).rev().find(|s| divisor(*s, n) == Some(1)).unwrap_or(1)
}

/// Factor that shortens a vector of this squared length to `limit`. Out of line: computed for every
/// point, root and quotient would delay those that stick.
#[cold]
#[inline(never)]
fn ratio(limit: f64, square: f64) -> f64 {
    limit / square.sqrt()
}

impl Own {
    /// Relaxes the impulse of a point whose sole moves with `motion`. Returns its change and the
    /// square of the change as a velocity, m^2/s^2.
    fn relax(&self, point: &Point, motion: &mut [f64; 6], impulse: &mut Vector3<f64>) -> (Vector3<f64>, f64) {
        if !(self.normal > 0.0) {
            return (Vector3::zeros(), 0.0);
        }
        let v = point.velocity(motion);
        let (before, [normal, tangential]) = (*impulse, self.inverse);
        impulse.z = (before.z - (v.z - point.target) * normal).max(0.0);
        let rise = impulse.z - before.z;
        if self.tangential > 0.0 {
            let mut t = before.xy() - (v.xy() + self.drift * rise) * tangential;
            let (limit, square) = (point.mu * impulse.z, t.norm_squared());
            if square > limit * limit {
                t *= ratio(limit, square);
            }
            (impulse.x, impulse.y) = (t.x, t.y);
        }
        let change = *impulse - before;
        let [x, y, z] = &self.motion;
        for (i, m) in motion.iter_mut().enumerate() {
            *m += z[i] * change.z + (x[i] * change.x + y[i] * change.y);
        }
        let (rise, slip) = (rise * self.normal, change.xy() * self.tangential);
        (change, (rise * rise).max(slip.norm_squared()))
    }
}
