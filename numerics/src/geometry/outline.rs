//! Convex outlines of planar point sets in space.

use crate::math;
use nalgebra::Vector3;

/// Convex outline of points seen along `up`, counter-clockwise. Its vertices are given points;
/// repeated points and points on an edge are left out. Equal points give one vertex, collinear
/// points two.
pub fn convex_outline(points: &[Vector3<f64>], up: &Vector3<f64>) -> Vec<Vector3<f64>> {
    // The view's axes are the body axes nearest to level ones, so that the first vertex does not
    // depend on rounding.
    let helper = if up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let across = (helper - up * up.dot(&helper)).normalize();
    let along = up.cross(&across);
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let tolerance = 1e-9 * size;
    let mut flat: Vec<(f64, f64, Vector3<f64>)> = points.iter().map(|p| (across.dot(p), along.dot(p), *p)).collect();
    let snap = |x: f64| if tolerance > 0.0 { (x / tolerance).round() } else { x };
    flat.sort_by(|a, b| snap(a.0).total_cmp(&snap(b.0)).then(a.1.total_cmp(&b.1)));
    flat.dedup_by(|a, b| math::hypot(a.0 - b.0, a.1 - b.1) <= tolerance);
    if flat.len() < 3 {
        return flat.into_iter().map(|p| p.2).collect();
    }
    // Andrew's monotone chain [Andrew 1979]: lower, then upper outline.
    let turn =
        |a: &(f64, f64, _), b: &(f64, f64, _), c: &(f64, f64, _)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let chain = |order: &mut dyn Iterator<Item = &(f64, f64, Vector3<f64>)>| {
        let mut chain: Vec<(f64, f64, Vector3<f64>)> = Vec::new();
        for p in order {
            while chain.len() > 1 && turn(&chain[chain.len() - 2], &chain[chain.len() - 1], p) <= tolerance * size {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut outline = chain(&mut flat.iter());
    outline.extend(chain(&mut flat.iter().rev()));
    outline.into_iter().map(|p| p.2).collect()
}

/// Drops the vertices that enclose the least area until at most `max_vertices` are left.
pub fn simplify(mut outline: Vec<Vector3<f64>>, max_vertices: usize) -> Vec<Vector3<f64>> {
    while outline.len() > max_vertices.max(3) {
        let n = outline.len();
        let area = |i: usize| {
            let (a, b, c) = (outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n]);
            (b - a).cross(&(c - a)).norm()
        };
        let least = (0..n).min_by(|&i, &j| area(i).total_cmp(&area(j))).unwrap_or(0);
        outline.remove(least);
    }
    outline
}

/// The greatest distance between two vertices, and these vertices.
pub fn diameter(outline: &[Vector3<f64>]) -> (f64, [Vector3<f64>; 2]) {
    let pairs = outline.iter().enumerate().flat_map(|(i, a)| outline[i + 1..].iter().map(move |b| [*a, *b]));
    let length = |[a, b]: &[Vector3<f64>; 2]| (b - a).norm();
    let none = outline.first().copied().unwrap_or_default();
    pairs.max_by(|a, b| length(a).total_cmp(&length(b))).map_or((0.0, [none; 2]), |pair| (length(&pair), pair))
}

/// The least width of a convex outline seen along `up`: over its edges, the distance of the
/// furthest vertex.
pub fn width(outline: &[Vector3<f64>], up: &Vector3<f64>) -> f64 {
    let n = outline.len();
    let off_edge = |i: usize| {
        let edge = outline[(i + 1) % n] - outline[i];
        let inward = up.cross(&edge).normalize();
        outline.iter().map(|p| inward.dot(&(p - outline[i]))).fold(0.0, f64::max)
    };
    if n < 3 { 0.0 } else { (0..n).map(off_edge).fold(f64::INFINITY, f64::min) }
}
