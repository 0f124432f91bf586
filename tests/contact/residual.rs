//! Residuals of solutions built by hand: zero for exact ones, and one residual per kind of error.

use nalgebra::{Vector2, Vector3};
use stiction::contact::model::problem::Problem;
use stiction::contact::model::residual::{Residual, evaluate};
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::{Mode, Pattern, SoleState, States};

const MU_S: f64 = 0.5;
const MU_K: f64 = 0.4;
/// Half lengths of the sole, m.
const HALF: [f64; 2] = [0.06, 0.03];

/// A rectangular sole on the floor, each vertex pressed down with its normal force; tangential
/// forces at the vertices.
struct Case {
    p: Problem,
    states: States,
    solution: Solution,
}

impl Case {
    fn new(state: SoleState, normal: [f64; 4], tangent: [[f64; 2]; 4]) -> Self {
        let mut p = Problem::new(&[4]);
        p.soles[0].radius = HALF[0].hypot(HALF[1]);
        for (v, [x, y]) in p.soles[0].vertices.iter_mut().zip([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) {
            v.r = Vector3::new(x * HALF[0], y * HALF[1], 0.0);
            (v.mu_s, v.mu_k) = (MU_S, MU_K);
        }
        let mut solution = Solution::new(&p);
        solution.normal[0].copy_from_slice(&normal);
        solution.tangent[0].iter_mut().zip(tangent).for_each(|(t, value)| *t = value.into());
        let mut states = States::default();
        states[0] = state;
        let mut case = Case { p, states, solution };
        case.sum_up();
        case
    }

    /// Sets the wrench to the sum of the vertex forces.
    fn sum_up(&mut self) {
        self.solution.wrench.fill(0.0);
        for (i, v) in self.p.soles[0].vertices.iter().enumerate() {
            let t = self.solution.tangent[0][i];
            let f = Vector3::new(t.x, t.y, self.solution.normal[0][i]);
            let m = v.r.cross(&f);
            for (w, x) in self.solution.wrench.iter_mut().zip([f.x, f.y, f.z, m.x, m.y, m.z]) {
                *w += x;
            }
        }
    }

    /// Every vertex slides with this velocity against full kinetic friction.
    fn sliding(velocity: [f64; 2]) -> Self {
        let v = Vector2::from(velocity);
        let normal = [10.0, 8.0, 6.0, 4.0];
        let mut case = Case::new(SoleState::sliding(Pattern::Face), normal, [[0.0; 2]; 4]);
        for (i, n) in normal.iter().enumerate() {
            case.p.soles[0].vertices[i].velocity = Vector3::new(v.x, v.y, 0.0);
            case.solution.tangent[0][i] = -v.normalize() * (MU_K * n);
        }
        case.sum_up();
        case
    }

    fn sticking() -> Self {
        Case::new(
            SoleState::fixed(Pattern::Face),
            [10.0, 8.0, 6.0, 4.0],
            [[2.0, 1.0], [1.0, 1.0], [0.5, 0.0], [0.0, -1.0]],
        )
    }

    fn residual(&self) -> Residual {
        evaluate(&self.p, &self.states, &self.solution)
    }

    fn vertex(&mut self, i: usize) -> &mut stiction::contact::model::problem::Vertex {
        &mut self.p.soles[0].vertices[i]
    }
}

/// Checks that named residuals have these values and all others are zero to rounding.
#[track_caller]
fn only(r: &Residual, expected: &[(&str, f64)]) {
    let names =
        ["penetration", "tension", "signorini", "cone_excess", "dissipation_gap", "creep_speed", "resultant_gap"];
    for (name, value) in names.into_iter().zip(r.values()) {
        let target = expected.iter().find(|e| e.0 == name).map_or(0.0, |e| e.1);
        // Rounding of forces of some 10 N.
        assert!((value - target).abs() < 1e-13, "{name} is {value}, not {target}: {r:?}");
    }
}

#[test]
fn an_exact_solution_has_zero_residuals() {
    only(&Case::sticking().residual(), &[]);
    for k in 0..12 {
        let (s, c) = (0.1 + 0.55 * k as f64).sin_cos();
        only(&Case::sliding([2.0 * c, 2.0 * s]).residual(), &[]);
    }
    // Forces along an edge may be shared unequally as long as both ends together carry them.
    let edge = SoleState::fixed(Pattern::Edge(0));
    only(&Case::new(edge, [10.0, 4.0, 0.0, 0.0], [[3.0, 4.0 - 1e-9], [-2.5, 0.0], [0.0; 2], [0.0; 2]]).residual(), &[]);
    // Edge 0 runs along x. The 4 N across it take 3 N of the 5 N that vertex 0 carries; vertex 1
    // carries 2 N along.
    let shifted = Case::new(edge, [10.0, 4.0, 0.0, 0.0], [[5.0 - 1e-9, 4.0], [0.0; 2], [0.0; 2], [0.0; 2]]);
    only(&shifted.residual(), &[]);
}

#[test]
fn penetration_tension_and_force_across_a_gap_are_measured() {
    let mut case = Case::sticking();
    case.vertex(3).height = -2e-3;
    only(&case.residual(), &[("penetration", 2e-3), ("signorini", 4.0 * 2e-3)]);

    let mut case = Case::sticking();
    case.vertex(0).height = 1e-3;
    only(&case.residual(), &[("signorini", 10.0 * 1e-3)]);

    // A pulled vertex; the other three hold the load.
    let mut case = Case::sticking();
    case.solution.normal[0][3] = -0.25;
    case.solution.tangent[0].fill(Vector2::zeros());
    case.sum_up();
    only(&case.residual(), &[("tension", 0.25)]);
}

#[test]
fn loads_beyond_the_friction_cone_are_measured() {
    // A static face: all of mu_s N is 14 N.
    let mut case = Case::sticking();
    for (i, n) in [10.0, 8.0, 6.0, 4.0].into_iter().enumerate() {
        case.solution.tangent[0][i] = Vector2::new(0.6, -0.8) * (n * MU_S * 15.0 / 14.0);
    }
    case.sum_up();
    only(&case.residual(), &[("cone_excess", 1.0)]);
    // A pure twist about the centre of four equal loads: mu_s N r at each vertex.
    let mut case = Case::new(SoleState::fixed(Pattern::Face), [5.0; 4], [[0.0; 2]; 4]);
    let radius = case.p.soles[0].radius;
    for i in 0..4 {
        let r = case.p.soles[0].vertices[i].r;
        case.solution.tangent[0][i] = Vector2::new(-r.y, r.x) / radius * (5.0 * MU_S + 0.1);
    }
    case.sum_up();
    only(&case.residual(), &[("cone_excess", 0.4)]);
    // A static vertex.
    let vertex = SoleState::fixed(Pattern::Vertex(2));
    let case = Case::new(vertex, [0.0, 0.0, 10.0, 0.0], [[0.0; 2], [0.0; 2], [3.0, 4.5], [0.0; 2]]);
    only(&case.residual(), &[("cone_excess", 3f64.hypot(4.5) - 5.0)]);
    // A static edge with one end that cannot carry the force across it.
    let edge = SoleState::fixed(Pattern::Edge(0));
    let case = Case::new(edge, [10.0, 4.0, 0.0, 0.0], [[0.0; 2], [0.0, 2.5], [0.0; 2], [0.0; 2]]);
    only(&case.residual(), &[("cone_excess", 0.5)]);
    // An unclamped vertex with friction.
    let case = Case::new(SoleState::FREE, [0.0; 4], [[0.0, 0.3], [0.0; 2], [0.0; 2], [0.0; 2]]);
    only(&case.residual(), &[("cone_excess", 0.3)]);
    // The resting pivot of a sole that rotates about it.
    let mut case = Case::new(
        SoleState { pattern: Pattern::Edge(0), mode: Mode::Pivoting(1) },
        [0.0, 10.0, 0.0, 0.0],
        [[0.0; 2]; 4],
    );
    case.solution.tangent[0][1] = Vector2::new(0.0, -5.5);
    case.sum_up();
    only(&case.residual(), &[("cone_excess", 0.5)]);
}

#[test]
fn friction_of_wrong_size_or_direction_is_measured() {
    let speed = 2.0;
    // Too strong by 10 %: beyond the cone as well.
    let mut case = Case::sliding([speed, 0.0]);
    case.solution.tangent[0][1] *= 1.1;
    case.sum_up();
    only(&case.residual(), &[("cone_excess", 0.1 * MU_K * 8.0), ("dissipation_gap", 0.1 * MU_K * 8.0 * speed)]);
    // Too weak.
    let mut case = Case::sliding([speed, 0.0]);
    case.solution.tangent[0][1] *= 0.5;
    case.sum_up();
    only(&case.residual(), &[("dissipation_gap", 0.5 * MU_K * 8.0 * speed)]);
    // Of the right size, rotated by 0.3 rad.
    let mut case = Case::sliding([speed, 0.0]);
    let (s, c) = 0.3f64.sin_cos();
    case.solution.tangent[0][0] = -Vector2::new(c, s) * (MU_K * 10.0);
    case.sum_up();
    only(&case.residual(), &[("dissipation_gap", MU_K * 10.0 * speed * (1.0 - c))]);
}

#[test]
fn creep_of_static_vertices_and_wrong_sums_of_forces_are_measured() {
    let mut case = Case::sticking();
    case.vertex(1).velocity = Vector3::new(3e-9, -4e-9, 1e-3);
    only(&case.residual(), &[("creep_speed", 5e-9)]);

    let mut case = Case::sticking();
    case.solution.wrench[1] += 0.01;
    only(&case.residual(), &[("resultant_gap", 0.01)]);
    let mut case = Case::sticking();
    case.solution.wrench[5] += 0.001;
    let radius = case.p.soles[0].radius;
    only(&case.residual(), &[("resultant_gap", 0.001 / radius)]);
}
