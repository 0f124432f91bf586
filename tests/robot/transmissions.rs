//! `[[transmission]]` of robot files: what it makes of the model, and errors.

use super::{BODY, assert_fault, load_toml};
use stiction::robot::adjustments::{self, DriveSettings};
use stiction::robot::{JointId, inspect};

/// Pitch carries roll and a tail; the finger follows roll.
fn urdf() -> String {
    let joint = |name: &str, parent: &str, child: &str, more: &str| {
        format!(
            r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="8" velocity="3"/><dynamics damping="0.1" friction="0.2"/>{more}</joint>
<link name="{child}">{BODY}</link>"#
        )
    };
    format!(
        r#"<robot name="r"><link name="base">{BODY}</link>{}{}{}{}</robot>"#,
        joint("pitch", "base", "cross", ""),
        joint("roll", "cross", "foot", ""),
        joint("tail", "cross", "tip", ""),
        joint("finger", "foot", "nail", r#"<mimic joint="roll" multiplier="2"/>"#),
    )
}

const GOOD: &str = r#"urdf = "robot.urdf"
[joint.pitch]
kp = 10.0
[joint_default]
mode = "passive"
armature = 0.5
[[transmission]]
name = "ankle"
joints = ["pitch", "roll"]
matrix = [[1, 1], [1, -1]]
gear_ratio = [10.0, 20.0]
rotor_inertia = 1e-3
effort = 2
velocity = [30.0, 60.0]
friction = { coulomb = 0.1, viscous = 0.01 }
[[transmission]]
name = "wag"
joints = ["tail"]
gear_ratio = 5.0
rotor_inertia = 1e-3
"#;

const CASES: &[(&str, &str, usize, &str)] = &[
    ("\"roll\"]", "\"rol\"]", 9, "did you mean `roll`?"),
    ("\"roll\"]", "\"pitch\"]", 9, "transmission `ankle` names joint `pitch` twice"),
    ("\"roll\"]", "\"finger\"]", 9, "joint `finger` follows `roll` and has no motor"),
    ("[\"pitch\", \"roll\"]", "[]", 9, "transmission `ankle` has no joints"),
    ("[\"pitch\", \"roll\"]", "[\"roll\", \"tail\"]", 9, "joints `roll` and `tail` are on different branches"),
    ("[\"tail\"]", "[\"roll\"]", 18, "joint `roll` belongs to transmission `ankle` already"),
    ("\"wag\"", "\"ankle\"", 16, "two transmissions named `ankle`"),
    ("matrix = [[1, 1], [1, -1]]\n", "", 7, "transmission `ankle` has 2 joints but no `matrix`"),
    ("[[1, 1], [1, -1]]", "[[1, 1], [2, 2]]", 10, "a singular matrix (expected independent rows"),
    ("[[1, 1], [1, -1]]", "[[0, 0], [1, -1]]", 10, "a singular matrix"),
    ("[[1, 1], [1, -1]]", "[[1, 1], [1, 1.000000000001]]", 10, "a singular matrix"),
    ("[[1, 1], [1, -1]]", "[[1, 1]]", 10, "1 rows (expected 2 rows of 2 finite numbers"),
    ("[[1, 1], [1, -1]]", "[[1, 1], [1, -1, 0]]", 10, "a row of 3 (expected 2 rows of 2 finite numbers"),
    ("[[1, 1], [1, -1]]", "[[1, nan], [1, -1]]", 10, "matrix of transmission `ankle` cannot be used: NaN"),
    ("[10.0, 20.0]", "[10.0, 20.0, 30.0]", 11, "3 numbers (expected a number, or 2 of them, one per motor"),
    ("[10.0, 20.0]", "0.0", 11, "gear_ratio of transmission `ankle` cannot be used: 0"),
    ("[10.0, 20.0]", "[10.0, -20.0]", 11, "finite numbers above 0 (`matrix` has signs)"),
    ("[10.0, 20.0]", "\"ten\"", 11, "a number, or a list of numbers with one per motor"),
    ("rotor_inertia = 1e-3\neffort", "rotor_inertia = -1e-3\neffort", 12, "cannot be used: -0.001"),
    ("effort = 2", "effort = nan", 13, "effort of transmission `ankle` cannot be used: NaN"),
    ("effort = 2", "effrt = 2", 13, "did you mean `effort`?"),
    ("velocity = [30.0, 60.0]", "velocity = -1.0", 14, "velocity of transmission `ankle` cannot be used: -1"),
    ("coulomb = 0.1", "coulomb = -0.1", 15, "friction.coulomb of transmission `ankle` cannot be used: -0.1"),
    ("coulomb = 0.1", "coulomb = 0.1, static = 0.05", 15, "at least friction.coulomb, 0.1"),
    ("coulomb = 0.1", "coulomb = 0.1, slip_velocity = 0.0", 15, "friction.slip_velocity"),
    ("kp = 10.0", "kp = 10.0\narmature = 0.1", 4, "no `armature` here, or no `rotor_inertia` there"),
    ("kp = 10.0", "kp = 10.0\neffort = 5.0", 4, "effort of joint `pitch` is given by transmission `ankle` too"),
    ("kp = 10.0", "kp = 10.0\nvelocity = 5.0", 4, "velocity of joint `pitch` is given"),
    ("kp = 10.0", "kp = 10.0\nfriction = { viscous = 1.0 }", 2, "friction of joint `pitch` is given"),
];

#[test]
fn each_error_is_reported_with_its_line() {
    for &(from, to, line, needle) in CASES {
        assert!(GOOD.contains(from), "`{from}` is not in the file: the case tests nothing");
        let case = format!("{from} -> {to}");
        assert_fault(&case, load_toml(&GOOD.replacen(from, to, 1), &urdf()), "robot.toml", line, needle);
    }
}

#[test]
fn a_transmission_replaces_the_settings_of_its_joints() {
    let robot = load_toml(GOOD, &urdf()).unwrap();
    let model = &robot.model;
    let [ankle, wag] = &model.transmissions[..] else { panic!("two transmissions") };
    assert_eq!((ankle.is_coupled(), wag.is_coupled()), (true, false));
    assert_eq!(ankle.gear, [10.0, 10.0, 20.0, -20.0]);
    // T^T J T of 1e-3 (100 + 400), and 1e-3 (100 - 400) across; rounding of sums.
    for (a, b) in ankle.reflected.iter().zip([0.5, -0.3, -0.3, 0.5]) {
        assert!((a - b).abs() < 1e-15, "{:?}", ankle.reflected);
    }
    assert_eq!(ankle.effort_limit.as_deref(), Some(&[2.0, 2.0][..]));
    let joint = |name: &str| &model.joints[model.joint(name).unwrap().0];
    for name in ["pitch", "roll"] {
        let joint = joint(name);
        assert_eq!((joint.armature, joint.friction, joint.damping), (0.0, 0.0, 0.0));
        // Bounds: 10 * 2 + 20 * 2 N m, and (30 / 10 + 60 / 20) / 2 rad/s.
        assert_eq!(joint.effort_limit, 60.0);
        assert!((joint.velocity_limit - 3.0).abs() < 1e-15, "{}", joint.velocity_limit);
    }
    // Slip and Stribeck speeds are those of a joint behind the gear.
    let laws = ankle.friction.as_ref().unwrap();
    assert_eq!((laws[0].slip_velocity, laws[1].stribeck_velocity), (10.0 * 0.05, 20.0 * 0.2));
    // What a transmission does not give remains.
    let tail = joint("tail");
    assert_eq!((tail.armature, tail.effort_limit, tail.friction, tail.damping), (25.0 * 1e-3, 8.0, 0.2, 0.1));
    assert_eq!(joint("finger").armature, 0.5);
}

#[test]
fn a_scenario_changes_joints_with_one_motor_only() {
    let mut model = load_toml(GOOD, &urdf()).unwrap().model;
    let settings = |armature| DriveSettings { armature: Some(armature), ..DriveSettings::default() };
    adjustments::set_drive(&mut model, "tail", &settings(0.3)).unwrap();
    assert_eq!(model.joints[model.joint("tail").unwrap().0].armature, 0.3);
    let error = adjustments::set_drive(&mut model, "roll", &settings(0.3)).unwrap_err().to_string();
    assert!(error.contains("armature of joint `roll`: 0.3") && error.contains("transmission `ankle`"), "{error}");
    let effort = DriveSettings { effort: Some(1.0), ..DriveSettings::default() };
    assert!(adjustments::set_drive(&mut model, "roll", &effort).is_err());
    let gains = DriveSettings { kp: Some(3.0), kd: Some(1.0), ..DriveSettings::default() };
    adjustments::set_drive(&mut model, "roll", &gains).unwrap();
    assert!(model.coupled_transmission_of(JointId(model.joint("tail").unwrap().0)).is_none());
}

#[test]
fn inspect_shows_each_motor() {
    let shown = inspect(&load_toml(GOOD, &urdf()).unwrap());
    let lines: Vec<&str> = shown.lines().skip_while(|line| !line.starts_with("transmissions (2)")).take(6).collect();
    let trimmed: Vec<String> = lines[1..].iter().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(
        trimmed,
        [
            "ankle pitch, roll",
            "[10 10]; 0.001; 2, 30; 0.1 + 0.01 v",
            "[20 -20]; 0.001; 2, 60; 0.1 + 0.01 v",
            "wag tail",
            "[5]; 0.001; unlimited, unlimited; 0 + 0 v",
        ]
    );
    // Robots without transmissions have no such section.
    assert!(!inspect(&load_toml("urdf = \"robot.urdf\"\n", &urdf()).unwrap()).contains("transmissions"));
}
