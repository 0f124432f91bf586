//! Convex hull of points on a plane, by Andrew's monotone chain (A. M. Andrew, Information Processing Letters 9, 1979).

use super::Plane;
use nalgebra::Vector3;

/// Points nearer to a side of the hull than this part of its size, roughly, are no corners of it.
const FLAT: f64 = 1e-12;

/// Replaces points by the corners of their convex hull as seen along the plane's normal, counter-clockwise from above.
/// Points on one line leave its two ends; equal points leave one. Works in place: a capacity of three times the points
/// (and 2) is never outgrown.
pub fn convex_hull(points: &mut Vec<Vector3<f64>>, plane: &Plane) {
    let flat = |p: &Vector3<f64>| plane.flat(p);
    points.sort_unstable_by(|a, b| {
        let (a, b) = (flat(a), flat(b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    });
    let Some((first, last)) = points.first().zip(points.last()) else { return };
    let turn = |o: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>| (flat(a) - flat(o)).perp(&(flat(b) - flat(o)));
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        let y = flat(p).y;
        (low.min(y), high.max(y))
    });
    let size = (flat(last) - flat(first)).norm().max(high - low);
    if size == 0.0 {
        points.truncate(1);
        return;
    }
    let n = points.len();
    // The chain is built behind the points and moved to the front.
    for pass in 0..2 {
        let begin = points.len();
        for k in 0..n {
            let next = points[if pass == 0 { k } else { n - 1 - k }];
            while points.len() >= begin + 2
                && turn(&points[points.len() - 2], &points[points.len() - 1], &next) <= FLAT * size * size
            {
                points.pop();
            }
            points.push(next);
        }
        points.pop();
    }
    points.drain(..n);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hull(points: &[(f64, f64)]) -> Vec<(i32, i32)> {
        let mut points: Vec<_> = points.iter().map(|p| Vector3::new(p.0, p.1, 0.0)).collect();
        convex_hull(&mut points, &Plane::LEVEL);
        points.iter().map(|p| ((p.x * 100.0).round() as i32, (p.y * 100.0).round() as i32)).collect()
    }

    #[test]
    fn the_hull_of_two_feet_runs_counter_clockwise() {
        let foot = |y: f64| [(0.0, y), (0.1, y), (0.1, y + 0.05), (0.0, y + 0.05)];
        let mut points: Vec<_> = foot(-0.1).into_iter().chain(foot(0.1)).collect();
        points.push((0.05, 0.0));
        assert_eq!(hull(&points), [(0, -10), (10, -10), (10, 15), (0, 15)]);
    }

    #[test]
    fn lines_and_points_have_hulls_too() {
        assert_eq!(hull(&[]), []);
        assert_eq!(hull(&[(0.1, 0.2); 3]), [(10, 20)]);
        assert_eq!(hull(&[(0.0, 0.0), (0.2, 0.4), (0.1, 0.2), (0.05, 0.1)]), [(0, 0), (20, 40)]);
        assert_eq!(hull(&[(0.0, 0.3), (0.0, -0.1), (0.0, 0.1), (0.0, 0.3)]), [(0, -10), (0, 30)]);
    }
}
