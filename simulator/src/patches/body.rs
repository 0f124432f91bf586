//! Convex bodies with their features, in body frames.
//!
//! A body is a core with a rounding radius r: all points within r of the core. Cores are polyhedra,
//! flat polygons, half-spaces (r = 0 for these), segments and points; for cylinders see `cylinder`. An
//! edge with the unit direction e borders the faces with the outward normals n_0, where it runs counter-clockwise, and
//! n_1. The unit vectors from the edge into these faces are
//!
//! ```text
//! u_0 = n_0 x e        u_1 = e x n_1
//! ```
//!
//! A plane with the normal n through the edge has the body on the side of n if n . u_0 >= 0 and
//! n . u_1 >= 0.

use super::Placement;
use nalgebra::Vector3;

/// Stands for a face that does not exist: the edge of a segment has none.
pub const NO_FACE: u16 = u16::MAX;

/// A flat face.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Indices of vertices, counter-clockwise seen from outside. Empty for half-spaces and cylinders.
    pub corners: Vec<u16>,
    /// Outward unit normal n, body frame.
    pub normal: Vector3<f64>,
    /// n . x of its points x, m.
    pub offset: f64,
    /// Indices of edges; number k runs from corner k to corner k + 1.
    pub edges: Vec<u16>,
    /// Whether the face may own a patch.
    pub touchable: bool,
}

/// A straight edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Indices of vertices.
    pub ends: [u16; 2],
    /// Indices of faces. The edge runs counter-clockwise around the first. [`NO_FACE`] for
    /// segments and cylinders.
    pub faces: [u16; 2],
    /// Whether the edge may own a patch.
    pub touchable: bool,
    /// Unit vector from the first end to the second, body frame.
    pub direction: Vector3<f64>,
    /// Length, m.
    pub length: f64,
    /// Unit vectors u_0, u_1 from the edge into its faces, body frame; zero for segments.
    pub inward: [Vector3<f64>; 2],
}

impl Edge {
    /// Whether it is that of a segment or the axis of a cylinder.
    pub fn has_no_faces(&self) -> bool {
        self.faces[0] == NO_FACE
    }
}

/// A convex body in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexBody {
    /// Vertices of the core, m.
    pub vertices: Vec<Vector3<f64>>,
    /// Faces of the core.
    pub faces: Vec<Face>,
    /// Edges of the core.
    pub edges: Vec<Edge>,
    /// Rounding radius r, m; zero for cores with faces.
    pub rounding: f64,
    /// Radius of a cylinder around edge 0, m. Its vertices are the centres of its ends.
    pub barrel: Option<f64>,
    /// Centre of the bounding sphere, m.
    pub centre: Vector3<f64>,
    /// Radius of the bounding sphere, rounding included, m; infinite for half-spaces.
    pub radius: f64,
    /// Distance of the centre from the nearest face, m; zero without faces.
    pub inner: f64,
}

impl ConvexBody {
    /// A box around the origin. `half`: half the edges' lengths, m.
    pub fn cuboid(half: Vector3<f64>) -> Self {
        let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] });
        let rings = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let face = |(k, ring): (usize, &[u16; 4])| {
            let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
            (ring.to_vec(), Vector3::ith(k / 2, sign))
        };
        let faces = rings.iter().enumerate().map(face).collect();
        // The rings fit together, so there is always a body.
        Self::from_faces((0..8).map(corner).collect(), faces).unwrap_or_else(|| Self::ball(0.0))
    }

    /// A flat convex polygon without thickness. `polygon`: its corners in order, m. Face 0 is the
    /// one around which they are counter-clockwise. `None` for fewer than three corners and for
    /// corners on a line.
    pub fn plate(polygon: &[Vector3<f64>]) -> Option<Self> {
        let first = *polygon.first()?;
        let count = polygon.len();
        let part = |k: usize| (polygon[k] - first).cross(&(polygon[(k + 1) % count] - first));
        let normal = (0..count).map(part).sum::<Vector3<f64>>().try_normalize(0.0)?;
        let ring: Vec<u16> = (0..count as u16).collect();
        let back: Vec<u16> = ring.iter().rev().copied().collect();
        Self::from_faces(polygon.to_vec(), vec![(ring, normal), (back, -normal)])
    }

    /// A ball around the origin. `radius`: m.
    pub fn ball(radius: f64) -> Self {
        let vertices = vec![Vector3::zeros()];
        ConvexBody {
            vertices,
            faces: vec![],
            edges: vec![],
            rounding: radius,
            barrel: None,
            centre: Vector3::zeros(),
            radius,
            inner: 0.0,
        }
    }

    /// A capsule along the z axis, around the origin. `half_length` of its segment and `radius`: m.
    pub fn capsule(half_length: f64, radius: f64) -> Self {
        let edge = Edge {
            ends: [0, 1],
            faces: [NO_FACE; 2],
            touchable: true,
            direction: Vector3::z(),
            length: 2.0 * half_length,
            inward: [Vector3::zeros(); 2],
        };
        ConvexBody {
            vertices: vec![Vector3::z() * -half_length, Vector3::z() * half_length],
            faces: vec![],
            edges: vec![edge],
            rounding: radius,
            barrel: None,
            centre: Vector3::zeros(),
            radius: half_length + radius,
            inner: 0.0,
        }
    }

    /// A point foot. `at`: body frame, m.
    pub fn point(at: Vector3<f64>) -> Self {
        ConvexBody { vertices: vec![at], centre: at, ..Self::ball(0.0) }
    }

    /// A line without thickness between two points, body frame, m; `None` if they are equal.
    pub fn segment(ends: [Vector3<f64>; 2]) -> Option<Self> {
        let along = ends[1] - ends[0];
        let mut body = Self::capsule(0.5 * along.norm(), 0.0);
        body.edges[0].direction = along.try_normalize(0.0)?;
        Some(ConvexBody { vertices: ends.to_vec(), centre: ends[0] + along * 0.5, ..body })
    }

    /// The half-space z <= 0.
    pub fn half_space() -> Self {
        let face = Face { corners: vec![], normal: Vector3::z(), offset: 0.0, edges: vec![], touchable: true };
        ConvexBody {
            vertices: vec![],
            faces: vec![face],
            edges: vec![],
            rounding: 0.0,
            barrel: None,
            centre: Vector3::zeros(),
            radius: f64::INFINITY,
            inner: 0.0,
        }
    }

    /// A polyhedron from its vertices, m, and its faces: corners, counter-clockwise seen from
    /// outside, with unit normals. `None` if the faces do not fit together or edges have no length.
    pub fn from_faces(vertices: Vec<Vector3<f64>>, faces: Vec<(Vec<u16>, Vector3<f64>)>) -> Option<Self> {
        let mut edges: Vec<Edge> = Vec::new();
        let mut built: Vec<Face> = Vec::new();
        for (corners, normal) in faces {
            if corners.len() < 3 || built.len() >= NO_FACE as usize {
                return None;
            }
            let mut sides = Vec::new();
            for (k, &from) in corners.iter().enumerate() {
                let to = corners[(k + 1) % corners.len()];
                sides.push(add_side(&mut edges, &vertices, [from, to], built.len() as u16, &normal)?);
            }
            let sum: f64 = corners.iter().map(|&k| normal.dot(&vertices[k as usize])).sum();
            let offset = sum / corners.len() as f64;
            built.push(Face { corners, normal, offset, edges: sides, touchable: true });
        }
        if edges.iter().any(|edge| edge.faces[1] == NO_FACE) || edges.is_empty() {
            return None;
        }
        let centre = vertices.iter().sum::<Vector3<f64>>() / vertices.len() as f64;
        let radius = vertices.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let depth = |face: &Face| (face.offset - face.normal.dot(&centre)).max(0.0);
        let inner = built.iter().map(depth).fold(f64::INFINITY, f64::min);
        Some(ConvexBody { vertices, faces: built, edges, rounding: 0.0, barrel: None, centre, radius, inner })
    }

    /// Sets whether a face may own patches. Its edges may own patches if one of their faces may.
    pub fn set_touchable(&mut self, face: u16, touchable: bool) {
        self.faces[face as usize].touchable = touchable;
        for edge in self.edges.iter_mut().filter(|edge| edge.faces.contains(&face)) {
            edge.touchable = edge.faces.iter().any(|&f| self.faces[f as usize].touchable);
        }
    }

    /// Sets whether an edge may own patches.
    pub fn set_edge_touchable(&mut self, edge: u16, touchable: bool) {
        self.edges[edge as usize].touchable = touchable;
    }

    /// Whether a vertex may own patches: one of its faces may, or the body has none or is a
    /// cylinder.
    pub fn is_vertex_touchable(&self, vertex: u16) -> bool {
        self.barrel.is_some()
            || self.faces.is_empty()
            || self.faces.iter().any(|face| face.touchable && face.corners.contains(&vertex))
    }

    /// Whether the body is a half-space: a face without corners.
    pub fn is_half_space(&self) -> bool {
        self.vertices.is_empty()
    }

    /// A vertex, body frame, m.
    pub fn vertex(&self, k: u16) -> &Vector3<f64> {
        &self.vertices[k as usize]
    }

    /// An edge.
    pub fn edge(&self, k: u16) -> &Edge {
        &self.edges[k as usize]
    }

    /// A face.
    pub fn face(&self, k: u16) -> &Face {
        &self.faces[k as usize]
    }

    /// Least d . x over the points x of the core, or of a cylinder; `d` in the body frame.
    pub fn least(&self, d: &Vector3<f64>) -> f64 {
        let least = self.vertices.iter().map(|x| d.dot(x)).fold(f64::INFINITY, f64::min);
        self.barrel.map_or(least, |radius| least - radius * self.across(d).norm())
    }

    /// Least and greatest coordinates, world, m.
    pub fn bounds(&self, at: &Placement) -> (Vector3<f64>, Vector3<f64>) {
        let least = |axis: usize, sign: f64| {
            let d = at.rotation.row(axis).transpose() * sign;
            self.least(&d) - self.rounding + sign * at.position[axis]
        };
        (Vector3::from_fn(|axis, _| least(axis, 1.0)), Vector3::from_fn(|axis, _| -least(axis, -1.0)))
    }

    /// Unit vector in a face, into it from its side number `side`; body frame.
    pub fn side_inward(&self, face: u16, side: usize) -> &Vector3<f64> {
        let edge = self.edge(self.face(face).edges[side]);
        &edge.inward[usize::from(edge.faces[0] != face)]
    }
}

/// Adds the side of a face to the edges and returns the index of its edge.
fn add_side(
    edges: &mut Vec<Edge>,
    vertices: &[Vector3<f64>],
    ends: [u16; 2],
    face: u16,
    normal: &Vector3<f64>,
) -> Option<u16> {
    let reversed = |edge: &Edge| edge.ends == [ends[1], ends[0]] && edge.faces[1] == NO_FACE;
    if let Some(k) = edges.iter().position(reversed) {
        let edge = &mut edges[k];
        edge.faces[1] = face;
        edge.inward[1] = edge.direction.cross(normal);
        return Some(k as u16);
    }
    let along = vertices[ends[1] as usize] - vertices[ends[0] as usize];
    let direction = along.try_normalize(0.0)?;
    let inward = [normal.cross(&direction), Vector3::zeros()];
    edges.push(Edge { ends, faces: [face, NO_FACE], touchable: true, direction, length: along.norm(), inward });
    (edges.len() < NO_FACE as usize).then(|| edges.len() as u16 - 1)
}
