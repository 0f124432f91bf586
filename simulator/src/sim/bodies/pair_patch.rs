//! The patch in which a body touches others along one plane, as a polygon of the contact problem.
//!
//! A vertex of the patch is a corner of either body or a crossing of edges. Its geometry, and the terms
//! of its acceleration that points and normals which move bring, are those of [`crate::patches`]. Where a
//! body touches several pieces of terrain in one plane, they have one patch, the convex hull of their
//! polygons: forces on points inside it have the same resultants as forces on its corners. A seam between
//! two pieces thus changes nothing.
//!
//! A static vertex is held at its anchor: the point of each body that was there when it was clamped,
//!
//! ```text
//! e = n gap + t ((x_A + R_A p_A) - (x_B + R_B p_B))
//! ```
//!
//! p_A, p_B are these points in the bodies' frames, and t projects onto the plane. Points of rounded bodies, and
//! of the sides and rims of cylinders, roll and have no anchor.

use super::{Body, Pair};
use crate::dynamics::reduced::Mechanisms;
use crate::geometry::{Plane, convex_hull};
use crate::patches::{self, Corner, CornerMotion, Feature, Owner, PatchGeometry, Placement, Topology};
use nalgebra::{Matrix3, Vector3};

/// Angle, rad, and distance, m, up to which two planes are one.
const COPLANAR: f64 = 1e-9;

/// Distance, m, up to which corners of several parts are one point: twice the resolution of corners.
const SAME_POINT: f64 = 2.0 * patches::RESOLUTION;

/// Distance, m, up to which a crossing is beside an end of its edge, and least slope of an edge that is not level.
const BESIDE: f64 = 1e-6;
const SLOPE: f64 = 1e-4;

/// The points of both bodies, in their frames, at a vertex that was clamped, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Anchor {
    a: Vector3<f64>,
    b: Vector3<f64>,
}

/// The corners that one pair contributes.
#[derive(Clone, Debug)]
pub struct Part {
    /// The pair.
    pub pair: Pair,
    /// Its corners.
    pub topology: Topology,
    /// Whether the body has just slid off the feature that owned the plane before, so that the corners on the
    /// present one may move apart.
    pub opens: bool,
    geometry: PatchGeometry,
    placements: (Placement, Placement),
}

impl Part {
    /// A part at the present kinematics.
    pub fn new(pair: Pair, topology: Topology, bodies: &[Body], mechanisms: Mechanisms) -> Self {
        let (a, b) = (&bodies[pair.bodies.0], &bodies[pair.bodies.1]);
        let placements = (a.placement(mechanisms), b.placement(mechanisms));
        let geometry = PatchGeometry::default();
        let mut part = Part { pair, topology, opens: false, geometry, placements };
        part.update(bodies, mechanisms);
        part
    }

    fn update(&mut self, bodies: &[Body], mechanisms: Mechanisms) {
        let (a, b) = (&bodies[self.pair.bodies.0], &bodies[self.pair.bodies.1]);
        self.placements = (a.placement(mechanisms), b.placement(mechanisms));
        let (pa, pb) = &self.placements;
        patches::geometry(&self.topology, &a.shape, pa, &b.shape, pb, &mut self.geometry);
        if self.pair.links.1.is_none() && matches!(self.topology.owner, Owner::FaceOfB(_)) {
            self.geometry.axes = world_axes(&self.geometry.axes.column(2).into());
        }
    }

    /// Normals and offsets, m, of the planes of the faces of A and B that lie against each other, world.
    fn face_planes(&self, bodies: &[Body]) -> Option<[(Vector3<f64>, f64); 2]> {
        let (of_a, of_b) = match (self.topology.owner, self.topology.incident) {
            (Owner::FaceOfA(k), Some(l)) => (k, l),
            (Owner::FaceOfB(l), Some(k)) => (k, l),
            _ => return None,
        };
        let plane = |body: usize, at: &Placement, k: u16| {
            let face = bodies[body].shape.face(k);
            let normal = at.rotation * face.normal;
            (normal, face.offset + normal.dot(&at.position))
        };
        let (a, b) = self.pair.bodies;
        Some([plane(a, &self.placements.0, of_a), plane(b, &self.placements.1, of_b)])
    }

    /// Normal and a point of its plane, if that is a face of the world.
    pub fn world_plane(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let point = self.geometry.points.first()?;
        let n: Vector3<f64> = self.geometry.axes.column(2).into();
        let is_face = self.pair.links.1.is_none() && matches!(self.topology.owner, Owner::FaceOfB(_));
        is_face.then(|| (n, point.position - n * point.gap))
    }

    /// Whether a corner has a gap of at most `near`, m.
    pub fn touches(&self, corner: usize, near: f64) -> bool {
        self.geometry.points[corner].gap <= near
    }

    /// Whether some corners are apart, and those with a gap of at most `near`, m, are one point up to `size`, m.
    pub fn touches_at_point(&self, near: f64, size: f64) -> bool {
        let mut touching = self.geometry.points.iter().filter(|point| point.gap <= near);
        let Some(first) = touching.next() else { return false };
        let is_open = self.geometry.points.iter().any(|point| point.gap > near);
        is_open && touching.all(|point| (point.position - first.position).norm() <= size)
    }

    /// Least normal velocity of the corners with a gap of at most `near`, m; m/s.
    pub fn opening_speed(&self, near: f64) -> f64 {
        let n = self.geometry.axes.column(2);
        let speeds = self.geometry.points.iter().filter(|point| point.gap <= near).map(|point| n.dot(&point.velocity));
        speeds.fold(f64::INFINITY, f64::min)
    }

    /// Position of a corner, world, m.
    pub fn position(&self, corner: usize) -> &Vector3<f64> {
        &self.geometry.points[corner].position
    }

    /// Whether a vertex at most `BESIDE` away is lower than this corner.
    fn is_above_end(&self, corner: usize) -> bool {
        let points = &self.geometry.points;
        let at = &points[corner];
        let ends = self.topology.corners.iter().zip(points).filter(|(end, _)| !matches!(end, Corner::Crossing { .. }));
        ends.map(|(_, end)| (at.gap - end.gap, (at.position - end.position).norm()))
            .any(|(rise, way)| way <= BESIDE && rise > SLOPE * way)
    }

    /// Whether both have corners in one plane of their common body A with the world.
    fn has_plane_of(&self, other: &Part) -> bool {
        let (Some(plane), Some(others)) = (self.plane(), other.plane()) else { return false };
        self.is_of_one_body(other) && is_one_plane(&plane, &others)
    }

    /// Whether both are of one body A with the world.
    fn is_of_one_body(&self, other: &Part) -> bool {
        let fixed = self.pair.links.1.is_none() && other.pair.links.1.is_none();
        fixed && self.pair.bodies.0 == other.pair.bodies.0
    }

    /// Normal, from B into A, and offset, m, of its plane; `None` without corners.
    fn plane(&self) -> Option<(Vector3<f64>, f64)> {
        let point = self.geometry.points.first()?;
        let n: Vector3<f64> = self.geometry.axes.column(2).into();
        // Corners lie on the body that does not own the plane.
        let gap = if matches!(self.topology.owner, Owner::FaceOfA(_)) { -point.gap } else { point.gap };
        Some((n, n.dot(&point.position) - gap))
    }

    /// Whether both have corners in one plane fixed to the world or to their common body A, and faces of A and of
    /// the others in one plane each: the gaps are then a linear function of the position.
    fn is_coplanar(&self, other: &Part, bodies: &[Body]) -> bool {
        self.has_plane_of(other)
            && match (self.face_planes(bodies), other.face_planes(bodies)) {
                (Some(own), Some(others)) => own.iter().zip(&others).all(|(p, q)| is_one_plane(p, q)),
                (None, None) => self.keeps_plane_of(other, bodies),
                _ => false,
            }
    }

    /// Whether planes that are one now remain one: they are faces, or of the same features. The planes of an edge
    /// of A with two edges of the world turn apart.
    fn keeps_plane_of(&self, other: &Part, bodies: &[Body]) -> bool {
        let is_face = |owner| matches!(owner, Owner::FaceOfA(_) | Owner::FaceOfB(_));
        let (own, others) = (self.topology.owner, other.topology.owner);
        is_face(own) && is_face(others)
            || match (self.world_feature(bodies), other.world_feature(bodies)) {
                (Some((of_a, at, along)), Some((a, point, e))) => {
                    let apart = point - at;
                    let way = apart - along * along.dot(&apart);
                    of_a == a && along.cross(&e).norm() < COPLANAR && way.norm() < COPLANAR
                }
                _ => false,
            }
    }

    /// For owners that are no faces: the feature of A, and a point and the direction of the edge of B, world; the
    /// direction is zero for a vertex of B.
    fn world_feature(&self, bodies: &[Body]) -> Option<(Feature, Vector3<f64>, Vector3<f64>)> {
        let (of_a, of_b) = self.topology.owner.features()?;
        let (b, at) = (&bodies[self.pair.bodies.1].shape, &self.placements.1);
        match of_b {
            Feature::Vertex(k) => Some((of_a, at.point(b.vertex(k)), Vector3::zeros())),
            Feature::Edge(k) => {
                let edge = b.edge(k);
                Some((of_a, at.point(b.vertex(edge.ends[0])), at.rotation * edge.direction))
            }
            Feature::Rim(_) => None,
        }
    }
}

/// Leaves points that several patches with the same plane share to the first of them: forces there are those of one
/// contact. So a face that lies on a peak of a height field meets it once, not once per triangle. A patch that
/// has no other points joins the first.
fn drop_shared_points(patches: &mut Vec<PairPatch>, bodies: &[Body]) {
    let mut p = 1;
    while p < patches.len() {
        let (before, rest) = patches.split_at_mut(p);
        let patch = &mut rest[0];
        let mut owner = None;
        for (k, other) in before.iter().enumerate() {
            if !patch.has_plane_of(other) || !patch.parts[0].keeps_plane_of(&other.parts[0], bodies) {
                continue;
            }
            let (parts, count) = (&patch.parts, patch.vertices.len());
            patch.vertices.retain(|&(part, corner)| {
                let at = &parts[part].geometry.points[corner].position;
                (0..other.len()).all(|i| (other.point(i).position - at).norm() > SAME_POINT)
            });
            if patch.vertices.len() < count {
                owner = owner.or(Some(k));
            }
        }
        match owner.filter(|_| patch.is_empty()) {
            Some(k) => {
                let parts = patches.remove(p).parts;
                patches[k].parts.extend(parts);
            }
            None => p += 1,
        }
    }
}

fn is_one_plane((m, s): &(Vector3<f64>, f64), (n, t): &(Vector3<f64>, f64)) -> bool {
    (m - n).norm() < COPLANAR && (s - t).abs() < COPLANAR
}

/// Axes of a plane of the world with the normal `n`, which depend on nothing else.
fn world_axes(n: &Vector3<f64>) -> Matrix3<f64> {
    let along = if n.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let t = (along - n * n.dot(&along)).normalize();
    Matrix3::from_columns(&[t, n.cross(&t), *n])
}

/// The patch of a body with others in one plane.
#[derive(Clone, Debug)]
pub struct PairPatch {
    /// Name in logs and messages: of both bodies.
    pub name: String,
    /// Pairs that touch in the plane.
    pub parts: Vec<Part>,
    /// Part and corner of each vertex, counter-clockwise about the normal.
    vertices: Vec<(usize, usize)>,
    anchors: Vec<Anchor>,
    rolls: bool,
}

impl PairPatch {
    /// The patches of these parts, in the order of the first of each.
    pub fn merge(parts: Vec<Part>, bodies: &[Body]) -> Vec<Self> {
        let mut patches: Vec<PairPatch> = Vec::new();
        for part in parts {
            match patches.iter_mut().find(|patch| patch.parts[0].is_coplanar(&part, bodies)) {
                Some(patch) => patch.parts.push(part),
                None => patches.push(PairPatch::of(part, bodies)),
            }
        }
        patches.iter_mut().for_each(PairPatch::complete);
        drop_shared_points(&mut patches, bodies);
        patches.iter_mut().for_each(PairPatch::anchor_all);
        patches
    }

    fn of(part: Part, bodies: &[Body]) -> Self {
        let (a, b) = (&bodies[part.pair.bodies.0], &bodies[part.pair.bodies.1]);
        PairPatch {
            name: format!("{} on {}", a.name, b.name),
            rolls: part.topology.rolls(&a.shape, &b.shape),
            parts: vec![part],
            vertices: Vec::new(),
            anchors: Vec::new(),
        }
    }

    /// Chooses the vertices.
    fn complete(&mut self) {
        let corners = |(p, part): (usize, &Part)| (0..part.geometry.points.len()).map(move |c| (p, c));
        self.vertices = self.parts.iter().enumerate().flat_map(corners).collect();
        if self.parts.len() > 1 {
            self.drop_equal_points();
            let plane = Plane { rotation: *self.axes(), point: self.point(0).position };
            let mut hull: Vec<Vector3<f64>> = (0..self.vertices.len()).map(|i| self.point(i).position).collect();
            let positions = hull.clone();
            convex_hull(&mut hull, &plane);
            let index = |p: &Vector3<f64>| positions.iter().position(|q| p == q).map(|i| self.vertices[i]);
            self.vertices = hull.iter().filter_map(index).collect();
        }
    }

    fn anchor_all(&mut self) {
        self.anchors = vec![Anchor::default(); self.vertices.len()];
        (0..self.len()).for_each(|i| self.anchor(i));
    }

    /// Keeps one of several corners at one point, of body A if there is one, else of body B.
    fn drop_equal_points(&mut self) {
        let rank = |&(p, c): &(usize, usize)| match self.parts[p].topology.corners[c] {
            Corner::A(_) => 0,
            Corner::B(_) => 1,
            Corner::Crossing { .. } => 2,
        };
        let mut all = std::mem::take(&mut self.vertices);
        all.sort_by_key(rank);
        for vertex in all {
            let at = |(p, c): (usize, usize)| self.parts[p].geometry.points[c].position;
            let is_new = |known: &(usize, usize)| (at(*known) - at(vertex)).norm() > SAME_POINT;
            if self.vertices.iter().all(is_new) {
                self.vertices.push(vertex);
            }
        }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether it has no vertex.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// World from patch axes; the third column is the normal, from B into A.
    pub fn axes(&self) -> &Matrix3<f64> {
        &self.parts[0].geometry.axes
    }

    /// Position and motion of a vertex.
    pub fn point(&self, i: usize) -> &CornerMotion {
        let (part, corner) = self.vertices[i];
        &self.parts[part].geometry.points[corner]
    }

    /// Whether the part of a vertex opens.
    pub fn opens(&self, i: usize) -> bool {
        self.parts[self.vertices[i].0].opens
    }

    /// Whether a vertex is a crossing of an edge whose lower end has just passed the border: the end is the contact.
    pub fn is_above_end(&self, i: usize) -> bool {
        let (part, corner) = self.vertices[i];
        let part = &self.parts[part];
        matches!(part.topology.corners[corner], Corner::Crossing { .. }) && part.is_above_end(corner)
    }

    /// Whether points of contact move over the bodies without sliding: one of them is round.
    pub fn rolls(&self) -> bool {
        self.rolls
    }

    /// Friction of a vertex.
    pub fn friction(&self, i: usize) -> super::PairFriction {
        self.parts[self.vertices[i].0].pair.friction
    }

    /// Whether it has the plane and the friction of another patch of the same body with the world.
    fn has_plane_of(&self, other: &PairPatch) -> bool {
        let (part, first) = (&self.parts[0], &other.parts[0]);
        part.has_plane_of(first) && part.pair.friction == first.pair.friction
    }

    /// Whether vertex `i` of this patch is the same as vertex `k` of a former one.
    pub fn is_vertex_of(&self, i: usize, former: &PairPatch, k: usize) -> bool {
        let ((p, c), (q, d)) = (self.vertices[i], former.vertices[k]);
        let (part, old) = (&self.parts[p], &former.parts[q]);
        let (corner, before) = (part.topology.corners[c], old.topology.corners[d]);
        if part.pair.bodies == old.pair.bodies {
            return corner == before;
        }
        // A corner of A is one in whatever pieces of terrain it touches; others may be points that pieces share.
        let is_corner = matches!(corner, Corner::A(_)) && corner == before;
        let is_shared = part.is_of_one_body(old) && part.pair.friction == old.pair.friction;
        is_corner || is_shared && (self.point(i).position - former.point(k).position).norm() <= SAME_POINT
    }

    /// Whether a former patch has a pair of this one.
    pub fn continues(&self, former: &PairPatch) -> bool {
        let is_in = |part: &Part| former.parts.iter().any(|old| old.pair.bodies == part.pair.bodies);
        self.parts.iter().any(is_in)
    }

    /// Mean of the vertices, world, m: the reference point of its motion.
    pub fn reference(&self) -> Vector3<f64> {
        (0..self.len()).map(|i| self.point(i).position).sum::<Vector3<f64>>() / self.len().max(1) as f64
    }

    /// Greatest distance of a vertex from the reference point, m; 1 if it is none.
    pub fn radius(&self) -> f64 {
        let centre = self.reference();
        let radius = (0..self.len()).map(|i| (self.point(i).position - centre).norm()).fold(0.0, f64::max);
        if radius > 0.0 { radius } else { 1.0 }
    }

    /// Rate of the relative angular velocity at vertex `i` that the turn of the normal brings,
    /// omega x (n x n'), world, rad/s^2.
    pub fn turning_bias(&self, i: usize) -> Vector3<f64> {
        let (a, b) = &self.parts[self.vertices[i].0].placements;
        let n: Vector3<f64> = self.axes().column(2).into();
        (a.omega - b.omega).cross(&n.cross(&self.point(i).normal_rate))
    }

    /// Updates the geometry to the kinematics.
    pub fn update(&mut self, bodies: &[Body], mechanisms: Mechanisms) {
        self.parts.iter_mut().for_each(|part| part.update(bodies, mechanisms));
    }

    /// Anchors a vertex at its present position.
    pub fn anchor(&mut self, i: usize) {
        let position = self.point(i).position;
        let (a, b) = &self.parts[self.vertices[i].0].placements;
        let local = |placement: &Placement| placement.rotation.tr_mul(&(position - placement.position));
        self.anchors[i] = Anchor { a: local(a), b: local(b) };
    }

    /// Takes over the anchor of vertex `k` of a former patch as that of vertex `i`, if it is the same point.
    pub fn take_anchor(&mut self, i: usize, former: &PairPatch, k: usize) {
        let (part, old) = (&self.parts[self.vertices[i].0], &former.parts[former.vertices[k].0]);
        if part.topology.has_rings_of(&old.topology) {
            self.anchors[i] = former.anchors[k];
        }
    }

    /// Position error of a vertex relative to its anchor, patch axes, m: along the normal its gap.
    pub fn error(&self, i: usize) -> Vector3<f64> {
        let gap = self.point(i).gap;
        if self.rolls {
            return Vector3::new(0.0, 0.0, gap);
        }
        let (pa, pb) = &self.parts[self.vertices[i].0].placements;
        let Anchor { a, b } = &self.anchors[i];
        let apart = self.axes().tr_mul(&(pa.point(a) - pb.point(b)));
        Vector3::new(apart.x, apart.y, gap)
    }
}
