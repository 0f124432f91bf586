//! The point of optimal stability of a convex polygon: the mid-point of the locus of centres of its
//! largest inscribed discs.
//!
//! ```text
//! r(x) = min_i (n_i . x - d_i),   locus = { x : r(x) = max r }
//! ```
//!
//! where n_i are the inward unit normals of the edges (footnote 2 of section II.B of [Hale 2008]).
//! r is concave, so the locus is a point or, where two edges are parallel, a segment between them.
//! The result for a line is its mid-point, for a point the point itself.
//!
//! The largest radius is found by shrinking the polygon. All edges move inward at unit speed, a
//! corner between normals a and b at `(a + b) / (1 + a . b)`. The neighbours of a vanished edge
//! meet. If they are parallel or would part, only a corner on the locus remains.
//!
//! **Nearly parallel edges.** For two edges with the slightest taper the definition gives the wide
//! end of the strip between them, so a rounding error would move the point from the middle to an
//! end. The locus is therefore measured on the level sets `r >= (1 - s) max r` for s = TAPER and
//! TAPER / 2 and extrapolated to s = 0 along straight lines. That is exact for a single centre and
//! for parallel edges, and continuous in between: edges count as parallel while the radius of the
//! disc between them changes by less than TAPER / 2 over the strip.

use nalgebra::Vector2;

/// Taper below which edges count as parallel, relative to the radius; see the module.
const TAPER: f64 = 1e-6;

/// Sine of the angle below which neighbours no longer meet.
const PARALLEL: f64 = 1e-12;

/// Result of [`stable_point`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StablePoint {
    /// The point, m.
    pub point: Vector2<f64>,
    /// Radius of the largest disc, m.
    pub radius: f64,
}

/// One edge of the shrinking polygon.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Inward unit normal.
    normal: Vector2<f64>,
    /// Unit vector along it, counter-clockwise.
    along: Vector2<f64>,
    /// Its current start, m.
    start: Vector2<f64>,
    /// A point of it before shrinking, m.
    anchor: Vector2<f64>,
}

/// The point of optimal stability of a convex polygon; `None` without corners.
///
/// Corners are counter-clockwise, no three collinear, as [`super::convex_hull`] leaves them.
/// `edges` is scratch: with a capacity of twice the corners nothing is allocated.
pub fn stable_point(
    corners: impl ExactSizeIterator<Item = Vector2<f64>> + Clone,
    edges: &mut Vec<Edge>,
) -> Option<StablePoint> {
    let first = corners.clone().next()?;
    if corners.len() < 3 {
        let point = corners.last().map_or(first, |last| first + (last - first) * 0.5);
        return Some(StablePoint { point, radius: 0.0 });
    }
    edges.clear();
    let next = corners.clone().skip(1).chain(std::iter::once(first));
    for (start, end) in corners.zip(next) {
        let along = (end - start).normalize();
        edges.push(Edge { normal: Vector2::new(-along.y, along.x), along, start, anchor: start });
    }
    let n = edges.len();
    edges.extend_from_within(..);
    let (original, shrinking) = edges.split_at_mut(n);
    let (centre, radius) = shrink(shrinking);
    Some(StablePoint { point: middle(original, centre, radius), radius })
}

/// Velocity of the corner between two neighbours; `None` if they are parallel or part.
fn corner_velocity(before: &Edge, after: &Edge) -> Option<Vector2<f64>> {
    let (sine, cosine) = (before.along.perp(&after.along), before.along.dot(&after.along));
    if sine <= PARALLEL && (cosine < 0.0 || sine < -PARALLEL) {
        return None;
    }
    // tan of half the turning angle, in the form without cancellation.
    let half = if cosine > 0.0 { sine / (1.0 + cosine) } else { (1.0 - cosine) / sine };
    Some(before.normal - before.along * half)
}

/// Shrinks the polygon until it vanishes. Returns a point of the locus and the largest radius.
fn shrink(edges: &mut [Edge]) -> (Vector2<f64>, f64) {
    let mut n = edges.len();
    let mut time = 0.0;
    loop {
        // The edge that vanishes first: its length over the speed at which its corners approach
        // each other.
        let mut first = (f64::INFINITY, 0);
        for i in 0..n {
            let (before, here, after) = (&edges[(i + n - 1) % n], &edges[i], &edges[(i + 1) % n]);
            let ends = corner_velocity(before, here).zip(corner_velocity(here, after));
            let length = (after.start - here.start).dot(&here.along).max(0.0);
            let remaining = ends.map_or(0.0, |(start, end)| length / (start - end).dot(&here.along));
            // An edge that grows never vanishes.
            if remaining >= 0.0 && remaining < first.0 {
                first = (remaining, i);
            }
        }
        let (remaining, vanished) = first;
        if remaining == f64::INFINITY {
            return (edges[0].start, time);
        }
        time += remaining;
        for i in 0..n {
            let velocity = corner_velocity(&edges[(i + n - 1) % n], &edges[i]).unwrap_or_default();
            edges[i].start += velocity * remaining;
        }
        let (before, after) = ((vanished + n - 1) % n, (vanished + 1) % n);
        let corner = edges[vanished].start;
        if n == 3 || corner_velocity(&edges[before], &edges[after]).is_none() {
            return (corner, time);
        }
        edges[after].start = corner;
        edges.copy_within(vanished + 1..n, vanished);
        n -= 1;
    }
}

/// Moves from one centre of a largest disc to the middle of all of them.
fn middle(edges: &[Edge], centre: Vector2<f64>, radius: f64) -> Vector2<f64> {
    let distance = |e: &Edge| (e.normal.dot(&(centre - e.anchor)) - radius).max(0.0);
    let active = |e: &&Edge| distance(e) <= TAPER * radius;
    let mut opposite: Option<(f64, Vector2<f64>)> = None;
    for (i, a) in edges.iter().enumerate().filter(|(_, e)| active(e)) {
        for b in edges[..i].iter().filter(active) {
            let cosine = a.normal.dot(&b.normal);
            if opposite.is_none_or(|(least, _)| cosine < least) {
                opposite = Some((cosine, a.normal - b.normal));
            }
        }
    }
    let Some((_, across)) = opposite.filter(|(_, across)| across.norm() > 0.0) else { return centre };
    // The strip runs along the bisector of the two edges.
    let along = Vector2::new(-across.y, across.x).normalize();
    let reach = |direction: Vector2<f64>| {
        let to = |level: f64| {
            let leaves = edges.iter().map(|e| (e, -e.normal.dot(&direction))).filter(|(_, fall)| *fall > 0.0);
            leaves.map(|(e, fall)| (distance(e) + level * radius) / fall).fold(f64::INFINITY, f64::min)
        };
        2.0 * to(0.5 * TAPER) - to(TAPER)
    };
    centre + along * (0.5 * (reach(along) - reach(-along)))
}
