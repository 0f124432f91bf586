//! Sole forces as a force-torque sensor reads them.
//!
//! A sensor with a frame (origin o, orientation R) on the sole's link reads the floor's force F and
//! its moment about o in its own axes; c is the mean of the sole's vertices, M the moment about it:
//!
//! ```text
//! f = R^T F        m = R^T M + R^T (c - o) x f
//! ```
//!
//! Sensor errors apply to f and m. F and M are recovered with the orientation of the frame from the
//! sensed IMU and joints; `R^T (c - o)` is a constant of the link.

use crate::dynamics::chain;
use crate::robot::{Model, Mount, Sole};
use crate::task::sensor_readings::SoleLoad;
use nalgebra::{UnitQuaternion, Vector3};

/// A part of the reading of a sole's sensor.
pub(super) type Part = fn(&mut SoleLoad) -> &mut Vector3<f64>;

/// The force.
pub(super) fn force(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.force
}

/// The mean force since the last tick.
pub(super) fn mean_force(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.mean_force
}

/// The moment.
pub(super) fn moment(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.moment
}

/// A force-torque sensor with a frame.
pub(super) struct ForceSensor {
    mount: Mount,
    /// `R^T (c - o)`, m.
    lever: Vector3<f64>,
}

impl ForceSensor {
    /// The first sensor on the sole's link. Without one the load is measured in world axes about
    /// the mean of the vertices.
    pub fn of_sole(model: &Model, sole: &Sole) -> Option<Self> {
        let mount = model.sensors.force.iter().find(|f| f.mount.link == sole.link)?.mount;
        let lever = mount.pose.rotation.inverse() * (sole.centroid() - mount.pose.translation.vector);
        Some(ForceSensor { mount, lever })
    }

    /// Orientation of its frame in the world, with that of the base and joint positions.
    pub fn orientation(&self, model: &Model, base: &UnitQuaternion<f64>, q: &[f64], qd: &[f64]) -> UnitQuaternion<f64> {
        base * chain::from_root(model, &self.mount, q, qd).rotation
    }

    /// Transforms a load from world axes and the mean of the vertices into the frame.
    pub fn to_frame(&self, orientation: &UnitQuaternion<f64>, sole: &mut SoleLoad) {
        sole.force = orientation.inverse() * sole.force;
        sole.mean_force = orientation.inverse() * sole.mean_force;
        sole.moment = orientation.inverse() * sole.moment + self.lever.cross(&sole.force);
    }

    /// Transforms a load from the frame to world axes and the mean of the vertices.
    pub fn to_world(&self, orientation: &UnitQuaternion<f64>, sole: &mut SoleLoad) {
        sole.moment = orientation * (sole.moment - self.lever.cross(&sole.force));
        sole.force = orientation * sole.force;
        sole.mean_force = orientation * sole.mean_force;
    }
}
