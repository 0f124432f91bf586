//! Forces on the sole vertices, the points in contact, and the zero-moment point.
//!
//! ```text
//! F = sum f_s,  M = sum m_s + (p_s - o) x f_s     zmp = o + (-M_y, M_x, 0) / F_z     in the floor's axes, o on the floor
//! ```
//!
//! with f_s and m_s the force and moment on sole s about its reference point p_s.

use super::AugmentedData;
use crate::dynamics::body;
use crate::geometry::Plane;
use crate::task::SensorReadings;
use crate::task::sensor_readings::SoleCorner;
use nalgebra::{Vector2, Vector3};

/// A vertex with a smaller force, N, counts as unloaded: solver rounding.
pub(super) const UNLOADED: f64 = 1e-9;
/// A sole whose sensor measures less than this fraction of the robot's weight counts as in the air.
pub const LIGHT: f64 = 0.02;

/// A point of a sole in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Index of the sole.
    pub sole: usize,
    /// Index of the vertex in it; none where a border of terrain or an object crosses the sole.
    pub vertex: Option<usize>,
    /// Position, world, m.
    pub position: Vector3<f64>,
    /// Force on it, world axes, N.
    pub force: Vector3<f64>,
}

impl AugmentedData {
    /// Uses the vertex forces of the simulation. If a sensor measures only the resultants,
    /// these are split ([`super::load_split`]), and loaded vertices count as in contact on soles
    /// that bear more than `LIGHT` times the weight.
    pub(super) fn find_contacts(&mut self, sensed: &SensorReadings, floor: &Plane) {
        self.contacts.clear();
        let light = LIGHT * body::total_inertia(&self.workspace).mass * self.gravity.norm();
        for (s, (data, load)) in self.soles.iter_mut().zip(&sensed.soles).enumerate() {
            if load.resolved {
                data.vertex_forces.copy_from_slice(&load.vertices);
            } else {
                self.splitter.split(s, data, load, floor);
            }
            let loaded = floor.to_plane(&load.force).z > light;
            for (i, (position, force)) in data.vertices.iter().zip(&data.vertex_forces).enumerate() {
                let bears = || loaded && floor.to_plane(force).z > UNLOADED;
                let touches = if load.resolved { load.clamped[i] } else { bears() };
                if touches {
                    self.contacts.push(ContactPoint { sole: s, vertex: Some(i), position: *position, force: *force });
                }
            }
            let corner = |c: &SoleCorner| ContactPoint { sole: s, vertex: None, position: c.position, force: c.force };
            self.contacts.extend(load.corners.iter().map(corner));
        }
    }

    pub(super) fn find_zmp(&mut self, sensed: &SensorReadings, floor: &Plane) {
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (data, load) in self.soles.iter().zip(&sensed.soles) {
            force += load.force;
            moment += load.moment + (data.position - floor.point).cross(&load.force);
        }
        let (f, m) = (floor.to_plane(&force), floor.to_plane(&moment));
        self.zmp = (f.z > UNLOADED).then(|| floor.world(&Vector2::new(-m.y / f.z, m.x / f.z)));
    }
}
