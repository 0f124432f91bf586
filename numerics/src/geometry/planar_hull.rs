//! Convex hull of points on a plane, by Andrew's monotone chain [Andrew 1979].

use super::Plane;
use nalgebra::Vector3;

/// Points nearer to a side of the hull than about this fraction of its size are not corners.
const COLLINEAR: f64 = 1e-12;

/// Replaces points by the corners of their convex hull, projected along the plane's normal.
///
/// Corners run counter-clockwise from above, the leftmost first. Collinear points leave two ends;
/// equal points leave one. Works in place: a capacity of three times the points plus 2 suffices.
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
    // The chain is built behind the points and then moved to the front. Its turns are tested
    // without tolerance, which would drop the end of a side as well as the points between.
    for pass in 0..2 {
        let begin = points.len();
        for k in 0..n {
            let next = points[if pass == 0 { k } else { n - 1 - k }];
            while points.len() >= begin + 2 && turn(&points[points.len() - 2], &points[points.len() - 1], &next) <= 0.0
            {
                points.pop();
            }
            points.push(next);
        }
        points.pop();
    }
    points.drain(..n);
    // A point between its neighbours, on their line up to rounding, is not a corner.
    let flat_corner = |points: &[Vector3<f64>], i: usize| {
        let n = points.len();
        let (a, b, c) = (&points[(i + n - 1) % n], &points[i], &points[(i + 1) % n]);
        turn(a, b, c) <= COLLINEAR * size * size && (flat(b) - flat(a)).dot(&(flat(c) - flat(b))) > 0.0
    };
    while points.len() > 2 {
        let Some(i) = (0..points.len()).find(|i| flat_corner(points, *i)) else { break };
        points.remove(i);
    }
    // The first corner is the leftmost, the lowest of those that are leftmost up to rounding.
    let before = |i: usize, k: usize| {
        let (a, b) = (flat(&points[i]), flat(&points[k]));
        a.x < b.x - COLLINEAR * size || a.x < b.x + COLLINEAR * size && a.y < b.y
    };
    let first = (1..points.len()).fold(0, |first, i| if before(i, first) { i } else { first });
    points.rotate_left(first);
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
    fn rounding_moves_no_corner() {
        // Every order in x of the four points on each of two sides, by differences of one rounding.
        for mask in 0u32..1 << 8 {
            let mut points = Vec::new();
            for (i, x) in [0.3f64, 0.7].into_iter().enumerate() {
                for (j, y) in [0.1, 0.2, 0.3, 0.4].into_iter().enumerate() {
                    points.push((if mask >> (4 * i + j) & 1 == 1 { x.next_up() } else { x }, y));
                }
            }
            // Rounding decides which of the two leftmost comes first.
            let mut found = hull(&points);
            let first = found.iter().position(|p| *p == (30, 10)).unwrap_or(0);
            found.rotate_left(first);
            assert_eq!(found, [(30, 10), (70, 10), (70, 40), (30, 40)], "{mask:b}");
        }
    }

    #[test]
    fn hulls_of_lines_and_points() {
        assert_eq!(hull(&[]), []);
        assert_eq!(hull(&[(0.1, 0.2); 3]), [(10, 20)]);
        assert_eq!(hull(&[(0.0, 0.0), (0.2, 0.4), (0.1, 0.2), (0.05, 0.1)]), [(0, 0), (20, 40)]);
        assert_eq!(hull(&[(0.0, 0.3), (0.0, -0.1), (0.0, 0.1), (0.0, 0.3)]), [(0, -10), (0, 30)]);
    }

    #[test]
    fn rounding_of_points_in_line_loses_no_corner() {
        // Two feet side by side, their points off by all patterns of two rounding errors.
        let feet = [-0.07, -0.008, 0.008, 0.07].map(|y| [(-0.07, y), (0.024, y)]);
        for pattern in 0..1u32 << 16 {
            let off = |i: usize| if pattern >> i & 1 == 1 { 3e-17 } else { -4e-17 };
            let points = feet.as_flattened().iter().enumerate().map(|(i, p)| (p.0 + off(i), p.1 + off(i + 8)));
            let mut points: Vec<_> = points.map(|p| Vector3::new(p.0, p.1, 0.0)).collect();
            convex_hull(&mut points, &Plane::LEVEL);
            let corners: Vec<_> =
                points.iter().map(|p| ((p.x * 1e3).round() as i32, (p.y * 1e3).round() as i32)).collect();
            assert_eq!(corners, [(-70, -70), (24, -70), (24, 70), (-70, 70)], "{pattern}");
        }
    }

    #[test]
    fn a_thin_hull_keeps_its_ends() {
        let mut points: Vec<_> =
            [(0.0, 0.0), (2.0, 0.0), (2.0, 1e-13), (0.0, 1e-13)].map(|p| Vector3::new(p.0, p.1, 0.0)).into();
        convex_hull(&mut points, &Plane::LEVEL);
        let reach = |end: f64| points.iter().any(|p| (p.x - end).abs() < 1e-12);
        assert!(reach(0.0) && reach(2.0), "{points:?}");
    }
}
