//! Residuals of the contact laws, computed from the problem and the solution by nobody who solved it
//! (`contact.md` section 12).

use super::candidate::Solution;
use super::judge::margin;
use super::problem::Problem;
use super::state::States;

/// What the contact laws miss at one instant.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Residual {
    /// Deepest vertex below the floor, m.
    pub penetration: f64,
    /// Height of the lowest vertex of all, m; infinite without soles.
    pub lift: f64,
    /// Greatest tension the floor exerts, N.
    pub tension: f64,
    /// Greatest tangential load beyond the friction capacity, N: of a sliding or pivoting vertex against its own cone,
    /// of a static pattern against the exact capacity of the pattern.
    pub cone_excess: f64,
    /// Greatest tangential speed of a vertex that is said to stick, m/s.
    pub creep_speed: f64,
    /// Greatest `mu_k N |v| + t . v` of a sliding vertex, W: what maximum dissipation lacks.
    pub dissipation_gap: f64,
    /// Greatest product of normal force and gap, N m.
    pub signorini: f64,
}

/// Evaluates the residuals; `solution` must hold the per-vertex forces.
pub fn evaluate(p: &Problem, states: &States, solution: &Solution) -> Residual {
    let mut r = Residual { lift: f64::INFINITY, ..Residual::default() };
    for (s, sole) in p.soles.iter().enumerate() {
        let state = states[s];
        let k = sole.vertices.len();
        for (i, v) in sole.vertices.iter().enumerate() {
            let (n, t) = (solution.normal[s][i], solution.tangent[s][i]);
            r.penetration = r.penetration.max(-v.height);
            r.lift = r.lift.min(v.height);
            r.tension = r.tension.max(-n);
            r.signorini = r.signorini.max(n.abs() * v.height.abs());
            if !state.clamps(i, k) {
                continue;
            }
            let slip = v.velocity.xy();
            if state.is_static() {
                r.creep_speed = r.creep_speed.max(slip.norm());
            } else {
                r.cone_excess = r.cone_excess.max(t.norm() - v.mu_s.max(v.mu_k) * n.max(0.0));
                r.dissipation_gap = r.dissipation_gap.max((v.mu_k * n * slip.norm() + t.dot(&slip)).abs());
            }
        }
        if state.is_static() {
            r.cone_excess = r.cone_excess.max(-margin(p, s, state, solution).friction * p.scale);
        }
    }
    r
}
