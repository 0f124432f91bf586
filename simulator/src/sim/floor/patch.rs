//! Patches: polygons on the floor with friction of their own.
//!
//! A patch is a simple polygon in the world's x and y, seen from above: it covers the points of the
//! floor that lie vertically above or below it, however the floor is tilted. The signed distance to
//! its border is
//!
//! ```text
//! inside(p) = +- min over edges |p - edge|        positive within the polygon
//! ```

use crate::terrain::ExtraFriction;
use nalgebra::Vector2;

/// Width of a border, m: a point nearer to a border is on it. It is 1e-12 times the coordinates, at
/// least 1e-12 m, far above their rounding.
pub fn border_width(p: &Vector2<f64>) -> f64 {
    1e-12 * p.amax().max(1.0)
}

/// A region of the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Corners in order around it, world x and y, m; a simple polygon, convex or not.
    pub corners: Vec<Vector2<f64>>,
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// Its other terms of friction.
    pub extra: ExtraFriction,
}

impl Patch {
    /// The edges, in order.
    pub(super) fn edges(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> {
        let n = self.corners.len();
        (0..n).map(move |i| (self.corners[i], self.corners[(i + 1) % n]))
    }

    /// Distance of `p` to the border, m, positive inside.
    pub fn inside(&self, p: &Vector2<f64>) -> f64 {
        let (mut nearest, mut within) = (f64::INFINITY, false);
        for (a, b) in self.edges() {
            let d = b - a;
            let along = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            nearest = nearest.min((p - a - d * along).norm());
            // A ray towards +x crosses this edge; the edge's upper end does not belong to it.
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / d.y * d.x {
                within = !within;
            }
        }
        if within { nearest } else { -nearest }
    }
}
