//! Splits a sole's resultant over its vertices if the sensor measures only the resultant.
//!
//! ```text
//! min sum N_i^2   with   sum N_i = F_z,  sum N_i (x_i, y_i) = F_z c,  N_i >= 0        c the centre of pressure
//! ```
//!
//! The simulated floor uses the same rule for a face at rest ([`crate::contact::model::pressure`]).
//! The split of a load over more than three vertices is indeterminate; this is the most even one.
//! Tangential forces are proportional to the normal ones times the translation and rotation that
//! balance the rest of the wrench. A centre of pressure that sensor errors put outside the sole is
//! moved to the nearest point of the outline, and the two ends of that side share the load.

use super::contacts::UNLOADED;
use super::soles::SoleData;
use crate::contact::model::pressure;
use crate::contact::model::problem::{SoleProblem, Vertex};
use crate::contact::model::turning::Turning;
use crate::contact::search::static_loads::share_tangent;
use crate::geometry::Plane;
use crate::robot::{Model, Sole};
use crate::task::sensor_readings::SoleLoad;
use nalgebra::{Vector2, Vector3};

/// Scratch for all soles.
#[derive(Clone, Debug)]
pub(super) struct Splitter {
    soles: Vec<SoleProblem>,
    normal: Vec<f64>,
    tangent: Vec<Vector2<f64>>,
}

impl Splitter {
    pub fn new(model: &Model) -> Self {
        let most = model.soles.iter().map(|s| s.vertices.len()).max().unwrap_or(0);
        Splitter {
            soles: model.soles.iter().map(problem).collect(),
            normal: vec![0.0; most],
            tangent: vec![Vector2::zeros(); most],
        }
    }

    /// Fills the vertex forces of sole `s` at the positions in `data`.
    pub fn split(&mut self, s: usize, data: &mut SoleData, load: &SoleLoad, floor: &Plane) {
        let sole = &mut self.soles[s];
        for (v, at) in sole.vertices.iter_mut().zip(&data.vertices) {
            v.r = floor.to_plane(&(at - data.position));
        }
        let k = sole.vertices.len();
        let (normal, tangent) = (&mut self.normal[..k], &mut self.tangent[..k]);
        let (force, moment) = (floor.to_plane(&load.force), floor.to_plane(&load.moment));
        normal.fill(0.0);
        tangent.fill(Vector2::zeros());
        if force.z > UNLOADED {
            if !(k > 2 && pressure::share(sole, force.z, [moment.x, moment.y], normal)) {
                split_on_outline(sole, force.z, Vector2::new(-moment.y, moment.x) / force.z, normal);
            }
            share_tangent(sole, force.xy(), moment.z, normal, tangent);
        }
        for ((out, n), t) in data.vertex_forces.iter_mut().zip(&*normal).zip(&*tangent) {
            *out = floor.rotation * Vector3::new(t.x, t.y, *n);
        }
    }
}

fn problem(sole: &Sole) -> SoleProblem {
    SoleProblem {
        vertices: vec![Vertex::default(); sole.vertices.len()],
        radius: sole.radius(),
        body: sole.link.0,
        position: Vector3::zeros(),
        target: Vector3::zeros(),
        turning: Turning::default(),
    }
}

/// Gives the load to the two ends of the side nearest to `cop`, so that its centre of pressure is
/// the nearest point.
fn split_on_outline(sole: &SoleProblem, load: f64, cop: Vector2<f64>, normal: &mut [f64]) {
    let k = normal.len();
    let mut best = (f64::INFINITY, 0, 0.0);
    for i in 0..k {
        let (a, b) = (sole.vertices[i].r.xy(), sole.vertices[(i + 1) % k].r.xy());
        let (side, to) = (b - a, cop - a);
        let part = if side == Vector2::zeros() { 0.0 } else { (to.dot(&side) / side.norm_squared()).clamp(0.0, 1.0) };
        let distance = (to - side * part).norm();
        if distance < best.0 {
            best = (distance, i, part);
        }
    }
    let (_, i, part) = best;
    normal.fill(0.0);
    normal[i] += load * (1.0 - part);
    normal[(i + 1) % k] += load * part;
}
