//! Sensors with bias, noise, resolution and delay, and estimators of the base's motion.
//!
//! [`Sensors`] reads the plant at every control tick; [`Estimator`] turns the readings into the
//! state that tasks receive.
//!
//! Imports plant, robot, dynamics, random and task (the type of the readings). Called by the
//! control tick.

pub mod channel_error;
mod delay;
pub mod estimator;
mod force_sensor;
pub mod imu;
pub mod sensors;
mod true_readings;

pub use channel_error::{ChannelError, RotationError, SensorErrors};
pub use estimator::{Estimator, EstimatorSetup};
pub use imu::Imu;
pub use sensors::Sensors;
