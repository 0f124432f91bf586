//! Tests of the patches: closed forms, oracles, finite differences, events.

mod cylinder_events;
mod cylinders;
mod events;
mod oracle;
mod rates;
mod shapes;
mod ties;

use super::*;
use nalgebra::Rotation3;

/// Uniform numbers from a linear congruential generator.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678)
    }

    /// In [-1, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.next())
    }

    /// Uniform enough on the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = self.vector();
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    pub fn placement(&mut self) -> Placement {
        let rotation = turn(self.vector() * 3.0);
        Placement { rotation, position: self.vector(), velocity: self.vector(), omega: self.vector() }
    }

    /// Hull of points on a sphere with the radius 1.
    pub fn hull(&mut self, count: usize) -> ConvexBody {
        let points: Vec<_> = (0..count).map(|_| self.direction()).collect();
        ConvexBody::from_points(&points).unwrap()
    }

    pub fn cuboid(&mut self) -> ConvexBody {
        ConvexBody::cuboid(self.vector().map(|x| 0.6 + 0.4 * x))
    }
}

/// Rotation by a vector of angles, rad.
pub fn turn(v: Vector3<f64>) -> Matrix3<f64> {
    Rotation3::new(v).into_inner()
}

pub fn at(rotation: Matrix3<f64>, x: f64, y: f64, z: f64) -> Placement {
    Placement::at_rest(rotation, Vector3::new(x, y, z))
}

pub fn level(x: f64, y: f64, z: f64) -> Placement {
    at(Matrix3::identity(), x, y, z)
}

pub fn swap(owner: Owner) -> Owner {
    match owner {
        Owner::FaceOfA(k) => Owner::FaceOfB(k),
        Owner::FaceOfB(k) => Owner::FaceOfA(k),
        Owner::Edges(i, j) => Owner::Edges(j, i),
        Owner::VertexVertex(i, j) => Owner::VertexVertex(j, i),
        Owner::VertexOfAEdgeOfB(i, j) => Owner::EdgeOfAVertexOfB(j, i),
        Owner::EdgeOfAVertexOfB(i, j) => Owner::VertexOfAEdgeOfB(j, i),
        Owner::Curved(i, j) => Owner::Curved(j, i),
        Owner::Along(i, j) => Owner::Along(j, i),
    }
}

/// A pair of bodies with their placements.
#[derive(Clone)]
pub struct Pair {
    pub a: ConvexBody,
    pub pa: Placement,
    pub b: ConvexBody,
    pub pb: Placement,
}

impl Pair {
    pub fn new(a: &ConvexBody, pa: Placement, b: &ConvexBody, pb: Placement) -> Self {
        Pair { a: a.clone(), pa, b: b.clone(), pb }
    }

    pub fn swapped(&self) -> Self {
        Pair { a: self.b.clone(), pa: self.pb, b: self.a.clone(), pb: self.pa }
    }

    pub fn separation(&self) -> Separation {
        separation(&self.a, &self.pa, &self.b, &self.pb, None, f64::INFINITY)
    }

    pub fn topology(&self, owner: Owner, near: f64) -> Topology {
        let mut out = Topology::new();
        assert!(topology(&self.a, &self.pa, &self.b, &self.pb, near, owner, None, &mut out), "{owner:?}");
        out
    }

    pub fn geometry(&self, topology: &Topology) -> PatchGeometry {
        let mut out = PatchGeometry::new();
        geometry(topology, &self.a, &self.pa, &self.b, &self.pb, &mut out);
        out
    }

    pub fn validity(&self, topology: &Topology) -> f64 {
        validity(topology, &self.a, &self.pa, &self.b, &self.pb, 1.0)
    }

    /// Moves A along the normal until the separation is zero, and returns the owner.
    pub fn touch(&mut self) -> Owner {
        for _ in 0..50 {
            let found = self.separation();
            let owner = found.owner.unwrap();
            if found.distance.abs() < 1e-14 {
                break;
            }
            let n = kinematics::plane_normal(owner, &self.a, &self.pa, &self.b, &self.pb);
            self.pa.position -= n * found.distance;
        }
        self.separation().owner.unwrap()
    }

    /// Turns and shifts both bodies, and their velocities, as one rigid body.
    pub fn moved(&self, rotation: &Matrix3<f64>, shift: &Vector3<f64>) -> Self {
        let move_one = |p: &Placement| Placement {
            rotation: rotation * p.rotation,
            position: rotation * p.position + shift,
            velocity: rotation * p.velocity,
            omega: rotation * p.omega,
        };
        Pair { pa: move_one(&self.pa), pb: move_one(&self.pb), ..self.clone() }
    }
}
