//! Splits the wrenches of static soles over their vertices.
//!
//! Within a static pattern only the resultant is physical. The normal forces of a face follow the pressure rule
//! ([`pressure`]); tangential forces are proportional to the normal ones times a common translation and
//! rotation field.

use crate::contact::model::pressure;
use crate::contact::model::problem::{Problem, SoleProblem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, States};
use nalgebra::{Vector2, Vector3};

/// Horizontal unit vector across an edge; any one where its ends coincide, as two corners of a patch may that meet.
pub(super) fn across(sole: &SoleProblem, i: usize, j: usize) -> Vector3<f64> {
    let d = sole.vertices[j].r - sole.vertices[i].r;
    let n = Vector2::new(-d.y, d.x).try_normalize(0.0).unwrap_or(Vector2::y());
    Vector3::new(n.x, n.y, 0.0)
}

/// Splits the wrenches of static soles over their vertices; clears the entries of free soles.
pub fn share_static(p: &Problem, states: &States, out: &mut Solution) {
    for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| !states[*s].is_dynamic()) {
        let k = sole.vertices.len();
        out.normal[s].fill(0.0);
        out.tangent[s].fill(Vector2::zeros());
        let w: &[f64] = &out.wrench[6 * s..6 * s + 6];
        let t = Vector2::new(w[0], w[1]);
        match states[s].pattern {
            Pattern::Free => {}
            Pattern::Vertex(i) => {
                out.normal[s][i as usize] = w[2];
                out.tangent[s][i as usize] = t;
            }
            Pattern::Edge(i) => {
                let (i, j) = (i as usize, (i as usize + 1) % k);
                let (normal, side, along, along_unit) = edge_load(sole, i, j, w);
                let across = across(sole, i, j).xy();
                let sum = normal[0] + normal[1];
                for (v, c) in [(i, 0), (j, 1)] {
                    let part = if sum != 0.0 { normal[c] / sum } else { 0.5 };
                    out.normal[s][v] = normal[c];
                    out.tangent[s][v] = across * side[c] + along_unit * (along * part);
                }
            }
            Pattern::Face => {
                let inside = pressure::share(sole, w[2], [w[3], w[4]], &mut out.normal[s]);
                out.inside.set(s, inside);
                share_tangent(sole, t, w[5], &out.normal[s], &mut out.tangent[s]);
            }
        }
    }
}

/// Load of a static edge: normal forces of its two ends, tangential forces across it at the two
/// ends, the sum along it and the horizontal unit vector along it. Where its ends coincide the first carries all.
pub fn edge_load(sole: &SoleProblem, i: usize, j: usize, w: &[f64]) -> ([f64; 2], [f64; 2], f64, Vector2<f64>) {
    let (ri, rj) = (&sole.vertices[i].r, &sole.vertices[j].r);
    let d = (rj - ri).xy();
    let Some(along) = d.try_normalize(0.0) else { return ([w[2], 0.0], [w[1], 0.0], w[0], Vector2::x()) };
    let length = d.norm();
    let across = Vector2::new(-along.y, along.x);
    let f = Vector3::new(w[0], w[1], w[2]);
    // Moment about vertex i; only forces at j contribute: (r_j - r_i) x f_j.
    let m = Vector3::new(w[3], w[4], w[5]) - ri.cross(&f);
    // With f_j = s across + n z and e x z = -across: m . across = -length n, m . z = length s.
    let side_j = m.z / length;
    let normal_j = -m.xy().dot(&across) / length;
    ([f.z - normal_j, normal_j], [f.xy().dot(&across) - side_j, side_j], f.xy().dot(&along), along)
}

/// Tangential forces proportional to the normal ones times a common translation and rotation field
/// that carry (t, yaw).
pub fn share_tangent(sole: &SoleProblem, t: Vector2<f64>, yaw: f64, normal: &[f64], out: &mut [Vector2<f64>]) {
    let sum: f64 = normal.iter().sum();
    if sum <= 0.0 {
        return;
    }
    let centre: Vector2<f64> = normal.iter().zip(&sole.vertices).map(|(n, v)| v.r.xy() * (n / sum)).sum();
    let spread: f64 = normal.iter().zip(&sole.vertices).map(|(n, v)| n * (v.r.xy() - centre).norm_squared()).sum();
    let about_centre = yaw - centre.perp(&t);
    let turn = if spread > 0.0 { about_centre / spread } else { 0.0 };
    for ((n, v), out) in normal.iter().zip(&sole.vertices).zip(out) {
        let d = v.r.xy() - centre;
        *out = t * (n / sum) + Vector2::new(-d.y, d.x) * (turn * n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::state::SoleState;
    use crate::contact::search::candidate::CandidateSolver;

    /// Two corners of a patch may meet in a point. An edge between them holds what a vertex there holds.
    #[test]
    fn an_edge_whose_ends_coincide_is_a_vertex() {
        let mut p = Problem::new(&[3]);
        for (v, r) in p.soles[0].vertices.iter_mut().zip([[0.1, 0.05], [0.1, 0.05], [-0.1, 0.02]]) {
            v.r = Vector3::new(r[0], r[1], -0.03);
        }
        (0..6).for_each(|k| p.w[7 * k] = [2.0, 2.0, 2.0, 9.0, 8.0, 7.0][k]);
        p.b.copy_from_slice(&[0.4, -0.3, -9.81, 1.0, -2.0, 0.5]);
        let solved = |pattern: Pattern| {
            let (mut states, mut out) = (States::default(), Solution::new(&p));
            states[0] = SoleState::fixed(pattern);
            CandidateSolver::new(&p).solve(&p, &states, &mut out);
            share_static(&p, &states, &mut out);
            out
        };
        let (edge, vertex) = (solved(Pattern::Edge(0)), solved(Pattern::Vertex(0)));
        let sum = |s: &Solution| Vector3::new(s.tangent[0][0].x, s.tangent[0][0].y, s.normal[0][0]);
        // Rounding of forces of some 5 N.
        assert!((sum(&edge) - sum(&vertex)).norm() < 1e-12, "{edge:?} {vertex:?}");
        assert_eq!((edge.normal[0][1], edge.tangent[0][1]), (0.0, Vector2::zeros()));
        let apart = edge.wrench.iter().zip(&vertex.wrench).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-12, "{edge:?} {vertex:?}");
    }
}
