//! Pose and velocity of one frame relative to the root, from the links of its chain only.
//!
//! The recursion runs from the frame towards the root. p is the frame's origin, u its velocity and
//! w the angular velocity of the frame, all relative to the present link and in its axes. R_i0 and
//! d_i are the joint's frame at position 0 in the parent:
//!
//! ```text
//! u <- R (u + q' z x p)    w <- R (w + q' z)    p <- d_i + R p            R = R_i0 Rz(q)     revolute
//! u <- R (u + q' z)        w <- R w             p <- d_i + R (p + q z)    R = R_i0           prismatic
//! ```

use super::state::State;
use crate::robot::{JointKind, Model, Mount};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Pose and velocity of a frame relative to the root link, in root axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeMotion {
    /// Rotation, root from frame.
    pub rotation: UnitQuaternion<f64>,
    /// Origin of the frame, m.
    pub position: Vector3<f64>,
    /// Velocity of that origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity of the frame, rad/s.
    pub omega: Vector3<f64>,
}

/// Motion of `mount` relative to the root at joint positions `q` (rad, m) and rates `qd`.
pub fn from_root(model: &Model, mount: &Mount, q: &[f64], qd: &[f64]) -> RelativeMotion {
    let mut rotation: Matrix3<f64> = mount.pose.rotation.to_rotation_matrix().into_inner();
    let mut position = mount.pose.translation.vector;
    let (mut velocity, mut omega) = (Vector3::zeros(), Vector3::zeros());
    let mut at = mount.link;
    while let Some(parent) = model.links[at.0].parent {
        let (link, j) = (&model.links[at.0], at.0 - 1);
        let z = Vector3::z();
        let turn = match model.joints[j].kind {
            JointKind::Revolute | JointKind::Continuous => {
                velocity += (z * qd[j]).cross(&position);
                omega += z * qd[j];
                link.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), q[j]).into_inner()
            }
            JointKind::Prismatic => {
                velocity += z * qd[j];
                position += z * q[j];
                link.rotation
            }
        };
        (velocity, omega, rotation) = (turn * velocity, turn * omega, turn * rotation);
        position = link.offset + turn * position;
        at = parent;
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    RelativeMotion { rotation, position, velocity, omega }
}

/// Pose and velocity of a frame, world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameMotion {
    /// Rotation, world from frame.
    pub rotation: UnitQuaternion<f64>,
    /// Origin, m.
    pub position: Vector3<f64>,
    /// Velocity of the origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub omega: Vector3<f64>,
}

impl FrameMotion {
    /// Motion of the base of a state; a fixed base does not move.
    pub fn of_base(state: &State) -> Self {
        let moves = state.v.len() > state.joints.len();
        let part = |k: usize| if moves { Vector3::from_column_slice(&state.v[k..k + 3]) } else { Vector3::zeros() };
        FrameMotion { rotation: state.rotation, position: state.position, velocity: part(0), omega: part(3) }
    }

    /// Writes it as the base motion of a state. A fixed base gets the pose only.
    pub fn write_base(&self, state: &mut State) {
        (state.position, state.rotation) = (self.position, self.rotation);
        if state.v.len() > state.joints.len() {
            state.v[..3].copy_from_slice(self.velocity.as_slice());
            state.v[3..6].copy_from_slice(self.omega.as_slice());
        }
    }
}

impl RelativeMotion {
    /// Motion of the frame for the root motion `root`.
    pub fn carried_by(&self, root: &FrameMotion) -> FrameMotion {
        let arm = root.rotation * self.position;
        FrameMotion {
            rotation: root.rotation * self.rotation,
            position: root.position + arm,
            velocity: root.velocity + root.omega.cross(&arm) + root.rotation * self.velocity,
            omega: root.omega + root.rotation * self.omega,
        }
    }

    /// Motion of the root for the frame motion `frame`: the inverse of
    /// [`carried_by`](Self::carried_by).
    pub fn carries(&self, frame: &FrameMotion) -> FrameMotion {
        let rotation = frame.rotation * self.rotation.inverse();
        let arm = rotation * self.position;
        let omega = frame.omega - rotation * self.omega;
        FrameMotion {
            rotation,
            position: frame.position - arm,
            velocity: frame.velocity - omega.cross(&arm) - rotation * self.velocity,
            omega,
        }
    }
}
