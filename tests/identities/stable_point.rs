//! The point of optimal stability: closed forms, and an exhaustive search over triples of edges.

use super::random_tree::Random;
use nalgebra::{Matrix3, Rotation2, Vector2, Vector3};
use stiction::geometry::{StablePoint, convex_hull, plane::Plane, stable_point};

fn v(x: f64, y: f64) -> Vector2<f64> {
    Vector2::new(x, y)
}

fn find(corners: &[Vector2<f64>]) -> StablePoint {
    stable_point(corners.iter().copied(), &mut Vec::new()).expect("there are corners")
}

#[track_caller]
fn assert_near(found: Vector2<f64>, expected: Vector2<f64>, bound: f64) {
    assert!((found - expected).norm() <= bound, "{found} is not {expected}");
}

/// Rounding of some operations on numbers of size 1, amplified where shrinking brings corners near
/// to each other.
const ROUNDING: f64 = 1e-13;

#[test]
fn no_point_gives_none_and_a_point_and_a_line_their_middle() {
    assert_eq!(stable_point(std::iter::empty(), &mut Vec::new()), None);
    assert_eq!(find(&[v(0.3, 0.4)]), StablePoint { point: v(0.3, 0.4), radius: 0.0 });
    assert_eq!(find(&[v(0.0, 1.0), v(0.5, 2.0)]), StablePoint { point: v(0.25, 1.5), radius: 0.0 });
}

#[test]
fn a_triangle_has_its_incentre() {
    for [a, b, c] in [
        [v(0.0, 0.0), v(3.0, 0.0), v(0.0, 4.0)],
        [v(-1.0, 0.2), v(2.0, 0.0), v(0.4, 0.9)],
        [v(0.0, 0.0), v(1.0, 0.0), v(0.99, 0.01)],
    ] {
        let (la, lb, lc) = ((c - b).norm(), (a - c).norm(), (b - a).norm());
        let found = find(&[a, b, c]);
        let area = 0.5 * (b - a).perp(&(c - a));
        assert!((found.radius - 2.0 * area / (la + lb + lc)).abs() < ROUNDING, "{found:?}");
        assert_near(found.point, (a * la + b * lb + c * lc) / (la + lb + lc), ROUNDING);
    }
}

#[test]
fn a_rectangle_has_its_centre_at_any_aspect_ratio_and_orientation() {
    for (length, width) in [(2.0, 1.0), (1.0, 2.0), (1.0, 1.0), (50.0, 1.0), (0.094, 0.062)] {
        for turn in [0.0, 0.3, 1.0, 2.5] {
            let (to, r) = (v(0.4, -0.7), Rotation2::new(turn));
            let corners = [v(0.0, 0.0), v(length, 0.0), v(length, width), v(0.0, width)].map(|p| r * p + to);
            let found = find(&corners);
            // Opposite edges are parallel up to rounding; the rest is rounding of coordinates up to
            // 50.
            assert_near(found.point, r * v(0.5 * length, 0.5 * width) + to, 1e-13 * length.max(1.0));
            assert!((found.radius - 0.5 * length.min(width)).abs() < ROUNDING * length.max(1.0));
        }
    }
}

#[test]
fn trapezoids_have_their_closed_forms() {
    // Parallel sides of 4 and 2, height 1, ends of slope 1: discs of radius 1/2 between them with centres at height 1/2,
    // 1/2 / sin(pi/4) from each end: from 1/2 + sqrt(1/2) to 4 - that.
    let found = find(&[v(0.0, 0.0), v(4.0, 0.0), v(3.0, 1.0), v(1.0, 1.0)]);
    assert_near(found.point, v(2.0, 0.5), ROUNDING);
    // One end upright: the locus runs from 1/2 to 4 - (1/2 + sqrt(1/2)).
    let found = find(&[v(0.0, 0.0), v(4.0, 0.0), v(3.0, 1.0), v(0.0, 1.0)]);
    assert_near(found.point, v(0.5 * (0.5 + 3.5 - 0.5f64.sqrt()), 0.5), ROUNDING);
    assert!((found.radius - 0.5).abs() < ROUNDING);
    // Tall: the base and both ends hold the disc, as in the triangle they would make; base 2, top 1.9, height 3.
    let found = find(&[v(0.0, 0.0), v(2.0, 0.0), v(1.95, 3.0), v(0.05, 3.0)]);
    // Half the base angle's tangent times half the base.
    let radius = (0.5 * (3.0f64 / 0.05).atan()).tan();
    assert_near(found.point, v(1.0, radius), ROUNDING);
    assert!((found.radius - radius).abs() < ROUNDING);
}

#[test]
fn a_slight_taper_moves_the_point_continuously_from_the_middle_to_the_wide_end() {
    // 10 long, 1 high at the right and less by the taper at the left.
    let at = |taper: f64| find(&[v(0.0, 0.0), v(10.0, 0.0), v(10.0, 1.0), v(0.0, 1.0 - taper)]).point.x;
    let right = |taper: f64| {
        // Between the bottom, the right end and the top: their angle at the top right corner is
        // slightly below 90 degrees.
        let slope = taper / 10.0;
        let radius = 1.0 / (1.0 + (1.0 + slope * slope).sqrt() + slope);
        10.0 - radius
    };
    for taper in [0.0, 1e-15, 1e-12, 1e-9, 1e-7] {
        // From the left end, whose disc is by half the taper smaller, to the right.
        assert!((at(taper) - 5.0).abs() < taper + 1e-12, "{taper}: {}", at(taper));
    }
    for taper in [1e-5, 1e-3, 0.3] {
        assert!((at(taper) - right(taper)).abs() < 1e-9, "{taper}: {} not {}", at(taper), right(taper));
    }
    let mut before = at(1e-8);
    for k in 1..=4000 {
        let here = at(1e-8 * 1e4f64.powf(f64::from(k) / 4000.0));
        assert!(here >= before - 1e-9 && here - before < 0.05, "{k}: from {before} to {here}");
        before = here;
    }
}

/// All discs that touch three edges and are inside: the largest, and the mean centre of equally
/// large ones.
fn by_triples(corners: &[Vector2<f64>]) -> StablePoint {
    let n = corners.len();
    let edges: Vec<(Vector2<f64>, f64)> = (0..n)
        .map(|i| {
            let along = (corners[(i + 1) % n] - corners[i]).normalize();
            let normal = v(-along.y, along.x);
            (normal, normal.dot(&corners[i]))
        })
        .collect();
    let mut discs = Vec::new();
    for a in 0..n {
        for b in 0..a {
            for c in 0..b {
                let row = |i: usize| [edges[i].0.x, edges[i].0.y, -1.0];
                let m = Matrix3::from_fn(|r, k| row([a, b, c][r])[k]);
                let Some(inverse) = m.try_inverse() else { continue };
                let x = inverse * Vector3::new(edges[a].1, edges[b].1, edges[c].1);
                if edges.iter().all(|(normal, d)| normal.dot(&x.xy()) - d - x.z >= -1e-11) {
                    discs.push((x.xy(), x.z));
                }
            }
        }
    }
    let radius = discs.iter().map(|d| d.1).fold(f64::NEG_INFINITY, f64::max);
    discs.retain(|d| d.1 > radius - 1e-9);
    let apart = |p: &Vector2<f64>, q: &Vector2<f64>| (p - q).norm();
    let far = |p: Vector2<f64>| discs.iter().map(|d| d.0).max_by(|a, b| apart(a, &p).total_cmp(&apart(b, &p))).unwrap();
    let one = far(discs[0].0);
    StablePoint { point: (one + far(one)) * 0.5, radius }
}

#[test]
fn random_polygons_agree_with_every_triple_of_edges() {
    let mut r = Random::new(11);
    let mut counts = [0; 12];
    for _ in 0..3000 {
        let n = 3 + (r.list(1, 1.0)[0].abs() * 20.0) as usize;
        let points = (0..n).map(|_| r.list(2, 1.0));
        let mut points: Vec<_> = points.map(|p| Vector3::new(p[0], p[1], 0.0)).collect();
        convex_hull(&mut points, &Plane::LEVEL);
        let corners: Vec<_> = points.iter().map(|p| p.xy()).collect();
        let (found, expected) = (find(&corners), by_triples(&corners));
        counts[corners.len().min(11)] += 1;
        // Two nearly opposite edges of a random polygon amplify rounding by 1 over the sine of
        // their angle.
        assert!((found.radius - expected.radius).abs() < 1e-12, "{corners:?}: {found:?} {expected:?}");
        assert_near(found.point, expected.point, 1e-9);
    }
    assert!(counts[3..9].iter().all(|c| *c > 50), "{counts:?}");
}

#[test]
fn two_feet_anywhere_agree_with_every_triple_of_edges() {
    let mut r = Random::new(12);
    for _ in 0..500 {
        let foot = [v(0.058, 0.031), v(-0.036, 0.031), v(-0.036, -0.031), v(0.058, -0.031)];
        let place = r.list(3, 1.0);
        let second = foot.map(|p| Rotation2::new(0.5 * place[0]) * p + v(0.1 * place[1], 0.15 + 0.05 * place[2]));
        let mut points: Vec<_> = foot.iter().chain(&second).map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
        convex_hull(&mut points, &Plane::LEVEL);
        let corners: Vec<_> = points.iter().map(|p| p.xy()).collect();
        let (found, expected) = (find(&corners), by_triples(&corners));
        assert!((found.radius - expected.radius).abs() < 1e-13, "{found:?} {expected:?}");
        assert_near(found.point, expected.point, 1e-10);
    }
}

#[test]
fn translating_rotating_and_scaling_a_polygon_transforms_its_point() {
    let mut r = Random::new(13);
    for _ in 0..200 {
        let mut points: Vec<_> = (0..7).map(|_| r.list(2, 1.0)).map(|p| Vector3::new(p[0], p[1], 0.0)).collect();
        convex_hull(&mut points, &Plane::LEVEL);
        let corners: Vec<_> = points.iter().map(|p| p.xy()).collect();
        let found = find(&corners);
        let (turn, to) = (Rotation2::new(r.list(1, 3.0)[0]), v(0.7, -1.3));
        let moved: Vec<_> = corners.iter().map(|p| turn * p * 0.01 + to).collect();
        let again = find(&moved);
        // Coordinates of size 1 round by 1e-16, so a polygon of size 1/100 keeps 1e-14 of its size.
        assert_near((again.point - to) * 100.0, turn * found.point, 1e-10);
        assert!((again.radius * 100.0 - found.radius).abs() < 1e-12);
    }
}
