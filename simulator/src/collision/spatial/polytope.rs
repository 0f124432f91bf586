//! A convex polyhedron with its support mapping (the outermost vertex in a direction) and an
//! oriented box around it.
//!
//! ```text
//! support(d) = argmax_k d . p_k
//! ```
//!
//! Every local maximum of a linear function on a convex body is global, so climbing from vertex to
//! neighbour finds it, faster from a closer start. A table of start directions is no faster than
//! starting at the last result. Source: [van den Bergen 2004, section 4.3.4] (after Dobkin and
//! Kirkpatrick; [Cameron 1997]).

use nalgebra::{Point3, Vector3};

use super::oriented_box::OrientedBox;
use crate::geometry::convex_hull_3d;

/// Neighbouring faces whose normals differ by less than this angle, rad, count as one face. A climb
/// that stops at the border of such a face is at most this angle times the size of the body below
/// the maximum: 1e-10 m for a body of 1 m.
const COPLANAR: f64 = 1e-10;

/// A convex polyhedron, in the frame of its vertices.
#[derive(Clone, Debug)]
pub struct Polytope {
    /// Vertices, m.
    pub vertices: Vec<Vector3<f64>>,
    /// Triangles that cover the surface, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// A small box around the vertices.
    pub bounds: OrientedBox,
    /// Neighbours of vertex k are `around[first[k]..first[k + 1]]`.
    first: Vec<u32>,
    around: Vec<u16>,
}

impl Polytope {
    /// The convex hull of points, m; `None` when they are flat, or when it has more than 65 535
    /// vertices.
    pub fn hull(points: &[Vector3<f64>]) -> Option<Self> {
        let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
        let (vertices, triangles) = convex_hull_3d(&points)?;
        Self::new(vertices.iter().map(|p| p.coords).collect(), triangles)
    }

    /// From the vertices and triangles of a convex hull.
    fn new(vertices: Vec<Vector3<f64>>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        u16::try_from(vertices.len()).ok().filter(|n| *n >= 4)?;
        let (first, around) = neighbours(&vertices, &triangles);
        let bounds = OrientedBox::around(&vertices, &triangles);
        Some(Self { vertices, triangles, bounds, first, around })
    }

    /// The outermost vertex in direction `d`, climbing from `start`. `points` are the vertices in
    /// the frame of `d`.
    #[inline]
    pub fn support(&self, points: &[Vector3<f64>], d: &Vector3<f64>, start: u16) -> u16 {
        let mut at = start;
        let mut height = d.dot(&points[at as usize]);
        loop {
            let mut next = at;
            for &k in self.neighbours(at) {
                let h = d.dot(&points[k as usize]);
                if h > height {
                    (next, height) = (k, h);
                }
            }
            if next == at {
                return at;
            }
            at = next;
        }
    }

    #[inline]
    fn neighbours(&self, k: u16) -> &[u16] {
        let k = k as usize;
        &self.around[self.first[k] as usize..self.first[k + 1] as usize]
    }

    /// Whether the point (in the body's frame) is inside, or outside by at most `margin`, m.
    pub fn contains(&self, point: &Vector3<f64>, margin: f64) -> bool {
        self.triangles.iter().all(|t| {
            let [a, b, c] = t.map(|k| self.vertices[k as usize]);
            let normal = (b - a).cross(&(c - a));
            normal.dot(&(point - a)) <= margin * normal.norm()
        })
    }
}

/// Neighbours along the edges of the polyhedron. Diagonals of flat faces are left out, except at
/// vertices that are not corners (inside a face or an edge), where a climb would stop without them.
fn neighbours(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u16>) {
    // Every edge twice, once from each of its triangles, by its lower and upper vertex.
    let mut edges: Vec<([u32; 2], Vector3<f64>)> = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        let [a, b, c] = t.map(|k| vertices[k as usize]);
        let normal = (b - a).cross(&(c - a));
        let normal = normal / normal.norm();
        edges.extend((0..3).map(|i| ([t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3])], normal)));
    }
    edges.sort_by_key(|(ends, _)| *ends);
    let mut all: Vec<Vec<(u16, bool)>> = vec![Vec::new(); vertices.len()];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let bent = |n: &Vector3<f64>| !(n.cross(&same[0].1).norm() < COPLANAR && n.dot(&same[0].1) > 0.0);
        let sharp = same.len() != 2 || bent(&same[1].1);
        let [i, k] = same[0].0;
        all[i as usize].push((k as u16, sharp));
        all[k as usize].push((i as u16, sharp));
    }
    let (mut first, mut around) = (vec![0], Vec::new());
    for list in all {
        let corner = list.iter().filter(|(_, sharp)| *sharp).count() >= 3;
        around.extend(list.iter().filter(|(_, sharp)| *sharp || !corner).map(|(k, _)| *k));
        first.push(around.len() as u32);
    }
    (first, around)
}
