//! Creates the sensors and the estimator of a run.

use crate::assemble::names;
use crate::robot::{Base, Model};
use crate::scenario::{AccelerationSource, Diagnostic, Estimator, OrientationError, Run, SensorError, SensorsSpec};
use crate::sim::sensing::{ChannelError, EstimatorSetup, Imu, RotationError, SensorErrors};
use crate::text::suggest;

/// The IMU that is read: the one that the scenario names, or the robot's first.
pub(super) fn imu(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Imu {
    let imus = &model.sensors.imu;
    let Some(name) = &run.scenario.sensors.imu else { return Imu(imus.first().map(|imu| imu.mount)) };
    let found = imus.iter().find(|imu| imu.name == *name);
    if found.is_none() {
        let help = match imus.is_empty() {
            true => "its robot file has no IMU in `[sensors]`".to_owned(),
            false => suggest(name, imus.iter().map(|imu| imu.name.as_str())),
        };
        errors.push(run.error_at("sensors.imu", format!("the robot `{}` has no IMU `{name}`", model.name), Some(help)));
    }
    Imu(found.map(|imu| imu.mount))
}

/// Errors of the sensors; none when the scenario sets none.
pub(super) fn errors(spec: &SensorsSpec) -> Option<SensorErrors> {
    if spec.is_none() {
        return None;
    }
    let channel =
        |e: &SensorError| ChannelError { noise: e.noise, bias: e.bias, resolution: e.resolution, delay: e.delay };
    let rotation = |e: &OrientationError| RotationError { noise: e.noise, bias: e.bias.into(), delay: e.delay };
    Some(SensorErrors {
        joint_position: channel(&spec.joint_position),
        joint_velocity: channel(&spec.joint_velocity),
        joint_load: channel(&spec.joint_load),
        orientation: rotation(&spec.orientation),
        gyroscope: channel(&spec.gyroscope),
        accelerometer: channel(&spec.accelerometer),
        sole_force: channel(&spec.sole_force),
        sole_moment: channel(&spec.sole_moment),
    })
}

/// The estimator; a fixed base needs none and soles must be the robot's.
pub(super) fn estimator(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> EstimatorSetup {
    let control = &run.scenario.control;
    if control.estimator != Estimator::Truth && model.base == Base::Fixed {
        let message = format!("the base of the robot `{}` is fixed: there is nothing to estimate", model.name);
        errors.push(run.error_at("control.estimator", message, Some("leave it out".to_owned())));
    }
    match control.estimator {
        Estimator::Truth => EstimatorSetup::Truth,
        Estimator::Kinematic => {
            for (i, name) in control.kinematic.static_soles.iter().flatten().enumerate() {
                names::sole(model, run, &format!("control.kinematic.static_soles.{i}"), name, errors);
            }
            let weight = model.mass() * nalgebra::Vector3::from(run.scenario.gravity).norm();
            let is_listed = |list: &Vec<String>| model.soles.iter().map(|s| list.contains(&s.name)).collect();
            EstimatorSetup::Kinematic {
                load: control.kinematic.threshold * weight,
                soles: control.kinematic.static_soles.as_ref().map(is_listed),
            }
        }
        Estimator::Inertial => {
            EstimatorSetup::Inertial { by_soles: control.inertial.acceleration == AccelerationSource::Soles }
        }
    }
}
