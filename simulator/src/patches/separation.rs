//! Signed separation of two convex bodies, by a search over the features that can own a plane.
//!
//! Along a unit vector n from B into A the cores are apart by the support distance
//!
//! ```text
//! s(n) = min_A n . x - max_B n . y - r_A - r_B
//! ```
//!
//! Each s(n) is a lower bound of the distance, and the greatest s(n) is the distance, or minus the
//! least depth of an overlap. For polyhedra that overlap or touch the greatest s(n) is at a face of
//! the Minkowski difference A - B: a face of A, a face of B, or a pair of edges. An edge pair with
//! n along e_A x e_B is such a face if both bodies are on their sides of the plane,
//!
//! ```text
//! n . u_A0 > 0,  n . u_A1 > 0,  n . u_B0 < 0,  n . u_B1 < 0
//! ```
//!
//! with the vectors u into the faces of the edges (see `body`). Rounded bodies also need the lines
//! between nearest points: vertex and vertex, vertex and edge. Cylinders also need those of their rims
//! (`curves`); the edges of parallel edges that touch along a segment replace an owner at its end.
//!
//! With the centres at the distance D = c_A - c_B and the distances rho_A, rho_B of the centres from
//! the nearest faces, s(n) <= n . D - rho_A - rho_B - r_A - r_B. Candidates with a bound less than
//! the best separation are skipped. For an edge pair, n lies between the normals of the faces of
//! each edge: at most the angle phi/2 from one of them, where phi is the angle between them.
//!
//! Among candidates within `TIE` the first in the order faces of B, faces of A, edges is the owner.
//! Pairs of nearest points replace them: a ball beyond the border of a face belongs to the edge,
//! although s differs only by the square of the distance from the border.

use super::curves::{Curve, apart, best_normal};
use super::kinematics::plane_normal;
use super::pins::roundings;
use super::roles::relative;
use super::{ConvexBody, Edge, Feature, Owner, Placement, parallel};
use nalgebra::{Matrix3, Vector3};

/// Separations closer than this, m, are equal.
pub const TIE: f64 = 1e-12;

/// An owner must reach the separation up to this, m.
pub(super) const REACH: f64 = 1e-9;

/// Added to bounds against roundoff, m.
const SLACK: f64 = 1e-9;

/// Least sine of the angle between edges that make a plane.
pub(super) const PARALLEL: f64 = 1e-9;

/// Result of `separation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Greatest support distance over all candidates, m: positive when apart, negative when they
    /// overlap. At early returns, that of a separating axis.
    pub distance: f64,
    /// The best candidate that may own a patch; `None` if it is worse than `distance` by 1e-9 m.
    pub owner: Option<Owner>,
    /// Greatest support distance over the candidates that may own a patch, m; minus infinity without any.
    pub touchable: f64,
}

/// Separation of A and B. The search starts with `hint` and ends early with a candidate whose
/// separation is greater than `margin`, m; an infinite margin makes it complete.
pub fn separation(
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    hint: Option<Owner>,
    margin: f64,
) -> Separation {
    let mut search = Search::new(a, pa, b, pb);
    if a.is_half_space() && b.is_half_space() {
        return Separation { distance: f64::NEG_INFINITY, owner: None, touchable: f64::NEG_INFINITY };
    }
    let spheres = (pa.point(&a.centre) - pb.point(&b.centre)).norm() - a.radius - b.radius;
    if spheres > margin {
        return Separation { distance: spheres, owner: None, touchable: spheres };
    }
    if let Some(owner) = hint.filter(|&owner| search.has(owner)) {
        let n = pb.rotation.tr_mul(&plane_normal(owner, a, pa, b, pb));
        let value = search.along(&n);
        if n != Vector3::zeros() && value > margin {
            let owner = Some(owner).filter(|&owner| search.is_touchable(owner));
            return Separation { distance: value, owner, touchable: value };
        }
    }
    if !a.is_half_space() {
        search.faces_of_b();
    }
    if !b.is_half_space() {
        search.faces_of_a();
    }
    if search.distance <= margin {
        search.edges();
        if a.is_round() || b.is_round() {
            search.nearest_points();
        }
        if a.barrel.is_some() || b.barrel.is_some() {
            search.rims();
        }
    }
    let mut found = search.result();
    let is_touchable = |owner: &Owner| search.is_touchable(*owner);
    if let Some(owner) = found.owner {
        let along = parallel::owner(owner, found.touchable, (a, pa), (b, pb)).filter(is_touchable);
        found.owner = Some(along.unwrap_or(owner));
    }
    found
}

/// Depth of an overlap along candidates that may own a patch, m; zero when apart.
pub fn touchable_depth(a: &ConvexBody, pa: &Placement, b: &ConvexBody, pb: &Placement) -> f64 {
    let Separation { distance, touchable, .. } = separation(a, pa, b, pb, None, f64::INFINITY);
    let depth = if touchable.is_finite() { -touchable } else { -distance };
    if distance < 0.0 { depth } else { 0.0 }
}

pub(super) struct Search<'a> {
    a: &'a ConvexBody,
    b: &'a ConvexBody,
    /// Frame of B from frame of A.
    pub r: Matrix3<f64>,
    p: Vector3<f64>,
    /// D in the frame of B.
    between: Vector3<f64>,
    distance: f64,
    /// Separation along the normal of `owner`.
    best: f64,
    owner: Option<Owner>,
}

impl<'a> Search<'a> {
    pub fn new(a: &'a ConvexBody, pa: &Placement, b: &'a ConvexBody, pb: &Placement) -> Self {
        let (r, p) = relative(pb, pa);
        let has_centres = !a.is_half_space() && !b.is_half_space();
        let between = if has_centres { r * a.centre + p - b.centre } else { Vector3::zeros() };
        Search { a, b, r, p, between, distance: f64::NEG_INFINITY, best: f64::NEG_INFINITY, owner: None }
    }

    fn result(&self) -> Separation {
        let rounding = self.a.rounding + self.b.rounding;
        // Without candidates the cores share a point.
        let distance = if self.distance == f64::NEG_INFINITY { -rounding } else { self.distance };
        let owner = self.owner.filter(|_| self.best >= distance - REACH);
        Separation { distance, owner, touchable: self.best }
    }

    /// s(n); `n` in the frame of B.
    pub fn along(&self, n: &Vector3<f64>) -> f64 {
        if self.a.is_half_space() || self.b.is_half_space() {
            return self.along_half_space(n);
        }
        let lowest = self.a.least(&self.r.tr_mul(n)) + n.dot(&self.p);
        lowest + self.b.least(&-n) - self.a.rounding - self.b.rounding
    }

    /// s(n) for n normal to the half-space.
    fn along_half_space(&self, n: &Vector3<f64>) -> f64 {
        if self.b.is_half_space() {
            self.a.least(&self.r.tr_mul(n)) + n.dot(&self.p) - self.a.rounding
        } else {
            self.b.least(&-n) + n.dot(&self.p) - self.b.rounding
        }
    }

    fn has(&self, owner: Owner) -> bool {
        let (a, b) = (self.a, self.b);
        match owner {
            Owner::FaceOfA(i) => (i as usize) < a.faces.len() && !b.is_half_space(),
            Owner::FaceOfB(i) => (i as usize) < b.faces.len() && !a.is_half_space(),
            Owner::Edges(i, j) => (i as usize) < a.edges.len() && (j as usize) < b.edges.len(),
            Owner::VertexVertex(i, j) => (i as usize) < a.vertices.len() && (j as usize) < b.vertices.len(),
            Owner::VertexOfAEdgeOfB(i, j) => (i as usize) < a.vertices.len() && (j as usize) < b.edges.len(),
            Owner::EdgeOfAVertexOfB(i, j) => (i as usize) < a.edges.len() && (j as usize) < b.vertices.len(),
            Owner::Along(i, j) => (i as usize) < a.edges.len() && (j as usize) < b.edges.len(),
            Owner::Curved(of_a, of_b) => has_feature(a, of_a) && has_feature(b, of_b),
        }
    }

    pub fn is_touchable(&self, owner: Owner) -> bool {
        let (a, b) = (self.a, self.b);
        match owner {
            Owner::FaceOfA(i) => a.face(i).touchable,
            Owner::FaceOfB(i) => b.face(i).touchable,
            Owner::Edges(i, j) => a.edge(i).touchable && b.edge(j).touchable,
            Owner::VertexVertex(i, j) => a.is_vertex_touchable(i) && b.is_vertex_touchable(j),
            Owner::VertexOfAEdgeOfB(i, j) => a.is_vertex_touchable(i) && b.edge(j).touchable,
            Owner::EdgeOfAVertexOfB(i, j) => a.edge(i).touchable && b.is_vertex_touchable(j),
            Owner::Along(i, j) => a.edge(i).touchable && b.edge(j).touchable,
            Owner::Curved(of_a, of_b) => is_feature_touchable(a, of_a) && is_feature_touchable(b, of_b),
        }
    }

    /// Takes a candidate into account. It becomes the owner if it is better than the last one by
    /// more than `step`.
    fn offer(&mut self, value: f64, owner: Owner, step: f64) {
        self.distance = self.distance.max(value);
        if (self.owner.is_none() || value > self.best + step) && self.is_touchable(owner) {
            (self.best, self.owner) = (value, Some(owner));
        }
    }

    /// Whether a candidate with this upper bound cannot matter.
    fn is_hopeless(&self, bound: f64, step: f64) -> bool {
        bound <= self.distance && self.owner.is_some() && bound <= self.best + step
    }

    /// Upper bound of s(n); infinite with half-spaces.
    fn bound(&self, n: &Vector3<f64>) -> f64 {
        if self.a.is_half_space() || self.b.is_half_space() {
            return f64::INFINITY;
        }
        n.dot(&self.between) - self.a.inner - self.b.inner - self.a.rounding - self.b.rounding
    }

    fn faces_of_b(&mut self) {
        for (k, face) in self.b.faces.iter().enumerate() {
            if self.is_hopeless(self.bound(&face.normal) + SLACK, TIE) {
                continue;
            }
            let lowest = self.a.least(&self.r.tr_mul(&face.normal)) + face.normal.dot(&self.p);
            self.offer(lowest - face.offset - self.a.rounding, Owner::FaceOfB(k as u16), TIE);
        }
    }

    fn faces_of_a(&mut self) {
        for (k, face) in self.a.faces.iter().enumerate() {
            let m = self.r * face.normal;
            if self.is_hopeless(self.bound(&-m) + SLACK, TIE) {
                continue;
            }
            let lowest = self.b.least(&m) - m.dot(&self.p);
            self.offer(lowest - face.offset - self.b.rounding, Owner::FaceOfA(k as u16), TIE);
        }
    }

    /// Whether an edge can matter by the bound of s(n). `towards`: direction from the centre of its
    /// body to the other centre, D or -D, in the frame of the body.
    fn may_matter(&self, body: &ConvexBody, edge: &Edge, towards: &Vector3<f64>) -> bool {
        if edge.has_no_faces() || self.owner.is_none() {
            return true;
        }
        let [m, o] = edge.faces.map(|k| body.face(k).normal);
        let size = towards.norm();
        let needed = self.distance.min(self.best) - SLACK - self.bound(&Vector3::zeros());
        // n . D >= needed: n is within the angle alpha of D, so a face is within alpha + phi/2.
        let (cos, both) = ((needed / size).clamp(-1.0, 1.0), m.dot(&o).clamp(-1.0, 1.0));
        let (cos_half, sin_half) = (((1.0 + both) / 2.0).sqrt(), ((1.0 - both) / 2.0).sqrt());
        let sin = (1.0 - cos * cos).sqrt();
        let is_all = !(size > SLACK) || sin * cos_half + cos * sin_half <= 0.0;
        let least = (cos * cos_half - sin * sin_half - 1e-6) * size;
        is_all || m.dot(towards).max(o.dot(towards)) >= least
    }

    fn edges(&mut self) {
        let (a, b) = (self.a, self.b);
        let towards = self.r.tr_mul(&-self.between);
        // One bit for each edge of B that may matter; those beyond the last bit all may.
        let mut marks = [0u64; 16];
        for (j, edge) in b.edges.iter().enumerate().take(64 * marks.len()) {
            marks[j / 64] |= u64::from(self.may_matter(b, edge, &self.between)) << (j % 64);
        }
        let has_faces = |body: &ConvexBody| body.edges.first().is_some_and(|edge| !edge.has_no_faces());
        let (has_faces_a, has_faces_b) = (has_faces(a), has_faces(b));
        let rounding = a.edge_rounding() + b.edge_rounding();
        for (i, edge) in a.edges.iter().enumerate() {
            if !self.may_matter(a, edge, &towards) {
                continue;
            }
            let e = self.r * edge.direction;
            let u = edge.inward.map(|u| self.r * u);
            let point = self.r * a.vertex(edge.ends[0]) + self.p;
            for (j, other) in b.edges.iter().enumerate() {
                if marks.get(j / 64).is_some_and(|mark| mark >> (j % 64) & 1 == 0) {
                    continue;
                }
                let cross = e.cross(&other.direction);
                let s = u.map(|u| cross.dot(&u));
                if has_faces_a && !(s[0] * s[1] > 0.0) {
                    continue;
                }
                let t = other.inward.map(|u| -cross.dot(&u));
                if has_faces_b && !(t[0] * t[1] > 0.0 && (!has_faces_a || t[0] * s[0] > 0.0)) {
                    continue;
                }
                let norm = cross.norm();
                let apart = point - b.vertex(other.ends[0]);
                let is_flat = |s: &[f64; 2]| s[0].abs().min(s[1].abs()) <= TIE * norm;
                if norm < PARALLEL || has_faces_a && is_flat(&s) || has_faces_b && is_flat(&t) {
                    continue;
                }
                let reference = match (has_faces_a, has_faces_b) {
                    (true, _) => s[0],
                    (_, true) => t[0],
                    _ => cross.dot(&apart),
                };
                let n = cross * if reference < 0.0 { -1.0 / norm } else { 1.0 / norm };
                if !self.is_hopeless(n.dot(&apart) - rounding, TIE) {
                    let value = self.along(&n);
                    self.offer(value, Owner::Edges(i as u16, j as u16), TIE);
                }
            }
        }
    }

    /// Candidate n along `apart`, from a point of B to a point of A, if both bodies are on their
    /// sides of it. An owner that is a pair of nearest points replaces others unless it is worse.
    fn offer_points(&mut self, apart: &Vector3<f64>, owner: Owner) {
        let norm = apart.norm();
        let [r_a, r_b] = roundings(owner, self.a, self.b);
        let value = norm - r_a - r_b;
        if norm < TIE || self.is_hopeless(value, -TIE) {
            return;
        }
        let full = self.along(&(apart / norm));
        if full >= value - TIE {
            self.offer(full, owner, -TIE);
        }
    }

    fn nearest_points(&mut self) {
        let (a, b) = (self.a, self.b);
        // The points on the axis of a cylinder are no vertices.
        let vertices = |body: &'_ ConvexBody| if body.barrel.is_some() { 0 } else { body.vertices.len() };
        let (of_a, of_b) = (vertices(a), vertices(b));
        for (i, x) in a.vertices.iter().enumerate().take(of_a) {
            let x = self.r * x + self.p;
            for (j, edge) in b.edges.iter().enumerate() {
                let from = x - b.vertex(edge.ends[0]);
                let t = edge.direction.dot(&from);
                if t > 0.0 && t < edge.length {
                    self.offer_points(&(from - edge.direction * t), Owner::VertexOfAEdgeOfB(i as u16, j as u16));
                }
            }
        }
        for (i, edge) in a.edges.iter().enumerate() {
            let (e, start) = (self.r * edge.direction, self.r * a.vertex(edge.ends[0]) + self.p);
            for (j, y) in b.vertices.iter().enumerate().take(of_b) {
                let s = e.dot(&(y - start));
                if s > 0.0 && s < edge.length {
                    self.offer_points(&(start + e * s - y), Owner::EdgeOfAVertexOfB(i as u16, j as u16));
                }
            }
        }
        for (i, x) in a.vertices.iter().enumerate().take(of_a) {
            let x = self.r * x + self.p;
            for (j, y) in b.vertices.iter().enumerate().take(of_b) {
                self.offer_points(&(x - y), Owner::VertexVertex(i as u16, j as u16));
            }
        }
    }

    /// Nearest points of rims and other features.
    fn rims(&mut self) {
        if self.a.is_half_space() || self.b.is_half_space() {
            return;
        }
        let (a, b) = (self.a, self.b);
        let towards = self.r.tr_mul(&-self.between);
        for of_a in features(a) {
            if !self.feature_may_matter(a, of_a, &towards) {
                continue;
            }
            let curve_a = Curve::new(a, of_a, &self.r, &self.p);
            for of_b in features(b) {
                let is_rim = |feature: &Feature| matches!(feature, Feature::Rim(_));
                let has_rim = is_rim(&of_a) || is_rim(&of_b);
                if has_rim && self.feature_may_matter(b, of_b, &self.between) {
                    let curve_b = Curve::new(b, of_b, &Matrix3::identity(), &Vector3::zeros());
                    self.offer_curves((of_a, &curve_a), (of_b, &curve_b));
                }
            }
        }
    }

    fn feature_may_matter(&self, body: &ConvexBody, feature: Feature, towards: &Vector3<f64>) -> bool {
        match feature {
            Feature::Edge(k) => self.may_matter(body, body.edge(k), towards),
            _ => true,
        }
    }

    /// Candidate n of two features, if both bodies are on their sides of it. Features whose points are between
    /// the ends of edges replace other owners unless they are worse: a rim that leaves a face has a normal that
    /// turns, and s differs only by the square of the distance from the border.
    fn offer_curves(&mut self, (of_a, curve_a): (Feature, &Curve), (of_b, curve_b): (Feature, &Curve)) {
        let n = best_normal(curve_a, curve_b);
        if n == Vector3::zeros() {
            return;
        }
        let d = apart(curve_a, curve_b, &n);
        let rounding = self.a.feature_rounding(of_a) + self.b.feature_rounding(of_b);
        let value = n.dot(&d) - rounding;
        let is_on = |body: &ConvexBody, feature: Feature, along: f64| match feature {
            Feature::Edge(k) => along > 0.0 && along < body.edge(k).length,
            _ => true,
        };
        let is_between = is_on(self.a, of_a, -curve_a.axis.dot(&d)) && is_on(self.b, of_b, curve_b.axis.dot(&d));
        let step = if is_between { -TIE } else { TIE };
        // Beyond the ends of rounded edges their vertices have other normals.
        if self.is_hopeless(value, step) || !is_between && rounding > 0.0 {
            return;
        }
        let full = self.along(&n);
        if full >= value - TIE {
            self.offer(full, Owner::Curved(of_a, of_b), step);
        }
    }
}

/// Features that can touch a rim: rims, edges, and vertices of rounded bodies.
fn features(body: &ConvexBody) -> impl Iterator<Item = Feature> {
    let is_barrel = body.barrel.is_some();
    let rims = (0..if is_barrel { 2 } else { 0 }).map(Feature::Rim);
    let vertices = if body.rounding > 0.0 { body.vertices.len() } else { 0 };
    rims.chain((0..body.edges.len() as u16).map(Feature::Edge)).chain((0..vertices as u16).map(Feature::Vertex))
}

fn has_feature(body: &ConvexBody, feature: Feature) -> bool {
    match feature {
        Feature::Vertex(k) => (k as usize) < body.vertices.len(),
        Feature::Edge(k) => (k as usize) < body.edges.len(),
        Feature::Rim(k) => k < 2 && body.barrel.is_some(),
    }
}

fn is_feature_touchable(body: &ConvexBody, feature: Feature) -> bool {
    match feature {
        Feature::Vertex(k) => body.is_vertex_touchable(k),
        Feature::Edge(k) => body.edge(k).touchable,
        Feature::Rim(_) => true,
    }
}
