//! Without a floor: flight, tops, a double pendulum.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use stiction::assemble;
use stiction::dynamics::body;
use stiction::robot::load;
use stiction::sim::Simulation;

use super::case::{Case, cases};
use crate::analytic::body::G;
use crate::analytic::pendulum;
use crate::support::runs::rk4;

/// A box thrown from `position`; its centre of mass at the end.
pub fn boxes(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (Some([x, y, z]), [vx, vy, vz], t) = (case.base().position, case.base().linear_velocity, case.duration())
    else {
        return None;
    };
    match metric {
        "final_com_x_m" => Some(x + vx * t),
        "final_com_y_m" => Some(y + vy * t),
        "final_com_z_m" => Some(z + vz * t - G * t * t / 2.0),
        "final_com_vz_m_s" => Some(vz - G * t),
        _ => None,
    }
}

#[test]
fn the_drift_allowed_in_flight_is_a_small_part_of_the_angular_momentum() {
    for (name, part) in [("flight-of-biped", 1e-10), ("flight-of-boxes", 1e-10)] {
        for case in cases(name) {
            let robot = load(&case.run.resolve(&case.run.scenario.robot.model))
                .unwrap_or_else(|e| panic!("{}", e.render(false)));
            let setup = assemble::setup(&case.run, &robot).unwrap_or_else(|e| panic!("{e}"));
            let start = Simulation::new(setup).unwrap_or_else(|e| panic!("{e}"));
            let spin = body::momentum(&start.plant().ws).angular.norm();
            let drift = |e: &&stiction::scenario::Expect| e.metric.as_deref() == Some("max_flight_spin_drift_Nms");
            let allowed = case
                .run
                .scenario
                .expect
                .iter()
                .find(drift)
                .and_then(|e| e.allowed())
                .expect("an allowed drift is given");
            assert!(spin > 0.0 && allowed <= part * spin, "{name}: {allowed:e} of {spin}");
        }
    }
}

/// The equations of [`pendulum`], for the centre of mass.
pub fn double_pendulum(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let robot = &case.run.scenario.robot;
    let (a, b) = (robot.posture["shoulder"], robot.posture["shoulder"] + robot.posture["elbow"]);
    let (p, q) = (robot.velocity["shoulder"], robot.velocity["shoulder"] + robot.velocity["elbow"]);
    let [a, b, p, q] = rk4([a, b, p, q], case.duration(), 20_000, |_, s| pendulum::derivative(s));
    match metric {
        "final_com_x_m" => Some(-(0.75 * a.sin() + 0.25 * b.sin()) / 2.0),
        "final_com_z_m" => Some(1.5 - (0.75 * a.cos() + 0.25 * b.cos()) / 2.0),
        "final_com_vx_m_s" => Some(-(0.75 * a.cos() * p + 0.25 * b.cos() * q) / 2.0),
        "final_com_vz_m_s" => Some((0.75 * a.sin() * p + 0.25 * b.sin() * q) / 2.0),
        _ => None,
    }
}

fn orientation(rotation: &UnitQuaternion<f64>, omega: &Vector3<f64>, metric: &str) -> Option<f64> {
    let (roll, pitch, yaw) = rotation.euler_angles();
    match metric {
        "final_base_roll" => Some(roll),
        "final_base_pitch" => Some(pitch),
        "final_base_yaw" => Some(yaw),
        "final_base_wx_rad_s" => Some(omega.x),
        "final_base_wy_rad_s" => Some(omega.y),
        "final_base_wz_rad_s" => Some(omega.z),
        _ => None,
    }
}

/// `R(t) = exp(t L / I_1) exp(t W e_3)`, `omega = L / I_1 + W R e_3`, `W = w_3 (I_1 - I_3) / I_1`.
pub fn symmetric_top(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [across, same, along] = case.inertia();
    assert_eq!((across, case.base().rpy), (same, [0.0; 3]));
    let omega = Vector3::from(case.base().angular_velocity);
    let precession = Vector3::new(omega.x, omega.y, omega.z * along / across);
    let slip = omega.z * (across - along) / across;
    let t = case.duration();
    let rotation = Rotation3::new(precession * t) * Rotation3::new(Vector3::z() * (slip * t));
    let omega = precession + rotation * Vector3::z() * slip;
    orientation(&UnitQuaternion::from_rotation_matrix(&rotation), &omega, metric)
}

/// Euler's equations with the quaternion of the attitude, by fixed steps.
pub fn asymmetric_top(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [i, j, k] = case.inertia();
    assert!(i != j && j != k && i != k);
    let [wx, wy, wz] = case.base().angular_velocity;
    let end = rk4([1.0, 0.0, 0.0, 0.0, wx, wy, wz], case.duration(), 10_000, |_, s: &[f64; 7]| {
        let [w, x, y, z, a, b, c] = *s;
        let turn = Quaternion::new(w, x, y, z) * Quaternion::new(0.0, a, b, c) * 0.5;
        [turn.w, turn.i, turn.j, turn.k, (j - k) * b * c / i, (k - i) * c * a / j, (i - j) * a * b / k]
    });
    let attitude = UnitQuaternion::from_quaternion(Quaternion::new(end[0], end[1], end[2], end[3]));
    orientation(&attitude, &(attitude * Vector3::new(end[4], end[5], end[6])), metric)
}
