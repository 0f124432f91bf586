//! Torsional and rolling friction of point contacts by closed forms: balls that spin and roll to rest, limits
//! that hold, moments that break away, and a body that stands on a point.

use super::body::{Body, G};
use super::objects::{assert_clean, motion};
use crate::support::runs::{Recording, TIGHT, finish, run, simulation, watch};
use nalgebra::{Matrix2, Vector2, Vector3};
use stiction::sim::{Metrics, NullObserver, Simulation};

/// Radius, mass and inertia of the ball.
const R: f64 = 0.1;
const M: f64 = 2.0;
const I: f64 = 0.4 * M * R * R;

/// A run of objects with located events; its events and, at rest, its end.
fn finished(scenario: &str) -> (Simulation, Metrics, Recording) {
    finished_with("", scenario)
}

/// The same with more keys of `contact`.
fn finished_with(contact: &str, scenario: &str) -> (Simulation, Metrics, Recording) {
    let mut sim = simulation(&format!(
        "robot = {{ model = \"robots/ground/ground.urdf\" }}
        integrator = {{ relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }}
        contact = {{ distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8{contact} }}
        log = {{ rate = 0 }}\n{scenario}"
    ));
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    (sim, metrics, recording)
}

/// Floor with these lengths of torsional and rolling friction, and a ball on it.
fn ball(torsional: f64, rolling: f64, more: &str) -> String {
    format!(
        "floor = {{ friction = {{ static = 0.8, kinetic = 0.6, torsional = {torsional}, rolling = {rolling} }} }}
        object = [{{ type = \"sphere\", name = \"ball\", radius = {R}, mass = {M}, position = [0, 0, {R}], {more} }}]\n"
    )
}

/// Time of the first event with this text.
fn time_of(recording: &Recording, message: &str) -> Option<f64> {
    recording.events.iter().find(|e| e.kind == "turning" && e.message == message).map(|e| e.time)
}

/// w = w0 - mu_t m g t / I, and rest from the instant at which it is zero.
#[test]
fn a_spinning_ball_stops() {
    for (mu, w0) in [(0.004f64, 5.0f64), (0.02, -30.0)] {
        let rate = mu * M * G / I;
        let t = w0.abs() / rate;
        let spinning = ball(mu, 0.0, &format!("angular_velocity = [0, 0, {w0}]"));
        let (sim, m, _) = finished(&format!("duration = {}\n{spinning}", 0.5 * t));
        assert!((motion(&sim, 0).2.z - 0.5 * w0).abs() < 1e-10, "{}", motion(&sim, 0).2);
        assert_clean(&m);
        let (sim, m, recording) = finished(&format!("duration = {}\n{spinning}", 1.5 * t));
        // The event is located to 1e-13 of a step.
        assert!((time_of(&recording, "spin ends").unwrap() - t).abs() < 1e-11, "{:?} {t}", recording.events);
        let angle = 0.5 * w0 * t;
        let turned = sim.plant().objects.list[0].state.rotation.scaled_axis();
        let wrapped = (turned.z - angle).rem_euclid(std::f64::consts::TAU);
        assert!(wrapped.min(std::f64::consts::TAU - wrapped) < 1e-9, "{turned} {angle}");
        assert_eq!(motion(&sim, 0).2, Vector3::zeros(), "it rests exactly");
        assert!((m.friction_loss_j - 0.5 * I * w0 * w0).abs() < 1e-11, "{}", m.friction_loss_j);
        assert_clean(&m);
    }
}

/// A moment holds up to mu_t m g; beyond, the ball turns with the difference.
#[test]
fn a_moment_holds_up_to_the_torsional_limit() {
    let (mu, t) = (0.004, 0.5);
    let limit = mu * M * G;
    for excess in [-1e-3, -1e-9, 1e-9, 1e-3, 0.5] {
        let (sim, m, _) = finished(&format!(
            "duration = {t}\n{}
            force = [{{ type = \"constant\", object = \"ball\", moment = [0, 0, {}] }}]",
            ball(mu, 0.0, ""),
            limit * (1.0 + excess)
        ));
        let w = limit * excess.max(0.0) / I * t;
        // Rounding of the moments over the inertia.
        assert!((motion(&sim, 0).2.z - w).abs() < 1e-13 + 1e-11 * w, "{excess}: {} {w}", motion(&sim, 0).2);
        assert!(excess > 0.0 || motion(&sim, 0).2.z.abs() < 1e-16, "{}", motion(&sim, 0).2);
        assert_clean(&m);
    }
}

/// A growing moment breaks away at the limit: yaw of a ball, and tilt of one that cannot slip.
#[test]
fn growing_moments_break_away_at_the_limits() {
    let (mu_t, mu_r) = (0.004, 0.001);
    for (axis, limit, text) in [(2, mu_t * M * G, "spin begins"), (0, mu_r * M * G, "roll begins")] {
        for sign in [1.0, -1.0] {
            let mut moment = [0.0; 3];
            moment[axis] = sign * 1.7 * limit;
            let (_, m, recording) = finished(&format!(
                "duration = 1.0\n{}
                force = [{{ type = \"push\", object = \"ball\", moment = {moment:?}, duration = 1.0, profile = \"ramp\" }}]",
                ball(mu_t, mu_r, "")
            ));
            let at = time_of(&recording, text).unwrap_or_else(|| panic!("{text}: {:?}", recording.events));
            assert!((at * 1.7 - 1.0).abs() < 1e-11, "{text}: {}", at * 1.7 - 1.0);
            assert_clean(&m);
        }
    }
}

/// A rolling ball: v' = -mu_r g / (r (1 + 2/5)), along any heading, also while it spins.
#[test]
fn a_rolling_ball_stops() {
    for (mu_r, v0, heading, spin) in [(0.004, 0.3f64, 0.0f64, 0.0), (0.02, 1.1, 2.0, 7.0), (0.001, 0.2, 4.0, -1.0)] {
        let (a, along) = (mu_r * G / (R * 1.4), Vector3::new(heading.cos(), heading.sin(), 0.0));
        let (t, way) = (v0 / a, v0 * v0 / (2.0 * a));
        let (v, w) = (along * v0, Vector3::z().cross(&along) * (v0 / R) + Vector3::z() * spin);
        let text = ball(
            0.01,
            mu_r,
            &format!("linear_velocity = [{}, {}, 0], angular_velocity = [{}, {}, {}]", v.x, v.y, w.x, w.y, w.z),
        );
        let (sim, m, recording) = finished(&format!("duration = {}\n{text}", 1.2 * t));
        assert!((time_of(&recording, "roll ends").unwrap() - t).abs() < 1e-9, "{:?} {t}", recording.events);
        let (position, velocity, omega) = motion(&sim, 0);
        assert!((position - Vector3::z() * R - along * way).norm() < 1e-9, "{position} {way}");
        assert!(velocity.norm() < 1e-14 && omega.norm() < 1e-13, "{velocity} {omega}");
        let loss = 0.5 * 1.4 * M * v0 * v0 + 0.5 * I * spin * spin;
        assert!((m.friction_loss_j - loss).abs() < 1e-9, "{} {loss}", m.friction_loss_j);
        assert_clean(&m);
    }
}

/// On a slope the ball rests while tan(tilt) <= mu_r / r, and rolls with g (sin - mu_r / r cos) 5 / 7 beyond.
#[test]
fn a_ball_rests_on_a_slope_up_to_its_rolling_friction() {
    let (mu, t) = (0.01f64, 1.0);
    let limit = (mu / R).atan();
    for (tilt, heading) in [(0.5 * limit, 0.0), (limit * (1.0 - 1e-9), 0.0), (limit * (1.0 + 1e-7), 0.0), (0.2, 1.0)] {
        let (sin, cos) = tilt.sin_cos();
        let down = Vector3::new(cos * f64::cos(heading), cos * f64::sin(heading), -sin);
        let normal = Vector3::new(sin * f64::cos(heading), sin * f64::sin(heading), cos) * R;
        let (sim, m, _) = finished(&format!(
            "duration = {t}
            floor = {{ friction = {{ static = 0.8, kinetic = 0.6, rolling = {mu} }}, rpy = [0, {tilt}, {heading}] }}
            object = [{{ type = \"sphere\", radius = {R}, mass = {M}, position = [{}, {}, {}] }}]",
            normal.x, normal.y, normal.z
        ));
        let a = 5.0 / 7.0 * G * (sin - mu / R * cos).max(0.0);
        let (position, velocity, _) = motion(&sim, 0);
        assert!((velocity - down * (a * t)).norm() < 1e-12 + 1e-10 * a, "{tilt} {heading}: {velocity} {a}");
        assert!((position - normal - down * (0.5 * a * t * t)).norm() < 1e-12 + 1e-10 * a);
        assert_clean(&m);
    }
}

/// A ball that slides begins to roll; its rolling friction acts from the start on the little that it turns.
/// Slip: v' = -mu g, r w' = (mu m g r - mu_r m g) r / I. Then both as in `a_rolling_ball_stops`.
#[test]
fn a_sliding_ball_begins_to_roll_against_rolling_friction() {
    let (mu, mu_r, v0) = (0.6, 0.01, 2.0);
    let turns = (mu * R - mu_r) * M * G * R / I;
    let t = v0 / (mu * G + turns);
    let v = v0 - mu * G * t;
    let a = mu_r * G / (R * 1.4);
    let (sim, m, _) =
        finished(&format!("duration = 1.0\n{}", ball(0.0, mu_r, &format!("linear_velocity = [{v0}, 0, 0]"))));
    assert!((m.first_stick_s.unwrap() - t).abs() < 1e-9, "{:?} {t}", m.first_stick_s);
    let way = v0 * t - 0.5 * mu * G * t * t + v * (1.0 - t) - 0.5 * a * (1.0 - t) * (1.0 - t);
    assert!((motion(&sim, 0).0.x - way).abs() < 1e-9, "{} {way}", motion(&sim, 0).0);
    assert_clean(&m);
}

/// The contact's torsional moment brings a ball and the box below it to a common spin.
#[test]
fn a_ball_and_a_turntable_reach_a_common_spin() {
    let (mu, w0) = (0.005, 8.0);
    let table = 3.0 * (0.4f64.powi(2) + 0.4f64.powi(2)) / 12.0;
    let rate = mu * M * G * (1.0 / I + 1.0 / table);
    let pair = format!(
        ", pair = [{{ bodies = [\"table\", \"ball\"], friction = {{ static = 0.5, kinetic = 0.5, torsional = {mu} }} }}]"
    );
    let (sim, m, recording) = finished_with(&pair, &format!(
        "duration = 1.0
        floor = {{ friction = 0 }}
        object = [
            {{ type = \"box\", name = \"table\", size = [0.4, 0.4, 0.1], mass = 3.0, position = [0, 0, 0.05], angular_velocity = [0, 0, {w0}] }},
            {{ type = \"sphere\", name = \"ball\", radius = {R}, mass = {M}, position = [0, 0, {}] }},
        ]",
        0.1 + R
    ));
    assert!((time_of(&recording, "spin ends").unwrap() - w0 / rate).abs() < 1e-10, "{:?}", recording.events);
    let common = table * w0 / (I + table);
    for o in [0, 1] {
        assert!((motion(&sim, o).2 - Vector3::z() * common).norm() < 1e-10, "{} {common}", motion(&sim, o).2);
    }
    assert_clean(&m);
}

/// A plastic landing changes the spin by mu_t times the normal impulse, and the roll of a ball that sticks by
/// the impulse of rolling friction.
#[test]
fn moments_act_in_impacts() {
    let (mu, w0, height) = (0.002, 9.0, 0.2);
    let impulse = M * f64::sqrt(2.0 * G * height);
    let t = f64::sqrt(2.0 * height / G) + 1e-9;
    let (sim, m, _) = finished(&format!(
        "duration = {t}\n{}",
        ball(mu, 0.0, &format!("angular_velocity = [0, 0, {w0}]"))
            .replace("[0, 0, 0.1]", &format!("[0, 0, {}]", R + height))
    ));
    let after = w0 - mu * impulse / I - mu * M * G / I * 1e-9;
    assert!((motion(&sim, 0).2.z - after).abs() < 1e-9, "{} {after}", motion(&sim, 0).2);
    let loss = M * G * height + 0.5 * I * (w0 * w0 - after * after);
    assert!((m.impact_loss_j - loss).abs() < 1e-6, "{} {loss}", m.impact_loss_j);
}

/// A body stands on a point while its centre of mass is within mu_r of it. Beyond, it falls: its angular
/// acceleration obeys `A alpha = m g (n x e) - mu_r N alpha / |alpha|`, A its inertia about the point, which
/// friction holds, without spin. A is not isotropic, so that it does not fall along its lever.
#[test]
fn a_body_stands_on_a_point_by_rolling_friction() {
    let (body, mu) = (Body::new([0.3, 0.02, 0.1], 3.0), 0.01);
    let scenario = |e: f64| {
        let floor =
            format!("floor = {{ friction = {{ static = 0.8, kinetic = 0.8, torsional = 0.02, rolling = {mu} }} }}");
        format!("{floor}\n{}{TIGHT}", body.on_point([-0.6 * e, -0.8 * e]))
    };
    let m = run(&format!("duration = 2.0\n{}", scenario(mu * (1.0 - 1e-9))));
    assert!(m.max_static_creep_m < 1e-12 && m.max_cone_excess < 1e-9 && m.steps < 1000, "{m:?}");
    let (e, t, h) = (1.5 * mu, 1e-4, body.half[2]);
    let mut sim = simulation(&format!("duration = {t}\n{}", scenario(e)));
    let m = finish(&mut sim, &mut NullObserver);
    let (x, y) = (0.6 * e, 0.8 * e);
    let [ix, iy, _] = body.inertia();
    let a = Matrix2::new(ix + 3.0 * (y * y + h * h), -3.0 * x * y, -3.0 * x * y, iy + 3.0 * (x * x + h * h));
    let inverse = a.try_inverse().unwrap();
    let drive = Vector2::new(-y, x) * (3.0 * G);
    let along = |angle: f64| Vector2::new(angle.cos(), angle.sin());
    let with_direction = |u: Vector2<f64>| {
        let mut alpha = Vector2::zeros();
        // The normal force depends weakly on the acceleration.
        for _ in 0..50 {
            let normal = 3.0 * (G + alpha.x * y - alpha.y * x);
            alpha = inverse * (drive - u * (mu * normal));
        }
        alpha
    };
    let middle = f64::atan2(drive.y, drive.x);
    let (mut low, mut high) = (middle - 1.0, middle + 1.0);
    for _ in 0..60 {
        let angle = 0.5 * (low + high);
        if along(angle).perp(&with_direction(along(angle))) > 0.0 { low = angle } else { high = angle }
    }
    let alpha = with_direction(along(low));
    let v = &sim.plant().state.v;
    let turned = Vector2::new(v[3], v[4]) / t;
    // Relative change of the acceleration within t: t^2 g / h, 1e-6.
    assert!((turned - alpha).norm() < 3e-6 * alpha.norm(), "{turned} {alpha}");
    assert!(alpha.normalize().perp(&drive.normalize()).abs() > 0.05, "not along the lever");
    assert!(v[5].abs() < 1e-9 && m.max_cone_excess < 1e-9 && m.inconsistent == 0, "{m:?}");
}

/// Methods that decide per step stop a ball up to a step late; fixed steps are of first order.
#[test]
fn one_step_and_fixed_steps_have_both() {
    let (mu, v0, w0, step) = (0.01, 0.4, 5.0, 1e-4);
    let a = mu * G / (R * 1.4);
    let way = v0 * v0 / (2.0 * a);
    for (method, integrator) in [
        ("one-step", "integrator = { method = \"dopri5\", max_step = 1e-4 }"),
        ("one-step", "integrator = { method = \"rk4\", step = 1e-4 }"),
        ("one-step", "integrator = { method = \"semi-implicit\", step = 1e-4 }"),
        ("exact", "integrator = { method = \"semi-implicit\", step = 1e-4 }"),
        ("exact", "integrator = { method = \"rosenbrock\" }"),
        ("exact", "integrator = { method = \"bdf\" }"),
        ("exact", "integrator = { method = \"rk4\", step = 1e-3 }"),
    ] {
        let mut sim = simulation(&format!(
            "robot = {{ model = \"robots/ground/ground.urdf\" }}
            {integrator}
            contact = {{ method = \"{method}\" }}
            log = {{ rate = 0 }}
            duration = 1.0\n{}",
            ball(mu, mu, &format!("linear_velocity = [{v0}, 0, 0], angular_velocity = [0, {}, {w0}]", v0 / R))
        ));
        let m = finish(&mut sim, &mut NullObserver);
        let (position, velocity, omega) = motion(&sim, 0);
        assert!((position.x - way).abs() < 2.0 * step * v0, "{method} {integrator}: {position} {way}");
        assert!(velocity.norm() < 1e-9 && omega.norm() < 1e-9, "{method} {integrator}: {velocity} {omega}");
        let loss = 0.5 * 1.4 * M * v0 * v0 + 0.5 * I * w0 * w0;
        assert!((m.friction_loss_j - loss).abs() < 1e-4, "{method} {integrator}: {} {loss}", m.friction_loss_j);
        assert!(m.max_cone_excess < 1e-8 && m.inconsistent == 0, "{method} {integrator}: {m:?}");
    }
}

/// Without the keys and with lengths of zero a run has the same bits.
#[test]
fn lengths_of_zero_change_nothing() {
    let text = |terms: &str| {
        format!(
            "duration = 0.5
            robot = {{ model = \"robots/quadruped/quadruped.toml\" }}
            floor = {{ friction = {{ static = 0.5, kinetic = 0.4{terms} }}, rpy = [0, 0.05, 0] }}\n"
        )
    };
    let (plain, zero) = (watch(&text("")), watch(&text(", viscous = 0, torsional = 0, rolling = 0")));
    assert_eq!(plain.0.friction_loss_j.to_bits(), zero.0.friction_loss_j.to_bits());
    assert_eq!((plain.0.steps, plain.0.evaluations), (zero.0.steps, zero.0.evaluations));
}

/// A ball slides over a rolling one, and neither turns with the normal: a held spin needs the rate of the normal
/// in its condition. Without it the energy changes by 4e-5 J.
#[test]
fn a_spin_is_held_between_two_balls_that_both_move() {
    let (_, m, _) = finished(
        "duration = 0.3
        floor = { friction = { static = 0.05, kinetic = 0.05, torsional = 0.5 } }
        object = [
            { type = \"sphere\", radius = 0.3, mass = 2.0, position = [0, 0, 0.3], angular_velocity = [1.0, 2.0, 0] },
            { type = \"sphere\", radius = 0.1, mass = 1.0, position = [0.04, 0, 0.6979949748426482],
                linear_velocity = [0, 0.5, 0], angular_velocity = [-2.0, 3.0, 0] },
        ]",
    );
    assert!(m.friction_loss_j > 0.01, "{m:?}");
    assert_clean(&m);
}
