//! The sole vertices that a robot stands on, from its kinematics.

use crate::dynamics::{State, Workspace};
use crate::geometry::{Plane, convex_hull, stable_point};
use crate::robot::{Model, SoleId};
use crate::task::SensorReadings;
use nalgebra::{Rotation3, Vector3};

/// One vertex that may bear load.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Foothold {
    /// The sole.
    pub sole: SoleId,
    /// Point of contact forces, world, m.
    pub point: Vector3<f64>,
    /// Unit normal of the sole towards the robot, world.
    pub normal: Vector3<f64>,
}

/// The vertices that may bear load at one instant.
#[derive(Clone, Debug)]
pub struct Stance {
    soles: Vec<SoleId>,
    /// The vertices that may bear load.
    pub footholds: Vec<Foothold>,
    /// Mean of all vertices of the soles, loaded or not, world, m.
    pub centre: Vector3<f64>,
}

impl Stance {
    /// For a robot that stands on `soles`.
    pub fn new(model: &Model, soles: Vec<SoleId>) -> Self {
        let points = soles.iter().map(|s| model.soles[s.0].vertices.len() + SensorReadings::CORNERS).sum();
        Stance { soles, footholds: Vec::with_capacity(points), centre: Vector3::zeros() }
    }

    /// The soles.
    pub fn soles(&self) -> &[SoleId] {
        &self.soles
    }

    /// Updates the vertices to the kinematics `ws`, moved towards the middle of their sole by the
    /// fraction `margin` of their distance from it. With `sensed` only vertices in contact count.
    /// `up` is the normal of soles without area.
    pub fn update(
        &mut self,
        model: &Model,
        ws: &Workspace,
        margin: f64,
        sensed: Option<&SensorReadings>,
        up: &Vector3<f64>,
    ) {
        self.footholds.clear();
        let (mut sum, mut count) = (Vector3::zeros(), 0.0);
        for &id in &self.soles {
            let sole = &model.soles[id.0];
            let middle = sole.centroid();
            let area = ws.links[sole.link.0].rotation * area(&sole.vertices, &middle);
            let normal = if area.norm() > 0.0 { area.normalize() * area.dot(up).signum() } else { *up };
            for (i, vertex) in sole.vertices.iter().enumerate() {
                sum += ws.point(sole.link, vertex);
                count += 1.0;
                if sensed.is_none_or(|s| s.soles[id.0].clamped[i]) {
                    let point = ws.point(sole.link, &vertex.lerp(&middle, margin));
                    self.footholds.push(Foothold { sole: id, point, normal });
                }
            }
            for corner in sensed.iter().flat_map(|s| &s.soles[id.0].corners) {
                let point = corner.position.lerp(&ws.point(sole.link, &middle), margin);
                self.footholds.push(Foothold { sole: id, point, normal });
            }
        }
        self.centre = if count > 0.0 { sum / count } else { ws.position };
    }

    /// Point of optimal stability of all vertices of the soles seen along `up`, at the height of
    /// the centre, world, m. Needs [`update`](Self::update). Allocates.
    pub fn stable_point(&self, model: &Model, ws: &Workspace, up: &Vector3<f64>) -> Vector3<f64> {
        let axes = Rotation3::rotation_between(&Vector3::z(), up).unwrap_or_else(Rotation3::identity);
        let level = Plane { rotation: axes.into_inner(), point: self.centre };
        let soles = self.soles.iter().map(|id| &model.soles[id.0]);
        let mut corners: Vec<_> = soles.flat_map(|s| s.vertices.iter().map(|v| ws.point(s.link, v))).collect();
        convex_hull(&mut corners, &level);
        let found = stable_point(corners.iter().map(|c| level.flat(c)), &mut Vec::new());
        found.map_or(self.centre, |s| level.world(&s.point))
    }
}

/// Twice the area vector of a polygon; zero for points and lines.
fn area(vertices: &[Vector3<f64>], middle: &Vector3<f64>) -> Vector3<f64> {
    let n = vertices.len();
    (0..n).map(|i| (vertices[i] - middle).cross(&(vertices[(i + 1) % n] - middle))).sum()
}

/// Unit vector against gravity; the world's z axis without gravity.
pub fn upwards(gravity: &Vector3<f64>) -> Vector3<f64> {
    gravity.try_normalize(0.0).map_or(Vector3::z(), |g| -g)
}

/// Rotation vector (world, rad) that turns the base of `state` to `desired`.
pub fn turn_to(state: &State, desired: &nalgebra::UnitQuaternion<f64>) -> Vector3<f64> {
    (desired * state.rotation.inverse()).scaled_axis()
}
