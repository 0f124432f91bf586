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
//! tangential response, which makes both steps descents. The first is exact for its point. The
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
use crate::contact::methods::points::Points;
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::search::judge::Assessment;
use crate::contact::search::select::Selection;
use crate::text::quantity::{count, json, positive};
use nalgebra::Vector3;
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
        let error = self.sweeps.run(&self.points, self.parameters.iterations, self.parameters.tolerance);
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
            assessment: Assessment { levels, ..Assessment::default() },
        }
    }
}

impl ContactSolver for Ncp {
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

/// The relaxation and its scratch.
#[derive(Clone, Debug)]
pub(super) struct Sweeps {
    impulses: Vec<Vector3<f64>>,
    /// D_nn and D_tt of each point.
    own: Vec<[f64; 2]>,
    motion: Vec<f64>,
    count: usize,
}

impl Sweeps {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        let most = p.soles.iter().map(|s| s.vertices.len()).sum();
        Sweeps {
            impulses: vec![Vector3::zeros(); most],
            own: vec![[0.0; 2]; most],
            motion: vec![0.0; p.dim()],
            count: 0,
        }
    }

    /// Starts from the vertex forces of `last` over the problem's step, or from zero.
    pub fn start(&mut self, p: &Problem, points: &Points, last: Option<&Solution>) {
        self.count = points.list().len();
        self.motion.copy_from_slice(&p.b);
        for (c, point) in points.list().iter().enumerate() {
            let block = points.block(c, c);
            let (mean, half) = (0.5 * (block[(0, 0)] + block[(1, 1)]), 0.5 * (block[(0, 0)] - block[(1, 1)]));
            self.own[c] = [block[(2, 2)], mean + half.hypot(block[(0, 1)])];
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
    pub fn run(&mut self, points: &Points, iterations: u32, tolerance: f64) -> f64 {
        let mut error = 0.0;
        for _ in 0..iterations {
            error = self.sweep(points);
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

    fn sweep(&mut self, points: &Points) -> f64 {
        let mut error: f64 = 0.0;
        for (c, point) in points.list().iter().enumerate() {
            let [normal, tangential] = self.own[c];
            if !(normal > 0.0) {
                continue;
            }
            let p = self.impulses[c];
            let mut next = p;
            next.z = (p.z - (points.velocity(c, &self.motion).z - point.target) / normal).max(0.0);
            points.add_response(c, &Vector3::new(0.0, 0.0, next.z - p.z), &mut self.motion);
            if tangential > 0.0 {
                let free = p.xy() - points.velocity(c, &self.motion).xy() / tangential;
                let t = free.cap_magnitude(point.mu * next.z);
                (next.x, next.y) = (t.x, t.y);
            }
            let change = next - p;
            points.add_response(c, &Vector3::new(change.x, change.y, 0.0), &mut self.motion);
            error = error.max(change.z.abs() * normal).max(change.xy().norm() * tangential);
            self.impulses[c] = next;
        }
        error
    }
}
