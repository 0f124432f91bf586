//! Is a list of points a sole: a point, a segment, or a strictly convex planar polygon in order?

use nalgebra::Vector3;

/// Points further apart than this fraction of the polygon's size count as distinct, or off the plane.
const RELATIVE: f64 = 1e-6;

/// Checks the points; the message says what is wrong and names the point by its index.
pub fn check(points: &[Vector3<f64>]) -> Result<(), String> {
    if points.is_empty() {
        return Err("it has no points".into());
    }
    if let Some(i) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(format!("point {i} is not finite"));
    }
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    for (i, p) in points.iter().enumerate() {
        if let Some(j) = points[..i].iter().position(|o| (p - o).norm() <= RELATIVE * size) {
            return Err(format!("points {j} and {i} coincide"));
        }
    }
    if points.len() < 3 {
        return Ok(());
    }
    let normal = area_vector(points);
    // A bow tie may enclose no area though its points are fine.
    if normal.norm() <= RELATIVE * size * size {
        return Err("it encloses no area: the points lie on a line or are not in order".into());
    }
    let normal = normal.normalize();
    if let Some(i) = points.iter().position(|p| (p - points[0]).dot(&normal).abs() > RELATIVE * size) {
        let off = (points[i] - points[0]).dot(&normal);
        return Err(format!("it is not flat: point {i} is {off:.3e} m off the plane of the others"));
    }
    let n = points.len();
    let mut turning = 0.0;
    for i in 0..n {
        let (a, b, c) = (points[i], points[(i + 1) % n], points[(i + 2) % n]);
        let (into, out) = ((b - a).normalize(), (c - b).normalize());
        let sine = into.cross(&out).dot(&normal);
        if sine.abs() <= RELATIVE {
            return Err(format!("point {} lies on the line between its neighbours: leave it out", (i + 1) % n));
        }
        if sine < 0.0 {
            return Err(format!("it is not convex, or its points are not in order: see point {}", (i + 1) % n));
        }
        turning += sine.atan2(into.dot(&out));
    }
    // A star turns left at every point but goes round twice.
    if turning > 3.0 * std::f64::consts::PI {
        return Err("it goes round more than once: the points are not in order".into());
    }
    Ok(())
}

/// Twice the enclosed area, along the normal about which the points run counter-clockwise.
pub fn area_vector(points: &[Vector3<f64>]) -> Vector3<f64> {
    let origin = points.first().copied().unwrap_or_default();
    points.windows(2).map(|w| (w[0] - origin).cross(&(w[1] - origin))).sum()
}
