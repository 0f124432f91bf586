//! A block on a slope holds below the friction angle and slides with `g (sin - mu cos)` above it,
//! for any heading.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, rk4, run, simulation, watch};
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

struct Slope {
    downhill: Vector3<f64>,
    rpy: [f64; 3],
}

/// A plane that descends by `angle` towards `heading`.
fn slope(angle: f64, heading: f64) -> Slope {
    let (s, c) = heading.sin_cos();
    let rotation = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::new(-s, c, 0.0)), angle);
    let (roll, pitch, yaw) = rotation.euler_angles();
    Slope { downhill: rotation * Vector3::new(c, s, 0.0), rpy: [roll, pitch, yaw] }
}

fn scenario(body: &Body, slope: &Slope, friction: &str, duration: f64) -> String {
    format!(
        "duration = {duration}\nfloor = {{ friction = {friction}, rpy = {:?} }}\n{}{TIGHT}",
        slope.rpy,
        body.robot(&format!("rpy = {:?}", slope.rpy))
    )
}

fn moved(body: &Body, angle: f64, position: [f64; 3]) -> Vector3<f64> {
    Vector3::from(position) - Vector3::new(0.0, 0.0, body.half[2] / angle.cos())
}

#[test]
fn a_block_holds_below_the_friction_angle_for_every_heading() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.1, 0.6, 0.3]) {
        for k in 0..12 {
            // 99.9 % of the static friction angle, where kinetic friction could not hold the block.
            let angle = 0.999 * f64::atan(mu);
            let slope = slope(angle, 0.05 + k as f64 * std::f64::consts::TAU / 12.0);
            let friction = format!("{{ static = {mu}, kinetic = {} }}", 0.5 * mu);
            let m = run(&scenario(&body, &slope, &friction, 1.0));
            // A static sole keeps its position to rounding.
            assert!(moved(&body, angle, m.final_base_position).norm() < 1e-12, "{:?}", m.final_base_position);
            assert_eq!((m.first_slip_s, m.inconsistent, m.state_changes), (None, 0, 0));
        }
    }
}

#[test]
fn a_block_slides_above_the_friction_angle_for_every_heading() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.1, 0.6, 0.3]) {
        for k in 0..12 {
            for (beyond, duration) in [(1.001, 1.0), (1.2, 0.5)] {
                let angle = beyond * f64::atan(mu);
                let slope = slope(angle, 0.05 + k as f64 * std::f64::consts::TAU / 12.0);
                let m = run(&scenario(&body, &slope, &mu.to_string(), duration));
                let way = 0.5 * G * (angle.sin() - mu * angle.cos()) * duration * duration;
                let moved = moved(&body, angle, m.final_base_position);
                // A parabola, exact for the integrator. The error is rounding of forces, 1e-15 of g
                // t^2 / 2, times the cancellation between weight and friction.
                assert!((moved - slope.downhill * way).norm() < 1e-12, "{moved} {way} {}", slope.downhill);
                assert_eq!(m.inconsistent, 0);
            }
        }
    }
}

#[test]
fn without_friction_a_block_slides_with_g_sin_for_every_heading() {
    for body in Body::several() {
        for k in 0..12 {
            let (angle, duration) = (0.05 + 0.1 * k as f64, 0.5);
            let slope = slope(angle, 0.05 + k as f64 * std::f64::consts::TAU / 12.0);
            let m = run(&scenario(&body, &slope, "0", duration));
            let moved = moved(&body, angle, m.final_base_position);
            let way = 0.5 * G * angle.sin() * duration * duration;
            // A parabola, exact for the integrator; rounding.
            assert!((moved - slope.downhill * way).norm() < 1e-12, "{moved} {way}");
            assert!(m.max_lift_m.unwrap() < 1e-12 && m.max_penetration_m < 1e-12);
            assert_eq!((m.inconsistent, m.state_changes), (0, 0));
        }
    }
}

#[test]
fn with_friction_of_1000_a_block_tips_on_a_steep_slope_and_never_slides() {
    for half in [[0.05, 0.08, 0.1], [0.1, 0.05, 0.15], [0.1, 0.1, 0.05]] {
        let body = Body::new(half, 1.3);
        let [a, _, c] = half;
        for k in 0..4 {
            let heading = 0.2 + 1.5 * k as f64;
            for (part, tips) in [(0.999, false), (1.001, true), (1.1, true)] {
                let angle = part * (a / c).atan();
                let slope = slope(angle, heading);
                // The body's x axis points downhill, for any heading of the slope.
                let turned = Rotation3::from_euler_angles(slope.rpy[0], slope.rpy[1], slope.rpy[2]);
                let base = turned * Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
                let (roll, pitch, turn) = base.euler_angles();
                let duration = 0.12;
                let (m, recording) = watch(&format!(
                    "duration = {duration}\nfloor = {{ friction = 1000, rpy = {:?} }}\n{}{TIGHT}",
                    slope.rpy,
                    body.robot(&format!("rpy = [{roll}, {pitch}, {turn}]"))
                ));
                assert_eq!((m.inconsistent, m.first_slip_s, m.jams), (0, None, 0));
                let state = &recording.snapshots.last().expect("the end is reported").soles[0].state;
                // The tilt about the lower edge from the slope.
                let [roll, pitch, turn] = m.final_base_rpy;
                let change = (base.inverse() * Rotation3::from_euler_angles(roll, pitch, turn)).into_inner();
                let tilt = 0.5 * (change[(0, 2)] - change[(2, 0)]).hypot(change[(1, 2)] - change[(2, 1)]);
                let tilt = tilt.asin();
                if !tips {
                    assert!(state == "face-static" && tilt < 1e-12, "{state} {tilt}");
                    continue;
                }
                assert!(state.starts_with("edge") && state.ends_with("static"), "{state}");
                // I phi'' = m g (c sin - a cos)(angle + phi), phi about the edge.
                let inertia = body.inertia()[1] + body.mass * (a * a + c * c);
                let truth = rk4([0.0, 0.0], duration, 2000, |_, [phi, rate]: &[f64; 2]| {
                    let (s, cos) = (angle + phi).sin_cos();
                    [*rate, body.mass * G * (c * s - a * cos) / inertia]
                });
                // Integration at 1e-9.
                assert!((tilt - truth[0]).abs() < 1e-8 && truth[0] > 1e-6, "{part} {tilt} {truth:?}");
            }
        }
    }
}

#[test]
fn an_upright_body_on_a_slope_starts_on_its_lowest_corner_and_ends_flat() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    for heading in [0.2, 1.2, 2.2, 4.2, 5.2, 7.2] {
        let angle = 0.3;
        let slope = slope(angle, heading);
        let text = format!(
            "duration = 3.0\nfloor = {{ friction = 0.9, rpy = {:?} }}\n{}\ncontact = {{ velocity_tolerance = 0.01 }}\n",
            slope.rpy,
            body.robot("")
        );
        let start = simulation(&text);
        let lowest = start.plant().floor.height(&start.plant().state.position);
        let reach =
            (body.corners().iter()).map(|[x, y]| slope.downhill.x * x + slope.downhill.y * y).fold(0.0, f64::max);
        // The centre is half a height above the corners, and the lowest of these is furthest
        // uphill.
        let truth = 0.05 * angle.cos() + reach / angle.cos() * angle.sin();
        assert!((lowest - truth).abs() < 1e-12, "{lowest} {truth}");
        let (m, recording) = watch(&text);
        let end = recording.snapshots.last().expect("the end is reported");
        assert_eq!(end.soles[0].state, "face-static");
        let normal = end.base_pose.rotation * Vector3::z();
        let plane = Rotation3::from_euler_angles(slope.rpy[0], slope.rpy[1], slope.rpy[2]) * Vector3::z();
        assert!((normal - plane).norm() < 1e-9, "it lies flat: {}", (normal - plane).norm());
        assert_eq!(m.inconsistent, 0);
    }
}
