//! Polyhedra from convex hulls: merges coplanar triangles to polygons.
//!
//! Vertices within `COPLANAR` times the size of the hull of the plane of a triangle belong to its
//! face. The corners of the face are those of their outline. Large triangles come first, as their
//! planes are the best known.
//!
//! Where points are coplanar up to about this tolerance such faces may not fit together. Then the faces are
//! groups of adjacent triangles within the tolerance of the plane of their largest one.

use super::ConvexBody;
use nalgebra::{Vector2, Vector3};
use std::collections::{HashMap, HashSet};

/// Distance from the plane of a face, relative to the size of the hull.
const COPLANAR: f64 = 1e-9;

impl ConvexBody {
    /// A polyhedron from the vertices, m, and triangles of a convex hull, counter-clockwise seen
    /// from outside. Coplanar triangles become one face. `None` if the triangles do not close.
    pub fn from_hull(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Option<Self> {
        let first = *vertices.first()?;
        let size = vertices.iter().map(|p| (p - first).norm()).fold(0.0, f64::max);
        let area = |t: &[u32; 3]| area(vertices, t);
        let mut faces: Vec<(Vec<u16>, Vector3<f64>)> = Vec::new();
        for triangle in by_area(vertices, triangles) {
            let is_known = |ring: &[u16]| triangle.iter().all(|&k| ring.contains(&(k as u16)));
            if faces.iter().any(|(ring, _)| is_known(ring)) {
                continue;
            }
            let Some(normal) = area(triangle).try_normalize(0.0) else { continue };
            let origin = vertices[triangle[0] as usize];
            let on_plane = |k: &u16| normal.dot(&(vertices[*k as usize] - origin)).abs() <= COPLANAR * size;
            let mut ring: Vec<u16> = (0..vertices.len() as u16).filter(on_plane).collect();
            let all = ring.clone();
            outline(&mut ring, vertices, &normal, size);
            let is_repeated = faces.iter().any(|(known, n)| n.dot(&normal) > 0.0 && all_in(&ring, known));
            if ring.len() > 2 && all.len() > 2 && !is_repeated {
                faces.push((ring, normal));
            }
        }
        let adjacent = || compact(vertices, merge_adjacent(vertices, triangles, COPLANAR * size)?);
        compact(vertices, faces).or_else(adjacent).or_else(|| {
            let face = |t: &[u32; 3]| Some((t.map(|k| k as u16).to_vec(), area(t).try_normalize(0.0)?));
            compact(vertices, triangles.iter().filter_map(face).collect())
        })
    }

    /// The convex hull of points, m; `None` for points without volume. Points that are equal up to
    /// rounding count once. For set-up and tests: the effort grows with the square of the number of
    /// points.
    pub fn from_points(points: &[Vector3<f64>]) -> Option<Self> {
        let points = distinct(points);
        let triangles = convex_hull(&points)?;
        Self::from_hull(&points, &triangles)
    }
}

/// Points without those nearer to an earlier one than the resolution of planes. Two corners at one
/// place would make edges without a direction.
fn distinct(points: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let mut kept: Vec<Vector3<f64>> = Vec::with_capacity(points.len());
    for p in points {
        if kept.iter().all(|q| (p - q).norm() > COPLANAR * size) {
            kept.push(*p);
        }
    }
    kept
}

/// Normal of a triangle with the length of twice its area, m^2.
fn area(vertices: &[Vector3<f64>], triangle: &[u32; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|k| vertices[k as usize]);
    (b - a).cross(&(c - a))
}

/// Large triangles first.
fn by_area<'a>(vertices: &[Vector3<f64>], triangles: &'a [[u32; 3]]) -> Vec<&'a [u32; 3]> {
    let size = |t: &[u32; 3]| area(vertices, t).norm_squared();
    let mut order: Vec<&[u32; 3]> = triangles.iter().collect();
    order.sort_by(|s, t| size(t).total_cmp(&size(s)));
    order
}

/// Directed sides of a triangle.
fn sides(t: &[u32; 3]) -> [[u32; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

/// Faces of groups of adjacent triangles, with their normals. `None` if an outline does not close.
fn merge_adjacent(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    tolerance: f64,
) -> Option<Vec<(Vec<u16>, Vector3<f64>)>> {
    let mut order = by_area(vertices, triangles);
    let mut faces = Vec::new();
    while let Some(&&largest) = order.first() {
        let normal = area(vertices, &largest).try_normalize(0.0)?;
        let origin = vertices[largest[0] as usize];
        let is_flat = |t: &[u32; 3]| t.iter().all(|k| normal.dot(&(vertices[*k as usize] - origin)).abs() <= tolerance);
        let mut group: Vec<[u32; 2]> = Vec::new();
        let mut grows = true;
        while grows {
            let before = order.len();
            order.retain(|t| {
                let is_adjacent = group.is_empty() || sides(t).iter().any(|[a, b]| group.contains(&[*b, *a]));
                let joins = is_adjacent && is_flat(t);
                if joins {
                    group.extend(sides(t));
                }
                !joins
            });
            grows = order.len() < before;
        }
        let outline: Vec<[u32; 2]> = group.iter().filter(|s| !group.contains(&[s[1], s[0]])).copied().collect();
        let mut ring = vec![outline.first()?[0]];
        while ring.len() < outline.len() {
            ring.push(outline.iter().find(|s| Some(&s[0]) == ring.last())?[1]);
        }
        faces.push((ring.into_iter().map(|k| k as u16).collect::<Vec<u16>>(), normal));
    }
    // Vertices of two faces only are on their common edge.
    let count = |k: u16| faces.iter().filter(|(ring, _)| ring.contains(&k)).count();
    let inner: Vec<u16> = (0..vertices.len() as u16).filter(|k| count(*k) == 2).collect();
    faces.iter_mut().for_each(|(ring, _)| ring.retain(|k| !inner.contains(k)));
    Some(faces)
}

fn all_in(ring: &[u16], known: &[u16]) -> bool {
    ring.iter().all(|k| known.contains(k))
}

/// A body from faces; vertices without a face are dropped.
fn compact(vertices: &[Vector3<f64>], mut faces: Vec<(Vec<u16>, Vector3<f64>)>) -> Option<ConvexBody> {
    let is_used = |k: &usize| faces.iter().any(|(ring, _)| ring.contains(&(*k as u16)));
    let used: Vec<usize> = (0..vertices.len()).filter(is_used).collect();
    for k in faces.iter_mut().flat_map(|(ring, _)| ring) {
        *k = used.binary_search(&(*k as usize)).ok()? as u16;
    }
    ConvexBody::from_faces(used.into_iter().map(|k| vertices[k]).collect(), faces)
}

/// Replaces coplanar points by the corners of their outline, counter-clockwise about `normal`.
fn outline(ring: &mut Vec<u16>, vertices: &[Vector3<f64>], normal: &Vector3<f64>, size: f64) {
    let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let up = normal.cross(&across);
    let flat = |k: u16| Vector2::new(across.dot(&vertices[k as usize]), up.dot(&vertices[k as usize]));
    ring.sort_by(|&s, &t| flat(s).x.total_cmp(&flat(t).x).then(flat(s).y.total_cmp(&flat(t).y)));
    let points = std::mem::take(ring);
    let mut half = |points: &mut dyn Iterator<Item = u16>| {
        let start = ring.len();
        for k in points {
            while ring.len() >= start + 2 {
                let (o, p) = (flat(ring[ring.len() - 2]), flat(ring[ring.len() - 1]));
                if (p - o).perp(&(flat(k) - p)) > COPLANAR * size * (flat(k) - o).norm() {
                    break;
                }
                ring.pop();
            }
            ring.push(k);
        }
        ring.pop();
    };
    half(&mut points.iter().copied());
    half(&mut points.iter().rev().copied());
}

/// Triangles of the convex hull, by adding one point after the other. Each removes the triangles that it sees, as
/// far as they are connected with the one that it sees best, and makes a cone over their horizon. Nearly coplanar
/// points may leave a horizon that is no single ring; then the point is above fewer triangles, or, as
/// it is hardly outside, left out.
fn convex_hull(points: &[Vector3<f64>]) -> Option<Vec<[u32; 3]>> {
    let farthest =
        |f: &dyn Fn(&Vector3<f64>) -> f64| (0..points.len()).max_by(|&i, &j| f(&points[i]).total_cmp(&f(&points[j])));
    let a = 0;
    let b = farthest(&|p| (p - points[a]).norm_squared())?;
    let along = points[b] - points[a];
    let c = farthest(&|p| along.cross(&(p - points[a])).norm_squared())?;
    let normal = along.cross(&(points[c] - points[a])).try_normalize(0.0)?;
    let d = farthest(&|p| normal.dot(&(p - points[a])).abs())?;
    let height = normal.dot(&(points[d] - points[a]));
    let tolerance = OUTSIDE * along.norm();
    if height.abs() <= tolerance {
        return None;
    }
    let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
    let [a, b, c, d] = [a, b, c, d].map(|k| k as u32);
    let triangle = |corners: [u32; 3]| {
        let normal = area(points, &corners).try_normalize(0.0).unwrap_or_default();
        Triangle { corners, normal }
    };
    let mut triangles = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(triangle).to_vec();
    for k in 0..points.len() as u32 {
        let height = |t: &Triangle| t.normal.dot(&(points[k as usize] - points[t.corners[0] as usize]));
        let heights: Vec<f64> = triangles.iter().map(height).collect();
        let Some(best) = (0..heights.len()).max_by(|&i, &j| heights[i].total_cmp(&heights[j])) else { continue };
        let mut above = tolerance;
        while heights[best] > above {
            let seen = connected(&triangles, best, |t| heights[t] > above);
            if let Some(horizon) = horizon(&triangles, &seen) {
                let mut seen = seen.into_iter();
                triangles.retain(|_| seen.next() == Some(false));
                triangles.extend(horizon.iter().map(|s| triangle([s[0], s[1], k])));
                break;
            }
            above *= 10.0;
        }
    }
    Some(triangles.into_iter().map(|t| t.corners).collect())
}

/// Height above a triangle, relative to the size of the hull, from which a point is outside.
const OUTSIDE: f64 = 1e-12;

#[derive(Clone)]
struct Triangle {
    corners: [u32; 3],
    normal: Vector3<f64>,
}

/// Flags of the triangles of a set that are connected with the first one across their sides.
fn connected(triangles: &[Triangle], first: usize, is_in: impl Fn(usize) -> bool) -> Vec<bool> {
    let members: Vec<usize> = (0..triangles.len()).filter(|&t| is_in(t)).collect();
    let of_side: HashMap<[u32; 2], usize> =
        members.iter().flat_map(|&t| sides(&triangles[t].corners).map(|side| (side, t))).collect();
    let mut found = vec![false; triangles.len()];
    let mut open = vec![first];
    found[first] = true;
    while let Some(t) = open.pop() {
        for [p, q] in sides(&triangles[t].corners) {
            if let Some(&next) = of_side.get(&[q, p]).filter(|&&next| !found[next]) {
                found[next] = true;
                open.push(next);
            }
        }
    }
    found
}

/// Directed sides around a set of triangles; `None` unless they are one ring.
fn horizon(triangles: &[Triangle], set: &[bool]) -> Option<Vec<[u32; 2]>> {
    let members = triangles.iter().zip(set).filter(|(_, is_in)| **is_in).map(|(t, _)| t);
    let all: Vec<[u32; 2]> = members.flat_map(|t| sides(&t.corners)).collect();
    let known: HashSet<[u32; 2]> = all.iter().copied().collect();
    let ring: Vec<[u32; 2]> = all.into_iter().filter(|s| !known.contains(&[s[1], s[0]])).collect();
    let next: HashMap<u32, u32> = ring.iter().map(|s| (s[0], s[1])).collect();
    let first = ring.first()?[0];
    let (mut at, mut length) = (*next.get(&first)?, 1);
    while at != first && length <= ring.len() {
        (at, length) = (*next.get(&at)?, length + 1);
    }
    (next.len() == ring.len() && length == ring.len()).then_some(ring)
}
