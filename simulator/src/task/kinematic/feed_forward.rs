//! Feed-forward efforts of a planned motion, so that servos do not sag.
//!
//! The whole robot is assumed to accelerate with its centre of mass, c''. In a frame that moves
//! with it the robot is at rest under `g - c''`, and the floor carries it by
//!
//! ```text
//! f = -m (g - c''),   f_s = a_s f at x_s,   sum a_s = 1,   sum a_s x_s = z
//! tau = h(q, v; g - c'') - sum J_s^T f_s
//! ```
//!
//! with z the zero-moment point of the plan, h the bias forces, x_s the centroid of sole s shifted
//! by the offset of z from the line of centroids, and the shares a_s in proportion to the position
//! of z along that line. Soles of a robot with one or more than two are assumed to share evenly.

use super::PlannedRobot;
use crate::dynamics::{jacobian, rnea};
use crate::robot::Model;
use nalgebra::{Vector2, Vector3};

/// Writes the joint efforts tau (N m or N) to `out`. `zmp` in world axes, m; `acceleration` is c'',
/// m/s^2. The plan's kinematics must be those of its state.
pub fn efforts(
    model: &Model,
    planned: &mut PlannedRobot,
    gravity: &Vector3<f64>,
    acceleration: &Vector3<f64>,
    zmp: &Vector2<f64>,
    out: &mut [f64],
) {
    let apparent = gravity - acceleration;
    rnea::bias(&mut planned.ws, &apparent);
    let nb = model.nb();
    out.copy_from_slice(&planned.ws.bias[nb..]);
    let force = apparent * -model.mass();
    let feet = planned.feet.len();
    let position = |s: usize| planned.sole(s).translation.vector;
    let along = if feet == 2 {
        let (a, b) = (position(0).xy(), position(1).xy());
        ((zmp - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let share = |s: usize| match (feet, s) {
        (2, 0) => 1.0 - along,
        (2, _) => along,
        (n, _) => 1.0 / n as f64,
    };
    let middle: Vector2<f64> = (0..feet).map(|s| position(s).xy() * share(s)).sum();
    let offset = zmp - middle;
    for s in 0..feet {
        let point = position(s) + Vector3::new(offset.x, offset.y, 0.0);
        let carried = force * share(s);
        for &k in planned.ws.support(planned.feet[s].link).iter().filter(|k| **k >= nb) {
            out[k - nb] -= jacobian::column(&planned.ws, k, &point).linear.dot(&carried);
        }
    }
    model.move_efforts_to_leaders(&planned.state.joints, out);
}
