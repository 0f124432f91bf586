//! Checks that points form a sole: a point, a segment, or a strictly convex planar polygon in
//! order.

use crate::math;
use nalgebra::Vector3;

/// Fraction of the polygon's size below which points coincide, or are in one plane.
const TOLERANCE: f64 = 1e-6;

/// Why points form no sole. Points are given by index.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum PolygonDefect {
    /// No points.
    #[error("it has no points")]
    Empty,
    /// A coordinate is not finite.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// Two points are equal.
    #[error("points {0} and {1} coincide")]
    Coincide(usize, usize),
    /// The points are on a line or not in order.
    #[error("it encloses no area: the points lie on a line or are not in order")]
    NoArea,
    /// A point is off the plane of the others by this distance, m.
    #[error("it is not flat: point {0} is {1:.3e} m off the plane of the others")]
    NotFlat(usize, f64),
    /// A point is on the line between its neighbours.
    #[error("point {0} lies on the line between its neighbours: leave it out")]
    OnLine(usize),
    /// A corner turns the other way.
    #[error("it is not convex, or its points are not in order: see point {0}")]
    NotConvex(usize),
    /// The corners turn more than once.
    #[error("it winds more than once: the points are not in order")]
    Winding,
}

/// Checks the points.
///
/// # Errors
/// The first defect.
pub fn check(points: &[Vector3<f64>]) -> Result<(), PolygonDefect> {
    if points.is_empty() {
        return Err(PolygonDefect::Empty);
    }
    if let Some(i) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(PolygonDefect::NotFinite(i));
    }
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    for (i, p) in points.iter().enumerate() {
        if let Some(j) = points[..i].iter().position(|o| (p - o).norm() <= TOLERANCE * size) {
            return Err(PolygonDefect::Coincide(j, i));
        }
    }
    if points.len() < 3 {
        return Ok(());
    }
    let normal = area_vector(points);
    // A bow tie may enclose no area although its points are distinct.
    if normal.norm() <= TOLERANCE * size * size {
        return Err(PolygonDefect::NoArea);
    }
    let normal = normal.normalize();
    if let Some(i) = points.iter().position(|p| (p - points[0]).dot(&normal).abs() > TOLERANCE * size) {
        let off = (points[i] - points[0]).dot(&normal);
        return Err(PolygonDefect::NotFlat(i, off));
    }
    let n = points.len();
    let mut turning = 0.0;
    for i in 0..n {
        let (a, b, c) = (points[i], points[(i + 1) % n], points[(i + 2) % n]);
        let (into, out) = ((b - a).normalize(), (c - b).normalize());
        let sine = into.cross(&out).dot(&normal);
        if sine.abs() <= TOLERANCE {
            return Err(PolygonDefect::OnLine((i + 1) % n));
        }
        if sine < 0.0 {
            return Err(PolygonDefect::NotConvex((i + 1) % n));
        }
        turning += math::atan2(sine, into.dot(&out));
    }
    // A star turns left at every point but winds twice.
    if turning > 3.0 * std::f64::consts::PI {
        return Err(PolygonDefect::Winding);
    }
    Ok(())
}

/// Twice the enclosed area, along the normal about which the points run counter-clockwise.
pub fn area_vector(points: &[Vector3<f64>]) -> Vector3<f64> {
    let origin = points.first().copied().unwrap_or_default();
    points.windows(2).map(|w| (w[0] - origin).cross(&(w[1] - origin))).sum()
}
