//! Exact isotropic Coulomb friction capacity of a vertex, an edge and a face: the friction cone of
//! a sole.
//!
//! Rules of `docs/contact.md`, section 5; [Hale 2008], section III.A:
//!
//! - Vertex: `|t| <= c`, with `c = mu N`.
//! - Edge: `|T_along| <= sqrt(c_1^2 - t_1perp^2) + sqrt(c_2^2 - t_2perp^2)`, both roots real.
//! - Face: a tangential force F and yaw moment tau are carried if and only if no slip twist (v, w)
//!   extracts more power from the load than friction dissipates:
//!   `F . v + tau w <= sum c_i |v + w z x r_i|`. The set of carried loads is a Minkowski sum of
//!   discs. Pure translation gives `|F| <= sum c_i`; for w = +1 and -1 the best `v` solves a
//!   weighted Fermat-Weber problem with a linear term, solved here by vertex tests and damped
//!   Newton steps.
//!
//! Every margin is in newtons, positive inside, and continuous in the load, so that its zero can be
//! located.

use crate::math;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Margin of a vertex: capacity `c = mu N` against the tangential force `t`.
pub fn vertex(c: f64, t: &Vector2<f64>) -> f64 {
    c - t.norm()
}

/// Margin of an edge with capacities `c`, perpendicular tangential forces `across` at its two ends
/// and the sum `along` of the tangential forces along it.
pub fn edge(c: [f64; 2], across: [f64; 2], along: f64) -> f64 {
    let root = |c: f64, t: f64| (c * c - t * t).max(0.0).sqrt();
    let reach = root(c[0], across[0]) + root(c[1], across[1]) - along.abs();
    reach.min(c[0] - across[0].abs()).min(c[1] - across[1].abs())
}

/// Load of an edge beyond its capacity, N: the least sum of what its two ends carry beyond their own,
/// over all splits of the load along it. Unlike the negative margin it changes in proportion to the
/// load where that is at its limit across the edge.
pub fn edge_excess(c: [f64; 2], across: [f64; 2], along: f64) -> f64 {
    if edge(c, across, along) >= 0.0 {
        return 0.0;
    }
    let excess = |first: f64| {
        let carried = [first, along - first];
        (0..2).map(|i| (math::hypot(across[i], carried[i]) - c[i]).max(0.0)).sum::<f64>()
    };
    // Convex in the split.
    let (mut low, mut high) = (0.0, along);
    for _ in 0..100 {
        let third = (high - low) / 3.0;
        if excess(low + third) <= excess(high - third) { high -= third } else { low += third }
    }
    excess(0.5 * (low + high))
}

/// A slip twist of a sole: velocity of its reference point and yaw rate times the sole radius.
pub type Slip = Vector3<f64>;

/// Margin of a face and the twist of least margin.
///
/// The twist points along the load: a sole slips against the friction it carries. `points` gives
/// capacity `c_i` and horizontal position `r_i` (m) of each vertex. `force` (N) and `yaw` (N m,
/// about the reference point) are the load; `radius` (m) scales the yaw rate.
pub fn face(points: &[(f64, Vector2<f64>)], force: &Vector2<f64>, yaw: f64, radius: f64) -> (f64, Slip) {
    let total: f64 = points.iter().map(|p| p.0).sum();
    let size = force.norm();
    let direction = if size > 0.0 { force / size } else { Vector2::x() };
    let mut best = (total - size, Slip::new(direction.x, direction.y, 0.0));
    if best.0 <= 0.0 {
        return best;
    }
    for turn in [1.0, -1.0] {
        // Vertex i moves with v + turn z x r_i / radius = v - p_i.
        let data_point = |r: &Vector2<f64>| Vector2::new(r.y, -r.x) * (turn / radius);
        let cost = |v: &Vector2<f64>| -> f64 {
            points.iter().map(|(c, r)| c * (v - data_point(r)).norm()).sum::<f64>() - force.dot(v) - yaw * turn / radius
        };
        let v = fermat_weber(points, &data_point, force, &cost);
        let margin = cost(&v);
        if margin < best.0 {
            best = (margin, Slip::new(v.x, v.y, turn));
        }
    }
    best
}

/// Whether these tangential forces, one per point, carry the load, each clearly within its
/// capacity.
///
/// If so the margin of the face is positive and need not be computed. If not, other forces may
/// still carry the load.
pub fn carries(
    points: impl IntoIterator<Item = (f64, Vector2<f64>)>,
    tangent: &[Vector2<f64>],
    force: &Vector2<f64>,
    yaw: f64,
    radius: f64,
) -> bool {
    /// Fraction of the capacity that must stay unused, far above rounding.
    const SPARE: f64 = 1e-9;
    let (mut sum, mut turn, mut total) = (-*force, -yaw, 0.0);
    for ((c, r), t) in points.into_iter().zip(tangent) {
        if !(t.norm_squared() <= c * c * (1.0 - SPARE)) {
            return false;
        }
        sum += t;
        turn += r.perp(t);
        total += c;
    }
    sum.norm().max(turn.abs() / radius) <= 1e-3 * SPARE * total
}

/// Writes tangential forces that carry the load: `tangent` and a share of what it lacks,
/// proportional to the capacities times a common translation and rotation field.
pub fn balance(
    points: &[(f64, Vector2<f64>)],
    tangent: &[Vector2<f64>],
    force: &Vector2<f64>,
    yaw: f64,
    out: &mut [Vector2<f64>],
) {
    let (mut total, mut centre) = (0.0, Vector2::zeros());
    let (mut lack, mut lack_yaw) = (*force, yaw);
    for ((c, r), t) in points.iter().zip(tangent) {
        total += c;
        centre += r * *c;
        lack -= t;
        lack_yaw -= r.perp(t);
    }
    centre /= total;
    let spread: f64 = points.iter().map(|(c, r)| c * (r - centre).norm_squared()).sum();
    let shift = lack / total;
    let turn = if spread > 0.0 { (lack_yaw - centre.perp(&lack)) / spread } else { 0.0 };
    for (((c, r), t), out) in points.iter().zip(tangent).zip(out) {
        let d = r - centre;
        *out = t + (shift + Vector2::new(-d.y, d.x) * turn) * *c;
    }
}

/// Minimises `sum c_i |v - p_i| - F . v` over the plane, given `|F| < sum c_i`.
fn fermat_weber(
    points: &[(f64, Vector2<f64>)],
    data_point: &impl Fn(&Vector2<f64>) -> Vector2<f64>,
    force: &Vector2<f64>,
    cost: &impl Fn(&Vector2<f64>) -> f64,
) -> Vector2<f64> {
    // Usually the minimum is smooth and near the weighted mean.
    let total: f64 = points.iter().map(|p| p.0).sum();
    let middle = points.iter().fold(Vector2::zeros(), |sum, (c, r)| sum + data_point(r) * (c / total));
    if let (v, true) = newton(points, data_point, force, cost, middle, 8) {
        return v;
    }
    // A data point is the minimiser if and only if the pull of all others is within its own weight.
    let mut start = Vector2::zeros();
    let mut lowest = f64::INFINITY;
    for (j, (cj, rj)) in points.iter().enumerate() {
        let pj = data_point(rj);
        let mut pull = -*force;
        for (i, (ci, ri)) in points.iter().enumerate() {
            let d = pj - data_point(ri);
            let distance = d.norm();
            if i != j && distance > 0.0 {
                pull += d * (ci / distance);
            }
        }
        if pull.norm() <= *cj {
            return pj;
        }
        let value = cost(&pj);
        if value < lowest {
            lowest = value;
            // Start on the steepest descent from the kink, where the cost is smooth.
            start = pj - pull * (1e-3 / pull.norm());
        }
    }
    newton(points, data_point, force, cost, start, 60).0
}

/// Damped Newton steps from `v`. Returns the last point and whether it is the minimum.
fn newton(
    points: &[(f64, Vector2<f64>)],
    data_point: &impl Fn(&Vector2<f64>) -> Vector2<f64>,
    force: &Vector2<f64>,
    cost: &impl Fn(&Vector2<f64>) -> f64,
    mut v: Vector2<f64>,
    rounds: usize,
) -> (Vector2<f64>, bool) {
    /// Decrease of the cost, relative to the capacity, that rounding hides: full steps are taken
    /// below it.
    const ROUNDED: f64 = 1e-11;
    /// Predicted relative decrease of the last step. Convergence is quadratic, so the remaining
    /// error is its square.
    const LAST: f64 = 1e-18;
    let total: f64 = points.iter().map(|p| p.0).sum();
    for _ in 0..rounds {
        let (mut gradient, mut hessian) = (-*force, Matrix2::zeros());
        for (c, r) in points {
            let d = v - data_point(r);
            let distance = d.norm();
            if distance > 0.0 {
                let u = d / distance;
                gradient += u * *c;
                hessian += (Matrix2::identity() - u * u.transpose()) * (c / distance);
            }
        }
        let damped = hessian + Matrix2::identity() * (1e-14 * hessian.trace());
        let Some(step) = damped.try_inverse().map(|h| h * gradient) else { return (v, false) };
        let decrease = gradient.dot(&step);
        if decrease <= LAST * total {
            return (v - step, true);
        }
        let mut t = 1.0;
        if decrease > ROUNDED * total {
            let here = cost(&v);
            while t > 1e-10 && cost(&(v - step * t)) > here - 1e-4 * t * decrease {
                t *= 0.5;
            }
            if t <= 1e-10 {
                return (v, false);
            }
        }
        v -= step * t;
    }
    (v, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sole of side 0.1 m, mu N = 1 N at each vertex.
    fn square() -> Vec<(f64, Vector2<f64>)> {
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
            .map(|(x, y)| (1.0, Vector2::new(0.05 * x, 0.05 * y)))
            .to_vec()
    }

    const R: f64 = 0.05 * std::f64::consts::SQRT_2;

    #[test]
    fn load_of_an_edge_beyond_its_capacity() {
        // Along, across, and inside.
        assert!((edge_excess([1.0, 2.0], [0.0, 0.0], -3.5) - 0.5).abs() < 1e-15);
        assert!((edge_excess([1.0, 2.0], [1.25, 0.5], 0.0) - 0.25).abs() < 1e-15);
        assert_eq!(edge_excess([1.0, 2.0], [0.6, -1.2], 2.4 * (1.0 - 1e-14)), 0.0);
        // At the limit across one end, a billionth more is a billionth beyond: the other end carries
        // what is along. The margin falls by its root.
        let side = 1.0 + 1e-9;
        assert!((edge_excess([1.0, 1.0], [side, 0.0], 1.0) - 1e-9).abs() < 1e-14);
        assert!((edge_excess([1.0, 1.0], [side, 0.0], 1.0 + 1e-4) - 1e-9).abs() < 1e-7);
        assert!(edge([1.0, 1.0], [1.0 - 1e-9, 0.0], 1.0 + 1e-4) < -5e-5);
    }

    #[test]
    fn limits_of_pure_push_and_pure_twist() {
        for angle in [0.0, 0.3, 1.0, 2.5] {
            let push = Vector2::new(f64::cos(angle), f64::sin(angle));
            assert!(face(&square(), &(push * 3.999_999), 0.0, R).0 > 0.0);
            assert!(face(&square(), &(push * 4.000_001), 0.0, R).0 < 0.0);
        }
        // mu N r, r the vertex radius; bracket 1e-6 relative.
        assert!(face(&square(), &Vector2::zeros(), 4.0 * R * (1.0 - 1e-6), R).0 > 0.0);
        assert!(face(&square(), &Vector2::zeros(), 4.0 * R * (1.0 + 1e-6), R).0 < 0.0);
    }

    #[test]
    fn a_push_of_six_tenths_leaves_704_thousandths_of_the_twist_limit() {
        // 0.6 of the push limit leaves 0.704 of the twist limit (docs/contact.md, section 5, to
        // three digits).
        let (mut lo, mut hi) = (0.0, 1.0);
        for _ in 0..60 {
            let mid = 0.5 * (lo + hi);
            if face(&square(), &Vector2::new(2.4, 0.0), 4.0 * R * mid, R).0 > 0.0 { lo = mid } else { hi = mid }
        }
        assert!((lo - 0.704).abs() < 5e-4, "{lo}");
    }

    #[test]
    fn face_margin_is_the_least_over_a_scan_of_slip_twists() {
        let points = [
            (1.0, Vector2::new(0.06, 0.03)),
            (0.2, Vector2::new(-0.04, 0.03)),
            (2.0, Vector2::new(-0.04, -0.03)),
            (0.7, Vector2::new(0.06, -0.03)),
        ];
        for k in 0..40 {
            let a = k as f64;
            let force = Vector2::new((1.3 * a).sin(), (2.1 * a).cos()) * 2.0;
            let yaw = 0.08 * (0.7 * a).sin();
            let (margin, slip) = face(&points, &force, yaw, 0.07);
            let value = |v: Vector2<f64>, w: f64| -> f64 {
                points.iter().map(|(c, r)| c * (v + Vector2::new(-r.y, r.x) * (w / 0.07)).norm()).sum::<f64>()
                    - force.dot(&v)
                    - yaw * w / 0.07
            };
            if slip.z != 0.0 {
                assert!((value(Vector2::new(slip.x, slip.y), slip.z) - margin).abs() < 1e-12);
            }
            for i in 0..4000 {
                let v = Vector2::new((i as f64 * 0.37).sin(), (i as f64 * 0.53).cos()) * (1.0 + (i % 7) as f64);
                for w in [1.0, -1.0] {
                    assert!(value(v, w) >= margin - 1e-9, "a slip twist with a smaller margin exists");
                }
            }
        }
    }

    #[test]
    fn loads_carried_vertex_by_vertex_have_a_positive_margin() {
        let mut seen = [0, 0];
        for k in 0..2000 {
            let a = k as f64;
            let mut points = square();
            points[1].0 = 0.1 + (1.7 * a).sin().abs();
            points[3].0 = (0.3 * a).cos().abs();
            let size = 1.3 * (0.11 * a).sin().abs();
            let tangent: Vec<_> =
                (0..4).map(|i| Vector2::new((a + i as f64).sin(), (2.3 * a * i as f64).cos()) * size).collect();
            let force: Vector2<f64> = tangent.iter().sum();
            let yaw: f64 = points.iter().zip(&tangent).map(|((_, r), t)| r.perp(t)).sum();
            let carried = carries(points.iter().copied(), &tangent, &force, yaw, R);
            seen[usize::from(carried)] += 1;
            assert!(!carried || face(&points, &force, yaw, R).0 > 0.0, "{k}");
            // The forces do not carry a load that differs from their sum.
            assert!(!carries(points.iter().copied(), &tangent, &force, yaw + 1e-6, R));
            // Balanced forces carry any load.
            let (force, yaw) = (Vector2::new(0.3, -0.1), 0.02);
            let mut balanced = [Vector2::zeros(); 4];
            balance(&points, &tangent, &force, yaw, &mut balanced);
            let sum: Vector2<f64> = balanced.iter().sum();
            let turn: f64 = points.iter().zip(&balanced).map(|((_, r), t)| r.perp(t)).sum();
            assert!((sum - force).norm() < 1e-14 && (turn - yaw).abs() < 1e-15);
        }
        assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
    }

    #[test]
    fn margins_of_an_edge_and_a_vertex() {
        assert!((edge([5.0, 5.0], [3.0, 4.0], 6.9) - 0.1).abs() < 1e-12);
        assert!(edge([5.0, 1.0], [3.0, 1.1], 0.0) < 0.0);
        assert!((vertex(2.0, &Vector2::new(0.6, 0.8)) - 1.0).abs() < 1e-15);
    }
}
