//! Sensors: readings of the robot's state at a control tick.
//!
//! A reading y of a channel with true value x(t) is
//!
//! ```text
//! y_k = round_r( x(t_k - delay) + bias + sigma n_k )        n_k standard normal, white
//! ```
//!
//! with `round_r` to whole multiples of the resolution r. Between ticks x is interpolated linearly;
//! before the start it is constant. A measured orientation is
//! `R(t_k - delay) exp(bias + sigma n_k)`, the exponential in the axes of the IMU, whose frame is
//! on a link (see [`Imu`]).
//!
//! The gyroscope reads the angular velocity in the IMU's axes at the tick. The accelerometer reads
//! the mean specific force since the last tick, as units that output velocity increments do. It
//! therefore includes impacts:
//!
//! ```text
//! f_k = R_mid^T ((v_k - v_{k-1}) / T - g)        R_mid half way between the orientations at the two ticks
//! ```
//!
//! with v the velocity of the IMU's origin. Force sensors read the soles, see `force_sensor`.

use super::channel_error::{ChannelError, SensorErrors};
use super::delay::Delay;
use super::force_sensor::{self, ForceSensor};
use super::imu::Imu;
use super::true_readings;
use crate::dynamics::chain::FrameMotion;
use crate::random::Stream;
use crate::sim::plant::Plant;
use crate::task::SensorReadings;
use crate::task::augmented::LIGHT;
use nalgebra::{UnitQuaternion, Vector3};

/// The sensors of one run.
pub struct Sensors {
    /// Errors of the sensors; none: all readings are exact.
    errors: Option<Box<ErrorModel>>,
    /// Readings of the last tick.
    pub readings: SensorReadings,
    imu: Imu,
    /// Time, velocity of the IMU's origin and its orientation at the last tick.
    last: Option<(f64, Vector3<f64>, UnitQuaternion<f64>)>,
}

struct ErrorModel {
    errors: SensorErrors,
    streams: Streams,
    position: Delay,
    velocity: Delay,
    load: Delay,
    orientation: Delay,
    gyroscope: Delay,
    accelerometer: Delay,
    sole_force: Delay,
    mean_force: Delay,
    sole_moment: Delay,
    /// For each sole: its force-torque sensor, if it has one.
    frames: Vec<Option<ForceSensor>>,
    /// Forces or moments of all soles.
    scratch: Vec<f64>,
}

/// One stream of random numbers per sensor: the noise of one does not depend on the others.
struct Streams {
    joint_position: Stream,
    joint_velocity: Stream,
    joint_load: Stream,
    orientation: Stream,
    gyroscope: Stream,
    accelerometer: Stream,
    sole_force: Stream,
    mean_force: Stream,
    sole_moment: Stream,
}

impl Streams {
    fn new(seed: u64) -> Self {
        let of = |name: &str| Stream::new(seed, &["sensors", name]);
        Streams {
            joint_position: of("joint_position"),
            joint_velocity: of("joint_velocity"),
            joint_load: of("joint_load"),
            orientation: of("orientation"),
            gyroscope: of("gyroscope"),
            accelerometer: of("accelerometer"),
            sole_force: of("sole_force"),
            mean_force: of("mean_force"),
            sole_moment: of("sole_moment"),
        }
    }
}

impl Sensors {
    /// For a plant, read every `period` seconds; without `errors` all sensors are exact.
    pub fn new(plant: &Plant, errors: Option<SensorErrors>, imu: Imu, period: f64, seed: u64) -> Self {
        let readings = SensorReadings::blank(&plant.model);
        let (nj, ns) = (plant.model.nj(), plant.model.soles.len());
        let errors = errors.map(|e| {
            let delay = |channels: usize, error: &ChannelError| Delay::new(channels, error.delay, period);
            Box::new(ErrorModel {
                position: delay(nj, &e.joint_position),
                velocity: delay(nj, &e.joint_velocity),
                load: delay(nj, &e.joint_load),
                orientation: Delay::new(4, e.orientation.delay, period),
                gyroscope: delay(3, &e.gyroscope),
                accelerometer: delay(3, &e.accelerometer),
                sole_force: delay(3 * ns, &e.sole_force),
                mean_force: delay(3 * ns, &e.sole_force),
                sole_moment: delay(3 * ns, &e.sole_moment),
                frames: plant.model.soles.iter().map(|sole| ForceSensor::of_sole(&plant.model, sole)).collect(),
                scratch: vec![0.0; 3 * ns],
                streams: Streams::new(seed),
                errors: e,
            })
        });
        Sensors { errors, readings, imu, last: None }
    }

    /// Reads all sensors at the plant's present state, those of the soles only with `loads`. Times
    /// of successive calls must increase.
    pub fn read(&mut self, plant: &mut Plant, loads: bool) {
        true_readings::read(plant, loads, self.last.map(|last| last.0), &mut self.readings);
        self.readings.time = plant.state.time;
        self.readings.base = Some(FrameMotion::of_base(&plant.state));
        let imu = self.imu.motion(&plant.model, &plant.state);
        self.readings.orientation = imu.rotation;
        self.readings.angular_velocity = imu.rotation.inverse() * imu.omega;
        self.read_accelerometer(plant, &imu);
        if let Some(errors) = &mut self.errors {
            errors.apply(plant, &self.imu, &mut self.readings);
        }
    }

    /// Restarts the accelerometer after a jump of the robot's state.
    pub fn restart(&mut self) {
        self.last = None;
    }

    /// Reads the accelerometer.
    fn read_accelerometer(&mut self, plant: &Plant, imu: &FrameMotion) {
        let time = plant.state.time;
        let (mean, middle) = match self.last {
            Some((t, before, rotation)) if time > t => {
                ((imu.velocity - before) / (time - t), rotation.slerp(&imu.rotation, 0.5))
            }
            // The first reading: at rest.
            _ => (Vector3::zeros(), imu.rotation),
        };
        self.readings.specific_force = middle.inverse() * (mean - plant.gravity);
        self.last = Some((time, imu.velocity, imu.rotation));
    }
}

impl ErrorModel {
    /// Applies delays and errors to exact readings.
    fn apply(&mut self, plant: &Plant, imu: &Imu, out: &mut SensorReadings) {
        let (e, streams, now) = (&self.errors, &mut self.streams, plant.state.time);
        self.position.apply(now, &mut out.position);
        e.joint_position.apply(&mut out.position, &mut streams.joint_position);
        self.velocity.apply(now, &mut out.velocity);
        e.joint_velocity.apply(&mut out.velocity, &mut streams.joint_velocity);
        self.load.apply(now, &mut out.load);
        e.joint_load.apply(&mut out.load, &mut streams.joint_load);
        self.orientation.apply_to_rotation(now, &mut out.orientation);
        e.orientation.apply(&mut out.orientation, &mut streams.orientation);
        self.gyroscope.apply(now, out.angular_velocity.as_mut_slice());
        e.gyroscope.apply(out.angular_velocity.as_mut_slice(), &mut streams.gyroscope);
        self.accelerometer.apply(now, out.specific_force.as_mut_slice());
        e.accelerometer.apply(out.specific_force.as_mut_slice(), &mut streams.accelerometer);
        if e.sole_force.is_none() && e.sole_moment.is_none() {
            return;
        }
        let (model, state) = (&*plant.model, &plant.state);
        for (sole, sensor) in out.soles.iter_mut().zip(&self.frames) {
            let Some(sensor) = sensor else { continue };
            sensor.to_frame(&sensor.orientation(model, &state.rotation, &state.joints, state.rates()), sole);
        }
        let parts = [
            (&mut self.sole_force, &e.sole_force, &mut streams.sole_force, force_sensor::force as force_sensor::Part),
            (&mut self.mean_force, &e.sole_force, &mut streams.mean_force, force_sensor::mean_force),
            (&mut self.sole_moment, &e.sole_moment, &mut streams.sole_moment, force_sensor::moment),
        ];
        for (delay, error, stream, part) in parts {
            for (to, sole) in self.scratch.chunks_exact_mut(3).zip(&mut out.soles) {
                to.copy_from_slice(part(sole).as_slice());
            }
            delay.apply(now, &mut self.scratch);
            error.apply(&mut self.scratch, stream);
            for (from, sole) in self.scratch.chunks_exact(3).zip(&mut out.soles) {
                part(sole).copy_from_slice(from);
            }
        }
        let base = imu.base_orientation(model, &out.orientation, &out.position, &out.velocity);
        for (sole, sensor) in out.soles.iter_mut().zip(&self.frames) {
            let Some(sensor) = sensor else { continue };
            sensor.to_world(&sensor.orientation(model, &base, &out.position, &out.velocity), sole);
        }
        // Such a sensor does not measure the pressure distribution: all vertices are clamped, or
        // none.
        let light = LIGHT * model.mass() * plant.gravity.norm();
        let up = -plant.gravity.try_normalize(0.0).unwrap_or(-Vector3::z());
        for sole in &mut out.soles {
            sole.resolved = false;
            sole.corners.clear();
            sole.clamped.fill(sole.force.dot(&up) > light);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_have_independent_noise() {
        let mut s = Streams::new(1);
        let all = [
            &mut s.joint_position,
            &mut s.joint_velocity,
            &mut s.joint_load,
            &mut s.orientation,
            &mut s.gyroscope,
            &mut s.accelerometer,
            &mut s.sole_force,
            &mut s.mean_force,
            &mut s.sole_moment,
        ];
        let first: Vec<f64> = all.into_iter().map(|stream| stream.normal()).collect();
        for (i, x) in first.iter().enumerate() {
            assert!(!first[..i].contains(x), "{i}: {first:?}");
        }
    }
}
