//! Penetration depth of two overlapping convex polyhedra: the shortest translation that separates
//! them.
//!
//! ```text
//! depth = min over unit n of h(n),   h(n) = max { n . x : x in A - B } = n . (s_A(n) - s_B(-n))
//! ```
//!
//! A polytope inside `A - B` that contains the origin grows: its face nearest to the origin, at
//! distance d with normal n, is extended to the vertex of `A - B` farthest along n, until no vertex
//! is beyond it. At every step d is at most the depth, and h(n) at least, since moving A by -h(n) n
//! separates the bodies. Where rounding ends the growth early, the result is the least h(n) found:
//! an upper bound, and still a translation that separates them. Source: [van den Bergen 2001].

use nalgebra::Vector3;

use super::simplex::Simplex;
use super::support_mapping::SupportMapping;

/// Gap between the bounds at convergence, m.
const MEET: f64 = 1e-11;
/// A face is visible from a vertex above its plane by more than this, m.
const ABOVE: f64 = 1e-13;
/// Capacity for vertices, and for all faces created.
const MOST_VERTICES: usize = 256;
const MOST_FACES: usize = 8 * MOST_VERTICES;

/// Scratch, allocated once.
#[derive(Clone, Debug)]
pub struct Epa {
    w: Vec<Vector3<f64>>,
    from: Vec<[u16; 2]>,
    faces: Vec<Face>,
    horizon: Vec<[u16; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [u16; 3],
    normal: Vector3<f64>,
    /// Distance of the plane from the origin, m.
    distance: f64,
}

/// Depth with the deepest points.
#[derive(Clone, Copy, Debug)]
pub struct Depth {
    /// Upper bound, m: the bodies separate when A moves by `-depth * normal`.
    pub depth: f64,
    /// Unit vector pointing out of A.
    pub normal: Vector3<f64>,
    /// A's point deepest in B, m.
    pub on_a: Vector3<f64>,
    /// B's point deepest in A, m: `on_a - depth * normal`.
    pub on_b: Vector3<f64>,
}

impl Default for Epa {
    fn default() -> Self {
        Self {
            w: Vec::with_capacity(MOST_VERTICES),
            from: Vec::with_capacity(MOST_VERTICES),
            faces: Vec::with_capacity(MOST_FACES),
            horizon: Vec::with_capacity(MOST_FACES),
        }
    }
}

impl Epa {
    /// The depth of A in B, from a simplex of `A - B` that contains the origin.
    pub fn depth(&mut self, a: &impl SupportMapping, b: &impl SupportMapping, simplex: &Simplex) -> Depth {
        self.w.clear();
        self.from.clear();
        self.faces.clear();
        for i in 0..simplex.len {
            self.w.push(simplex.w[i]);
            self.from.push([simplex.a[i], simplex.b[i]]);
        }
        if !self.complete(a, b) {
            return touching(a, &self.from[0]);
        }
        for corners in [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] {
            self.add(corners);
        }
        let mut best: Option<(f64, Face)> = None;
        // The outermost vertices of A and B along the last normal are close to the next ones.
        let [mut ia, mut ib] = self.from[0];
        while let Some(nearest) = self.nearest() {
            let face = self.faces[nearest];
            let n = face.normal;
            ia = a.outermost(&n, ia);
            ib = b.outermost(&-n, ib);
            let w = a.vertex(ia) - b.vertex(ib);
            let reach = n.dot(&w);
            if best.as_ref().is_none_or(|(least, _)| reach <= *least) {
                best = Some((reach, face));
            }
            let is_done = reach - face.distance <= MEET || self.from.contains(&[ia, ib]);
            if is_done || self.w.len() == MOST_VERTICES || !self.grow(w, [ia, ib]) {
                break;
            }
        }
        match best {
            Some((depth, face)) => self.deepest_points(a, depth, &face),
            None => touching(a, &self.from[0]),
        }
    }

    fn deepest_points(&self, a: &impl SupportMapping, depth: f64, face: &Face) -> Depth {
        let [p, q, r] = face.corners.map(|k| self.w[k as usize]);
        let normal = (q - p).cross(&(r - p));
        let foot = face.normal * face.distance;
        let weight = |u: &Vector3<f64>, v: &Vector3<f64>| (u - foot).cross(&(v - foot)).dot(&normal);
        let weights = [weight(&q, &r), weight(&r, &p), weight(&p, &q)];
        let whole: f64 = weights.iter().sum();
        let corners = face.corners.map(|k| a.vertex(self.from[k as usize][0]));
        let on_a = corners.iter().zip(weights).map(|(p, l)| p * (l / whole)).sum::<Vector3<f64>>();
        Depth { depth, normal: face.normal, on_a, on_b: on_a - face.normal * depth }
    }

    /// Extends the simplex to a tetrahedron that contains the origin; false when `A - B` is flat.
    fn complete(&mut self, a: &impl SupportMapping, b: &impl SupportMapping) -> bool {
        while self.w.len() < 4 {
            let first = self.w[0];
            let directions: [Vector3<f64>; 3] = match self.w.len() {
                1 => [Vector3::x(), Vector3::y(), Vector3::z()],
                2 => {
                    let along = self.w[1] - first;
                    let (x, y) = across(&along);
                    [x, y, x + y]
                }
                _ => [(self.w[1] - first).cross(&(self.w[2] - first)); 3],
            };
            let mut best = (0.0, first, [0; 2]);
            for d in directions.iter().flat_map(|d| [*d, -d]) {
                let from = [a.outermost(&d, 0), b.outermost(&-d, 0)];
                let w = a.vertex(from[0]) - b.vertex(from[1]);
                let size = self.size(&w);
                if size > best.0 {
                    best = (size, w, from);
                }
            }
            if best.0 < 1e-12 {
                return false;
            }
            self.w.push(best.1);
            self.from.push(best.2);
        }
        // Seen from outside, 0, 1, 2 runs counter-clockwise when 3 is below it.
        let [p, q, r, s] = [self.w[0], self.w[1], self.w[2], self.w[3]];
        if (q - p).cross(&(r - p)).dot(&(s - p)) > 0.0 {
            self.w.swap(1, 2);
            self.from.swap(1, 2);
        }
        true
    }

    /// Distance of a point from the point, line or plane through the given points, m.
    fn size(&self, w: &Vector3<f64>) -> f64 {
        let off = w - self.w[0];
        match self.w.len() {
            1 => off.norm(),
            2 => off.cross(&(self.w[1] - self.w[0]).normalize()).norm(),
            _ => off.dot(&(self.w[1] - self.w[0]).cross(&(self.w[2] - self.w[0])).normalize()).abs(),
        }
    }

    fn nearest(&self) -> Option<usize> {
        let by_distance = |a: &usize, b: &usize| self.faces[*a].distance.total_cmp(&self.faces[*b].distance);
        (0..self.faces.len()).min_by(by_distance).filter(|&i| self.faces[i].distance.is_finite())
    }

    fn add(&mut self, corners: [u16; 3]) {
        let [p, q, r] = corners.map(|k| self.w[k as usize]);
        let normal = (q - p).cross(&(r - p));
        let length = normal.norm();
        // A sliver has no normal: it is never chosen, and no vertex is above it.
        let (normal, distance) =
            if length > 1e-18 { (normal / length, normal.dot(&p) / length) } else { (Vector3::zeros(), f64::INFINITY) };
        self.faces.push(Face { corners, normal, distance });
    }

    /// Adds a vertex: visible faces are removed, and new ones connect it to the border of the hole.
    /// Returns false if rounding has left the hole without a single closed border.
    fn grow(&mut self, w: Vector3<f64>, from: [u16; 2]) -> bool {
        self.horizon.clear();
        let mut i = 0;
        while i < self.faces.len() {
            let face = self.faces[i];
            if face.normal.dot(&w) - face.distance <= ABOVE {
                i += 1;
                continue;
            }
            let [p, q, r] = face.corners;
            for edge in [[p, q], [q, r], [r, p]] {
                // An edge between two removed faces is not part of the border.
                match self.horizon.iter().position(|e| *e == [edge[1], edge[0]]) {
                    Some(at) => drop(self.horizon.swap_remove(at)),
                    None => self.horizon.push(edge),
                }
            }
            self.faces.swap_remove(i);
        }
        let leaves_once = |e: &[u16; 2]| self.horizon.iter().filter(|f| f[0] == e[0]).count() == 1;
        let arrives = |e: &[u16; 2]| self.horizon.iter().any(|f| f[1] == e[0]);
        let is_closed = self.horizon.iter().all(|e| leaves_once(e) && arrives(e));
        if self.horizon.len() < 3 || !is_closed || self.faces.len() + self.horizon.len() > MOST_FACES {
            return false;
        }
        let new = self.w.len() as u16;
        self.w.push(w);
        self.from.push(from);
        for i in 0..self.horizon.len() {
            let [p, q] = self.horizon[i];
            self.add([p, q, new]);
        }
        true
    }
}

/// Two unit vectors across a third and each other.
fn across(along: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let mut least = Vector3::zeros();
    least[along.iamin()] = 1.0;
    let x = along.cross(&least).normalize();
    (x, along.cross(&x).normalize())
}

/// Zero depth: the bodies share one point.
fn touching(a: &impl SupportMapping, from: &[u16; 2]) -> Depth {
    let at = a.vertex(from[0]);
    Depth { depth: 0.0, normal: Vector3::z(), on_a: at, on_b: at }
}
