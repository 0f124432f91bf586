//! The height at which a robot starts on floor and terrain.
//!
//! Let s(t) be the signed distance of a body of the robot, raised by t, and a piece of terrain. It is that of a
//! point on a line and the Minkowski difference of both, which is convex, so s is convex in t: where it is
//! negative at all, the greatest root is found from its least value upward. The rise is the greatest
//! root over all pairs, or what the floor needs.

use crate::assemble::start::LINK_DEPTH;
use crate::dynamics::{State, Workspace, kinematics};
use crate::patches::{ConvexBody, Placement, separation};
use crate::robot::Model;
use crate::sim::Floor;
use crate::sim::bodies::Body;
use crate::sim::floor::LinkHull;
use crate::terrain::{PieceRef, Terrain, TerrainPiece};
use nalgebra::Vector3;

/// Greatest number of halvings of an interval of t: those of a double.
const HALVINGS: usize = 200;

/// Greatest height and depth of terrain, m.
const FAR: f64 = 1e6;

/// Width of the interval in which the least value of s is sought, m.
const WIDTH: f64 = 1e-9;

/// What a robot stands on, and what of the robot does.
pub(super) struct Ground<'a> {
    pub floor: &'a Floor,
    pub terrain: &'a Terrain,
    /// Hulls of links that touch the floor; with them round bodies do. `None`: only soles.
    pub hulls: Option<&'a [LinkHull]>,
    /// Bodies of the robot that touch terrain.
    pub bodies: &'a [Body],
}

impl Ground<'_> {
    /// Least height, m, of the base of a robot in this state above which neither floor nor terrain stops it. With
    /// an absent floor and without terrain around the origin it is that above the plane of the floor.
    pub fn rise(&self, model: &Model, state: &State) -> f64 {
        let mut state = state.clone();
        state.position = Vector3::zeros();
        let mut ws = Workspace::new(model);
        kinematics::update(model, &state, &mut ws);
        let plane = self.above_floor(model, &ws);
        let start = if self.floor.is_absent { f64::NEG_INFINITY } else { plane };
        let rise = self.above_terrain(&ws, start);
        if rise.is_finite() { rise } else { plane }
    }

    fn above_floor(&self, model: &Model, ws: &Workspace) -> f64 {
        let vertical = self.floor.rotation[(2, 2)];
        let soles = model.soles.iter().flat_map(|sole| sole.vertices.iter().map(|v| ws.point(sole.link, v)));
        let soles = soles.map(|point| self.floor.height(&point)).fold(f64::INFINITY, f64::min);
        let mut links = f64::INFINITY;
        for hull in self.hulls.unwrap_or_default() {
            hull.heights(ws, self.floor, 0.0, |_, height| links = links.min(height));
        }
        let normal: Vector3<f64> = self.floor.rotation.column(2).into();
        for body in self.bodies.iter().filter(|body| self.hulls.is_some() && body.meets_floor) {
            let at = body.placement(ws.into());
            let least = body.shape.least(&at.rotation.tr_mul(&normal)) - body.shape.rounding;
            links = links.min(self.floor.height(&at.position) + least);
        }
        // A foot is a bit lower than its sole by rounding; the sole stands for it.
        let lowest = if links < soles - LINK_DEPTH { links } else { soles };
        if lowest.is_finite() { -lowest / vertical } else { 0.0 }
    }

    fn above_terrain(&self, ws: &Workspace, start: f64) -> f64 {
        let mut found: Vec<(f64, usize, PieceRef)> = Vec::new();
        let mut buffer = TerrainPiece::prism_buffer();
        for (k, body) in self.bodies.iter().enumerate() {
            let (min, max) = body.shape.bounds(&body.placement(ws.into()));
            let (low, high) = (Vector3::new(min.x, min.y, -FAR), Vector3::new(max.x, max.y, FAR));
            let mut near = Vec::new();
            self.terrain.near(&low, &high, |piece| near.push(piece));
            for piece in near {
                let top = self.terrain.piece(piece, &mut buffer).points.iter().map(|p| p.z).fold(f64::MIN, f64::max);
                found.push((top - min.z, k, piece));
            }
        }
        // The highest first, most others then need no search.
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut rise = start;
        for (bound, k, piece) in found {
            if bound <= rise {
                break;
            }
            let body = &self.bodies[k];
            let Some(piece) = Body::of_piece(self.terrain.piece(piece, &mut buffer)) else { continue };
            let at = body.placement(ws.into());
            let low = bound - 2.0 * (body.shape.radius + piece.shape.radius);
            rise = rise.max(greatest_root((&body.shape, at), (&piece.shape, piece.placement(ws.into())), (low, bound)));
        }
        rise
    }
}

/// The greatest t at which the bodies touch when A is raised by t; minus infinity if they never overlap. `range`
/// contains all t at which they may.
fn greatest_root(
    (a, pa): (&ConvexBody, Placement),
    (b, pb): (&ConvexBody, Placement),
    (mut low, high): (f64, f64),
) -> f64 {
    let distance = |t: f64| {
        let raised = Placement { position: pa.position + Vector3::new(0.0, 0.0, t), ..pa };
        separation(a, &raised, b, &pb, None, f64::INFINITY).distance
    };
    let mut apart = high;
    while distance(low) >= 0.0 {
        if apart - low < WIDTH {
            return f64::NEG_INFINITY;
        }
        let (left, right) = (low + (apart - low) / 3.0, apart - (apart - low) / 3.0);
        match (distance(left), distance(right)) {
            (l, _) if l < 0.0 => low = left,
            (l, r) if l < r => apart = right,
            _ => low = left,
        }
    }
    apart = high;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + apart);
        if middle <= low || middle >= apart {
            break;
        }
        if distance(middle) < 0.0 { low = middle } else { apart = middle }
    }
    apart
}
