//! Friction regions: the plane and the patches on it, where a later patch covers earlier ones.
//!
//! The signed distance to the border of a region,
//!
//! ```text
//! inside(region j) = min(inside_j, -inside_i for all i > j)        inside(plane) = min over all i of -inside_i
//! ```
//!
//! with inside_j that of [`Patch::inside`], is continuous; a sliding vertex changes its friction
//! where it is zero. Distances are those seen from above.

use super::patch::{Patch, border_width};
use crate::geometry::Plane;
use crate::terrain::ExtraFriction;
use nalgebra::{Matrix3, Vector2, Vector3};

/// A friction region: the index of a patch, or none for the plane around all patches.
pub type RegionId = Option<usize>;

/// Gap of points to an absent plane, m.
const ABSENT: f64 = 1e6;

/// The floor plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Floor axes in the world; the third column is the upward normal.
    pub rotation: Matrix3<f64>,
    /// A point of the plane, m.
    pub point: Vector3<f64>,
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// The other terms of friction.
    pub extra: ExtraFriction,
    /// Patches with friction of their own; where they overlap the last one applies.
    pub patches: Vec<Patch>,
    /// Whether nothing touches the plane: only terrain carries the robot.
    pub is_absent: bool,
}

impl Floor {
    /// The plane alone.
    pub fn plane(&self) -> Plane {
        Plane { rotation: self.rotation, point: self.point }
    }

    /// World vector in floor axes.
    pub fn to_floor(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(v)
    }

    /// Height of a world point above the plane, m.
    pub fn height(&self, p: &Vector3<f64>) -> f64 {
        self.rotation.column(2).dot(&(p - self.point))
    }

    /// As [`height`](Self::height), for contact: nothing is near an absent plane.
    pub fn gap(&self, p: &Vector3<f64>) -> f64 {
        self.height(p) + if self.is_absent { ABSENT } else { 0.0 }
    }

    /// The region of a point; the border belongs to the patch.
    pub fn region(&self, p: &Vector2<f64>) -> RegionId {
        self.patches.iter().rposition(|patch| patch.inside(p) >= -0.5 * border_width(p))
    }

    /// Distance of a point to the border of `region`, m, positive inside; infinite without patches.
    pub fn inside(&self, region: RegionId, p: &Vector2<f64>) -> f64 {
        let own = region.map_or(f64::INFINITY, |z| self.patches[z].inside(p));
        self.above(region).iter().map(|patch| -patch.inside(p)).fold(own, f64::min)
    }

    /// Static and kinetic friction coefficient of a region.
    pub fn friction(&self, region: RegionId) -> (f64, f64) {
        region.map_or((self.mu_s, self.mu_k), |z| (self.patches[z].mu_s, self.patches[z].mu_k))
    }

    /// The other terms of friction of a region.
    pub fn extra(&self, region: RegionId) -> ExtraFriction {
        region.map_or(self.extra, |z| self.patches[z].extra)
    }

    /// Where the segment from `from` to `to` leaves `region`, if it does: the middle between that
    /// point and the next border, as a fraction of the segment. Pieces shorter than a nanometre are
    /// ignored.
    pub fn exit_from(&self, region: RegionId, from: &Vector2<f64>, to: &Vector2<f64>) -> Option<f64> {
        const SHORT: f64 = 1e-9;
        let length = (to - from).norm();
        if !(length > SHORT) {
            return None;
        }
        let borders = || region.map(|z| &self.patches[z]).into_iter().chain(self.above(region));
        let cuts = || borders().flat_map(Patch::edges).filter_map(|(a, b)| crossing(from, to, &a, &b));
        let at = |t: f64| from + (to - from) * t;
        let short = SHORT / length;
        let leaves = |t: &f64| *t + short < 1.0 && self.inside(region, &at(t + 0.5 * short)) < 0.0;
        let out = cuts().filter(leaves).fold(f64::INFINITY, f64::min);
        let back = cuts().filter(|t| *t > out + short).fold(1.0, f64::min);
        out.is_finite().then_some(0.5 * (out + back))
    }

    /// The corners of a patch on the plane, world, m.
    pub fn outline(&self, patch: &Patch) -> Vec<Vector3<f64>> {
        let n = self.rotation.column(2);
        let lift = |c: &Vector2<f64>| {
            let d = Vector3::new(c.x, c.y, 0.0) - self.point;
            Vector3::new(c.x, c.y, -n.dot(&d) / n.z)
        };
        patch.corners.iter().map(lift).collect()
    }

    /// The patches that cover `region` where they overlap it.
    fn above(&self, region: RegionId) -> &[Patch] {
        &self.patches[region.map_or(0, |z| z + 1)..]
    }
}

/// Where the segment `from`, `to` crosses the segment `a`, `b`, as a fraction of the former.
fn crossing(from: &Vector2<f64>, to: &Vector2<f64>, a: &Vector2<f64>, b: &Vector2<f64>) -> Option<f64> {
    let (segment, edge, start) = (to - from, b - a, a - from);
    let across = segment.perp(&edge);
    let (t, s) = (start.perp(&edge) / across, start.perp(&segment) / across);
    // Parallel segments divide by zero and do not cross.
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s)).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(patches: &[&[[f64; 2]]]) -> Floor {
        let patch = |(i, c): (usize, &&[[f64; 2]])| Patch {
            corners: c.iter().map(|&p| p.into()).collect(),
            mu_s: i as f64,
            mu_k: i as f64,
            extra: ExtraFriction::default(),
        };
        Floor {
            rotation: Matrix3::identity(),
            point: Vector3::zeros(),
            mu_s: 9.0,
            mu_k: 8.0,
            extra: ExtraFriction::default(),
            patches: patches.iter().enumerate().map(patch).collect(),
            is_absent: false,
        }
    }

    /// An L: the unit square without its upper right quarter.
    const L: &[[f64; 2]] = &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]];

    #[test]
    fn distance_to_the_border_of_a_concave_patch() {
        let inside = |x, y| floor(&[L]).patches[0].inside(&Vector2::new(x, y));
        for (x, y, distance) in [
            (0.25, 0.25, 0.25),
            (0.45, 0.45, 0.05 * 2f64.sqrt()),
            (0.6, 0.6, -0.1),
            (0.75, 0.45, 0.05),
            (2.0, 0.25, -1.0),
            (-3.0, -4.0, -5.0),
            (0.5, 0.0, 0.0),
            (0.5, 0.5, 0.0),
        ] {
            // One rounding of coordinates of order 1.
            assert!((inside(x, y) - distance).abs() < 1e-15, "{x} {y}: {}", inside(x, y));
        }
    }

    #[test]
    fn later_patches_cover_earlier_ones_and_own_their_border() {
        let floor = floor(&[L, &[[0.2, -1.0], [0.3, -1.0], [0.3, 2.0], [0.2, 2.0]]]);
        for (x, y, region) in [(0.1, 0.1, Some(0)), (0.25, 0.1, Some(1)), (0.2, 0.1, Some(1)), (0.6, 0.6, None)] {
            assert_eq!(floor.region(&Vector2::new(x, y)), region, "{x} {y}");
        }
        assert_eq!(floor.region(&Vector2::new(1.0, 0.25)), Some(0));
        assert_eq!(floor.region(&Vector2::new(1.0 + 1e-11, 0.25)), None);
        assert_eq!((floor.friction(None), floor.friction(Some(1))), ((9.0, 8.0), (1.0, 1.0)));
        // The later patch cuts a border into the earlier one, not the other way round.
        assert!((floor.inside(Some(0), &Vector2::new(0.15, 0.5)) - 0.05).abs() < 1e-15);
        assert!((floor.inside(Some(1), &Vector2::new(0.25, 0.01)) - 0.05).abs() < 1e-15);
        assert!((floor.inside(None, &Vector2::new(0.25, -1.2)) - 0.2).abs() < 1e-15);
    }

    #[test]
    fn segments_that_leave_a_region_and_return_are_found() {
        let floor = floor(&[L, &[[0.2, -1.0], [0.3, -1.0], [0.3, 2.0], [0.2, 2.0]]]);
        let exit_from = |region, from: [f64; 2], to: [f64; 2]| floor.exit_from(region, &from.into(), &to.into());
        // Over the strip, from 0.1 to 0.9: outside between 1/8 and 2/8 of the segment.
        assert!((exit_from(Some(0), [0.1, 0.1], [0.9, 0.1]).unwrap() - 0.1875).abs() < 1e-12);
        // Across the L's missing corner; into the L, whose first piece ends at the strip.
        assert!((exit_from(Some(0), [0.4, 0.9], [0.9, 0.4]).unwrap() - 0.5).abs() < 1e-12);
        assert!((exit_from(None, [-1.0, 0.75], [1.0, 0.75]).unwrap() - 0.55).abs() < 1e-12);
        assert_eq!(exit_from(Some(0), [0.35, 0.1], [0.9, 0.1]), None);
        assert_eq!(exit_from(None, [-1.0, 3.0], [1.0, 3.0]), None);
        // Along a border, and out at the end.
        assert_eq!(exit_from(Some(0), [0.4, 0.0], [0.9, 0.0]), None);
        assert!((exit_from(Some(0), [0.5, 0.25], [1.5, 0.25]).unwrap() - 0.75).abs() < 1e-12);
    }

    #[test]
    fn outlines_lie_on_the_tilted_plane() {
        let mut floor = floor(&[L]);
        floor.rotation = *nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 1.0).matrix();
        floor.point = Vector3::new(0.0, 0.0, 0.7);
        for (p, c) in floor.outline(&floor.patches[0]).iter().zip(L) {
            assert_eq!([p.x, p.y], *c);
            assert!(floor.height(p).abs() < 1e-15);
        }
    }
}
