//! Vertices of the patches of pairs in the contact problem, with the relative motion of the bodies.

use crate::contact::model::problem::SoleProblem;
use crate::dynamics::reduced::Reduced;
use crate::sim::bodies::PairPatch;
use nalgebra::Vector3;

/// Sets the vertices of polygon `s`, the patch of a pair. Vertices slower than `rest`, m/s, count as at rest.
pub(super) fn set_vertices(patch: &PairPatch, reduced: &Reduced, s: usize, rest: f64, sole: &mut SoleProblem) {
    let (axes, reference) = (&reduced.axes[s], &reduced.reference[s]);
    sole.position = axes.tr_mul(reference);
    let m = &reduced.velocity[6 * s..6 * s + 6];
    let (linear, omega) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
    for (i, v) in sole.vertices.iter_mut().enumerate() {
        let point = patch.point(i);
        v.r = axes.tr_mul(&(point.position - reference));
        (v.height, v.velocity) = (point.gap, linear + omega.cross(&v.r));
        v.bias = axes.tr_mul(&point.bias);
        v.moving = v.velocity.xy().norm_squared() > rest * rest;
        v.near = false;
    }
}
