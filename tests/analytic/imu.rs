//! Readings of an IMU at any pose on the robot, and base estimators that use it.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, root, run, simulation, watch};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;
use std::fs;
use stiction::sim::EstimateSnapshot;
use tempfile::TempDir;

pub const HOAP2: &str = "robots/hoap2/hoap2";

/// A robot file for a URDF of the repository, with additional lines at its end.
pub fn with(robot: &str, urdf: &str, more: &str) -> (TempDir, String) {
    let folder = TempDir::new().expect("a folder for the robot");
    let text = match robot {
        "" => "urdf = \"\"\n".to_owned(),
        file => fs::read_to_string(root().join(file)).expect("it is there"),
    };
    let (first, rest) = text[text.find("urdf = ").expect("a key")..].split_once('\n').expect("lines");
    assert!(first.starts_with("urdf = "));
    let path = folder.path().join("robot.toml");
    fs::write(&path, format!("urdf = {:?}\n{rest}\n{more}\n", root().join(urdf))).expect("the folder is writable");
    let model = format!("{path:?}");
    (folder, model)
}

/// A free body with an IMU, `base` as in a scenario; returns the readings at the ticks.
fn spinning(imu: &str, base: &str, more: &str) -> Vec<EstimateSnapshot> {
    let body = Body::new([0.12, 0.06, 0.03], 2.5);
    let urdf = body.floating("");
    let urdf = urdf.split('"').nth(1).expect("a path");
    let (_folder, model) = with("", urdf, &format!("[sensors]\nimu = [{imu}]"));
    let text = format!(
        "duration = 0.5\ngravity = [0.0, 0.0, 0.0]\nlog = {{ rate = 100.0 }}\ncontrol = {{ rate = 100.0 }}
        robot = {{ model = {model}, base = {{ {base} }}, soles = [] }}
        sensors = {{ imu = \"chip\" }}\nintegrator = {{ relative_tolerance = 1e-11, absolute_tolerance = 1e-13 }}\n{more}"
    );
    let recording = watch(&text).1.snapshots.into_iter().map(|s| s.estimate.expect("an IMU is named"));
    let readings: Vec<_> = recording.collect();
    // The end of the run is no tick: its reading is that of the previous tick.
    assert_eq!(readings.len(), 51);
    readings[..50].to_vec()
}

/// Mean acceleration over the tick before `k` of a point at distance `r` along x on a body that
/// rotates about z by `angle(t)` at `rate(t)`, in axes half way between the two ticks.
fn circling(r: f64, k: usize, angle: impl Fn(f64) -> f64, rate: impl Fn(f64) -> f64) -> Vector3<f64> {
    let (t, dt) = (k as f64 * 0.01, 0.01);
    let v = |t: f64| Vector3::new(-angle(t).sin(), angle(t).cos(), 0.0) * (r * rate(t));
    let middle = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5 * (angle(t) + angle(t - dt)));
    middle.inverse() * ((v(t) - v(t - dt)) / dt)
}

#[test]
fn off_the_axis_of_a_spin_it_reads_the_centripetal_acceleration() {
    let (r, w) = (0.1, 7.0);
    let readings = spinning(
        &format!("{{ name = \"chip\", link = \"block\", position = [{r}, 0, 0] }}"),
        &format!("angular_velocity = [0.0, 0.0, {w}]"),
        "",
    );
    assert_eq!(readings[0].specific_force, Vector3::zeros(), "the first reading is one at rest");
    for (k, e) in readings.iter().enumerate().skip(1) {
        assert!((e.angular_velocity - Vector3::new(0.0, 0.0, w)).norm() < 1e-9, "{k} {}", e.angular_velocity);
        // The mean of w^2 r over the arc of a tick: its chord is shorter by sin(x) / x, x half the
        // arc.
        let half = 0.5 * w * 0.01;
        let truth = Vector3::new(-w * w * r * half.sin() / half, 0.0, 0.0);
        // The same from the circle itself, and the reading of integration at 1e-11 divided by the
        // tick.
        assert!((circling(r, k, |t| w * t, |_| w) - truth).norm() < 1e-12);
        assert!((e.specific_force - truth).norm() < 1e-8, "{k} {} {truth}", e.specific_force);
    }
}

#[test]
fn on_an_accelerating_body_it_reads_the_tangential_acceleration_in_its_own_axes() {
    let (r, moment) = (0.1, 0.2);
    // Inertia about z of the body of `spinning`: m (a^2 + b^2) / 3.
    let alpha = moment / (2.5 * (0.12 * 0.12 + 0.06 * 0.06) / 3.0);
    let readings = spinning(
        // Rotated by a right angle about x: its y is the body's z, its z the body's -y.
        &format!("{{ name = \"chip\", link = \"block\", position = [{r}, 0, 0], rpy = [\"90 deg\", 0, 0] }}"),
        "",
        &format!("force = [{{ type = \"constant\", link = \"block\", moment = [0.0, 0.0, {moment}] }}]"),
    );
    for (k, e) in readings.iter().enumerate().skip(1) {
        let t = k as f64 * 0.01;
        let body = circling(r, k, |t| 0.5 * alpha * t * t, |t| alpha * t);
        let truth = Vector3::new(body.x, body.z, -body.y);
        assert!(truth.z < -0.9 * alpha * r, "the tangential part is there");
        // Integration at 1e-11, divided by the tick.
        assert!((e.specific_force - truth).norm() < 1e-8, "{k} {} {truth}", e.specific_force);
        assert!((e.angular_velocity - Vector3::new(0.0, alpha * t, 0.0)).norm() < 1e-8, "{k}");
        let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.5 * alpha * t * t)
            * Rotation3::from_euler_angles(0.5 * PI, 0.0, 0.0);
        assert!((e.orientation.to_rotation_matrix().matrix() - turn.matrix()).norm() < 1e-9, "{k}");
    }
}

#[test]
fn on_a_moved_link_it_reads_that_links_motion() {
    let imu = "[sensors]\nimu = [{ name = \"tip\", link = \"lower\", position = [0, 0, -0.3] }]";
    let (_folder, model) = with("", "robots/pendulum/pendulum.urdf", imu);
    let (_, recording) = watch(&format!(
        "duration = 0.5\nlog = {{ rate = 200.0 }}\ncontrol = {{ rate = 200.0 }}\nsensors = {{ imu = \"tip\" }}
        integrator = {{ relative_tolerance = 1e-11, absolute_tolerance = 1e-13 }}
        [robot]\nmodel = {model}\nsoles = []\njoint_default = {{ mode = \"passive\" }}
        posture = {{ shoulder = 0.5, elbow = -1.0 }}\nvelocity = {{ shoulder = 1.0, elbow = 4.0 }}\n"
    ));
    // Both bars rotate about y: a point l below a joint at angle a moves by l a' (-cos a, 0, sin
    // a).
    let velocity = |s: &stiction::sim::Snapshot| {
        let ([a, b], [p, q]) = ([s.q[0], s.q[0] + s.q[1]], [s.qd[0], s.qd[0] + s.qd[1]]);
        let bar = |l: f64, a: f64, rate: f64| Vector3::new(-a.cos(), 0.0, a.sin()) * (l * rate);
        bar(0.5, a, p) + bar(0.3, b, q)
    };
    assert!(recording.snapshots.len() == 101);
    for pair in recording.snapshots.windows(2) {
        let (before, now) = (&pair[0], &pair[1]);
        let e = now.estimate.as_ref().expect("an IMU is named");
        if e.time != now.time {
            // The end of the run is no tick.
            continue;
        }
        let (a, b) = (before.q[0] + before.q[1], now.q[0] + now.q[1]);
        let middle = Rotation3::from_euler_angles(0.0, 0.5 * (a + b), 0.0);
        let mean = (velocity(now) - velocity(before)) / (now.time - before.time);
        let truth = middle.inverse() * (mean + Vector3::new(0.0, 0.0, G));
        // The orientation half way between ticks: the sine of an arc x comes from 1 - cos^2, good
        // to 1e-16 / x^2, 2e-9 at worst. It rotates some 50 m/s^2.
        assert!((e.specific_force - truth).norm() < 2e-7, "{} {} {truth}", now.time, e.specific_force);
        assert!((e.angular_velocity - Vector3::new(0.0, now.qd[0] + now.qd[1], 0.0)).norm() < 1e-13);
        assert!(e.orientation.angle_to(&nalgebra::UnitQuaternion::from_euler_angles(0.0, b, 0.0)) < 1e-7);
    }
}

#[test]
fn integrating_from_a_displaced_and_rotated_imu_is_of_second_order() {
    let body = Body::new([0.12, 0.06, 0.03], 2.5);
    let urdf = body.floating("");
    let imu =
        "[sensors]\nimu = [{ name = \"a\", link = \"block\", position = [0.1, -0.05, 0.02], rpy = [0.4, -0.7, 2.0] }]";
    let (_folder, model) = with("", urdf.split('"').nth(1).expect("a path"), imu);
    let error = |rate: f64| {
        let m = run(&format!(
            "duration = 1.0\ncontrol = {{ rate = {rate}, estimator = \"inertial\" }}
            robot = {{ model = {model}, soles = [], base = {{ position = [0.0, 0.0, 9.0], rpy = [0.2, 0.1, 0.0],
            linear_velocity = [0.3, -0.2, 1.0], angular_velocity = [3.0, 8.0, -2.0] }} }}\n{TIGHT}"
        ));
        (m.final_estimate_error_rad.unwrap(), m.final_estimate_error_m.unwrap())
    };
    let ((turn, way), (fine_turn, fine_way)) = (error(250.0), error(500.0));
    assert!(turn > 1e-6 && way > 1e-6, "{turn} {way}");
    // Terms of order T^3 change the ratios by some T / (time scale of the motion), 1/30; the last ticks differ by 2 ms.
    assert!((turn / fine_turn - 4.0).abs() < 0.3, "{turn} {fine_turn}");
    assert!((way / fine_way - 4.0).abs() < 0.3, "{way} {fine_way}");
}

/// HOAP-2 bends its knees, its waist and its head, with an IMU in the head.
fn nodding(imu: &str, more: &str) -> stiction::sim::Metrics {
    let (_folder, model) = with(&format!("{HOAP2}.toml"), &format!("{HOAP2}.urdf"), imu);
    let text = fs::read_to_string(root().join("scenarios/knee-bend.toml")).expect("it is there");
    let text = text.replace("\"../robots/hoap2/hoap2.toml\"", &model).replace("duration = 6.0", "duration = 2.5");
    let text = text[..text.find("[[expect]]").unwrap()].to_owned();
    run(&format!(
        "{text}\n[[task]]\ntype = \"sine\"
        joints = {{ head_pan = {{ amplitude = 0.5 }}, head_tilt = {{ amplitude = 0.25, frequency = 1.7 }} }}\n{more}\n"
    ))
}

pub const HEAD: &str =
    "[sensors]\nimu = [{ name = \"head\", link = \"head\", position = [0.03, 0.01, 0.05], rpy = [0.3, -0.2, 1.0] }]";

#[test]
fn the_chain_from_the_head_to_static_soles_is_exact_to_rounding() {
    let m = nodding(HEAD, "[control]\nestimator = \"kinematic\"");
    // Static soles keep their position except for drift that is projected out, 1e-10 m.
    assert!(m.max_estimate_error_m.unwrap() < 1e-9, "{:?}", m.max_estimate_error_m);
    // Rotation along the chain and back: rounding of a dozen products.
    assert!(m.max_estimate_error_rad.unwrap() < 1e-14, "{:?}", m.max_estimate_error_rad);
}

/// Two bodies on a free joint, thrown upwards; the root is the heavier one, the IMU is on the
/// other.
fn thrown(rate: f64, source: &str) -> stiction::sim::Metrics {
    let inertial = |m: f64, [xx, yy, zz]: [f64; 3]| {
        format!(
            "<inertial><origin xyz=\"0 0.01 -0.1\"/><mass value=\"{m}\"/>\
             <inertia ixx=\"{xx}\" ixy=\"0\" ixz=\"0\" iyy=\"{yy}\" iyz=\"0\" izz=\"{zz}\"/></inertial>"
        )
    };
    let urdf = format!(
        "<robot name=\"pair\"><link name=\"big\">{}</link><link name=\"small\">{}</link>\
         <joint name=\"free\" type=\"continuous\"><origin xyz=\"0.1 0 -0.2\" rpy=\"0.3 0 0\"/><parent link=\"big\"/>\
         <child link=\"small\"/><axis xyz=\"0 1 0\"/></joint></robot>",
        inertial(3.0, [0.02, 0.03, 0.04]),
        inertial(1.0, [0.01, 0.012, 0.004])
    );
    let folder = TempDir::new().expect("a folder for the robot");
    fs::write(folder.path().join("pair.urdf"), urdf).expect("the folder is writable");
    let imu = "[sensors]\nimu = [{ name = \"chip\", link = \"small\", position = [0.05, 0.02, -0.2], rpy = [1.0, 0.4, -2.0] }]";
    let path = folder.path().join("pair.toml");
    fs::write(&path, format!("urdf = \"pair.urdf\"\n{imu}\n")).expect("the folder is writable");
    run(&format!(
        "duration = 1.0\n[robot]\nmodel = {path:?}\nsoles = []\njoint_default = {{ mode = \"passive\" }}
        velocity = {{ free = 5.0 }}\nbase = {{ position = [0, 0, 9], linear_velocity = [0.3, 0, 2], angular_velocity = [1, -2, 3] }}
        [control]\nrate = {rate}\nestimator = \"inertial\"\ninertial = {{ acceleration = \"{source}\" }}
        [integrator]\nrelative_tolerance = 1e-10\nabsolute_tolerance = 1e-12\n"
    ))
}

#[test]
fn integrating_from_an_imu_on_a_moving_link_locates_the_base_in_second_order() {
    for source in ["accelerometer", "soles"] {
        let error = |rate: f64| {
            let m = thrown(rate, source);
            (m.final_estimate_error_rad.unwrap(), m.final_estimate_error_m.unwrap())
        };
        let ((turn, way), (fine_turn, fine_way)) = (error(250.0), error(500.0));
        assert!((1e-6..1e-2).contains(&turn) && (1e-7..1e-2).contains(&way), "{source} {turn} {way}");
        // Terms of order T^3 change the ratios by some T / (time scale of the motion), 1/30; the last ticks differ by 2 ms.
        assert!((turn / fine_turn - 4.0).abs() < 0.3, "{source} {turn} {fine_turn}");
        assert!((way / fine_way - 4.0).abs() < 0.3, "{source} {way} {fine_way}");
    }
}

#[test]
fn an_encoder_bias_between_imu_and_base_rotates_the_base_by_the_bias() {
    // The pelvis hangs below the torso, the root, on the waist joint. Every joint reads too much by
    // the bias, but only the waist is between them.
    let imu = "[sensors]\nimu = [{ name = \"pelvis\", link = \"pelvis\" }]";
    let bias = 0.01;
    let m =
        nodding(imu, &format!("[sensors]\njoint_position = {{ bias = {bias} }}\n[control]\nestimator = \"kinematic\""));
    // Rounding.
    assert!((m.max_estimate_error_rad.unwrap() - bias).abs() < 1e-13, "{:?}", m.max_estimate_error_rad);
    assert!((m.final_estimate_error_rad.unwrap() - bias).abs() < 1e-13);
}

#[test]
fn the_first_imu_is_the_default_and_one_at_the_base_equals_the_base() {
    let two = "[sensors]\nimu = [{ name = \"base\", link = \"torso\" }, { name = \"head\", link = \"head\" }]";
    let (_folder, model) = with(&format!("{HOAP2}.toml"), &format!("{HOAP2}.urdf"), two);
    let text = |robot: &str, sensors: &str| {
        format!(
            "duration = 0.2\nrobot = {{ model = {robot} }}\nsensors = {{ {sensors} }}\n[[force]]\ntype = \"push\"\nlink = \"torso\"\nforce = [8.0, 3.0, 0.0]\n"
        )
    };
    let last = |text: &str| watch(text).1.snapshots.pop().expect("the end").estimate.expect("sensors are named");
    // A zero bias: the table is present, and the readings are exact.
    let first = last(&text(&model, "gyroscope = { resolution = 1e-30 }"));
    let named = last(&text(&model, "imu = \"base\""));
    let none = last(&text(&format!("\"{HOAP2}.toml\""), "gyroscope = { resolution = 1e-30 }"));
    let head = last(&text(&model, "imu = \"head\""));
    assert_eq!(first.specific_force, named.specific_force);
    // Rounding, divided by the tick.
    assert!((none.specific_force - named.specific_force).norm() < 1e-11);
    assert!((none.angular_velocity - named.angular_velocity).norm() < 1e-14 && none.angular_velocity.norm() > 1e-3);
    assert!((head.specific_force - named.specific_force).norm() > 1e-3);
}

#[test]
fn an_unknown_imu_is_an_error_with_its_position() {
    let fault = |robot: &str, name: &str| {
        let text = format!("robot = {{ model = {robot} }}\nsensors = {{ imu = \"{name}\" }}\n");
        let file = stiction::scenario::parse(&root().join("test.toml"), &text).unwrap();
        let runs = file.expand(&[]).unwrap();
        let robot = stiction::robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap();
        stiction::assemble::setup(&runs[0], &robot).err().expect("no such IMU").to_string()
    };
    let none = fault(&format!("\"{HOAP2}.toml\""), "head");
    assert!(none.contains("test.toml:2:19") && none.contains("has no IMU `head`"), "{none}");
    assert!(none.contains("its robot file has no IMU"), "{none}");
    let (_folder, model) = with(&format!("{HOAP2}.toml"), &format!("{HOAP2}.urdf"), HEAD);
    let near = fault(&model, "haed");
    assert!(near.contains("has no IMU `haed`") && near.contains("did you mean `head`?"), "{near}");
}

#[test]
fn scripts_read_the_rate_of_a_moved_imu() {
    let imu = "[sensors]\nimu = [{ name = \"tip\", link = \"lower\", rpy = [0, 0, 0] }]";
    let (folder, model) = with("", "robots/pendulum/pendulum.urdf", imu);
    // The script ends the run with an error unless it reads the rate of the second bar.
    let script = "function run(robot)\n local rate = robot.qd[1] + robot.qd[2]\n \
                  if math.abs(robot.imu.angular_velocity[2] - rate) > 1e-12 then error('not the link') end\nend\n";
    fs::write(folder.path().join("look.luau"), script).unwrap();
    let mut sim = simulation(&format!(
        "duration = 0.1\n[robot]\nmodel = {model}\nsoles = []\njoint_default = {{ mode = \"passive\" }}
        posture = {{ shoulder = 0.5 }}\nvelocity = {{ elbow = 4.0 }}
        [[task]]\ntype = \"script\"\nfile = {:?}\n",
        folder.path().join("look.luau")
    ));
    crate::support::runs::finish(&mut sim, &mut stiction::sim::NullObserver);
}
