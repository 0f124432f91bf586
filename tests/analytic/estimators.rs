//! Sensors and base estimators against their predicted errors.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, root, run, watch};
use nalgebra::{UnitQuaternion, Vector3};

/// Control ticks per second, and the time of the last tick before the end at 1 s.
const RATE: f64 = 1000.0;
const LAST: f64 = 0.999;

fn resting(body: &Body) -> String {
    format!("duration = 1.0\n{}", body.robot(""))
}

#[test]
fn a_gyroscope_bias_rotates_the_estimate_at_a_constant_rate() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let bias = 0.02;
    let m = run(&format!(
        "{}control = {{ estimator = \"inertial\", inertial = {{ acceleration = \"soles\" }} }}
        sensors = {{ gyroscope = {{ bias = {bias} }} }}\n",
        resting(&body)
    ));
    // Equal biases about all three axes rotate about the diagonal. Rounding of a thousand products.
    let turned = 3f64.sqrt() * bias * LAST;
    assert!((m.final_estimate_error_rad.unwrap() - turned).abs() < 1e-12, "{:?}", m.final_estimate_error_rad);
}

#[test]
fn an_accelerometer_bias_gives_a_quadratic_error() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let bias = 0.1;
    let m = run(&format!(
        "{}control = {{ estimator = \"inertial\" }}\nsensors = {{ accelerometer = {{ bias = {bias} }} }}\n",
        resting(&body)
    ));
    let distance = 0.5 * 3f64.sqrt() * bias * LAST * LAST;
    // Contact holds the block to the last bits of a velocity: 1e-12 m/s over 1 s.
    assert!((m.final_estimate_error_m.unwrap() - distance).abs() < 1e-11, "{:?}", m.final_estimate_error_m);
    assert!(m.max_estimate_error_rad.unwrap() < 1e-12);
}

#[test]
fn an_orientation_bias_tilts_the_base_about_its_sole() {
    // Half height 0.05 m, so the centroid of the sole is 0.05 m below the base.
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let tilt: f64 = 0.03;
    let m = run(&format!(
        "{}control = {{ estimator = \"kinematic\" }}\nsensors = {{ orientation = {{ bias = [0.0, {tilt}, 0.0] }} }}\n",
        resting(&body)
    ));
    let chord = 2.0 * 0.05 * (0.5 * tilt).sin();
    // Rounding.
    assert!((m.max_estimate_error_m.unwrap() - chord).abs() < 1e-14, "{:?}", m.max_estimate_error_m);
    assert!((m.max_estimate_error_rad.unwrap() - tilt).abs() < 1e-14, "{:?}", m.max_estimate_error_rad);
}

#[test]
fn a_slide_is_estimated_from_acceleration_and_not_from_a_loaded_sole() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let (mu, speed) = (0.3, 0.6);
    let way = speed * speed / (2.0 * mu * G);
    let text = |estimator: &str| {
        format!(
            "duration = 1.0\nfloor = {{ friction = {mu} }}\n{}control = {{ {estimator} }}{TIGHT}",
            body.robot(&format!("linear_velocity = [{speed}, 0.0, 0.0]"))
        )
    };
    let carried = run(&text("estimator = \"kinematic\"")).final_estimate_error_m.unwrap();
    // The estimator assumes a static sole, so the estimate misses the whole distance. Integration
    // at 1e-9.
    assert!((carried - way).abs() < 1e-9, "{carried} {way}");
    let imposed = "estimator = \"kinematic\", kinematic = { static_soles = [] }";
    let fallen = run(&text(imposed)).final_estimate_error_m.unwrap();
    // Without an assumed static sole the estimate continues in flight: along x by speed, down by
    // gravity.
    let flown = ((speed * LAST - way).powi(2) + (0.5 * G * LAST * LAST).powi(2)).sqrt();
    assert!((fallen - flown).abs() < 1e-9, "{fallen} {flown}");
    for source in ["accelerometer", "soles"] {
        let options = format!("estimator = \"inertial\", inertial = {{ acceleration = \"{source}\" }}");
        let m = run(&text(&options));
        // The deceleration is constant except in the period T of the stop, in which only its mean
        // is known. The accelerometer errs by T^2 a / 8 at most; the forces at both ends of the
        // period miss up to T a / 2 of velocity.
        let a = mu * G;
        let rest = LAST - speed / a;
        let bar = if source == "soles" { 0.5 * a / RATE * (rest + 1.0 / RATE) } else { a / (8.0 * RATE * RATE) };
        assert!(m.max_estimate_error_m.unwrap() < bar + 1e-9, "{source}: {:?} {bar}", m.max_estimate_error_m);
        assert!(m.max_estimate_error_rad.unwrap() < 1e-9);
    }
}

#[test]
fn integrating_a_tumbling_body_is_of_second_order() {
    let body = Body::new([0.12, 0.06, 0.03], 2.5);
    let robot = body.robot(
        "position = [0.0, 0.0, 9.0], rpy = [0.2, 0.1, 0.0], linear_velocity = [0.3, -0.2, 1.0], angular_velocity = [3.0, 8.0, -2.0]",
    );
    let error = |rate: f64| {
        let control = format!("control = {{ rate = {rate}, estimator = \"inertial\" }}");
        let m = run(&format!("duration = 1.0\n{robot}{control}{TIGHT}"));
        (m.final_estimate_error_rad.unwrap(), m.final_estimate_error_m.unwrap())
    };
    let ((turn, way), (fine_turn, fine_way)) = (error(250.0), error(500.0));
    assert!(turn > 1e-6, "{turn}");
    // Terms of order T^3 change the ratio by some T / (time scale of the motion), 1/30; the last
    // ticks differ by 2 ms.
    assert!((turn / fine_turn - 4.0).abs() < 0.3, "{turn} {fine_turn}");
    // In flight the specific force is zero in any orientation: the estimate follows the parabola to
    // rounding.
    assert!(way < 1e-11 && fine_way < 1e-11, "{way} {fine_way}");
}

#[test]
fn joint_motion_over_static_soles_is_estimated_to_rounding() {
    let text = std::fs::read_to_string(root().join("scenarios/knee-bend.toml")).expect("it is there");
    let text = text.replace("../robots", "robots").replace("duration = 6.0", "duration = 2.5");
    let text = text[..text.find("[[expect]]").unwrap()].to_owned();
    let m = run(&format!("{text}\n[control]\nestimator = \"kinematic\"\n"));
    // Static soles keep their position except for drift that is projected out, 1e-10 m, and the
    // floor does not move.
    assert!(m.max_estimate_error_m.unwrap() < 1e-9, "{:?}", m.max_estimate_error_m);
    // The quaternion times its own inverse.
    assert!(m.max_estimate_error_rad.unwrap() < 1e-15);
}

#[test]
fn noise_depends_on_the_seed_alone_and_bias_delay_and_resolution_are_exact() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let text = |seed: u32| {
        format!(
            "seed = {seed}\nduration = 0.4\nlog = {{ rate = 1000.0 }}\n{}
            sensors = {{ gyroscope = {{ noise = 0.01 }}, accelerometer = {{ bias = 0.3, resolution = 0.5 }},
            sole_force = {{ bias = 2.0 }}, orientation = {{ delay = 0.1 }} }}\n",
            body.robot("position = [0.0, 0.0, 9.0], angular_velocity = [0.0, 0.0, 2.0]")
        )
    };
    let readings = |seed: u32| -> Vec<_> {
        watch(&text(seed)).1.snapshots.into_iter().map(|s| s.estimate.expect("sensors have errors")).collect()
    };
    let (one, again, other) = (readings(1), readings(1), readings(2));
    assert_eq!(one, again);
    let noise = |r: &[stiction::sim::EstimateSnapshot]| -> Vec<Vector3<f64>> {
        r.iter().map(|e| e.angular_velocity - Vector3::new(0.0, 0.0, 2.0)).collect()
    };
    assert_ne!(noise(&one), noise(&other));
    // 400 readings of three channels: five standard deviations of the mean square.
    let square = noise(&one).iter().map(Vector3::norm_squared).sum::<f64>() / (3 * one.len()) as f64;
    assert!((square / 1e-4 - 1.0).abs() < 5.0 * (2.0 / (3.0 * one.len() as f64)).sqrt(), "{square}");
    assert_eq!(one[0].specific_force, Vector3::new(0.5, 0.5, 10.0), "the first reading is one at rest");
    for e in &one[1..] {
        // Free fall reads zero; 0.3 rounds to 0.5.
        assert_eq!(e.specific_force, Vector3::repeat(0.5));
        // No floor force, only the bias.
        assert_eq!(e.soles, [(Vector3::repeat(2.0), Vector3::zeros())]);
        let then = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 2.0 * (e.time - 0.1).max(0.0)));
        // Rounding; for an angle its square root.
        assert!(e.orientation.angle_to(&then) < 1e-7, "{} {:?}", e.time, e.orientation);
    }
}

/// In flight the centre of mass falls freely, wherever the base is in the robot. Here the base is 5
/// cm from a foot, and the other links swing. Orientation and joints are known, so the estimate is
/// exact up to the integrator's tolerance.
#[test]
fn a_flying_robot_is_estimated_from_its_centre_of_mass() {
    let m = run(&format!(
        "duration = 0.3\n{TIGHT}
        [robot]\nmodel = \"robots/hoap2/hoap2.toml\"
        base = {{ position = [0, 0, 2], linear_velocity = [0.3, 0.2, 1.0], angular_velocity = [3.0, -2.0, 4.0] }}
        [[task]]\ntype = \"sine\"\njoints = {{ left_knee = {{ amplitude = 0.3, frequency = 2.0 }}, left_hip_roll = {{ amplitude = 0.2, frequency = 3.0 }} }}
        [control]\nestimator = \"kinematic\"\n"
    ));
    // Momentum is conserved to the tolerance of 1e-9 over the flight.
    assert!(m.max_estimate_error_m.unwrap() < 1e-8, "{:?}", m.max_estimate_error_m);
}

/// Servo efforts jump at every tick, and the floor's forces with them. A tick reads the force
/// before its jump. Summing the means between ticks instead is correct to second order.
#[test]
fn forces_between_ticks_give_the_estimate_of_a_squatting_robot() {
    let off = |rate: f64| {
        let m = run(&format!(
            "duration = 2.0
            [robot]\nmodel = \"robots/hoap2/hoap2.toml\"
            [[task]]\ntype = \"posture\"\nstart = 0.2\nduration = 0.8
            joints = {{ left_hip_pitch = \"-30 deg\", left_knee = \"60 deg\", left_ankle_pitch = \"-30 deg\", right_hip_pitch = \"-30 deg\", right_knee = \"60 deg\", right_ankle_pitch = \"-30 deg\" }}
            [control]\nrate = {rate}\nestimator = \"inertial\"\ninertial = {{ acceleration = \"soles\" }}\n"
        ));
        m.max_estimate_error_m.unwrap()
    };
    // Velocities of 0.2 m/s change within some 0.1 s: (T / 0.1 s)^2 of them, over a second. With
    // the forces at ticks the error was 0.1 m.
    assert!(off(1000.0) < 2e-3, "{}", off(1000.0));
    assert!(off(250.0) < 1e-2, "{}", off(250.0));
}

/// The noise of one sensor does not depend on that of another.
#[test]
fn sensors_have_independent_noise() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let turned = |more: &str| {
        let m = run(&format!(
            "{}control = {{ estimator = \"inertial\", inertial = {{ acceleration = \"soles\" }} }}
            sensors = {{ gyroscope = {{ noise = 0.1 }}{more} }}\n",
            resting(&body)
        ));
        m.final_estimate_error_rad.unwrap()
    };
    assert_eq!(turned(""), turned(", joint_position = { noise = 0.01 }, sole_moment = { noise = 1.0 }"));
}

/// A force sensor does not know which vertices are static: a balance that uses the sensed contacts
/// loses them with the force.
#[test]
fn sensed_contacts_come_from_the_sensors() {
    let stands = |bias: f64| {
        let m = run(&format!(
            "duration = 0.3\nrobot = {{ model = \"robots/cbi/cbi.toml\" }}
            sensors = {{ sole_force = {{ bias = {bias} }} }}
            [[task]]\ntype = \"balance\"\ncontrol = \"force\"\nforce = {{ contacts = \"sensed\" }}\n"
        ));
        m.final_base_position[2]
    };
    let (right, blind) = (stands(1e-9), stands(-1e4));
    assert!(right > 0.79, "{right}");
    // No sole counts as loaded: the legs yield as far as their damping allows within 0.3 s.
    assert!(blind < right - 0.005, "{blind} {right}");
}
