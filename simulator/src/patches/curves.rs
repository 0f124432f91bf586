//! Nearest points of a rim and another feature, and their motion.
//!
//! Features are a vertex, the line of an edge with the direction e, and a rim: a circle with the
//! centre c, the axis a and the radius R. The point of a rim that is lowest along n is c + R u with
//! u = -P n/|P n| (see `cylinder`); the highest one has -u. With the lowest point p of A's feature and the
//! highest point y of B's, the support distance of the cores and its derivative are
//!
//! ```text
//! D = p - y      s(n) = n . D      grad s = D - s n      for n across e, if one is an edge
//! K = R/|P n| t t^T, t = a x n/|P n|, summed over rims      Hessian s = -(s 1 + K)
//! ```
//!
//! n is where s is greatest: there D = d n and d is the distance. A disc and a line, two discs, or a
//! disc and a point that are apart or touch have one maximum. In motion D' = W + sigma_A - sigma_B =
//! d' n + d n' with W = v_A(p) - v_B(y) and the slips of the points over their bodies
//!
//! ```text
//! rim of A   sigma_A = -K_A (n' - omega_A x n)      rim of B   sigma_B = K_B (n' - omega_B x n)
//! edge       sigma along e                          vertex     sigma = 0
//! ```
//!
//! so that across n, and of that across e if there is an edge,
//!
//! ```text
//! (d 1 + K_A + K_B) n' = W + K_A (omega_A x n) + K_B (omega_B x n)        n' . e = -n . (omega_e x e)
//! ```

use super::pins::Pin;
use super::{ConvexBody, Feature, Placement, RESOLUTION};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Cosines and sines of the directions from which a search around an edge starts.
const TWELFTHS: [[f64; 2]; 12] = {
    let (h, s) = (0.5, 0.866_025_403_784_438_6);
    [
        [1.0, 0.0],
        [s, h],
        [h, s],
        [0.0, 1.0],
        [-h, s],
        [-s, h],
        [-1.0, 0.0],
        [-s, -h],
        [-h, -s],
        [0.0, -1.0],
        [h, -s],
        [s, -h],
    ]
};

/// Distance from an axis at which a search starts.
const BESIDE: f64 = 1e-6;

/// |P n| below which n is along the axis up to a part that roundoff may falsify.
const ALONG: f64 = 1e-8;

/// Step at which a search between rims ends: the roundoff of the slope.
const CLOSE: f64 = 1e-13;

/// Greatest number of steps of a search.
const STEPS: usize = 60;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Vertex,
    Edge,
    Rim,
}

/// A feature in a common frame.
#[derive(Clone, Copy)]
pub(super) struct Curve {
    kind: Kind,
    /// The vertex, the start of the edge, or the centre c, m.
    pub at: Vector3<f64>,
    /// e or a.
    pub axis: Vector3<f64>,
    radius: f64,
}

impl Curve {
    /// A feature of a body, in the frame to which `rotation` and `position`, m, lead.
    pub fn new(body: &ConvexBody, feature: Feature, rotation: &Matrix3<f64>, position: &Vector3<f64>) -> Self {
        let point = |k: u16| rotation * body.vertex(k) + position;
        let none = Curve { kind: Kind::Vertex, at: Vector3::zeros(), axis: Vector3::zeros(), radius: 0.0 };
        match feature {
            Feature::Vertex(k) => Curve { at: point(k), ..none },
            Feature::Edge(k) => {
                let edge = body.edge(k);
                Curve { kind: Kind::Edge, at: point(edge.ends[0]), axis: rotation * edge.direction, ..none }
            }
            Feature::Rim(k) => Curve {
                kind: Kind::Rim,
                at: point(k),
                axis: rotation * body.axis(),
                radius: body.barrel.unwrap_or(0.0),
            },
        }
    }

    /// R u: from the centre to the lowest point along n; zero without a rim.
    fn arm(&self, n: &Vector3<f64>) -> Vector3<f64> {
        if self.kind != Kind::Rim {
            return Vector3::zeros();
        }
        let mut across = n - self.axis * self.axis.dot(n);
        if across.norm_squared() < ALONG * ALONG {
            // What is left along the axis, by roundoff, would count.
            across = self.axis.cross(n).cross(&self.axis);
        }
        across.try_normalize(f64::MIN_POSITIVE).unwrap_or_default() * -self.radius
    }

    /// R/|P n| and t; zero without a rim.
    fn stiffness(&self, n: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let turn = self.axis.cross(n);
        let norm = turn.norm();
        if self.kind != Kind::Rim || norm == 0.0 {
            return (0.0, Vector3::zeros());
        }
        (self.radius / norm, turn / norm)
    }
}

/// D at n, m.
pub(super) fn apart(a: &Curve, b: &Curve, n: &Vector3<f64>) -> Vector3<f64> {
    a.at - b.at + a.arm(n) + b.arm(n)
}

/// s(n), m, also next to the axis of a rim, where the direction of its arm is roundoff.
fn support(a: &Curve, b: &Curve, n: &Vector3<f64>) -> f64 {
    let lowest = |c: &Curve| c.radius * c.axis.cross(n).norm();
    n.dot(&(a.at - b.at)) - lowest(a) - lowest(b)
}

/// n, from B to A, where s is greatest; zero where it is not defined.
pub(super) fn best_normal(a: &Curve, b: &Curve) -> Vector3<f64> {
    match (a.kind, b.kind) {
        (Kind::Edge, _) => around(a, b, &a.axis),
        (_, Kind::Edge) => around(a, b, &b.axis),
        (Kind::Rim, Kind::Vertex) => (rim_point(a, &b.at) - b.at).try_normalize(0.0).unwrap_or_default(),
        (Kind::Vertex, Kind::Rim) => (a.at - rim_point(b, &a.at)).try_normalize(0.0).unwrap_or_default(),
        _ => between_rims(a, b),
    }
}

/// Point of a rim next to `x`.
fn rim_point(rim: &Curve, x: &Vector3<f64>) -> Vector3<f64> {
    let from = x - rim.at;
    let across = from - rim.axis * rim.axis.dot(&from);
    rim.at + across.try_normalize(0.0).unwrap_or_default() * rim.radius
}

/// The greatest s(n) for n across `e`: of the maxima next to the best of twelve directions, and next to the
/// axis of the rim, where s may have a narrow one.
fn around(a: &Curve, b: &Curve, e: &Vector3<f64>) -> Vector3<f64> {
    let x = e.cross(&Vector3::ith(e.iamin(), 1.0)).normalize();
    let y = e.cross(&x);
    let value = |n: &Vector3<f64>| n.dot(&apart(a, b, n));
    let start = TWELFTHS.map(|[cos, sin]| x * cos + y * sin);
    let values = start.map(|n| value(&n));
    let is_greatest = |k: &usize| values[*k] >= values[(k + 1) % 12] && values[*k] >= values[(k + 11) % 12];
    let rim = if a.kind == Kind::Rim { a } else { b };
    let beside = (rim.axis - e * e.dot(&rim.axis)).try_normalize(RESOLUTION);
    let axes = beside.into_iter().flat_map(|n| [n, -n]);
    let maxima = (0..12).filter(is_greatest).map(|k| start[k]).chain(axes);
    let (mut best, mut greatest) = (None, f64::NEG_INFINITY);
    for start in maxima {
        let Some(n) = maximum_near(a, b, e, start, greatest) else { continue };
        let s = value(&n);
        if best.is_none() || s > greatest {
            (best, greatest) = (Some(n), s);
        }
    }
    best.unwrap_or(x)
}

/// The maximum of s(n) across `e` near `start`: Newton steps and halvings of the interval on grad s. None once
/// it must be less than `least`: by the angle, which changes no faster than tau, s changes by at most
/// |D| <= |c_A - c_B| + R_A + R_B.
fn maximum_near(a: &Curve, b: &Curve, e: &Vector3<f64>, start: Vector3<f64>, least: f64) -> Option<Vector3<f64>> {
    let across = e.cross(&start);
    let reach = (a.at - b.at).norm() + a.radius + b.radius;
    // n = (start + tau across)/|..|; the interval reaches beyond the next direction, tan(30 degrees) away.
    let (mut low, mut high, mut tau) = (-0.6, 0.6, 0.0);
    let mut n = start;
    for _ in 0..STEPS {
        let (h, d) = (e.cross(&n), apart(a, b, &n));
        let slope = h.dot(&d);
        if slope == 0.0 {
            break;
        }
        if slope > 0.0 {
            low = tau
        } else {
            high = tau
        }
        // Next to a kink the halvings would continue to the roundoff, mostly for a maximum that is not the greatest.
        if support(a, b, &n) + reach * (high - low + RESOLUTION) < least {
            return None;
        }
        let stiff = |c: &Curve| {
            let (k, t) = c.stiffness(&n);
            k * h.dot(&t) * h.dot(&t)
        };
        let curvature = n.dot(&d) + stiff(a) + stiff(b);
        let mut next = tau + slope / curvature * (1.0 + tau * tau);
        if !(curvature > 0.0 && next > low && next < high) {
            next = 0.5 * (low + high);
        }
        if next == tau {
            break;
        }
        tau = next;
        n = (start + across * tau).normalize();
    }
    Some(n)
}

/// The greatest s(n) between two rims, from the best of 26 directions and from both axes, where s has kinks:
/// next to an axis s grows fastest towards the part of D across it.
fn between_rims(a: &Curve, b: &Curve) -> Vector3<f64> {
    let value = |n: &Vector3<f64>| n.dot(&apart(a, b, n));
    let better = |n: Vector3<f64>, m: Vector3<f64>| if value(&m) > value(&n) { m } else { n };
    let grid = |k: i32| Vector3::new((k % 3 - 1) as f64, (k / 3 % 3 - 1) as f64, (k / 9 - 1) as f64).normalize();
    let mut best = climb(a, b, (0..27).filter(|&k| k != 13).map(grid).fold(Vector3::z(), better));
    for axis in [&a.axis, &b.axis] {
        let start = better(*axis, -axis);
        let d = apart(a, b, &start);
        let across = d - start * start.dot(&d);
        let start = (start + across.try_normalize(0.0).unwrap_or_default() * BESIDE).normalize();
        best = better(best, climb(a, b, start));
    }
    best
}

/// Newton steps from `n`, of which none lowers s unless it is short.
fn climb(a: &Curve, b: &Curve, mut n: Vector3<f64>) -> Vector3<f64> {
    let value = |n: &Vector3<f64>| n.dot(&apart(a, b, n));
    for _ in 0..STEPS {
        let d = apart(a, b, &n);
        let s = n.dot(&d);
        let slope = d - n * s;
        let solved = solve_across(&n, s, &[a.stiffness(&n), b.stiffness(&n)], &slope);
        let mut step = solved.unwrap_or(slope * (0.2 / slope.norm().max(f64::MIN_POSITIVE)));
        step *= (0.3 / step.norm().max(f64::MIN_POSITIVE)).min(1.0);
        while step.norm() > 1e-7 && value(&(n + step).normalize()) < s {
            step *= 0.5;
        }
        n = (n + step).normalize();
        if step.norm() < CLOSE {
            break;
        }
    }
    n
}

/// x across n with (d 1 + K) x = v across n; `None` unless d 1 + K is positive definite.
fn solve_across(n: &Vector3<f64>, d: f64, stiff: &[(f64, Vector3<f64>); 2], v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let x = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    let y = n.cross(&x);
    let flat = |v: &Vector3<f64>| Vector2::new(x.dot(v), y.dot(v));
    let mut matrix = Matrix2::from_diagonal_element(d);
    for (k, t) in stiff {
        let t = flat(t);
        matrix += t * t.transpose() * *k;
    }
    let det = matrix.determinant();
    if !(det > 0.0 && matrix.trace() > 0.0) {
        return None;
    }
    let right = flat(v);
    let first = (matrix[(1, 1)] * right.x - matrix[(0, 1)] * right.y) / det;
    let second = (matrix[(0, 0)] * right.y - matrix[(1, 0)] * right.x) / det;
    Some(x * first + y * second)
}

impl Pin {
    /// Nearest points of two features, of which at least one is a rim.
    pub fn curved(
        (feature_a, a, pa): (Feature, &ConvexBody, &Placement),
        (feature_b, b, pb): (Feature, &ConvexBody, &Placement),
    ) -> Self {
        let curve_a = Curve::new(a, feature_a, &pa.rotation, &pa.position);
        let curve_b = Curve::new(b, feature_b, &pb.rotation, &pb.position);
        let n = best_normal(&curve_a, &curve_b);
        let (mut p, mut y) = (curve_a.at + curve_a.arm(&n), curve_b.at - curve_b.arm(&n));
        let mut along = [0.0; 2];
        if curve_a.kind == Kind::Edge {
            along[0] = curve_a.axis.dot(&(y - curve_a.at));
            p = curve_a.at + curve_a.axis * along[0];
        } else if curve_b.kind == Kind::Edge {
            along[1] = curve_b.axis.dot(&(p - curve_b.at));
            y = curve_b.at + curve_b.axis * along[1];
        }
        let distance = n.dot(&(p - y));
        let (v_p, v_y) = (pa.velocity_at(&p), pb.velocity_at(&y));
        let w = v_p - v_y;
        let (stiff_a, stiff_b) = (curve_a.stiffness(&n), curve_b.stiffness(&n));
        let (turn_a, turn_b) = (pa.omega.cross(&n), pb.omega.cross(&n));
        let k_of = |(k, t): &(f64, Vector3<f64>), v: &Vector3<f64>| t * (k * t.dot(v));
        let right = w + k_of(&stiff_a, &turn_a) + k_of(&stiff_b, &turn_b);
        let edge = match (curve_a.kind, curve_b.kind) {
            (Kind::Edge, _) => Some((curve_a.axis, pa.omega)),
            (_, Kind::Edge) => Some((curve_b.axis, pb.omega)),
            _ => None,
        };
        let n_rate = match edge {
            Some((e, omega)) => {
                let along_e = e * -n.dot(&omega.cross(&e));
                let h = n.cross(&e);
                let of_h = k_of(&stiff_a, &h) + k_of(&stiff_b, &h);
                let stiff = distance + h.dot(&of_h);
                let rate = (h.dot(&right) - of_h.dot(&along_e)) / stiff;
                if stiff > 0.0 { along_e + h * rate } else { along_e }
            }
            None => solve_across(&n, distance, &[stiff_a, stiff_b], &right).unwrap_or_default(),
        };
        let core_a_rate = if curve_a.kind == Kind::Edge {
            v_y + k_of(&stiff_b, &(n_rate - turn_b)) + n * n.dot(&w) + n_rate * distance
        } else {
            v_p - k_of(&stiff_a, &(n_rate - turn_a))
        };
        Pin { n, n_rate, core_a: p, core_a_rate, distance, along }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// Random edges and rims, and rims whose axes are along or across the edge, almost or exactly.
    fn pair(draw: &mut Stream, k: usize) -> [Curve; 2] {
        let mut vector = || Vector3::from_fn(|_, _| draw.normal());
        let axis = vector().normalize();
        let across = axis.cross(&vector()).normalize();
        let other = match k % 5 {
            0 => vector(),
            1 => axis + across * 1e-3,
            2 => across + axis * 1e-3,
            3 => across + axis * 1e-9,
            _ => across,
        };
        // Close to each other they have two maxima that are almost equal.
        let (at, size) = (vector(), if k % 4 < 2 { 0.02 } else { 0.5 });
        let edge = Curve { kind: Kind::Edge, at, axis, radius: 0.0 };
        let rim =
            Curve { kind: Kind::Rim, at: at + vector() * size, axis: other.normalize(), radius: 0.2 + draw.unit() };
        if k.is_multiple_of(2) { [edge, rim] } else { [rim, edge] }
    }

    #[test]
    fn no_direction_around_an_edge_has_a_greater_distance() {
        let mut draw = Stream::new(7, &["around"]);
        for k in 0..3000 {
            let [a, b] = pair(&mut draw, k);
            let e = if a.kind == Kind::Edge { a.axis } else { b.axis };
            let value = |n: &Vector3<f64>| n.dot(&apart(&a, &b, n));
            let found = value(&best_normal(&a, &b));
            let x = e.cross(&Vector3::ith(e.iamin(), 1.0)).normalize();
            let y = e.cross(&x);
            let around = |i: u32| {
                let angle = f64::from(i) * std::f64::consts::TAU / 2000.0;
                value(&(x * angle.cos() + y * angle.sin()))
            };
            let greatest = (0..2000).map(around).fold(f64::NEG_INFINITY, f64::max);
            // The roundoff of D, some units long.
            assert!(found >= greatest - 1e-14, "{k}: {found} < {greatest}");
        }
    }
}
