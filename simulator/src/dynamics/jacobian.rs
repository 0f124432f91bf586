//! Velocities, accelerations and Jacobians of points and frames fixed in a link, in world axes.
//!
//! For a point at r from O: `J_k = (S_lin + S_ang x r, S_ang)`, its velocity `V_lin + omega x r`
//! and its acceleration `A_lin + omega' x r + omega x (V_lin + omega x r)`, A the spatial
//! acceleration.

use super::spatial::Motion;
use super::workspace::Workspace;
use crate::robot::LinkId;
use nalgebra::Vector3;

/// Velocity (m/s, world axes) of the link's point that is at the world position `point`. Needs
/// `kinematics::update`.
#[inline]
pub fn point_velocity(ws: &Workspace, link: LinkId, point: &Vector3<f64>) -> Vector3<f64> {
    ws.links[link.0].velocity.at(&(point - ws.position))
}

/// Velocity of the link's point that is at `point`, and the link's angular velocity; world axes.
#[inline]
pub fn link_twist(ws: &Workspace, link: LinkId, point: &Vector3<f64>) -> Motion {
    Motion::new(point_velocity(ws, link, point), ws.links[link.0].velocity.angular)
}

/// Classical acceleration p'' (m/s^2) of the link's point that is at `point`, and omega'. Gravity
/// is not subtracted: it is zero for a robot at rest. Needs `kinematics::accelerations` (or a pass
/// that leaves them).
pub fn point_acceleration(ws: &Workspace, link: LinkId, point: &Vector3<f64>) -> Motion {
    let l = &ws.links[link.0];
    classical(&l.acceleration, &l.velocity, &(point - ws.position))
}

/// Acceleration of the link's point that is at `point` without accelerations of the velocities, `J' v`, m/s^2, world
/// axes. Needs [`super::prepare`].
pub fn point_drift(ws: &Workspace, link: LinkId, point: &Vector3<f64>) -> Vector3<f64> {
    let l = &ws.links[link.0];
    classical(&l.drift, &l.velocity, &(point - ws.position)).linear
}

/// Classical acceleration of the body point at `r` from O, from the spatial acceleration.
#[inline(always)]
pub(super) fn classical(acceleration: &Motion, velocity: &Motion, r: &Vector3<f64>) -> Motion {
    let linear = acceleration.at(r) + velocity.angular.cross(&velocity.at(r));
    Motion::new(linear, acceleration.angular)
}

/// Column of the frame Jacobian for velocity `k` at the world point `point`: the motion of the
/// frame at rate 1, if `k` moves its link.
#[inline]
pub fn column(ws: &Workspace, k: usize, point: &Vector3<f64>) -> Motion {
    let s = &ws.axes[k];
    Motion::new(s.at(&(point - ws.position)), s.angular)
}

/// Jacobian of the frame at world position `point` fixed to `link`: `(p', omega) = J v`, world
/// axes, 6 x nv, column-major (`out[6 k + row]`, length 6 nv). Needs `kinematics::positions`.
pub fn frame(ws: &Workspace, link: LinkId, point: &Vector3<f64>, out: &mut [f64]) {
    out.fill(0.0);
    for &k in ws.support(link) {
        let c = column(ws, k, point);
        out[6 * k..6 * k + 3].copy_from_slice(c.linear.as_slice());
        out[6 * k + 3..6 * k + 6].copy_from_slice(c.angular.as_slice());
    }
}

/// Jacobian of the centre of mass: `c' = J v`, world axes, 3 x nv, column-major (`out[3 k + row]`,
/// length 3 nv). Needs `crba::mass_matrix`, whose composite inertias it reads.
pub fn center_of_mass(ws: &Workspace, out: &mut [f64]) {
    let nb = ws.nb;
    let total = super::body::total_inertia(ws);
    for (k, s) in ws.axes.iter().enumerate() {
        // Velocity k moves the subtree of its link; each base velocity moves the whole body.
        let subtree = if k < nb { &total } else { &ws.composite[k + 1 - nb] };
        let momentum = subtree.apply(s);
        out[3 * k..3 * k + 3].copy_from_slice((momentum.linear / total.mass).as_slice());
    }
}
