//! Readings of a force-torque sensor with a frame on the sole's link.

use super::body::{Body, G};
use super::imu::with;
use crate::support::runs::watch;
use nalgebra::{Rotation3, Vector3};

const TURN: [f64; 3] = [0.4, -0.3, 1.1];
const PLACE: Vector3<f64> = Vector3::new(0.03, -0.02, 0.04);

/// Force and moment readings on the sole of a resting box of 2 kg and half height 0.05 m, rotated
/// by `yaw`.
fn resting(yaw: f64, frame: bool, sensors: &str) -> (Vector3<f64>, Vector3<f64>) {
    let body = Body::new([0.1, 0.08, 0.05], 2.0);
    let urdf = body.floating("");
    let frame = match frame {
        true => format!(
            "[sensors]\nforce = [{{ name = \"ankle\", link = \"block\", position = {:?}, rpy = {TURN:?} }}]",
            <[f64; 3]>::from(PLACE)
        ),
        false => String::new(),
    };
    let (_folder, model) = with("", urdf.split('"').nth(1).expect("a path"), &frame);
    let polygon = body.corners().map(|[x, y]| [x, y, -body.half[2]]);
    let (_, recording) = watch(&format!(
        "duration = 0.1\nrobot = {{ model = {model}, base = {{ rpy = [0, 0, {yaw}] }},
        soles = [{{ name = \"bottom\", link = \"block\", polygon = {polygon:?} }}] }}\nsensors = {{ {sensors} }}\n"
    ));
    recording.snapshots.last().expect("the end").estimate.as_ref().expect("sensors err").soles[0]
}

fn assert_reads((force, moment): (Vector3<f64>, Vector3<f64>), expected: (Vector3<f64>, Vector3<f64>)) {
    // Rounding of some 20 N; contact at rest holds it to 1e-9 of the weight.
    assert!((force - expected.0).norm() < 1e-7 && (moment - expected.1).norm() < 1e-7, "{force} {moment} {expected:?}");
}

#[test]
fn a_bias_rotates_with_the_foot_and_acts_about_the_sensor_origin() {
    let weight = Vector3::new(0.0, 0.0, 2.0 * G);
    let frame = Rotation3::from_euler_angles(TURN[0], TURN[1], TURN[2]);
    for yaw in [0.0, 0.7] {
        let foot = Rotation3::from_euler_angles(0.0, 0.0, yaw);
        // From its origin to the middle of the sole.
        let lever = Vector3::new(0.0, 0.0, -0.05) - PLACE;
        let off = foot * (frame * Vector3::repeat(0.5));
        // A smaller force at the sensor gives a smaller moment here.
        let turned = -(foot * lever).cross(&off);
        assert_reads(resting(yaw, true, "sole_force = { bias = 0.5 }"), (weight + off, turned));
        assert_reads(resting(yaw, true, "sole_moment = { bias = 0.5 }"), (weight, off));
        // Without its own frame it reads in world axes about the middle of the sole.
        assert_reads(
            resting(yaw, false, "sole_force = { bias = 0.5 }"),
            (weight + Vector3::repeat(0.5), Vector3::zeros()),
        );
    }
}

#[test]
fn world_readings_use_the_measured_orientation() {
    let tilt = 0.02;
    let sensors = format!("sole_force = {{ resolution = 1e-12 }}, orientation = {{ bias = [0, {tilt}, 0] }}");
    let weight = Vector3::new(0.0, 0.0, 2.0 * G);
    let seen = Rotation3::from_euler_angles(0.0, tilt, 0.0) * weight;
    assert_reads(resting(0.0, true, &sensors), (seen, Vector3::zeros()));
    assert_reads(resting(0.0, false, &sensors), (weight, Vector3::zeros()));
}
