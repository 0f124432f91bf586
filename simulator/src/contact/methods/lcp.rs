//! Time stepping with a polyhedral friction cone: one linear complementarity problem a step.
//!
//! For the velocities at the end of a step, at every point c (a vertex that may meet the floor, see
//! [`crate::contact::methods::points`]), with directions `e_j = (cos, sin)(2 pi j / m)`,
//! j = 0 .. m - 1, the first along the floor's x axis:
//!
//! ```text
//! 0 <= N       _|_  v_n - target               >= 0        target = -gap / dt
//! 0 <= beta_j  _|_  e_j . v_t + lambda         >= 0        t = sum_j beta_j e_j
//! 0 <= lambda  _|_  mu N - sum_j beta_j        >= 0
//! ```
//!
//! N and t are impulses over the step, lambda is the sliding speed (the greatest of `-e_j . v_t`).
//! The velocities are affine in the impulses, so this is `w = M z + q` in (N, beta, lambda) of all
//! points. M is copositive, and [`Lemke`]'s algorithm solves it unless the constraints contradict
//! each other. Impulses are scaled to velocities by the greatest response of a point to its own
//! impulse, so that all entries are of order one.
//!
//! A robot that stands sticks, step after step. So the loaded vertices of the last step are first
//! tried as static patterns, by one linear solve ([`CandidateSolver`]): a solution with N >= 0,
//! friction inside the pyramid, v_t = 0 and lambda = 0. Lemke's algorithm runs where this is none.
//!
//! When Lemke ends on a ray, at its limit of pivots or with a solution that violates the
//! conditions, the selection counts as `inconsistent`, and the impulses come from the sweeps of
//! [`super::ncp`] on the round cone.
//!
//! Known flaw: friction dissipates most within a polygon, not a circle. A sticking point holds at
//! least mu N cos(pi / m), in the middle between two directions. A sliding point is slowed along
//! the direction most opposed to its motion, and veers until it moves in the middle between two
//! directions and is slowed by mu N cos(pi / m).
//!
//! Sources: [Stewart 1996], [Anitescu 1997].

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput};
use crate::contact::methods::ncp::Sweeps;
use crate::contact::methods::points::{Point, Points};
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, States};
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::judge::Assessment;
use crate::contact::search::select::Selection;
use crate::contact::search::static_loads::share_static;
use crate::linalg::lemke::{Lemke, LemkeOutcome};
use crate::math;
use nalgebra::{Vector2, Vector3};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

/// Tolerated violation of the conditions, relative to the greatest velocity.
const VIOLATION: f64 = 1e-9;

/// Tie tolerances of Lemke's ratio test, tried in turn. Of 40 000 impacts of one and two bodies the
/// first leaves 46 unsolved, the second none.
const TIES: [f64; 3] = [1e-12, 1e-10, 1e-8];

/// Sweeps and their tolerance, relative to the greatest velocity, where Lemke finds no solution.
const FALLBACK: (u32, f64) = (1000, 1e-9);

/// Descriptor for scenarios and reports.
pub const DESCRIPTOR: MethodDescriptor = MethodDescriptor {
    name: "lcp",
    doc: "Time stepping with a polyhedral friction cone: one linear complementarity problem per step.",
    only_semi_implicit: Some("knows only impulses over a fixed step"),
    restitution: false,
    unforced: Some("chooses no states"),
    momentless: Some("gives vertices forces alone"),
    colour: "#9C3587",
    is_configured: |parameters| parameters.lcp != LcpParameters::default(),
    unknowns: Some(|parameters, vertices| parameters.lcp.unknowns(vertices)),
    solver: |parameters, p| Box::new(Lcp::new(parameters.lcp, p)),
};

/// Parameters of method `lcp`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LcpParameters {
    /// Number of friction directions, the first along the floor's x axis: even, 4 to 64.
    #[serde(deserialize_with = "facets")]
    #[schemars(range(min = 4, max = 64), extend("multipleOf" = 2))]
    pub facets: u32,
}

fn facets<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let n = u32::deserialize(d)?;
    if n.is_multiple_of(2) && (4..=64).contains(&n) {
        return Ok(n);
    }
    Err(D::Error::custom(format!("must be an even number from 4 to 64, not {n}")))
}

impl Default for LcpParameters {
    fn default() -> Self {
        LcpParameters { facets: 8 }
    }
}

impl LcpParameters {
    /// Number of unknowns for `points` points.
    pub fn unknowns(self, points: usize) -> usize {
        points * (self.facets as usize + 2)
    }
}

/// Solver of the method.
#[derive(Clone)]
pub struct Lcp {
    directions: Vec<Vector2<f64>>,
    /// Unit normals of the pyramid's sides.
    sides: Vec<Vector2<f64>>,
    points: Points,
    sticking: CandidateSolver,
    lemke: Lemke,
    z: Vec<f64>,
    impulses: Vec<Vector3<f64>>,
    fallback: Sweeps,
}

impl Lcp {
    /// For problems of this size.
    pub fn new(parameters: LcpParameters, p: &Problem) -> Self {
        let most = p.soles.iter().map(|s| s.vertices.len()).sum();
        let unknowns = parameters.unknowns(most);
        let directions = directions(parameters.facets);
        let next = directions.iter().cycle().skip(1);
        Lcp {
            sides: directions.iter().zip(next).map(|(a, b)| (a + b).normalize()).collect(),
            directions,
            points: Points::new(p),
            sticking: CandidateSolver::new(p),
            lemke: Lemke::new(unknowns),
            z: vec![0.0; unknowns],
            impulses: vec![Vector3::zeros(); most],
            fallback: Sweeps::new(p),
        }
    }

    fn solve(&mut self, p: &Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        let tol = &input.rules.tolerances;
        self.points.gather(p, tol.velocity);
        let count = self.points.list().len();
        let n = count * (self.directions.len() + 2);
        let fastest = (0..count).map(|c| self.points.velocity(c, &p.b).norm()).fold(f64::MIN_POSITIVE, f64::max);
        let greatest = (0..count).map(|c| self.points.block(c, c).trace()).fold(0.0, f64::max);
        let unit = if greatest > 0.0 { 1.0 / greatest } else { 1.0 };
        let load = unit * fastest;
        let mut consistent = self.stick(p, out) && self.violation(out, load, fastest) <= VIOLATION * fastest;
        for tie in TIES {
            if consistent {
                break;
            }
            self.assemble(p, unit);
            let (end, _) = self.lemke.solve(&mut self.z[..n], tie);
            self.read_impulses(unit);
            self.points.write_solution(p, &self.impulses[..count], out);
            consistent = end == LemkeOutcome::Solved && self.violation(out, load, fastest) <= VIOLATION * fastest;
        }
        if !consistent {
            self.fallback.start(p, &self.points, None);
            self.fallback.run(p, &self.points, FALLBACK.0, FALLBACK.1 * fastest);
            self.impulses[..count].copy_from_slice(self.fallback.impulses());
            self.points.write_solution(p, &self.impulses[..count], out);
        }
        let states = self.points.states(p, out, |c| self.points.velocity(c, &out.motion).xy().norm() > tol.rest);
        let levels = if consistent { [0.0; 3] } else { [0.0, self.violation(out, load, fastest) / tol.velocity, 0.0] };
        Selection {
            states,
            tested: 1,
            full: false,
            exhausted: true,
            consistent,
            assessment: Assessment { levels, ..Assessment::default() },
        }
    }

    /// Solves for the vertices that carried load in the last step as static patterns. Returns whether
    /// all impulses are at points, push, and are inside the pyramid without any tolerance: a limit is
    /// met exactly.
    fn stick(&mut self, p: &Problem, out: &mut Solution) -> bool {
        let states = self.points.states(p, out, |_| false);
        self.sticking.solve(p, &states, out);
        for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| states[*s].pattern == Pattern::Face) {
            // The pressure rule takes moments about a point at the height of the vertices.
            let height = sole.vertices.iter().map(|v| v.r.z).sum::<f64>() / sole.vertices.len() as f64;
            let w = &mut out.wrench[6 * s..6 * s + 6];
            (w[3], w[4]) = (w[3] + height * w[1], w[4] - height * w[0]);
        }
        share_static(p, &states, out);
        let mut at_points = 0;
        for (impulse, point) in self.impulses.iter_mut().zip(self.points.list()) {
            let (normal, tangent) = (out.normal[point.sole][point.vertex], out.tangent[point.sole][point.vertex]);
            *impulse = Vector3::new(tangent.x, tangent.y, normal);
            at_points += usize::from(normal != 0.0);
        }
        let middle = self.middle();
        let loaded = out.normal.iter().flatten().filter(|n| **n != 0.0).count();
        let impulses = &self.impulses[..self.points.list().len()];
        let inside = |(point, impulse): (&Point, &Vector3<f64>)| {
            impulse.z >= 0.0 && self.farthest(impulse) <= point.mu * impulse.z * middle
        };
        let valid = loaded == at_points && self.points.list().iter().zip(impulses).all(inside);
        if valid {
            self.points.write_solution(p, impulses, out);
        }
        valid
    }

    /// Distance of the pyramid's sides from its axis, as part of mu N.
    fn middle(&self) -> f64 {
        math::cos(std::f64::consts::PI / self.directions.len() as f64)
    }

    /// Greatest tangential impulse across a side of the pyramid.
    fn farthest(&self, impulse: &Vector3<f64>) -> f64 {
        self.sides.iter().map(|side| side.dot(&impulse.xy())).fold(0.0, f64::max)
    }

    /// Fills M and q, with impulses in units of `unit`, so that N is a velocity.
    fn assemble(&mut self, p: &Problem, unit: f64) {
        let (points, e) = (&self.points, &self.directions);
        let (count, m) = (points.list().len(), e.len());
        let size = m + 2;
        self.lemke.begin(count * size);
        for (c, point) in points.list().iter().enumerate() {
            let first = c * size;
            for d in 0..count {
                let block = points.block(c, d) * unit;
                let normal = self.lemke.row(first);
                normal[d * size] = block[(2, 2)];
                for (x, e) in normal[d * size + 1..].iter_mut().zip(e) {
                    *x = block[(2, 0)] * e.x + block[(2, 1)] * e.y;
                }
                let tangential = block.fixed_view::<2, 2>(0, 0).into_owned();
                let lift = Vector2::new(block[(0, 2)], block[(1, 2)]);
                for (j, ej) in e.iter().enumerate() {
                    let along = tangential.tr_mul(ej);
                    let row = &mut self.lemke.row(first + 1 + j)[d * size..];
                    row[0] = ej.dot(&lift);
                    row[1..].iter_mut().zip(e).for_each(|(x, e)| *x = along.dot(e));
                }
            }
            for j in 0..m {
                self.lemke.row(first + 1 + j)[first + m + 1] = 1.0;
            }
            let cone = self.lemke.row(first + m + 1);
            cone[first] = point.mu;
            cone[first + 1..=first + m].fill(-1.0);
            let free = points.velocity(c, &p.b);
            self.lemke.set_constant(first, free.z - point.target);
            (0..m).for_each(|j| self.lemke.set_constant(first + 1 + j, e[j].dot(&free.xy())));
        }
    }

    /// Reads the impulses from the unknowns.
    fn read_impulses(&mut self, unit: f64) {
        let size = self.directions.len() + 2;
        for (c, impulse) in self.impulses[..self.points.list().len()].iter_mut().enumerate() {
            let z = &self.z[c * size..(c + 1) * size];
            let t: Vector2<f64> = self.directions.iter().zip(&z[1..]).map(|(e, beta)| e * *beta).sum();
            *impulse = Vector3::new(t.x, t.y, z[0]) * unit;
        }
    }

    /// Greatest violation of the normal and friction conditions, m/s: approach, separation under
    /// load, and sliding without full friction. Products are divided by the impulse `load`.
    /// Friction beyond the pyramid is converted to a velocity by `fastest / load`.
    fn violation(&self, out: &Solution, load: f64, fastest: f64) -> f64 {
        let middle = self.middle();
        let mut greatest: f64 = 0.0;
        for (c, (point, impulse)) in self.points.list().iter().zip(&self.impulses).enumerate() {
            let v = self.points.velocity(c, &out.motion);
            let gap = v.z - point.target;
            let speed = self.directions.iter().map(|e| -e.dot(&v.xy())).fold(0.0, f64::max);
            let opposed = point.mu * impulse.z * speed + impulse.xy().dot(&v.xy());
            let outside = self.farthest(impulse) - point.mu * impulse.z.max(0.0) * middle;
            greatest = greatest.max(-gap).max(gap.abs() * impulse.z / load).max(opposed.abs() / load);
            greatest = greatest.max(outside.max(-impulse.z) * fastest / load);
        }
        greatest
    }
}

/// The directions e_j.
fn directions(facets: u32) -> Vec<Vector2<f64>> {
    let angle = |j: u32| f64::from(j) * std::f64::consts::TAU / f64::from(facets);
    (0..facets).map(|j| Vector2::new(math::cos(angle(j)), math::sin(angle(j)))).collect()
}

impl ContactSolver for Lcp {
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
