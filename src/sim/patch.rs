//! Patches: regions of the floor with friction of their own.
//!
//! A patch is a simple polygon in the world's x and y, seen from above: it covers the points of the floor that lie
//! straight above or below it, however the floor is tilted. Where patches overlap the later one counts. The signed
//! distance to a region's border,
//!
//! ```text
//! inside_j(p) = +- min over edges |p - edge|        positive within polygon j
//! inside(zone j) = min(inside_j, -inside_i for all i > j)        inside(floor) = min over all i of -inside_i
//! ```
//!
//! is continuous, and its zero is where a sliding vertex changes its friction. Distances are those seen from above.

use super::setup::Floor;
use nalgebra::{Vector2, Vector3};

/// Width of a border: what is nearer to it is on it. 1e-12 of the coordinates but at least of a metre, far above their
/// rounding.
pub fn border_width(p: &Vector2<f64>) -> f64 {
    1e-12 * p.amax().max(1.0)
}

/// Where a point of the floor belongs: to the patch of this index, or to none.
pub type Zone = Option<usize>;

/// A region of the floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Corners in order around it, world x and y, m; a simple polygon, convex or not.
    pub corners: Vec<Vector2<f64>>,
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
}

impl Patch {
    fn edges(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> {
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
            // An edge that a ray towards +x crosses; its upper end does not belong to it.
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / d.y * d.x {
                within = !within;
            }
        }
        if within { nearest } else { -nearest }
    }
}

impl Floor {
    /// The zone of a point; the border belongs to the patch.
    pub fn zone(&self, p: &Vector2<f64>) -> Zone {
        self.patches.iter().rposition(|patch| patch.inside(p) >= -0.5 * border_width(p))
    }

    /// Distance of a point to the border of `zone`, m, positive inside; infinite without patches.
    pub fn inside(&self, zone: Zone, p: &Vector2<f64>) -> f64 {
        let own = zone.map_or(f64::INFINITY, |z| self.patches[z].inside(p));
        self.above(zone).iter().map(|patch| -patch.inside(p)).fold(own, f64::min)
    }

    /// Static and kinetic friction of a zone.
    pub fn friction(&self, zone: Zone) -> (f64, f64) {
        zone.map_or((self.mu_s, self.mu_k), |z| (self.patches[z].mu_s, self.patches[z].mu_k))
    }

    /// Where the straight way `from`, `to` leaves `zone`, if it does: the middle between there and the next border, as a
    /// fraction of the way. Pieces shorter than a nanometre do not count.
    pub fn strays(&self, zone: Zone, from: &Vector2<f64>, to: &Vector2<f64>) -> Option<f64> {
        const SHORT: f64 = 1e-9;
        let length = (to - from).norm();
        if !(length > SHORT) {
            return None;
        }
        let borders = || zone.map(|z| &self.patches[z]).into_iter().chain(self.above(zone));
        let cuts = || borders().flat_map(Patch::edges).filter_map(|(a, b)| cut(from, to, &a, &b));
        let at = |t: f64| from + (to - from) * t;
        let short = SHORT / length;
        let leaves = |t: &f64| *t + short < 1.0 && self.inside(zone, &at(t + 0.5 * short)) < 0.0;
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

    fn above(&self, zone: Zone) -> &[Patch] {
        &self.patches[zone.map_or(0, |z| z + 1)..]
    }
}

/// Where the way `from`, `to` crosses the segment `a`, `b`, as a fraction of the way.
fn cut(from: &Vector2<f64>, to: &Vector2<f64>, a: &Vector2<f64>, b: &Vector2<f64>) -> Option<f64> {
    let (way, edge, start) = (to - from, b - a, a - from);
    let across = way.perp(&edge);
    let (t, s) = (start.perp(&edge) / across, start.perp(&way) / across);
    // Parallel ways give no number and do not cross.
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s)).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    fn floor(patches: &[&[[f64; 2]]]) -> Floor {
        let patch = |(i, c): (usize, &&[[f64; 2]])| Patch {
            corners: c.iter().map(|&p| p.into()).collect(),
            mu_s: i as f64,
            mu_k: i as f64,
        };
        Floor {
            rotation: Matrix3::identity(),
            point: Vector3::zeros(),
            mu_s: 9.0,
            mu_k: 8.0,
            patches: patches.iter().enumerate().map(patch).collect(),
        }
    }

    /// An L: the unit square without its upper right quarter.
    const L: &[[f64; 2]] = &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]];

    #[test]
    fn distance_to_a_border_that_turns_inwards() {
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
    fn the_later_patch_counts_and_the_border_is_the_patchs() {
        let floor = floor(&[L, &[[0.2, -1.0], [0.3, -1.0], [0.3, 2.0], [0.2, 2.0]]]);
        for (x, y, zone) in [(0.1, 0.1, Some(0)), (0.25, 0.1, Some(1)), (0.2, 0.1, Some(1)), (0.6, 0.6, None)] {
            assert_eq!(floor.zone(&Vector2::new(x, y)), zone, "{x} {y}");
        }
        assert_eq!(floor.zone(&Vector2::new(1.0, 0.25)), Some(0));
        assert_eq!(floor.zone(&Vector2::new(1.0 + 1e-11, 0.25)), None);
        assert_eq!((floor.friction(None), floor.friction(Some(1))), ((9.0, 8.0), (1.0, 1.0)));
        // The later patch cuts a border into the earlier one, not the other way round.
        assert!((floor.inside(Some(0), &Vector2::new(0.15, 0.5)) - 0.05).abs() < 1e-15);
        assert!((floor.inside(Some(1), &Vector2::new(0.25, 0.01)) - 0.05).abs() < 1e-15);
        assert!((floor.inside(None, &Vector2::new(0.25, -1.2)) - 0.2).abs() < 1e-15);
    }

    #[test]
    fn a_way_that_leaves_and_comes_back_is_noticed() {
        let floor = floor(&[L, &[[0.2, -1.0], [0.3, -1.0], [0.3, 2.0], [0.2, 2.0]]]);
        let strays = |zone, from: [f64; 2], to: [f64; 2]| floor.strays(zone, &from.into(), &to.into());
        // Over the strip, from 0.1 to 0.9: outside between 1/8 and 2/8 of the way.
        assert!((strays(Some(0), [0.1, 0.1], [0.9, 0.1]).unwrap() - 0.1875).abs() < 1e-12);
        // Across the L's missing corner; into the L, whose first piece ends at the strip.
        assert!((strays(Some(0), [0.4, 0.9], [0.9, 0.4]).unwrap() - 0.5).abs() < 1e-12);
        assert!((strays(None, [-1.0, 0.75], [1.0, 0.75]).unwrap() - 0.55).abs() < 1e-12);
        assert_eq!(strays(Some(0), [0.35, 0.1], [0.9, 0.1]), None);
        assert_eq!(strays(None, [-1.0, 3.0], [1.0, 3.0]), None);
        // Along a border, and out at the end.
        assert_eq!(strays(Some(0), [0.4, 0.0], [0.9, 0.0]), None);
        assert!((strays(Some(0), [0.5, 0.25], [1.5, 0.25]).unwrap() - 0.75).abs() < 1e-12);
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
