//! Bias, noise and resolution of readings.

use crate::random::Stream;
use nalgebra::{UnitQuaternion, Vector3};

/// Errors of a sensor, the same for each of its channels, in the unit of its readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelError {
    /// Standard deviation of the white noise.
    pub noise: f64,
    /// Constant error.
    pub bias: f64,
    /// Step between readings; 0 for none.
    pub resolution: f64,
    /// Age of a reading, s.
    pub delay: f64,
}

/// Errors of a measured orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotationError {
    /// Standard deviation of the turn about each axis of the IMU, rad.
    pub noise: f64,
    /// Constant turn, rotation vector in the IMU's axes, rad.
    pub bias: Vector3<f64>,
    /// Age of a reading, s.
    pub delay: f64,
}

/// Errors of all sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorErrors {
    /// Joint positions.
    pub joint_position: ChannelError,
    /// Joint velocities.
    pub joint_velocity: ChannelError,
    /// Joint loads.
    pub joint_load: ChannelError,
    /// Orientation of the IMU.
    pub orientation: RotationError,
    /// Angular velocity of the IMU.
    pub gyroscope: ChannelError,
    /// Specific force at the IMU.
    pub accelerometer: ChannelError,
    /// Forces on the soles.
    pub sole_force: ChannelError,
    /// Moments on the soles.
    pub sole_moment: ChannelError,
}

impl ChannelError {
    /// Is the sensor exact?
    pub fn is_none(&self) -> bool {
        *self == ChannelError::default()
    }

    /// Adds bias and noise to delayed values and rounds them. Draws from the stream only if there
    /// is noise.
    pub(super) fn apply(&self, values: &mut [f64], stream: &mut Stream) {
        for x in values {
            *x += self.bias;
            if self.noise > 0.0 {
                *x += self.noise * stream.normal();
            }
            if self.resolution > 0.0 {
                *x = (*x / self.resolution).round() * self.resolution;
            }
        }
    }
}

impl RotationError {
    /// Rotates a delayed orientation by bias and noise.
    pub(super) fn apply(&self, rotation: &mut UnitQuaternion<f64>, stream: &mut Stream) {
        let mut turn = self.bias;
        if self.noise > 0.0 {
            turn += Vector3::from_fn(|_, _| self.noise * stream.normal());
        }
        if turn != Vector3::zeros() {
            *rotation *= UnitQuaternion::from_scaled_axis(turn);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_is_added_before_rounding() {
        let error = ChannelError { bias: 0.02, resolution: 0.25, ..ChannelError::default() };
        let mut values = [0.10, 0.11, -0.3, 1.0];
        error.apply(&mut values, &mut Stream::new(1, &["x"]));
        assert_eq!(values, [0.0, 0.25, -0.25, 1.0]);
    }

    #[test]
    fn noise_has_its_deviation_and_is_white() {
        let error = ChannelError { noise: 0.3, ..ChannelError::default() };
        let mut values = vec![2.0; 100_000];
        error.apply(&mut values, &mut Stream::new(7, &["x"]));
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        let next = values.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>() / n;
        // Five standard deviations: sigma / sqrt(n), sqrt(2 / n) sigma^2, sigma^2 / sqrt(n).
        assert!((mean - 2.0).abs() < 5.0 * 0.3 / n.sqrt());
        assert!((variance - 0.09).abs() < 5.0 * 0.09 * (2.0 / n).sqrt());
        assert!(next.abs() < 5.0 * 0.09 / n.sqrt());
    }
}
