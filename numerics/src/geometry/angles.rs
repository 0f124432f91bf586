//! Angles of rotations.

use crate::math;
use nalgebra::UnitQuaternion;

/// Roll, pitch and yaw, rad, as in URDF: `R = R_z(yaw) R_y(pitch) R_x(roll)`, pitch in [-pi/2, pi/2].
pub fn roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let (roll, _, yaw) = rotation.euler_angles();
    let r = rotation.to_rotation_matrix();
    // An arc sine has half of the digits near a right angle.
    let pitch = math::atan2(-r[(2, 0)], math::hypot(r[(2, 1)], r[(2, 2)]));
    [roll, pitch, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn pitch_has_all_digits_near_a_right_angle() {
        for distance in [1.0, 1e-3, 1e-6, 1e-9, 0.0] {
            for sign in [-1.0, 1.0] {
                let pitch: f64 = sign * (FRAC_PI_2 - distance);
                let turned = UnitQuaternion::from_euler_angles(0.3, pitch, -0.7);
                // Rounding of the quaternion's components.
                let error = (roll_pitch_yaw(&turned)[1] - pitch).abs();
                assert!(error < 1e-15, "{pitch}: {error:e}");
            }
        }
        let turned = UnitQuaternion::from_euler_angles(0.3, -1.2, 2.5);
        let found = roll_pitch_yaw(&turned);
        assert!(found.iter().zip([0.3, -1.2, 2.5]).all(|(x, y)| (x - y).abs() < 1e-15), "{found:?}");
    }
}
