//! Cylinders and capsules that roll, stand, tip and lie along edges, by their closed forms.

use super::body::G;
use super::objects::{assert_clean, finished, motion};
use crate::support::runs::{TIGHT, finish, simulation};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::fs;
use stiction::sim::{NullObserver, Simulation};
use tempfile::TempDir;

/// `rpy` of a rotation.
fn rpy(rotation: &Rotation3<f64>) -> String {
    let (roll, pitch, yaw) = UnitQuaternion::from_rotation_matrix(rotation).euler_angles();
    format!("[{roll}, {pitch}, {yaw}]")
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

/// Normal forces on the patches of object `name`, N, in their order.
fn loads(sim: &Simulation, name: &str) -> Vec<Vec<f64>> {
    let plant = sim.plant();
    let own = |s: &usize| plant.polygons[*s].name().starts_with(name);
    (0..plant.polygons.len()).filter(own).map(|s| plant.solution.normal[s].clone()).collect()
}

#[test]
fn a_cylinder_rolls_down_an_incline() {
    let tilt: f64 = 0.2;
    let start = Vector3::new(tilt.sin(), 0.0, tilt.cos()) * 0.1;
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = 0.5, rpy = [0, {tilt}, 0] }}
        object = [{{ type = \"cylinder\", radius = 0.1, length = 0.3, mass = 2.0, position = {}, rpy = [{FRAC_PI_2}, 0, 0] }}]",
        list(&start)
    ));
    let (position, velocity, omega) = motion(&sim, 0);
    let a = 2.0 / 3.0 * G * tilt.sin();
    let down = Vector3::new(tilt.cos(), 0.0, -tilt.sin());
    assert!((position - start - down * (0.5 * a)).norm() < 1e-9, "{}", (position - start).norm() - 0.5 * a);
    assert!((velocity - down * a).norm() < 1e-9 && (omega - Vector3::y() * (a / 0.1)).norm() < 1e-8);
    // Both ends of the generator carry half of the load.
    let half = 0.5 * 2.0 * G * tilt.cos();
    assert!(loads(&sim, "object")[0].iter().all(|n| (n - half).abs() < 1e-8), "{:?}", loads(&sim, "object"));
    assert_clean(&m);
}

#[test]
fn a_sliding_cylinder_begins_to_roll() {
    let (mu, v0) = (0.3, 2.0);
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = {mu} }}
        object = [{{ type = \"cylinder\", radius = 0.1, length = 0.3, mass = 2.0, position = [0, 0, 0.1],
            rpy = [{FRAC_PI_2}, 0, 0], linear_velocity = [{v0}, 0, 0] }}]"
    ));
    let until = v0 / (3.0 * mu * G);
    let (position, velocity, omega) = motion(&sim, 0);
    assert!((m.first_stick_s.unwrap() - until).abs() < 1e-9, "{:?} {until}", m.first_stick_s);
    let v = 2.0 / 3.0 * v0;
    assert!((velocity - Vector3::x() * v).norm() < 1e-9 && (omega - Vector3::y() * (v / 0.1)).norm() < 1e-8);
    let way = v0 * until - 0.5 * mu * G * until * until + v * (1.0 - until);
    assert!((position - Vector3::new(way, 0.0, 0.1)).norm() < 1e-9, "{position} {way}");
    assert_clean(&m);
}

/// A cylinder on an incline tips when its centre is above the lowest point of the rim: tan a = R/(h/2). The ring has
/// its points elsewhere; a fixed polygon would tip at up to 1.9 % less.
#[test]
fn a_standing_cylinder_tips_over_its_rim() {
    let (r, h): (f64, f64) = (0.1, 0.6);
    for yaw in [0.0, 0.05, 0.1, 0.19, 1.0] {
        for (factor, tips) in [(0.99, false), (1.0 - 1e-6, false), (1.0 + 1e-6, true)] {
            let tilt: f64 = (factor * r / (0.5 * h)).atan();
            let rotation = Rotation3::new(Vector3::y() * tilt) * Rotation3::new(Vector3::z() * yaw);
            let start = rotation * Vector3::z() * (0.5 * h);
            let (sim, m) = finished(&format!(
                "duration = 0.3
                floor = {{ friction = 0.8, rpy = [0, {tilt}, 0] }}
                object = [{{ type = \"cylinder\", radius = {r}, length = {h}, mass = 2.0, position = {}, rpy = {} }}]",
                list(&start),
                rpy(&rotation)
            ));
            let moved = (motion(&sim, 0).0 - start).norm();
            assert_eq!(moved > 1e-9, tips, "{yaw} {factor}: {moved}");
            assert_clean(&m);
        }
    }
}

/// Steady rolling of a disc on its rim. The axis a has the angle t with the vertical and turns with W about it; the
/// centre runs on a circle with the radius c. With the lower end at -l a, the contact point is below the centre by
/// H = l cos t + R sin t and beside it by d = R cos t - l sin t. Rolling gives the spin s = -W (c + d)/R about the
/// axis, and the moment about the centre
///
/// ```text
/// W^2 (m H c + I_x sin t cos t - I_z sin t (cos t - (c + d)/R)) = m g d
/// ```
#[test]
fn a_coin_rolls_steadily_on_its_rim() {
    let (r, l, t, c, m): (f64, f64, f64, f64, f64) = (0.2, 0.02, 1.0, 0.3, 1.5);
    let (sin, cos) = t.sin_cos();
    let (height, beside) = (l * cos + r * sin, r * cos - l * sin);
    let (across, along) = (m * (r * r / 4.0 + l * l / 3.0), m * r * r / 2.0);
    let square = m * G * beside / (m * height * c + across * sin * cos - along * sin * (cos - (c + beside) / r));
    let turn = square.sqrt();
    let spin = -turn * (c + beside) / r;
    let axis = Vector3::new(sin, 0.0, cos);
    let omega = Vector3::z() * turn + axis * spin;
    assert!(square * c / G < 0.9);
    let (sim, metrics) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = 1.0 }}
        object = [{{ type = \"cylinder\", radius = {r}, length = {}, mass = {m}, position = [{c}, 0, {height}],
            rpy = [0, {t}, 0], linear_velocity = [0, {}, 0], angular_velocity = {} }}]",
        2.0 * l,
        turn * c,
        list(&omega)
    ));
    let turned = Matrix3::from(Rotation3::new(Vector3::z() * turn));
    let (position, velocity, after) = motion(&sim, 0);
    let expected = turned * Vector3::new(c, 0.0, height);
    // The motion multiplies the errors of the integrator by some 10 in this time.
    assert!((position - expected).norm() < 1e-8, "{position} {expected}");
    assert!((velocity - turned * Vector3::y() * (turn * c)).norm() < 1e-7, "{velocity}");
    assert!((after - turned * omega).norm() < 1e-6, "{after}");
    assert_clean(&metrics);
}

/// A cylinder falls back from the angle t onto its end: it turns about the rim point P, then, after the plastic impact,
/// about the opposite one. With I = I_x + m (R^2 + h^2/4) about P, the speeds are
///
/// ```text
/// I w^2 / 2 = m g (R sin t + h/2 cos t - h/2)        w' = w (I - 2 m R^2)/I
/// ```
#[test]
fn a_cylinder_rocks_on_its_rim() {
    let (r, h, t, m): (f64, f64, f64, f64) = (0.1, 0.5, 0.1, 2.0);
    let inertia = m * (r * r / 4.0 + h * h / 12.0) + m * (r * r + h * h / 4.0);
    let height = r * t.sin() + 0.5 * h * t.cos();
    let before = (2.0 * m * G * (height - 0.5 * h) / inertia).sqrt();
    let after = before * (1.0 - 2.0 * m * r * r / inertia);
    for yaw in [0.0, 0.1] {
        // The rim point at +x is the pivot.
        let rotation = Rotation3::new(Vector3::y() * t) * Rotation3::new(Vector3::z() * yaw);
        let centre = Vector3::new(r, 0.0, 0.0) + Rotation3::new(Vector3::y() * t) * Vector3::new(-r, 0.0, 0.5 * h);
        let (sim, metrics) = finished(&format!(
            "duration = 0.25
            floor = {{ friction = 1.0 }}
            object = [{{ type = \"cylinder\", radius = {r}, length = {h}, mass = {m}, position = {}, rpy = {} }}]",
            list(&centre),
            rpy(&rotation)
        ));
        let (position, _, omega) = motion(&sim, 0);
        let loss = 0.5 * inertia * (before * before - after * after);
        assert!((metrics.impact_loss_j - loss).abs() < 1e-9, "{} {loss}", metrics.impact_loss_j);
        // Now it turns about -x.
        let energy = 0.5 * inertia * omega.norm_squared() + m * G * (position.z - 0.5 * h);
        assert!((energy - 0.5 * inertia * after * after).abs() < 1e-9, "{energy}");
        assert!(omega.y < 0.0 && omega.xz().norm() < 1e-9 && position.y.abs() < 1e-9, "{omega} {position}");
        assert_clean(&metrics);
    }
}

/// A capsule and a cylinder across two rails, the uppermost edges of boxes: the loads by the lever arms.
#[test]
fn a_rod_across_two_rails_loads_them_by_its_lever_arms() {
    let (distance, off, m): (f64, f64, f64) = (0.4, 0.07, 2.0);
    let rail = |x: f64| {
        format!("{{ type = \"box\", size = [0.1, 1, 0.1], position = [{x}, 0, 0.2], rpy = [0, {FRAC_PI_4}, 0] }}")
    };
    for kind in ["capsule", "cylinder"] {
        let height = 0.2 + 0.05 * 2.0f64.sqrt() + 0.06;
        let (sim, metrics) = finished(&format!(
            "duration = 1.0
            floor = {{ friction = 0.5 }}
            terrain = [{}, {}]
            object = [{{ type = \"{kind}\", radius = 0.06, length = 0.6, mass = {m}, position = [{off}, 0, {height}], rpy = [0, {FRAC_PI_2}, 0] }}]",
            rail(-0.5 * distance),
            rail(0.5 * distance)
        ));
        let right = m * G * (0.5 + off / distance);
        let found = loads(&sim, "object");
        // Both points are in one plane, and so in one patch.
        let mut found = found.concat();
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), 2, "{kind}");
        assert!((found[0] - (m * G - right)).abs() < 1e-9 && (found[1] - right).abs() < 1e-9, "{found:?}");
        assert!(metrics.final_object_shift_m.unwrap() < 1e-12);
        assert_clean(&metrics);
    }
}

/// A capsule and a cylinder lie between two rails along them, without friction: each rail carries
/// m g/(2 cos a) with sin a = c/R, and its two corners share this by the lever arms.
#[test]
fn a_rod_between_two_rails_touches_each_along_a_segment() {
    let (r, c, off, m): (f64, f64, f64, f64) = (0.1, 0.06, 0.05, 2.0);
    let rail = |x: f64| {
        format!("{{ type = \"box\", size = [0.05, 0.4, 0.05], position = [{x}, 0, 0.3], rpy = [0, {FRAC_PI_4}, 0] }}")
    };
    let cos = (1.0 - (c / r) * (c / r)).sqrt();
    let height = 0.3 + 0.025 * 2.0f64.sqrt() + r * cos;
    // The rails end at y = 0.2, the rod at off +- 0.3.
    for kind in ["capsule", "cylinder"] {
        let (sim, metrics) = finished(&format!(
            "duration = 1.0
            floor = {{ friction = 0.0 }}
            terrain = [{}, {}]
            object = [{{ type = \"{kind}\", radius = {r}, length = 0.6, mass = {m}, position = [0, {off}, {height}], rpy = [{FRAC_PI_2}, 0, 0] }}]",
            rail(-c),
            rail(c)
        ));
        let all = m * G / (2.0 * cos);
        let mut expected = [all * (0.5 - off / 0.4), all * (0.5 + off / 0.4)];
        for mut found in loads(&sim, "object") {
            found.sort_by(f64::total_cmp);
            expected.sort_by(f64::total_cmp);
            assert_eq!(found.len(), 2, "{kind}");
            assert!(found.iter().zip(&expected).all(|(n, e)| (n - e).abs() < 1e-9), "{found:?} {expected:?}");
        }
        assert_eq!(loads(&sim, "object").len(), 2);
        assert!(metrics.final_object_shift_m.unwrap() < 1e-12);
        assert_clean(&metrics);
    }
}

/// A cylinder across a table's edge, and one that is pushed over: with its centre on the table it stays, beyond it
/// falls.
#[test]
fn a_lying_cylinder_falls_off_a_table_when_its_centre_does() {
    for (centre, falls) in [(-1e-6, false), (1e-6, true)] {
        let (sim, m) = finished(&format!(
            "duration = 0.5
            floor = {{ friction = 0.5 }}
            terrain = [{{ type = \"box\", size = [1, 1, 0.4], position = [-0.5, 0, 0.2] }}]
            object = [{{ type = \"cylinder\", radius = 0.1, length = 0.6, mass = 2.0, position = [{centre}, 0, 0.5], rpy = [0, {FRAC_PI_2}, 0] }}]"
        ));
        let moved = (motion(&sim, 0).0 - Vector3::new(centre, 0.0, 0.5)).norm();
        assert_eq!(moved > 1e-9, falls, "{centre}: {moved}");
        assert_clean(&m);
    }
}

/// A tin and a coin are thrown, tumble and roll: nothing but impacts and friction takes energy.
#[test]
fn thrown_cylinders_keep_the_balance_of_energy() {
    for (r, h) in [(0.1, 0.2), (0.15, 0.04)] {
        let (sim, m) = finished(&format!(
            "duration = 3.0
            floor = {{ friction = 0.6 }}
            object = [{{ type = \"cylinder\", radius = {r}, length = {h}, mass = 1.0, position = [0, 0, 0.5],
                rpy = [0.3, 0.4, 0.2], linear_velocity = [0.5, 0, 0], angular_velocity = [1, 2, 3] }}]"
        ));
        let (position, velocity, omega) = motion(&sim, 0);
        let across = r * r / 4.0 + h * h / 12.0;
        let state = &sim.plant().objects.list[0].state;
        let along = state.rotation.inverse() * omega;
        let spin = across * (along.x * along.x + along.y * along.y) + 0.5 * r * r * along.z * along.z;
        let energy = 0.5 * velocity.norm_squared() + 0.5 * spin + G * position.z;
        let turned = UnitQuaternion::from_euler_angles(0.3, 0.4, 0.2).inverse() * Vector3::new(1.0, 2.0, 3.0);
        let start_spin = across * (turned.x * turned.x + turned.y * turned.y) + 0.5 * r * r * turned.z * turned.z;
        let start = 0.5 * 0.25 + 0.5 * start_spin + G * 0.5;
        assert!(m.impacts > 0 && m.impact_loss_j > 1.0);
        assert!((start - energy - m.impact_loss_j - m.friction_loss_j).abs() < 1e-9, "{start} {energy} {m:?}");
        assert_clean(&m);
    }
}

/// A robot of one link, a homogeneous cylinder, without soles; written as URDF into a temporary folder.
fn robot(folder: &TempDir, [r, h, m]: [f64; 3], base: &str) -> String {
    let (across, along) = (m * (r * r / 4.0 + h * h / 12.0), m * r * r / 2.0);
    let urdf = format!(
        r#"<robot name="tin"><link name="tin"><inertial><mass value="{m}"/>
        <inertia ixx="{across}" ixy="0" ixz="0" iyy="{across}" iyz="0" izz="{along}"/></inertial>
        <collision><geometry><cylinder radius="{r}" length="{h}"/></geometry></collision></link></robot>"#
    );
    fs::write(folder.path().join("tin.urdf"), urdf).expect("the folder is writable");
    format!(
        "robot = {{ model = {:?}, base = {{ {base} }}, soles = [], contact = \"bodies\" }}\nfloor = {{ plane = false }}\n{TIGHT}",
        folder.path().join("tin.urdf")
    )
}

/// The collision cylinder of a link touches floor and terrain as a cylinder: it rolls with 2/3 g sin a.
#[test]
fn a_link_with_one_cylinder_rolls_on_floor_and_terrain() {
    let folder = TempDir::new().expect("a folder for the robot");
    let tilt: f64 = 0.2;
    let up = Vector3::new(tilt.sin(), 0.0, tilt.cos());
    let down = Vector3::new(tilt.cos(), 0.0, -tilt.sin());
    let rpy = format!("rpy = [{FRAC_PI_2}, 0, 0]");
    let a = 2.0 / 3.0 * G * tilt.sin();
    let base = format!("position = {}, {rpy}", list(&(up * 0.15)));
    let sim = ended(&format!(
        "duration = 0.5\n{}
        terrain = [{{ type = \"box\", size = [4, 1, 0.1], rpy = [0, {tilt}, 0], friction = 0.5 }}]",
        robot(&folder, [0.1, 0.3, 2.0], &base)
    ));
    let state = &sim.plant().state;
    assert!((state.position - up * 0.15 - down * (0.125 * a)).norm() < 1e-9, "{}", state.position);
    // Without a position the surface is r / cos a below the base.
    let floor = format!("floor = {{ friction = 0.5, rpy = [0, {tilt}, 0] }}");
    let text = robot(&folder, [0.1, 0.3, 2.0], &rpy).replace("floor = { plane = false }", &floor);
    let sim = ended(&format!("duration = 0.5\n{text}"));
    let start = Vector3::new(0.0, 0.0, 0.1 / tilt.cos());
    let state = &sim.plant().state;
    assert!((state.position - start - down * (0.125 * a)).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
}

/// A body of one ball without soles of its own gets none: it rolls with 5/7 g sin a.
#[test]
fn a_ball_without_soles_rolls() {
    let folder = TempDir::new().expect("a folder for the robot");
    let urdf = r#"<robot name="ball"><link name="ball"><inertial><mass value="1"/>
        <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.004"/></inertial>
        <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"#;
    let path = folder.path().join("ball.urdf");
    fs::write(&path, urdf).expect("the folder is writable");
    let (slope, mu) = (0.3_f64, 0.4);
    let sim = ended(&format!(
        "duration = 0.5\ngravity = [{}, 0, {}]\nrobot = {{ model = {path:?} }}\nfloor = {{ friction = {mu} }}\n{TIGHT}",
        G * slope.sin(),
        -G * slope.cos()
    ));
    let state = &sim.plant().state;
    let travel = 5.0 / 7.0 * G * slope.sin() * 0.125;
    assert!((state.position - Vector3::new(travel, 0.0, 0.1)).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
}

/// A push at the height H that grows to F in one second tips a standing cylinder if F H > m g R, whatever its
/// direction. The fixed polygon of the end would tip at up to 1.9 % less.
#[test]
fn a_ramped_push_tips_a_standing_cylinder_over_its_rim() {
    let folder = TempDir::new().expect("a folder for the robot");
    let [r, h, m] = [0.1, 0.5, 2.0];
    let top = 0.4;
    for yaw in [0.0f64, 0.1, 0.7, 2.1] {
        for (factor, tips) in [(1.0 - 1e-5, false), (1.0 + 1e-5, true)] {
            let force = factor * m * G * r / top;
            let sim = ended(&format!(
                "duration = 1.3\n{}
                terrain = [{{ type = \"box\", size = [1, 1, 0.1], position = [0, 0, -0.05], friction = 0.9 }}]
                force = [{{ type = \"ramp\", link = \"tin\", point = [0, 0, {}], force = [{}, {}, 0] }}]",
                robot(&folder, [r, h, m], "position = [0, 0, 0.25]"),
                top - 0.5 * h,
                force * yaw.cos(),
                force * yaw.sin()
            ));
            let moved = (sim.plant().state.position - Vector3::z() * 0.25).norm();
            assert_eq!(moved > 1e-9, tips, "{yaw} {factor}: {moved}");
        }
    }
}

/// Rods that fall by 0.2 m, inclined, hit the floor with the lower end and come to lie on it. A step of 1 ms turns
/// them by up to 0.04 rad: the point of contact moves along the end, which is then lower by the square of the
/// turn, some 1e-8 m; the lowest point of a rim lower by half of it times the radius.
#[test]
fn inclined_rods_land_in_fixed_steps() {
    for (kind, depth) in [("capsule", 1e-7), ("cylinder", 5e-5)] {
        for method in ["exact", "lcp", "ncp"] {
            for tilt in [0.3, 0.6, 1.2] {
                let mut sim = simulation(&format!(
                    "duration = 1.5
                    robot = {{ model = \"robots/block/block.toml\" }}
                    floor = {{ friction = 0.5 }}
                    contact = {{ method = \"{method}\" }}
                    integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
                    object = [{{ type = \"{kind}\", radius = 0.06, length = 0.4, mass = 2.0, position = [2, 0, 0.5],
                        rpy = [0, {tilt}, 0] }}]"
                ));
                let metrics = finish(&mut sim, &mut NullObserver);
                let (position, _, _) = motion(&sim, 0);
                assert!(metrics.max_penetration_m < depth, "{kind} {method} {tilt}: {}", metrics.max_penetration_m);
                assert!((position.z - 0.06).abs() < depth, "{kind} {method} {tilt}: {}", position.z);
            }
        }
    }
}

fn ended(scenario: &str) -> Simulation {
    let mut sim = simulation(scenario);
    let metrics = finish(&mut sim, &mut NullObserver);
    assert!(metrics.inconsistent == 0 && metrics.energy_error_j.abs() < 1e-9, "{metrics:?}");
    sim
}
