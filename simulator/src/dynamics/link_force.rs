//! Forces on links as generalised forces: `tau_k += S_k . (f, n + (x - O) x f)` for every velocity
//! k that moves the link.

use super::spatial::Force;
use super::workspace::Workspace;
use crate::robot::LinkId;
use nalgebra::Vector3;

/// Adds a force (N) acting on a link at a world point (m) and a free moment (N m), both in world
/// axes, to `tau` (length nv). Needs `kinematics::positions`.
pub fn accumulate(
    ws: &Workspace,
    link: LinkId,
    point: &Vector3<f64>,
    force: &Vector3<f64>,
    moment: &Vector3<f64>,
    tau: &mut [f64],
) {
    let wrench = Force::new(*force, moment + (point - ws.position).cross(force));
    for &k in ws.support(link) {
        tau[k] += ws.axes[k].dot(&wrench);
    }
}
