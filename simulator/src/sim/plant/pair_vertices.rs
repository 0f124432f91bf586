//! Vertices of the patches of pairs in the contact problem, with the relative motion of the bodies.
//!
//! The bias accelerations c_i of a patch's vertices (points that move along both bodies, a plane that
//! turns, the links' origins as reference of `Jdot v`) contain a motion of the patch as a whole,
//!
//! ```text
//! c_i = c + tau x r_i + d_i        c = mean of c_i,   tau = (tau_x, tau_y, 0) the least-squares tilt of c_i . n
//! ```
//!
//! (c, tau) belongs to the motion a0 of the contact frame, so that conditions on a whole face have it too; d_i
//! stays with the vertices. Where a face slides over a plane that turns, `c . n = 2 (omega x n) . v`.

use super::{Plant, Polygon};
use crate::contact::hybrid::projection::fit_plane;
use crate::contact::model::problem::SoleProblem;
use crate::dynamics::jacobian::link_twist;
use crate::dynamics::reduced::{BodyId, Mechanisms, Reduced};
use crate::sim::bodies::PairPatch;
use nalgebra::Vector3;

/// Sets the vertices of polygon `s`, the patch of a pair. Vertices slower than `rest`, m/s, count as at
/// rest. Returns (c, tau), patch axes.
pub(super) fn set_vertices(
    patch: &PairPatch,
    reduced: &Reduced,
    s: usize,
    rest: f64,
    sole: &mut SoleProblem,
) -> [f64; 6] {
    let (axes, reference) = (&reduced.axes[s], &reduced.reference[s]);
    sole.position = axes.tr_mul(reference);
    let m = &reduced.velocity[6 * s..6 * s + 6];
    let (linear, omega) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
    let mut mean = Vector3::zeros();
    for (i, v) in sole.vertices.iter_mut().enumerate() {
        let point = patch.point(i);
        v.r = axes.tr_mul(&(point.position - reference));
        (v.height, v.velocity) = (point.gap, linear + omega.cross(&v.r));
        v.bias = axes.tr_mul(&point.bias);
        v.moving = v.velocity.xy().norm_squared() > rest * rest;
        v.near = false;
        v.leaves = patch.opens(i) && v.velocity.z > rest || patch.is_above_end(i);
        mean += v.bias;
    }
    let k = sole.vertices.len();
    mean /= k.max(1) as f64;
    let tilt = if k > 2 { fit_plane(sole, |i| sole.vertices[i].bias.z) } else { Vector3::zeros() };
    let turn = Vector3::new(tilt.y, tilt.z, 0.0);
    sole.vertices.iter_mut().for_each(|v| v.bias -= mean + turn.cross(&v.r));
    [mean.x, mean.y, mean.z, turn.x, turn.y, 0.0]
}

/// Greatest speed, m/s, of points of either body of a pair in reach of its patch, from `reference` on, world.
pub fn fastest_side(patch: &PairPatch, mechanisms: Mechanisms, reference: &Vector3<f64>) -> f64 {
    let (a, b) = patch.parts[0].pair.links;
    let speed = |body: BodyId| {
        let twist = link_twist(mechanisms.get(body.mechanism), body.link, reference);
        twist.linear.norm() + twist.angular.norm() * patch.radius()
    };
    b.into_iter().map(speed).fold(speed(a), f64::max)
}

impl Plant {
    /// The patches of pairs of bodies, in the order of their polygons.
    pub fn pair_patches(&self) -> impl Iterator<Item = &PairPatch> {
        self.polygons.iter().filter_map(Polygon::pair)
    }

    /// Adds the motion of each patch that the biases of its vertices contain to that of its frame.
    pub(super) fn add_pair_bias(&mut self) {
        for (s, _) in self.polygons.iter().enumerate().filter(|(_, polygon)| polygon.pair().is_some()) {
            for (r, c) in self.pair_bias[s].iter().enumerate() {
                self.reduced.a0[6 * s + r] += c;
                self.problem.b[6 * s + r] += c;
            }
        }
    }
}
