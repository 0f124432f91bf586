//! Residuals of the contact laws (Signorini, Coulomb, complementarity), computed independently of
//! every solver.
//!
//! Inputs are forces, motions and positions only (`docs/contact.md`, section 12).
//!
//! | residual | expression, zero for an exact solution |
//! |---|---|
//! | Signorini | `max(0, -N)`, `max(0, -gap)`, `|N gap|` of every vertex |
//! | cone excess | `max(0, |t| - mu N)` of every vertex; of a static edge or face its resultant against what its N can carry |
//! | dissipation gap | `|mu_k N |v| + t . v|` of every sliding vertex: friction dissipates maximally |
//! | creep speed | `|v|` of every static vertex, and of a pivot |
//! | the last three of torsional and rolling friction | `max(0, |tau| / mu - N)`, `|mu N |omega| + tau . omega|`, `mu |omega|` |
//! | resultant gap | sum of the vertex forces minus the sole's wrench |
//!
//! with N and t the normal and tangential force, v the sliding velocity, gap the height of a
//! vertex. The tangential load of a static edge or face is split by a convention, so the resultant
//! is tested against the exact capacity of [`crate::contact::model::friction_capacity`]. The
//! solver's assessment is not used.

use crate::contact::model::friction_capacity;
use crate::contact::model::problem::{Level, Problem, SoleProblem, Vertex};
use crate::contact::model::sole_group;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::model::turning;
use nalgebra::{Vector2, Vector3};

/// Violation of the contact laws at one instant, greatest over all vertices and soles.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Residual {
    /// Deepest vertex below the floor, m.
    pub penetration: f64,
    /// Tension the floor exerts on a vertex, N.
    pub tension: f64,
    /// Tangential load beyond the friction capacity, N.
    pub cone_excess: f64,
    /// Tangential speed of a static vertex, m/s.
    pub creep_speed: f64,
    /// Deviation of the friction power from maximum dissipation, W.
    pub dissipation_gap: f64,
    /// Product of normal force and gap, N m.
    pub signorini: f64,
    /// Distance between the sum of a sole's vertex forces and its wrench, N (moments over the
    /// sole's radius).
    pub resultant_gap: f64,
}

/// Number of residuals in [`Residual::values`].
pub const RESIDUALS: usize = 7;

impl Residual {
    /// Penetration (m), tension (N), Signorini product (N m), cone excess (N), dissipation gap (W),
    /// creep speed (m/s), resultant gap (N).
    pub fn values(&self) -> [f64; RESIDUALS] {
        [
            self.penetration,
            self.tension,
            self.signorini,
            self.cone_excess,
            self.dissipation_gap,
            self.creep_speed,
            self.resultant_gap,
        ]
    }
}

/// Violation of the laws that limit loads, see [`Residual`].
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Loads {
    tension: f64,
    cone_excess: f64,
    resultant_gap: f64,
}

impl Loads {
    /// Greatest tension or load beyond its friction limit, N.
    pub fn excess(&self) -> f64 {
        self.tension.max(self.cone_excess)
    }
}

/// Loads of a velocity-level step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StepLoads {
    /// The loads.
    pub loads: Loads,
    /// Whether the step begins at the present state, whose velocities are those before it. Otherwise it ends
    /// there.
    pub begins: bool,
}

/// Evaluates the residuals. `solution` must hold wrenches and the forces of all vertices; of `p`
/// only positions, velocities and friction coefficients of the vertices are read.
pub fn evaluate(p: &Problem, states: &States, solution: &Solution) -> Residual {
    evaluate_motion(loads(p, states, solution), p, states, solution)
}

/// As [`evaluate`], with loads that were evaluated where the step began: a fixed step turns the
/// soles after its forces have been computed.
pub fn evaluate_motion(loads: Loads, p: &Problem, states: &States, solution: &Solution) -> Residual {
    let Loads { tension, cone_excess, resultant_gap } = loads;
    let mut r = Residual { tension, cone_excess, resultant_gap, ..Residual::default() };
    for (s, sole) in p.soles.iter().enumerate() {
        for (i, v) in sole.vertices.iter().enumerate() {
            r.motion(v, solution.normal[s][i], &solution.tangent[s][i], role(states[s], i, sole.vertices.len()));
        }
        if let Some([_, gap, speed]) = turning::residual(p, s, solution).filter(|_| states[s] != SoleState::FREE) {
            (r.dissipation_gap, r.creep_speed) = (r.dissipation_gap.max(gap), r.creep_speed.max(speed));
        }
    }
    r
}

/// Evaluates the residuals of the loads. Of `p` positions and friction coefficients are read.
pub fn loads(p: &Problem, states: &States, solution: &Solution) -> Loads {
    let mut r = Loads::default();
    for (s, sole) in p.soles.iter().enumerate() {
        let (normal, tangent) = (&solution.normal[s], &solution.tangent[s]);
        let wrench = &solution.wrench[6 * s..6 * s + 6];
        for (i, v) in sole.vertices.iter().enumerate() {
            r.vertex(p.level, v, (normal[i], &tangent[i]), role(states[s], i, sole.vertices.len()));
        }
        if sole_group::is_shared(p, states, s) {
            // The static soles of one body can only slip together.
            r.cone_excess = r.cone_excess.max(-sole_group::group_margin(p, states, s, solution).margin);
        } else if states[s].is_static() {
            r.cone_excess = r.cone_excess.max(-static_margin(p, s, states[s].pattern, (normal, tangent), wrench));
        }
        let carried = turning_moment(p, states, s, solution);
        r.resultant_gap = r.resultant_gap.max(resultant_gap(sole, (normal, tangent), wrench, &carried));
        if let Some([excess, ..]) = turning::residual(p, s, solution) {
            r.cone_excess = r.cone_excess.max(excess);
        }
    }
    r
}

/// State of a vertex in the solution.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    /// Not clamped.
    Unclamped,
    /// Part of a static pattern.
    Sticks,
    /// Sticks while the rest of its sole turns about it.
    Pivots,
    /// Slides.
    Slides,
}

fn role(state: SoleState, i: usize, k: usize) -> Role {
    match state.mode {
        _ if !state.clamps(i, k) => Role::Unclamped,
        Mode::Static => Role::Sticks,
        Mode::Pivoting(j) if i == j as usize => Role::Pivots,
        _ => Role::Slides,
    }
}

impl Loads {
    fn vertex(&mut self, level: Level, v: &Vertex, (n, t): (f64, &Vector2<f64>), role: Role) {
        self.tension = self.tension.max(-n);
        let mu = match role {
            // Its edge or face is tested.
            Role::Sticks => return,
            Role::Unclamped | Role::Pivots => v.stick_mu(level),
            Role::Slides => v.slip_mu(),
        };
        self.cone_excess = self.cone_excess.max(t.norm() - mu * n.max(0.0));
    }
}

impl Residual {
    fn motion(&mut self, v: &Vertex, n: f64, t: &Vector2<f64>, role: Role) {
        self.penetration = self.penetration.max(-v.height);
        self.signorini = self.signorini.max((n * v.height).abs());
        let slip = v.velocity.xy();
        match role {
            Role::Unclamped => {}
            Role::Sticks | Role::Pivots => self.creep_speed = self.creep_speed.max(slip.norm()),
            Role::Slides => {
                self.dissipation_gap = self.dissipation_gap.max((v.slip_mu() * n * slip.norm() + t.dot(&slip)).abs());
            }
        }
    }
}

/// Distance of the load of a static pattern from its friction limit, N, negative beyond it; zero if
/// an edge carries it or the vertex forces of a face show that the load is within it.
fn static_margin(
    p: &Problem,
    s: usize,
    pattern: Pattern,
    (normal, tangent): (&[f64], &[Vector2<f64>]),
    wrench: &[f64],
) -> f64 {
    /// Most vertices of most soles: less scratch to clear.
    const FEW: usize = 8;
    let (sole, level) = (&p.soles[s], p.level);
    let k = sole.vertices.len();
    let capacity = |i: usize| sole.vertices[i].stick_mu(level) * normal[i].max(0.0);
    match pattern {
        Pattern::Free => 0.0,
        Pattern::Vertex(i) => friction_capacity::vertex(capacity(i as usize), &tangent[i as usize]),
        Pattern::Edge(i) => {
            let (i, j) = (i as usize, (i as usize + 1) % k);
            let edge = (sole.vertices[j].r - sole.vertices[i].r).xy();
            let along = edge.try_normalize(0.0).unwrap_or(Vector2::x());
            let across = Vector2::new(-along.y, along.x);
            let side = [tangent[i].dot(&across), tangent[j].dot(&across)];
            -friction_capacity::edge_excess([capacity(i), capacity(j)], side, (tangent[i] + tangent[j]).dot(&along))
        }
        Pattern::Face if k <= FEW => face_margin::<FEW>(sole, level, (normal, tangent), wrench),
        Pattern::Face => face_margin::<64>(sole, level, (normal, tangent), wrench),
    }
}

/// [`static_margin`] of a face of at most `MOST` vertices.
fn face_margin<const MOST: usize>(
    sole: &SoleProblem,
    level: Level,
    (normal, tangent): (&[f64], &[Vector2<f64>]),
    wrench: &[f64],
) -> f64 {
    let mut points = [(0.0, Vector2::zeros()); MOST];
    for (point, (v, n)) in points.iter_mut().zip(sole.vertices.iter().zip(normal)) {
        *point = (v.stick_mu(level) * n.max(0.0), v.r.xy());
    }
    // The wrench itself is tested: without normal load its split over the vertices need not exist. A
    // fixed step that turns the sole changes the moment of its logged vertex forces slightly.
    let (points, force) = (&points[..sole.vertices.len()], Vector2::new(wrench[0], wrench[1]));
    let mut balanced = [Vector2::zeros(); MOST];
    friction_capacity::balance(points, tangent, &force, wrench[5], &mut balanced);
    if friction_capacity::carries(points.iter().copied(), &balanced, &force, wrench[5], sole.radius) {
        return 0.0;
    }
    friction_capacity::face(points, &force, wrench[5], sole.radius).0
}

/// Moment of a point contact besides that of its force: of the components that have a limit.
fn turning_moment(p: &Problem, states: &States, s: usize, solution: &Solution) -> Vector3<f64> {
    let Some(turning) = p.soles[s].turning().filter(|_| states[s] != SoleState::FREE) else { return Vector3::zeros() };
    let has = |limit: f64| f64::from(u8::from(limit > 0.0));
    let (roll, spin) = (has(turning.rolling), has(turning.torsional));
    turning::moment(p, s, solution).component_mul(&Vector3::new(roll, roll, spin))
}

fn resultant_gap(
    sole: &SoleProblem,
    (normal, tangent): (&[f64], &[Vector2<f64>]),
    wrench: &[f64],
    carried: &Vector3<f64>,
) -> f64 {
    let mut force = -Vector3::new(wrench[0], wrench[1], wrench[2]);
    let mut moment = carried - Vector3::new(wrench[3], wrench[4], wrench[5]);
    for ((v, n), t) in sole.vertices.iter().zip(normal).zip(tangent) {
        let f = Vector3::new(t.x, t.y, *n);
        force += f;
        moment += v.r.cross(&f);
    }
    force.norm().max(moment.norm() / sole.radius)
}
