//! Forces given in the frame of an end effector equal forces given in the frame of its link.

use crate::support::runs::{Recording, TIGHT, root, watch};
use std::fs;
use stiction::{assemble, robot, scenario};
use tempfile::TempDir;

/// A robot file of HOAP-2 whose left hand has its own frame, in the palm and rotated by a right
/// angle about z.
fn robot_file() -> (TempDir, String) {
    let folder = TempDir::new().expect("a folder for the robot");
    let text = fs::read_to_string(root().join("robots/hoap2/hoap2.toml")).expect("it is there");
    let urdf = format!("urdf = {:?}", root().join("robots/hoap2/hoap2.urdf"));
    let tool =
        "[[end_effector]]\nname = \"tool\"\nlink = \"l_hand\"\nposition = [0.02, 0, 0]\nrpy = [0, 0, \"90 deg\"]\n";
    let path = folder.path().join("hoap2.toml");
    fs::write(&path, format!("{}\n{tool}", text.replace("urdf = \"hoap2.urdf\"", &urdf))).expect("it is writable");
    (folder, format!("{path:?}"))
}

/// HOAP-2 floats and swings its arms, under one force.
fn floating(model: &str, force: &str) -> Recording {
    watch(&format!(
        "duration = 0.6\ngravity = [0, 0, 0]\n{TIGHT}[robot]\nmodel = {model}\nsoles = []\nbase = {{ position = [0, 0, 1] }}
        velocity = {{ left_shoulder_pitch = -1.0, left_elbow = 0.5 }}\n[[force]]\n{force}\n"
    ))
    .1
}

/// Force types as `(type and other keys, key of the point)`; run with and without that point.
const KINDS: [(&str, &str); 5] = [
    ("type = \"carried-object\"\nmass = 0.3\nstart = 0.1\nduration = 0.3\nvelocity = [0.1, 0, 0]", "position"),
    ("type = \"constant\"\nforce = [1, 2, 3]\nmoment = [0.1, 0, 0]", "point"),
    ("type = \"push\"\nforce = [1, -2, 0]", "point"),
    ("type = \"ramp\"\nforce = [0, 2, 0]", "point"),
    ("type = \"spring\"\nstiffness = 100.0\nanchor = { velocity = [0, 0.1, 0] }", "point"),
];

#[test]
fn both_notations_give_identical_bits() {
    for (kind, point_key) in KINDS {
        // The palm in the robot file: 0.02 m along x of the link.
        let by_hand = floating("\"robots/hoap2/hoap2.toml\"", &format!("{kind}\nend_effector = \"left_hand\""));
        let by_link =
            floating("\"robots/hoap2/hoap2.toml\"", &format!("{kind}\nlink = \"l_hand\"\n{point_key} = [0.02, 0, 0]"));
        let off = floating("\"robots/hoap2/hoap2.toml\"", &format!("{kind}\nlink = \"l_hand\""));
        let end = |recorded: &Recording| {
            recorded.snapshots.last().map(|s| (s.base_pose, s.q.clone(), s.qd.clone())).expect("the end")
        };
        assert_eq!(end(&by_hand), end(&by_link), "{kind}");
        assert_ne!(end(&by_hand), end(&off), "{kind}: the point matters");
    }
}

#[test]
fn points_rotations_and_axes_follow_a_rotated_frame() {
    let (_folder, model) = robot_file();
    let cases = [
        // The frame's x is the link's y.
        (
            "type = \"carried-object\"\nmass = 0.3\ninertia = [1e-4, 2e-4, 3e-4, 0, 0, 0]",
            "position = [0.03, 0.01, 0]\nrpy = [0.4, 0, 0]",
            "position = [0.01, 0.03, 0]\nrpy = [0.4, 0, \"90 deg\"]",
        ),
        (
            "type = \"constant\"\nframe = \"link\"",
            "point = [0.03, 0.01, 0]\nforce = [1, 2, 0]",
            "point = [0.01, 0.03, 0]\nforce = [-2, 1, 0]",
        ),
    ];
    for (kind, in_frame, in_link) in cases {
        let a = floating(&model, &format!("{kind}\nend_effector = \"tool\"\n{in_frame}"));
        let b = floating(&model, &format!("{kind}\nlink = \"l_hand\"\n{in_link}"));
        let (a, b) = (a.snapshots.last().expect("the end"), b.snapshots.last().expect("the end"));
        // Rounding of the frame, amplified over 0.6 s of motion integrated at 1e-9.
        let apart = (a.base_pose.translation.vector - b.base_pose.translation.vector).norm();
        assert!(apart < 1e-8 && a.q.iter().zip(&b.q).all(|(x, y)| (x - y).abs() < 1e-8), "{kind} {apart:e}");
        assert!(a.base_pose.translation.vector.norm() > 1.0 + 1e-6 || a.q[0] != 0.0, "it moved");
    }
}

#[test]
fn an_event_names_the_end_effector_of_an_object() {
    let recorded = floating("\"robots/hoap2/hoap2.toml\"", &format!("{}\nend_effector = \"left_hand\"", KINDS[0].0));
    assert!(recorded.events.iter().any(|e| e.message.contains("left_hand") || e.subject.contains("left_hand")));
}

#[test]
fn no_end_effector_two_or_an_unknown_one_is_an_error_with_its_position() {
    let wrong = |robot: &str, force: &str| {
        let text = format!("robot = {{ model = \"{robot}\" }}\n[[force]]\n{force}\n");
        let found = scenario::parse(&root().join("test.toml"), &text).and_then(|file| {
            let runs = file.expand(&[])?;
            let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
            assemble::setup(&runs[0], &robot)
        });
        found.err().unwrap_or_else(|| panic!("accepted:\n{text}")).to_string()
    };
    let hoap2 = "robots/hoap2/hoap2.toml";
    for (kind, _) in KINDS {
        let found = wrong(hoap2, kind);
        assert!(
            found.contains("test.toml:2:1") && found.contains("`force.0` needs `link` or `end_effector`"),
            "{found}"
        );
        let found = wrong(hoap2, &format!("end_effector = \"left_hand\"\nlink = \"l_hand\"\n{kind}"));
        assert!(found.contains("test.toml:3:16") && found.contains("has no meaning with `link`"), "{found}");
        let found = wrong(hoap2, &format!("end_effector = \"left_hnd\"\n{kind}"));
        assert!(found.contains("test.toml:3:16") && found.contains("has no end effector `left_hnd`"), "{found}");
        assert!(found.contains("did you mean `left_hand`?"), "{found}");
        let found = wrong("robots/block/block.toml", &format!("end_effector = \"hand\"\n{kind}"));
        assert!(found.contains("has no end effector `hand`") && found.contains("its robot file has no"), "{found}");
    }
}
