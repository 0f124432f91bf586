//! Wrenches of soles and of external forces, world axes.
//!
//! ```text
//! f = sum_i f_i,   n = sum_i (p_i - c) x f_i
//! ```
//!
//! with forces `f_i` at points `p_i`. The moment is about `c`: of a sole the mean of its vertices, of
//! external forces the world's origin.

use crate::export::bag::messages::{Wrench, WrenchStamped};
use crate::log::SoleSeries;
use crate::log::ros::{Header, Time};
use nalgebra::Vector3;

/// Force and moment of the floor on a sole at a tick. The force has the bits of the log.
pub(super) fn of_sole(sole: &SoleSeries, tick: usize, frame: &str, stamp: Time) -> WrenchStamped {
    let centre = centre(sole, tick);
    let moments = sole.vertices.iter().map(|v| (v.position[tick] - centre).cross(&v.force[tick]));
    message(frame, stamp, sole.force[tick], moments.sum())
}

/// Resultant of external forces, points and forces, about the world's origin.
pub(super) fn of_external(forces: &[(Vector3<f64>, Vector3<f64>)], world: &str, stamp: Time) -> WrenchStamped {
    let force = forces.iter().map(|(_, force)| force).sum();
    message(world, stamp, force, forces.iter().map(|(point, force)| point.cross(force)).sum())
}

/// Mean of the vertices of a sole at a tick, m; the origin if there are none.
pub(super) fn centre(sole: &SoleSeries, tick: usize) -> Vector3<f64> {
    let sum: Vector3<f64> = sole.vertices.iter().map(|vertex| vertex.position[tick]).sum();
    sum / (sole.vertices.len().max(1) as f64)
}

fn message(frame: &str, stamp: Time, force: Vector3<f64>, moment: Vector3<f64>) -> WrenchStamped {
    WrenchStamped {
        header: Header { stamp, frame_id: frame.to_owned() },
        wrench: Wrench { force: force.into(), torque: moment.into() },
    }
}
